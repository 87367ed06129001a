"""Time: whole picoseconds, clocks converted once, nothing rounded behind the user's back."""

from __future__ import annotations

from copy import copy, deepcopy
from fractions import Fraction
from pickle import dumps, loads
from random import Random

import numpy as np
import pytest

from slewline.core.time.timebase import Clock, Seconds, hertz, moment, moments, picoseconds, readable
from slewline.errors import TimeError
from tests.rows import rows

PS = 10**12
CRYSTALS = [11_000_000, 6_000_000, 5_500_000, 3_579_545, 10_999_999, 11_370_000, 1_000_000, 999_983, 12_000_000]


# ----------------------------------------------------------------------------------------------------- reading times


@rows(
    ("text", "ps"),
    [
        ("25 us", 25_000_000),
        ("25 \N{MICRO SIGN}s", 25_000_000),
        ("25 \N{GREEK SMALL LETTER MU}s", 25_000_000),
        ("1.5 ms", 1_500_000_000),
        ("1.5ms", 1_500_000_000),
        ("0 s", 0),
        ("3 ps", 3),
        ("0.001 ns", 1),
        ("2 min", 120 * PS),
        ("106.75 h", 384_300 * PS),
        ("  7  US ", 7_000_000),
        ("1. s", PS),
        ("123456789012345678 s", 123456789012345678 * PS),
        (12_000, 12_000),
        (10**30, 10**30),
    ],
)
def test_a_time_is_read_exactly(text, ps):
    assert picoseconds(text) == ps


@rows(
    "text",
    [
        "25",
        "us",
        "",
        "25 parsecs",
        "2,5 ms",
        "1e3 us",
        "0.0001 ns",
        "0.5 ps",
        "-3 ms",
        "1 2 us",
        ".5 ms",
        "+-1 s",
        "nan s",
    ],
)
def test_an_inexact_time_is_refused(text):
    with pytest.raises(TimeError):
        picoseconds(text)


@rows("value", [1.0, 25e6, True, False, None, b"1 us", np.float64(3), -1])
def test_times_other_than_an_int_of_picoseconds_are_refused(value):
    with pytest.raises(TimeError):
        picoseconds(value)


def test_a_refused_time_is_reported_with_its_value_and_the_allowed_forms():
    with pytest.raises(TimeError, match=r"'25'.*number and a unit.*'25 us'"):
        picoseconds("25")
    with pytest.raises(TimeError, match=r"1\.5.*a float would be rounded"):
        picoseconds(1.5)
    with pytest.raises(TimeError, match=r"'0\.5 ps': finer than"):
        picoseconds("0.5 ps")
    with pytest.raises(TimeError, match="does not run backwards"):
        picoseconds("-1 us")
    assert picoseconds("-1 us", negative=True) == -1_000_000


@rows(
    ("text", "hz"),
    [
        ("11 MHz", 11_000_000),
        ("3.579545 MHz", 3_579_545),
        ("6000 kHz", 6_000_000),
        ("7 Hz", 7),
        ("11 mhz", 11_000_000),
        (5, 5),
    ],
)
def test_a_frequency_is_read_exactly(text, hz):
    assert hertz(text) == hz


@rows("number", [1, 999, np.int64(5), True, -3])
def test_a_bare_number_below_a_nanosecond_is_refused_where_time_is_to_pass(number):
    with pytest.raises(TimeError):
        picoseconds(number)


def test_the_refusal_of_a_bare_number_suggests_a_unit():
    with pytest.raises(TimeError, match="bare number is picoseconds; write its unit, such as '5 ms' or '5 ps'"):
        picoseconds(5)
    assert [picoseconds(time) for time in (0, 1000, "5 ps", np.int64(2000), np.int32(0))] == [0, 1000, 5, 2000, 0]
    assert type(picoseconds(np.int64(2000))) is int


def test_a_question_about_the_past_takes_any_instant_and_many_of_them():
    assert [moment(time) for time in (0, 1, 999, "1 ns")] == [0, 1, 999, 1000]
    assert moments("1 ns") == 1000 and type(moments(np.int64(3))) is int
    assert moments([1, "1 ns", np.int64(7)]).tolist() == [1, 1000, 7]
    assert moments(["1 us"]).dtype == np.int64
    assert moments(np.array([[1, 2]])).tolist() == [[1, 2]]
    for wrong in (1.5, [1.5], np.array([1.0]), ["1.5"], [True, 1.5], None):
        with pytest.raises(TimeError):
            moments(wrong)


def test_seconds_read_well_and_are_a_number():
    now = Seconds(170_768_300_000)
    assert f"{now}" == str(now) == "0.170768 s"
    assert (f"{now:.3f}", float(now) < 0.171, now * 1000) == ("0.171", True, 170.7683)
    assert str(Seconds(36000 * 10**12)) == "36000.000000 s"
    assert [each.ps for each in (now, copy(now), deepcopy(now), loads(dumps(now)))] == [170_768_300_000] * 4


def test_the_seconds_of_a_bench_are_a_time_like_any_other_and_another_float_is_not():
    late = Seconds(9_007_199_254_740_993_001)  # more than a float can hold
    assert (picoseconds(late), moment(late), moments(late)) == (late.ps,) * 3
    assert moments([late, "1 ns"]).tolist() == [late.ps, 1000]
    assert picoseconds(Seconds(5)) == 5  # it is no bare number
    for wrong in (late + 0.5, 0.5, float(late)):
        with pytest.raises(
            TimeError, match=r"bench\.now, or an integer number of picoseconds; a float would be rounded"
        ):
            picoseconds(wrong)
    with pytest.raises(TimeError, match=r"expected text such as '0\.25 s'"):
        picoseconds(0.25)


@rows("text", ["11", "11 MH", "3.5795455 MHz", "fast", 11e6, True])
def test_a_frequency_that_is_not_a_whole_number_of_hertz_is_refused(text):
    with pytest.raises(TimeError):
        hertz(text)


@rows(
    ("ps", "text"),
    [
        (0, "0 ps"),
        (999, "999 ps"),
        (1000, "1 ns"),
        (3_200_000_000, "3.2 ms"),
        (25_000_000, "25 µs"),
        (PS, "1 s"),
        (90 * PS, "90 s"),
        (1_000_001, "1.000001 µs"),
        (-1_500_000, "-1.5 µs"),
        (12_005_000, "12.005 µs"),
    ],
)
def test_times_are_written_in_the_unit_that_fits(ps, text):
    assert readable(ps) == text


# ------------------------------------------------------------------------------------------------------------- clocks


def exact(hz: int, ticks: int) -> int:
    """The instant of a tick by fractions, rounded down."""
    return int(Fraction(ticks * PS, hz) // 1)


@rows("hz", CRYSTALS)
def test_a_tick_agrees_with_big_integers(hz):
    clock, random = Clock(hz), Random(hz)
    for ticks in [0, 1, 2, 15, hz, hz + 1, 10**15 + 7, *(random.randrange(1 << 60) for _ in range(200))]:
        ps = clock.ps(ticks)
        assert ps == exact(hz, ticks)
        assert clock.ticks_until(ps) == clock.ticks_from(ps) == ticks
        assert clock.ticks_until(ps - 1) == ticks - 1
        assert clock.ticks_from(ps + 1) == ticks + 1


@rows("hz", CRYSTALS)
def test_an_instant_is_between_two_ticks(hz):
    clock, random = Clock(hz), Random(hz)
    for _ in range(300):
        ps = random.randrange(1 << 62)
        until, after = clock.ticks_until(ps), clock.ticks_from(ps)
        assert exact(hz, until) <= ps < exact(hz, until + 1)
        assert exact(hz, after - 1) < ps <= exact(hz, after)


@rows("hz", CRYSTALS)
def test_an_array_of_ticks_is_exact_up_to_a_hundred_days(hz):
    clock, random = Clock(hz), Random(hz)
    top = (1 << 63) * hz // PS - 1  # ticks in 2^63 ps
    for origin in [0, 1, 12_345, clock.d, 3 * clock.d + 5, top // 2, top - 10_000]:
        span = min(top - origin, random.choice([10_000, 10**9, top]))
        ticks = np.array(sorted(random.randrange(span) for _ in range(200)), np.int64)
        assert clock.ps_array(ticks, origin).tolist() == [exact(hz, origin + int(tick)) for tick in ticks]
        assert clock.ps_list(ticks.tolist()) == [exact(hz, int(tick)) for tick in ticks]


@rows("hz", CRYSTALS)
def test_an_array_of_instants_finds_its_ticks_up_to_a_hundred_days(hz):
    clock, random = Clock(hz), Random(hz)
    for span in (10_000, 10**9, 10**13, (1 << 63) - 1):
        instants = [random.randrange(span) for _ in range(200)]
        on_ticks = [clock.ps(clock.ticks_until(ps)) for ps in instants]
        for plus in (-1, 0, 1):
            asked = [max(ps + plus, 0) for ps in on_ticks + instants[:-1] + [span - 1]]
            ticks = [clock.ticks_from(ps) for ps in asked]
            assert clock.ticks_array(np.array(asked, np.int64)).tolist() == clock.ticks_list(asked) == ticks


def test_an_array_beyond_a_hundred_days_is_refused():
    with pytest.raises(TimeError, match="106 days"):
        Clock(11_000_000).ps_array(np.array([0, 102 * 10**12]))


def test_an_empty_array_of_ticks_has_no_instants():
    assert Clock(11_000_000).ps_array(np.empty(0, np.int64), 5).tolist() == []


def test_nothing_drifts_in_a_hundred_days():
    clock = Clock(3_579_545)
    assert clock.ps(3_579_545 * 86_400 * 100) == 86_400 * 100 * PS
