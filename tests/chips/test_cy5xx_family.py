"""What the parts of the CY5xx family have in common: each statement is one test, run for every part that it holds for.

CY525 manual, section 3, comparison: what it does not list is the same in the CY512.
"""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from slewline.chips import sheet_of
from tests.chips.conftest import Rig

MS = 10**9


@dataclass(frozen=True)
class Spoken:
    """How a part is told what all of them can do."""

    part: str
    home: str  # this place is position 0
    run: str  # the letter that runs the program
    delay: str  # the letter that waits
    til: str  # to the start of the program while DOWHILE is low
    rate: str  # rates without a ramp, and every register set
    steps_per_s: int  # at that rate, at 11 MHz
    readout: bytes  # group 3 behind N 738, the rate, and home

    def rig(self, **options: object) -> Rig:
        """A bench with the part and its host; `rate` has been said."""
        r = Rig(part=self.part, **options)
        r.send(self.rate + "\r" + self.home + "\r")
        return r

    def run_program(self, r: Rig, *lines: str, timeout: str = "60 s") -> None:
        """Enter a program, and run it to its end."""
        r.enter(*lines)
        r.execute(self.run, timeout)


CY525 = Spoken("cy525", "A 0", "X", "D", "T 0", "F 40\rR 40\rS 255\rZ 1\rN 1", 4000, bytes([2, 0xE2, 255, 40, 40, 1]))
CY512 = Spoken("cy512", "A", "D", "X", "T", "R 255\rS 0\rF 1\rN 1", 5000, bytes([2, 0xE2, 0, 255, 1]))
family = pytest.mark.parametrize("of", [CY525, CY512], ids=lambda of: of.part)


# ------------------------------------------------------------------------------------------------------------- commands
@pytest.mark.fact("CY512-CMD-B-1")
@family
def test_bitset_and_clearbit_switch_the_programmable_output(of):
    r = of.rig()
    for letter, level in ("C", 0), ("B", 1), ("C", 0):
        r.send(f"{letter}\r")
        assert r.level("programmable_output") == level


@pytest.mark.fact("CY512-CMD-E-1")
@family
def test_enter_begins_and_quit_ends_program_entry_by_itself(of):
    r = of.rig()
    r.send("E\rB\r")
    assert r.level("prog") == 0 and r.level("programmable_output") == 1
    r.send("Q")
    assert r.level("prog") == 1 and r.x.program == b"B"


@pytest.mark.fact("CY512-CMD-G-1")
@family
def test_go_takes_the_number_of_steps_and_keeps_it(of):
    r = of.rig()
    r.send("N 7\r+\rG\rG\r")
    assert (r.x.position, r.x.registers["number"]) == (14, 7)
    r.send("-\rG\r")
    assert r.x.position == 7


@pytest.mark.fact("CY512-CMD-I-1")
@family
def test_initialize_forgets_the_program_and_keeps_the_parameters(of):
    r = of.rig()
    r.enter("B", "0")
    r.send("N 9\r-\rG\r")
    kept = dict(r.x.registers)
    r.send("I\r")
    assert r.x.program == b"" and r.x.registers == kept
    assert r.level("direction") == 1 and r.phases == (1, 1, 1, 1)


@pytest.mark.fact("CY512-CMD-J-1")
@family
def test_jump_continues_at_a_byte(of):
    r = of.rig()
    of.run_program(r, "C", "J 4", "B", "0")
    assert r.x.program.hex(" ") == "43 4a 04 42 00" and r.level("programmable_output") == 0


@pytest.mark.fact("CY512-CMD-L-1")
@pytest.mark.parametrize("count", [1, 2, 5, 255])
@family
def test_a_loop_makes_as_many_passes_as_it_counts(of, count):
    r = of.rig()
    of.run_program(r, "G", f"L {count},0", "0")
    assert r.x.position == count


@pytest.mark.fact("CY512-FORM-1")
@family
def test_numbers_come_as_text_and_as_bytes(of):
    texts, data = of.rig(), of.rig()
    texts.send("N 738\r")
    data.x.pin("ascii_binary").drive(0)
    data.send(b"N\2\xe2\2")
    for r in (texts, data):
        assert r.host.verify(3) == of.readout


@pytest.mark.fact("CY512-CMD-N-1", "CY512-RAMP-5")
@family
def test_a_relative_move_takes_up_to_65535_steps(of):
    r = of.rig()
    r.send("N 65535\r+\rG\r")
    assert r.x.travel == 65535 and r.x.sheet.commands["N"].args[0].high == 65535


@pytest.mark.fact("CY512-CMD-P-1", "CY512-PIN-2")
@family
def test_position_finds_the_direction_and_shows_it(of):
    r = of.rig(record=("direction", "pulse"))
    r.send("P 40\rP 15\r")
    assert (r.x.position, r.x.travel, len(r.x.steps())) == (15, 15, 65)
    (turned,) = r.falls("direction")
    assert r.falls("pulse")[39] < turned < r.falls("pulse")[40]


@pytest.mark.fact("CY512-CMD-U-1")
@pytest.mark.parametrize(("letter", "level"), [("U", 0), ("W", 1)])
@family
def test_until_waits_for_low_and_wait_for_high(of, letter, level):
    r = of.rig()
    r.drive("wait", 1 - level)
    r.enter("C", letter, "B", "0")
    r.start(f"{of.run}\r")
    r.bench.run("50 ms")
    assert r.level("programmable_output") == 0
    r.drive("wait", level)
    r.bench.run_until_idle()
    assert r.level("programmable_output") == 1


@pytest.mark.fact("CY512-CMD-V-1", "CY512-CMD-V-2")
@pytest.mark.parametrize(("text", "expected"), [(1, b"00750"), (0, b"\2\xee")])
@family
def test_the_position_is_read_as_digits_or_as_two_bytes(of, text, expected):
    r = of.rig()
    r.send("P 750\r")
    r.drive("ascii_binary", text)
    assert r.host.verify(0) == expected


@pytest.mark.fact("CY512-CMD-V-1", "CY512-UND-V-END")
@family
def test_program_and_status_are_read_and_ff_behind_the_end(of):
    r = of.rig()
    r.enter("B", "0")
    r.send("-\r")
    assert r.host.verify(1, 3) == b"B\0\0" and r.host.verify(2, 6) == b"\0\0\0\0\0\x10"
    assert "verify-overrun" not in r.codes
    assert r.host.verify(2, 7)[6] == 0xFF and r.codes[-1] == "verify-overrun"


@pytest.mark.fact("CY512-CMD-D-1")
@family
def test_the_program_runs_from_its_start_and_run_is_low(of):
    r = of.rig(record=("run",))
    of.run_program(r, "C", "0")
    assert [level for _, level in r.edges("run")] == [0, 1] and r.level("programmable_output") == 0


@pytest.mark.fact("CY512-CMD-D-2")
@family
def test_run_in_a_program_begins_it_anew_and_without_one_leaves_run_mode_on(of):
    r = of.rig()
    r.enter("G", of.run)
    r.start(f"{of.run}\r")
    r.bench.run("100 ms")
    assert r.x.position > 20 and r.level("run") == 0
    empty = of.rig()
    empty.start(f"{of.run}\r")
    empty.bench.run("100 ms")
    assert empty.level("run") == 0 and "end-of-program" in empty.codes


@pytest.mark.fact("CY512-CMD-T-1")
@family
def test_til_repeats_the_program_while_dowhile_is_low(of):
    r = of.rig()
    r.drive("dowhile", 0)
    r.enter("N 5", "+", "G", "-", "G", "N 1", of.til, "0")
    r.start(f"{of.run}\r")
    r.bench.run("100 ms")
    assert r.level("run") == 0 and len(r.x.steps()) > 20
    r.drive("dowhile", 1)
    r.bench.run_until_idle()
    assert r.level("run") == 1 and len(r.x.steps()) % 10 == 0 and r.x.position == 0


@pytest.mark.fact("CY512-CMD-X-1", "CY512-CMD-X-2")
@pytest.mark.parametrize(("crystal", "ms"), [("11 MHz", 500), ("5.5 MHz", 1000)])
@family
def test_the_delay_counts_milliseconds_of_an_11_mhz_crystal(of, crystal, ms):
    r = of.rig(crystal=crystal, record=("ready", "run"))
    since = r.bench.now_ps
    r.send(f"{of.delay} 500\r")
    last = r.edges("ready", since)[-2:]
    assert last[1][0] - last[0][0] == pytest.approx(ms * MS, rel=0.001) and r.edges("run") == []


@pytest.mark.fact("CY512-UND-EXPEND")
@family
def test_a_delay_of_0_is_over_at_once(of):
    r = of.rig(record=("ready",))
    since = r.bench.now_ps
    r.send(f"{of.delay} 0\r")
    assert r.bench.now_ps - since < 2 * MS


# --------------------------------------------------------------------------------------------------- handshake and time
@pytest.mark.fact("CY512-HS-1", "CY512-UND-TIMES")
def test_a_byte_is_taken_at_the_same_instants_by_all():
    edges = []
    for of in (CY525, CY512):
        r = Rig(part=of.part, record=("io_request", "instrobe", "ready"))
        r.send("B\r+\rE\rP 7\rQ")
        edges.append([r.edges(pin) for pin in ("io_request", "instrobe", "ready")])
    assert edges[0] == edges[1] and len(edges[0][1]) == 2 * 11


@pytest.mark.fact("CY512-HS-2")
@family
def test_ready_is_low_for_a_motion_that_the_host_commands(of):
    r = of.rig(record=("ready", "pulse"))
    r.send("N 20\rG\r")
    first, last = r.falls("pulse")[0], r.rises("pulse")[-1]
    assert not [at for at, _ in r.edges("ready") if first <= at <= last]
    assert r.edges("ready")[-1][0] > last and r.level("ready") == 1


@pytest.mark.fact("CY512-PROG-1", "CY512-UND-ERRORS", "CY512-CON-BUFFER")
@family
def test_the_program_buffer_holds_what_the_sheet_says_and_drops_the_rest(of):
    room = sheet_of(of.part).buffer_bytes
    assert room == {"cy525": 60, "cy512": 48}[of.part]
    r = of.rig()
    of.run_program(r, *["B"] * (room - 2), "C", "0")
    assert len(r.x.program) == room and "overflow" not in r.codes and r.level("programmable_output") == 0
    r.enter(*["B"] * (room + 1))
    assert len(r.x.program) == room and r.codes.count("overflow") == 1


@pytest.mark.fact("CY512-SET-2", "CY512-UND-ERRORS")
@pytest.mark.parametrize("letter", "KMYa")
@family
def test_what_is_no_command_takes_its_line_along_and_nothing_else(of, letter):
    r = of.rig()
    r.send(f"C\r{letter} 3\rB\r")
    assert r.codes[-1] == "unknown-command" and r.level("programmable_output") == 1


@pytest.mark.fact("CY512-SET-3")
@pytest.mark.parametrize("letter", "BCEGINPQUVW+-0")
def test_a_command_that_the_comparison_leaves_out_has_the_same_row(letter):
    assert sheet_of("cy512").commands[letter] == sheet_of("cy525").commands[letter]


# --------------------------------------------------------------------------------------------------------------- motion
@pytest.mark.fact("CY512-INHIB-1")
@family
def test_step_inhibit_holds_the_next_step(of):
    r = of.rig(record=("pulse",))
    r.send("N 40\r")
    r.start("G\r")
    r.bench.run_until(lambda: len(r.x.steps()) == 10)
    r.drive("step_inhibit", 1)
    r.bench.run("100 ms")
    assert len(r.x.steps()) == 10
    r.drive("step_inhibit", 0)
    r.bench.run_until_idle()
    assert len(r.x.steps()) == 40


@pytest.mark.fact("CY512-PIN-3", "CY512-RATE-5")
@pytest.mark.parametrize("crystal", [11, 5.5, 1])
@family
def test_a_motion_slews_at_its_rate_in_proportion_to_the_crystal(of, crystal):
    r = of.rig(crystal=f"{crystal} MHz", record=("slew", "motion_complete"))
    r.send("N 300\rG\r")
    since, to = r.falls("slew")[-1], r.rises("slew")[-1]
    assert (to - since) / 300 == pytest.approx(10**12 * 11 / crystal / of.steps_per_s, rel=1e-3)
    assert r.falls("motion_complete")[-1] == to


@pytest.mark.fact("CY512-PIN-7")
@family
def test_four_full_steps_go_once_round_the_phases(of):
    r = of.rig()
    seen = []
    for _ in range(4):
        r.send("G\r")
        seen.append(r.phases)
    assert seen == [(1, 0, 0, 1), (1, 0, 1, 0), (0, 1, 1, 0), (0, 1, 0, 1)]


@family
def test_reset_keeps_parameters_and_forgets_the_program(of):
    r = of.rig()
    r.enter("B", "0")
    r.send("N 77\r")
    kept = dict(r.x.registers)
    r.x.reset()
    r.bench.run("1 ms")
    assert r.x.program == b"" and r.x.registers == kept


@pytest.mark.fact("CY512-PIN-1", "CY512-PIN-3")
def test_the_pins_are_those_of_the_cy525_and_one_without_a_number():
    ours, theirs = ({pin.name: pin for pin in sheet_of(part).pins} for part in ("cy512", "cy525"))
    assert set(ours) - set(theirs) == {"terminate"} and not set(theirs) - set(ours)
    alike = ("number", "way", "active", "pull", "tie", "reset", "role")
    for name, pin in theirs.items():
        assert [getattr(ours[name], each) for each in alike] == [getattr(pin, each) for each in alike], name


@family
def test_a_host_runs_the_program_with_the_letter_of_the_part(of):
    r = of.rig()
    r.enter("C", "0")
    r.host.run_program()
    r.bench.run_until_idle()
    assert r.level("programmable_output") == 0 and "missing-argument" not in r.codes
