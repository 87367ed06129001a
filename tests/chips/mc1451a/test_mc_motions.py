"""What a chipset tells of the motions of its axes: what began them, what happened, their ideals, acceleration, jerk."""

from __future__ import annotations

from random import Random
from typing import Any

import numpy as np
import pytest
from ruckig import InputParameter, Ruckig
from ruckig import Trajectory as Found

import slewline
from slewline.core.motion.quantity import Quantity

BOTH = pytest.mark.parametrize("stepwise", (False, True))
ONE = 1 << 16
PER_S = 25_000_000 / 8192
TRAPEZOID = "SET_PRFL_TRAP|SET_VEL 196608|SET_ACC 1000|SET_START_VEL 0|SET_POS 2000|UPDATE"
CURVE = "SET_PRFL_S_CRV|SET_VEL 196608|SET_MAX_ACC 1000|SET_JERK 400000|SET_POS 2000|UPDATE"


class Axis:
    """An axis of a chipset, and its host."""

    def __init__(self, commands: str = "", stepwise: bool = False, part: str = "mc1151a") -> None:
        self.bench = slewline.Bench()
        self.chip: Any = self.bench.add(part, "x", stepwise=stepwise)
        self.host, self.axis = self.bench.host(self.chip), self.chip.axis(1)
        self.says(commands)

    def says(self, commands: str) -> None:
        for command in filter(None, commands.split("|")):
            name, *value = command.split()
            self.host.command(name, *map(int, value))

    def rests(self) -> Any:
        self.bench.run("1 ms")
        self.bench.run_until_idle(timeout="1000 s")
        self.bench.run("1 ms")
        return self.axis

    @property
    def marks(self) -> list[tuple[str, str]]:
        return [(mark.kind, mark.text) for mark in self.axis.marks()]

    def quantity(self, name: str) -> Quantity:
        return next(quantity for quantity in self.axis.quantities() if quantity.name == name)


@BOTH
def test_a_motion_names_its_command_and_the_registers_in_force(stepwise: bool) -> None:
    mover = Axis(TRAPEZOID, stepwise)
    mover.bench.run("100 ms")
    mover.says("SET_VEL 131072|SET_POS -700|UPDATE")
    first, second = mover.rests().motions()
    assert (first.text, first.rates, first.notes) == (
        "UPDATE",
        {"VEL = 196608": 3 * PER_S},
        {"ACC": 1000, "POS": 2000},
    )
    assert second.rates == {"VEL = 131072": 2 * PER_S} and second.notes == {"ACC": 1000, "POS": -700}
    assert first.ideal.stop == second.time_ps == second.ideal.start and first.ideal.interrupted
    assert second.ideal.velocities(np.array([second.time_ps])) == pytest.approx([3 * PER_S])
    assert second.ideal.positions(np.array([second.ideal.stop])) == pytest.approx([-700])


@BOTH
@pytest.mark.parametrize(
    "commands, kind, text",
    [
        ("STOP|UPDATE", "command", "STOP"),
        ("SMOOTH_STOP|UPDATE", "command", "SMOOTH_STOP"),
        ("MTR_OFF", "event", "motor off"),
        ("SET_PRFL_S_CRV", "command", "SET_PRFL_S_CRV"),
        ("SET_ACTL_POS 77", "command", "SET_ACTL_POS 77"),
    ],
)
def test_commands_that_change_a_motion_are_marked(commands: str, kind: str, text: str, stepwise: bool) -> None:
    mover = Axis(TRAPEZOID, stepwise)
    mover.bench.run("100 ms")
    mover.says(commands)
    (motion,) = mover.rests().motions()
    assert mover.marks == [(kind, text)] and motion.ideal.stop == mover.axis.marks()[0].time_ps


@BOTH
def test_limits_breakpoints_and_gears(stepwise: bool) -> None:
    mover = Axis(f"SET_BRK_PNT 50|SET_POS_BRK|{TRAPEZOID}|SET_POS 1000", stepwise)
    mover.rests()
    assert mover.marks == [("event", "SET_POS_BRK met")]
    assert [motion.text for motion in mover.axis.motions()] == ["UPDATE", "SET_POS_BRK"]
    mover = Axis(TRAPEZOID, stepwise)
    mover.bench.run("100 ms")
    mover.chip.pin("poslimit1").drive(1)
    mover.rests()
    assert mover.marks == [("limit", "PosLimit")]
    mover = Axis("SET_RATIO 70000|UPDATE", stepwise, "mc1151a-e")
    mover.bench.run("2 ms")
    mover.says("SET_PRFL_GEAR")
    mover.bench.run("2 ms")
    mover.says("SET_RATIO -5|UPDATE")
    mover.bench.run("2 ms")
    found = [(gear.text, gear.rates, gear.notes, gear.ideal) for gear in mover.axis.motions()]
    assert found == [("SET_PRFL_GEAR", {}, {"RATIO": 70000}, None), ("UPDATE", {}, {"RATIO": -5}, None)]


def test_a_reset_ends_the_ideal() -> None:
    mover = Axis(TRAPEZOID)
    mover.bench.run("100 ms")
    mover.chip.reset()
    now = mover.bench.now_ps
    mover.bench.run("10 ms")
    assert mover.axis.motions()[0].ideal.stop == now


def test_the_ideal_trapezoid_is_the_continuous_one() -> None:
    for start in (0, 30000):
        mover = Axis(TRAPEZOID.replace("START_VEL 0", f"START_VEL {start}"))
        ideal = mover.rests().motions()[0].ideal
        v, a, s = 3 * PER_S, 1000 / ONE * PER_S**2, start / ONE * PER_S
        up = (v - s) / a
        gained = (v * v - s * s) / (2 * a)
        at = ideal.start + np.rint(np.linspace(0, up, 30) * 1e12).astype(np.int64)
        t = (at - ideal.start) / 1e12
        assert ideal.velocities(at[:-1]) == pytest.approx(s + a * t[:-1])
        assert ideal.positions(at) == pytest.approx(s * t + a * t * t / 2)
        assert (ideal.stop - ideal.start) / 1e12 == pytest.approx(2 * up + (2000 - 2 * gained) / v)


def test_the_ideal_of_velocity_contouring_reverses_through_rest() -> None:
    mover = Axis("SET_PRFL_VEL|SET_VEL 196608|SET_ACC 1000|UPDATE")
    mover.bench.run("300 ms")
    mover.says("SET_ACC -2000|UPDATE")
    mover.bench.run("300 ms")
    ideal = mover.axis.motions()[1].ideal
    braking = 3 * PER_S / (2000 / ONE * PER_S**2)
    at = ideal.start + np.rint(np.array([0, 1, 2, 9]) * braking * 1e12).astype(np.int64)
    assert ideal.velocities(at) == pytest.approx([3 * PER_S, 0, -3 * PER_S, -3 * PER_S], abs=1e-6)


def ruckig(distance: int, velocity: int, acceleration: int, jerk: int, times: Any) -> Any:
    """Position, velocity and acceleration of the time-optimal curve of a library; steps and cycles; and its time."""
    asked, found = InputParameter(1), Found(1)
    asked.current_position, asked.target_position = [0.0], [float(distance)]
    asked.max_velocity, asked.max_acceleration = [velocity / ONE], [acceleration / ONE]
    asked.max_jerk = [jerk / ONE**2]
    assert Ruckig(1).calculate(asked, found) in (0, 1)
    return found.duration, np.array([[each[0] for each in found.at_time(float(time))] for time in times])


def test_the_ideal_s_curve_its_acceleration_and_jerk_are_those_of_a_library() -> None:
    for distance, velocity, acceleration, jerk in (
        (2000, 3 * ONE, 1000, 400_000),
        (2000, 3 * ONE, 1000, 4_000_000),
        (-900, 5 * ONE, 800, 900_000),
        (300, 15 * ONE, 32000, 1_000_000),
    ):
        mover = Axis("SET_PRFL_S_CRV")
        mover.says(f"SET_VEL {velocity}|SET_MAX_ACC {acceleration}|SET_JERK {jerk}|SET_POS {distance}|UPDATE")
        ideal = mover.rests().motions()[0].ideal
        cycles = (ideal.stop - ideal.start) / 1e12 * PER_S
        at = np.linspace(0, cycles, 200)[:-1]
        duration, curve = ruckig(distance, velocity, acceleration, jerk, at)
        times = ideal.start + np.rint(at / PER_S * 1e12).astype(np.int64)
        assert cycles == pytest.approx(duration, rel=1e-6)
        assert ideal.positions(times) == pytest.approx(curve[:, 0], abs=1e-4)
        assert ideal.velocities(times) / PER_S == pytest.approx(curve[:, 1], abs=1e-6)
        assert mover.quantity("acceleration").at(times) / PER_S**2 == pytest.approx(curve[:, 2], abs=1e-6)
        assert set(np.rint(np.abs(mover.quantity("jerk").at(times)) / PER_S**3 * ONE**2)) <= {0, jerk}


def test_no_motion_leaves_its_ideal_by_more_than_its_cycles_allow() -> None:
    """A step; of trapezoids half a cycle at the greatest velocity; of S-curves what a cycle bends, and a tick."""
    chance, used = Random(3), {"SET_PRFL_TRAP": 0.0, "SET_PRFL_S_CRV": 0.0}
    for _ in range(18):
        profile, velocity = chance.choice([*used]), chance.randrange(3000, 16 * ONE)
        acceleration = min(max(velocity // chance.randrange(2, 300), 1), 32767)
        start = chance.choice((0, velocity // 8)) if profile == "SET_PRFL_TRAP" else 0
        jerk, position = (acceleration << 16) // chance.randrange(1, 200), chance.randrange(-9000, 9000)
        mover = Axis(
            f"{profile}|SET_VEL {velocity}|SET_ACC {acceleration}|SET_MAX_ACC {acceleration}|SET_START_VEL {start}"
            f"|SET_JERK {jerk}|SET_POS {position}|UPDATE"
        )
        axis = mover.rests()
        found = axis.deviation(axis.motions()[0])
        if profile == "SET_PRFL_TRAP":
            more = velocity / ONE / 2
        else:
            more = acceleration / ONE / 8 + velocity / ONE / 8192 + 2 / ONE
            assert abs(found.velocity) <= (acceleration / 2 + 2) / ONE * PER_S
        assert abs(found.position) <= 1 + more
        used[profile] = max(used[profile], (abs(found.position) - 0.9) / (0.1 + more))
    assert min(used.values()) > 0.5


def test_acceleration_adds_up_to_velocity_and_jumps_have_none() -> None:
    mover = Axis(TRAPEZOID)
    mover.rests()
    acceleration = mover.quantity("acceleration")
    times, values = acceleration.changes(0, mover.bench.now_ps)
    assert times[0] == 0 and times[-1] == mover.bench.now_ps and np.trapezoid(values, times) == pytest.approx(0, abs=10)
    cycles = mover.axis.cycles()
    gained = np.diff(cycles.velocities) / ONE * PER_S**2
    assert acceleration.at(cycles.times_ps[1:]) == pytest.approx(gained)
    assert [quantity.name for quantity in mover.axis.quantities()] == ["velocity", "position", "acceleration"]
    mover = Axis(TRAPEZOID.replace("START_VEL 0", "START_VEL 60000"))
    mover.bench.run("100 ms")
    mover.says("STOP|UPDATE")
    mover.rests()
    greatest = 1000 / ONE * PER_S**2
    values = mover.quantity("acceleration").changes(0, mover.bench.now_ps).values
    assert values.max() == pytest.approx(greatest) and values.min() == 0


def test_phases_of_s_curves_begin_and_end_with_the_curve_not_with_cycles() -> None:
    mover = Axis(CURVE)
    axis = mover.rests()
    phases, ideal = axis.phases(), axis.motions()[0].ideal
    assert [text for _, _, text in phases] == list("1234567")
    assert phases[0][0] == ideal.start and phases[-1][1] == pytest.approx(ideal.stop, abs=40_000)
    assert [end for _, end, _ in phases[:-1]] == [begin for begin, _, _ in phases[1:]]
    jerked = phases[0][1] - phases[0][0]
    assert jerked / 1e12 * PER_S == pytest.approx((1000 << 16) / 400_000)
    middle = (phases[2][0] + phases[4][1]) // 2
    assert axis.phases(stop=middle) == [*phases[:3], (phases[3][0], middle, "4")]
    jerk = mover.quantity("jerk")
    times, values = jerk.changes(0, mover.bench.now_ps)
    assert times.tolist() == [0, *(begin for begin, _, _ in phases), phases[-1][1]]
    assert np.sign(values).tolist() == [0, 1, 0, -1, 0, -1, 0, 1, 0]


def test_a_smooth_stop_leaves_out_the_phases_that_it_cuts() -> None:
    mover = Axis(CURVE)
    mover.bench.run("60 ms")
    mover.says("SMOOTH_STOP|UPDATE")
    axis = mover.rests()
    assert [text for _, _, text in axis.phases()] == list("123567")
    times, values = mover.quantity("acceleration").changes(0, mover.bench.now_ps)
    assert np.trapezoid(values, times) == pytest.approx(0, abs=abs(values).max() * 1e6)


def test_the_slow_twin_has_velocity_and_position_alone() -> None:
    axis = Axis(CURVE, stepwise=True).rests()
    assert [quantity.name for quantity in axis.quantities()] == ["velocity", "position"] and not axis.phases()
