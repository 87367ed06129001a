"""Stand-alone start of the GS-C modules: REC low at power-up recalls the program, homes, and runs it.

The RESET pulse of power-up lasts 400 us; the first step of the homing follows 10 us later, one every 1/S from then on.
"""

from __future__ import annotations

from typing import Any

import pytest
from gsc import C200, CHARACTER, MS, NINE_SIX, SETUP, STR, TURNROUND, US, Rig, base, both, gaps

import slewline
from slewline.core.memory.store import Memory

RESET = 400 * US
PROGRAM = (*STR, "+50")
PINS = ("clock", "mov", "ramp", "dir", "uo1")


def kept(part: str, *lines: str) -> Memory:
    """An EEPROM with a program."""
    rig = base(part)
    assert rig.prg(*lines) == ["Y"] * len(lines)
    assert rig.ask("M") == "Y"
    return rig.x.store


def alone(part: str, *lines: str, **straps: int) -> Rig:
    """A module with a program in its EEPROM and REC low, at power-up."""
    return base(part, "reset", "rdy", *PINS, options={"store": kept(part, *lines)}, **{"rec": 0, **straps})


def without_host(part: str, **straps: int) -> Any:
    """The same without a host, RXD being open unless it is strapped."""
    bench = slewline.Bench()
    return bench, bench.add(part, name="x", straps={**NINE_SIX, "rec": 0, **straps}, store=kept(part, *PROGRAM))


@both
@pytest.mark.fact("GSC-AUTO-1", "GSC-AUTO-6", "GSC-AUTO-7", "GSC-CON-HOME-AUTO")
def test_the_program_is_recalled_homed_and_run_without_a_host(part: str) -> None:
    rig = alone(part, *PROGRAM)
    assert rig.levels("reset", "rdy") == (0, 0)
    first = RESET + SETUP
    rig.drive("eot", 0, at=first + 295 * MS)  # after 30 steps
    rig.drive("home", 0, at=first + 300 * MS + SETUP + 115 * MS)  # and 12 back
    rig.bench.run_until_idle()
    back = first + 300 * MS + SETUP
    begin = back + 120 * MS + 4 * MS + SETUP
    pulses = rig.pulses()
    assert rig.edges("reset") == [(RESET, 1)]
    assert rig.moves() == [30, -12, 50]
    assert pulses[:43] == [*(first + n * 10 * MS for n in range(30)), *(back + n * 10 * MS for n in range(12)), begin]
    assert rig.rises("rdy")[0] == pulses[-1] + 10 * MS  # low from power-up on
    assert rig.pos() == 50
    assert rig.listed() == list(PROGRAM)
    assert rig.x.findings == []


@both
@pytest.mark.fact("GSC-AUTO-2")
@pytest.mark.parametrize(("straps", "direction"), [({}, 1), ({"rxd": 1}, -1)])
def test_rxd_selects_the_direction_of_the_homing(part: str, straps: dict[str, int], direction: int) -> None:
    bench, x = without_host(part, **straps)
    bench.run("15 ms")
    assert x.steps().times_ps.tolist() == [RESET + SETUP, RESET + SETUP + 10 * MS]
    assert x.steps().directions.tolist() == [direction] * 2


@both
@pytest.mark.fact("GSC-AUTO-3")
def test_the_idle_line_of_a_host_counts_as_open(part: str) -> None:
    rig = alone(part, *PROGRAM)
    assert rig.x.pin("rxd").net.drivers  # a connected one
    rig.bench.run("15 ms")
    assert rig.moves() == [2]


@both
@pytest.mark.fact("GSC-UND-AUTO-RXD")
@pytest.mark.parametrize(("before", "after", "direction"), [(1, 0, -1), (0, 1, 1)])
def test_rxd_is_read_when_the_homing_starts(part: str, before: int, after: int, direction: int) -> None:
    bench, x = without_host(part)
    x.pin("rxd").drive(1 - before)
    x.pin("rxd").drive(before, at=RESET - US)
    x.pin("rxd").drive(after, at=RESET + US)
    bench.run("15 ms")
    assert x.steps().directions.tolist() == [direction] * 2


@both
@pytest.mark.fact("GSC-AUTO-4")
def test_both_switches_grounded_mean_no_homing(part: str) -> None:
    rig = alone(part, *PROGRAM, eot=0, home=0)
    rig.bench.run_until_idle()
    assert rig.moves() == [50] and rig.pos() == 50
    assert rig.edges("dir") == []


@both
@pytest.mark.fact("GSC-AUTO-5")
def test_nothing_happens_with_rec_high(part: str) -> None:
    rig = alone(part, *PROGRAM, rec=1)
    rig.bench.run("10 s")
    assert rig.pulses() == rig.edges("mov") == []
    assert rig.asks("F", "Q", "X") == ["R", "END", "Y"]
    assert rig.listed() == list(PROGRAM)


@both
@pytest.mark.fact("GSC-AUTO-5")
def test_rec_is_read_at_power_up_alone(part: str) -> None:
    rig = alone(part, *PROGRAM, rec=1)
    rig.bench.run("1 s")
    rig.drive("rec", 0)
    rig.bench.run("1 s")
    assert rig.pulses() == [] and rig.ask("F") == "R"


@both
@pytest.mark.fact("GSC-AUTO-6")
@pytest.mark.parametrize("speed", [10, 25])
def test_the_s_at_the_head_is_the_speed_of_the_homing(part: str, speed: int) -> None:
    rig = alone(part, f"S{speed}", "T100", "R10", "S5", "+50")
    rig.bench.run("1 s")
    assert set(gaps(rig.pulses())) == {100 * MS // speed}
    assert len(rig.pulses()) == 10 * speed


@both
@pytest.mark.fact("GSC-AUTO-6", "GSC-UND-AUTO-NO-S")
@pytest.mark.parametrize("lines", [("T100", "R10", "S10", "+50"), ("A1",), ("T100", "S10", "+50")])
def test_a_program_that_does_not_begin_with_s_is_neither_homed_nor_run(part: str, lines: tuple[str, ...]) -> None:
    rig = alone(part, *lines)
    rig.bench.run("10 s")
    assert rig.pulses() == rig.edges("mov") == rig.rises("uo1") == []
    assert rig.codes == ["no-autorun"]
    assert rig.ask("F") == "R"
    assert rig.listed() == list(lines)


@both
@pytest.mark.fact("GSC-UND-DEFAULTS")
def test_a_program_that_lacks_a_speed_is_neither_homed_nor_run(part: str) -> None:
    rig = alone(part, "S10", "T100", "+50", "R10")
    rig.bench.run("10 s")
    assert rig.pulses() == rig.edges("mov") == []
    assert rig.codes == ["no-autorun"] and rig.ask("F") == "R"


@both
@pytest.mark.fact("GSC-UND-AUTO-EMPTY")
def test_an_empty_eeprom_starts_nothing(part: str) -> None:
    rig = base(part, "mov", rec=0)
    rig.bench.run("10 s")
    assert rig.pulses() == rig.edges("mov") == []
    assert rig.asks("F", "Q") == ["R", "END"] and rig.codes == []


@pytest.mark.fact("GSC-AUTO-7", "GSC-CON-HOME-AUTO")
def test_on_the_c200_only_a_homing_of_the_host_erases_the_program() -> None:
    rig = alone(C200, *PROGRAM, eot=0, home=0)
    rig.bench.run_until_idle()
    assert rig.listed() == list(PROGRAM)
    assert rig.ask("H") == "Y"
    rig.bench.run_until_idle()
    assert rig.listed() == []


@both
@pytest.mark.fact("GSC-AUTO-8")
@pytest.mark.parametrize("end", ["K", "Z"])
def test_the_line_works_during_a_stand_alone_run(part: str, end: str) -> None:
    rig = alone(part, *STR, "A1", "D50", "A2", eot=0, home=0)
    assert rig.asks("F", "V1", end, "F") == ["B", "B", "Y", "R"]
    rig.bench.run("10 s")
    assert rig.levels("uo1", "uo2") == (1, 0)
    homing = alone(part, *PROGRAM)
    assert homing.asks("F", end, "F") == ["B", "Y", "R"]
    steps = len(homing.pulses())
    homing.bench.run("1 s")
    assert len(homing.pulses()) == steps > 0


@both
def test_a_line_that_the_supply_cuts_short_does_not_keep_rdy_low_after_the_run(part: str) -> None:
    rig = alone(part, *PROGRAM, eot=0, home=0)
    rig.bench.run_until_idle()
    rig.host.write("F\r")
    rig.bench.run(2 * CHARACTER + TURNROUND // 2)  # the line is in work
    assert rig.level("rdy") == 0
    rig.cycle()
    rig.bench.run_until_idle()
    assert rig.pos() == 50
    assert rig.level("rdy") == 1
