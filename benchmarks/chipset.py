"""The MC1451A family on a bench: four axes for ten virtual seconds, encoders, packets, moves.

A host at the pins of the port starts the axes, time passes, and their motion is queried afterwards, pulse by pulse or
cycle by cycle.  Pulses and cycles are computed from the same law in different ways, and are compared before a figure is
accepted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from random import Random
from statistics import median
from typing import Any

import numpy as np
import profiled
from rows import REAL, Row, best, best_of, timed

import slewline
from slewline.bench.scripts.script import run_script

ONE = 1 << 16  # a step
TOP = 512 * ONE  # 1.5625 Mpulses/s
SECOND = 10**12  # ps
STRETCH_PS = 640 * SECOND // 1000  # a million steps at top speed
TEN_MS = SECOND // 100
CYCLES_A_SECOND = 3052
AXES = range(1, 5)
ALL = 0b1111

Setting = tuple[Any, ...]  # a mnemonic, and its arguments


# ----------------------------------------------------------------------------------------------------------- four axes
@dataclass
class Ran:
    """A chip whose axes have moved forward, from 0, between two instants."""

    chip: Any
    begin: int
    end: int

    @property
    def seconds(self) -> float:
        """Virtual seconds."""
        return (self.end - self.begin) / SECOND

    @property
    def stretches(self) -> list[tuple[int, int]]:
        """The time between the two instants, in parts of at most a million steps."""
        starts = range(self.begin, self.end + 1, STRETCH_PS)
        return [(start, min(start + STRETCH_PS - 1, self.end)) for start in starts]

    def expand(self, buffer: np.ndarray) -> int:
        """Write every pulse of every axis into a buffer; return their number."""
        motors = [self.chip.axis(n).motor for n in AXES]
        return sum(len(motor.times(start, stop, buffer)) for motor in motors for start, stop in self.stretches)

    def cycles(self) -> list[Any]:
        """Return targets, velocities and phases of every cycle of every axis."""
        return [self.chip.axis(n).cycles(self.begin, self.end) for n in AXES]

    def check(self) -> int:
        """Check that the pulses up to the start of each cycle equal the target; return the number of pulses."""
        total = 0
        for n, cycles in zip(AXES, self.cycles(), strict=True):
            count, steps = 0, cycles.targets // ONE
            for start, stop in self.stretches:
                here = slice(*np.searchsorted(cycles.times_ps, (start, stop + 1)))
                found = self.chip.axis(n).steps(start, stop)
                so_far = np.searchsorted(found.times_ps, cycles.times_ps[here], side="right")
                assert (count + so_far == steps[here]).all() and (np.diff(found.times_ps) > 0).all()
                assert (found.positions == np.arange(count, count + len(found)) + 1).all()
                count += len(found)
            assert count == self.chip.axis(n).position > 0
            total += count
        return total


def furnished(part: str, *settings: Setting) -> tuple[slewline.Bench, Any, Any]:
    """Return a bench with a chip, ideal encoders if supported, and a host that has sent every axis its settings."""
    bench = slewline.Bench()
    chip = bench.add(part)
    host = bench.host(chip)
    if chip.sheet.encoder:
        for n in AXES:
            bench.part("encoder", f"shaft{n}", to=chip, axis=n, counts=400, steps=400)
    told(host, *settings)
    return bench, chip, host


def told(host: Any, *settings: Setting) -> None:
    """Send every axis of a chip its settings."""
    for n in range(1, host.chip.sheet.axes + 1):
        for name, *values in settings:
            host.axis(n).command(name, *values)


def contour(velocity: int, acceleration: int) -> Callable[[], Callable[[], Ran]]:
    """Return velocity contouring on four axes, up to a velocity and on at that velocity."""

    def prepared() -> Callable[[], Ran]:
        settings = ("SET_PRFL_VEL",), ("SET_OUTPUT_HIGH",), ("SET_VEL", velocity), ("SET_ACC", acceleration)
        bench, chip, host = furnished("mc1451a", *settings)
        begin = bench.now_ps
        host.command("MULTI_UPDATE", ALL)

        def run() -> Ran:
            bench.run("10 s")
            return Ran(chip, begin, bench.now_ps)

        return run

    return prepared


def curves() -> Callable[[], Ran]:
    """Return ten S-curves of a second on four axes, each up to 500 steps per cycle, with packets in between."""
    jerked = 763  # cycles
    distance, jerk = 2 * jerked * (TOP // ONE), TOP * ONE // jerked**2
    settings = ("SET_PRFL_S_CRV",), ("SET_OUTPUT_HIGH",), ("SET_VEL", TOP), ("SET_MAX_ACC", 32767), ("SET_JERK", jerk)
    bench, chip, host = furnished("mc1451a", *settings)

    def run() -> Ran:
        begin = bench.now_ps
        for move in range(1, 11):
            told(host, ("SET_POS", move * distance))
            host.command("MULTI_UPDATE", ALL)
            bench.run_until_idle()
        assert [chip.axis(n).position for n in AXES] == [10 * distance] * 4
        return Ran(chip, begin, bench.now_ps)

    return run


PROMISED = "a few events; pulses are kept as trains, not simulated one by one"
CASES = (
    ("at 1.5625 Mpulses/s", contour(TOP, TOP), PROMISED),
    ("at 61 % of 1.5625 Mpulses/s", contour(TOP * 61 // 100, TOP), PROMISED),
    ("in ramps throughout", contour(TOP, TOP // 30_518), PROMISED),
    ("in ten S-curves each", curves, "90 packets between the S-curves"),
)


def axes() -> list[Row]:
    """Return the rows of four axes for ten virtual seconds."""
    return [row for case in CASES for row in asked(*case)]


def asked(name: str, prepare: Callable[[], Callable[[], Ran]], passing: str) -> Iterator[Row]:
    """Yield rows for the passing of time, and for queries of every pulse, of every cycle, and of windows of 10 ms."""
    wall, ran = best_of(prepare)
    yield Row(f"four axes {name}, 10 s", ran.seconds / wall, REAL, None, True, passing)
    pulses = ran.check()
    buffer = np.empty(1 << 20, np.int64)
    assert ran.expand(buffer) == pulses
    wall = best(lambda: ran.expand(buffer))
    bound = f"expanding the trains above: {pulses / wall / 1e6:.0f} M pulses/s"
    yield Row("the same: every pulse expanded", ran.seconds / wall, REAL, 20, True, bound)
    wall, count = best(ran.cycles), sum(map(len, ran.cycles()))
    bound = f"arrays of targets, velocities, instants, phases: {wall / count * 1e9:.0f} ns per cycle"
    yield Row("the same: all cycles", ran.seconds / wall, REAL, 1000, True, bound)
    times, steps = windows(ran)
    bound = f"finding and expanding the instants ({times:.2g} ms), then the directions and positions"
    yield Row("the same: the steps of an axis in any window of 10 ms", steps, "ms", 1, False, bound)


def windows(ran: Ran) -> tuple[float, float]:
    """Return the slowest of fifty windows of 10 ms, in milliseconds: instants alone, and steps.

    All other windows are queried before each one, because a train caches its last window.
    """
    axis, random = ran.chip.axis(1), Random(1)
    starts = [random.randrange(ran.begin, ran.end - TEN_MS) for _ in range(50)]

    def slowest(call: Callable[[int, int], object]) -> float:
        rounds = [[timed(partial(call, start, start + TEN_MS))[0] for start in starts] for _ in range(7)]
        return float(max(map(min, zip(*rounds, strict=True)))) * 1000

    return slowest(axis.motor.times), slowest(axis.steps)


# ------------------------------------------------------------------------------------------------------------ encoders
def encoders() -> list[Row]:
    """Return the rows of stall detection on four axes, with an encoder each, and of gears that follow a master."""
    rows = []
    for counts, velocity, goal, polls in (
        ("953,125", TOP * 61 // 100, None, 0),
        ("781,250", TOP // 2, 2, 100),
        ("48,828", 16 * ONE, None, 0),
    ):
        wall, (chip, host) = best_of(partial(armed, velocity, polls), 3)
        told(host, ("STOP",), ("UPDATE",))
        host.command("GET_TIME")
        for n in AXES:
            actual, error = (host.axis(n).query(name) for name in ("GET_ACTL_POS", "GET_ACTL_POS_ERR"))
            assert actual == chip.axis(n).position > velocity * 3000 // ONE and abs(error) <= 1
        name = f"stall detection, four encoders at {counts} counts/s"
        bound = profiled.bound(name, partial(armed, velocity, polls), 4 * CYCLES_A_SECOND, "per cycle and axis")
        if polls:
            name, bound = f"{name}, each read every 10 ms", f"{bound}; {4 * polls} packets"
        rows.append(Row(name, 1 / wall, REAL, goal, True, bound))
    for number in (1, 4):
        wall, (chip, host) = best_of(partial(geared, number), 3)
        for n in range(1, number + 1):
            behind = host.axis(n).query("GET_ACTL_POS") - host.axis(n).query("GET_TRGT_POS")
            assert chip.axis(n).position > 39_900 and 0 <= behind < 400  # the host reads one after the other
        name = f"gear, {'one axis follows' if number == 1 else 'four axes follow'} 40,000 counts/s"
        bound = profiled.bound(name, partial(geared, number), number * CYCLES_A_SECOND, "per cycle and axis")
        rows.append(Row(name, 1 / wall, REAL, None, True, bound))
    return rows


def armed(velocity: int, polls: int = 0) -> Callable[[], tuple[Any, Any]]:
    """Return a second of four axes, which would stop at an error of eleven counts; a host polls them `polls` times."""
    contouring = ("SET_PRFL_VEL",), ("SET_OUTPUT_HIGH",), ("SET_VEL", velocity), ("SET_ACC", velocity)
    detection = ("SET_STEP_RATIO", 256), ("SET_POS_ERR", 10), ("SET_AUTO_STOP_ON",)
    bench, chip, host = furnished("mc1451a-e", *contouring, *detection)

    def run() -> tuple[Any, Any]:
        host.command("MULTI_UPDATE", ALL)
        end = bench.now_ps + SECOND
        for poll in range(polls):
            bench.run_to(end - (polls - poll) * TEN_MS)
            for n in AXES:
                host.axis(n).query("GET_ACTL_POS")
        bench.run_to(end)
        return chip, host

    return run


def geared(number: int) -> Callable[[], tuple[Any, Any]]:
    """Return a second of some axes, each of which follows a master count by count."""
    bench = slewline.Bench()
    chip = bench.add("mc1451a-e")
    host = bench.host(chip)
    masters = [bench.part("quadrature", f"master{n}", to=chip, axis=n) for n in range(1, number + 1)]
    told(host, ("SET_PRFL_GEAR",), ("SET_RATIO", ONE))
    host.command("MULTI_UPDATE", ALL)

    def run() -> tuple[Any, Any]:
        for master in masters:
            master.run(40_000)
        bench.run("1 s")
        return chip, host

    return run


# --------------------------------------------------------------------------------------------------- packets and moves
def packets() -> list[Row]:
    """Return the rows of 1,000 packets through the pins, from a host without delays: a mix, and status queries."""

    def mixed(host: Any) -> None:
        for number in range(250):
            host.command("SET_POS", number)
            assert host.query("GET_POS") == number
            assert host.query("GET_STATUS") == 0x0300
            host.command("CLR_STATUS")

    def one_by_one(host: Any) -> None:
        assert {host.query("GET_STATUS") for _ in range(1000)} == {0x0300}

    def queued(host: Any) -> None:
        host.send("GET_STATUS\n" * 1000)
        host.query("GET_STATUS")
        assert host.received[-2:] == [0x0300, 0x0331]

    def prepared(talk: Callable[[Any], None]) -> Callable[[], Callable[[], int]]:
        def prepare() -> Callable[[], int]:
            bench, _, host = furnished("mc1451a")

            def run() -> int:
                begin = bench.now_ps
                talk(host)
                return bench.now_ps - begin

            return run

        return prepare

    rows = []
    for name, talk in (
        ("1,000 packets through the pins", mixed),
        ("1,000 times GET_STATUS, one by one", one_by_one),
        ("1,000 times GET_STATUS, queued", queued),
    ):
        wall, virtual = best_of(prepared(talk))
        bound = profiled.bound(name, prepared(talk), 1000, "per packet")
        rows.append(Row(name, virtual / SECOND / wall, REAL, None, True, bound))
    return rows


TRAPEZOID = ("SET_VEL", 4 * ONE), ("SET_ACC", 4096)
S_CURVE = ("SET_PRFL_S_CRV",), ("SET_VEL", 4 * ONE), ("SET_MAX_ACC", 4096), ("SET_JERK", 1 << 20)
MOVES = 200


def moves() -> list[Row]:
    """Return the rows of the time of a whole move."""
    rows = []
    for name, settings, runs in (
        ("trapezoid", TRAPEZOID, "four runs and their starting instants"),
        ("S-curve", S_CURVE, "one run and its starting instant"),
    ):
        pairs = [(moved("CLR_STATUS", settings), moved("UPDATE", settings)) for _ in range(9)]  # by turns
        packets, move = (median(column) for column in zip(*((one, both - one) for one, both in pairs), strict=True))
        bound = f"{runs}; for comparison: two packets take {packets * 1e6:.0f} µs"
        rows.append(Row(f"a move, {name}: plan and simulate", move * 1e6, "µs", None, False, bound))
    return rows


def moved(begins: str, settings: tuple[Setting, ...]) -> float:
    """Return the seconds of a move back and forth, with its packets; without a command, of the packets alone."""
    positions = [(6000 + number) * (1 - number % 2) for number in range(MOVES)]

    def prepare() -> Callable[[], Any]:
        bench, chip, host = furnished("mc1151a", *settings)

        def run() -> Any:
            for position in positions:
                host.command("SET_POS", position)
                host.command(begins)
                bench.run_until_idle()
            return chip

        return run

    wall, chip = best_of(prepare, 1)
    steps = int(np.abs(np.diff([0, *positions])).sum()) if begins == "UPDATE" else 0
    assert len(chip.steps()) == steps
    return wall / MOVES


def scripts() -> list[Row]:
    """Return the rows of random moves from scripts: one waits for the interrupt, one polls the status."""
    rows = []
    for number, waits, how in (
        (1000, ("@until hostintrpt=0", "RST_INTRPT 0"), "waiting for the interrupt"),
        (100, ("wait motion_complete", "CLR_STATUS"), "polling the status"),
    ):
        prepare, name = partial(scripted, number, waits), f"{number:,} random moves of a script, {how}"
        wall, virtual = best_of(prepare, 3)
        bound = profiled.bound(name, prepare, number, "per move")
        rows.append(Row(name, virtual / wall, REAL, None, True, bound))
    return rows


def scripted(number: int, waits: tuple[str, ...]) -> Callable[[], float]:
    """Return a script of random moves; each must end at its target, and every line must have its expected result."""
    random, lines = Random(1), ["SET_INTRPT_MASK 1"]
    for _ in range(number):
        position = random.randrange(-5000, 5000)
        velocity, acceleration = random.randrange(ONE // 2, 16 * ONE), random.randrange(1 << 10, 1 << 15)
        lines += [f"SET_POS {position}", f"SET_VEL {velocity}", f"SET_ACC {acceleration}", "UPDATE", *waits]
        lines += ["GET_TRGT_POS", f"expect {position}"]
    bench, chip, host = furnished("mc1151a")

    def run() -> float:
        run_script(bench, host, lines)
        bench.run_until_idle("1 h")
        assert len(host.results) == number and not bench.findings and chip.position == position
        return bench.now_ps / SECOND

    return run
