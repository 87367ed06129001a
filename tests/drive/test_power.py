"""The current of a driver, from open to close: what the user asks for, what the board allows, what is known then."""

from __future__ import annotations

from random import Random

import pytest

from slewline.drive.board.wire import ENABLE, BoardState, FrameKind
from slewline.errors import UsageError
from tests.ensembles import few, members

from .families import furnished
from .rig import HZ, TwinLine, drive_of

MOVING = ["cy525 long ramp", "gs-c200s to 10 k", "cy545 to 27 k", "mc1451a to 45 k", "mc1451a endless"]
POWERED = {"enable": True, "driver": "A4988", "pulses": False}


def codes(drive):
    return [trouble.partition(":")[0] for trouble in drive.troubles]


def switched(line):
    """Ticks and states of ENABLE."""
    out, before = [], False
    for tick, value in line.twin.outputs:
        if bool(value & ENABLE) != before:
            before = not before
            out.append((tick, before))
    return out


def is_on(line):
    return bool(line.twin.output & ENABLE)


def estopped(line, level):
    line.twin.set_input(0, level, max(line.tick(line.now), line.twin.now))


# ---------------------------------------------------------------------------------------------------------------- close
@pytest.mark.parametrize("off", few(["halt", "rest", "never"], 2))
@members("numbers", 2, 12)
@pytest.mark.parametrize("name", few(MOVING, 3))
def test_a_session_that_ends_in_a_motion_removes_the_current_from_a_stopped_motor(name, numbers, off):
    for number in numbers:
        rnd = Random(f"close {name} {number}")
        bench, x, *_ = furnished(name)
        line = TwinLine(rnd)
        with drive_of(bench, x, line, enable_off=off, start_stop=30000, **POWERED) as drive:
            drive.run(f"{rnd.randrange(250, 800)} ms")
            made = len(line.twin.steps)
        assert len(line.twin.steps) > made, "it was in motion"
        assert drive.state == "closed" and line.closed
        last = line.twin.steps[-1][0]
        (_, on), *later = switched(line)
        assert on and [state for _, state in later] == [False] * (off != "never")
        for tick, _ in later:
            assert 0 < tick - last < HZ // 10
        stood = len(line.twin.steps)
        line.pass_to(line.now + 10**9)
        assert len(line.twin.steps) == stood
        assert line.twin.position == drive.count
        if x.sheet.part != "mc1451a":  # which is stopped by its supply, and forgets
            assert x.position == drive.count
            assert "position-taken-over" in codes(drive)


def test_an_exception_of_the_users_program_ends_a_session_as_its_end_does():
    bench, x, *_ = furnished("cy525 long ramp")
    line = TwinLine()
    with pytest.raises(ZeroDivisionError), drive_of(bench, x, line, **POWERED) as drive:
        drive.run("700 ms")
        raise ZeroDivisionError
    assert x.position == drive.count == len(line.twin.steps) and not is_on(line)
    assert switched(line)[-1][0] > line.twin.steps[-1][0]


def test_an_interrupt_while_a_session_ends_leaves_the_current_to_the_board(monkeypatch):
    bench, x, *_ = furnished("cy525 long ramp")
    line = TwinLine()
    drive = drive_of(bench, x, line, **POWERED)
    with pytest.raises(KeyboardInterrupt), drive:
        drive.run("700 ms")
        monkeypatch.setattr(drive._live, "keep_up", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    assert drive.state == "closed" and line.closed and is_on(line)
    line.pass_to(line.now + 3 * 10**9)  # the board has not heard its host: it goes down, and halts
    assert line.twin.state == BoardState.HALT and is_on(line)
    line.pass_to(line.now + 61 * 10**9)
    assert not is_on(line) and line.twin.power.locked


# --------------------------------------------------------------------------------------------------------- after a halt
@pytest.fixture
def stopped():
    """A GS-C whose motor an emergency stop has stopped in a motion."""
    bench, x, *_ = furnished("gs-c200s to 10 k")
    line = TwinLine()
    line.twin.inputs &= ~1
    drive = drive_of(bench, x, line, inputs={"A0": "estop"}, **POWERED)
    with drive:
        drive.run("500 ms")
        assert is_on(line) and drive.power.known
        estopped(line, 1)
        assert not is_on(line), "at once"
        drive.run("300 ms")
        yield drive, line
    assert not is_on(line)


def test_an_emergency_stop_leaves_a_gsc_its_program_and_its_register_at_the_count(stopped):
    drive, line = stopped
    assert codes(drive)[0] == "e-stop" and drive.state == "halted" and not drive.power.known
    x = drive.chip
    assert x.powered and x.program_rows() and x.position == line.twin.position == drive.count
    host = drive.bench["host"]
    before = len(host.received)
    host.send("F\rV1\r")
    drive.run("100 ms")
    assert bytes(host.received[before:]) == b"R\rV%+d\r" % x.position


def test_an_open_emergency_stop_keeps_the_driver_off_whatever_the_host_sends(stopped):
    drive, line = stopped
    for words in ({}, {"homed": True}, {"homing": True}):
        with pytest.raises(UsageError, match="emergency stop is active"):
            drive.clear(**words)
        assert not is_on(line) and drive.state == "halted"
    drive._path.link.outputs(ENABLE, ENABLE)
    drive.run("50 ms")
    assert not is_on(line)
    estopped(line, 0)
    with pytest.raises(UsageError, match="'homed' and 'homing'"):
        drive.clear(homed=True, homing=True)


@pytest.mark.parametrize(("words", "on", "known"), [({}, False, False), ({"homed": True}, True, True)])
def test_the_driver_stays_off_after_an_emergency_stop_unless_the_user_sends_more_than_clear(stopped, words, on, known):
    drive, line = stopped
    estopped(line, 0)
    drive.clear(**words)
    drive.run("100 ms")
    assert drive.state == "ok" and is_on(line) is on is drive.power.on and drive.power.known is known
    assert bool(line.twin.power.locked) is not on


def test_the_position_is_unknown_until_the_homing_has_ended(stopped):
    drive, line = stopped
    estopped(line, 0)
    x, host = drive.chip, drive.bench["host"]
    drive.clear(homing=True)
    drive.run("100 ms")
    assert is_on(line) and not drive.power.known and line.twin.power.unsure
    host.send("Po\rS50\rT100\rR90\r+20\rE\r")
    drive.run("600 ms")
    assert not drive.power.known, "a move is no homing"
    host.send("H+\r")
    drive.run("300 ms")
    assert x.motor.homing and not drive.power.known
    x.pin("eot").drive(0)
    drive.run("300 ms")
    x.pin("eot").drive(1)
    x.pin("home").drive(0)
    drive.run("400 ms")
    assert not x.motor.homing and x.position == 0
    assert drive.power.known and not line.twin.power.unsure


def test_a_homing_that_is_killed_leaves_the_position_unknown(stopped):
    drive, line = stopped
    estopped(line, 0)
    drive.clear(homing=True)
    host = drive.bench["host"]
    host.send("Po\rS50\rPx\rE\rH+\r")
    drive.run("400 ms")
    host.send("K\r")
    drive.run("400 ms")
    assert not drive.chip.motor.homing and drive.chip.position != 0 and not drive.power.known


# ------------------------------------------------------------------------------------------------------ without a host
@pytest.mark.parametrize("off", ["halt", "never"])
def test_a_host_that_is_silent_at_rest_for_too_long_is_notified_that_the_driver_is_off(off):
    bench, x, *_ = furnished("cy525 five steps")
    line = TwinLine()
    with drive_of(bench, x, line, enable_off=off, enable_hold="1 s", **POWERED) as drive:
        drive.run("500 ms")
        line.pass_to(line.now + 3 * 10**9)  # a computer that stands, as by SIGSTOP
        assert is_on(line) is (off == "never")
        drive.run("500 ms")
        assert codes(drive)[:1] == ["driver-off"] * (off == "halt")
        assert drive.state == ("halted" if off == "halt" else "ok") and drive.power.known is (off == "never")


def test_a_driver_that_goes_off_at_rest_is_on_again_before_the_first_step():
    bench, x, host, _ = furnished("cy525 five steps")
    line = TwinLine()
    with drive_of(bench, x, line, enable_off="rest", enable_hold="50 ms", **POWERED) as drive:
        drive.run("600 ms")
        assert not is_on(line) and len(line.twin.steps) == 5
        for made in (10, 15):
            host.send("G\r")
            drive.run("600 ms")
            assert len(line.twin.steps) == made and not is_on(line)
        assert not drive.troubles and drive.power.known and not line.twin.power.unsure
    on = [tick for tick, on in switched(line) if on]
    assert len(on) == 3 and on[1] < line.twin.steps[5][0] and on[2] < line.twin.steps[10][0]


def test_a_count_without_current_is_not_kept():
    line = TwinLine()
    bench, x, *_ = furnished("cy525 five steps")
    with drive_of(bench, x, line) as drive:  # pulses, and no current
        drive.run("300 ms")
    again, y, *_ = furnished("cy525 five steps")
    with pytest.raises(UsageError, match=r"count of the board, 5, cannot be kept .* without current"):
        drive_of(again, y, line, keep_count=True).open()
    again, y, *_ = furnished("cy525 five steps")
    with drive_of(again, y, line, keep_count=True, homed=True) as drive:
        assert y.position == 5 and drive.power.known


# --------------------------------------------------------------------------------------------------------------- clocks
@pytest.mark.parametrize("slept_s", few([10, 100, 134, 140, 200, 260, 268, 269, 420, 1000], 5))
def test_after_the_computer_has_slept_the_next_motion_is_made(slept_s):
    bench, x, host, _ = furnished("cy525 five steps")
    line = TwinLine()
    with drive_of(bench, x, line, enable_off="never", **POWERED) as drive:
        drive.run("500 ms")
        line.began -= slept_s * 10**9  # the clock of the board went on, that of the computer stood
        drive.run("300 ms")
        host.send("G\r")
        before = line.now
        drive.run("500 ms")
        assert drive.state == "ok" and not drive.troubles
        assert len(line.twin.steps) == 10 and line.twin.steps[5][0] - line.tick(before) < HZ // 4
        assert x.position == drive.count == 10


@pytest.mark.parametrize("slept_s", few([10, 140, 200, 1000], 2))
def test_a_computer_that_slept_in_a_motion_halts_where_the_board_has_stopped(slept_s):
    bench, x, *_ = furnished("cy525 long ramp")
    line = TwinLine()
    with drive_of(bench, x, line, **POWERED) as drive:
        drive.run("900 ms")
        line.began -= slept_s * 10**9
        drive.run("2 s")
        assert drive.state == "halted" and x.position == drive.count == len(line.twin.steps)
        assert {"underrun", "host-silent", "computer-slept"} & set(codes(drive))


# ----------------------------------------------------------------------------------------------------------- a bad line
@pytest.mark.parametrize("lost", [FrameKind.START, FrameKind.PUSH])
def test_a_motion_whose_start_is_never_confirmed_is_reported_and_not_made(lost):
    bench, x, host, _ = furnished("cy525 five steps")
    line = TwinLine()
    with drive_of(bench, x, line, **POWERED) as drive:
        drive.run("500 ms")
        receive = line.twin._take
        line.twin._take = lambda frame, tick: getattr(frame, "kind", 0) == lost or receive(frame, tick)
        host.send("G\r")
        drive.run("800 ms")
        assert codes(drive)[0] == "not-started" and drive.state == "halted"
        del line.twin._take
        drive.run("1 s")
        assert len(line.twin.steps) == 5 == drive.count == x.position and line.twin.state == BoardState.IDLE
        drive.clear()
        host.send("G\r")
        drive.run("500 ms")
        assert len(line.twin.steps) == 10 == x.position and drive.state == "ok"
