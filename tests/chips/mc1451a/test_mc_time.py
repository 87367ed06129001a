"""The clock of the MC1451A family: cycles, slices and rates at the pins, the time, and what another crystal changes."""

from __future__ import annotations

from random import Random

import pytest
from mc import AXES, ONE, READY, US, base, each, gaps

import slewline

SECOND = 10**12  # picoseconds
CYCLES_PER_S = 25_000_000 / 8192


@each
@pytest.mark.fact("PMD-TIME-1", "PMD-TIME-2", "PMD-CON-CYCLE", "PMD-UND-TIME-START")
def test_the_time_counts_cycles_of_327_68_us_from_the_end_of_reset_on(part: str) -> None:
    rig = base(part, ready=False)
    for cycle in (0, 1, 9):
        rig.bench.run_to(US + cycle * 327_680_000)
        assert rig.shows("time") == cycle
    rig.bench.run_to(US + 9 * 327_680_000 + 327_679_999)
    assert (rig.shows("time"), rig.level("hostrdy")) == (9, 0)
    rig.bench.run_to(US + SECOND)
    assert rig.shows("time") == 3051
    first = rig.do("GET_TIME")
    assert first == 3052  # a slice later
    rig.bench.run_to(US + SECOND + 10_000 * 327_680_000)
    assert rig.do("GET_TIME") == first + 10_000


@pytest.mark.fact("PMD-TIME-10", "PMD-CON-TIME-WRAP")
def test_after_the_greatest_number_the_time_is_0() -> None:
    rig = base("mc1151a")
    rig.to((1 << 32) - 1)  # 16 days
    rig.says("3e > ffff ffff 003c")
    rig.next()
    rig.says("3e > 0000 0000 003e")
    rig.begin(f"SET_VEL {ONE}", f"SET_ACC {ONE}", "SET_POS 5")
    rig.rest()
    assert (rig.x.position, rig.status()) == (5, 0x0301)


@each
@pytest.mark.fact("PMD-TIME-13")
def test_no_command_but_reset_touches_the_time(part: str) -> None:
    random, rig = Random(13), base(part)
    rows = [row for row in rig.x.sheet.commands if row.name not in ("RESET", "GET_TIME")]
    for number in range(2 * len(rows)):
        row = rows[number % len(rows)]
        rig.host.command(row.name, *(random.randint(arg.low, arg.high) for arg in row.args))
        cycle = rig.next(random.randrange(1, 3))
        assert rig.do("GET_TIME") == cycle
    rig.do("RESET")
    assert rig.do("GET_TIME") == READY


# ------------------------------------------------------------------------------------------------------- other crystals
@pytest.mark.fact("PMD-TIME-3", "PMD-TIME-11", "PMD-UND-CLOCK-OTHER")
@pytest.mark.parametrize("mhz", [25, 20, 10, 8])
def test_every_time_goes_with_the_crystal(mhz: int) -> None:
    tick = 10**6 // mhz
    rig = base("mc1151a", "hostrdy", "atrest1", "pulse1", "clkout", options={"crystal": f"{mhz} MHz"})
    assert rig.rises("hostrdy")[0] == 25 * tick + 10 * 8192 * tick  # behind 25 clocks of reset
    since = rig.bench.now_ps
    rig.do(f"SET_VEL {ONE}", f"SET_ACC {ONE}")
    rig.next()
    falls, rises = rig.falls("hostrdy", since), rig.rises("hostrdy", since + 1)
    assert len(falls) == len(rises) == 8
    assert all(0 <= rise - fall - 2048 * tick < tick for fall, rise in zip(falls, rises, strict=True))
    rig.begin("SET_POS 4")
    rig.rest()
    (fall, _), (rise, _) = rig.edges("atrest1", since)
    assert rise - fall == 4 * 8192 * tick
    assert set(gaps([time for time, _ in rig.edges("pulse1", since)])) == {4096 * tick}
    clkout = rig.edges("clkout", since)[:101]
    assert set(gaps([time for time, _ in clkout])) == {2 * tick} and len(clkout) == 101


@pytest.mark.fact("PMD-TIME-3", "PMD-UND-CLOCK-OTHER")
def test_at_20_mhz_a_cycle_is_409_6_us_and_the_filter_600_ns() -> None:
    rig = base("mc1151a", "atrest1", options={"crystal": "20 MHz"})
    assert gaps([rig.at(n) for n in range(3)]) == [409_600_000] * 2
    cycle = rig.next() + 3
    rig.do("SET_AUTO_UPDATE_OFF", "SET_EXT_BRK")
    rig.drive("home1", 0, at=rig.at(cycle) - 600_000)
    rig.to(cycle)
    assert rig.shows("status") == 0x0300  # a clock too late
    rig.to(cycle + 1)
    assert rig.shows("status") == 0x0304


@pytest.mark.fact("PMD-TIME-12")
@pytest.mark.parametrize(
    ("crystal", "codes"),
    [
        ("6.7 MHz", []),
        ("6.699999 MHz", ["crystal"]),
        ("25 MHz", []),
        ("25.6 MHz", []),
        ("25.600001 MHz", ["crystal"]),
    ],
)
def test_a_crystal_outside_of_6_7_to_25_6_mhz_is_reported(crystal: str, codes: list[str]) -> None:
    rig = base("mc1451a", options={"crystal": crystal})
    assert rig.status() == 0x0300 and rig.codes == codes


@pytest.mark.fact("PMD-TIME-11")
@each
def test_clkout_is_a_quarter_of_the_clock(part: str) -> None:
    bench = slewline.Bench()
    bench.add(part, name="x")
    bench.record("x.clkout")
    bench.run("10 us")
    times, levels = (column.tolist() for column in bench.edges("x.clkout"))
    rises = [time for time, level in zip(times, levels, strict=True) if level]
    assert set(gaps(rises)) == {160_000} and set(gaps(times)) == {80_000}
    assert len(rises) in (62, 63)


# ------------------------------------------------------------------------------------------ rates as the manual reckons
@pytest.mark.parametrize(
    ("velocity", "rate"),
    [
        pytest.param(267_010, 12_433.6, marks=pytest.mark.fact("PMD-TIME-5")),
        pytest.param(265_107, 12_345.0, marks=pytest.mark.fact("PMD-TIME-6")),
    ],
)
def test_a_velocity_in_steps_per_second(velocity: int, rate: float) -> None:
    rig = base("mc1151a")
    begun = rig.begin("SET_PRFL_VEL", f"SET_VEL {velocity}", f"SET_ACC {velocity}")
    rig.to(begun + 3000)
    steps = rig.pulses()
    measured = (len(steps) - 1) * SECOND / (steps[-1] - steps[0])
    assert measured == pytest.approx(rate, rel=1e-5) == velocity / ONE * CYCLES_PER_S


@pytest.mark.parametrize(
    ("acceleration", "rate"),
    [
        pytest.param(485, 68_923, marks=pytest.mark.fact("PMD-TIME-7")),
        pytest.param(478, 67_928, marks=pytest.mark.fact("PMD-TIME-8")),
    ],
)
def test_an_acceleration_in_steps_per_second_squared(acceleration: int, rate: float) -> None:
    rig = base("mc1151a")
    begun = rig.begin("SET_PRFL_VEL", f"SET_VEL {16 * ONE}", f"SET_ACC {acceleration}")
    rig.to(begun + 2000)
    steps = rig.pulses()

    def speed(cycle: int) -> float:
        """Steps per second in the 200 cycles around one."""
        first, last = rig.at(begun + cycle - 100), rig.at(begun + cycle + 100)
        return sum(first < step <= last for step in steps) * CYCLES_PER_S / 200

    measured = (speed(1900) - speed(100)) * CYCLES_PER_S / 1800
    assert measured == pytest.approx(rate, rel=1e-3)
    assert rate == pytest.approx(acceleration / ONE * CYCLES_PER_S**2, rel=1e-4)


@each
@pytest.mark.fact("PMD-TIME-1", "PMD-TIME-4")
def test_the_cycle_does_not_depend_on_the_number_of_axes_that_move(part: str) -> None:
    axes = range(1, AXES[part] + 1)
    rig = base(part, *(f"atrest{axis}" for axis in axes))
    for axis in axes:
        rig.do(f"SET_VEL {ONE}", f"SET_ACC {ONE}", f"SET_POS {10 * axis}", axis=axis)
    rig.do(f"MULTI_UPDATE {2 ** AXES[part] - 1}")
    rig.next()
    rig.rest()
    (begun, _), *_ = rig.lows("atrest1")
    assert [rig.lows(f"atrest{axis}") for axis in axes] == [[(begun, 10 * axis)] for axis in axes]
    assert rig.falls("atrest1", rig.at(READY)) == [US + begun * 327_680_000]
