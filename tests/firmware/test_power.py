"""ENABLE at the pin of the board: who switches the driver on and off, in which state, and when."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise, product
from random import Random

import pytest

from slewline.drive.board import wire
from slewline.drive.board.records import PAUSE, REST, Record
from slewline.drive.board.wire import (
    BoardState,
    DriverFlag,
    EnableOff,
    FrameKind,
    FrameResult,
    PowerFlag,
    Reflex,
)
from tests.ensembles import members

from .dialogue import LAMPS_WITHIN
from .talk import ESTOP_INPUT, HOLD, LIMIT_INPUT, LONG, TAKEN, Talk

pytestmark = pytest.mark.system

IDLE, RUN, BRAKE, HALT = BoardState.IDLE, BoardState.RUN, BoardState.BRAKE, BoardState.HALT
NEVER, AT_HALT, AT_REST = EnableOff
WRONG_STATE = FrameResult.WRONG_STATE
OFF_WITHIN = 1_600  # ticks from an edge of an emergency stop to D11: 100 us, behind a CONFIG; usually 20 us
HOLDS, WATCHDOG = 4, 100_000
LATER = 20_000  # ticks that the main loop may be late with what it does by time
LOW = 2  # of the polarity


def energised(emulator, state, **config):
    """A board whose driver is on, in some state."""
    talk = Talk(emulator, **config)
    assert talk.switch(True).result == TAKEN
    if state == IDLE:
        return talk
    if state == BRAKE:
        entries = [(20_000 << 8, 400)]
        assert talk.say(FrameKind.TAIL, wire.tail_payload(0, entries)).result == TAKEN
    assert talk.play([Record(0, 60_000, 8_000)]).result == TAKEN
    talk.board.run(talk.board.now + 60_000)
    if state in (BRAKE, HALT):
        talk.say(FrameKind.STOP, bytes((state == BRAKE,)))
        talk.board.run(talk.board.now + 10_000)
    assert talk.say(FrameKind.ASK).state == state
    return talk


# What happens, and what D11 does: "on" remains, "off" is the level without current, "none" is high impedance.  For each
# cause the states in which it does so; in the others the driver remains on.
def expected(state, cause, policy):
    """What D11 does, and whether the board is locked: worked out from the rules, not from the code."""
    moves = state in (RUN, BRAKE)
    if cause in ("on", "reset"):
        return "on", False
    if cause == "off":
        return ("on" if moves else "off"), False
    if cause == "emergency stop":
        return "off", True
    if cause == "time, and the host asks":
        if state in (HALT, BRAKE):  # the way down ends in HALT
            return ("on", False) if policy == NEVER else ("off", True)
        return ("off" if state == IDLE and policy == AT_REST else "on"), False
    if cause == "time, and the host is silent":  # a board that runs brakes, and halts
        return ("on", False) if policy == NEVER else ("off", True)
    if moves:  # CONFIG is refused
        return "on", False
    if cause == "CONFIG without ENABLE":
        return "none", False
    if cause == "CONFIG, emergency stop open":
        return "off", True
    return "off", False


CAUSES = [
    "on", "off", "reset", "emergency stop", "time, and the host asks", "time, and the host is silent",
    "CONFIG without ENABLE", "CONFIG with the other polarity", "CONFIG for a dry run", "CONFIG, emergency stop open",
]  # fmt: skip


def cause_it(talk, cause):
    """Let a cause come."""
    if cause in ("on", "off"):
        talk.switch(cause == "on")
    elif cause == "reset":
        talk.reset()
    elif cause == "emergency stop":
        talk.board.set_input(ESTOP_INPUT, 1, talk.board.now + 50)
    elif cause.startswith("time"):
        # a way down of 400 steps lasts 8 million ticks
        wait = 9_000_000 if talk.say(FrameKind.ASK).state == BRAKE else 0
        talk.pass_by(wait + 2 * WATCHDOG + (HOLDS + 3) * HOLD, silent="silent" in cause)
    else:
        config = {
            "CONFIG without ENABLE": {"driver": 0},
            "CONFIG with the other polarity": {"polarity": talk.config.polarity ^ LOW},
            "CONFIG for a dry run": {"driver": DriverFlag.ENABLE | DriverFlag.DRY},
            "CONFIG, emergency stop open": {"reflex": (Reflex.STOP, Reflex.ESTOP, Reflex.ESTOP, 0, 0, 0), "active": 59},
        }[cause]
        changed = replace(talk.config, **config)
        if talk.say(FrameKind.CONFIG, changed.pack()).result == TAKEN:
            talk.config = changed
    talk.board.run(talk.board.now + 10_000)


@pytest.mark.timeout(600)
@pytest.mark.parametrize("cause", CAUSES)
@pytest.mark.parametrize("state", [IDLE, RUN, BRAKE, HALT], ids=lambda each: each.name)
def test_causes_that_switch_the_driver_off_or_leave_it_on(emulator, state, cause):
    for policy, polarity in product(EnableOff, (1, 1 | LOW)):
        talk = energised(emulator, state, enable_off=policy, polarity=polarity, enable_hold=HOLDS, watchdog=WATCHDOG)
        on = 0 if polarity & LOW else 1
        assert talk.level == on
        cause_it(talk, cause)
        does, locks = expected(state, cause, policy)
        on = 0 if talk.config.polarity & LOW else 1
        assert talk.level == {"on": on, "off": 1 - on, "none": None}[does], (policy, polarity)
        answer = talk.say(FrameKind.ASK)
        assert bool(answer.flags & PowerFlag.ENERGISED) == (does == "on")
        assert bool(answer.flags & PowerFlag.LOCKED) == locks
        assert bool(answer.flags & PowerFlag.UNSURE) == locks
        if cause == "CONFIG, emergency stop open" and state == IDLE:
            assert answer.state == HALT and answer.flags & PowerFlag.ESTOP


@pytest.mark.parametrize("driver", range(4))
@pytest.mark.parametrize("polarity", [1, 1 | LOW])
def test_only_a_driver_that_is_known_is_switched_on_and_only_where_steps_are_real(emulator, driver, polarity):
    talk = Talk(emulator, driver=driver, polarity=polarity)
    off = 1 if polarity & LOW else 0
    assert talk.level == (off if driver & DriverFlag.ENABLE else None)
    answer = talk.switch(True)
    assert answer.result == (TAKEN if driver == DriverFlag.ENABLE else WRONG_STATE)
    on = driver == DriverFlag.ENABLE
    assert talk.level == (1 - off if on else off if driver & DriverFlag.ENABLE else None)
    assert len(talk.board.enable) == bool(driver & DriverFlag.ENABLE) + on  # and no other level even for a moment


@pytest.mark.parametrize("state", [RUN, BRAKE, HALT], ids=lambda each: each.name)
def test_the_driver_is_switched_on_only_at_rest(emulator, state):
    talk = Talk(emulator)
    talk.play([Record(0, 60_000, 8_000)])
    talk.board.run(talk.board.now + 60_000)
    assert talk.say(FrameKind.ASK).flags & PowerFlag.UNSURE  # steps without current
    if state == BRAKE:
        talk.say(FrameKind.TAIL, wire.tail_payload(0, [(20_000 << 8, 400)]))
    if state != RUN:
        talk.say(FrameKind.STOP, bytes((state == BRAKE,)))
    answer = talk.switch(True)
    assert (answer.state, answer.result) == (state, WRONG_STATE) and talk.level == 0
    assert len(talk.board.enable) == 1


@pytest.mark.parametrize("known, power", [(False, False), (True, False), (False, True)])
def test_only_a_word_of_the_host_switches_the_driver_on_again(emulator, known, power):
    talk = energised(emulator, IDLE)
    talk.board.set_input(ESTOP_INPUT, 1, talk.board.now + 10)
    talk.board.run(talk.board.now + 10_000)
    assert talk.reset(known=known, power=power).result == WRONG_STATE  # it is open
    talk.board.set_input(ESTOP_INPUT, 0, talk.board.now + 10)
    talk.board.run(talk.board.now + 10_000)
    assert talk.switch(True).result == WRONG_STATE  # in HALT
    answer = talk.reset(known=known, power=power)
    assert answer.result == TAKEN and bool(answer.flags & PowerFlag.UNSURE) != known
    assert talk.level == 0
    assert talk.switch(True).result == (TAKEN if known or power else WRONG_STATE)
    assert talk.level == (known or power)


def test_after_power_up_the_driver_waits_for_a_word_of_the_host(emulator):
    talk = Talk(emulator)
    talk.board.power_up()
    talk.board.run(5_000)
    talk.number = 0
    talk.say(FrameKind.CONFIG, talk.config.pack())
    talk.reset(known=False)
    assert talk.switch(True).result == WRONG_STATE and talk.level == 0


@members("seeds", 20, 400)
def test_enable_is_never_on_while_an_emergency_stop_is_open(emulator, seeds):
    was_on = 0
    for seed in seeds:
        random = Random(f"stop {seed}")
        talk = Talk(emulator, watchdog=random.choice((0, 200_000)), filter=random.choice((0, 15)))
        opened = [[0, False]]  # tick, and whether it is open
        for _ in range(40):
            if random.random() < 0.3:
                tick = talk.board.now + random.randrange(1, 9_000)
                opened.append([tick, not opened[-1][1]])
                talk.board.set_input(ESTOP_INPUT, opened[-1][1], tick)
            for number in (LIMIT_INPUT, 3, 4):
                if random.random() < 0.3:  # others bounce meanwhile
                    for at in range(random.randrange(20)):
                        talk.board.set_input(number, at & 1, talk.board.now + at * random.randrange(20, 300))
            what = random.random()
            if what < 0.4:
                talk.switch(True)
            elif what < 0.7:
                talk.reset(power=random.random() < 0.9)
            elif what < 0.8:
                talk.say(FrameKind.CONFIG, replace(talk.config, enable_off=random.randrange(3)).pack())
            else:
                moves = Record(0, random.randrange(1, 400), random.choice((400, 4_000)))
                talk.say(FrameKind.PUSH, moves.pack())
                talk.say(FrameKind.START, wire.start_payload(talk.board.now + 20_000))
            if what > 0.9:
                talk.say(FrameKind.STOP, b"\0")
            talk.board.run(max(talk.board.now, opened[-1][0]) + random.choice((10, 3_000)))
        opened.append([talk.board.now, False])
        lit = [*talk.board.enable, (talk.board.now, 0)]
        for (begin, level), (end, _) in pairwise(lit):
            was_on += level == 1
            for (since, is_open), (until, _) in pairwise(opened):
                if is_open and level == 1:
                    common = min(end, until) - max(begin, since)
                    assert common <= OFF_WITHIN, (seed, since, common)
    assert was_on > len(seeds)


@pytest.mark.parametrize("policy", EnableOff)
@pytest.mark.parametrize("silent", [False, True])
@pytest.mark.parametrize("hold", [0, 1, 7, 65_535])
def test_the_time_for_which_the_driver_remains_on(emulator, policy, silent, hold):
    """Up to 268 s, by a clock that jumps while the processor stands."""
    if policy == AT_REST:
        hold = max(hold, 4)  # or it would be off before the motion
    talk = energised(emulator, RUN, enable_off=policy, enable_hold=hold, watchdog=10 * HOLD)
    talk.say(FrameKind.STOP, b"\0")
    halted = talk.events[-1].tick
    while hold > 100 and (left := hold - (talk.board.now - halted) // HOLD - 2) > 0:
        talk.board.skip(min(left, 5_000))  # in pieces: each is one look of the main loop
        talk.board.run(talk.board.now + 2_000)
        if not silent:
            talk.say(FrameKind.ASK)
    assert talk.level == 1 or hold < 2
    talk.pass_by((hold % 100 + 6) * HOLD, silent=silent)
    if policy == NEVER:
        assert talk.level == 1
        return
    assert talk.level == 0
    off = talk.board.enable[-1][0]
    assert (hold - 1) * HOLD <= off - halted <= (hold + 1) * HOLD + LATER, (off - halted) / HOLD


@pytest.mark.parametrize("policy", EnableOff)
def test_silence_at_rest(emulator, policy):
    talk = energised(emulator, IDLE, enable_off=policy, enable_hold=HOLDS, watchdog=WATCHDOG)
    talk.pass_by(WATCHDOG + (HOLDS + 4) * HOLD)  # it is not silent
    assert talk.level == (policy != AT_REST)
    if policy == AT_REST:  # that was rest, and needs no word to be switched on again
        assert talk.switch(True).result == TAKEN
    heard = talk.answers[-1].tick
    talk.pass_by(WATCHDOG + (HOLDS + 4) * HOLD, silent=True)
    answer = talk.say(FrameKind.ASK)
    assert talk.level == (policy == NEVER) and answer.state == IDLE
    if policy == AT_HALT:
        off = talk.board.enable[-1][0] - heard - WATCHDOG
        assert (HOLDS - 1) * HOLD <= off <= (HOLDS + 1) * HOLD + LATER
        assert answer.flags & PowerFlag.LOCKED and talk.switch(True).result == WRONG_STATE
        assert talk.reset(known=False, power=True).result == TAKEN and talk.switch(True).result == TAKEN


def test_in_motion_no_time_takes_the_current_away(emulator):
    talk = energised(emulator, IDLE, enable_off=AT_REST, enable_hold=2)
    talk.play([Record(0, 60, LONG), Record(PAUSE, 0, 16 * HOLD), Record(PAUSE | REST, 0, 300)])
    talk.pass_by(60 * LONG + 8 * HOLD)
    assert talk.level == 1 and talk.say(FrameKind.ASK).state == RUN  # a pause is no rest
    talk.pass_by(12 * HOLD)
    assert talk.level == 0 and len(talk.board.rises) == 60


@pytest.mark.parametrize("driver", [DriverFlag.DRY, DriverFlag.DRY | DriverFlag.ENABLE, DriverFlag.ENABLE, 0])
@pytest.mark.parametrize("on", [False, True])
def test_no_self_test_moves_a_motor(emulator, driver, on):
    talk = Talk(emulator, driver=driver)
    talk.switch(on)
    is_on = on and driver == DriverFlag.ENABLE
    answer = talk.say(FrameKind.CHECK, wire.check_payload(20, 1_600))
    refused = is_on or bool(driver & DriverFlag.DRY)
    assert answer.result == (WRONG_STATE if refused else TAKEN)
    talk.board.run(talk.board.now + 100_000)
    assert len(talk.board.rises) == (0 if refused else 20)


# --------------------------------------------------------------------------------------------------------------- lamps
@pytest.mark.parametrize("fault, power", [(1, 2), (4, 3), (2, 2), (0, 1), (3, 0)])
def test_lamps_show_a_halt_and_the_current_whatever_the_host_sends_for_their_outputs(emulator, fault, power):
    talk = Talk(emulator, fault_output=fault, power_output=power)

    def lamps():
        talk.board.run(talk.board.now + LAMPS_WITHIN)
        return tuple(talk.output(number - 1) if number else None for number in (fault, power))

    def levels(is_halted, is_on):
        if fault == power:
            return (int(is_halted or is_on),) * 2
        return (is_halted if fault else None, is_on if power else None)

    free = next(number for number in range(4) if number + 1 not in (fault, power))
    assert lamps() == levels(0, 0)
    talk.say(FrameKind.OUTPUTS, b"\x0f\x0f")
    assert lamps() == levels(0, 0) and talk.output(free) == 1
    talk.switch(True)
    assert lamps() == levels(0, 1)
    talk.say(FrameKind.STOP, b"\0")
    talk.say(FrameKind.OUTPUTS, b"\x0f\x00")
    assert lamps() == levels(0, 1) and talk.output(free) == 0
    talk.board.set_input(ESTOP_INPUT, 1, talk.board.now + 10)
    assert lamps() == levels(1, 0)
    talk.board.set_input(ESTOP_INPUT, 0, talk.board.now + 10)
    assert lamps() == levels(1, 0)
    talk.reset()
    assert lamps() == levels(0, 0)
    talk.say(FrameKind.OUTPUTS, b"\x0f\x0f")
    talk.say(FrameKind.CONFIG, replace(talk.config, fault_output=0, power_output=0).pack())
    assert [talk.output(number) for number in range(4)] == [1, 1, 1, 1]  # the user's again


def test_lamps_are_soon_there_while_steps_are_fast(emulator):
    talk = energised(emulator, IDLE, fault_output=1, power_output=2)
    talk.play([Record(0, 20_000, 1_000)])
    tick = talk.board.now + 100_123
    talk.board.set_input(ESTOP_INPUT, 1, tick)
    talk.board.run(tick + LAMPS_WITHIN)
    lit = next(at for at, value in talk.board.outputs if at >= tick and value & 1)
    dark = next(at for at, value in talk.board.outputs if at >= tick and not value & 2)
    assert lit < tick + LAMPS_WITHIN and dark < tick + OFF_WITHIN
