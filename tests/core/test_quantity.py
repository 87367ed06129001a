"""Velocity and position over time: exact at every instant, and in every column of a picture."""

from __future__ import annotations

from itertools import pairwise
from random import Random
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import slewline
from slewline.bench.scripts.script import run_script
from slewline.chips import PARTS, sheet_of
from slewline.chips.mc1451a.profiles.cycle_train import CycleTrain, Linear
from slewline.core.motion.axis import Axis
from slewline.core.motion.quantity import Outline, Position, Quantity, Velocity, column_edges
from slewline.core.motion.train import Playing, StepTrain
from slewline.core.time.kernel import Kernel
from slewline.core.time.timebase import Clock
from slewline.errors import UsageError

US, MS, S = 10**6, 10**9, 10**12

BEFORE = "F 1\nR 250\nN 60\n+\nG\nA\nB\n-\nN 90\nG\n+\nN 40\nG\n"  # without a ramp
LETTERS = {
    "cy500": BEFORE,
    "cy512": f"S 0\n{BEFORE}",
    "cy525": "A 65500\nF 30\nR 90\nS 253\nZ 1\nN 60\n+\nG\n-\nN 90\nG\nA 10\n+\nN 40\nG\n-\nG\n",
}
VERBATIM = "A 16777190\nF 30\nR 90\nS 253\nN 60\n+\nG\n-\nN 90\nG\nA 10\n+\nN 40\nG\n-\nG\nF 255\n"
PACKETS = "SET_VEL 0x10000\nSET_ACC 0x800\nSET_POS {first}\nUPDATE\n"
CURVE = "SET_PRFL_S_CRV\nSET_MAX_ACC 0x800\nSET_JERK 0x100000\nSET_POS {second}\nUPDATE\n"
ENTER = {"gs-c200": "P", "gs-c200s": "Po"}


def played(part: str) -> Any:
    """A bench with one chip, x, on which much has happened: loads, wraps, reversals, holds, a stop."""
    bench = slewline.Bench()
    sheet = sheet_of(part)
    straps = {"br0": 0, "br1": 0, "br2": 0, "chs": 0} if sheet.dialect.name == "lines" else None
    x = bench.add(part, name="x", straps=straps, **({"position": 65500} if part in LETTERS else {}))
    host, axis = bench.host(x), x.axes[0]
    if sheet.dialect.name == "lines":
        endless = "G+" if part == "gs-c200" else "g+"
        for line in (ENTER[part], "S20", "T100", "R5", "+70", "-60", "+9", "D1", endless, "E"):
            assert host.ask(line) == "Y"
        now = bench.now_ps
        for at, level in ((60, 0), (75, 1), (350, 0), (500, 1), (600, 0), (600.001, 1)):
            x.pin("enable").drive(level, at=now + int(at * MS))
        bench.run("800 ms")
        host.ask("K")
        axis.load(axis.positions[-1] - 10)
        for line in (ENTER[part], "+33", "E"):
            host.ask(line)
    elif sheet.dialect.name == "packets":
        bench.run("3 ms")
        axis.load(axis.positions[-1] - 10)
        run_script(bench, host, PACKETS.format(first=60))
        bench.run("40 ms")
        run_script(bench, host, CURVE.format(second=-50))
        bench.run("30 ms")
        axis.load(-5)
        bench.run("40 ms")
        host.command("SET_POS", -90)
        host.command("UPDATE")
        bench.run("20 ms")
        host.command("STOP")
        host.command("UPDATE")
    elif sheet.dialect.name == "verbatim":
        host.send(VERBATIM.replace("\n", "\r"))
        for at, level in ((20, 0), (22, 1), (90, 0), (95, 1)):
            x.pin("inhibit_abort").drive(level, at=int(at * MS))
        bench.run("400 ms")
        x.pin("jog").drive(0)
        x.pin("jog").release(at=450 * MS)
    else:
        for at, level in ((8.5, 1), (12, 0), (20, 1), (20.1, 0), (41, 1), (45, 0)):
            x.pin(sheet.role("enable").name).drive(level, at=int(at * MS))
        x.pin("io_request").drive(0, at=53 * MS)
        x.pin("io_request").release(at=int(53.3 * MS))
        host.send(LETTERS[part].replace("\n", "\r"))
    bench.run("200 ms")
    return bench


@pytest.fixture(scope="module", params=PARTS)
def bench(request: pytest.FixtureRequest) -> Any:
    return played(request.param)


def at(outline: Outline, times: Any) -> Any:
    """What an outline shows at instants."""
    return outline.values[np.searchsorted(outline.times_ps, times, side="right") - 1]


def quantities(bench: Any) -> list[Quantity]:
    x = bench["x"]
    return [quantity for axis in x.axes[:2] for quantity in (Velocity(axis), Position(axis))]


def test_the_bench_has_a_long_past(bench: Any) -> None:
    axis = bench["x"].axes[0]
    steps = axis.steps(0, bench.now_ps)
    assert len(steps) > 60 and set(steps.directions.tolist()) == {-1, 1}
    breaks = {"gs-c200": 1, "gs-c200s": 2}.get(bench["x"].sheet.part, 3)  # the counter of a GS-C200 does not wrap
    assert np.isnan(Position(axis).changes(0, bench.now_ps).values).sum() >= breaks


def test_a_curve_equals_its_quantity_at_a_thousand_instants(bench: Any) -> None:
    now = bench.now_ps
    for number, axis in enumerate(bench["x"].axes, 1):
        steps = axis.steps(0, now).times_ps
        times = np.concatenate([np.random.default_rng(number).integers(0, now, 1000), steps, steps - 1, [0, now]])
        position, velocity = Position(axis).changes(0, now), Velocity(axis).changes(0, now)
        assert at(position, times).tolist() == bench["x"].axis(number).position_at(times).tolist()
        assert [axis.position_at(time) for time in times.tolist()] == at(position, times).tolist()
        assert at(velocity, times).tolist() == bench["x"].axis(number).velocity_at(times).tolist()
        for start, stop in ((now // 3, now // 2), (int(steps[5]) if len(steps) > 5 else 5, now - 1)):
            inside = times[(times >= start) & (times <= stop)]
            for quantity in (Position(axis), Velocity(axis)):
                found = quantity.changes(start, stop)
                assert found.times_ps[0] == start and found.times_ps[-1] <= stop
                assert at(found, inside).tolist() == quantity.at(inside).tolist()


@pytest.mark.parametrize("columns", [3, 11, 130])
def test_an_outline_keeps_visible_points(bench: Any, columns: int) -> None:
    for quantity in quantities(bench):
        for start, stop in ((0, bench.now_ps), (bench.now_ps // 7, bench.now_ps * 3 // 5)):
            keeps_what_shows(quantity, start, stop, columns)


def keeps_what_shows(quantity: Quantity, start: int, stop: int, columns: int) -> None:
    every, few = quantity.changes(start, stop), quantity.outline(start, stop, columns)
    assert len(few.times_ps) <= max(8 * columns, len(every.times_ps) if len(every.times_ps) <= 4 * columns else 0)
    assert few.times_ps[0] == start and (np.diff(few.times_ps) >= 0).all() and few.times_ps[-1] <= stop
    real = ~np.isnan(few.values)
    assert quantity.at(few.times_ps[real]).tolist() == few.values[real].tolist()
    edges = [*column_edges(start, stop, columns), stop + 1]
    for begin, end in pairwise(edges):
        if begin < end:
            assert reach(few, begin, end) == reach(every, begin, end), (quantity.name, columns, begin, end)
    for broken in few.times_ps[~real].tolist():
        assert np.isnan(every.values[np.searchsorted(every.times_ps, broken)])
    values, breaks = every.values, np.isnan(every.values)
    if breaks.any():  # a line never leads over a break
        for a, b in pairwise(np.flatnonzero(real).tolist()):
            between = (every.times_ps > few.times_ps[a]) & (every.times_ps <= few.times_ps[b]) & np.isnan(values)
            if between.any():
                assert b > a + 1, (few.times_ps[a], few.times_ps[b])


def reach(outline: Outline, begin: int, end: int) -> tuple[float, float]:
    """The lowest and the highest value in a column."""
    inside = outline.values[(outline.times_ps >= begin) & (outline.times_ps < end)]
    real = [*inside[~np.isnan(inside)].tolist(), float(at(outline, begin))]
    real = [value for value in real if value == value]
    return min(real), max(real)


def area(outline: Outline, start: int, stop: int) -> float:
    """Steps that a velocity makes between two instants."""
    inside = (outline.times_ps > start) & (outline.times_ps < stop)
    times = np.concatenate([[start], outline.times_ps[inside], [stop]])
    return float((np.diff(times) * at(outline, times[:-1])).sum()) / S


def test_the_velocity_adds_up_to_the_steps(bench: Any) -> None:
    for axis in bench["x"].axes:
        velocity, steps = Velocity(axis).changes(0, bench.now_ps), axis.steps(0, bench.now_ps)
        if not len(steps):
            assert not velocity.values.any()
        if bench["x"].sheet.dialect.name == "packets":  # even in a cycle: within a step of the pulses at every instant
            travelled = np.append(0, np.cumsum(steps.directions))
            for time in np.random.default_rng(1).integers(0, bench.now_ps, 60).tolist():
                made = travelled[np.searchsorted(steps.times_ps, time, side="right")]
                assert abs(area(velocity, 0, time) - made) < 1.001 + len(axis.offsets)  # a load forgets the rest
            continue
        cuts = [m.end.time_ps for m in axis.motions(0, bench.now_ps) if m.end is not None and m.end.why == "cut"]
        assert len(cuts) == (bench["x"].sheet.dialect.name == "lines"), "K"
        for sign, begin, end in zip(steps.directions, steps.times_ps, [*steps.times_ps[1:], bench.now_ps], strict=True):
            made = sign * area(velocity, int(begin), int(end))
            if any(begin < cut < end for cut in cuts):
                assert 0 < made < 0.99, "the step is not completed"
                continue
            assert made == pytest.approx(1, rel=1e-6)


def test_within_a_train_the_velocity_is_one_over_the_interval(bench: Any) -> None:
    if bench["x"].sheet.dialect.name == "packets":
        pytest.skip("moves evenly within cycles")
    axis = bench["x"].axes[0]
    steps, now = axis.steps(0, bench.now_ps), bench.now_ps
    moving = 0
    for begin, end, sign in zip(
        steps.times_ps[:-1].tolist(), steps.times_ps[1:].tolist(), steps.directions, strict=False
    ):
        speeds = [axis.velocity_at(time) for time in (begin, (begin + end) // 2, end - 2)]
        if speeds[2]:  # nothing holds the next step back
            moving += 1
            assert speeds == pytest.approx([int(sign) * S / (end - begin)] * 3, rel=1e-6)
        else:
            assert speeds[0] * sign > S / (end - begin)
    assert moving > 0.8 * len(steps) and axis.velocity_at(now) == 0


def test_a_part_at_rest_has_no_velocity(bench: Any) -> None:
    """Between the moves, however short the rest is."""
    x, now = bench["x"], bench.now_ps
    axis = x.axes[0]
    steps = axis.steps(0, now)
    first, velocity = int(steps.times_ps[0]), Velocity(axis).changes(0, now)
    before = (
        8192 * S // x.crystal_hz * 200 if x.sheet.dialect.name == "packets" else 0
    )  # an S-curve begins below a step per second
    assert not at(velocity, [0, first - before - 1]).any() and velocity.values[-1] == 0
    rests = np.flatnonzero(np.diff(steps.times_ps) > 45 * MS)
    for n in rests.tolist():
        end = int(steps.times_ps[n + 1])
        if x.sheet.dialect.name != "packets":
            assert axis.velocity_at(end - 1) == 0 == axis.velocity_at(end - 20 * MS)
            assert axis.velocity_at(end) != 0


def test_velocity_at_takes_what_position_at_takes(bench: Any) -> None:
    x, now = bench["x"], bench.now_ps
    one = x.velocity_at("30 ms")
    assert isinstance(one, float) and one == x.velocity_at(30 * MS) == x.velocity_at(["1 ms", "30 ms"])[1]
    assert x.velocity_at(np.array([[30 * MS, 1], [2, 3]])).tolist()[0][0] == one
    assert x.velocity_at(np.array([], np.int64)).shape == (0,)
    with pytest.raises(UsageError, match="in the future"):
        x.velocity_at(now + 1)
    names = [(quantity.name, quantity.unit, quantity.is_staircase) for quantity in x.axis(1).quantities()[:2]]
    assert names == [("velocity", "steps/s", True), ("position", "steps", True)]


# ----------------------------------------------------------------------------------------------------- made-up pasts
CLOCK = Clock(10_000_000)  # a tick is 100 ns
TICK = 100_000


def made(seed: int, positions: range) -> Axis:
    """An axis with a register of a few positions, on which trains follow each other, are cut, and loads happen."""
    rnd, kernel = Random(seed), Kernel()
    axis = Axis(kernel, positions, positions[0])
    last: Playing | None = None
    for _ in range(rnd.randrange(1, 30)):
        kernel.run(kernel.now + TICK * rnd.choice((0, 1, 7, 40, rnd.randrange(200))))
        tick = kernel.now // TICK
        if rnd.random() < 0.2:
            axis.load(rnd.choice(positions))
            continue
        if last is not None:
            last.until = min(kernel.now + rnd.randrange(2), last.until or kernel.now + 1)
        if rnd.random() < 0.2:
            last = None
            continue
        if rnd.random() < 0.5:
            runs = [(rnd.randrange(1, 12), rnd.randrange(1, 9)) for _ in range(rnd.randrange(1, 5))]
            train: Any = StepTrain(CLOCK, tick + rnd.choice((0, 0, 3)), runs)
        else:
            law = Linear(rnd.randrange(1, 1 << 17), rnd.choice((0, 0, 300)))
            train = CycleTrain(CLOCK, tick, law, rnd.randrange(1, 20), rnd.randrange(1 << 15), cycle=16)
        last = Playing(train)
        axis.follow(last, rnd.choice((1, -1)), counted=rnd.random() < 0.9)
    kernel.run(kernel.now + 60 * TICK)
    return axis


@settings(max_examples=25)
@given(st.integers(0, 10**6), st.sampled_from([range(7), range(-3, 200)]), st.sampled_from([1, 3, 17, 60]))
def test_any_past_is_drawn_as_it_was(seed: int, positions: range, columns: int) -> None:
    axis = made(seed, positions)
    now = axis.kernel.now
    ticks = np.arange(0, now + 1, TICK)
    times = np.unique(np.concatenate([ticks, np.maximum(ticks - 1, 0)]))
    truth = [axis.position_at(time) for time in times.tolist()]
    assert axis.positions_at(times[::-1]).tolist() == truth[::-1]
    assert at(Position(axis).changes(0, now), times).tolist() == truth
    some = times[:: len(times) // 40 + 1]
    assert axis.velocities_at(some[::-1]).tolist()[::-1] == [axis.velocity_at(time) for time in some.tolist()]
    for quantity in (Position(axis), Velocity(axis)):
        keeps_what_shows(quantity, 0, now, columns)


@pytest.mark.parametrize("columns", [2, 5, 13])
def test_a_program_that_moves_over_and_over_keeps_its_peaks(columns: int) -> None:
    """Moves of which many lie in a column; the last one is faster than the others."""
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    moves = "L 9,A\rR 90\rN 90\r+\rG\r0\r"
    bench.host(x).send(f"A 0\rF 20\rR 60\rS 255\rZ 1\rE\rA$P 40\rP 0\r{moves}QX\r")
    bench.run("2 s")
    axis = x.axes[0]
    assert len(axis.past) > 15
    for quantity in (Velocity(axis), Position(axis)):
        for start in (0, bench.now_ps // 7):
            keeps_what_shows(quantity, start, bench.now_ps, columns)


def test_an_axis_that_forgets_is_still_drawn() -> None:
    axis = made(11, range(1000))
    now, half = axis.kernel.now, axis.kernel.now // 2
    before = [quantity.changes(half, now) for quantity in (Position(axis), Velocity(axis))]
    axis.forget(half)
    after = [quantity.changes(half, now) for quantity in (Position(axis), Velocity(axis))]
    for one, other in zip(before, after, strict=True):
        assert one.times_ps.tolist() == other.times_ps.tolist() and repr(one.values) == repr(other.values)
