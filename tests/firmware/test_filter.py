"""The filter of the inputs: short pulses are none, an edge is seen a little later, an emergency stop is not delayed."""

from __future__ import annotations

from random import Random

import pytest

from slewline.drive.board.records import Record
from slewline.drive.board.wire import BoardState, DriverFlag, FrameKind, Happening, Reflex
from tests.ensembles import members

from .talk import ESTOP_INPUT, LIMIT_INPUT, Talk

pytestmark = pytest.mark.system

US = 16  # ticks
LOOK = 7 * US  # of one look of the filter at most, with slow steps
SEEN = 60 * US  # without a filter, with slow steps
FAST_LOOK = 16 * US  # where steps are made at 40,000 a second meanwhile
OTHER = 2  # an input that reports its edges


def moving(emulator, looks, interval=8_000, **config):
    """A board that makes steps."""
    talk = Talk(
        emulator,
        filter=looks,
        reflex=(Reflex.STOP, Reflex.ESTOP, 0, Reflex.MARK, Reflex.BRAKE, 0),
        start_stop=16_000,
        **{"report": 1 << OTHER, **config},
    )
    talk.play(
        [Record(0, 60_000, 2_000), Record(0, 60_000, interval)] if interval < 1_000 else [Record(0, 60_000, interval)]
    )
    talk.board.run(talk.board.now + 80_000)
    return talk


def pulse(talk, number, tick, width):
    """Open an input for a moment."""
    talk.board.set_input(number, 1, tick)
    talk.board.set_input(number, 0, tick + width)


@members("seeds", 3, 100)
def test_pulses_of_2_to_20_us_are_ignored(emulator, seeds):
    for seed in seeds:
        random = Random(f"pulse {seed}")
        talk = moving(emulator, 8, driver=random.choice((DriverFlag.ENABLE, DriverFlag.DRY)))
        for width in range(2 * US, 20 * US + 1, 9):
            tick = talk.board.now + random.randrange(100, 9_000)
            pulse(talk, random.choice((LIMIT_INPUT, OTHER, 3, 4)), tick, width)
            talk.board.run(tick + 5_000)
        answer = talk.say(FrameKind.ASK)
        assert talk.events == [] and answer.state == BoardState.RUN and answer.inputs == 0


def test_without_a_filter_a_pulse_of_20_us_is_seen(emulator):
    talk = moving(emulator, 0)
    pulse(talk, LIMIT_INPUT, talk.board.now + 1_234, 20 * US)
    talk.board.run(talk.board.now + 20_000)
    assert [event.kind for event in talk.events] == [Happening.STOPPED]


@pytest.mark.parametrize("looks", [0, 1, 8, 15])
@members("seeds", 6, 200)
def test_an_edge_is_seen_later_by_the_filter_and_no_more(emulator, looks, seeds):
    later = []
    for seed in seeds:
        random = Random(f"edge {looks} {seed}")
        interval, look = random.choice(((8_000, LOOK), (400, FAST_LOOK)))
        talk = moving(emulator, looks, interval)
        tick = talk.board.now + random.randrange(300, 9_000)
        talk.board.set_input(LIMIT_INPUT, 1, tick)
        talk.board.run(tick + 20_000)
        (stop,) = talk.events
        assert stop.kind == Happening.STOPPED and stop.position == len(talk.board.rises)
        later.append(stop.tick - tick)
        assert looks * 4 * US <= later[-1] <= SEEN + looks * look, (seed, interval)
        made = sum(each > tick for each in talk.board.rises)
        assert made <= 1 + later[-1] // interval


def test_an_input_that_bounces_counts_when_it_is_quiet(emulator):
    talk = moving(emulator, 8)
    tick = talk.board.now + 1_000
    for at in range(21):  # ten pulses of 10 us, then it remains open
        talk.board.set_input(LIMIT_INPUT, 1 - at % 2, tick + at * 10 * US)
    talk.board.run(tick + 20_000)
    (stop,) = talk.events
    assert 200 * US <= stop.tick - tick <= 200 * US + 2 * (SEEN + 8 * LOOK)


@pytest.mark.parametrize("looks", [0, 8, 15])
@members("seeds", 8, 400)
def test_an_emergency_stop_is_not_delayed_by_it(emulator, looks, seeds):
    for seed in seeds:
        random = Random(f"stop {looks} {seed}")
        # Without a filter the events of the one that bounces would be more than the board keeps.
        talk = moving(emulator, looks, report=(1 << OTHER) * bool(looks))
        tick = talk.board.now + 2_000 + random.randrange(9_000)
        # The other bounces before it, in the same instant, or after it.
        begin, apart = tick - random.choice((0, 0, 1, 30, 200, 900)), random.choice((25, 90, 400))
        for at in range(random.choice((1, 2, 9, 40))):
            talk.board.set_input(OTHER, 1 - at % 2, begin + at * apart)
        talk.board.set_input(ESTOP_INPUT, 1, tick)
        talk.board.run(tick + 60_000)
        stop = next(event for event in talk.events if event.kind == Happening.ESTOP)
        assert tick <= stop.tick <= tick + SEEN, (seed, stop.tick - tick)
        assert not [each for each in talk.board.rises if each > stop.tick]
