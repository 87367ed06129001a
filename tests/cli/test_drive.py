"""slewline drive, on a board of software: options and their mistakes, words and signals of the user, the black box."""

from __future__ import annotations

import csv
import os
import signal
import threading
import tty
from contextlib import suppress
from pathlib import Path
from time import sleep

import pytest

from slewline.cli.live import drive
from slewline.drive.blackbox import read_line
from slewline.drive.board import wire
from slewline.drive.board.boards import BOARDS
from slewline.drive.board.wire import Answer, Decoder, Frame, FrameKind
from tests.drive.process import ModuleHost, Slewline

pytestmark = pytest.mark.posix

DRIVE = ("drive", "gs-c200s", "--strap", "chs=0", "--tcp", "127.0.0.1:0")
AHEAD = ("--horizon", "2 s")  # a busy machine is late by more than the usual 100 ms
SPEEDS = ("S50", "T200", "R100")
MOVE = (*SPEEDS, "+400")


# --------------------------------------------------------------------------------------------------------- mistakes
MISTAKES = [
    (DRIVE, ["Missing --board; for example:"]),
    (("drive", "gs-c200s", "--board", "twin"), ["no port given; give one of --tcp, --pty, --rfc2217, --serial"]),
    (("drive", "gs-c20s", "--board", "twin", "--tcp", "127.0.0.1:0"), ["did you mean gs-c200s?"]),
    (
        (*DRIVE, "--board", "/dev/ttyNONE"),
        ["/dev/ttyNONE: no such port; name the port of the board", "list_ports", "or twin, a simulated board"],
    ),
    ((*DRIVE, "--board", "/dev/null"), ["/dev/null: ", "name the serial port of the board", "list_ports"]),
    (
        (*DRIVE, "--board", "twin", "--control", "127.0.0.1:0", "--allow-remote"),
        ["--control and --allow-remote", "can move a real motor; leave one out"],
    ),
    (
        (*DRIVE, "--board", "twin", "--black-box", "b", "--no-black-box"),
        ["--black-box and --no-black-box: leave one out"],
    ),
    ((*DRIVE, "--board", "twin", "--horizon", "5 ms"), ["horizon '5 ms'; allowed 10 ms to 2 s"]),
    ((*DRIVE, "--board", "twin", "--horizon", "long"), ["'long'"]),
    ((*DRIVE, "--board", "twin", "--driver", "DM452"), ["driver 'DM452'; known: A4988, ", "did you mean DM542?"]),
    (
        (*DRIVE, "--board", "twin", "--input", "A1=hom"),
        ["input A1: 'hom' is not an input of gs_c200s; allowed estop, ", "did you mean home?"],
    ),
    ((*DRIVE, "--board", "twin", "--input", "A9=home"), ["input 'A9' of the board; allowed A0, A1, A2, A3, "]),
    (
        (*DRIVE, "--board", "twin", "--output", "D2=uo9"),
        ["output D2: 'uo9' is not an output of gs_c200s; allowed ", "did you mean uo1?"],
    ),
    ((*DRIVE, "--board", "twin", "--output", "D9=uo1"), ["output 'D9' of the board; allowed D2, "]),
    (
        (*DRIVE, "--board", "twin", "--start-stop", "fast"),
        ["rate 'fast': expected steps per second with their unit", "500 steps/s"],
    ),
    (
        (*DRIVE, "--board", "twin", "--start-stop", "500"),
        ["'--start-stop': rate '500': 500 has no unit; expected", "with their unit"],
    ),
    ((*DRIVE, "--board", "twin", "--horizon", "100"), ["'--horizon': time '100': expected a number and a unit"]),
    ((*DRIVE, "--board", "twin", "--enable-hold", "60"), ["'--enable-hold': time '60': expected a number and a unit"]),
    (
        (*DRIVE, "--board", "twin", "--input", "A1=home", "--input", "A1=eot"),
        ["'--input': A1 is given twice; leave one out"],
    ),
    ((*DRIVE, "--board", "twin", "--input", "A1=home", "--input", "a1=eot"), ["input a1: A1 is given twice"]),
    (
        (*DRIVE, "--board", "twin", "--output", "D2=uo1", "--output", "D2=uo2"),
        ["'--output': D2 is given twice; leave one out"],
    ),
    ((*DRIVE, "--board", "twin", "--output", "D2=uo1", "--output", "d2=uo2"), ["output d2 is given twice"]),
    ((*DRIVE, "--board", "twin", "--strap", "chs=0", "--strap", "chs=1"), ["'--strap': chs is given twice"]),
    (
        (*DRIVE, "--board", "twin", "--option", "eeprom_time=1 ms", "--option", "eeprom_time=2 ms"),
        ["'--option': eeprom_time is given twice"],
    ),
    (
        (*DRIVE, "--board", "twin", "--input", "A0=!estop"),
        ["input A0: an E-stop is active while its contact is open", "give A0=estop"],
    ),
    ((*DRIVE, "--board", "twin", "--input", "A1=uo1"), ["input A1: uo1 is an output of gs_c200s", "--output D2=uo1"]),
    (
        (*DRIVE, "--board", "twin", "--output", "D2=home"),
        ["output D2: home is an input of gs_c200s", "--input A1=home"],
    ),
    (
        ("drive", "gs-c200s", "--board", "/dev/ttyNONE", "--serial", "/dev/ttyNONE"),
        ["--board and --serial: both are /dev/ttyNONE"],
    ),
    ((*DRIVE, "--board", "twin", "--input", "A1"), ["give an input of the board and its signal, such as 'A1=home'"]),
    ((*DRIVE, "--board", "twin", "--output", "D2"), ["an output of the board and its signal, such as 'D12=fault'"]),
    ((*DRIVE, "--board", "twin", "--stop", "abort"), ["stop='abort'; allowed 'kill', 'power'"]),
    ((*DRIVE, "--board", "twin", "--of", "y"), ["--of: 'y' has no motor; allowed: gs_c200s.1"]),
    ((*DRIVE, "--board", "twin", "--of", "gs_c200s.2"), ["--of: 'gs_c200s.2' has no motor"]),
    ((*DRIVE, "--board", "twin", "--of", "gs_c200s.x"), ["--of: 'gs_c200s.x' has no motor"]),
]


def test_a_mistake_is_reported_with_its_value_and_the_allowed_ones(call, monkeypatch, folder, subtests):
    monkeypatch.setenv("XDG_STATE_HOME", str(folder / "state"))
    for words, says in MISTAKES:
        with subtests.test(words=words, description=says):
            ran = call(*words)
            assert ran.status == 2
            text = " ".join(ran.err.replace("│", " ").split())
            for each in says:
                assert each in text
            assert not list((folder / "state").glob("slewline/drive/*")), "a mistake has taken the place of a black box"


TWO = """
[[chip]]
name = "x"
part = "gs-c200s"
straps = { chs = 0, br0 = 0, br1 = 0, br2 = 0 }

[[chip]]
name = "y"
part = "gs-c200s"
straps = { chs = 0, br0 = 0, br1 = 0, br2 = 0 }

[[serve]]
chips = ["x"]
tcp = "127.0.0.1:0"

[[serve]]
chips = ["y"]
tcp = "127.0.0.1:0"
"""


def test_of_several_chips_one_is_chosen(call, write):
    write("two.toml", TWO)
    ran = call("drive", "--bench", "two.toml", "--board", "twin", "--no-black-box")
    assert ran.status == 2 and "--of: no motor given; allowed: x.1, y.1" in ran.err


@pytest.mark.system
def test_a_bench_file_with_two_chips_drives_the_motor_of_one(folder, write):
    write("two.toml", TWO)
    with Slewline("drive", "--bench", "two.toml", "--board", "twin", "--of", "y", *AHEAD, folder=folder) as driven:
        driven.ready()
        assert "slewline: y on an Arduino Uno" in driven.text
        first, second = (driven.hears(rf"^{name}: (socket://\S+)$")[1] for name in "xy")
        with ModuleHost(first) as one, ModuleHost(second) as two:
            one.program(*MOVE)
            one.until_ready()
            assert driven.count() == 0
            two.program(*SPEEDS, "-7")
            two.until_ready()
            assert (one.position(), two.position(), driven.count()) == (400, -7, -7)
        assert driven.end() == 0


@pytest.fixture
def port():
    """A pseudo-terminal; what is at its other end is up to the test."""
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    yield ours, os.ttyname(theirs)
    for each in (ours, theirs):
        with suppress(OSError):
            os.close(each)


@pytest.mark.system
def test_a_port_that_another_program_has(call, port):
    serial = pytest.importorskip("serial")
    _, name = port
    with serial.Serial(name, exclusive=True):
        ran = call(*DRIVE, "--board", name, "--no-black-box")
    assert ran.status == 2 and f"{name}: another program uses this port; close it" in ran.err


@pytest.mark.system
def test_a_port_that_has_no_board(call, port, folder):
    ours, name = port
    over = threading.Event()

    def babble():
        while not over.wait(0.05):
            os.write(ours, b"Grbl 1.1h ['$' for help]\r\n")

    thread = threading.Thread(target=babble)
    thread.start()
    try:
        ran = call(*DRIVE, "--board", name, "--black-box", "boxes")
    finally:
        over.set()
        thread.join()
    assert ran.status == 2
    assert "no board answers within 3 s; received 64 bytes, " in ran.err
    known = " or ".join(f"an {board.title}" for board in BOARDS.values())
    assert f"expected the firmware of slewline on {known}, at 500000 baud" in " ".join(ran.err.split())
    assert not list(Path("boxes").iterdir())


# ----------------------------------------------------------------------------------------------------- what it does
def frames(box, way):
    """The frames that went a way, as the black box has them."""
    decoder = Decoder()
    data = b"".join(data for _, _, there, data in read_line(box) if there == way)
    return [each for each in decoder.feed(data) if isinstance(each, Frame)]


def enabled(box):
    """The values of ENABLE that the board was given, in order."""
    return [
        bool(frame.payload[1] & 16)
        for frame in frames(box, ">")
        if frame.kind == FrameKind.OUTPUTS and frame.payload[0] & 16
    ]


@pytest.mark.system
@pytest.mark.parametrize("enable", [False, True])
def test_a_session_and_its_black_box(folder, enable, call):
    words = ["--black-box", "boxes", *AHEAD, *(["--enable", "--driver", "A4988"] if enable else [])]
    with Slewline(*DRIVE, "--board", "twin", *words, folder=folder) as driven:
        where = driven.ready()
        says = "the driver is enabled" if enable else "a dry run: no pulses, and the driver stays off, until --enable"
        assert f"slewline: gs_c200s on an Arduino Uno (ATmega328P, 16 MHz), horizon 2 s; {says}" in driven.text
        with ModuleHost(where) as host:
            host.program(*MOVE)
            host.until_ready()
            assert host.position() == 400 == driven.count()
            host.program("-150")
            host.until_ready()
        line = driven.status()
        current = "on" if enable else "off"
        assert (
            f"board ok at 250 | driver {current} | lead 0 ms | 64 of 64 slots free" in line
            and " ms round trip, worst " in line
        )
        assert driven.end() == 0
        assert "late-start" not in driven.text
    (box,) = Path("boxes").iterdir()
    assert f"slewline: black box: {Path('boxes') / box.name}" in driven.text
    assert enabled(box) == [True, False] * enable
    assert [said.position for each in frames(box, "<") if isinstance(said := wire.read(each), Answer)][-1] == 250
    ran = call("run", "--replay", str(box / "journal.jsonl"), "--steps", "steps.csv", "-q")
    assert ran.status == 0, ran.err
    rows = list(csv.reader(Path("steps.csv").read_text().splitlines()))[1:]
    assert [int(row[-1]) for row in rows] == [*range(1, 401), *range(399, 249, -1)]


@pytest.mark.system
def test_without_a_black_box_nothing_is_left(folder):
    with Slewline(*DRIVE, "--board", "twin", "--no-black-box", folder=folder) as driven:
        driven.ready()
        assert "horizon 100 ms" in driven.text and "black box" not in driven.text
        assert driven.end() == 0
    assert not list(folder.iterdir())


@pytest.mark.system
def test_typed_words_stop_the_motor_and_let_it_continue(folder):
    with Slewline(*DRIVE, *AHEAD, "--board", "twin", "--no-black-box", folder=folder, typed=True) as driven:
        where = driven.ready()
        driven.hears("slewline: type clear: continue after a halt; clear homing, clear homed: and energise it; stop:")
        driven.type("clear")
        driven.hears("slewline: the drive is not halted, so clearing it has no effect")
        driven.type("Halt")
        driven.hears("slewline: 'halt'; allowed: clear: continue after a halt")
        with ModuleHost(where) as host:
            host.program(*SPEEDS, "g+")
            while driven.count() < 300:
                sleep(0.02)
            driven.type("stop")
            driven.hears(r"gs_c200s: board-stopped: the host stops the motor along its stop ramp")
            driven.type("status")
            driven.hears(r"board halted at \d+ .*board-stopped")
            stood = driven.stands()
            assert stood > 300
            driven.type("clear")
            driven.hears("the drive continues")
            assert host.ask("F") == "R"
            host.program(*SPEEDS, "+5")
            host.until_ready()
            assert driven.stands() == host.position() == stood + 5
        driven.type("end")
        assert driven.ended() == 0


@pytest.mark.system
def test_sigusr2_is_clear(folder):
    with Slewline(*DRIVE, "--board", "twin", "--no-black-box", folder=folder) as driven:
        driven.ready()
        driven.signal(signal.SIGUSR2)
        driven.hears("slewline: the drive is not halted, so clearing it has no effect")
        assert driven.process.poll() is None
        assert "type clear" not in driven.text  # there is no terminal
        assert driven.end() == 0


@pytest.mark.system
def test_a_program_that_starts_by_itself_moves_the_motor_only_where_that_is_allowed(folder):
    words = ("--board", "twin", "--no-black-box", "--state", "kept", *AHEAD)
    with Slewline(*DRIVE, *words, folder=folder) as driven:
        with ModuleHost(driven.ready()) as host:
            host.tell("Po", *SPEEDS, "+300", "Px", "M")
            host.until_ready()
        assert driven.end() == 0
    with Slewline(*DRIVE, *words, "--strap", "rec=0", folder=folder) as driven:
        driven.ready()
        driven.hears("gs_c200s: moved-by-itself: the chip began to move before any command from a host")
        driven.hears("--self-start")
        for _ in range(3):
            assert "board halted at 0" in driven.status()
        assert driven.end() == 0
    with Slewline(*DRIVE, *words, "--strap", "rec=0", "--self-start", folder=folder) as driven:
        with ModuleHost(driven.ready()) as host:
            # As the module does it, it homes first; no switch is wired, so it looks for one until it is told to stop.
            while driven.count() < 200:
                assert host.ask("F") == "B"
            host.tell("K")
            assert driven.stands() > 200
        assert driven.end() == 0


def test_check_needs_no_port_and_leaves_nothing(call, monkeypatch, folder):
    monkeypatch.setenv("XDG_STATE_HOME", str(folder / "state"))
    monkeypatch.setattr(drive, "CHECK_S", 0.1)
    monkeypatch.setattr("slewline.links.sockets.system.be_prompt", lambda: "normal priority")
    ran = call("drive", "gs-c200s", "--board", "twin", "--check")
    assert ran.status == 0 and ran.out.splitlines()[-1] == "pulses    1000 pulses sent, 1000 counted"
    assert "slewline: measuring for 0.1 s" in ran.err
    monkeypatch.setattr("slewline.drive.check.ESTOP_S", 0.2)
    words = ("--enable", "--driver", "A4988", "--input", "A0=estop")
    ran = call("drive", "gs-c200s", "--board", "twin", "--check", *words)
    assert ran.status == 1 and [line.split()[0] for line in ran.out.splitlines()[-2:]] == ["jog", "e-stop"]
    assert "10 steps up and 10 back" in ran.out and "not detected within 0.2 s: check its wire" in ran.out
    assert "open the contact of the emergency stop" in ran.err
    assert not list(folder.iterdir())
