"""Hazards of a real motor: whatever host, user and line do, what the pins of the board show is allowed."""

from __future__ import annotations

import re
import signal
from itertools import product
from random import Random
from time import monotonic, sleep

import numpy as np
import pytest

from slewline.drive.board.wire import Happening
from slewline.drive.step_drivers import STEP_DRIVERS
from tests.drive.process import ModuleHost, Slewline
from tests.ensembles import few, members

from .chain import WITHIN_TICKS, events, said, wanted
from .served import ServedBoard
from .test_hard_times import damaged
from .trials import (
    DRIVERS,
    FAMILIES,
    HZ,
    OFF_WITHIN,
    SET_UP,
    Followed,
    Sessions,
    edges_after,
    least_set_up,
    levels_at_edges,
    moves,
    prepared,
    spans_on,
)

pytestmark = [pytest.mark.system, pytest.mark.timeout(600)]
PHASES = 0xF0  # of port D
OFF_AFTER_REST = HZ // 10  # ticks from the last step to ENABLE off, at the end of a session


def codes(drive):
    """The troubles of a drive, without their texts."""
    return {trouble.partition(":")[0] for trouble in drive.troubles}


def instant(rnd, trial):
    """An instant at which the motor of a trial is in motion."""
    first, last = trial.family.span
    return f"{rnd.randrange(first * 1000, last * 1000)} us"


# ------------------------------------------------------------------------------------------------------------------ DIR
@members("seeds", 1, 21)
@pytest.mark.parametrize("invert", [False, True])
@pytest.mark.parametrize("name", FAMILIES)
def test_dir_has_the_level_of_the_chips_own_pin_at_every_step(emulator, name, invert, seeds):
    for seed in seeds:
        rnd = Random(f"dir {name} {seed}")
        family = FAMILIES[name]
        trial = prepared(emulator, name, seed, text=family.first, invert_dir=invert)
        row = next((row for row in trial.x.sheet.pins if row.plays("direction", 1)), None)
        assert (row is None) == (name == "cy500")
        pin = None if row is None else Followed(trial.bench, trial.x.pin(row.name))
        place = 0
        with trial.drive as drive:
            drive.run("200 ms")
            for steps in [7, -5, *moves(rnd, 4)]:
                trial.send(family.move(steps, place))
                place += steps
                drive.run("250 ms")
            drive.run_until_rest()
            drive.run("150 ms")
            steps = trial.x.steps()
            own = pin.at(steps.times_ps) if pin else [int(way > 0) for way in steps.directions]
            assert set(own) == {0, 1} and place == int(steps.directions.sum()) == trial.edges
            assert [level ^ invert for level in levels_at_edges(trial.board)] == own
            assert least_set_up(trial.board) >= SET_UP
            assert not drive.troubles


# ---------------------------------------------------------------------------------------------- the end of a session
def ended_well(trial, policy, made):
    """A session has ended in a motion: rest, then ENABLE; the count is that of the edges."""
    board, drive, x = trial.board, trial.drive, trial.x
    assert drive.state == "closed" and trial.line.closed
    assert len(board.rises) > made, "it was in motion"
    last, rises = board.rises[-1], len(board.rises)
    trial.line.stop_host(1_000)
    assert len(board.rises) == rises
    assert board.enable[-2 if policy != "never" else -1][1] == trial.on
    if policy == "never":
        assert trial.is_on()
        late = 0
    else:
        off, level = board.enable[-1]
        assert level == 1 - trial.on, "driven, not let go of"
        late = off - last
        assert 0 < late < OFF_AFTER_REST
        assert edges_after(board, off) == 0
    assert len(spans_on(board, trial.on)) == 1, "never off and on in between"
    assert trial.edges == drive.count == said(trial.line).position
    if x.sheet.part != "mc1451a":  # which is stopped by its supply, and forgets
        assert x.position == trial.edges
        assert ("position-taken-over" in codes(drive)) == (x.travel != trial.edges)
    return late


@members("numbers", 1, 101)
@pytest.mark.parametrize("case", few([*product(FAMILIES, ("halt", "never"))][::-1], 7), ids=" ".join)
def test_a_session_closed_in_motion_ramps_down_then_takes_the_current_away(emulator, case, numbers):
    (name, policy), latest = case, 0
    for number in numbers:
        rnd = Random(f"close {name} {policy} {number}")
        driver = rnd.choice(DRIVERS)
        trial = prepared(emulator, name, number, driver=driver, enable_off=policy)
        with trial.drive as drive:
            drive.run(instant(rnd, trial))
            made = len(trial.board.rises)
        latest = max(latest, ended_well(trial, policy, made))
    print(f"{name} {policy}: ENABLE off {latest / HZ * 1000:.2f} ms after the last step at most")


@members("numbers", 1, 21)
@pytest.mark.parametrize("error", [ZeroDivisionError, KeyboardInterrupt])
def test_an_exception_in_a_session_ends_it_as_its_end_does(emulator, error, numbers):
    for number in numbers:
        rnd = Random(f"exception {error} {number}")
        trial = prepared(emulator, rnd.choice(list(FAMILIES)), number, driver=rnd.choice(DRIVERS))
        with pytest.raises(error), trial.drive as drive:
            drive.run(instant(rnd, trial))
            made = len(trial.board.rises)
            raise error
        ended_well(trial, "halt", made)


@members("numbers", 2, 102)
@pytest.mark.parametrize("name", FAMILIES)
def test_an_emergency_stop_takes_the_current_and_the_steps_away_immediately(emulator, name, numbers):
    latest = most = 0
    for number in numbers:
        rnd = Random(f"e-stop {name} {number}")
        driver, policy = rnd.choice(DRIVERS), rnd.choice(["halt", "never", "rest"])
        trial = prepared(
            emulator, name, number, driver=driver, enable_off=policy, closed=(5,), inputs={"A5": "estop"}, filter=15
        )
        board = trial.board
        with trial.drive as drive:
            drive.run(instant(rnd, trial))
            assert trial.is_on() and board.rises
            tick = trial.set_input(5, 1, rnd.randrange(40, 40_000))
            drive.run("300 ms")
            drive.run_until(lambda: not drive._state.axis.moving and drive._watch.stopping.settled)
            off, level = board.enable[-1]
            assert level == 1 - trial.on
            latest, most = max(latest, off - tick), max(most, edges_after(board, tick))
            assert 0 < off - tick <= OFF_WITHIN
            assert edges_after(board, tick) <= 1 and edges_after(board, off) == 0
            assert drive.state == "halted" and not drive.power.known
            assert trial.edges == drive.count
            assert {"e-stop"} <= codes(drive)
            if name != "mc1451a":
                assert trial.x.position == trial.edges
        assert not trial.is_on() and board.enable[-1] == (off, level)
    print(f"{name}: ENABLE off {latest / HZ * 1e6:.1f} us after the edge at most; {most} edges after it at most")


@members("seeds", 20, 1000, 70)
def test_a_driver_is_never_on_while_an_emergency_stop_is_open(emulator, seeds):
    switched_on = opened = begun = refused = latest = 0
    for seed in seeds:
        sessions = Sessions(emulator, seed)
        sessions.live(24)
        board = sessions.line.board
        lit = spans_on(board, STEP_DRIVERS[sessions.driver].enabled)
        for (since, until), (on, off) in product(sessions.opened, lit):
            assert not since + OFF_WITHIN < on < until, (seed, since, on)
            assert min(until, off) - max(since, on) <= OFF_WITHIN, (seed, since, on, off)
            if on <= since < off:
                latest = max(latest, off - since)
        assert not lit or lit[-1][1] < board.now or sessions.policy == "never", "a session that has ended"
        switched_on, opened = switched_on + len(lit), opened + len(sessions.opened)
        begun, refused = begun + sessions.begun, refused + sessions.refused
    print(
        f"{begun} sessions, {refused} refusals, contact open {opened} times, driver on {switched_on} times; "
        f"off {latest / HZ * 1e6:.1f} us after the contact at most"
    )
    assert begun > len(seeds) and switched_on > len(seeds) / 2 and opened > len(seeds)


# --------------------------------------------------------------------------------------------------------- dry runs
@members("numbers", 1, 11)
@pytest.mark.parametrize("driver", [None, *DRIVERS])
@pytest.mark.parametrize("name", FAMILIES)
def test_a_dry_run_counts_every_step_and_outputs_no_edge(emulator, name, driver, numbers):
    for number in numbers:
        rnd = Random(f"dry {name} {driver} {number}")
        family = FAMILIES[name]
        trial = prepared(emulator, name, number, driver=driver, text=family.first, enable=False, pulses=False)
        board, place = trial.board, 0
        with trial.drive as drive:
            drive.run("200 ms")
            for steps in moves(rnd, 3):
                trial.send(family.move(steps, place))
                place += steps
                drive.run("250 ms")
            drive.run_until_rest()
            drive.run("100 ms")
            assert place == int(trial.x.steps().directions.sum()) == drive.count == said(trial.line).position
            assert not drive.troubles
        assert board.rises == board.falls == []
        assert not any((portd | ddrd) & PHASES for _, _, _, portd, ddrd in board.ports)
        off = None if driver is None else 1 - STEP_DRIVERS[driver].enabled
        assert {level for _, level in board.enable} == ({off} - {None})


# ------------------------------------------------------------------------------------------------------------- holds
HELD = {"gs-c200s": ("enable", 0), "cy525": ("step_inhibit", 1), "cy500": ("trigger", 1)}


@members("numbers", 1, 11)
@pytest.mark.parametrize("journal", [False, True], ids=["no journal", "journal"])
@pytest.mark.parametrize("what", ["close", "emergency stop", "silence", "stop", "stop at once"])
@pytest.mark.parametrize("name", HELD)
def test_a_hold_that_something_else_has_ended_is_not_released_into_a_motion(
    emulator, tmp_path, name, what, journal, numbers
):
    pin, level = HELD[name]
    for number in numbers:
        rnd = Random(f"held {name} {what} {number}")
        (folder := tmp_path / str(number)).mkdir()
        trial = prepared(
            emulator, name, number, driver=rnd.choice(DRIVERS), closed=(0, 5) if level else (5,), start_stop=30_000,
            inputs={"A5": "estop", "A0": pin}, journal=folder / "journal" if journal else None,
        )  # fmt: skip
        board = trial.board
        with trial.drive as drive:
            drive.run(instant(rnd, trial))
            held = trial.set_input(0, level)
            drive.run(f"{rnd.randrange(2, 400)} ms")
            made = len(board.rises)
            assert made and edges_after(board, held) <= 1
            if what == "emergency stop":
                trial.set_input(5, 1)
                drive.run("5 ms")
                assert not trial.is_on()
            elif what == "silence":
                trial.line.stop_host(400)
            elif what != "close":
                drive.stop(at_once=what == "stop at once")
            if what == "silence" and journal:  # of a motor at rest: its host goes on, and so does the motion
                trial.set_input(0, 1 - level)
                drive.run("500 ms")
                assert len(board.rises) > made and not drive.troubles
                continue
            if what != "close":
                drive.run("300 ms")
                trial.set_input(0, 1 - level)
                drive.run("500 ms")
                assert len(board.rises) == made and drive.state == "halted", drive.troubles
                drive.run_until(lambda: not drive._state.axis.moving and drive._watch.stopping.settled)
                assert drive.count == trial.edges == trial.x.position
        assert len(board.rises) == made and not trial.is_on()
        trial.set_input(0, 1 - level)
        trial.line.stop_host(1_000)
        assert len(board.rises) == made and not trial.is_on()
        assert trial.drive.count == trial.edges == said(trial.line).position == trial.x.position


# ----------------------------------------------------------------------------------------------------- ends and stops
@members("seeds", 2, 52)
@pytest.mark.parametrize("how", ["stop", "stop at once", "close"])
@pytest.mark.parametrize("name", FAMILIES)
def test_a_stop_as_a_motion_begins_is_a_stop(emulator, name, how, seeds):
    most = 0
    for seed in seeds:
        rnd = Random(f"early {name} {how} {seed}")
        trial = prepared(emulator, name, seed, driver=rnd.choice(DRIVERS), text=trial_text(name))
        board = trial.board
        with trial.drive as drive:
            drive.run("200 ms")
            trial.send(trial.family.long)
            drive.run_until(lambda: drive._state.axis.moving)
            if wait := rnd.choice((0, rnd.randrange(30))):
                drive.run(f"{wait} ms")
            if how != "close":
                drive.stop(at_once="once" in how)
                drive.run("300 ms")
                drive.run_until(lambda: drive._state.final and drive._watch.stopping.settled)
                assert drive.state == "halted" and "board-stopped" in codes(drive)
        if how == "close":
            assert trial.line.now < 5_000_000_000 + 3 * 10**9
        stood = len(board.rises)
        most = max(most, stood)
        trial.line.stop_host(1_000)
        assert len(board.rises) == stood and not trial.is_on()
        assert trial.edges == drive.count == said(trial.line).position
        if name != "mc1451a":
            assert trial.x.position == trial.edges
    print(f"{name} {how}: {most} steps at most")
    assert most < 40, "down from the start-stop rate"


def trial_text(name):
    """What is sent before a long motion: nothing that is sent again with it."""
    return FAMILIES[name].first if name == "gs-c200s" else ""


@members("seeds", 4, 104)
@pytest.mark.parametrize("how", ["stop", "close"])
def test_a_stop_between_two_motions_of_a_program_is_a_stop(emulator, how, seeds):
    for seed in seeds:
        rnd = Random(f"between {how} {seed}")
        text = "I3\rPo\rS50\rT200\rR40\rL0\r+4\rD1\r-4\rD2\r+2\r-2\rL200\rPx\rE\r"
        trial = prepared(emulator, "gs-c200s", seed, driver=rnd.choice(DRIVERS), text=text)
        board = trial.board
        with trial.drive as drive:
            drive.run(f"{rnd.randrange(400_000, 900_000)} us")
            made, began = len(board.rises), trial.line.now
            if how == "stop":
                drive.stop()
                drive.run("400 ms")
                assert drive.state == "halted" and made, drive.troubles
                stood = len(board.rises)
                drive.run("500 ms")
                assert len(board.rises) == stood
        assert trial.line.now - began < 1.5 * 10**9
        stood = len(board.rises)
        trial.line.stop_host(1_000)
        assert made and len(board.rises) == stood <= made + 30 and not trial.is_on()
        assert trial.edges == drive.count == trial.x.position


# ------------------------------------------------------------------------------------------------------------ damage
@members("seeds", 2, 21)
@pytest.mark.parametrize("percent", [1, 2, 5, 10])
@pytest.mark.parametrize("name", few(["gs-c200s", "cy525", "cy545", "mc1451a"], 2))
def test_on_a_line_that_damages_to_the_end_nothing_is_wrong_without_a_finding(emulator, name, percent, seeds):
    outcomes = dict.fromkeys(("all steps", "halted", "off by the board"), 0)
    for seed in seeds:
        rnd = Random(f"damage {name} {percent} {seed}")
        driver, family = rnd.choice(DRIVERS), FAMILIES[name]
        trial = prepared(
            emulator, name, seed, driver=driver, text=family.first, horizon="300 ms", enable_hold="1 s", start_stop=500
        )
        board, drive = trial.board, trial.drive
        with drive:
            drive.run("200 ms")
            trial.line.damage = damaged(f"{name} {percent} {seed}", percent / 100)
            trial.send(family.move(400, 0))
            drive.run("2500 ms")
            due, _ = wanted(drive)
            if drive.state == "ok":
                assert len(board.rises) == 400 and codes(drive) <= {"late-start"}, drive.troubles
                outcomes["all steps"] += 1
            else:
                assert codes(drive) & {"underrun", "host-silent", "not-started", "board-silent"}
                outcomes["halted"] += 1
        closed = board.now
        trial.line.stop_host(3_000)
        made = np.array(board.rises)
        dry = [event.tick for event in events(trial.line) if event.kind in (Happening.UNDERRUN, Happening.WATCHDOG)]
        planned = made[made <= min(dry, default=1 << 60)]
        late = np.abs(planned - due[: len(planned)]).max(initial=0) > WITHIN_TICKS
        # where the board has dried up in the last steps, its own way down may be a step longer than what was left
        assert len(made) <= 400 + bool(dry) and (not late or "late-start" in codes(drive)), (seed, drive.troubles)
        assert trial.edges == len(made) == said(trial.line).position
        off, level = board.enable[-1]
        assert level == 1 - trial.on and edges_after(board, off) == 0
        assert off < closed + HZ * 3 // 2  # by the host, or by the board, which waits for a second
        outcomes["off by the board"] += int(off > closed)
        if drive.count != trial.edges:  # it could not be heard
            assert codes(drive) & {"board-silent"}, (seed, drive.count, trial.edges, drive.troubles)
    print(f"{name}, {percent} %: {outcomes}")


# ------------------------------------------------------------------------------------- the end of a process, real time
COMMAND = ("drive", "gs-c200s", "--strap", "chs=0", "--tcp", "127.0.0.1:0", "--black-box", "boxes")
FAST = ("S50", "T600", "R300")
IN_REAL_TIME = HZ // 2  # ticks from the last step to ENABLE off, beside whatever else this machine does


@pytest.mark.posix
@pytest.mark.long  # in real time: not beside other tests
@pytest.mark.timeout(900)
@members("numbers", 2, 20, 5)
@pytest.mark.parametrize("how", ["SIGINT", "SIGTERM", "end", "SIGKILL"])
def test_a_process_that_ends_in_motion_leaves_a_motor_at_rest_without_current(firmware, tmp_path, how, numbers):
    for number in numbers:
        rnd = Random(f"process {how} {number}")
        driver = rnd.choice(DRIVERS)
        (folder := tmp_path / str(number)).mkdir()
        words = (*COMMAND, "--driver", driver, "--enable", "--enable-hold", "1 s", "--horizon", "1 s")
        with (
            ServedBoard(firmware) as board,
            Slewline(*words, "--board", board.port, folder=folder, typed=True) as process,
            ModuleHost(process.ready()) as host,
        ):
            board.promptly()
            host.program(*FAST, "g+")
            while len(board.steps()) < 100:
                sleep(0.02)
            sleep(rnd.uniform(0, 1))
            made, before = len(board.steps()), process.text
            if how == "end":
                process.type("end")
            else:
                process.signal(getattr(signal, how))
            status = process.ended()
            assert (status == 0) == (how != "SIGKILL"), process.text
            limit, shown = monotonic() + 30, board.shown()
            on = STEP_DRIVERS[driver].enabled
            while shown["enable"][-1][1] == on or shown["now"] < shown["enable"][-1][0] + HZ // 2:
                assert monotonic() < limit, shown["enable"]
                sleep(0.1)
                shown = board.shown()
            rises, (off, level) = shown["rises"], shown["enable"][-1]
            busy = "underrun|host-silent|computer-slept|not-started"
            assert not re.search(busy, before), "this machine was too busy to keep the motor in motion"
            assert level == 1 - on and len(rises) > made
            assert [each for _, each in shown["enable"]].count(on) == 1
            late = off - rises[-1]
            if how == "SIGKILL":  # the board ramps down, halts, and waits
                assert 0.9 * HZ < late < 1.2 * HZ
            else:
                assert 0 < late < IN_REAL_TIME
                found = re.search(r"position-taken-over: the motor is at (-?\d+)", process.text)
                assert found and int(found[1]) == len(rises), process.text
        print(f"{how}: ENABLE off {late / HZ * 1000:.1f} ms after the last step, {len(rises) - made} steps later")
