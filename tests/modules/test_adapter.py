"""A part on a bus behind an adapter: what pull reads of it, over a socket that may be cut or noisy, without a step."""

from __future__ import annotations

import re
import socket
import threading
import time
from contextlib import ExitStack, suppress
from pathlib import Path
from random import Random

import pytest
import serial

from slewline.chips import sheet_of
from slewline.cli.main import invoke
from slewline.language.assemble import assemble
from slewline.modules.dialogue import RecordedDialogue
from slewline.modules.speech import speech_of
from tests.ensembles import few
from tests.links.conftest import Asks, Client, Process

from .random_programs import program

PARTS = ("cy525", "cy512")
HELD = ("A 750", "N 513", "S 25", "R 127", "F 3", "Z 1", "-", "E", "P 300", "P 0", "T 0", "0", "Q")
SAVED = ["A 750", "N 513", "S 25", "R 127", "F 3", "Z 1", "-", "E", "P 300", "P 0", "T 0", "0", "Q"]
SENT = b"\xff\r?\r?0\r?3\r?2\r?1\r"  # what pull sends, each question once
framing = pytest.mark.slewline(on="tcp", framing=True)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty directory."""
    monkeypatch.chdir(tmp_path)


def tell(url, lines, ready=True):
    """Send lines as a host does; wait until the part has taken them."""
    with serial.serial_for_url(url, timeout=10) as port:
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
        self.url = "socket://127.0.0.1:{}".format(self.server.getsockname()[1])
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
@framing
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


@framing
def test_what_no_command_sets_is_a_comment(cy525, capfd):
    assert pull(cy525.url) == 0
    assert "; number 0" in Path("out.cy525").read_text()
    assert saved()[-2:] == ["E", "Q"]
    assert "all 48 bytes that the part gives are 00: no program" in capfd.readouterr().err


PROGRAMS = {
    "ends where it jumps back": (("B", "J 0", "C"), ("B", "J 0"), ""),
    "goes on where it jumps to": (("T 3", "0", "B", "0"), ("T 3", "0", "B", "0"), ""),
    "behind a loop": (("B", "L 3,0", "X"), ("B", "L 3,0", "X"), ""),
    "a label that has not run": (("J A", "0", "A$B", "0"), ("J A", "0", "B", "0"), "where its labels are (A)"),
    "longer than what is given": (("P 300",) * 17 + ("0",), ("P 300",) * 16, "goes on at 48; the part gives the first"),
    "an instruction across the end": (("R 5",) + ("P 300",) * 17, ("R 5",) + ("P 300",) * 15, "the program goes on at 47"),
}


@framing
@pytest.mark.fact("VERIFY-8")
@pytest.mark.parametrize("case", PROGRAMS)
def test_a_program_is_saved_as_far_as_a_run_of_it_goes(cy525, capfd, case):
    entered, expected, says = PROGRAMS[case]
    tell(cy525.url, ("N 1", "E", *entered, "Q"))
    assert pull(cy525.url) == 0
    lines = saved()
    assert lines[lines.index("E") + 1 : -1] == list(expected)
    told = capfd.readouterr().err
    assert says in told
    assert says in Path("out.cy525").read_text()
    assert ("its bytes are in" in told) == ("label" in case)  # asm takes no label that is nowhere
    cy525.assert_steps(0)


@framing
def test_a_label_that_has_run_is_an_address(cy525, capfd):
    tell(cy525.url, ("E", "J A", "0", "A$B", "0", "QX"))
    assert pull(cy525.url) == 0
    assert saved()[-6:] == ["E", "J 3", "0", "B", "0", "Q"]


@framing
@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("seed", few(range(40), 1))
def test_what_is_saved_of_any_program_is_its_beginning(slewline_module, capfd, part, seed):
    x = slewline_module(part)
    sheet = sheet_of(part)
    tell(x.url, ("N 1", sheet.enter.form, *program(sheet, seed), "0", "Q"))
    assert pull(x.url, part) == 0
    stored = assemble(Path(f"out.{part}").read_text(), sheet, part).stored
    assert bytes(x.chip.program).startswith(stored)
    assert stored
    x.assert_steps(0)


# --------------------------------------------------------------------------------------------------- what goes wrong
@pytest.mark.parametrize("part", PARTS)
def test_no_single_wrong_bit_makes_a_step_of_what_pull_sends(part):
    speech = speech_of(sheet_of(part))
    for at in range(len(SENT)):
        for bit in range(8):
            wrong = SENT[:at] + bytes([SENT[at] ^ 1 << bit]) + SENT[at + 1 :]
            for line in re.split(rb"[\r\n]+", wrong):
                row = speech.row(line.decode()) if line.isascii() and line else None
                assert row is None or not row.may_step, line


@framing
@pytest.mark.parametrize("at", few(range(0, 640, 7), 3))
@pytest.mark.parametrize("way", (0, 1))
@pytest.mark.parametrize("spoil", (lambda byte: bytes([byte ^ 1 << byte % 8]), lambda _byte: b""), ids=("bit", "lost"))
def test_a_damaged_character_spoils_no_file(cy525, capfd, way, at, spoil):
    tell(cy525.url, HELD)
    with Relay(cy525.url, way, at // (1 if way else 8), spoil) as relay:
        status = pull(relay.url)
    assert status == 0
    assert saved() == SAVED
    check_nothing_half_written()
    cy525.assert_steps(0)


@framing
@pytest.mark.parametrize("at", few(range(0, 640, 9), 3))
@pytest.mark.parametrize("way", (0, 1))
def test_a_cut_cable_leaves_a_whole_file_or_none(cy525, capfd, way, at):
    tell(cy525.url, HELD)
    with Relay(cy525.url, way, at // (1 if way else 8)) as relay:
        status = pull(relay.url)
    check_nothing_half_written()
    assert Path("out.cy525").exists() == (status == 0)
    assert status == 0 or "the port is gone" in capfd.readouterr().err
    assert pull(cy525.url, "cy525", "--replace") == 0
    assert saved() == SAVED
    cy525.assert_steps(0)


@pytest.mark.parametrize("seed", few(range(30), 1))
def test_a_server_that_is_killed_leaves_a_whole_file_or_none(capfd, seed):
    server = Process("cy525", "--framing", "--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0", ports=2)
    with ExitStack() as stack:
        stack.callback(server.kill)
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


@framing
def test_what_an_earlier_host_has_left_of_a_line_is_not_performed(cy525, capfd):
    tell(cy525.url, HELD)
    with serial.serial_for_url(cy525.url) as port:
        port.write(b"P 3000")
    while cy525.rig.do(lambda: not cy525.rig.line.line):
        time.sleep(0.005)
    assert pull(cy525.url) == 0
    assert saved() == SAVED
    cy525.assert_steps(0)


@framing
def test_a_part_at_work_is_not_disturbed(cy525, capfd):
    tell(cy525.url, ("A 0", "R 10", "F 10", "S 255", "Z 1", "P 5000"), ready=False)
    cy525.until(lambda: cy525.position > 5)
    assert pull(cy525.url) == 1
    assert "? was answered with ? busy" in capfd.readouterr().err
    assert not Path("out.cy525").exists()
    cy525.until_idle()
    cy525.assert_steps(5000)
    assert not cy525.bench.findings


@framing
def test_another_part_behind_an_adapter_is_noticed(cy512, capfd):
    assert pull(cy512.url) == 1
    assert "is this the right port, and --part the right part?" in capfd.readouterr().err
    assert not Path("out.cy525").exists()


@pytest.mark.slewline(on="tcp")
@pytest.mark.parametrize(("part", "found"), (("gs-c200s", "what came was b'E"), ("cy525", "nothing came")))
def test_a_port_without_an_adapter_is_noticed(slewline_module, capfd, part, found):
    x = slewline_module(part)
    assert pull(x.url) == 1
    assert "no adapter answers ? at 9600 baud: " + found in capfd.readouterr().err
    assert not list(Path().iterdir())
    x.assert_steps(0)
