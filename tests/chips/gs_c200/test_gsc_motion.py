"""Ramps, speeds, the times of steps and of instructions, and how a motion ends before its time; through the pins."""

from __future__ import annotations

from math import sqrt

import pytest
from gsc import C200, C200S, CHARACTER, MS, SETUP, STR, TURNROUND, US, WIDTH, Rig, base, both, gaps, spacing

from tests.ensembles import few


def endless(part: str, sign: str = "+") -> str:
    return ("G" if part == C200 else "g") + sign


def under(rig: Rig, pin: str) -> list[int]:
    """How many steps begin in each interval in which a pin is high."""
    steps = rig.pulses()
    return [sum(rise <= step < fall for step in steps) for rise, fall in pairs(rig, pin)]


def pairs(rig: Rig, pin: str) -> list[tuple[int, int]]:
    """From when to when a pin is high, each time."""
    return list(zip(rig.rises(pin), rig.falls(pin), strict=True))


# ------------------------------------------------------------------------------------------------------------- ramps
@both
@pytest.mark.fact("GSC-RAMP-1", "GSC-RAMP-2", "GSC-PIN-RAMP-1", "GSC-UND-RAMP-COUNT", "GSC-UND-FIRST-PULSE")
def test_the_ramps_take_r_steps_and_mirror_each_other(part: str) -> None:
    rig = base(part, "ramp")
    rig.run("S10", "T100", "R50", "+1000")
    steps = gaps(rig.pulses())
    assert steps == spacing(1000, 10, 100, 50)[:-1]
    assert steps[0] == 10 * MS
    assert [step for step, gap in enumerate(steps) if gap == MS] == list(range(50, 949))
    assert all(MS < gap <= 10 * MS for gap in steps[:50])
    # RAMP is high for 50 intervals of each ramp; the last one leads to the last step
    assert [end - begin for begin, end in pairs(rig, "ramp")] == [SETUP + sum(steps[:50]), sum(steps[:50]) + WIDTH]
    assert under(rig, "ramp") == [50, 51]


@both
@pytest.mark.fact("GSC-RAMP-1", "GSC-UND-FIRST-PULSE", "GSC-UND-RAMP-COUNT")
@pytest.mark.parametrize("length", few([1, 2, 50, 3, 999], 2))
@pytest.mark.parametrize("slewing", [-3, -2, -1, 0, 1, 2, 100])
def test_the_intervals_of_a_move_read_the_same_backwards(part: str, length: int, slewing: int) -> None:
    rig = base(part)
    number = max(2 * length + 1 + slewing, 2)
    rig.run("S10", "T100", f"R{length}", f"+{number}")
    steps = gaps(rig.pulses())
    assert len(steps) == number - 1
    assert steps == steps[::-1] and steps[0] == 10 * MS
    assert steps.count(MS) == max(number - 1 - 2 * length, 0)


@both
@pytest.mark.fact("GSC-RAMP-7", "GSC-UND-FIRST-PULSE")
@pytest.mark.parametrize("length", [1, 2, 3, 50])
@pytest.mark.parametrize("issued", few([1, 3, 2, 4, 50, 51, 52, 60], 4))
def test_z_decelerates_as_the_motion_accelerated(part: str, length: int, issued: int) -> None:
    rig = base(part, "ramp")
    rig.start("S10", "T100", f"R{length}", endless(part))
    up = spacing(1000, 10, 100, length)
    rig.bench.run_until(rig.x.reaches(1))
    rig.acts("Z", rig.pulses()[0] + sum(up[: issued - 1]) + 5 * US)
    rig.bench.run_until_idle()
    steps = gaps(rig.pulses())
    assert steps == steps[::-1]
    assert len(rig.pulses()) == issued + min(issued, length + 1)
    assert steps == spacing(len(rig.pulses()), 10, 100, length)[:-1]


@both
@pytest.mark.fact("GSC-UND-RAMP-LAW")
def test_the_speed_of_a_ramp_grows_at_constant_acceleration(part: str) -> None:
    rig = base(part)
    rig.run("S10", "T100", "R50", "+1000")
    steps = gaps(rig.pulses())
    assert [round(1e12 / gap, 1) for gap in steps[:6]] == [100.0, 172.6, 222.7, 263.4, 298.7, 330.2]
    for k, gap in enumerate(steps[:51]):
        assert gap == round(1e12 / sqrt(100**2 + (1000**2 - 100**2) * k / 50))


@pytest.mark.fact("GSC-UND-RAMP-LAW", "GSC-RAMP-2")
@pytest.mark.parametrize("law", ["linear in steps", lambda start, top, ramp, k: start + (top - start) * k / ramp])
def test_another_law_changes_only_the_steps_between_the_ends(law: object) -> None:
    rig = base(C200S, "ramp", options={"law": law})
    rig.run("S10", "T100", "R50", "+1000", "+60")
    steps = gaps(rig.pulses())
    assert steps[:50] == [round(10**12 / (100 + 18 * k)) for k in range(50)]
    assert steps[50:949] == [MS] * 899
    assert steps[:999] == steps[998::-1]
    assert len(rig.pulses()) == 1060
    assert under(rig, "ramp") == [50, 51, 60]


@both
@pytest.mark.fact("GSC-RAMP-3", "GSC-RAMP-4", "GSC-PIN-RAMP-4")
def test_a_short_move_turns_round_before_it_is_at_top_speed(part: str) -> None:
    rig = base(part, "ramp", "mov")
    rig.run("S10", "T100", "R50", "+60")
    steps = gaps(rig.pulses())
    assert len(steps) == 59
    assert steps == spacing(60, 10, 100, 50)[:-1]
    assert min(steps) > MS and max(steps) == 10 * MS
    assert [step for step, gap in enumerate(steps) if gap == min(steps)] == [29]
    assert steps == steps[::-1]
    assert rig.edges("ramp") == rig.edges("mov")


@both
@pytest.mark.fact("GSC-RAMP-5", "GSC-UND-SHORT-ODD", "GSC-UND-SINGLE", "GSC-PIN-RAMP-4")
def test_moves_of_every_length_around_two_ramps_are_exact(part: str) -> None:
    rig = base(part, "ramp", "mov")
    rig.run(*STR)
    done = 0
    for number in (1, 2, 3, 4, 5, 18, 19, 20, 21, 22, 23):
        before, edges = rig.bench.now_ps, len(rig.edges("ramp"))
        rig.run(f"+{number}")
        steps = rig.pulses(before)
        done += number
        assert len(steps) == number and rig.x.position == done
        assert gaps(steps) == spacing(number, 10, 100, 10)[:-1]
        assert rig.edges("mov")[-1][0] == steps[-1] + WIDTH
        assert len(rig.edges("ramp")) - edges == (0 if number == 1 else 2 if number <= 21 else 4)


@both
@pytest.mark.fact("GSC-UND-SHORT-ODD")
def test_a_short_move_of_odd_length_has_two_fastest_intervals(part: str) -> None:
    rig = base(part)
    rig.run(*STR, "+7", "+8")
    up = spacing(100, 10, 100, 10)
    assert gaps(rig.pulses()[:7]) == [up[0], up[1], up[2], up[2], up[1], up[0]]
    assert gaps(rig.pulses()[7:]) == [up[0], up[1], up[2], up[3], up[2], up[1], up[0]]


@both
@pytest.mark.fact("GSC-RAMP-6", "GSC-UND-T-LE-S", "GSC-PIN-RAMP-4")
@pytest.mark.parametrize(("start", "top", "gap"), [(50, 50, 2 * MS), (50, 10, 10 * MS), (2, 1, 100 * MS)])
def test_a_slew_speed_not_above_the_start_stop_speed_is_that_of_the_whole_move(
    part: str, start: int, top: int, gap: int
) -> None:
    rig = base(part, "ramp", "mov", "uo1")
    rig.run(f"S{start}", f"T{top}", "R20", "+50", "A1")
    assert gaps(rig.pulses()) == [gap] * 49
    assert rig.edges("ramp") == []
    assert len(rig.edges("mov")) == 2
    assert rig.rises("uo1") == [rig.pulses()[-1] + gap + MS]  # the last interval passes too


@both
@pytest.mark.fact("GSC-RAMP-8")
@pytest.mark.parametrize("length", [1, 2, 3, 500, 999])
def test_a_ramp_has_from_1_to_999_steps(part: str, length: int) -> None:
    rig = base(part, "ramp")
    rig.run("S10", "T100", f"R{length}", "+3000")
    assert under(rig, "ramp") == [length, length + 1]
    assert gaps(rig.pulses()) == spacing(3000, 10, 100, length)[:-1]


@both
@pytest.mark.fact("GSC-RAMP-8", "GSC-SPEED-1", "GSC-CON-SPEED-GRID")
def test_values_outside_the_ranges_of_s_t_and_r_are_refused(part: str) -> None:
    rig = base(part)
    assert rig.prg("R1", "R999", "S1", "S1000", "T1", "T1000") == ["Y"] * 6
    assert rig.asks("R0", "R1000", "S0", "S1001", "T0", "T1001", "S1.5") == ["E2"] * 7


# ------------------------------------------------------------------------------------------------------------ speeds
@both
@pytest.mark.fact("GSC-SPEED-1", "GSC-TIME-4", "GSC-CON-SPEED-GRID")
@pytest.mark.parametrize(
    ("top", "gap"),
    [(1, 10**11), (2, 5 * 10**10), (3, 33_333_333_333), (37, 2_702_702_703), (500, 2 * 10**8), (1000, 10**8)],
)
def test_a_slew_interval_is_one_over_ten_t(part: str, top: int, gap: int) -> None:
    rig = base(part)
    rig.run("S1", f"T{top}", "R1", "+100")
    steps = gaps(rig.pulses())
    assert steps == [10**11, *[gap] * 97, 10**11]


@both
@pytest.mark.fact("GSC-SPEED-2")
def test_t300_is_900_turns_a_minute(part: str) -> None:
    rig = base(part)
    rig.run("S30", "T300", "R50", "+5000")
    slew = set(gaps(rig.pulses())[50:4949])
    assert slew == {333_333_333}
    assert 60 / (200 * slew.pop() / 1e12) == pytest.approx(900, rel=1e-8)


@both
@pytest.mark.fact("GSC-TIME-4")
def test_ten_thousand_slew_intervals_do_not_drift(part: str) -> None:
    rig = base(part)
    rig.run("S10", "T100", "R10", "+10021")
    steps = rig.pulses()
    assert steps[10_010] - steps[10] == 10_000 * MS


@both
@pytest.mark.fact("GSC-SPEED-3")
@pytest.mark.parametrize("lacking", [(), ("S10",), ("S10", "T100"), ("T100", "R10"), ("S10", "R10")])
def test_a_motion_before_s_t_and_r_is_refused(part: str, lacking: tuple[str, ...]) -> None:
    rig = base(part)
    rig.prg(*lacking, "+5", *STR)
    assert rig.ask("E") == "E4"
    rig.bench.run("1 s")
    assert rig.pulses() == [] and rig.ask("F") == "R"
    rig.prg(*STR, "+5")
    assert rig.ask("E") == "Y"
    rig.bench.run_until_idle()
    assert len(rig.pulses()) == 5


@both
@pytest.mark.fact("GSC-SPEED-4")
def test_speeds_stay_in_force_until_power_off(part: str) -> None:
    rig = base(part)
    rig.run(*STR)
    rig.run("+50")
    assert gaps(rig.pulses()) == spacing(50, 10, 100, 10)[:-1]
    rig.run("R1", "+50")  # one of them is replaced, the others stay
    assert gaps(rig.pulses()[50:]) == spacing(50, 10, 100, 1)[:-1]
    rig.x.power(False)
    rig.x.power(True)
    rig.prg("+50")
    assert rig.ask("E") == "E4"


# ------------------------------------------------------------------------------------------------------------- times
@both
@pytest.mark.fact("GSC-TIME-1", "GSC-CON-CLOCK-WIDTH", "GSC-PIN-CLOCK-1")
@pytest.mark.parametrize("top", [1, 100, 1000])
def test_clock_is_low_for_1_7_us_at_every_speed(part: str, top: int) -> None:
    rig = base(part, "clock")
    assert rig.level("clock") == 1
    rig.run("S10", f"T{top}", "R5", "+37")
    edges = rig.edges("clock")
    assert [level for _, level in edges] == [0, 1] * 37
    assert [rise - fall for (fall, _), (rise, _) in zip(edges[::2], edges[1::2], strict=True)] == [WIDTH] * 37
    assert [fall for fall, _ in edges[::2]] == rig.pulses()
    assert rig.level("clock") == 1


@both
@pytest.mark.fact("GSC-UND-FIRST-PULSE", "GSC-UND-LAST-PULSE", "GSC-UND-DIR-SETUP", "GSC-CON-MOV-END", "GSC-PIN-MOV-3")
def test_mov_rises_with_dir_and_falls_with_the_last_pulse(part: str) -> None:
    rig = base(part, "dir", "mov", "ramp", "uo1")
    rig.run(*STR, "+50", "-50", "A1")
    steps = rig.pulses()
    assert rig.falls("mov") == [steps[49] + WIDTH, steps[99] + WIDTH]
    assert rig.rises("mov") == [steps[0] - SETUP, steps[50] - SETUP]
    assert rig.edges("dir") == [(steps[50] - SETUP, 0)]
    assert rig.falls("ramp")[1::2] == rig.falls("mov")
    # one start-stop period behind the last pulse the next instruction begins, and takes its time
    assert steps[50] - SETUP == steps[49] + 10 * MS + MS
    assert rig.rises("uo1") == [steps[99] + 10 * MS + MS]


@pytest.mark.fact("GSC-UND-DIR-SETUP", "GSC-UND-LAST-PULSE", "GSC-UND-INSTR-TIME")
def test_set_up_hold_and_instruction_time_can_be_chosen() -> None:
    options = {"dir_setup": "100 us", "instruction_time": "250 us", "mov_hold": True}
    rig = base(C200S, "mov", "ramp", "uo1", options=options)
    rig.run(*STR, "+50", "A1")
    steps = rig.pulses()
    assert rig.edges("mov") == [(steps[0] - 100 * US, 1), (steps[-1] + 10 * MS, 0)]
    assert rig.falls("ramp")[-1] == steps[-1] + 10 * MS
    assert rig.rises("uo1") == [steps[-1] + 10 * MS + 250 * US]


@both
@pytest.mark.fact("GSC-UND-DIR-REST", "GSC-PIN-DIR-1")
def test_dir_rests_at_1_and_later_at_the_last_direction(part: str) -> None:
    rig = base(part)
    rig.bench.run("1 s")
    seen = [rig.level("dir")]
    for line in ("+9", "-3", "D3", "+1"):
        rig.run(*STR, line)
        seen.append(rig.level("dir"))
    assert seen == [1, 1, 0, 0, 1]


@both
@pytest.mark.fact("GSC-TIME-3")
@pytest.mark.parametrize("tenths", [1, 10, 100, 255])
def test_delays_count_in_tenths_of_a_second(part: str, tenths: int) -> None:
    rig = base(part, "uo1")
    rig.run("A1", f"D{tenths}", "C1")
    (rise, _), (fall, _) = rig.edges("uo1")
    assert fall - rise == tenths * 100 * MS + 2 * MS  # D and C take their time too


@both
@pytest.mark.fact("GSC-TIME-5", "GSC-UND-INSTR-TIME", "GSC-CON-PULSE-WIDTH")
def test_an_output_set_and_cleared_by_neighbours_pulses_for_an_instruction_time(part: str) -> None:
    rig = base(part, "uo2")
    rig.run("A2", "C2", "A2", "C2")
    first, *_ = rig.rises("uo2")
    assert rig.edges("uo2") == [(first, 1), (first + MS, 0), (first + 2 * MS, 1), (first + 3 * MS, 0)]


@both
@pytest.mark.fact("GSC-TIME-5", "GSC-TIME-7", "GSC-UND-INSTR-TIME", "GSC-CON-PULSE-WIDTH")
@pytest.mark.parametrize("phase", [0, 1, MS // 2, MS - 1, MS])
def test_a_wait_sees_every_pulse_of_an_instruction_time(part: str, phase: int) -> None:
    rig = base(part, "uo1", ui2=0)
    rig.prg("W2", "A1")
    look = rig.bench.now_ps + 2 * CHARACTER + TURNROUND + 50 * MS  # a look every millisecond
    assert rig.ask("E") == "Y"
    rig.x.pin("ui2").pulse(1, MS - 1, at=look - 10 * MS)  # one from look to look, neither included, is not seen
    rig.x.pin("ui2").pulse(1, MS, at=look + phase)
    rig.bench.run_until_idle()
    assert rig.rises("uo1") == [look + (phase // MS + 1) * MS + MS]


@pytest.mark.fact("GSC-TIME-5", "GSC-CON-PULSE-WIDTH")
@pytest.mark.parametrize("late", range(0, 1100, 100))
def test_another_module_waits_for_the_short_pulse_and_continues(late: int) -> None:
    rig = base(C200)
    bench = rig.bench
    y = bench.add("gs-c200s", name="y", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0})
    host = bench.host(y)
    bench.wire("x.uo2", "y.ui2")
    assert [host.ask(line) for line in ("Po", "W2", "A1", "E")] == ["Y"] * 4
    bench.run(late * US)
    rig.run("A2", "C2")
    assert y.pin("uo1").level == 1


COMMANDS = {
    C200: "F I1 I2 I3 V1 V2 Q K Z X P S10 G5 G+ G-1 M E H",
    C200S: "F I1 f+5 V1 V2 Q K Z X Po S10 G+5 g+ g-1 j0 jc0,0 I1 f-3 Px Po +5 A1 C1 D1 L0 L5 U1 W1 M E H",
}


@both
@pytest.mark.fact("GSC-TIME-6")
def test_an_answer_begins_a_millisecond_after_the_carriage_return(part: str) -> None:
    rig = base(part, "txd", options={"eeprom_time": "1.2 s"})
    rig.bench.run("2 ms")
    for command in [*COMMANDS[part].split(), "nonsense", "S9999", "F"]:
        sent = rig.bench.now_ps
        rig.wire(f"{command}\r")
        first = rig.rises("txd", sent)[0]
        writing = 10 * MS * (len(rig.x.program) + 1) if command == "M" else 0
        reset = 400 * US if command in ("I1", "I3") and not rig.x._entering else 0
        assert first == sent + CHARACTER * (len(command) + 1) + TURNROUND + writing + reset, command


# ----------------------------------------------------------------------------------------------------- early endings
@both
@pytest.mark.fact("GSC-RAMP-7", "GSC-TIME-7")
@pytest.mark.parametrize("number", [1, 2, 40, 41])
def test_z_slows_down_from_the_rate_that_was_reached(part: str, number: int) -> None:
    rig = base(part, "mov")
    rig.start("S10", "T100", "R200", endless(part))
    up = spacing(1000, 10, 100, 200)
    rig.bench.run_until(rig.x.reaches(1))
    rig.acts("Z", rig.pulses()[0] + sum(up[: number - 1]) + 5 * US)
    rig.bench.run_until_idle()
    assert gaps(rig.pulses()) == spacing(2 * number, 10, 100, 200)[:-1]
    assert rig.x.position == 2 * number
    assert rig.falls("mov") == [rig.pulses()[-1] + WIDTH]


@both
@pytest.mark.fact("GSC-RAMP-7")
def test_z_is_sampled_just_before_each_step(part: str) -> None:
    for early, number in ((0, 162), (1, 161)):  # exactly with step 150, counted from 0, it comes too late for it
        rig = base(part)
        rig.start(*STR, endless(part))
        rig.bench.run_until(rig.x.reaches(100))
        rig.acts("Z", rig.pulses()[-1] + 51 * MS - early)
        rig.bench.run_until_idle()
        assert rig.x.position == number
        assert gaps(rig.pulses()) == spacing(number, 10, 100, 10)[:-1]


@both
@pytest.mark.fact("GSC-RAMP-7")
def test_z_during_deceleration_changes_nothing(part: str) -> None:
    rig = base(part)
    rig.start(*STR, "+30", "+30")
    rig.bench.run_until(rig.x.reaches(25))
    assert rig.ask("Z") == "Y"
    rig.bench.run_until_idle()
    assert gaps(rig.pulses()) == spacing(30, 10, 100, 10)[:-1]  # and the program is over


@both
@pytest.mark.fact("GSC-UND-T-LE-S", "GSC-RAMP-7")
def test_z_without_ramps_ends_with_the_step_in_progress(part: str) -> None:
    rig = base(part, "mov")
    rig.start("S100", "T100", "R50", endless(part))
    rig.bench.run_until(rig.x.reaches(10))
    rig.acts("Z", rig.pulses()[-1] + 20 * MS + MS // 2)
    rig.bench.run_until_idle()
    assert rig.x.position == 31 - 1
    assert gaps(rig.pulses()) == [MS] * 29
    assert rig.falls("mov") == [rig.pulses()[-1] + MS]


@both
@pytest.mark.fact("GSC-UND-K-DETAIL", "GSC-POS-8", "GSC-TIME-7")
@pytest.mark.parametrize(
    ("after", "issued", "clock_up"),
    [(-1, 149, -1), (0, 150, WIDTH), (US, 150, WIDTH), (WIDTH, 150, WIDTH), (2 * US, 150, 2 * US)],
)
def test_k_completes_the_pulse_in_progress_and_makes_no_other(
    part: str, after: int, issued: int, clock_up: int
) -> None:
    rig = base(part, "clock", "mov", "ramp")
    rig.start(*STR, "A2", "+1000")
    rig.bench.run_until(rig.x.reaches(100))
    last = rig.pulses()[-1] + 50 * MS  # step 150
    rig.acts("K", last + after)
    assert rig.falls("mov") == [last + clock_up]
    rig.bench.run("3 s")
    assert len(rig.pulses()) == issued == rig.x.position == rig.pos()
    assert rig.falls("clock") == rig.pulses() and len(rig.rises("clock")) == issued
    assert rig.rises("clock")[-1] - rig.falls("clock")[-1] == WIDTH
    assert rig.level("uo2") == 1
    assert rig.ask("F") == "R"


@both
@pytest.mark.fact("GSC-UND-K-DETAIL", "GSC-PIN-RAMP-3")
def test_k_in_a_ramp_drops_mov_and_ramp_together(part: str) -> None:
    rig = base(part, "mov", "ramp")
    rig.start("S10", "T100", "R500", "+1000")
    rig.bench.run_until(rig.x.reaches(20))
    assert rig.ask("K") == "Y"
    assert rig.edges("mov") == rig.edges("ramp")
    assert len(rig.edges("mov")) == 2


@both
@pytest.mark.fact("GSC-UND-K-DETAIL")
def test_k_between_dir_and_the_first_step_prevents_the_step(part: str) -> None:
    rig = base(part, "mov", "dir")
    rig.start(*STR, "-5" if part == C200S else "+5", "D5", "+5")
    rig.bench.run_until_idle()
    second = rig.rises("mov")[1] - rig.rises("mov")[0]
    before = len(rig.pulses())
    assert rig.ask("E") == "Y"
    rig.bench.run_until(rig.x.pin("mov").is_(1))
    rig.acts("K", rig.bench.now_ps + second + 5 * US)
    rig.bench.run("1 s")
    assert len(rig.pulses()) == before + 5
    assert rig.falls("mov")[-1] - rig.rises("mov")[-1] == 5 * US


@both
@pytest.mark.fact("GSC-UND-GX-STOP", "GSC-TIME-7", "GSC-UND-INSTR-TIME")
@pytest.mark.parametrize("steps", [4, 100])
def test_controlled_velocity_slows_down_when_its_input_is_low_and_the_program_continues(part: str, steps: int) -> None:
    rig = base(part, "mov", "uo1")
    rig.start(*STR, endless(part) + "2", "A1")
    rig.bench.run_until(rig.x.reaches(1))
    up = spacing(1000, 10, 100, 10)
    first = rig.pulses()[0]
    at = first + sum(up[:steps]) + 1  # just behind step `steps`, counted from 0
    rig.drive("ui2", 0, at=at)
    look = first - SETUP + ((at - first + SETUP) // MS + 1) * MS  # a look every millisecond from the begin on
    begun = sum(first + sum(up[:step]) <= look for step in range(steps + 4))
    rig.bench.run_until_idle()
    number = begun + min(begun, 11)
    assert gaps(rig.pulses()) == spacing(number, 10, 100, 10)[:-1]
    assert rig.rises("uo1") == [rig.pulses()[-1] + 10 * MS + MS]
    assert rig.ask("F") == "R"


@both
@pytest.mark.fact("GSC-UND-GX-STOP")
def test_controlled_velocity_with_its_input_low_takes_no_step(part: str) -> None:
    rig = base(part, "mov", "dir", "uo1", ui2=0)
    rig.run(*STR, endless(part, "-") + "2", "A1")
    assert rig.pulses() == [] and rig.edges("mov") == [] and rig.edges("dir") == []
    assert rig.level("uo1") == 1 and rig.ask("F") == "R"  # not even on a GS-C200 at 0, whose counter could not go down


@both
@pytest.mark.fact("GSC-UND-GX-STOP")
def test_controlled_velocity_misses_an_input_that_is_low_between_two_samples(part: str) -> None:
    rig = base(part, "mov")
    rig.start(*STR, endless(part) + "1")
    rig.bench.run_until(rig.x.pin("mov").is_(1))
    begin = rig.bench.now_ps
    rig.x.pin("ui1").pulse(0, MS - 1, at=begin + 30 * MS)  # from look to look, neither included
    rig.bench.run("500 ms")
    assert rig.x.registers["position"] > 400
    rig.x.pin("ui1").pulse(0, MS, at=rig.bench.now_ps + 123_456)
    rig.bench.run_until_idle()


@both
@pytest.mark.fact("GSC-UND-GX-STOP")
@pytest.mark.parametrize(("early", "steps"), [(0, 2), (1, 0)])
def test_controlled_velocity_first_samples_at_its_start(part: str, early: int, steps: int) -> None:
    rig = base(part)
    begin = rig.start(*STR, endless(part) + "2", "D1", "+1") + 4 * MS
    rig.drive("ui2", 0, at=begin - early)
    rig.bench.run_until_idle()
    assert rig.x.position == steps + 1  # in the instant itself it is seen a look later, when a step is made


@both
@pytest.mark.fact("GSC-UND-GX-STOP", "GSC-RAMP-7")
def test_a_stop_holds_for_one_motion_only(part: str) -> None:
    rig = base(part)
    rig.start(*STR, endless(part) + "2", "+20")
    rig.bench.run_until(rig.x.reaches(50))
    rig.drive("ui2", 0)
    rig.bench.run_until_idle()
    assert gaps(rig.pulses()[-20:]) == spacing(20, 10, 100, 10)[:-1]
    rig.drive("ui2", 1)
    position = rig.x.position
    rig.start(*STR, endless(part))
    rig.bench.run_until(rig.x.reaches(position + 50))
    assert rig.ask("Z") == "Y"
    rig.bench.run_until_idle()
    position = rig.x.position
    rig.run("+20")
    assert rig.x.position == position + 20


@both
@pytest.mark.fact("GSC-CON-W-EDGE", "GSC-TIME-7")
def test_a_wait_samples_the_level_and_not_an_edge(part: str) -> None:
    rig = base(part, "uo1")
    rig.prg("W1", "A1")  # UI1 is high from the beginning
    sent = rig.bench.now_ps
    assert rig.ask("E") == "Y"
    rig.bench.run_until_idle()
    assert rig.rises("uo1") == [sent + 2 * CHARACTER + TURNROUND + 2 * MS]


@both
@pytest.mark.fact("GSC-CON-U")
def test_until_repeats_while_its_input_is_high_and_continues_when_it_is_low(part: str) -> None:
    rig = base(part, "uo2")
    rig.start("A2", "D1", "C2", "U3", "A1")
    rig.bench.run_until(rig.x.pin("uo2").edges(5))
    rig.drive("ui3", 0)
    rig.bench.run_until_idle()
    assert len(rig.rises("uo2")) == 3
    assert rig.levels("uo1", "uo2") == (1, 0)
