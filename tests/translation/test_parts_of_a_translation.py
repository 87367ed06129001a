"""What single commands become, by their roles."""

from __future__ import annotations

import pytest

from slewline.translation.meaning import Delay, Jump, Loop, MoveBy, MoveTo, RunEndless, SetOutput
from slewline.translation.proof.prove import prove
from slewline.translation.source_text.reading import read_program
from slewline.translation.translate import DRIVEN, translate_text
from slewline.translation.translation_report import LineKind
from tests.rows import rows

GSC = "Po\nS20\nT200\nR40\n{}\nE\n"
CY = "A 0\nF 3\nR 40\nS 200\nE\n{}\n0\nQ\nX\n"


def result(text: str, source: str, to: str) -> list[str]:
    found = translate_text(text, source, to).text.splitlines()
    return [line.split(";")[0].strip() for line in found if line.split(";")[0].strip()]


@rows(
    ("command", "becomes"),
    [
        ("+\nN 250\nG", ["+250"]),
        ("-\nN 250\nG", ["-250"]),
        ("P 700", ["G+700"]),
        ("B", ["A1"]),
        ("C", ["C1"]),
        ("D 1500", ["D15"]),
        ("D 60000", ["D255", "D255", "D90"]),
        ("W", ["W1"]),
        ("A$G\nL 3,A", ["L0", "L3"]),
    ],
)
def test_a_command_of_the_cy525_for_the_gs_c200s(command: str, becomes: list[str]) -> None:
    found = result(CY.format(command), "cy525", "gs-c200s")
    body = [line for line in found[found.index("Po") + 4 : -1] if not line.startswith(("+0",))]
    assert [line for line in body if line in becomes] == becomes, found


@rows(
    ("command", "becomes"),
    [
        ("+250", ["+", "N 250", "G"]),
        ("-250\n-250", ["-", "N 250", "G", "G"]),
        ("A1\nC1", ["B", "C"]),
        ("D15", ["D 1500"]),
        ("W1", ["W"]),
        ("W2", ["A$T A"]),
        ("L0\n+9\nL3", ["A$+", "N 9", "G", "L 3,A"]),
    ],
)
def test_a_command_of_the_gs_c200s_for_the_cy525(command: str, becomes: list[str]) -> None:
    found = result(GSC.format(command), "gs-c200s", "cy525")
    assert found[found.index("E") + 1 : -3] == becomes


def test_settings_go_to_the_head_of_a_program_of_a_module_and_before_that_of_a_cy525() -> None:
    found = result(CY.format("P 9"), "cy525", "gs-c200s")
    assert found.index("Po") < min(found.index(line) for line in found if line[0] in "STR")
    back = result(GSC.format("+9"), "gs-c200s", "cy525")
    assert back.index("E") > max(back.index(line) for line in back if line[0] in "FRS")


def test_a_move_of_a_host_becomes_a_program_of_a_module() -> None:
    found = result("R 40\nN 9\n+\nG\n", "cy525", "gs-c200s")
    assert found[0] == "Po" and found[-3:] == ["+9", "E", "@until ready"]


def test_registers_needed_for_the_first_motion_of_a_part_are_set() -> None:
    assert result("P 40\n", "cy525", "gs-c200s")[:5] == ["Po", "S30", "T30", "R999", "G+40"]
    found = result("N 4\nG\n", "cy525", "cy545b")
    assert found.index("+") < found.index("G")  # the part begins counter-clockwise
    assert result(GSC.format("G0"), "gs-c200s", "cy525")[:5].count("A 0") == 1  # whose position is undefined


def test_loops_are_unrolled_for_a_chipset_that_stores_no_program() -> None:
    found = result(GSC.format("L0\n+9\nL3"), "gs-c200s", "mc1151a")
    assert [line for line in found if line.startswith("SET_POS")] == ["SET_POS 9", "SET_POS 18", "SET_POS 27"]
    assert found.count("wait motion_complete") == 3


def test_an_endless_loop_is_not_possible_there() -> None:
    report = translate_text("A 0\nR 9\nE\nP 9\nP 0\nJ 0\nQ\nX\n", "cy525", "mc1151a").report
    (line,) = [line for line in report if line.code == "J 0"]
    assert line.kind is LineKind.IMPOSSIBLE and "jumps" in line.verdicts[0].limit


@pytest.mark.parametrize(
    ("text", "part", "kinds"),
    [
        ("E\nB$N 5\n+\nG\nL 3,B\nT B\n0\nQ\nX\n", "cy525", [MoveBy, Loop, Jump]),
        ("Po\nS9\nT99\nR9\nL0\n-7\nL2\nG+40\nA3\nE\n", "gs-c200s", [MoveBy, Loop, MoveTo, SetOutput]),
        ("Po\nS9\nT99\nR9\nD2\ng-\nE\n", "gs-c200s", [Delay, RunEndless]),
        ("SET_VEL 9999\nSET_ACC 99\nSET_POS 5\nUPDATE\n", "mc1151a", [MoveTo]),
        ("B 3\nB 19\nN 4\n+\nG\nP 9\n", "cy545", [SetOutput, SetOutput, MoveBy, MoveTo]),
    ],
)  # fmt: skip
def test_a_text_is_read_as_what_it_does(text: str, part: str, kinds: list[type]) -> None:
    found = [type(action) for action in read_program(text, part).actions]
    assert [kind for kind in found if kind in kinds] == kinds


def test_a_value_that_depends_on_the_path_is_not_known() -> None:
    program = read_program("R 80\nE\nC$N 5\n+\nG\nT C\nR 60\nJ C\nQ\nX\n", "cy525")
    (move,) = [action for action in program.actions if isinstance(action, MoveBy)]
    assert move.steps == 5 and move.profile is None


# ------------------------------------------------------------------------------------------ faults of random programs
def test_a_direction_is_set_again_after_a_move_to_a_position_in_a_loop() -> None:
    done = translate_text("I3\n" + GSC.format("+19\nL0\n+9\nG500\nG90\nL3"), "gs-c200s", "cy545")
    proof = prove(done)
    assert proof.proven and proof.compared is not None and proof.compared.moves == 10, proof.compared


def test_the_memory_pointer_is_set_where_the_source_sets_it_and_once() -> None:
    text = "Y 0\nE\nN 5\n+\nG\n0\nQ\nY 0\nX\n"
    assert [line for line in result(text, "cy545", "cy545b") if line[0] in "YEX"] == ["Y 0", "E", "Y 0", "X"]
    (line,) = [line for line in translate_text(text, "cy545", "cy525").report if line.code == "Y 0"][:1]
    assert line.kind is LineKind.SAME and line.written == ()


def test_a_jump_by_the_memory_pointer_is_a_jump() -> None:
    program = read_program("Y 0\nE\nB 0\nY 0\nQ\n", "cy545")
    assert [action.to for action in program.actions if isinstance(action, Jump)] == ["line3"]


def test_bits_of_a_port_are_high_after_a_reset() -> None:
    assumed = read_program("B 16\nB 0\n", "cy545").assumed
    assert [each.value for each in assumed if each.about == "output 1 (usrb0)"] == ["high after reset"]


def test_a_move_of_unknown_length_has_a_bound_below_the_length_of_its_ramps() -> None:
    text = "F 17\nR 56\nS 184\n+\nN 84\nE\nG\nP 8340\nL 3,0\n0\nQ\nX\n"
    report = translate_text(text, "cy545b", "gs-c200s").report
    (line,) = [line for line in report if line.code == "P 8340"]
    assert line.verdicts[0].off > 0.115
    report = translate_text("F 20\nR 137\nS 218\nE\n+\nG\nP 8650\nL 3,0\n0\nQ\nX\n", "cy545b", "cy525").report
    (line,) = [line for line in report if line.code == "P 8650"]
    assert line.verdicts[0].off > 0.205  # at some 480 steps
    report = translate_text("F 5\nZ 1\nS 200\nR 83\nE\nG\nP 8340\nL 3,0\n0\nQ\nX\n", "cy525", "gs-c200s").report
    (line,) = [line for line in report if line.code == "P 8340"]
    assert line.verdicts[0].off > 0.4  # just beyond both ramps


# ----------------------------------------------------------------------------- what a host sends beside its programs
RAMP = "A 0\nF 20\nR 60\nS 200\n"


@pytest.mark.parametrize(
    ("source", "code"), [("cy512", "J 3"), ("cy512", "L 3,0"), ("cy500", "T"), ("cy525", "T 4"), ("cy545", "J 0")]
)
@pytest.mark.parametrize("to", ["cy525", "cy512", "gs-c200s", "mc1451a", "grbl", "tmcl"])
def test_a_branch_into_a_program_that_the_text_does_not_enter_is_not_possible(source: str, code: str, to: str) -> None:
    if source != to:
        (line,) = translate_text(f"{code}\n", source, to).report.lines
        assert line.kind is LineKind.IMPOSSIBLE and "add the lines that enter the program" in line.verdicts[0].text


@pytest.mark.parametrize("to", ["grbl", "linuxcnc", "klipper", "tmcl", "arduino", "python"])
@pytest.mark.parametrize("code", ["L 4,0", "T 0"])
def test_a_host_starts_no_program_of_a_language_by_a_loop_or_branch(code: str, to: str) -> None:
    done = translate_text(f"{RAMP}E\n+\nN 50\nG\n0\nQ\n{code}\n", "cy525", to)
    assert done.report.lines[-1].kind is LineKind.IMPOSSIBLE


@pytest.mark.parametrize("program", ["E\n+\nN 50\nG\n0\nQ\nJ 1\n", "E\nJ A\n+\nA$N 50\nG\n0\nQ\nX\n"])
def test_a_direction_that_a_path_leaves_out_is_that_of_the_reset(program: str) -> None:
    assert prove(translate_text(f"{RAMP}{program}", "cy525", "cy545")).proven  # whose reset sets the other one


@pytest.mark.parametrize("to", ["cy525", "cy545", "gs-c200s", "tmcl"])
def test_a_cy500_moves_clockwise_after_a_reset(to: str) -> None:
    assert prove(translate_text("R 100\nS 4\nN 50\nG\n", "cy500", to)).proven


# ------------------------------------------------------------------------------------- what is not in a number alone
@pytest.mark.parametrize("code", ["N #", "P #", "A #", "R #", "D #", "B #"])
def test_a_number_from_switches_is_copied_to_a_part_that_reads_them_and_is_not_possible_elsewhere(code: str) -> None:
    assert code in translate_text(f"+\n{code}\n", "cy545", "cy545b").text.splitlines()
    for to in ("cy525", "gs-c200s", "mc1451a", "grbl", "arduino"):
        line = translate_text(f"+\n{code}\n", "cy545", to).report.lines[-1]
        assert line.kind is LineKind.IMPOSSIBLE and "write the number" in line.verdicts[0].text


def test_a_move_after_a_number_from_switches_has_no_known_length() -> None:
    (move,) = [each for each in read_program("+\nN 5\nN #\nG\n", "cy545").actions if isinstance(each, MoveBy)]
    assert move.distance is None and move.sign == 1


@pytest.mark.parametrize("code", ["/B 0", "/W 3", '" hello"', "? P", "B 0"])
def test_prefixes_and_strings_are_copied(code: str) -> None:
    done = translate_text(f"{code}\n", "cy545", "cy545b")
    assert done.text.splitlines()[-1] == code and done.report.same


@pytest.mark.parametrize(("text", "to"), [("@drive slew=0\n", "cy525"), ("@drive ccw=0\n", "gs-c200s")])
def test_a_host_drives_no_output_of_the_target(text: str, to: str) -> None:
    (line,) = translate_text(text, "cy545", to).report.lines
    assert line.kind is LineKind.IMPOSSIBLE and "is an output" in line.verdicts[0].text


@pytest.mark.parametrize(("code", "kind"), [("@drive abort=0", LineKind.IMPOSSIBLE), ("@drive wait=0", LineKind.SAME)])
def test_a_level_at_a_pin_that_stops_or_turns_is_not_the_same_where_it_is_left_out(code: str, kind: LineKind) -> None:
    for to in ("grbl", "linuxcnc", "klipper", "tmcl", "arduino", "python"):
        (line,) = translate_text(f"{code}\n", "cy525", to).report.lines
        assert line.kind is kind

    assumed = translate_text("@drive wait=0\n", "cy525", "arduino").report.assumed
    assert [each.value for each in assumed if each.about == "inputs that the host drives"] == [DRIVEN]


def test_commands_of_an_encoder_need_one() -> None:
    for to, kind in (("mc1451a", LineKind.IMPOSSIBLE), ("mc1151a-e", LineKind.SAME)):
        (line,) = translate_text("SET_POS_ERR 10\n", "mc1451a-e", to).report.lines
        assert line.kind is kind


def test_an_s_curve_has_its_values_at_a_part_with_the_same_ramps() -> None:
    text = "SET_PRFL_S_CRV\nSET_POS 400\nSET_VEL 30000\nSET_MAX_ACC 900\nSET_JERK 900000\nUPDATE\n"
    text = f"SET_VEL 9000\nSET_ACC 90\nUPDATE\nwait motion_complete\n{text}wait motion_complete\n"
    done = translate_text(text, "mc1451a", "mc1151a-e")
    assert {"SET_VEL 30000", "SET_MAX_ACC 900", "SET_JERK 900000"} <= {*done.text.splitlines()}
    assert prove(done).proven


def test_a_pin_of_an_axis_is_that_of_the_same_axis() -> None:
    for to, name in (("mc1251a", "poslimit2"), ("mc1451a-e", "poslimit2")):
        assert f"@drive {name}=1" in translate_text("@drive poslimit2=1\n", "mc1451a", to).text.splitlines()
    (line,) = translate_text("@drive poslimit2=1\n", "mc1451a", "mc1151a").report.lines
    assert line.kind is LineKind.IMPOSSIBLE


def test_a_distance_is_set_again_after_a_target_that_replaces_it() -> None:
    text = "A 0\nF 5\nR 9\nS 200\nN 20\nP 90\n+\nG\n-\nG\n"
    done = translate_text(text, "cy525", "cy500")
    assert [line for line in done.text.splitlines() if line[0] in "NPG+-"] == [
        "N 20",
        "P 90",
        "+",
        "G",
        "+",
        "N 20",
        "G",
        "-",
        "G",
    ]
    assert prove(done).proven


def test_an_interrupting_axis_is_not_known() -> None:
    text = "SET_1\nSET_VEL 90000\nSET_ACC 900\nSET_I\nSET_POS 500\nUPDATE\nSET_2\nSET_POS 7\nUPDATE\n"
    for to in ("tmcl", "linuxcnc", "gs-c200s", "cy525"):
        lines = translate_text(text, "mc1451a", to).report.lines
        assert lines[4].kind is lines[5].kind is LineKind.IMPOSSIBLE
    done = translate_text(text, "mc1451a", "mc1251a")
    assert done.report.same and "SET_POS 500" in done.text


# ------------------------------------------------------------------------------ a host that acts while the motor runs
MOVES = "A 0\nF 3\nR 40\nS 200\n+\nN 9000\nG\nN 20000\nG\n"
ABORTED = f"{MOVES}@wait 500 ms\n@drive abort=0\n@until motion_complete=0\n@drive abort=1\nN 30\nG\n"
STOPPED = (
    "SET_VEL 90000\nSET_ACC 900\nSET_POS 60000\nCLR_STATUS\nUPDATE\n@wait 500 ms\n{}\nUPDATE\nwait motion_complete\n"
)


def test_the_wait_for_the_end_of_a_motion_follows_what_the_host_does_during_it() -> None:
    assert result(ABORTED, "cy525", "mc1451a")[-6:] == [
        *("CLR_STATUS", "UPDATE", "@wait 500 ms", "SMOOTH_STOP", "UPDATE"),
        "wait motion_complete",
    ]
    found = result(ABORTED, "cy525", "gs-c200s")
    assert found[found.index("+20000") :] == [
        "+20000",
        "E",
        "@wait 500 ms",
        "Z",
        "@until ready",
        "Po",
        "+30",
        "E",
        "@until ready",
    ]
    assert found[found.index("+9000") + 1 : found.index("+20000")] == ["E", "@until ready", "Po"]


@pytest.mark.parametrize("to", ["cy512", "cy545b", "gs-c200", "gs-c200s", "mc1451a"])
def test_source_and_result_are_stopped_in_the_same_motion(to: str) -> None:
    compared = prove(translate_text(ABORTED, "cy525", to)).compared
    assert compared is not None
    assert compared.proven or (to == "mc1451a" and compared.differences[0].startswith("the source alone: +30"))
    assert compared.moves >= 2


@rows(("command", "becomes"), [("STOP", "K"), ("SMOOTH_STOP", "Z")])
def test_a_stop_acts_at_the_update(command: str, becomes: str) -> None:
    done = translate_text(STOPPED.format(command), "mc1451a", "gs-c200s")
    assert [(line.code, line.written) for line in done.report][6:8] == [(command, ()), ("UPDATE", (becomes,))]
    assert prove(done).trace.happened[0].kind == "run"


def test_a_relative_move_from_an_unknown_position_is_not_possible_with_positions_alone() -> None:
    report = translate_text(ABORTED, "cy525", "mc1451a").report
    assert report.lines[-1].kind is LineKind.IMPOSSIBLE
    assert report.lines[-1].verdicts[0].description.startswith("the position before it is unknown")


def test_a_controller_without_a_host_cannot_be_stopped_by_it() -> None:
    for to in ("linuxcnc", "grbl", "arduino", "klipper", "tmcl", "python"):
        kinds = {line.code: line.kind for line in translate_text(ABORTED, "cy525", to).report}
        assert kinds["@drive abort=0"] is LineKind.IMPOSSIBLE, to
        stopped = {line.code: line.kind for line in translate_text(STOPPED.format("STOP"), "mc1451a", to).report}
        assert stopped["UPDATE"] is LineKind.IMPOSSIBLE, to


def test_a_free_output_shows_the_end_of_a_program_where_no_pin_does() -> None:
    text = GSC.format("A1\n+100\nC1") + "@until ready\nE\n"
    done = translate_text(text, "gs-c200s", "cy545b")
    code = [line.split(";")[0].strip() for line in done.text.splitlines()]
    assert code[-10:] == ["B 2", "0", "Q", "B 18", "Y 0", "X", "@until usrb2=1", "B 18", "Y 0", "X"]
    assert prove(done).proven and [each.value for each in done.report.assumed if each.about == "end of a program"]


def test_a_free_output_shows_the_end_of_a_program_whose_end_is_copied() -> None:
    text = CY.format("N 50\nG") + "@until run=1\nN 9\nG\n"
    assert "B 2\n0\nQ" in translate_text(text, "cy525", "cy545b").text
    assert prove(translate_text(text, "cy525", "cy545b")).proven


def test_a_program_that_moves_of_the_host_have_replaced_is_entered_again() -> None:
    text = CY.format("+\nN 50\nG") + "@until run=1\nN 90\nG\n@until run=1\nX\n"
    found = result(text, "cy525", "gs-c200s")
    assert [line for line in found if line in ("Po", "+50", "+90", "E")] == [
        "Po",
        "+50",
        "E",
        "Po",
        "+90",
        "E",
        "Po",
        "+50",
        "E",
    ]
    assert prove(translate_text(text, "cy525", "gs-c200s")).proven


def test_without_a_free_output_the_end_of_a_program_is_not_shown() -> None:
    text = GSC.format("A1\nA2\nA3\n+100") + "@until ready\nE\n"
    (line,) = [line for line in translate_text(text, "gs-c200s", "cy545b").report if line.code == "@until ready"]
    assert line.kind is LineKind.IMPOSSIBLE and "no pin of the CY545B shows" in line.verdicts[0].limit


def test_a_target_of_the_cy500_replaces_the_distance_until_it_is_set_again() -> None:
    text = "A\nR 230\nS 3\n+\nN 9000\nG\nP 714\nE\nG\n0\nQ\nD\n"
    found = result(text, "cy512", "cy500")
    assert found[found.index("E") + 1 : found.index("Q")] == ["N 9000", "G", "0"]
    assert prove(translate_text(text, "cy512", "cy500")).proven


def test_a_single_step_does_not_change_the_distance() -> None:
    text = "A\nR 200\nS 3\n+\nN 50\nG\nO\nG\n"
    assert result(text, "cy500", "cy525")[-6:] == ["N 50", "G", "N 1", "G", "N 50", "G"]


def test_a_target_in_the_other_direction_passes_the_overflow() -> None:
    report = translate_text("A\nR 200\nS 3\n+\nN 500\nG\nP 100\nG\n", "cy500", "cy525").report
    assert report.lines[-1].kind is LineKind.IMPOSSIBLE and "overflow" in report.lines[-1].verdicts[0].limit


def test_a_move_to_a_position_after_a_stop_ends_at_the_same_position() -> None:
    text = f"{ABORTED}P 100\n"
    proof = prove(translate_text(text, "cy525", "gs-c200s"))
    (run, back), (run_there, back_there) = (
        [each for each in trace.happened if each.kind == "run" or each.value < 0]
        for trace in (proof.source.trace, proof.trace)
    )
    assert proof.proven and run.net != run_there.net
    assert run.net + back.value == run_there.net + back_there.value


def test_a_motor_that_is_off_does_not_move_at_a_target_without_such_a_command() -> None:
    text = "SET_VEL 90000\nSET_ACC 900\nMTR_OFF\nSET_POS 500\nCLR_STATUS\nUPDATE\n"
    for to in ("cy525", "gs-c200s", "linuxcnc"):
        (line,) = [line for line in translate_text(text, "mc1451a", to).report if line.code == "MTR_OFF"]
        assert line.kind is LineKind.IMPOSSIBLE, to


def test_a_motion_without_an_end_is_cut_off_in_both_runs() -> None:
    proof = prove(translate_text("A 0\nF 3\nR 40\nS 200\nZ 1\n+\nN 65000\nH\nG\n", "cy525", "cy545b"))
    assert proof.result is not None and proof.compared is not None and proof.compared.cut
    assert max(proof.source.bench.now_ps, proof.result.bench.now_ps) < 150 * 10**12
