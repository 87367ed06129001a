"""What a target cannot do: the limit, its place, and the remedy; and what is written out."""

from __future__ import annotations

import pytest

from slewline.errors import UsageError
from slewline.translation.meaning import Action, Line, MoveBy, Profile, Program, SetOutput
from slewline.translation.source_text.reading import read_program
from slewline.translation.target_writer import WriterOptions, Written
from slewline.translation.translate import translate_text
from slewline.translation.translation_report import LineKind, LineVerdict
from slewline.translation.writers import target

LOOP = "R 80\nE\nC$N 5\n+\nG\nL 6,C\n0\nQX\n"
FAST = "F 255\nR 200\nS 255\nN 10\nG\n"


def written(text: str, name: str, part: str = "cy525", **options: object) -> Written:
    return target(name).write(read_program(text, part, "text"), WriterOptions(**options))  # type: ignore[arg-type]


def text_of(text: str, name: str, **options: object) -> list[str]:
    return [line.text for line in written(text, name, **options).lines]


def verdict(found: Written, line: int, kind: LineKind) -> LineVerdict:
    return next(each for each in found.verdicts if (each.line, each.kind) == (line, kind))


def test_grbl_has_no_loops_so_they_are_written_out():
    lines = text_of(LOOP, "grbl")
    assert sum(line.startswith("G91 G1 X5") for line in lines) == 6
    assert lines.count("G4 P0") == 5  # between two moves, or grbl would join them


def test_an_excessively_long_loop_is_impossible_and_its_length_is_reported():
    found = written(LOOP, "grbl", unroll=5)
    judged = verdict(found, 6, LineKind.IMPOSSIBLE)
    assert "5 allowed (--unroll)" in judged.limit
    assert "--to python" in judged.remedy
    assert sum(line.text.startswith("G91 G1 X5") for line in found.lines) == 1


def test_a_wait_for_an_input_stops_grbl_until_a_person_continues():
    found = written("W\nN 5\nG\n", "grbl")
    assert "M0" in [line.text for line in found.lines]
    assert "--to python" in verdict(found, 1, LineKind.IMPOSSIBLE).remedy


def test_dwells_of_grbl_are_whole_steps_of_50_ms():
    found = verdict(written("D 120\n", "grbl"), 1, LineKind.NEARLY)
    assert found.description.startswith("150 ms instead of 120 ms")
    assert found.off_ps == 30 * 10**9
    assert not [each for each in written("D 150\n", "grbl").verdicts if each.kind is not LineKind.SAME]


def test_ticks_of_tmcl_are_10_ms():
    assert verdict(written("D 124\n", "tmcl"), 1, LineKind.NEARLY).off_ps == 4 * 10**9
    assert "WAIT TICKS, 0, 12" in text_of("D 124\n", "tmcl")


def test_tmcl_has_the_start_rate_and_the_ramp():
    lines = text_of("F 3\nR 80\nS 200\nN 9\nG\n", "tmcl")
    assert "SAP 19, 0, 300" in lines and "SAP 4, 0, 5978" in lines and "SAP 5, 0, 32031" in lines


def test_a_sketch_takes_the_faster_library_for_a_greater_rate():
    assert "#include <AccelStepper.h>" in text_of("R 50\nN 5\nG\n".replace("R 50", "R 10"), "arduino")
    assert "#include <FastAccelStepper.h>" in text_of("R 80\nN 5\nG\n", "arduino")
    found = written("R 80\nN 5\nG\n", "arduino", values={"library": "accelstepper"})
    judged = verdict(found, 1, LineKind.IMPOSSIBLE)
    assert judged.limit == "about 4,000 steps/s on an Uno (AccelStepper, description of the class)"


def test_an_unknown_library_is_refused_with_the_known_ones():
    with pytest.raises(UsageError, match="allowed accelstepper or fastaccelstepper"):
        written("N 5\nG\n", "arduino", values={"library": "stepper"})


def test_a_move_without_a_ramp_runs_at_an_even_rate():
    assert "  moveByEvenly(5, 299.997);" in text_of("F 3\nR 3\nN 5\nG\n", "arduino")
    assert any("ACCEL=0" in line for line in text_of("F 3\nR 3\nN 5\nG\n", "klipper"))


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("linuxcnc", "G91 G1 X0.0125"),
        ("grbl", "G91 G1 X0.0125"),
        ("klipper", "  MANUAL_STEPPER STEPPER=axis MOVE={ns.at / 400}"),
    ],
)
def test_units_are_steps_per_millimetre(name, wanted):
    assert any(line.startswith(wanted) for line in text_of("R 80\nN 5\nG\n", name, steps_per_mm=400))


def of_actions(*actions: Action) -> Program:
    lines = [Line(number, "code", actions=(action,)) for number, action in enumerate(actions, 1)]
    return Program("mc1451a", "text", tuple(lines))


PROFILE = Profile(start=100.0, top=1000.0, time_ps=10**11, steps=55)
FOUR_AXES = of_actions(*(MoveBy(line=n, axis=n, distance=n, sign=1, profile=PROFILE) for n in (1, 2, 3, 4)))


@pytest.mark.parametrize("name", ["grbl", "python"])
def test_axes_beyond_three_are_not_possible_for_grbl(name):
    found = target(name).write(FOUR_AXES, WriterOptions())
    (judged,) = [each for each in found.verdicts if each.kind is LineKind.IMPOSSIBLE]
    assert (judged.line, judged.limit) == (4, "3 axes: X, Y, Z")


def test_four_axes_go_to_linuxcnc_and_to_a_sketch():
    lines = [line.text for line in target("linuxcnc").write(FOUR_AXES, WriterOptions()).lines]
    assert [line[:9] for line in lines if line.startswith("G91")] == [
        "G91 G1 X1",
        "G91 G1 Y2",
        "G91 G1 Z3",
        "G91 G1 A4",
    ]
    three = of_actions(*(action for action in FOUR_AXES.actions if action.axis < 4))
    text = "\n".join(line.text for line in target("arduino").write(three, WriterOptions()).lines)
    trace = target("arduino").read_back(text, WriterOptions())
    assert [(each.number, each.value) for each in trace.happened] == [(1, 1), (2, 2), (3, 3)]


@pytest.mark.parametrize("name", ["grbl", "python", "tmcl", "linuxcnc", "arduino"])
def test_outputs_beyond_those_of_the_target_are_not_possible(name):
    five = of_actions(*(SetOutput(line=n, number=n, level=1) for n in (1, 2, 3, 4, 5)))
    judged = [each for each in target(name).write(five, WriterOptions()).verdicts if each.kind is LineKind.IMPOSSIBLE]
    assert judged[-1].line == 5
    assert judged[-1].limit and judged[-1].remedy


@pytest.mark.parametrize("name", ["grbl", "python", "klipper", "tmcl", "arduino"])
def test_nothing_is_written_for_an_axis_that_the_target_has_not(name):
    moves = "SET_{0}\nSET_VEL 9000\nSET_ACC 90\nSET_POS {0}0\nUPDATE\n"
    found = written(moves.format(1) + moves.format(4), name, "mc1451a")
    assert {each.kind for each in found.verdicts if each.line in (7, 8, 9)} == {LineKind.IMPOSSIBLE}
    assert verdict(found, 9, LineKind.IMPOSSIBLE).description == "axis 4"
    assert not any(
        "40" in line.text for line in found.lines if "NOT POSSIBLE" not in line.text and "SAP" not in line.text
    )


@pytest.mark.parametrize(
    ("name", "sets"), [("linuxcnc", "F358695"), ("python", "grbl.feed(5978"), ("tmcl", "SAP 4, 0, 5978")]
)
def test_a_program_that_is_run_with_two_rates_sets_its_own(name, sets):
    lines = text_of("R 40\nE\nR 80\nN 5\n+\nG\n0\nQ\nX\nR 80\nX\n", name)
    assert sum(line.strip().startswith(sets) for line in lines) == 2, lines


@pytest.mark.parametrize("name", ["grbl", "python", "linuxcnc"])
def test_an_unknown_axis_letter_is_refused_with_the_existing_ones(name):
    with pytest.raises(UsageError, match="axis Q: allowed X, Y, Z"):
        written("N 5\nG\n", name, axis="Q")


def test_the_levels_of_outputs_at_the_start_are_written():
    assert "M8" in text_of("C\nB\n", "grbl")  # high after a reset
    assert "SIO 0, 2, 1" in text_of("C\nB\n", "tmcl")


def test_a_program_that_is_entered_and_not_run_is_there_and_does_not_run():
    text = "E\nN 5\n+\nG\n0\nQ\n"
    lines = text_of(text, "grbl")
    assert lines.index("M2") < lines.index(next(line for line in lines if "X5" in line))
    assert "[gcode_macro STORED1]" in text_of(text, "klipper")


# ------------------------------------------------------------------------------------------ what only a chipset has
SEVERAL = (
    "SET_1\nSET_VEL 90000\nSET_ACC 90\nSET_POS 50\nSET_2\nSET_VEL 90000\nSET_ACC 90\nSET_POS 70\nMULTI_UPDATE 0x3\n"
)


def test_an_update_of_several_axes_moves_each_and_reports_that_they_do_not_start_together():
    found = written(SEVERAL, "linuxcnc", "mc1451a")
    assert [line.text[:10] for line in found.lines if "G90 G1" in line.text] == ["G90 G1 X50", "G90 G1 Y70"]
    judged = verdict(found, 9, LineKind.IMPOSSIBLE)
    assert (
        "in the same cycle" in judged.description
        and "LinuxCNC 2.9" in judged.limit
        and "one axis moves after" in judged.remedy
    )


def test_an_s_curve_is_not_possible_and_the_remedy_is_a_ramp_that_has_a_counterpart():
    for name in ("linuxcnc", "grbl", "klipper", "tmcl", "arduino", "python"):
        judged = verdict(written("SET_PRFL_S_CRV\nSET_POS 5\nUPDATE\n", name, "mc1451a"), 1, LineKind.IMPOSSIBLE)
        assert target(name).language in judged.limit and "SET_PRFL_TRAP" in judged.remedy


# ----------------------------------------------------------------------------------------------------------- settings
def test_an_output_begins_at_the_level_that_a_user_gives():
    for level, code in (({}, "M8"), ({"output1": "low"}, "M9"), ({"output1": "high"}, "M8")):  # high after a reset
        assert next(line for line in translated("B\nC\n", "grbl", **level) if line in ("M8", "M9")) == code


def translated(text: str, to: str, **settings: str) -> list[str]:
    done = translate_text(text, "cy525", to, options=WriterOptions(values=settings))
    return [line.partition("  ;")[0] for line in done.text.splitlines()]


def test_a_setting_selects_library_port_and_repetitions():
    assert "#include <FastAccelStepper.h>" in translated("N 5\nG\n", "arduino", library="fastaccelstepper")
    assert 'PORT = "COM3"' in translated("N 5\nG\n", "python", port="COM3")
    text = "R 80\nE\nN 5\n+\nG\nJ 0\nQX\n"
    assert sum(line.startswith("G91 G1 X5") for line in translated(text, "grbl", repeats="7")) == 7


@pytest.mark.parametrize(
    ("to", "setting", "says"),
    [
        ("grbl", {"repeat": "3"}, "grbl has no such setting; allowed repeats .*did you mean repeats"),
        ("grbl", {"repeats": "none"}, "repeats none: allowed 1 or more"),
        ("linuxcnc", {"output1": "off"}, "output1=off: allowed low or high"),
        ("gs-c200s", {"output1": "low"}, "gs-c200s has no such setting; allowed none"),
        ("arduino", {"library": "stepper"}, "allowed accelstepper or fastaccelstepper"),
    ],
)
def test_an_unknown_setting_of_a_target_is_refused_with_the_existing_ones(to, setting, says):
    with pytest.raises(UsageError, match=says):
        translated("N 5\nG\n", to, **setting)
