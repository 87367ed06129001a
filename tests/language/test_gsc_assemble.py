"""Program text of the GS-C modules: assembled, sent, taken apart again, and refused with places."""

from __future__ import annotations

from pathlib import Path

import pytest

from slewline.chips import sheet_of
from slewline.errors import ProgramError, UsageError
from slewline.language.assemble import assemble, to_ascii, to_binary
from slewline.language.disassemble import disassemble, instructions, listing
from slewline.language.lines import spell
from tests.rows import rows

EXAMPLES = Path(__file__).parents[2] / "examples"
C200, C200S = sheet_of("gs-c200"), sheet_of("gs-c200s")
ENTER = {C200: "P", C200S: "Po"}
both = pytest.mark.parametrize("sheet", [C200, C200S], ids=lambda sheet: sheet.part)
every_row = rows(("sheet", "row"), [(sheet, row) for sheet in (C200, C200S) for row in sheet.commands if row.stored])


def problems(text, sheet=C200S):
    with pytest.raises(ProgramError) as caught:
        assemble(text, sheet)
    return [(problem.line, problem.column, problem.length, problem.code) for problem in caught.value.problems]


# ----------------------------------------------------------------------------------------------------------- assembling
@every_row
@rows("pick", ["low", "high"])
def test_every_stored_row_at_its_bounds_and_back(sheet, row, pick):
    values = tuple(getattr(arg, pick) for arg in row.args)
    stored = assemble(spell(row, values), sheet).stored
    assert (stored, len(stored)) == (row.pack(values), row.size)
    assert [(i.row, i.values) for i in instructions(stored, sheet)] == [(row, values)]
    assert assemble(disassemble(stored, sheet), sheet).stored == stored


@every_row
def test_every_stored_row_beyond_its_bounds(sheet, row):
    for place, arg in enumerate(row.args):
        if arg.sign == "alone":
            continue
        for number in {arg.low - 1, arg.high + 1} - ({-1, 0} if row.name == "LOOP" else {-1}):  # L0 is another row
            values = [number if at == place else other.low for at, other in enumerate(row.args)]
            text = spell(row, values)
            written = arg.spell(number)
            assert problems(text, sheet) == [(1, text.rindex(written) + 1, len(written), "range")]


@both
def test_a_session_is_taken_apart(sheet):
    found = assemble(f"F\nI3\n{ENTER[sheet]}\nS10\nV1\nT100 ; fast\n\n  R40\n+250\nE\nF", sheet)
    assert found.listing().splitlines() == [
        "000  53 0A 00 00  S10",
        "004  54 64 00 00  T100",
        "008  52 28 00 00  R40",
        "012  2B FA 00 00  +250",
    ]
    assert [(line.address, line.number) for line in found.lines] == [(0, 4), (4, 6), (8, 8), (12, 9)]
    assert found.preset == ("F", "I3", "V1", "F")


@both
def test_lines_around_a_program_may_be_left_out(sheet):
    whole = assemble(f"{ENTER[sheet]}\nS10\nA1\nE", sheet).stored
    assert assemble("S10\nA1", sheet).stored == assemble("S10\nA1\nE", sheet).stored == whole


@both
@pytest.mark.parametrize(("name", "locations"), [("bar", 50), ("drill", 36), ("drill_loop", 40)])
def test_the_printed_programs_take_the_locations_given_in_the_data_sheet(sheet, name, locations):
    text = (EXAMPLES / "drill" / f"{name}.gs-c200").read_text().replace("P\n", f"{ENTER[sheet]}\n")
    assert len(assemble(text, sheet).stored) == locations


def test_jumps_land_where_the_instructions_lie():
    found = assemble((EXAMPLES / "programs" / "segments.gs-c200s").read_text(), C200S)
    assert [line.address for line in found.lines] == [0, 4, 8, 12, 14, 16, 18, 22, 24, 28]
    assert found.stored[12:18] == bytes.fromhex("81 12 82 18 6A 0C")
    assert len(found.stored) == 30


def test_signs_and_widths_of_numbers():
    assert assemble("f-8388608", C200S).stored == bytes.fromhex("66 00 00 80")
    assert assemble("-999999", C200).stored == b"+" + (-999999).to_bytes(3, "little", signed=True)
    assert assemble("G9999999", C200).stored == b"G" + (9999999).to_bytes(3, "little")
    assert assemble("G+2", C200).stored != assemble("G+2", C200S).stored == bytes.fromhex("47 02 00 00")


# -------------------------------------------------------------------------------------------------------------- streams
def test_the_lines_of_a_host_with_and_without_checksums():
    found = assemble("Po\nS10\nT9\nL4\n-800\nE", C200S)
    assert to_ascii(found) == b"Po\rS10\rT9\rL4\r-800\rE\r"
    assert to_ascii(found, check=True) == b"Po?\rS104\rT9\x1d\rL4\x10\r-800U\rEU\r"


@rows(
    ("sheet", "text", "sent"),
    [
        (C200S, "A1", b"Po\rA1\rPx\r"),
        (C200S, "Po\nA1\nPx", b"Po\rA1\rPx\r"),
        (C200S, "Po\nA1\nE", b"Po\rA1\rE\r"),
        (C200, "A1", b"P\rA1\rE\r"),
    ],
)
def test_program_entry_ends_as_written_or_else_without_a_run_where_the_part_can(sheet, text, sent):
    assert to_ascii(assemble(text, sheet)) == sent


def test_there_is_no_binary_form():
    with pytest.raises(UsageError, match="GS-C200 has no binary commands"):
        to_binary(assemble("A1", C200))


def test_unknown_instructions_are_shown_as_bytes():
    assert listing(b"\x00A\x01S\x0a", C200).splitlines() == [
        "000  00           ??? 00",
        "001  41 01        A1",
        "003  53 0A        ??? 53 0A",
    ]


# ------------------------------------------------------------------------------------------------------------- mistakes
@rows(
    ("text", "found"),
    [
        ("s10", [(1, 1, 3, "unknown-command")]),
        ("A1\n  N 5", [(2, 3, 3, "unknown-command")]),
        ("S 10", [(1, 1, 4, "bad-argument")]),
        ("A", [(1, 1, 1, "bad-argument")]),
        ("g1", [(1, 1, 2, "bad-argument")]),
        ("jc8,0", [(1, 3, 1, "range")]),
        ("jc7,119", [(1, 5, 3, "range")]),
        ("\t+0", [(1, 2, 2, "range")]),
        ("+00000000001", [(1, 1, 12, "too-long")]),
        ("A1\nH+", [(2, 1, 2, "not-now")]),
        ("A1\nK", [(2, 1, 1, "not-now")]),
        ("A1\nPo\nC1\nE", [(1, 1, 2, "not-now")]),
        ("Po\nA1\nE\nD5\nF", [(4, 1, 2, "not-now")]),
        ("Po\nA1\nE\nPo\nC1\nPx", [(4, 1, 2, "second-program")]),
        ("A1\n" * 59 + "C1", [(60, 1, 2, "overflow")]),
        ("+1\n" * 29 + "A1\nA2\nA3", [(31, 1, 2, "overflow")]),
    ],
)
def test_mistakes_have_places(text, found):
    assert problems(text) == found


def test_the_memory_may_be_filled_to_the_last_location_but_one():
    assert len(assemble("A1\n" * 59, C200S).stored) == 118


@rows(
    ("sheet", "text", "remedy"),
    [
        (C200S, "s10", "write S10: no spaces, and case matters"),
        (C200S, "S 10", "write S10: no spaces, and case matters"),
        (C200, "g+1", "write G+1: no spaces, and case matters"),
        (C200S, "P", "with this letter it has Po, Px"),
        (C200, "Po", "with this letter it has P"),
        (C200, "j12", "a sister part has this command"),
        (C200, "f+5", "a sister part has this command"),
        (C200S, "A1\nZ", "end program entry first, with E or Px"),
        (C200S, "Po\nE\nD1", "begin program entry with Po"),
        (C200, "A1\nI1", "end program entry first, with E"),
    ],
)
def test_remedies(sheet, text, remedy):
    with pytest.raises(ProgramError) as caught:
        assemble(text, sheet)
    assert str(caught.value).splitlines()[3].strip() == remedy


def test_a_message_has_place_limits_source_and_picture():
    with pytest.raises(ProgramError) as caught:
        assemble("Po\nS10\n  T1001 ; too fast\nE", C200S, "x.gs-c200s")
    assert str(caught.value).splitlines() == [
        "x.gs-c200s, line 3, column 4: TOP_SPEED 1001: allowed 1..1000 (GS-C200S manual, command descriptions)",
        "      T1001 ; too fast",
        "       ^^^^",
        "    the nearest is 1000",
    ]


@rows("line", ["S10\u2193", "+250\u2193", "\u2193", "A1 \u2193"])
def test_the_return_sign_of_the_data_sheet_is_to_be_left_out(line):
    with pytest.raises(ProgramError) as caught:
        assemble(f"Po\n{line}\nPx", C200S)
    (problem,) = caught.value.problems
    assert problem.remedy == "the data sheet prints \u2193 for the return key: leave it out"
