"""Records: the arithmetic of the board by hand, and trains that are fitted within the tolerance."""

from __future__ import annotations

import random
from itertools import accumulate

import pytest

from slewline.drive.board import records
from slewline.drive.board.records import DOWN, HALF, OUT, PAUSE, PER_TICK, REST, Record, fit, length, pauses
from slewline.errors import UsageError
from tests.ensembles import few

SHORTEST = 224


def played(made: list[Record], base: int) -> list[int]:
    out: list[int] = []
    for record in made:
        assert record.good(SHORTEST), record
        out += record.times(base)
        base += record.length
    return out


def test_thirteen_bytes() -> None:
    record = Record(DOWN | HALF, 258, 0x01020304, 0x0506, -2)
    assert record.pack().hex() == "11" + "0201" + "04030201" + "0605" + "feffffff"
    assert records.unpack(record.pack() * 2) == [record, record]
    assert records.pack([record, record]) == record.pack() * 2


def test_the_arithmetic_of_the_board_by_hand() -> None:
    record = Record(0, 4, 1000, 0x8000, -65_536 * 10)
    assert [time / PER_TICK for time in record.times(5 * PER_TICK)] == [1005.5, 1996.0, 2976.5, 3947.0]
    assert record.length == 3942 * PER_TICK and record.last == int(970.5 * PER_TICK)
    pause = Record(PAUSE, 0, 300, 0x4000, 77)
    assert [*pause.times(0)] == [] and pause.length == int(300.25 * PER_TICK)
    assert length([record, pause]) == int(4242.25 * PER_TICK)


@pytest.mark.parametrize(
    ("record", "good"),
    [
        (Record(0, 1, 224), True), (Record(0, 1, 223, 65_535), False), (Record(0, 0, 1000), False),
        (Record(0, 11, 234, 0, -PER_TICK), True), (Record(0, 12, 234, 0, -PER_TICK), False),
        (Record(0, 1, 2**31 - 1), True), (Record(0, 1, 2**31), False), (Record(0, 2, 2**31 - 1, 0, PER_TICK), False),
        (Record(PAUSE, 0, 256), True), (Record(PAUSE, 0, 255, 65_535), False), (Record(PAUSE, 0, 2**31), False),
        (Record(PAUSE | REST, 0, 256), True), (Record(PAUSE | OUT, 0x0F0F, 256), True), (Record(REST, 1, 1000), False),
        (Record(OUT, 1, 1000), False), (Record(PAUSE, 1, 1000), False), (Record(PAUSE | OUT, 0x1000, 1000), False),
        (Record(PAUSE | OUT, 16, 1000), False), (Record(32, 1, 1000), False), (Record(32 | PAUSE, 1, 1000), False),
    ],
)  # fmt: skip
def test_rules_of_content(record: Record, good: bool) -> None:
    assert record.good(SHORTEST) is good


def trains(seed: int) -> dict[str, list[float]]:
    """Intervals in ticks."""
    chance = random.Random(seed)
    return {
        "constant": [chance.uniform(300, 20_000)] * 3000,
        "up": [16e6 / (1e4 + 100 * k) ** 0.5 / 10 for k in range(2500)],
        "down": [350.0 + 0.5 * k for k in range(3000)],
        "stairs": [1000.0 + 137 * (k // 40) for k in range(1500)],
        "jitter": [1600 + chance.uniform(-9, 9) for _ in range(700)],
        "wild": [chance.uniform(240, 50_000) for _ in range(300)],
        "slow": [chance.uniform(2**30, 2**33) for _ in range(20)],
        "at the limit": [224.0] * 500,
        "down to the limit": [*(224 + 40 / 1.3**k for k in range(12)), *[224.0] * 20] * 20,
        "up from the limit": [*[224.0] * 5, *(224 + 3 * k for k in range(30))] * 9,
    }


@pytest.mark.parametrize("seed", few(range(4), 2))
@pytest.mark.parametrize("tolerance", [PER_TICK, 8 * PER_TICK])
def test_every_step_is_within_the_tolerance(seed: int, tolerance: int) -> None:
    for name, intervals in trains(seed).items():
        base = random.Random(seed).randrange(2**40)
        instants = [base + int(each * PER_TICK) for each in accumulate(intervals)]
        made = fit(instants, base, tolerance=tolerance, flags=DOWN)
        steps = played(made, base)
        assert len(steps) == len(instants), name
        assert max(abs(one - two) for one, two in zip(steps, instants, strict=True)) <= tolerance, name
        assert {record.flags & ~PAUSE for record in made} == {DOWN}


def test_equal_intervals_in_fractions_of_a_tick_are_one_record_and_quadratic_ones_too() -> None:
    constant = [k * (1600 * PER_TICK + 12_345) for k in range(1, 60_001)]
    assert fit(constant, 0) == [Record(0, 60_000, 1600, 12_345, 0)]
    ramp = Record(0, 20_000, 16_000, 1, -50_000)
    assert fit([*ramp.times(7)], 7, tolerance=0) == [ramp]
    assert len(fit([*Record(0, 65_535, 300).times(0), 65_536 * 300 * PER_TICK], 0)) == 2  # the count has 16 bits


@pytest.mark.parametrize("seed", few(range(20), 8))
def test_no_record_could_be_longer(seed: int) -> None:
    """The greedy fit against a search over all values of `add` in steps of 1/20 tick, for short trains."""
    chance = random.Random(seed)
    instants = [*accumulate(int(chance.uniform(995, 1005) * PER_TICK) for _ in range(12))]
    tolerance = 3 * PER_TICK
    found = fit(instants, 0, tolerance=tolerance)[0].count
    longest = 0
    for add in range(-8 * PER_TICK, 8 * PER_TICK, PER_TICK // 20):
        low, high, count = 0, 2**62, 0
        for k, instant in enumerate(instants, 1):
            moved = instant - k * (k - 1) // 2 * add
            low, high = max(low, -((tolerance - moved) // k)), min(high, (moved + tolerance) // k)
            if low > high:
                break
            count = k
        longest = max(longest, count)
    assert found >= longest


def test_where_the_train_is_faster_than_the_board_it_is_refused() -> None:
    instants = [*accumulate([300 * PER_TICK] * 50 + [200 * PER_TICK] * 50)]
    with pytest.raises(UsageError, match=r"step 5\d of 100: .* expected 224 or more; choose a lower rate"):
        fit(instants, 0)


def test_a_day_of_records_does_not_drift() -> None:
    """An hour's train, fitted 24 times from where the arithmetic of the board is."""
    interval = 16_000_000 * PER_TICK // 7  # 7 steps a second, which is no whole number
    base = worst = number = 0
    for _ in range(24):
        instants = [(number + k) * 16_000_000 * PER_TICK // 7 for k in range(1, 25_201)]
        for record in fit(instants, base):
            for time in record.times(base):
                number += 1
                worst = max(worst, abs(time - number * 16_000_000 * PER_TICK // 7))
            base += record.length
    assert number == 24 * 25_200 and interval * number != number * 16_000_000 * PER_TICK // 7
    assert worst <= 8 * PER_TICK
    assert abs(base - 86_400 * 16_000_000 * PER_TICK) <= 8 * PER_TICK


def test_a_gap_becomes_pauses_that_are_as_long_in_all() -> None:
    for gap in (256 << 16, (256 << 16) + 1, 2**47 - 1, 2**47, 2**47 + 255, 2**50 + 12_345):
        made = pauses(gap, DOWN)
        assert length(made) == gap
        assert all(record.good(SHORTEST) and record.flags == DOWN | PAUSE for record in made)
    with pytest.raises(UsageError, match="expected 256"):
        pauses((256 << 16) - 1)
