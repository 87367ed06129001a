"""The CY5xx family from the CY500 to the CY545B: what all five have in common, a test each, run for every part.

What only those with a program buffer of their own share stands in test_cy5xx_suite.py.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import pytest
from cy5xx import Rig

import slewline
from slewline.chips import ramps_of, sheet_of


@dataclass(frozen=True)
class Way:
    """How a part is told what all of them can do."""

    quick: str  # the parameters of a brisk move without a ramp
    home: str  # this place is position 0
    output: str  # a pin that programs switch
    on: str
    off: str
    run: str  # runs the stored program
    modulus: int  # positions
    delay: str  # waits for so many milliseconds, at the crystal of the sheet
    steps_per_s: float  # of a brisk move
    starts: str = ""  # in front of E
    extra: dict[str, object] = field(default_factory=dict)


OWN = ("programmable_output", "B", "C")
BITS = ("usrb2", "B 2", "B 18")
WAYS = {
    "cy500": Way("R 253", "A", *OWN, "D", 1 << 16, "", 3350),
    "cy512": Way("R 255\rS 0\rF 1", "A", *OWN, "D", 1 << 16, "X 30", 5000),
    "cy525": Way("F 80\rR 80\rS 255\rZ 1", "A 0", *OWN, "X", 1 << 16, "D 30", 5978),
    **dict.fromkeys(
        ("cy545", "cy545b"), Way("F 137\rR 137", "A 0", *BITS, "Y 0\rX", 1 << 24, "D 30", 10**6 / 168, starts="Y 0\r")
    ),
}
all_five = pytest.mark.parametrize("part", WAYS)


class Sister(Rig):
    """A part of the family named x, its host, and a memory where it has none of its own."""

    def __init__(self, part: str, *record: str, crystal: int | None = None) -> None:
        self.bench, self.way, self.part = slewline.Bench(), WAYS[part], part
        self.x = self.bench.add(part, name="x", crystal=crystal)
        if self.x.sheet.role("memory_select") is not None:
            self.bench.part("ram", name="memory", to=self.x, image=b"0\r" * 4096)
        self.host = self.bench.host(self.x)
        if record:
            self.bench.record(*(f"x.{pin}" for pin in record))

    def say(self, *lines: str) -> Sister:
        self.send("".join(f"{line}\r" for line in lines))
        return self

    def quick(self, *lines: str) -> Sister:
        """Brisk moves from position 0 on; then some commands."""
        return self.say(self.way.quick, self.way.home, "+", *lines)

    def store(self, *lines: str) -> None:
        """Enter a program at address 0."""
        self.send(self.way.starts + "".join(f"{line}\r" for line in ("E", *lines)) + "Q")

    def go(self) -> Sister:
        """Run the stored program to its end."""
        self.host.send(f"{self.way.run}\r")
        self.bench.run("5 ms")
        self.bench.run_until_idle("60 s")
        return self

    @property
    def out(self) -> int | None:
        return self.level(self.way.output)

    def pin(self, role: str) -> str:
        """The name of the pin that has a role."""
        row = self.x.sheet.role(role)
        assert row is not None
        return row.name


@all_five
def test_letters_that_are_not_exchanged_have_the_same_meaning(part: str) -> None:
    rows, reference = sheet_of(part).commands, sheet_of("cy525").commands
    for letter in "EGIQRS+-0":
        assert rows[letter].role == reference[letter].role or letter == "I"
        assert [arg.size for arg in rows[letter].args] == [arg.size for arg in reference[letter].args]
        assert (rows[letter].code, rows[letter].terminated) == (reference[letter].code, reference[letter].terminated)
    assert not rows["Q"].stored and rows["0"].code == 0


@all_five
def test_a_program_switches_an_output(part: str) -> None:
    rig = Sister(part, WAYS[part].output)
    rig.say(rig.way.off, rig.way.on, rig.way.off)
    assert [level for _, level in rig.edges(rig.way.output)] == [0, 1, 0]


@pytest.mark.fact("CY545-CMD-G-1", "CY545-CMD-G-2", "CY545-CMD-PLUS-1")
@all_five
def test_g_takes_n_steps_in_the_set_direction(part: str) -> None:
    rig = Sister(part).quick("N 9", "+", "G", "G", "-", "N 4", "G")
    assert rig.x.position == 14
    assert rig.x.steps().directions.tolist() == [1] * 18 + [-1] * 4
    assert rig.x.registers["number"] == 4
    assert rig.codes == []


@pytest.mark.fact("CY545-UND-N-ZERO")
@all_five
def test_n_0_takes_no_step_and_is_reported(part: str) -> None:
    rig = Sister(part).quick("N 0", "G")
    assert len(rig.x.steps()) == 0
    assert rig.codes[-1] == "no-steps"


@pytest.mark.fact("CY545-UND-WRAP")
@all_five
def test_the_position_wraps(part: str) -> None:
    rig = Sister(part).quick("-", "N 3", "G")
    assert rig.x.position == rig.way.modulus - 3


@pytest.mark.fact("CY545-PULSE-1")
@all_five
def test_each_step_is_one_fall_of_its_pulse(part: str) -> None:
    rig = Sister(part, "pulse").quick("N 4", "G")
    assert rig.falls("pulse")[-4:] == rig.x.steps().times_ps.tolist()
    assert rig.level("pulse") == 1


@pytest.mark.fact("CY545-CMD-E-1", "CY545-CMD-X-1")
@all_five
def test_program_entry_stores_and_does_not_perform(part: str) -> None:
    rig = Sister(part).say(WAYS[part].off)
    rig.store(rig.way.on, "N 300", "0")
    assert rig.out == 0
    rig.go()
    assert rig.out == 1
    assert rig.x.registers["number"] == 300
    rig.say(rig.way.off).go()
    assert rig.out == 1
    assert rig.codes == []


@pytest.mark.fact("CY545-CMD-0-1")
@all_five
def test_0_ends_a_program_and_the_rest_is_not_performed(part: str) -> None:
    rig = Sister(part).quick()
    rig.store("N 5", "G", "0", rig.way.off)
    rig.say(rig.way.on).go()
    assert (rig.x.position, rig.out) == (5, 1)
    assert rig.x.program_counter is None
    assert rig.say(rig.way.off).out == 0


@pytest.mark.fact("CY545-CMD-I-1")
@all_five
def test_i_ends_a_program(part: str) -> None:
    rig = Sister(part).quick()
    rig.store(rig.way.off, "I", "N 9", "G", "0")
    rig.go()
    assert len(rig.x.steps()) == 0
    assert rig.x.program_counter is None


@all_five
def test_each_instruction_is_reported_with_its_address(part: str) -> None:
    rig = Sister(part)
    seen: list[int] = []
    rig.x.on_instruction.add(seen.append)
    rig.store("+", "N 3", "-", "0")
    rig.go()
    sizes = [2, 4, 2] if rig.x.sheet.role("memory_select") is not None else [1, 3, 1]
    assert seen == [0, *(sum(sizes[: n + 1]) for n in range(3))]


@pytest.mark.fact("CY545-UND-LETTER")
@pytest.mark.parametrize("letter", "KMa")
@all_five
def test_an_unknown_command_swallows_only_its_own_line(part: str, letter: str) -> None:
    rig = Sister(part).say(WAYS[part].off, f"{letter} 3", WAYS[part].on)
    assert rig.codes == ["unknown-command"]
    assert rig.out == 1


@pytest.mark.fact("CY545-UND-LF", "CY545-UND-ILLEGAL")
@all_five
def test_bad_numbers_surplus_ones_and_line_feeds_are_reported(part: str) -> None:
    rig = Sister(part).quick("N two", "N 3", "G 7")
    assert rig.codes == ["bad-number", "extra-argument"]
    assert rig.x.position == 3
    rig.send(f"{rig.way.off}\r\n{rig.way.on}\r")
    assert "line-feed" in rig.codes
    assert rig.out == 0


@pytest.mark.fact("CY545-BIN-2")
@all_five
def test_a_letter_a_count_and_data_do_the_same_as_text(part: str) -> None:
    rig = Sister(part).quick()
    text = rig.x.sheet.role("text")
    if text is not None:
        rig.drive(text.name, 0)
    else:
        rig.say("O 0")
    size = rig.x.sheet.commands["N"].args[0].size
    rig.send(bytes([0x4E, size]) + (738).to_bytes(size, "little") + b"-\0G\0")
    assert rig.x.registers["number"] == 738
    assert rig.x.position == rig.way.modulus - 738
    assert rig.codes == []


@pytest.mark.fact("CY545-HS-8")
@all_five
def test_the_part_is_busy_for_a_motion_that_the_host_commands(part: str) -> None:
    rig = Sister(part, "pulse", sheet_of(part).role("ready").name).quick("N 20", "G")
    ready = rig.pin("ready")
    first, last = rig.falls("pulse")[-20], rig.rises("pulse")[-1]
    assert not [at for at, _ in rig.edges(ready) if first <= at <= last]
    assert rig.edges(ready)[-1][0] > last
    assert rig.level(ready) == 1


@pytest.mark.fact("CY545-RATE-1", "CY545-PULSE-4")
@pytest.mark.parametrize("divided", [1, 2, 5])
@all_five
def test_a_motion_is_made_at_its_rate_in_proportion_to_the_crystal(part: str, divided: int) -> None:
    rig = Sister(part, crystal=sheet_of(part).crystal_hz // divided).quick("N 300", "G")
    times = rig.x.steps().times_ps
    assert int(times[-1] - times[0]) / 299 == pytest.approx(10**12 * divided / rig.way.steps_per_s, rel=1e-3)


@pytest.mark.fact("CY545-CMD-D-1")
@pytest.mark.parametrize("part", [part for part in WAYS if WAYS[part].delay])
def test_a_delay_lasts_for_its_milliseconds(part: str) -> None:
    rig = Sister(part).quick("N 1")
    rig.store("G", rig.way.delay, "G", "0")
    rig.go()
    one, two = rig.x.steps().times_ps.tolist()
    assert 30 <= (two - one) / 10**9 < 36


@all_five
def test_reset_in_mid_motion_cuts_it(part: str) -> None:
    rig = Sister(part).quick("N 4000")
    rig.start("G\r")
    rig.bench.run("100 ms")
    moved = len(rig.x.steps())
    rig.x.reset()
    rig.bench.run("50 ms")
    assert 0 < len(rig.x.steps()) <= moved + 1
    assert rig.x.idle
    rig.host.clear()
    before = len(rig.x.steps())
    rig.quick("N 3", "G")
    assert len(rig.x.steps()) == before + 3


@pytest.mark.fact("CY545-RESET-1")
@all_five
def test_power_up_gives_every_register_its_value(part: str) -> None:
    rig = Sister(part)
    defaults = dict(rig.x.registers)
    rig.quick("N 5", "G")
    rig.x.power(False)
    rig.bench.run("1 ms")
    rig.x.power(True)
    rig.bench.run("100 ms")
    assert rig.x.registers == defaults


@all_five
def test_fast_path_and_twin_step_at_the_same_instants(part: str) -> None:
    found = []
    for stepwise in (False, True):
        bench = slewline.Bench()
        x = bench.add(part, name="x", stepwise=stepwise)
        way = WAYS[part]
        bench.host(x).send(f"{way.quick}\rN 40\r+\rG\r-\rN 7\rG\r")
        bench.run_until_idle("10 s")
        found.append(x.steps().times_ps.tolist())
    assert found[0] == found[1]
    assert len(found[0]) == 47


GUIDE = {  # bytes of program, instructions (the sheets of the CY500 have one more than the guide), usable steps/s
    "cy500": (18, 22, 3350),
    "cy512": (48, 25, 5000),
    "cy525": (60, 26, 9675),
    "cy545": (65536, 28, 20000),
    "cy545b": (65536, 28, 20000),
}


@pytest.mark.fact("FAMILY-1", "CY545-SYS-1", "CY545-CON-INSTR-COUNT")
@all_five
def test_the_family_differs_in_rates_program_memory_and_number_of_instructions(part: str) -> None:
    sheet = sheet_of(part)
    assert (sheet.buffer_bytes, len(sheet.commands), max(sheet.rates)) == GUIDE[part]
    by = [sheet_of(one) for one in GUIDE]
    for older, newer in pairwise(by[:4]):
        assert older.buffer_bytes < newer.buffer_bytes
        assert max(older.rates) < max(newer.rates)
        assert len(older.commands) < len(newer.commands)


RAMPS = {
    "cy500": {"R": 253, "S": 1},
    "cy512": {"R": 255, "S": 1},
    "cy525": {"F": 3, "R": 127, "S": 100, "Z": 1},
    "cy545": {"F": 0, "R": 136, "S": 175},
    "cy545b": {"F": 0, "R": 136, "S": 175},
}


@pytest.mark.fact("FAMILY-1")
@all_five
def test_ramps_are_exponential_in_the_older_parts_and_linear_in_the_newer_ones(part: str) -> None:
    rig = Sister(part)
    rig.say(*(f"{letter} {number}" for letter, number in RAMPS[part].items()), "+", "N 60000", "G")
    times = rig.x.steps().times_ps
    periods = [later - earlier for earlier, later in pairwise(times.tolist()[:30000])]
    top = min(periods)
    ramp = periods.index(top)
    half = next(n for n, period in enumerate(periods) if period <= 2 * top)
    share = int(times[half] - times[0]) / int(times[ramp] - times[0])  # of the ramp that is slower than half the rate
    assert share > 0.8 if part in ("cy500", "cy512") else 0.4 < share < 0.65
    assert ramps_of(part) is not None
