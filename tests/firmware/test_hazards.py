"""Current, direction, holds, sleeps and damage on the emulated board: its pins are the witness, whatever the model."""

from __future__ import annotations

from contextlib import suppress
from random import Random

import numpy as np
import pytest

from slewline.drive.board.wire import ENABLE, BoardState, Happening
from slewline.errors import UsageError
from tests.drive.families import SCRIPTS
from tests.ensembles import few, members

from .chain import HZ, WITHIN_TICKS, events, said, wanted
from .hazards import (
    AT_ONCE_TICKS,
    ESTOP,
    GSC,
    HOLD,
    OVERFLOW,
    Trial,
    count,
    edges_after_off,
    enabling,
    force_power,
    is_on,
    net,
    powered,
)
from .test_hard_times import damaged

pytestmark = [pytest.mark.system, pytest.mark.timeout(900)]

POLICIES = ("never", "halt", "rest")
DRIVERS = ("A4988", "DM542", "L297")
ON = {"enable": True, "driver": "A4988", "pulses": False}
MOVING = ("cy525 long ramp", "gs-c200s to 10 k", "cy545 to 27 k", "mc1451a endless")
AGAIN = "I3\rPo\rS100\rT1000\rR255\r+%d\rPx\rE\r"  # of a GS-C
SLOW = "I3\rPo\rS50\rT300\rR90\r%sPx\rE\r"


def codes(drive):
    """The findings of a drive."""
    return [trouble.partition(":")[0] for trouble in drive.troubles]


# ------------------------------------------------------------------------------------------------ the level of ENABLE
MODES = {  # options of a drive, and whether STEP has edges
    "dry": ({"pulses": False}, False),
    "pulses": ({"pulses": True}, True),
    "enabled": ({"pulses": False, "enable": True}, True),
}
STAGES = (  # what comes, and under which policies the driver of an enabled drive is on behind it
    ("opened", POLICIES),
    ("in motion", POLICIES),
    ("at rest for 300 ms", ("never", "halt")),
    ("in motion again", POLICIES),
    ("stopped, on its way down", POLICIES),
    ("halted for 300 ms", ("never",)),
    ("clear", ("never",)),
    ("emergency stop in motion", ()),
    ("clear, contact open", ()),
    ("clear, contact closed", ()),
    ("emergency stop at rest", ()),
    ("clear homing", POLICIES),
    ("host silent for 1 s", ("never",)),
    ("closed", ("never",)),
)


def to_stage(trial, stage):
    """Let the next stage come."""
    drive, line = trial.drive, trial.line
    if stage == "opened":
        drive.open()
    elif stage == "in motion" or stage == "in motion again":
        trial.say(AGAIN % 4000, "350 ms")
    elif stage == "at rest for 300 ms":
        drive.run("1100 ms")
    elif stage.startswith("stopped"):
        drive.stop()
        drive.run("15 ms")
    elif stage == "halted for 300 ms":
        drive.run("700 ms")
        assert drive.state == "halted"
    elif stage == "clear":
        drive.clear()
    elif stage.startswith("emergency"):
        if stage.endswith("motion"):
            trial.say(AGAIN % 4000, "350 ms")
        line.set_input(ESTOP, 1)
        drive.run("200 ms")
        assert drive.state == "halted"
    elif stage.endswith("contact open"):
        with pytest.raises(UsageError, match="emergency stop is active"):
            drive.clear()
    elif stage.startswith("clear"):
        line.set_input(ESTOP, 0)
        drive.run("20 ms")
        drive.clear(homing="homing" in stage)
    elif stage.startswith("host silent"):
        line.stop_host(1000)
    else:
        drive.close()


@pytest.mark.parametrize("policy", POLICIES)
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("driver", few((None, "DM542", "L297", "A4988"), 2))
def test_d11_has_no_level_without_a_driver_and_the_one_without_current_in_every_state(emulator, driver, mode, policy):
    options, pulses = MODES[mode]
    if driver is None and mode == "enabled":
        with pytest.raises(UsageError, match="enable needs the name of the driver"):
            Trial(emulator, "gs-c200s", GSC, "I3\r", driver=None, **options)
        return
    trial = Trial(
        emulator, "gs-c200s", GSC, "I3\r", driver=driver, inputs={"A5": "estop"}, enable_off=policy,
        enable_hold="100 ms", **options,
    )  # fmt: skip
    board, made = trial.board, 0
    assert not board.enable
    for stage, policies in STAGES:
        to_stage(trial, stage)
        level = board.enable[-1][1] if board.enable else None
        if driver is None:
            assert level is None and not board.enable, stage
            continue
        disabling = 1 - enabling(driver)
        on = mode == "enabled" and policy in policies
        assert level == (1 - disabling if on else disabling), (stage, board.enable)
        if mode != "enabled":
            assert {level for _, level in board.enable} == {disabling}
        if "motion" in stage:
            assert not pulses or len(board.rises) > made
            made = len(board.rises)
    assert bool(board.rises) is pulses
    assert abs(count(trial.line)) > 1000, "the count goes on without edges"


@pytest.mark.parametrize("hold", few(["0 s", "300 ms", "1 s", "1200 ms"], 2))
@pytest.mark.parametrize("policy", POLICIES)
def test_a_host_that_lives_is_not_taken_for_a_silent_one_at_rest(emulator, policy, hold):
    options = {**ON, "enable_off": policy, "enable_hold": hold}
    trial = Trial(emulator, "gs-c200s", GSC, AGAIN % 400, **options)
    board = trial.board
    with trial.drive as drive:
        for steps in (400, 440, 480):
            drive.run("3 s")
            assert is_on(board, "A4988") is (policy != "rest")
            assert drive.state == "ok" and not drive.troubles, drive.troubles
            assert net(board) == trial.x.position == steps and drive.power.known
            trial.say("Po\r+40\rE\r")
        drive.run("1 s")
        stretches = [*powered(board, "A4988")]
        assert all(any(since < tick < until for since, until in stretches) for tick in board.rises), "without current"
    assert len(stretches) >= 4 if policy == "rest" else len(stretches) == 1


# -------------------------------------------------------------------------------------------------- ways to be stopped
def ended(trial, how, ms):
    """Begin a session, and end it after so many ms in some way."""
    drive, line = trial.drive, trial.line
    try:
        with drive:
            drive.run(f"{round(ms * 1000)} us")
            if how == "exception":
                raise ZeroDivisionError
            if how == "SIGINT":
                line.interrupt_at = line.now
                drive.run("1 s")
            if how == "stop":
                drive.stop()
    except (ZeroDivisionError, KeyboardInterrupt):
        assert how in ("exception", "SIGINT")
    assert drive.state == "closed" and line.closed


def agreed(trial):
    """Return the place of the motor, which count, drive and register have as well."""
    place = net(trial.board)
    assert count(trial.line) == trial.drive.count == place
    if trial.x.sheet.part != "mc1451a":  # its supply has stopped it: it has forgotten
        assert trial.x.position == place
    return place


@members("seeds", 2, 200)
@pytest.mark.parametrize("how", ["close", "exception", "SIGINT", "stop"])
def test_the_current_goes_off_when_the_motor_rests_and_no_edge_comes_after(emulator, how, seeds):
    worst = 0
    for seed in seeds:
        rnd = Random(f"{how} {seed}")
        policy, name = POLICIES[seed % 3], MOVING[seed % 4]
        trial = Trial(emulator, *SCRIPTS[name][:3], seed=seed, enable_off=policy, start_stop=30_000, **ON)
        ended(trial, how, rnd.uniform(200, 800))
        board = trial.board
        trial.line.stop_host(1500)
        assert board.rises
        assert is_on(board, "A4988") is (policy == "never")
        agreed(trial)
        if policy != "never":
            ((_, went),) = powered(board, "A4988")
            assert not edges_after_off(board, "A4988")
            late = went - board.rises[-1]
            worst = max(worst, late)
            assert 0 < late < HZ // 10, (seed, late / HZ)
    print(f"{how}: ENABLE off at most {worst / HZ * 1000:.1f} ms after the last edge")


@members("seeds", 3, 200)
def test_a_host_that_is_killed_leaves_the_current_to_the_policy(emulator, seeds):
    hold = HZ * 300 // 1000 // OVERFLOW * OVERFLOW
    for seed in seeds:
        rnd = Random(f"killed {seed}")
        name, policy = MOVING[seed % 4], POLICIES[seed % 3]
        trial = Trial(
            emulator, *SCRIPTS[name][:3], seed=seed, enable_off=policy, enable_hold="300 ms", start_stop=3_000, **ON
        )
        trial.drive.open()
        trial.drive.run(f"{rnd.randrange(250_000, 800_000)} us")
        trial.line.stop_host(2_000)
        board = trial.board
        halted = events(trial.line)[-1]
        assert halted.kind == Happening.HALTED and said(trial.line).state == BoardState.HALT
        assert count(trial.line) == net(board)
        assert is_on(board, "A4988") is (policy == "never")
        if policy != "never":
            ((_, went),) = powered(board, "A4988")
            assert not edges_after_off(board, "A4988")
            assert hold - OVERFLOW <= went - board.rises[-1] <= hold + 3 * OVERFLOW, (seed, went - board.rises[-1])


# ----------------------------------------------------------------------------------------------- an open emergency stop
class Session:
    """A user who does things in any order, on a board whose emergency stop opens and closes."""

    ACTS = (
        "open contact", "close contact", "close contact", "clear", "clear homed", "clear homing", "start", "start",
        "outputs", "stop", "end", "begin", "begin", "past the host", "wait",
    )  # fmt: skip

    def __init__(self, emulator, seed):
        self.emulator, self.seed = emulator, seed
        self.random = Random(f"session {seed}")
        self.driver, self.policy = self.random.choice(DRIVERS), self.random.choice(POLICIES)
        self.line, self.trial = None, None
        self.opened = [(0, 0)]  # ticks at which the contact opened, and closed: 0, not yet

    @property
    def is_begun(self):
        """Whether a session goes on."""
        return self.trial is not None and self.trial.drive.state != "closed"

    def act(self, act):
        """Do something."""
        drive = None if self.trial is None else self.trial.drive
        if act == "begin" and not self.is_begun:
            self.trial = Trial(
                self.emulator, "gs-c200s", GSC, "I3\r", seed=self.seed, line=self.line, inputs={"A5": "estop"},
                enable=True, driver=self.driver, pulses=False, enable_off=self.policy, enable_hold="50 ms",
            )  # fmt: skip
            if self.line is None:  # which closes its contact: 0, at power-up
                self.line = self.trial.line
                self.opened = []
            self.trial.drive.open()
        elif act in ("open contact", "close contact") and self.line is not None:
            level = int(act == "open contact")
            if self.line.levels[ESTOP] != level:
                tick = self.line.set_input(ESTOP, level, self.random.randrange(40, 4_000))
                if level:
                    self.opened.append((tick, 0))
                else:
                    self.opened[-1] = self.opened[-1][0], tick
        elif act == "past the host" and self.line is not None:
            if not self.is_begun:
                force_power(self.line)
        elif self.is_begun:
            if act == "end":
                drive.close()
            elif act.startswith("clear"):
                drive.clear(homed="homed" in act, homing="homing" in act)
            elif act == "start":
                self.trial.say(AGAIN % self.random.choice((40, 4000)))
            elif act == "outputs":
                drive._path.link.outputs(ENABLE, ENABLE)
            elif act == "stop":
                drive.stop(at_once=self.random.random() < 0.5)
        if self.line is not None:
            ms = self.random.uniform(1, 150)
            if self.is_begun:
                drive = self.trial.drive
                drive.run(f"{round(ms * 1000)} us")
            else:
                self.line.stop_host(ms)

    def live(self, acts):
        """Do so many things; what is refused is refused."""
        for act in ("begin", *self.random.choices(self.ACTS, k=acts)):
            with suppress(UsageError):
                self.act(act)
        if self.is_begun:
            self.trial.drive.close()


@members("seeds", 20, 1000, 50)
def test_the_driver_is_never_on_while_an_emergency_stop_is_open(emulator, seeds):
    on = opened = 0
    for seed in seeds:
        session = Session(emulator, seed)
        session.live(12)
        board = session.line.board
        stretches = [*powered(board, session.driver)]
        on += len(stretches)
        for start, end in session.opened:
            opened += 1
            end = end or board.now
            for since, until in stretches:
                assert until <= start + AT_ONCE_TICKS or since >= end, (seed, start, end, since, until)
        last = stretches[-1][1] if stretches else 0
        assert is_on(board, session.driver) is (last > board.now)
    assert on > len(seeds) / 2 and opened > len(seeds) / 3, "sessions that tried nothing"
    print(f"{len(seeds)} sessions: driver on {on} times, contact open {opened} times")


# ----------------------------------------------------------------------------------------------------------- homing
HOME, END = range(-240, -220), 60  # where switches are closed


@pytest.mark.parametrize("inverted", [False, True])
def test_a_module_homes_at_the_switch_of_a_machine_that_its_own_pins_would_move(emulator, tmp_path, inverted):
    trial = Trial(
        emulator, "gs-c200s", GSC, SLOW % "", folder=tmp_path, inputs={"A0": "eot", "A1": "home"}, start_stop=30_000,
        invert_dir=inverted,
    )  # fmt: skip
    way = -1 if inverted else 1  # how the machine is wired

    def switches(place):
        place *= way
        return {0: int(place < END), 1: int(place not in HOME)}

    trial.line.switches = switches
    with trial.drive as drive:
        drive.run("250 ms")
        trial.say("H\r")
        drive.run("3 s")
        place = way * trial.line.place
        assert trial.say("F\rV1\r", "50 ms").replace(b"Y", b"") == b"R\rV+0\r"
        assert not trial.x.motor.homing and abs(place - (HOME.stop - 1)) <= 12
        assert drive.state == "ok" and not drive.troubles, drive.troubles
        trial.say("Po\r+30\rE\r", "700 ms")
        assert way * trial.line.place == place + 30 and trial.x.position == 30


# ----------------------------------------------------------------------------------------------------------- holds
HELD = {  # part: options, what its host sends, pin, level that holds, steps
    "gs-c200s": (GSC, SLOW % "+3000\r", "enable", 0, 3000),
    "cy525": ({}, "A 0\rF 40\rR 75\rS 200\rZ 1\rN 3000\rG\r", "step_inhibit", 1, 3000),
}
IN_FULL = 3  # seconds of a hold that are emulated in full; of more, 10 ms of 94, the rest are leaps of both clocks


def hold_for(trial, seconds, full):
    """Let so many seconds pass; not in full: leaps of whole overflows, between which all goes on."""
    drive, line = trial.drive, trial.line
    end = line.now + round(seconds * 1e9)
    while line.now < end:
        if full or end - line.now < 200_000_000:
            drive.run(f"{max(min(end - line.now, 100_000_000), 1000)} ns")
        else:
            line.leap(20)
            drive.run("10 ms")


@pytest.mark.parametrize("part", HELD)
@pytest.mark.parametrize(
    "seconds, full",
    [
        (1, True),
        (136, False),
        *(
            pytest.param(seconds, full, marks=pytest.mark.long)
            for seconds, full in [
                *((seconds, False) for seconds in (100, 133, 200, 268, 269, 420, 1000)),
                (100, True),
                (136, True),
            ]
        ),
    ],
)
def test_a_paused_motor_continues_when_it_is_released(emulator, tmp_path, part, seconds, full):
    chip, text, pin, level, steps = HELD[part]
    trial = Trial(emulator, part, chip, text, folder=tmp_path, inputs={"A0": pin}, start_stop=30_000)
    board, line = trial.board, trial.line
    line.set_input(HOLD, 1 - level)
    with trial.drive as drive:
        drive.run(f"{trial.random.randrange(380_000, 480_000)} us")
        held = line.set_input(HOLD, level)
        drive.run("300 ms")
        stood = net(board)
        assert 0 < stood < steps and sum(tick > held for tick in board.rises) <= 1
        for _ in range(3):
            hold_for(trial, seconds / 3, full)
            assert not trial.x.idle and trial.x.position == stood == net(board) == count(line)
            if part == "gs-c200s":
                assert trial.say("F\r", "30 ms") == b"B\r" and trial.say("V1\r", "30 ms") == b"B\r"
        made, released = len(board.rises), line.set_input(HOLD, 1 - level)
        drive.run("400 ms")
        assert len(board.rises) > made
        late = (board.rises[made] - released) / HZ
        assert 0 < late < drive._state.horizon / HZ + 0.02, late
        drive.run("4 s")
        assert drive.state == "ok" and all(code == "position-taken-over" for code in codes(drive)), drive.troubles
        assert net(board) == len(board.rises) == trial.x.position == count(line)
        assert abs(net(board) - steps) <= len(drive.troubles) and not trial.x.motor.moving
        if part == "gs-c200s":
            assert not drive.troubles
            assert trial.say("F\r", "30 ms") == b"R\r" and trial.say("V1\r", "30 ms") == b"V+%d\r" % steps
    print(f"{part} held {seconds} s: first step {late * 1000:.1f} ms after the release")


# ----------------------------------------------------------------------------------------------------------- sleeps
SLEEPS = (200, 134, 268, 269, 140, 50, 100, 260, 10, 400, 1000)  # s; ticks wrap at 268.4


@pytest.mark.parametrize("seconds", few(SLEEPS, 3))
@pytest.mark.parametrize("options", [{}, {**ON, "enable_hold": "250 s"}], ids=["pulses", "enabled"])
def test_a_computer_that_slept_at_rest_drives_on(emulator, seconds, options):
    trial = Trial(emulator, "gs-c200s", GSC, AGAIN % 400, **options)
    with trial.drive as drive:
        drive.run("800 ms")
        assert net(trial.board) == 400
        trial.line.sleep(seconds, emulated=0.3)
        before = len(trial.board.rises)
        drive.run("1 s")
        if options and seconds > 250:  # the board has switched its driver off, for its host was silent
            assert drive.state == "halted" and codes(drive) == ["driver-off"]
            assert not is_on(trial.board, "A4988") and not drive.power.known
            drive.clear(homed=True)
            drive.run("20 ms")
        assert drive.state == "ok" and codes(drive) == ["driver-off"] * (bool(options) and seconds > 250)
        sent = trial.line.tick(trial.line.now)
        trial.say("Po\r+400\rE\r", "900 ms")
        assert trial.board.rises[before] - sent < HZ * 4 // 10
        assert net(trial.board) == trial.x.position == count(trial.line) == 800


@members("seeds", 2, 20)
@pytest.mark.parametrize("seconds", few(SLEEPS, 3))
def test_a_computer_that_slept_in_a_motion_reports_it_and_the_count_is_right(emulator, seconds, seeds):
    for seed in seeds:
        rnd = Random(f"slept {seconds} {seed}")
        name = ("cy525 long ramp", "gs-c200s to 10 k")[seed % 2]
        trial = Trial(emulator, *SCRIPTS[name][:3], seed=seed)
        with trial.drive as drive:
            drive.run(f"{rnd.randrange(250_000, 600_000)} us")
            due, _ = wanted(drive)
            trial.line.sleep(seconds, emulated=3)
            drive.run("2 s")
            assert drive.state == "halted" and {"underrun", "computer-slept"} & set(codes(drive)), drive.troubles
            agreed(trial)
            made = np.array(trial.board.rises)
            assert not trial.x.motor.moving
            until = events(trial.line)[1]  # BOOT came first
            assert until.kind == Happening.UNDERRUN
            followed = made[made <= until.tick]
            assert np.abs(followed - due[: len(followed)]).max() <= WITHIN_TICKS
            drive.clear()
            drive.run("100 ms")
            assert drive.state == "ok" and len(trial.board.rises) == len(made)


# ----------------------------------------------------------------------------------------------------------- damage
def harm(emulator, percent, name, seeds):
    """Move on a line that damages so many bytes; check that nothing is made up, and nothing lost in silence."""
    found = {"all": 0, "halted": 0, "no board": 0}
    for seed in seeds:
        script = SCRIPTS.get(name, ("cy525", {}, "A 0\rF 10\rR 100\rS 200\rZ 1\rN 500\rG\r"))
        trial = Trial(emulator, *script[:3], seed=seed, horizon="300 ms")
        line, drive = trial.line, trial.drive
        if seed % 2:
            drive.open()
        line.damage = damaged(f"{percent} {seed}", percent / 100)
        try:
            if drive.state == "closed":
                drive.open()
        except UsageError as error:
            found["no board"] += 1
            assert not trial.board.rises and "board" in str(error)
            continue
        drive.run("3 s")
        line.damage = lambda data: data
        drive.run("700 ms")
        made, place = np.array(trial.board.rises), net(trial.board)
        assert count(line) == drive.count == place
        assert not trial.x.motor.moving and trial.x.position == place, drive.troubles
        if drive.state == "ok":
            found["all"] += 1
            assert place == trial.x.travel == len(made) and set(codes(drive)) <= {"late-start"}
        else:
            found["halted"] += 1
            assert drive.state == "halted" and set(codes(drive)) & {"underrun", "not-started", "board-silent"}
        due, _ = wanted(drive)
        stops = [event.tick for event in events(line) if event.kind == Happening.UNDERRUN]
        followed = made[made <= min([*stops, 1 << 62])]
        if len(followed):
            assert np.abs(followed - due[: len(followed)]).max() <= WITHIN_TICKS, "an edge that the model did not make"
        drive.close()
    print(f"{name}, {percent} %: {found}")


@members("seeds", 2, 20)
@pytest.mark.parametrize("name", ["cy525 five hundred", "gs-c200s to 10 k"])
@pytest.mark.parametrize("percent", [1, 2, 5, 10])
def test_on_a_damaged_line_all_steps_are_made_or_a_finding_reports_the_missing_ones(emulator, percent, name, seeds):
    harm(emulator, percent, name, seeds)


@pytest.mark.parametrize("seed", few([5, 8, 18], 1))
def test_a_board_that_was_silent_before_the_start_of_a_motion_has_its_count_taken_over(emulator, seed):
    harm(emulator, 5, "cy525 five hundred", [seed])
