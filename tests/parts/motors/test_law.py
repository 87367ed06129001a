"""What a motor is asked for, its names and its traces: quick tests; what it does is in tests/physics."""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest

from slewline.errors import UnknownName, UsageError
from slewline.parts.motors.law import CHOPPED_PS, STEP_PS, MotorLaw
from slewline.parts.motors.motor_data import DriverData, LoadData, MotorData
from tests.rows import rows

A = MotorData(name="A", current=1.0, resistance=5.0, inductance=8e-3, torque=0.49, inertia=6.8e-6, iron=2e-3)
UNIPOLAR = replace(A, name="U", windings="unipolar")
RELUCTANCE = MotorData(
    name="VR", windings="reluctance", teeth=12, current=1.0, resistance=5.0, inductance=8e-3, swing=5e-3, inertia=4e-6
)  # fmt: skip
HELD = DriverData(kind="current", current=1.0)
VOLTS = DriverData(kind="voltage", supply=20.0, series=15.0)
CHOPPER = DriverData(kind="chopper", supply=24.0, current=1.0)


# ------------------------------------------------------------------------------------------------------------- a motor
def test_constant_of_a_phase_follows_from_how_the_torque_is_rated() -> None:
    assert A.constant == pytest.approx(0.49 / sqrt(2))
    assert replace(A, rated="one").constant == 0.49


def test_iron_loss_is_reckoned_from_the_torque_unless_it_is_given() -> None:
    assert replace(A, iron=None, viscous=1e-5).drag == pytest.approx(2.66e-3 * 0.49 + 1e-5)
    assert A.drag == 2e-3


@pytest.mark.parametrize(("motor", "steps"), [(A, 200), (RELUCTANCE, 48), (replace(RELUCTANCE, phases=3), 36)])
def test_full_steps_a_turn(motor: MotorData, steps: int) -> None:
    assert motor.full_steps == steps
    assert motor.step == pytest.approx(2 * pi / steps)


# --------------------------------------------------------------------------------------------------------------- steps
@rows(
    ("steps", "micro", "cycle"),
    [("full", 1, 4), ("wave", 1, 4), ("half", 2, 8), ("micro 8", 8, 32), ("micro16", 16, 64)],
)
def test_commands_a_full_step_and_an_electrical_turn(steps: str, micro: int, cycle: int) -> None:
    law = MotorLaw(A, HELD, steps=steps)
    assert (law.micro, law.cycle, len(law.table)) == (micro, cycle, 4 * cycle)


@rows("steps", ["", "quarter", "micro", "micro 0", "micro 08", "micro 10000", "Full", "full "])
def test_other_steps_are_refused(steps: str) -> None:
    with pytest.raises(UsageError, match=r"allowed 'full', 'wave', 'half', or 'micro' and a number"):
        MotorLaw(A, HELD, steps=steps)


def test_grid_is_finer_with_a_chopper_unless_it_is_given() -> None:
    assert MotorLaw(A, HELD).step_ps == STEP_PS
    assert MotorLaw(A, CHOPPER).step_ps == CHOPPED_PS
    assert MotorLaw(A, CHOPPER, step_ps=5_000_000).step_ps == 5_000_000


@rows(
    ("motor", "driver", "load", "steps", "message"),
    [
        (UNIPOLAR, CHOPPER, LoadData(), "full", r"U: unipolar windings with a driver of kind 'chopper'; allowed: kind"),
        (
            RELUCTANCE,
            HELD,
            LoadData(),
            "full",
            r"VR: reluctance windings with a driver of kind 'current'; allowed: kind 'voltage'",
        ),
        (RELUCTANCE, VOLTS, LoadData(), "micro 4", r"VR \(reluctance\): steps 'micro 4'; allowed 'full'"),
        (replace(RELUCTANCE, phases=5), VOLTS, LoadData(), "full", r"VR: 5 phases of a reluctance motor; allowed 3, 4"),
        (A, HELD, LoadData(stiffness=10.0), "full", r"inertia 0.0 on a coupling; allowed more than 0"),
    ],
)
def test_incompatible_arguments_are_refused(
    motor: MotorData, driver: DriverData, load: LoadData, steps: str, message: str
) -> None:
    with pytest.raises(UsageError, match=message):
        MotorLaw(motor, driver, load, steps=steps)


# --------------------------------------------------------------------------------------------------------------- table
R = sqrt(2)


@rows(
    ("driver", "steps", "rows"),
    [
        (HELD, "full", [(1, 1), (-1, 1), (-1, -1), (1, -1)]),
        (HELD, "wave", [(1, 0), (0, 1), (-1, 0), (0, -1)]),
        (HELD, "half", [(1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)]),
        (replace(HELD, boost=True), "half", [(1, 1), (0, R), (-1, 1), (-R, 0), (-1, -1), (0, -R), (1, -1), (R, 0)]),
        (replace(HELD, boost=True), "full", [(1, 1), (-1, 1), (-1, -1), (1, -1)]),
        (HELD, "micro 2", [(1, 1), (0, R), (-1, 1), (-R, 0), (-1, -1), (0, -R), (1, -1), (R, 0)]),
        (VOLTS, "full", [(20, 20), (-20, 20), (-20, -20), (20, -20)]),
        (VOLTS, "micro 1", [(20 / R, 20 / R), (-20 / R, 20 / R), (-20 / R, -20 / R), (20 / R, -20 / R)]),
        (DriverData(kind="bilevel", supply=5.0, high=40.0), "wave", [(1, 0), (0, 1), (-1, 0), (0, -1)]),
    ],
)
def test_rows_of_two_windings(driver: DriverData, steps: str, rows: list[tuple[float, float]]) -> None:
    law = MotorLaw(A, driver, steps=steps)
    assert np.array(law.table[: law.cycle]) == pytest.approx(np.array(rows, float), abs=1e-12)


def test_a_microstep_of_zero_current_has_no_current_at_all() -> None:
    rows = MotorLaw(A, HELD, steps="micro 64").table
    assert [n for n, row in enumerate(rows[:256]) if 0.0 in row] == [32, 96, 160, 224]
    assert 0.0 not in [
        part for row in MotorLaw(A, VOLTS, steps="micro 64").table[:256] for part in row
    ]  # 0 V, not open


@pytest.mark.parametrize(
    ("steps", "rows"),
    [
        ("full", ["1010", "0110", "0101", "1001"]),
        ("wave", ["1000", "0010", "0100", "0001"]),
        ("half", ["1010", "0010", "0110", "0100", "0101", "0001", "1001", "1000"]),
    ],
)
def test_rows_of_half_windings(steps: str, rows: list[str]) -> None:
    law = MotorLaw(UNIPOLAR, VOLTS, steps=steps)
    assert ["".join(str(int(part)) for part in row) for row in law.table[: law.cycle]] == rows


@rows(
    ("phases", "steps", "rows"),
    [
        (4, "full", ["1100", "0110", "0011", "1001"]),
        (4, "wave", ["1000", "0100", "0010", "0001"]),
        (4, "half", ["1100", "0100", "0110", "0010", "0011", "0001", "1001", "1000"]),
        (3, "full", ["110", "011", "101"]),
        (3, "wave", ["100", "010", "001"]),
        (3, "half", ["110", "010", "011", "001", "101", "100"]),
    ],
)
def test_rows_of_a_reluctance_motor(phases: int, steps: str, rows: list[str]) -> None:
    law = MotorLaw(replace(RELUCTANCE, phases=phases), VOLTS, steps=steps)
    assert ["".join(str(int(part)) for part in row) for row in law.table[: law.cycle]] == rows


def test_levels_of_current_are_rows_after_each_other() -> None:
    law = MotorLaw(A, replace(HELD, rest=0.25, ramp=1.5))
    levels = [law.table[law.code(5, level)] for level in ("slew", "ramp", "rest", "off")]
    assert levels == [(-1.0, 1.0), (-1.5, 1.5), (-0.25, 0.25), (0.0, 0.0)]
    assert law.code(-1) == 3


@pytest.mark.parametrize("motor", [UNIPOLAR, RELUCTANCE])
def test_transistors_are_on_at_each_level_but_off(motor: MotorData) -> None:
    law = MotorLaw(motor, replace(VOLTS, rest=0.1))
    on = [sum(law.table[law.code(0, level)]) for level in ("slew", "ramp", "rest", "off")]
    assert on == [2, 2, 2, 0]


# --------------------------------------------------------------------------------------------------------------- phases
def test_fields_of_phases_that_are_on() -> None:
    law = MotorLaw(A, HELD, steps="half", phased=True)
    commands = MotorLaw(UNIPOLAR, VOLTS, steps="half").table[:8]
    bits = [sum(1 << n for n, on in enumerate(row) if on) for row in commands]
    assert [law.fields[each] for each in bits] == list(range(8))
    assert law.fields[0] is law.fields[3] is law.fields[15] is None
    assert law.table[0b0101] == (1.0, 1.0)
    assert law.table[0b1111] == (0.0, 0.0)


# ------------------------------------------------------------------------------------------------------- names, at rest
@rows(
    ("law", "names"),
    [
        (MotorLaw(A, HELD), "theta omega i1 i2"),
        (MotorLaw(A, VOLTS), "theta omega i1 i2"),
        (MotorLaw(UNIPOLAR, VOLTS), "theta omega i1 i2 i3 i4"),
        (MotorLaw(replace(RELUCTANCE, phases=3), VOLTS), "theta omega i1 i2 i3"),
        (MotorLaw(A, CHOPPER), "theta omega i1 i2 clock asked on1 on2"),
        (MotorLaw(A, replace(CHOPPER, decay="mixed", least_on=1e-6)),
         "theta omega i1 i2 clock asked on1 on2 blank1 blank2 fast1 fast2"),
        (MotorLaw(A, replace(VOLTS, kind="bilevel")), "theta omega i1 i2 until1 until2"),
        (MotorLaw(A, VOLTS, LoadData(inertia=1e-5, stiffness=9.0)), "theta omega i1 i2 theta2 omega2"),
        (MotorLaw(A, VOLTS, LoadData(damper_inertia=1e-5, damper_drag=1e-3)), "theta omega i1 i2 omega3"),
    ],
)  # fmt: skip
def test_names_of_the_state(law: MotorLaw, names: str) -> None:
    assert sorted(law.names) == sorted(names.split())
    assert law.names[:2] == ("theta", "omega")
    assert len(law.at_rest()) == len(law.names)


@rows(
    ("law", "command", "currents"),
    [
        (MotorLaw(A, HELD), 1, (-1.0, 1.0)),
        (MotorLaw(A, VOLTS), 2, (-1.0, -1.0)),
        (MotorLaw(A, replace(VOLTS, kind="bilevel", supply=5.0, series=0.0)), 1, (-1.0, 1.0)),
        (MotorLaw(UNIPOLAR, VOLTS), 0, (1.0, 0.0, 1.0, 0.0)),
        (MotorLaw(RELUCTANCE, VOLTS, steps="wave"), 2, (0.0, 0.0, 1.0, 0.0)),
        (MotorLaw(A, CHOPPER, steps="half"), 1, (0.0, 1.0)),
        (MotorLaw(A, replace(CHOPPER, supply=2.5)), 0, (0.5, 0.5)),  # more the supply does not give
    ],
)
def test_at_rest_the_currents_are_settled(law: MotorLaw, command: int, currents: tuple[float, ...]) -> None:
    state = dict(zip(law.names, law.at_rest(command), strict=True))
    assert state["theta"] == pytest.approx(command / law.micro * law.motor.step)
    assert state["omega"] == 0.0
    assert [state[f"i{n + 1}"] for n in range(len(currents))] == pytest.approx(currents)


@rows("kind", ["current", "averaged", "chopper", "voltage", "bilevel"])
def test_at_rest_it_stays(kind: str) -> None:
    driver = DriverData(kind=kind, supply=24.0 if kind != "bilevel" else 5.0, current=1.0)  # type: ignore[arg-type]
    law = MotorLaw(A, driver)
    for command in range(-2, 3):
        trace = law.integrate([], [], 100_000_000, command=command, engine="python")
        assert trace.rests or kind == "chopper"
        assert trace["theta"][-1] == pytest.approx(command * A.step, abs=1e-7)


@pytest.mark.parametrize("decay", ["slow", "mixed"])
def test_with_a_chopper_it_rests_only_where_the_currents_have_followed(decay: str) -> None:
    motor = replace(A, current=2.8, resistance=0.5, inductance=0.6e-3, torque=0.4, iron=1e-3)
    law = MotorLaw(motor, replace(CHOPPER, current=2.8, decay=decay, rest=0.5), steps="micro 16")  # type: ignore[arg-type]
    trace = law.integrate([1], [1], 400_000_000_000, engine="python")
    assert trace.rests
    assert abs(trace.lag[-1]) < 0.03  # a microstep is 0.0625
    for codes in ([0, law.code(0, "rest")], [law.code(0, "rest"), 0]):
        trace = law.integrate([1, 100_000_000_000], [0, 0], 400_000_000_000, codes=codes, engine="python")
        asked = abs(law.table[codes[1]][0])
        assert trace.rests
        assert 0.9 * asked < trace["i1"][-1] < 1.03 * asked


# --------------------------------------------------------------------------------------------------------------- traces
def test_trace_of_a_step() -> None:
    law = MotorLaw(A, HELD)
    trace = law.integrate([30_000_000], [1], 200_000_000_000, engine="python")

    assert trace.times[:4].tolist() == [0, 30_000_000, 50_000_000, 70_000_000]  # it rested until the edge
    assert trace.commands[:2].tolist() == trace.codes[:2].tolist() == [0, 1]
    assert trace.times.dtype == trace.commands.dtype == trace.codes.dtype == np.int64
    assert trace.states.shape == (len(trace.times), len(law.names))
    assert trace.rests
    assert trace["theta"][-1] == pytest.approx(A.step, abs=1e-6)
    assert trace.lag[0] == 0.0
    assert trace.lag[1] == trace.worst == 1.0
    assert trace.lost == 0


def test_edges_restart_the_grid_and_cut_a_step() -> None:
    trace = MotorLaw(A, HELD).integrate([5_000_000, 12_000_000], [1, 2], 60_000_000, engine="python")
    assert trace.times.tolist() == [0, 5_000_000, 12_000_000, 32_000_000, 52_000_000]


def test_state_between_grid_points_is_one_step_of_that_length() -> None:
    law = MotorLaw(A, VOLTS)
    trace = law.integrate([1], [1], 1_000_000_000, engine="python")
    n = len(trace.times) // 2
    point = int(trace.times[n]), trace.states[n].tolist(), int(trace.codes[n])
    assert law.after(*point, law.step_ps) == tuple(trace.states[n + 1].tolist())
    assert law.after(*point, 0) == tuple(point[1])


def test_pieces_give_the_same_bits_as_the_whole() -> None:
    law = MotorLaw(A, replace(VOLTS, kind="bilevel", supply=5.0, series=0.0, high=40.0, high_time=3e-4), steps="half")
    edges = np.arange(1, 21, dtype=np.int64) * 700_000_001
    commands = np.arange(1, 21)
    whole = law.integrate(edges, commands, 15_000_000_000, engine="python")
    parts, first = law.integrate(edges, commands, 4_321_000_000, engine="python"), 6
    rest = law.integrate(
        edges[first:], commands[first:], 15_000_000_000, start=int(parts.times[-1]), state=parts.states[-1].tolist(),
        command=int(parts.commands[-1]), code=int(parts.codes[-1]), engine="python",
    )  # fmt: skip
    assert np.array_equal(whole.states[-len(rest.states) :], rest.states)
    assert np.array_equal(whole.times[-len(rest.times) :], rest.times)


def test_limit_ends_a_run_early() -> None:
    edges = np.arange(1, 101, dtype=np.int64) * 100_000_000  # 10,000 steps/s at once
    trace = MotorLaw(A, HELD).integrate(edges, np.arange(1, 101), 10**12, limit=3.9, engine="python")
    assert 3.9 < trace.worst < 5.0
    assert trace.times[-1] < edges[10]
    assert not trace.rests


def test_lost_steps_are_a_multiple_of_four() -> None:
    edges = np.arange(1, 102, dtype=np.int64) * 100_000_000
    trace = MotorLaw(A, HELD).integrate(edges, np.arange(1, 102), 10**12, engine="python")
    assert trace.rests
    assert trace.lost == pytest.approx(float(trace.lag[-1]), abs=1e-3)
    assert trace.lost % 4 == 0
    assert trace.lost > 0


def test_another_engine_is_refused() -> None:
    with pytest.raises(UsageError, match=r"engine 'fortran'; allowed python, numba, None"):
        MotorLaw(A, HELD).integrate([], [], 1, engine="fortran")


def test_integers_for_figures_give_the_same() -> None:
    one, two = MotorLaw(A, VOLTS, LoadData(torque=0)), MotorLaw(A, VOLTS, LoadData(torque=0.0))
    assert [type(value) for value in one.parameters] == [type(value) for value in two.parameters]


def test_blocked_rotor_stays_and_its_currents_do_not() -> None:
    trace = MotorLaw(A, VOLTS, blocked=True).integrate([1], [2], 5_000_000_000, engine="python")
    assert set(trace["theta"].tolist()) == {0.0}
    assert trace["i1"][-1] == pytest.approx(-1.0, abs=1e-4)


# -------------------------------------------------------------------------------------------------------------- motion
@rows("command", range(8))
def test_each_half_of_a_winding_holds_the_rotor_in_its_own_place(command: int) -> None:
    law = MotorLaw(UNIPOLAR, VOLTS, steps="half")
    state = law.at_rest(command)
    near = (state[0] - 0.01 * law.step, *state[1:])
    pulled = (law.after(0, each, law.code(command), law.step_ps)[1] for each in (state, near))
    assert next(pulled) == pytest.approx(0, abs=1e-6) and next(pulled) > 0.01


def test_an_averaged_source_keeps_its_current_against_the_emf() -> None:
    heavy = LoadData(inertia=1.0)  # keeps its speed
    law = MotorLaw(A, DriverData(kind="averaged", supply=48.0, current=1.0), heavy)
    turning = (0.0, 20.0, *law.at_rest(0)[2:])
    trace = law.integrate((), (), 5_000_000_000, state=turning, engine="python")
    assert trace["i1"][50:] == pytest.approx(1.0, abs=0.01) and trace["i2"][50:] == pytest.approx(1.0, abs=0.01)


def test_a_rotor_that_nothing_brakes_turns_on() -> None:
    law = MotorLaw(replace(A, iron=0.0), HELD)
    off = law.code(0, "off")
    trace = law.integrate((), (), 100_000_000_000, state=(0.0, 5.0, 0.0, 0.0), code=off, engine="python")
    assert not trace.rests and trace["theta"][-1] == pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize(
    ("times", "commands", "says"),
    [
        ([10, 10], [1, 2], r"edge 1 at 10 ps; it must be after the previous edge \(10 ps\)"),
        ([0], [1], r"edge 0 at 0 ps; it must be after the start \(0 ps\)"),
        ([10, 20], [1], "2 edges with 1 commands; pass one command for each edge"),
    ],
)
def test_edges_ascend_and_have_a_command_each(times: list[int], commands: list[int], says: str) -> None:
    with pytest.raises(UsageError, match=says):
        MotorLaw(A, HELD).integrate(times, commands, 1000)


def test_an_unknown_state_is_reported() -> None:
    trace = MotorLaw(A, HELD).integrate([], [], 0)

    with pytest.raises(UnknownName, match="no state 'omega1'; known: theta, omega, i1, i2; did you mean omega"):
        trace["omega1"]
