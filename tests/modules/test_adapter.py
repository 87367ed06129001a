"""A part on a bus behind an adapter: what pull reads of it, over a socket that may be cut or noisy, without a step."""

from __future__ import annotations

import re
import socket
import threading
from contextlib import ExitStack, closing, suppress
from pathlib import Path
from random import Random

import pytest
import serial

from slewline.chips import sheet_of
from slewline.cli.main import invoke
from slewline.language.assemble import assemble
from slewline.links.ports.tcp import TcpPort
from slewline.modules.comparing.model import ModelLine
from slewline.modules.conversation import Conversation, ShadowModel
from slewline.modules.dialogue import DialogueFile, DialogueHeader, RecordedDialogue
from slewline.modules.module import Module
from slewline.modules.module_port import ModulePort
from slewline.modules.recording_proxy import DialogueRecorder, Proxy
from slewline.modules.speech import speech_of
from tests.ensembles import few, in_long_runs
from tests.links.conftest import PATIENCE, Asks, Client, until

from . import protocol_adapter
from .random_programs import program

PARTS = ("cy525", "cy512")
HELD = ("A 750", "N 513", "S 25", "R 127", "F 3", "Z 1", "-", "E", "P 300", "P 0", "T 0", "0", "Q")
SAVED = ["N 513", "S 25", "R 127", "F 3", "Z 1", "A 750", "-", "E", "P 300", "P 0", "T 0", "0", "Q"]
SENT = b"\xff\r?\r?0\r?3\r?2\r?1\r"  # what pull sends, each question once
PLACES = [
    (1, 85),
    (1, 405),  # of the program, the first time it is read: a 0 that becomes a 1
    (0, 11),
    *((0, at) for at in range(0, 50, 3)),
    *((1, at) for at in range(0, 640, 13)),
]  # of a fault


@pytest.fixture(params=["in virtual time", pytest.param("on a socket", marks=pytest.mark.system)])
def adapter(request, slewline_module):
    """Return a function that puts a part behind an adapter."""
    if request.param == "on a socket":
        yield lambda part: slewline_module(part, on="tcp", framing=True)
        return
    with ExitStack() as stack:
        yield lambda part: stack.enter_context(closing(protocol_adapter.running(part)))


@pytest.fixture
def cy525(adapter):
    return adapter("cy525")


@pytest.fixture
def cy512(adapter):
    return adapter("cy512")


def cable_to(x, *fault):
    """A cable that spoils a character, or is cut behind one."""
    return protocol_adapter.Cable(x.rig, *fault) if x.url.startswith("adapter:") else Relay(x.url, *fault)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty directory."""
    monkeypatch.chdir(tmp_path)


def tell(url, lines, ready=True):
    """Send lines as a host does; wait until the part has taken them."""
    with serial.serial_for_url(url, timeout=PATIENCE) as port:
        port.write("".join(f"{line}\r" for line in lines).encode())
        said = b"? busy\r\n"
        while ready and said != b"? ready\r\n":
            port.write(b"?\r")
            said = port.read_until(b"\n")


def pull(url, part="cy525", *more):
    return invoke(["pull", url, "-o", f"out.{part}", *more])


def saved(part="cy525"):
    return [line for line in Path(f"out.{part}").read_text().splitlines() if not line.startswith(";")]


def check_nothing_half_written(part="cy525"):
    """What is there is whole: the file, if it is there, and the dialogue up to its last line."""
    assert not list(Path().glob("*.tmp*"))
    if Path(f"out.{part}").exists():
        assert assemble(Path(f"out.{part}").read_text(), sheet_of(part), part).stored is not None
    for path in Path().glob("*.dialogue"):
        assert not RecordedDialogue.read(path).torn


class Relay:
    """A cable between the tool and a served port, which spoils a character, or is cut behind one.

    Args:
        way: 0: towards the part, 1: back.
        at: which character of it, from 0 on.
        spoil: returns what becomes of it; None: the cable is cut.
    """

    def __init__(self, url, way, at, spoil=None):
        self.far = socket.create_connection(url.rpartition("/")[2].rsplit(":", 1))
        self.server = socket.create_server(("127.0.0.1", 0))
        self.url = f"socket://127.0.0.1:{self.server.getsockname()[1]}"
        self.way, self.at, self.spoil = way, at, spoil
        self.thread = threading.Thread(target=self.accept, daemon=True)
        self.thread.start()

    def accept(self):
        with suppress(OSError), self.server.accept()[0] as near:
            back = threading.Thread(target=self.carry, args=(self.far, near, 1), daemon=True)
            back.start()
            self.carry(near, self.far, 0)
            self.cut(near)
            back.join()

    def carry(self, source, target, way):
        left = self.at if way == self.way else -1
        with suppress(OSError):
            while data := source.recv(4096):
                if 0 <= left < len(data):
                    if self.spoil is None:
                        target.sendall(data[:left])
                        break
                    data = data[:left] + self.spoil(data[left]) + data[left + 1 :]
                left -= len(data)
                target.sendall(data)
        self.cut(target)

    def cut(self, near):
        for each in (near, self.far):
            with suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.server.close()
        self.cut(self.far)
        self.far.close()
        self.thread.join(5)


# ------------------------------------------------------------------------------------------------------- what is read
@pytest.mark.fact("VERIFY-4", "VERIFY-7", "VERIFY-9", "VERIFY-10", "VERIFY-14")
def test_registers_and_program_are_saved_as_asm_takes_them(cy525, capfd):
    tell(cy525.url, HELD)
    assert pull(cy525.url, "cy525", "--markings", "CY525 8414") == 0
    assert saved() == SAVED
    assert assemble(Path("out.cy525").read_text(), sheet_of("cy525"), "out").stored == bytes(cy525.chip.program)
    header = RecordedDialogue.read("out.cy525.dialogue").header
    assert (header.part, header.markings) == ("cy525", "CY525 8414")
    cy525.assert_steps(0)
    assert not cy525.bench.findings


def test_values_without_a_command_are_comments(cy525, capfd):
    assert pull(cy525.url) == 0
    assert "; number 0" in Path("out.cy525").read_text()
    assert saved()[-2:] == ["E", "Q"]
    assert "all 48 bytes that the part reports are 00: no program" in capfd.readouterr().err


PROGRAMS = {
    "a label that has not run": (("J A", "0", "A$B", "0"), ("J A", "0", "B", "0"), "its labels are unknown (A)"),
    "longer than what is given": (
        ("P 300",) * 17 + ("0",),
        ("P 300",) * 16,
        "at 48; the part reports only the first 48",
    ),
    "an instruction across the end": (("R 5", *("P 300",) * 17), ("R 5", *("P 300",) * 15), "continues at 47"),
    "ends where it jumps back": (("B", "J 0", "C"), ("B", "J 0"), ""),
    "goes on where it jumps to": (("T 3", "0", "B", "0"), ("T 3", "0", "B", "0"), ""),
    "behind a loop": (("B", "L 3,0", "X"), ("B", "L 3,0", "X"), ""),
}


@pytest.mark.fact("VERIFY-8")
@pytest.mark.parametrize("case", few(PROGRAMS, 3))
def test_a_program_is_saved_as_far_as_a_run_of_it_goes(cy525, capfd, case):
    entered, expected, says = PROGRAMS[case]
    tell(cy525.url, ("N 1", "E", *entered, "Q"))
    assert pull(cy525.url) == 0
    lines = saved()
    assert lines[lines.index("E") + 1 : -1] == list(expected)
    told = capfd.readouterr().err
    assert says in told
    assert says in Path("out.cy525").read_text()
    assert ("the bytes of the program are in" in told) == ("label" in case)  # asm takes no label that is nowhere
    cy525.assert_steps(0)


def test_a_label_that_has_run_is_an_address(cy525, capfd):
    tell(cy525.url, ("E", "J A", "0", "A$B", "0", "QX"))
    assert pull(cy525.url) == 0
    assert saved()[-6:] == ["E", "J 3", "0", "B", "0", "Q"]


@pytest.mark.parametrize("part", few(PARTS, 1))
@pytest.mark.parametrize("seed", few(range(40), 1))
def test_the_saved_text_of_any_program_is_the_start_of_its_buffer(adapter, capfd, part, seed):
    x = adapter(part)
    sheet = sheet_of(part)
    tell(x.url, ("N 1", sheet.enter.form, *program(sheet, seed), "0", "Q"))
    assert pull(x.url, part) == 0
    stored = assemble(Path(f"out.{part}").read_text(), sheet, part).stored
    assert bytes(x.chip.program).ljust(sheet.buffer_bytes, b"\0").startswith(stored)
    x.assert_steps(0)


# --------------------------------------------------------------------------------------------------- what goes wrong
@pytest.mark.parametrize("part", PARTS)
def test_no_single_wrong_bit_turns_the_output_of_pull_into_a_step(part):
    speech = speech_of(sheet_of(part))
    for at in range(len(SENT)):
        for bit in range(8):
            wrong = SENT[:at] + bytes([SENT[at] ^ 1 << bit]) + SENT[at + 1 :]
            for line in re.split(rb"[\r\n]+", wrong):
                row = speech.row(line.decode()) if line.isascii() and line else None
                assert row is None or not row.may_step, line


def flipped(byte):
    return bytes([byte ^ 1 << byte % 8])


def lost(_byte):
    return b""


@pytest.mark.parametrize("place", [*PLACES[:3], *map(in_long_runs, PLACES[3:])], ids=str)
@pytest.mark.parametrize("spoil", few((flipped, lost), 1))
def test_a_damaged_character_spoils_no_file(cy525, capfd, place, spoil):
    tell(cy525.url, HELD)
    with cable_to(cy525, *place, spoil) as relay:
        status = pull(relay.url)
    assert status == 0
    assert saved() == SAVED
    check_nothing_half_written()
    cy525.assert_steps(0)


@pytest.mark.parametrize("place", [*PLACES[1:3], *map(in_long_runs, PLACES[3:])], ids=str)
def test_a_cut_cable_leaves_a_whole_file_or_none(cy525, capfd, place):
    tell(cy525.url, HELD)
    with cable_to(cy525, *place) as relay:
        status = pull(relay.url)
    check_nothing_half_written()
    assert Path("out.cy525").exists() == (status == 0)
    assert status == 0 or "the port is gone" in capfd.readouterr().err
    assert pull(cy525.url, "cy525", "--replace") == 0
    assert saved() == SAVED
    cy525.assert_steps(0)


@pytest.mark.parametrize("seed", few(range(30), 0))  # a cut cable is the same to the tool
def test_a_server_that_is_killed_leaves_a_whole_file_or_none(serve, capfd, seed):
    server = serve("cy525", "--framing", "--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0", ports=2)
    with ExitStack() as stack:
        client = Client(server.ports["control"])
        stack.callback(client.close)
        tell(server.where, HELD)
        killer = threading.Timer(Random(seed).uniform(0, 0.05), server.process.kill)
        status = Asks(client)("status")["chips"]["cy525"]["steps"]
        killer.start()
        assert pull(server.where) in (0, 1, 2)
        killer.join()
    assert status == 0
    check_nothing_half_written()


def test_a_partial_line_of_an_earlier_host_is_not_performed(cy525, capfd):
    tell(cy525.url, HELD)
    with serial.serial_for_url(cy525.url) as port:
        port.write(b"P 3000")
    until(lambda: cy525.rig.do(lambda: cy525.rig.line.line))
    assert pull(cy525.url) == 0
    assert saved() == SAVED
    cy525.assert_steps(0)


def test_a_part_at_work_is_not_disturbed(cy525, capfd):
    tell(cy525.url, ("A 0", "R 10", "F 10", "S 255", "Z 1", "P 5000"), ready=False)
    cy525.until(lambda: cy525.position > 5)
    assert pull(cy525.url) == 1
    assert "? was answered with ? busy" in capfd.readouterr().err
    assert not Path("out.cy525").exists()
    cy525.until_idle()
    cy525.assert_steps(5000)
    assert not cy525.bench.findings


def test_another_part_on_an_adapter_is_noticed(cy512, capfd):
    assert pull(cy512.url) == 1
    assert "check the port and --chip" in capfd.readouterr().err
    assert not Path("out.cy525").exists()


WITHOUT = (
    ("gs-c200s", "url", "received b'E"),
    *(
        pytest.param(*row, marks=pytest.mark.system)
        for row in (
            ("gs-c200s", "tcp", "received b'E"),
            ("cy525", "tcp", "no characters received"),
        )
    ),
)


@pytest.mark.parametrize(("part", "on", "found"), WITHOUT)
def test_a_port_without_an_adapter_is_noticed(slewline_module, capfd, part, on, found):
    x = slewline_module(part, on=on)
    assert pull(x.url) == 1
    assert "no adapter answers ? at 9600 baud: " + found in capfd.readouterr().err
    assert {path.suffix for path in Path().iterdir()} <= {".raw"}
    x.assert_steps(0)


@pytest.mark.system
def test_a_port_that_answers_everything_is_noticed(capfd):
    def answer():
        with server.accept()[0] as modem:
            while modem.recv(4096):
                modem.sendall(b"OK\r\n")

    with socket.create_server(("127.0.0.1", 0)) as server:
        threading.Thread(target=answer, daemon=True).start()
        assert pull(f"socket://127.0.0.1:{server.getsockname()[1]}") == 1
    assert "received b'OK'" in capfd.readouterr().err


# ------------------------------------------------------------------------------------- what goes over the same adapter
def test_a_dialogue_is_compared_with_the_model_and_played_again(cy525, capfd):
    assert pull(cy525.url) == 0
    assert invoke(["compare", "out.cy525.dialogue"]) == 0
    assert "0 differences; times are those of the adapter, and are not compared" in capfd.readouterr().out
    assert invoke(["compare", "out.cy525.dialogue", "--port", cy525.url]) == 0
    file = Path("out.cy525.dialogue")
    file.write_text(file.read_text().replace("?2 00 00 00 00 00 00", "?2 07 00 00 00 00 00", 1))
    capfd.readouterr()
    assert invoke(["compare", "out.cy525.dialogue"]) == 1
    found = capfd.readouterr().out
    assert "1 difference" in found
    assert "?2: module ?2 07 00 00 00 00 00, model ?2 00 00 00 00 00 00" in found


@pytest.mark.system
@pytest.mark.slewline(on="tcp", framing=True)
def test_proxy_traffic_is_recorded_and_not_played_if_it_may_step(slewline_module, capfd):
    cy525 = slewline_module("cy525")
    header = DialogueHeader("cy525", baud=9600, checksum=False)
    recorder = DialogueRecorder(DialogueFile("x.dialogue", header))
    setting = speech_of(sheet_of("cy525")).setting
    proxy = Proxy(cy525.url, setting, recorder, lambda loop, line: TcpPort(loop, line, "127.0.0.1:0"))
    with closing(proxy):
        thread = threading.Thread(target=proxy.run)
        thread.start()
        with serial.serial_for_url(proxy.port.where, timeout=PATIENCE) as port:
            port.write("\r".join((*HELD, "?0", "")).encode())
            assert port.read_until(b"\n") == b"?0 30 30 37 35 30\r\n"
        proxy.stop()
        thread.join()
    assert invoke(["compare", "x.dialogue"]) == 0
    capfd.readouterr()
    assert invoke(["compare", "x.dialogue", "--port", cy525.url, "--replace"]) == 2
    assert "P 300, P 0, T 0 may step the motor; no command was sent" in capfd.readouterr().err
    cy525.assert_steps(0)


def test_a_person_converses_with_it(cy525):
    with closing(ModulePort(cy525.url, speech_of(sheet_of("cy525")).setting)) as port:
        module = Module(port, speech_of(sheet_of("cy525")), may_move=True)
        talk = Conversation(module, ShadowModel(ModelLine(DialogueHeader("cy525"), module.speech)))
        assert talk.say("R 300").findings == ["range: RATE 300: allowed 0..127"]
        assert talk.say("R 7").lines == ()
        assert talk.say("?3").lines == ("?3 00 00 FF 07 03 01",)
        assert "rate: 7" in talk.say(":values").text.splitlines()
        assert talk.say("?9").lines == ("! ?9: allowed ?, ?0, ?1, ?2, ?3",)
        assert talk.hint("?3").startswith("queries")


@pytest.mark.parametrize("line", ("P 5", "G", "J 0", "L 3,0", "T 0", "X", "QX", "Q"))
def test_lines_that_may_step_are_known(line):
    assert speech_of(sheet_of("cy525")).moves(line) == (line != "Q")
