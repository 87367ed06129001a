"""The clock of a board: bounds from round trips, how far it is off, and what it never does."""

from __future__ import annotations

import random

import pytest

from slewline.drive.board.clock import BoardClock
from tests.ensembles import few

MS, SECOND = 1_000_000, 1_000_000_000


def watched(
    seed: int, ppm: float, late: tuple[float, float], *, every: int = 100 * MS, seconds: int = 60, begun: int = 0
) -> tuple[BoardClock, list[tuple[float, float]]]:
    """A clock, and at each look, 1 ms apart: seconds since the first, error in ms."""
    chance = random.Random(seed)
    clock, rate = BoardClock(), 16e6 * (1 + ppm / 1e6) / 1e9
    start = 7 * SECOND
    errors: list[tuple[float, float]] = []
    before = (-1, -1)
    free, sent, received, taken = start, 0, 0, 0

    def tick(at: int) -> int:
        return begun + int((at - start) * rate)

    for now in range(start, start + seconds * SECOND, MS):
        if received and now >= received:
            clock.note(sent, received, taken)
            received = 0
        if not received and now >= free:
            sent = now
            at = sent + int(chance.uniform(*late) * MS)
            received = at + int(chance.uniform(*late) * MS)
            taken, free = tick(at) % 2**32, now + every
        if clock.known:
            now_tick, now_ns = clock.ticks(now), clock.nanoseconds(now)
            assert now_tick >= before[0] and now_ns >= before[1]
            before = now_tick, now_ns
            errors.append(((now - start) / 1e9, (now_tick - tick(now)) / 16e3))
    return clock, errors


@pytest.mark.parametrize("seed", few(range(3), 1))
@pytest.mark.parametrize("ppm", [-5000, 0, 5000])
def test_with_latencies_of_1_to_30_ms_it_is_soon_within_2_ms_and_monotone(seed: int, ppm: float) -> None:
    clock, errors = watched(seed, ppm, (1, 30), begun=2**32 - 16_000_000)
    assert max(abs(error) for time, error in errors) < 16
    assert max(abs(error) for time, error in errors if time > 5) < 6
    assert max(abs(error) for time, error in errors if time > 20) < 2
    assert abs(clock.offset_ppm - ppm) < 20
    last, worst, median = clock.round_trip_ns
    assert 2 * MS <= last <= worst <= 60 * MS and 20 * MS < median < 40 * MS


def test_on_a_quick_line_it_is_within_a_tenth_of_a_millisecond() -> None:
    clock, errors = watched(1, 5000, (0.1, 1))
    assert max(abs(error) for time, error in errors if time > 5) < 0.1
    assert abs(clock.offset_ppm - 5000) < 2
    assert clock.doubt_ns < 0.3 * MS


def test_the_error_is_within_its_own_estimate() -> None:
    clock, errors = watched(2, -3000, (1, 30), seconds=20)
    assert abs(errors[-1][1]) * MS <= clock.doubt_ns + 0.2 * MS


def test_before_the_first_round_trip_it_does_not_advance() -> None:
    clock = BoardClock()
    assert (clock.known, clock.ticks(5), clock.nanoseconds(9), clock.round_trip_ns) == (False, 0, 0, (0, 0, 0))


def test_one_round_trip_by_hand() -> None:
    clock = BoardClock()
    clock.note(1 * MS, 3 * MS, 800)
    assert clock.ticks(2 * MS) == 800 and clock.ticks(3 * MS) == 16_800
    assert clock.at_ns(800) == 2 * MS and clock.at_ns(16_800) == 3 * MS
    assert clock.nanoseconds(3 * MS) == 1 * MS
    assert clock.ticks(2 * MS) == 16_800  # never less
    assert clock.round_trip_ns == (2 * MS, 2 * MS, 2 * MS)


def test_in_the_first_seconds_each_round_trip_makes_the_rate_better() -> None:
    clock, start = BoardClock(), 100 * SECOND
    for sent, received in ((0, 0), (SECOND, SECOND + 50 * MS), (SECOND + 60 * MS, SECOND + 60 * MS)):
        clock.note(start + sent, start + received, sent * 16_064 // 1_000_000)  # 0.4 % fast
    assert clock.offset_ppm == pytest.approx(4000, abs=1)


def test_ticks_are_unwrapped_to_the_nearest_one() -> None:
    clock = BoardClock()
    clock.note(0, 10, 2**32 - 5)
    assert clock.unwrap(2**32 - 100) == 2**32 - 100 and clock.unwrap(7) == 2**32 + 7
    clock.note(1000, 1010, 11)
    assert clock.unwrap(2**32 - 100) == 2**32 - 100
    assert clock.unwrap(clock.unwrap(12)) == 2**32 + 12


def test_after_a_boot_board_time_continues_and_ticks_begin_again() -> None:
    clock = BoardClock()
    clock.note(0, 0, 5_000_000)
    before = clock.nanoseconds(SECOND)
    clock.restart()
    assert clock.nanoseconds(3 * SECOND) == before and not clock.known
    clock.note(4 * SECOND, 4 * SECOND, 77)
    assert clock.ticks(4 * SECOND) == 77
    assert clock.nanoseconds(5 * SECOND) == before + SECOND


def test_after_a_jump_of_the_hosts_clock_it_is_right_again() -> None:
    clock = BoardClock()
    for second in range(10):
        clock.note(second * SECOND, second * SECOND + MS, second * 16_000_000)
    clock.note(100 * SECOND, 100 * SECOND + MS, 10 * 16_000_000)  # the host slept, or its clock did not
    for second in range(11, 20):
        clock.note((second + 90) * SECOND, (second + 90) * SECOND + MS, second * 16_000_000)
    assert abs(clock.at_ns(20 * 16_000_000) - 110 * SECOND) < 2 * MS


def test_after_a_silence_of_an_hour_ticks_do_not_lag_a_round() -> None:
    clock = BoardClock()
    for second in (*range(100), 3700):
        clock.note(second * SECOND, second * SECOND + MS, second * 16_064_000 % 2**32)  # 0.4 % fast
    assert abs(clock.ticks(3700 * SECOND) - 3700 * 16_064_000) < 40_000
    assert clock.unwrap(3700 * 16_064_000 % 2**32) == 3700 * 16_064_000
