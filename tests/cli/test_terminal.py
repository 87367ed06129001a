"""slewline terminal: lines from a file, and from a person at a real pty, with and without menus."""

from __future__ import annotations

import io
import re
import socket
import sys
import threading
import time
from importlib.util import find_spec
from pathlib import Path

import pytest

import slewline.testing  # noqa: F401  # pySerial knows slewline://
from slewline.modules.dialogue import RecordedDialogue
from tests.links.conftest import PATIENCE, serve  # noqa: F401
from tests.terminals import Terminal

GSC = "slewline://gs-c200s?chs=0"
SEATED = f"""
import fcntl, struct, termios
from slewline.modules import finding, spoken
finding.LOOK_S, spoken.ANSWER_S = 5, {PATIENCE}  # a server may be kept from running for a while
fcntl.ioctl(0, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 100, 0, 0))
from slewline.cli.main import main
main()
"""
ESCAPES = re.compile(rb"\x1b\[[0-9;?]*[A-Za-z]|\x1b[()=>].?|\x1b\][^\x07]*\x07")


@pytest.fixture
def talk(call, monkeypatch):
    """Call the command with lines on its standard input."""

    def talk(*lines, url=GSC, part="gs-c200s", options=()):
        monkeypatch.setattr(sys, "stdin", io.StringIO("".join(f"{line}\n" for line in lines)))
        return call("terminal", url, "--part", part, *options)

    return talk


LEAVES = "Ctrl-D leaves, :help lists the commands"


def test_lines_their_answers_and_oddities(talk):
    found = talk("V1", "S0", "Q")
    assert found.status == 0
    assert re.sub(r"[0-9]+ ms", "1 ms", found.out).splitlines() == [
        "gs-c200s> V1",
        "V+0  (1 ms)",
        "gs-c200s> S0",
        "E2  (argument missing, wrong or out of range, 1 ms)",
        "  ! E2: S0: speed 0, allowed 1..1000; the nearest is 1",
        "gs-c200s> Q",
        "END  (end of the listing, 1 ms)",
    ]
    assert (
        found.err
        == f"slewline: gs-c200s at {GSC}, 9600 7O2; raw characters are recorded in terminal.gs-c200s.raw; {LEAVES}\n"
    )


def test_a_part_that_answers_queries_only(talk):
    found = talk("R 300", "? R", url="slewline://cy545", part="cy545")
    assert re.sub(r"[0-9]+ ms", "1 ms", found.out).splitlines() == [
        "cy545> R 300",
        "  ! range: RATE 300: allowed 0..255; only its low bits are used: 44",
        "cy545> ? R",
        "R=00044  (1 ms)",
    ]


def test_verbs(talk):
    found = talk(":values", ":quit", "V1")
    assert found.out.splitlines() == [
        "gs-c200s> :values",
        "position: +0",
        "inputs and outputs: 70",
        "gs-c200s> :quit",
    ]


def test_without_the_model_nothing_is_found(talk):
    assert "!" not in talk("S0", options=["--no-model"]).out


def test_the_dialogue_is_recorded(talk, folder):
    assert talk("V1", options=["--dialogue", "x.dialogue", "--markings", "9431"]).status == 0
    found = RecordedDialogue.read("x.dialogue")
    assert [each.text for each in found.entries if each.speaker != "tool"] == ["V1\r", "V+0\r"]
    assert (found.header.part, found.header.checksum, found.header.markings) == ("gs-c200s", False, "9431")
    again = talk("V1", options=["--dialogue", "x.dialogue"])
    assert (again.status, "this file exists; name a new file" in again.err) == (2, True)


def test_a_module_with_checksums_and_an_address_is_found(talk):
    url = "slewline://gs-c200s?sel2=0&sel1=0&sel0=1"
    found = talk("V1", url=url, options=["--address", "3"])
    assert "V+0" in found.out
    assert "with checksums" in found.err


WRONG = {
    "no port": (["/dev/ttyUSB77", "--part", "gs-c200s"], "/dev/ttyUSB77: No such file or directory"),
    "no part": ([GSC], "Missing --chip; for example:"),
    "a part on a bus": ([GSC, "--part", "cy500"], "cy500 is on a bus and cannot be read back"),
    "a rate": ([GSC, "--part", "gs-c200s", "--baud", "9601"], "--baud 9601: not a rate of the GS-C200S"),
}


@pytest.mark.parametrize("arguments, says", WRONG.values(), ids=WRONG)
def test_refused_arguments(call, arguments, says):
    found = call("terminal", *arguments)
    assert found.status == 2
    assert says in found.err


# ---------------------------------------------------------------------------------------------------- a person at a pty
class Person(Terminal):
    """Whoever sits at a terminal on which the command runs."""

    def __init__(self, where, *options):
        call = [sys.executable, "-c", SEATED, "terminal", where, "--part", "gs-c200s", *options]
        super().__init__(call, environment={"TERM": "xterm"})

    def sees(self, text):
        """Wait until a text has been shown."""
        end = time.monotonic() + PATIENCE
        while text.encode() not in ESCAPES.sub(b"", self.seen):
            assert time.monotonic() < end, self.seen
            self.looks()

    def gets(self, text):
        """Wait until a text has been shown, and after it a prompt."""
        self.sees(text)
        end = time.monotonic() + PATIENCE
        while b"gs-c200s>" not in ESCAPES.sub(b"", self.seen).rpartition(text.encode())[2]:
            assert time.monotonic() < end, self.seen
            self.looks()

    def looks(self, seconds=0.1):
        """Take what is shown; say where the cursor is, as a terminal does that is asked."""
        super().types("\x1b[1;1R" * super().looks(seconds).count(b"\x1b[6n"))

    def types(self, text):
        self.seen = b""
        super().types(text)

    def gives_up(self):
        """Press Ctrl-C until there is a new prompt: readline misses a signal that comes before it waits for a key.

        A person presses it once a second: one that is interrupted again and again before it has shown its prompt
        never comes to show it.
        """
        self.seen = b""
        end, pressed = time.monotonic() + PATIENCE, 0.0
        while b"gs-c200s>" not in ESCAPES.sub(b"", self.seen):
            assert time.monotonic() < end, self.seen
            if time.monotonic() > pressed + 1:
                super().types("\x03")
                pressed = time.monotonic()
            self.looks()

    def leaves(self):
        """Press Ctrl-D until a prompt is there to take it; return the exit status."""
        end = time.monotonic() + PATIENCE
        while self.status is None and time.monotonic() < end:
            super().types("\x04")
            self.looks()
        return self.status

    def is_left(self):
        """Wait until the command has ended by itself; return the exit status."""
        end = time.monotonic() + PATIENCE
        while self.status is None and time.monotonic() < end:
            self.looks()
        return self.status


@pytest.fixture
def person(serve):  # noqa: F811
    """A person who speaks with a served module."""
    made = []

    def sit_down(*options, where=None):
        served = serve("gs-c200s", "--tcp", "127.0.0.1:0", "--strap", "chs=0") if where is None else None
        made.append(Person(where or served.where, *options))
        made[-1].server = served
        made[-1].sees("gs-c200s>")
        return made[-1]

    yield sit_down
    for one in made:
        one.close()


@pytest.mark.system
@pytest.mark.posix
def test_a_person_with_plain_lines(person):
    person = person("--plain")
    person.types("V1\r")
    person.gets("V+0  (")
    person.types("\x1b[A\r")  # the line before
    person.gets("V+0  (")
    person.types("Px")
    person.sees("Px")
    person.gives_up()
    person.types("S0\r")
    person.gets("! E2: S0: speed 0")
    person.server.kill()
    person.types("F\r")
    person.sees("the port is gone")
    assert person.is_left() == 1


@pytest.mark.system
@pytest.mark.posix
def test_the_tab_key_completes_a_plain_line(person):
    pytest.importorskip("readline")
    person = person("--plain")
    person.types(":val\t\r")
    person.gets("inputs and outputs: 70")
    assert person.leaves() == 0


@pytest.mark.system
@pytest.mark.posix
@pytest.mark.skipif(find_spec("prompt_toolkit") is None, reason="needs prompt_toolkit")
def test_a_person_with_menus(person, tmp_path):
    person = person("--dialogue", str(tmp_path / "x"))
    person.sees("Ctrl-D leaves, :help lists the commands")
    person.types("S1")
    person.sees("S <speed>: start-stop speed")
    person.types("\x15P\t")
    person.sees("begin programming; erases the program")
    person.types("\x03")
    person.types("V1\r")
    person.gets("V+0  (")
    assert person.leaves() == 0
    said = RecordedDialogue.read(Path(tmp_path / "x")).entries
    assert [each.text for each in said if each.speaker == "host"] == ["V1\r"]


def answering(listener, writes):
    """A module that answers V2 and V1, and says something by itself when the person writes."""
    with listener.accept()[0] as line:
        coming = b""
        while data := line.recv(100):
            coming += data
            while b"\r" in coming:
                command, _, coming = coming.partition(b"\r")
                line.sendall({b"V2": b"V70\r", b"V1": b"V+0\r"}.get(command, b"E4\r"))
                if command == b"V1":
                    writes.wait(PATIENCE)
                    line.sendall(b"HELLO\r")


@pytest.mark.system
@pytest.mark.posix
@pytest.mark.skipif(find_spec("prompt_toolkit") is None, reason="needs prompt_toolkit")
def test_unsolicited_text_is_shown_while_a_line_is_written(person):
    with socket.create_server(("127.0.0.1", 0)) as listener:
        writes = threading.Event()
        thread = threading.Thread(target=answering, args=(listener, writes), daemon=True)
        thread.start()
        person = person(*("--no-checksum", "--baud", "9600"), where=f"socket://127.0.0.1:{listener.getsockname()[1]}")
        person.types("V1\r")
        person.gets("V+0  (")
        person.types("S1")
        person.sees("S1")
        writes.set()
        person.sees("unsolicited: HELLO")
        person.close()
        thread.join(PATIENCE)
