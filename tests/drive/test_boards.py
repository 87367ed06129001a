"""Boards are looked up by what they report: a row of BOARDS gives the pins and the clock of a second one."""

from __future__ import annotations

import pytest

import slewline
from slewline.cli.main import invoke
from slewline.drive import motor_drive as drives
from slewline.drive.board import rehearsal
from slewline.drive.board.boards import BOARDS, UNO, BoardModel, BoardPin, board_of, by_number
from slewline.drive.board.wire import VERSION, BoardState, Ident
from slewline.errors import UsageError

from .rig import TwinLine, drive_of

OTHER = UNO._replace(
    number=7,
    name="other",
    title="Other board (64 MHz)",
    hz=64_000_000,
    step=BoardPin("GP2", "2"),
    loop=BoardPin("GP3", "3"),
    outputs=tuple(BoardPin(f"GP{n}", str(n)) for n in (10, 11)),
    inputs=tuple(BoardPin(f"GP{n}", str(n)) for n in (20, 21, 22)),
)


@pytest.fixture
def listed(monkeypatch: pytest.MonkeyPatch) -> BoardModel:
    monkeypatch.setitem(BOARDS, OTHER.number, OTHER)
    return OTHER


def test_two_boards_of_one_number_are_refused():
    assert by_number(UNO, OTHER) == {1: UNO, 7: OTHER}
    with pytest.raises(ValueError, match="boards uno and mega: both have number 1; give each a different one"):
        by_number(UNO, OTHER, UNO._replace(name="mega"))


def test_a_second_board_needs_a_row_alone(listed):
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.host(x).send("A 0\rF 10\rR 60\rS 200\rZ 1\rN 50\rG\r")
    port = rehearsal.TwinPort(OTHER)
    port.set_input("GP21", 0)
    wired = {"inputs": {"GP21": "estop"}, "outputs": {"gp11": "slew"}}
    with slewline.Drive(bench, x, port, horizon="300 ms", black_box=False, **wired) as drive:
        assert drive.board is OTHER and drive._path.clock.hz == 64_000_000 and drive._state.horizon == 19_200_000
        assert drive._state.outputs == {1: "slew"} and [each.number for each in drive._inputs] == [1]
        drive.run_until_rest()
        assert len(port.twin.steps) == 50 and port.twin.state == BoardState.IDLE
        port.set_input("GP21", 1)
        drive.run("20 ms")
        assert drive.state == "halted"


@pytest.mark.parametrize(
    ("more", "says"),
    [
        (("--input", "A1=home"), "input 'A1' of the board; allowed GP20, GP21, GP22"),
        (("--output", "D2=uo1"), "output 'D2' of the board; allowed GP10, GP11"),
    ],
)
def test_the_command_line_takes_the_names_of_its_pins(listed, more, says, monkeypatch, tmp_path, capfd):
    monkeypatch.setattr(drives, "opened", lambda _name: rehearsal.TwinPort(OTHER))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    words = ["drive", "gs-c200s", "--board", "ttyX", "--tcp", "127.0.0.1:0", "--no-black-box", *more]
    assert invoke(words) == 2
    assert says in " ".join(capfd.readouterr().err.replace("│", " ").split())


def test_a_board_that_is_not_listed_is_refused_and_its_port_is_closed(monkeypatch):
    port = rehearsal.TwinPort(OTHER)
    closed = []
    monkeypatch.setattr(port, "close", lambda: closed.append(True))
    monkeypatch.setattr(drives, "opened", lambda _name: port)
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    with pytest.raises(
        UsageError, match=r"board 7; known: 1 \(Arduino Uno .*\); write the firmware .* to a board that is listed"
    ):
        slewline.Drive(bench, x, "ttyX", black_box=False)
    assert closed == [True]


def test_a_port_that_is_handed_over_stays_open():
    line = TwinLine(model=OTHER)
    bench = slewline.Bench()
    with pytest.raises(UsageError, match="board 7"):
        drive_of(bench, bench.add("cy525", name="x"), line)
    assert not line.closed


def test_a_board_that_becomes_another_one_is_refused(listed):
    line = TwinLine()
    bench = slewline.Bench()
    drive = drive_of(bench, bench.add("cy525", name="x"), line)
    line.model = UNO._replace(number=OTHER.number, hz=OTHER.hz)
    line.reset_board()
    with pytest.raises(UsageError, match=r"is now an Other board .*, but was an Arduino Uno"), drive:
        pass


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"version": VERSION + 1}, "has version 3 of the firmware, but this slewline needs 2"),
        ({"hz": 8_000_000}, "has 8000000 ticks per second; expected 16000000, as for a uno"),
    ],
)
def test_another_version_and_another_clock_are_refused(change, says):
    ident = Ident(0, VERSION, UNO.number, UNO.slots, UNO.tail, UNO.room, UNO.shortest, UNO.hz)
    assert board_of(ident) is UNO
    with pytest.raises(UsageError, match=says):
        board_of(ident._replace(**change))
