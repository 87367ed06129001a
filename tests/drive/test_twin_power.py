"""The driver's current in the twin: each rule of ENABLE, of lamps and of dry runs by exact ticks."""

from __future__ import annotations

from dataclasses import replace

import pytest

from slewline.drive.board import wire
from slewline.drive.board.records import PAUSE, REST, Record
from slewline.drive.board.wire import (
    ENABLE,
    Answer,
    BoardState,
    DriverFlag,
    EnableOff,
    FrameKind,
    FrameResult,
    PowerFlag,
)

from .test_twin import BRAKE as BRAKE_REFLEX
from .test_twin import END, ESTOP, FULL, Rig

IDLE, RUN, BRAKE, HALT, _ = BoardState
TAKEN, WRONG_STATE = FrameResult.TAKEN, FrameResult.WRONG_STATE
ENERGISED, IN_ESTOP, UNSURE, LOCKED = PowerFlag
DRY_ENABLE = DriverFlag.DRY | DriverFlag.ENABLE
LOW = 2  # of the polarity
HOLD = 65_536  # ticks
OPENS = 1  # the input of the emergency stop
REFLEX = (BRAKE_REFLEX, ESTOP)


def switch(rig: Rig, on: bool, tick: int) -> Answer:
    """Send OUTPUTS with ENABLE."""
    return rig.tell(FrameKind.OUTPUTS, bytes((ENABLE, ENABLE * on)), tick)


def reset(rig: Rig, tick: int, *, known: bool = False, power: bool = False) -> Answer:
    """Send RESET without a position."""
    return rig.tell(FrameKind.RESET, wire.reset_payload(None, known=known, power=power), tick)


def energised(state: BoardState, **config: object) -> Rig:
    """Return a twin whose driver has been switched on at tick 200, in a state at tick 20,000."""
    rig = Rig(reflex=REFLEX, **config).ready()  # type: ignore[arg-type]
    assert switch(rig, True, 200).result == TAKEN
    if state != IDLE:
        rig.tell(FrameKind.TAIL, wire.tail_payload(0, [(30_000 << 8, 60_000)]), 300)
        rig.play(Record(0, 60_000, 2_000), start=5_000)
    if state in (BRAKE, HALT):
        rig.tell(FrameKind.STOP, bytes((state == BRAKE,)), 19_000)
    rig.twin.run(20_000)
    assert rig.twin.state == state
    return rig


@pytest.mark.parametrize("driver", range(4))
@pytest.mark.parametrize("polarity", [1, 1 | LOW])
def test_only_a_driver_that_is_known_is_switched_on(driver: int, polarity: int) -> None:
    rig = Rig(driver=driver, polarity=polarity).ready()
    off = polarity >> 1
    known = [(100, off)] if driver & DriverFlag.ENABLE else []
    assert rig.twin.enable == known
    answer = switch(rig, True, 200)
    if driver == DriverFlag.ENABLE:
        assert answer.result == TAKEN and answer.flags == ENERGISED
        assert rig.twin.enable == [*known, (200, 1 - off)]
    else:
        assert answer.result == WRONG_STATE and answer.flags == 0 and rig.twin.enable == known


@pytest.mark.parametrize("state", [RUN, BRAKE, HALT])
def test_the_driver_is_switched_on_at_rest_only(state: BoardState) -> None:
    rig = Rig(reflex=REFLEX).ready()
    rig.tell(FrameKind.TAIL, wire.tail_payload(0, [(30_000 << 8, 60_000)]), 300)
    rig.play(Record(0, 60_000, 2_000), start=5_000)
    if state != RUN:
        rig.tell(FrameKind.STOP, bytes((state == BRAKE,)), 19_000)
    answer = switch(rig, True, 20_000)
    assert (answer.state, answer.result, answer.flags) == (state, WRONG_STATE, UNSURE)  # steps without current


@pytest.mark.parametrize("state", [IDLE, RUN, BRAKE, HALT])
def test_the_host_switches_the_driver_off_where_no_steps_are_made(state: BoardState) -> None:
    rig = energised(state)
    answer = switch(rig, False, 20_000)
    stays = state in (RUN, BRAKE)
    assert answer.result == (WRONG_STATE if stays else TAKEN)
    assert answer.flags == (ENERGISED if stays else 0)  # no lock: it was the host
    assert rig.twin.enable[1:] == [(200, 1), *([] if stays else [(20_000, 0)])]


@pytest.mark.parametrize(
    ("known", "power", "flags"), [(False, False, UNSURE | LOCKED), (True, False, 0), (False, True, UNSURE)]
)
def test_a_driver_that_an_emergency_stop_has_switched_off_waits_for_reset(known: bool, power: bool, flags: int) -> None:
    rig = energised(IDLE)
    rig.twin.set_input(OPENS, 1, 21_000)
    assert rig.twin.enable[-1] == (21_000, 0)
    assert rig.tell(FrameKind.ASK, tick=21_001).flags == IN_ESTOP | UNSURE | LOCKED
    assert reset(rig, 21_100, known=known, power=power).result == WRONG_STATE
    rig.twin.set_input(OPENS, 0, 22_000)
    assert switch(rig, True, 22_100).result == WRONG_STATE  # in HALT
    assert reset(rig, 22_200, known=known, power=power).flags == flags
    answer = switch(rig, True, 22_300)
    assert answer.result == (WRONG_STATE if flags & LOCKED else TAKEN)
    assert rig.twin.enable[-1] == ((21_000, 0) if flags & LOCKED else (22_300, 1))


def test_an_open_emergency_stop_lets_nothing_be_switched_on() -> None:
    rig = Rig().ready()
    rig.twin.set_input(OPENS, 1, 150)  # it has no reflex yet
    with_stop = replace(rig.config, reflex=(0, ESTOP, 0, 0, 0, 0))
    assert rig.tell(FrameKind.CONFIG, with_stop.pack(), 200).state == HALT
    assert switch(rig, True, 300).result == WRONG_STATE
    assert rig.tell(FrameKind.ASK, tick=301).flags == IN_ESTOP  # the driver was off: nothing is locked


def test_after_power_up_the_driver_waits_for_reset() -> None:
    rig = Rig()
    assert rig.tell(FrameKind.CONFIG, rig.config.pack(), 100).flags == LOCKED
    assert reset(rig, 200).flags == LOCKED
    assert switch(rig, True, 300).result == WRONG_STATE
    assert reset(rig, 400, power=True).flags == 0
    assert switch(rig, True, 500).result == TAKEN


@pytest.mark.parametrize("state", [IDLE, RUN, BRAKE, HALT])
def test_an_emergency_stop_takes_the_current_in_every_state(state: BoardState) -> None:
    rig = energised(state, enable_off=EnableOff.NEVER)
    rig.twin.set_input(OPENS, 1, 20_500)
    assert rig.twin.enable[1:] == [(200, 1), (20_500, 0)]
    answer = rig.tell(FrameKind.ASK, tick=20_600)
    assert (answer.state, answer.flags) == (HALT, IN_ESTOP | UNSURE | LOCKED)


@pytest.mark.parametrize(
    ("changed", "level"),
    [
        ({"driver": 0}, None),
        ({"driver": DRY_ENABLE}, 0),
        ({"polarity": 1 | LOW}, "off"),  # by the level that it has
        ({"polarity": 0}, "on"),
        ({"enable_off": EnableOff.REST, "start_stop": 77}, "on"),
    ],
)
@pytest.mark.parametrize("state", [IDLE, HALT])
def test_another_driver_is_not_switched_on(state: BoardState, changed: dict[str, int], level: object) -> None:
    rig = energised(state)
    answer = rig.tell(FrameKind.CONFIG, replace(rig.config, **changed).pack(), 20_000)
    assert answer.flags == (ENERGISED if level == "on" else 0)
    assert rig.twin.enable[2:] == ([] if level in ("on", "off") else [(20_000, level)])


def test_a_config_under_an_open_emergency_stop_halts() -> None:
    rig = energised(IDLE)
    rig.twin.set_input(2, 1, 20_000)
    opened = replace(rig.config, reflex=(0, ESTOP, ESTOP, 0, 0, 0))
    answer = rig.tell(FrameKind.CONFIG, opened.pack(), 20_100)
    assert (answer.state, answer.flags) == (HALT, IN_ESTOP | UNSURE | LOCKED)
    assert rig.twin.enable[-1] == (20_100, 0)


@pytest.mark.parametrize("policy", EnableOff)
@pytest.mark.parametrize("state", [IDLE, HALT])
@pytest.mark.parametrize("silent", [False, True])
def test_the_driver_goes_off_after_its_time(policy: EnableOff, state: BoardState, silent: bool) -> None:
    rig = energised(state, enable_off=policy, enable_hold=3, watchdog=2 * HOLD)
    rig.twin.look(20_000)
    for look in range(1, 12):
        if not silent:
            rig.tell(FrameKind.ASK, tick=look * HOLD)
        rig.twin.look(look * HOLD + 7)
    abandoned = state == HALT or silent
    switched = rig.twin.enable[2:]
    if policy == EnableOff.NEVER or (not abandoned and policy == EnableOff.HALT):
        assert switched == [] and not rig.twin.power.locked
        return
    # at rest, silence is noticed by the third look: the last frame came at tick 200
    begins = 3 if state == IDLE and policy == EnableOff.HALT else 1
    assert switched == [((begins + 2) * HOLD + 7, 0)]
    assert rig.twin.power.locked == rig.twin.power.unsure == abandoned


def test_the_time_counts_from_the_last_motion() -> None:
    rig = energised(IDLE, enable_off=EnableOff.REST, enable_hold=3)
    rig.twin.look(20_000)
    rig.twin.look(2 * HOLD)
    rig.play(Record(0, 2, 2_000), Record(PAUSE, 0, 9 * HOLD), END, start=2 * HOLD + 5_000, tick=2 * HOLD)
    for look in range(3, 12):
        rig.twin.look(look * HOLD)
        assert rig.twin.state == RUN and rig.twin.power.on
    for look in range(12, 15):
        rig.twin.look(look * HOLD)
    assert rig.twin.state == IDLE and rig.twin.enable[-1] == (14 * HOLD, 0)
    assert not rig.twin.power.locked and switch(rig, True, 15 * HOLD).result == TAKEN


def test_lamps_show_a_halt_and_the_current() -> None:
    rig = Rig(fault_output=1, power_output=3, reflex=REFLEX)
    rig.tell(FrameKind.CONFIG, rig.config.pack(), 100)
    reset(rig, 200, known=True)
    rig.tell(FrameKind.OUTPUTS, b"\x0f\x0f", 300)  # outputs 1 and 4 alone are the user's
    switch(rig, True, 400)
    rig.twin.set_input(OPENS, 1, 500)
    assert dict(rig.twin.outputs) == {100: 1, 200: 0, 300: 10, 400: 10 | ENABLE | 4, 500: 10 | 1}


def test_steps_of_a_dry_run_are_counted_and_move_no_pin() -> None:
    rig = Rig(driver=DRY_ENABLE, pattern=FULL).ready()
    rig.play(Record(0, 3, 1_000), Record(PAUSE | REST, 0, 500))
    rig.twin.run(20_000)
    assert rig.ticks() == [11_000, 12_000, 13_000] and rig.twin.position == 3
    assert rig.twin.pulses == [] and rig.twin.phases == []
    assert rig.tell(FrameKind.ASK, tick=20_000).flags == UNSURE
    assert rig.tell(FrameKind.CHECK, wire.check_payload(10, 1_000), 20_000).result == WRONG_STATE
    rig.tell(FrameKind.CONFIG, replace(rig.config, driver=DriverFlag.ENABLE).pack(), 21_000)
    rig.play(Record(0, 3, 1_000), Record(PAUSE | REST, 0, 500), start=30_000, tick=22_000)
    rig.twin.run(40_000)
    assert rig.twin.pulses == [31_000, 32_000, 33_000] and [tick for tick, _ in rig.twin.phases][-3:] == rig.twin.pulses


def test_no_self_test_while_the_driver_is_on() -> None:
    rig = energised(IDLE)
    assert rig.tell(FrameKind.CHECK, wire.check_payload(10, 1_000), 20_000).result == WRONG_STATE
    switch(rig, False, 20_100)
    assert rig.tell(FrameKind.CHECK, wire.check_payload(10, 1_000), 20_200).result == TAKEN
