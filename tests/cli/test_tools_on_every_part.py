"""The commands know every part: a suite over PARTS in which no part has a test of its own."""

from __future__ import annotations

import pytest

from slewline.chips import PARTS, sheet_of

PACKETS = ("SET_VEL 0x10000", "SET_ACC 0x800", "SET_POS 30", "UPDATE")
PROGRAMS = {  # take 30 steps, and are no reason to complain
    "cy500": ("A", "R 253", "+", "E", "N 30", "G", "0", "QD"),
    "cy512": ("A", "R 250", "S 0", "F 1", "+", "E", "N 30", "G", "0", "QD"),
    "cy525": ("A 0", "F 5", "R 5", "S 255", "Z 1", "+", "E", "N 30", "G", "0", "QX"),
    **dict.fromkeys(("cy545", "cy545b"), ("A 0", "F 20", "R 20", "+", "E", "N 30", "G", "0", "Q", "Y 0", "X")),
    "gs-c200": ("P", "S20", "T100", "R5", "+30", "E"),
    "gs-c200s": ("Po", "S20", "T100", "R5", "+30", "E"),
}
RAMPS = {"cy500": "R=253 S=10", "cy512": "R=250 S=10", "cy525": "F=3 R=80 S=100"}
RAMPS |= dict.fromkeys(("cy545", "cy545b"), "F=14 R=100 S=220")
RAMPS |= dict.fromkeys(("gs-c200", "gs-c200s"), "S=10 T=300 R=5")

every_part = pytest.mark.parametrize("part", PARTS)


@every_part
def test_a_program_is_linted_assembled_listed_and_run(part, call, write):
    program = write(f"p.{part}", *PROGRAMS.get(part, PACKETS))
    assert call("lint", program, "--strict").out == f"{program}: no problems found\n"
    write("p.hex", call("asm", program, "--format", "hex").out)
    listed = call("dis", "p.hex", "--chip", part).out
    again = write(f"again.{part}", *(line for line in listed.splitlines() if line))
    assert call("asm", again, "--format", "hex").out == call("asm", program, "--format", "hex").out
    ran = call("run", program, "--json", "-").json
    assert (ran["chip"], ran["position"], ran["findings"]) == (part, 30, [])


@every_part
def test_it_is_described_and_its_ramp_reckoned(part, call):
    assert call("describe", part).out.startswith(f"# {sheet_of(part).title}\n")
    row = next(iter(sheet_of(part).commands))
    assert row.name in call("describe", part, row.head).out
    given = RAMPS.get(part, "SET_VEL=265107 SET_ACC=2000")
    shown = call("ramp", part, *given.split()).out
    assert shown.startswith(part) and " steps/s" in shown
