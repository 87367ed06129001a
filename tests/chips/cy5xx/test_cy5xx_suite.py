"""The CY5xx family: what several parts have in common, a test each, run for every part; and each difference, a test.

CY525 manual, section 3, comparison: what it does not list is the same in the CY512.  The shared objects alone are
tested in test_cy5xx.py.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import pytest
from cy5xx import Rig

import slewline
from slewline.chips import sheet_of

US, MS = 10**6, 10**9  # ps


@dataclass(frozen=True)
class Way:
    """How a part is told what all of them can do."""

    quick: str  # the parameters of a brisk move without a ramp
    run: str  # runs the stored program
    home: str  # this place is position 0
    dowhile: str  # the pin that T tests
    hold: str  # the pin that holds the next step
    til: str  # T, to the start of the program
    steps_per_s: int  # of a brisk move
    room: int  # bytes of the program
    delay: str = ""  # waits
    readout: bytes = b""  # group 3 behind N 738 and a brisk move


WAYS = {
    "cy500": Way("R 253\r", "D", "A", "xss", "trigger", "T", 3350, 18),
    "cy512": Way(
        "R 255\rS 0\rF 1\r", "D", "A", "dowhile", "step_inhibit", "T", 5000, 48, "X", bytes([2, 0xE2, 0, 255, 1])
    ),
    "cy525": Way(
        *("F 80\rR 80\rS 255\rZ 1\r", "X", "A 0", "dowhile", "step_inhibit", "T 0", 5978, 60, "D"),
        bytes([2, 0xE2, 255, 80, 80, 1]),
    ),
}
family = pytest.mark.parametrize("part", WAYS)
older = pytest.mark.parametrize("part", ["cy500", "cy512"])
later = pytest.mark.parametrize("part", ["cy512", "cy525"])


class Sister(Rig):
    """A part of the family named x and its host; its crystal is the reference one."""

    def __init__(self, part: str, *record: str, **options: object) -> None:
        self.bench = slewline.Bench()
        self.way = WAYS[part]
        self.x = self.bench.add(part, name="x", **options)
        self.host = self.bench.host(self.x)
        if record:
            self.bench.record(*(f"x.{pin}" for pin in record))

    def say(self, *lines: str) -> Sister:
        self.send("".join(f"{line}\r" for line in lines))
        return self

    def quick(self, *lines: str) -> Sister:
        """Brisk moves from position 0 on; then some commands."""
        self.send(f"{self.way.quick}{self.way.home}\rB\r")
        return self.say(*lines)

    def go(self, timeout: str = "60 s") -> Sister:
        """Run the stored program to its end."""
        self.execute(self.way.run, timeout)
        return self


def alone(part: str) -> Sister:
    return Sister(part)


# ----------------------------------------------------------------------------------------------- alike in every part
@pytest.mark.fact("CY500-CMD-B-1", "CY512-CMD-B-1")
@family
def test_b_and_c_switch_pin_34(part: str) -> None:
    rig = Sister(part, "programmable_output").say("C", "B", "C")
    assert [level for _, level in rig.edges("programmable_output")] == [0, 1, 0]
    assert rig.x.sheet.pin("programmable_output").number == 34


@family
def test_pins_that_parts_share_have_one_number_and_one_role(part: str) -> None:
    reference = {pin.number: pin.role for pin in sheet_of("cy525").pins}
    changed = {"cy500": {10, 28, 29, 30, 33, 39}, "cy512": set(), "cy525": set()}[part]
    for pin in sheet_of(part).pins:
        if pin.number and pin.number not in changed:
            assert pin.role == reference[pin.number], pin


@family
@pytest.mark.parametrize("letter", "BCEGINQRSU+-0")
def test_commands_that_every_part_has_take_the_same_arguments(part: str, letter: str) -> None:
    row, reference = sheet_of(part).commands[letter], sheet_of("cy525").commands[letter]
    assert [arg.size for arg in row.args] == [arg.size for arg in reference.args]
    assert (row.code, row.terminated, row.stored) == (reference.code, reference.terminated, reference.stored)


@family
def test_a_byte_is_taken_in_the_same_clocks_by_every_part(part: str) -> None:
    rig = Sister(part, "io_request", "instrobe", "ready")
    rig.bench.run("1 us")
    rig.host.send("B")
    rig.bench.run("1 ms")
    request = rig.falls("io_request")[0]
    edges = [rig.falls("instrobe")[0], rig.rises("instrobe")[0], rig.falls("ready")[0], rig.rises("ready")[0]]
    assert [rig.x.clock.ticks_until(edge - request + 1) for edge in edges] == [165, 176, 286, 187 * 11]


@pytest.mark.fact("CY512-FORM-1")
@family
def test_letters_in_ascii_and_in_binary_do_the_same(part: str) -> None:
    for data, binary in (("N 738\rC\r", 1), (b"N\2\xe2\2C\0", 0)):
        rig = Sister(part).quick()
        rig.drive("ascii_binary", binary)
        rig.send(data)
        assert rig.x.registers["number"] == 738
        assert rig.level("programmable_output") == 0
        assert rig.codes == []
        if rig.way.readout:
            assert rig.host.verify(3) == rig.way.readout


@pytest.mark.fact("CY512-HS-1", "CY512-UND-TIMES")
def test_a_command_is_taken_at_the_same_instants_by_cy512_and_cy525() -> None:
    edges = []
    for part in ("cy512", "cy525"):
        rig = Sister(part, "io_request", "instrobe", "ready")
        rig.send("B\r+\rE\rP 7\rQ")
        edges.append([rig.edges(pin) for pin in ("io_request", "instrobe", "ready")])
    assert edges[0] == edges[1]
    assert len(edges[0][1]) == 2 * 11


@pytest.mark.fact("CY500-CMD-E-1", "CY500-CMD-Q-1", "CY500-CMD-D-1", "CY512-CMD-E-1", "CY512-CMD-D-1")
@family
def test_program_entry_stores_and_does_not_perform(part: str) -> None:
    rig = Sister(part, "prog", "run").say("C")
    rig.enter("B", "N 300", "0")
    assert rig.level("programmable_output") == 0
    assert rig.x.program.hex() == "424e2c0100"
    assert [level for _, level in rig.edges("prog")] == [0, 1]
    rig.go()
    assert rig.level("programmable_output") == 1
    assert rig.x.registers["number"] == 300
    assert [level for _, level in rig.edges("run")] == [0, 1]
    rig.send("C\r")
    rig.host.run_program()
    rig.bench.run_until_idle("1 s")
    assert rig.level("programmable_output") == 1
    assert rig.codes == []


@family
def test_a_return_after_q_is_reported(part: str) -> None:
    rig = alone(part).say("E", "B")
    rig.send("Q\r")
    assert rig.codes == ["unfinished", "q-terminated"]  # it was idle in program entry


@pytest.mark.fact("CY500-PROG-1", "CY500-UND-OVERFLOW", "CY512-PROG-1", "CY512-CON-BUFFER")
@family
def test_the_program_buffer_holds_the_size_in_the_sheet_and_drops_the_rest(part: str) -> None:
    rig = alone(part)
    room = rig.x.sheet.buffer_bytes
    assert room == rig.way.room
    rig.enter(*["B"] * (room - 2), "C", "0")
    rig.go()
    assert len(rig.x.program) == room
    assert rig.level("programmable_output") == 0
    assert rig.codes == []
    rig.enter(*["B"] * (room + 1))
    assert len(rig.x.program) == room
    assert rig.codes == ["overflow"]


@pytest.mark.fact("CY500-CMD-I-2", "CY512-CMD-I-1")
@family
def test_i_ends_a_program_and_switches_the_coils_off(part: str) -> None:
    rig = alone(part).quick("C", "N 3", "-", "G")
    assert rig.phases != (1, 1, 1, 1)
    kept = dict(rig.x.registers)
    rig.enter("B", "I", "C")
    rig.go()
    assert rig.level("programmable_output") == 1
    assert rig.phases == (1, 1, 1, 1)
    assert rig.x.program == b""
    assert rig.x.registers == kept
    assert part == "cy500" or rig.level("direction") == 1


@pytest.mark.fact("CY500-CMD-G-1", "CY500-CMD-N-1", "CY500-CMD-PLUS-1", "CY512-CMD-G-1")
@family
def test_g_takes_n_steps_in_the_set_direction(part: str) -> None:
    rig = alone(part).quick("N 9", "+", "G", "G", "-", "N 4", "G")
    assert rig.x.position == 14
    assert rig.x.steps().directions.tolist() == [1] * 18 + [-1] * 4
    assert rig.x.registers["number"] == 4


@pytest.mark.fact("CY512-CMD-N-1", "CY512-RAMP-5")
@family
def test_a_relative_move_takes_up_to_65535_steps(part: str) -> None:
    rig = alone(part).quick("N 65535", "+", "G")
    assert rig.x.travel == 65535
    assert rig.x.sheet.commands["N"].args[0].high == 65535


@pytest.mark.fact("CY500-UND-N-ZERO")
@family
def test_n_0_takes_no_step_and_is_reported(part: str) -> None:
    rig = alone(part).quick("N 0", "G")
    assert len(rig.x.steps()) == 0
    assert rig.codes == ["range", "no-steps"]


@pytest.mark.fact("CY512-PIN-7")
@family
def test_four_whole_steps_go_round_the_phases(part: str) -> None:
    rig = alone(part).quick("N 1")
    seen = [rig.say("G").phases for _ in range(5)]
    patterns = ((1, 0, 0, 1), (1, 0, 1, 0), (0, 1, 1, 0), (0, 1, 0, 1), (1, 0, 0, 1))
    assert seen == list(patterns)
    assert rig.say("-", "G").phases == patterns[3]


@family
def test_position_wraps_at_64k(part: str) -> None:
    rig = alone(part).quick("-", "N 3", "G")
    assert rig.x.position == 65533


@pytest.mark.fact("CY512-CMD-T-1")
@family
def test_t_repeats_the_program_while_its_pin_is_low(part: str) -> None:
    rig = alone(part).quick("N 2")
    rig.drive(rig.way.dowhile, 0)
    rig.enter("G", rig.way.til, "C", "0")
    rig.start(f"{rig.way.run}\r")
    rig.bench.run_until(lambda: len(rig.x.steps()) >= 10)
    rig.drive(rig.way.dowhile, 1)
    rig.bench.run_until_idle("1 s")
    assert len(rig.x.steps()) in (10, 12)
    assert rig.level("programmable_output") == 0
    assert rig.level("run") == 1


@pytest.mark.fact("CY512-CMD-U-1")
@pytest.mark.parametrize(("letter", "level"), [("U", 0), ("W", 1)])
@family
def test_until_waits_for_low_and_wait_for_high(part: str, letter: str, level: int) -> None:
    rig = alone(part).say("C")
    rig.drive("wait", 1 - level)
    rig.enter(letter, "B", "0")
    rig.start(f"{rig.way.run}\r")
    rig.bench.run("20 ms")
    if letter not in sheet_of(part).commands.by_form:
        assert rig.codes == ["unknown-command"]
        return
    assert rig.level("programmable_output") == 0
    rig.drive("wait", level)
    rig.bench.run("1 ms")
    assert rig.level("programmable_output") == 1


@family
def test_an_instruction_shows_where_the_program_is(part: str) -> None:
    rig = alone(part)
    seen: list[int] = []
    rig.x.on_instruction.add(seen.append)
    rig.enter("B", "N 3", "C", "0")
    rig.go()
    assert seen == [0, 1, 4, 5]
    assert [row.text for row in rig.x.program_rows()] == ["B", "N 3", "C", "0"]


@family
def test_pulse_falls_with_each_step_and_phases_change_with_it(part: str) -> None:
    rig = Sister(part, "pulse", "phase1").quick("N 4", "G")
    falls = rig.falls("pulse")
    assert falls[-4:] == rig.x.steps().times_ps.tolist()
    assert set(time for time, _ in rig.edges("phase1")) <= set(falls)


@family
def test_motion_complete_falls_after_the_last_step_and_rises_with_the_next_byte(part: str) -> None:
    rig = Sister(part, "pulse", "motion_complete", "instrobe").quick("N 4", "G")
    fell = rig.falls("motion_complete")[-1]
    assert fell > rig.rises("pulse")[-1] - US
    rig.say("B")
    assert rig.rises("instrobe")[-2] <= rig.rises("motion_complete")[-1]


@pytest.mark.fact("CY512-INHIB-1")
@family
def test_the_next_step_is_inhibited_by_its_pin(part: str) -> None:
    rig = alone(part).quick("N 40")
    rig.start("G\r")
    rig.bench.run_until(rig.x.reaches(10), "1 s")
    rig.drive(rig.way.hold, 1)
    rig.bench.run("200 ms")
    assert rig.x.position in (10, 11)
    rig.drive(rig.way.hold, 0)
    rig.bench.run_until_idle("2 s")
    assert rig.x.position == 40


@family
def test_reset_in_mid_motion_cuts_it_and_keeps_the_parameters(part: str) -> None:
    rig = alone(part).quick("N 4000")
    rig.start("G\r")
    rig.bench.run("100 ms")
    moved = rig.x.position
    rig.x.reset()
    rig.bench.run("50 ms")
    assert 0 < rig.x.position <= moved + 1
    assert rig.phases == (1, 1, 1, 1)
    assert rig.x.registers["number"] == 4000
    assert rig.x.idle
    rig.enter("B", "0")
    rig.x.reset()
    rig.bench.run("1 ms")
    assert rig.x.program == b""
    assert rig.x.registers["number"] == 4000


@pytest.mark.fact("CY500-UND-HANDSHAKE", "CY512-HS-2")
@family
def test_ready_is_low_for_a_motion_that_the_host_commands(part: str) -> None:
    rig = Sister(part, "ready", "pulse").quick("N 20", "G")
    first, last = rig.falls("pulse")[0], rig.rises("pulse")[-1]
    assert not [at for at, _ in rig.edges("ready") if first <= at <= last]
    assert rig.edges("ready")[-1][0] > last
    assert rig.level("ready") == 1


@family
def test_power_up_gives_every_register_its_value(part: str) -> None:
    rig = alone(part)
    defaults = dict(rig.x.registers)
    rig.quick("N 5", "G")
    rig.x.power(False)
    rig.bench.run("1 ms")
    assert set(rig.levels("ready", "pulse", "phase1")) <= {None, 0, 1}
    rig.x.power(True)
    rig.bench.run("100 ms")
    assert rig.x.registers == defaults


@pytest.mark.fact("CY512-PIN-3", "CY512-RATE-5")
@pytest.mark.parametrize("divided", [1, 2, 5])
@family
def test_a_motion_is_made_at_its_rate_in_proportion_to_the_crystal(part: str, divided: int) -> None:
    slews = ("slew",) if part != "cy500" else ()
    rig = Sister(part, "motion_complete", *slews, crystal=sheet_of(part).crystal_hz // divided).quick("N 300", "G")
    times = rig.x.steps().times_ps
    assert int(times[-1] - times[0]) / 299 == pytest.approx(10**12 * divided / rig.way.steps_per_s, rel=1e-3)
    over = rig.falls("motion_complete")[-1]
    assert (over - int(times[0])) / 300 == pytest.approx(10**12 * divided / rig.way.steps_per_s, rel=1e-3)
    for pin in slews:
        assert (rig.falls(pin)[-1], rig.rises(pin)[-1]) == (times[0], over)


@pytest.mark.fact("CY500-UND-ERRORS", "CY512-SET-2", "CY512-UND-ERRORS")
@pytest.mark.parametrize("letter", "KMYa")
@family
def test_an_unknown_command_swallows_only_its_own_line(part: str, letter: str) -> None:
    rig = alone(part).say("C", f"{letter} 3", "B")
    assert rig.codes == ["unknown-command"]
    assert rig.level("programmable_output") == 1


@family
def test_unknown_letters_bad_numbers_and_line_feeds(part: str) -> None:
    rig = alone(part).say("K 3", "N two", "G 7")
    assert rig.codes == ["unknown-command", "bad-number", "extra-argument", *rig.codes[3:]]
    rig = alone(part)
    rig.send("C\r\nB\rC\r")
    assert "line-feed" in rig.codes
    assert rig.level("programmable_output") == 0


# -------------------------------------------------------------------------- alike in the older parts, not in the CY525
@older
def test_d_runs_the_program(part: str) -> None:
    rig = alone(part).say("C")
    rig.enter("B", "0")
    rig.say("D")
    rig.bench.run("10 ms")
    assert rig.level("programmable_output") == 1
    assert sheet_of("cy525").commands["D"].name == "DELAY"


@older
def test_h_half_steps_until_i(part: str) -> None:
    rig = alone(part).quick("N 1", "H")
    seen = [rig.say("G").phases for _ in range(8)]
    assert len(set(seen)) == 8
    assert rig.x.position == 8
    rig.say("I")
    assert len({rig.say("G").phases for _ in range(8)}) == 4


@older
def test_a_factor_divides_the_rate(part: str) -> None:
    rig = alone(part).quick("N 3", "G", "F 7", "G")
    times = rig.x.steps().times_ps.tolist()
    assert times[4] - times[3] == pytest.approx(7 * (times[1] - times[0]), rel=1e-4)


@older
def test_a_slope_starts_at_rate_1_and_is_steeper_the_faster_it_is(part: str) -> None:
    rig = alone(part).quick("S 10", "N 100", "G")
    times = rig.x.steps().times_ps.tolist()
    gaps = [b - a for a, b in pairwise(times)]
    assert gaps[:26] == sorted(gaps[:26], reverse=True)
    falls = [a - b for a, b in pairwise(gaps[:25])]
    assert max(falls) - min(falls) < 2 * US  # the period, not the rate, changes evenly
    assert gaps[-25:] == pytest.approx(gaps[25:0:-1], abs=US)


@older
def test_ready_stays_high_for_motions_of_a_program(part: str) -> None:
    rig = Sister(part, "ready").quick("N 20")
    rig.enter("G", "0")
    rig.host.send("D\r")
    rig.bench.run_until(rig.x.pin("run").is_(0), "1 s")
    began = rig.bench.now_ps
    rig.bench.run_until_idle("2 s")
    assert rig.falls("ready", began) == []
    assert rig.x.position == 20


@older
def test_the_first_step_does_not_wait_for_the_host(part: str) -> None:
    rig = Sister(part, "io_request", "pulse").quick("N 1")
    rig.host.send("G")
    rig.pull_request("30 ms", b"\r", ready=True)
    rig.bench.run_until_idle("1 s")
    assert rig.rises("io_request")[-1] > rig.falls("pulse")[-1]


@older
def test_u_is_not_ended_by_the_host(part: str) -> None:
    rig = alone(part).say("C")
    rig.drive("wait", 1)
    rig.enter("U", "B", "0")
    rig.start("D\r")
    rig.bench.run("5 ms")
    rig.pull_request("100 us")
    rig.bench.run("20 ms")
    assert rig.level("programmable_output") == 0


@older
def test_prog_pulled_low_admits_no_live_commands(part: str) -> None:
    rig = alone(part).quick("N 50")
    rig.enter("G", "C", "0")
    rig.start("D\r")
    rig.x.pin("prog").drive(0)
    rig.bench.run_until_idle("5 s")
    assert rig.x.position == 50
    assert rig.level("programmable_output") == 0


@older
def test_pulse_is_high_for_16_us_at_6_mhz_between_steps(part: str) -> None:
    rig = Sister(part, "pulse", crystal="6 MHz").quick("N 3", "G")
    rises, falls = rig.rises("pulse"), rig.falls("pulse")
    assert falls[-1] - rises[-2] == pytest.approx(16 * US, abs=2)


@older
def test_an_inhibited_step_has_pulse_high(part: str) -> None:
    rig = alone(part).quick("N 40")
    rig.start("G\r")
    rig.bench.run_until(rig.x.reaches(10), "1 s")
    rig.drive(rig.way.hold, 1)
    rig.bench.run("200 ms")
    assert rig.level("pulse") == 1


# --------------------------------------------------------------------------- alike in the later parts, not in the CY500
@pytest.mark.fact("CY512-SET-3")
@pytest.mark.parametrize("letter", "BCEGINPQUVW+-0")
def test_a_command_that_the_comparison_leaves_out_has_the_same_row(letter: str) -> None:
    assert sheet_of("cy512").commands[letter] == sheet_of("cy525").commands[letter]


@pytest.mark.fact("CY512-PIN-1", "CY512-PIN-3")
def test_the_pins_of_the_cy512_are_those_of_the_cy525_and_one_without_a_number() -> None:
    ours, theirs = ({pin.name: pin for pin in sheet_of(part).pins} for part in ("cy512", "cy525"))
    assert set(ours) - set(theirs) == {"terminate"}
    assert not set(theirs) - set(ours)
    alike = ("number", "in_out", "active", "pull", "tie", "reset", "role")
    for name, pin in theirs.items():
        same = [each for each in alike if name != "prog" or each not in ("in_out", "pull")]
        assert [getattr(ours[name], each) for each in same] == [getattr(pin, each) for each in same], name
    assert (ours["prog"].way, theirs["prog"].way) == ("out", "both")  # no live commands come through it


@pytest.mark.fact("CY512-CMD-J-1")
@later
def test_jump_continues_at_a_byte(part: str) -> None:
    rig = alone(part)
    rig.enter("C", "J 4", "B", "0")
    rig.go()
    assert rig.x.program.hex(" ") == "43 4a 04 42 00"
    assert rig.level("programmable_output") == 0


@pytest.mark.fact("CY512-CMD-L-1")
@pytest.mark.parametrize("count", [1, 5, 255])
@later
def test_a_loop_makes_the_counted_number_of_passes(part: str, count: int) -> None:
    rig = alone(part).quick("N 1")
    rig.enter("G", f"L {count},0", "0")
    assert rig.go().x.position == count


@pytest.mark.fact("CY512-CMD-P-1", "CY512-PIN-2")
@later
def test_position_finds_the_direction_and_shows_it(part: str) -> None:
    rig = Sister(part, "direction", "pulse").quick("P 40", "P 15")
    assert (rig.x.position, rig.x.travel, len(rig.x.steps())) == (15, 15, 65)
    (turned,) = rig.falls("direction")
    assert rig.falls("pulse")[39] < turned < rig.falls("pulse")[40]


@pytest.mark.fact("CY512-CMD-V-1", "CY512-CMD-V-2")
@pytest.mark.parametrize(("text", "expected"), [(1, b"00750"), (0, b"\2\xee")])
@later
def test_the_position_is_read_as_digits_or_as_two_bytes(part: str, text: int, expected: bytes) -> None:
    rig = alone(part).quick("P 750")
    rig.drive("ascii_binary", text)
    assert rig.host.verify(0) == expected


@pytest.mark.fact("CY512-CMD-V-1", "CY512-UND-V-END")
@later
def test_program_and_status_are_read_and_ff_after_the_end(part: str) -> None:
    rig = alone(part)
    rig.enter("B", "0")
    rig.send("-\r")
    assert rig.host.verify(1, 3) == b"B\0\0"
    assert rig.host.verify(2, 6) == b"\0\0\0\0\0\x10"
    assert rig.codes == []
    assert rig.host.verify(2, 7)[6] == 0xFF
    assert rig.codes == ["verify-overrun"]


@pytest.mark.fact("CY512-CMD-D-2")
@family
def test_run_in_a_program_restarts_it(part: str) -> None:
    rig = alone(part).quick("N 1")
    rig.enter("G", rig.way.run)
    rig.start(f"{rig.way.run}\r")
    rig.bench.run("40 ms")
    assert rig.x.position > 20
    assert rig.level("run") == 0


@pytest.mark.fact("CY512-CMD-X-1", "CY512-CMD-X-2")
@pytest.mark.parametrize(("crystal", "ms"), [("11 MHz", 500), ("5.5 MHz", 1000)])
@later
def test_the_delay_counts_milliseconds_of_an_11_mhz_crystal(part: str, crystal: str, ms: int) -> None:
    rig = Sister(part, "ready", "run", crystal=crystal)
    rig.send(f"{rig.way.delay} 500\r")
    last = rig.edges("ready")[-2:]
    assert last[1][0] - last[0][0] == pytest.approx(ms * MS, rel=0.001)
    assert rig.edges("run") == []


@pytest.mark.fact("CY512-UND-EXPEND")
@later
def test_a_delay_of_0_ends_immediately(part: str) -> None:
    rig = alone(part)
    rig.send(f"{rig.way.delay} 0\r")
    assert rig.bench.now_ps < 2 * MS


# --------------------------------------------------------------------------------------------- what one part has alone
@pytest.mark.parametrize(
    ("part", "letters"),
    [
        ("cy500", "ABCDEFGHIJLNOPQRSTU+-0"),
        ("cy512", "ABCDEFGHIJLNOPQRSTUVWX+-0"),
        ("cy525", "ABCDEFGHIJLNOPQRSTUVWXZ+-0"),
    ],
)
def test_each_part_has_its_letters(part: str, letters: str) -> None:
    assert sorted(row.form for row in sheet_of(part).commands) == sorted(letters)


@pytest.mark.fact("CY500-FAM-4")
def test_nine_tenths_of_the_letters_of_the_cy500_remain() -> None:
    ours, theirs = sheet_of("cy500").commands, sheet_of("cy512").commands
    same = [row.form for row in ours if row.form in theirs.by_form and theirs[row.form].args == row.args]
    assert set("ABCDEGHIQTU+-0") <= set(same)
    assert sum(pin.trust == "inferred" for pin in sheet_of("cy500").pins) > 25


@family
def test_p_starts_the_motion_except_in_the_cy500(part: str) -> None:
    rig = alone(part).quick("P 6")
    assert rig.x.position == (0 if part == "cy500" else 6)


@family
def test_p_finds_its_direction_except_in_the_cy500(part: str) -> None:
    rig = alone(part).quick("N 9", "G", "P 4", *["G"] * (part == "cy500"))
    assert rig.x.position == 4
    assert rig.x.travel == (65540 if part == "cy500" else 4)


@family
def test_o_is_a_single_step_in_the_cy500_and_a_pattern_in_its_successors(part: str) -> None:
    rig = alone(part).quick(*["O"] if part == "cy500" else ["O 2"])
    assert rig.x.position == (1 if part == "cy500" else 0)
    assert rig.phases == ((1, 0, 0, 1) if part == "cy500" else (1, 0, 1, 0))


@family
def test_l_is_a_line_in_the_cy500_and_a_loop_in_its_successors(part: str) -> None:
    rig = alone(part).quick("N 1")
    if part == "cy500":
        rig.drive("xdir", 0)
        assert rig.say("L", "G").x.position == 65535
    else:
        rig.enter("G", "L 3,0", "0")
        assert rig.go().x.position == 3


@family
def test_j_is_jog_in_the_cy500_and_a_jump_in_its_successors(part: str) -> None:
    rig = alone(part).quick("C")
    if part == "cy500":
        rig.say("J").x.pin("xss").pulse(0, "3 ms")
        rig.bench.run("10 ms")
        assert rig.x.position > 5
    else:
        rig.enter("J 3", "B", "0")
        rig.go()
        assert rig.level("programmable_output") == 0


@family
def test_the_end_of_the_stored_bytes_ends_the_program_in_the_cy500_only(part: str) -> None:
    rig = alone(part)
    rig.enter("B")
    rig.start(f"{rig.way.run}\r")
    rig.bench.run("20 ms")
    assert rig.level("run") == (1 if part == "cy500" else 0)
    assert rig.codes == ["end-of-program"]


@family
def test_the_program_run_without_one_returns_to_command_mode_in_the_cy500_only(part: str) -> None:
    rig = alone(part)
    rig.start(f"{rig.way.run}\r")
    rig.bench.run("20 ms")
    assert rig.level("run") == (1 if part == "cy500" else 0)


@family
def test_n_directly_after_a_loses_a_step_in_the_cy500_only(part: str) -> None:
    rig = alone(part)
    rig.send(rig.way.quick)
    rig.say(rig.way.home, "N 10", "G")
    assert rig.x.position == (9 if part == "cy500" else 10)


@family
def test_q_in_command_mode_is_a_mistake_except_in_the_cy500(part: str) -> None:
    rig = alone(part)
    rig.send("Q")
    assert rig.codes == ([] if part == "cy500" else ["quit-outside-entry"])


@pytest.mark.fact("CY500-FAM-2")
@family
@pytest.mark.parametrize("source", ["keyboard", "prom", "host"])
def test_a_program_comes_from_a_keyboard_a_prom_or_a_bus(part: str, source: str) -> None:
    bench = slewline.Bench()
    x = bench.add(part, name="x")
    text = "E\rC\rN 7\r0\rQ"
    if source == "host":
        bench.host(x).send(text)
    elif source == "keyboard":
        bench.part("keyboard", to="x", down="1 ms", apart="2 ms").type(text)
    else:
        bench.part("prom", to="x", image=text)
    bench.run("100 ms")
    assert x.program.hex() == "434e070000"
