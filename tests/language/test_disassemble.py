"""The disassembler: bytes to text, and back to the same bytes."""

from hypothesis import given
from hypothesis import strategies as st

from slewline.chips.cy525.sheet import SHEET
from slewline.language.assemble import assemble
from slewline.language.disassemble import disassemble, instructions, listing
from tests.rows import rows

ROWS = [row for row in SHEET.commands if row.stored]
WELD = bytes.fromhex("57 2B 4E 64 00 42 44 F4 01 43 47 4C 06 05 50 00 00 54 00 00")


def codes(text):
    """The text without its comments."""
    return [line.split(";")[0].rstrip() for line in text.splitlines()]


def inner(text):
    """The same of the program alone."""
    return codes(text)[1:-1]


def test_numbers():
    text = disassemble(WELD, SHEET)
    assert codes(text) == ["E", "W", "+", "N 100", "B", "D 500", "C", "G", "L 6,5", "P 0", "T 0", "0", "Q"]
    assert text.splitlines()[3] == "N 100           ; 02  4E 64 00"
    assert text.endswith("Q\n")


def test_labels():
    text = disassemble(WELD, SHEET, labels=True)
    assert codes(text) == ["E", "A$W", "+", "N 100", "B$B", "D 500", "C", "G", "L 6,B", "P 0", "T A", "0", "Q"]


def test_new_labels_leave_kept_letters_alone():
    assert inner(disassemble(b"BJ\0JAJB", SHEET, labels=True)) == ["C$B", "J C", "J A", "J B"]
    assert inner(disassemble(b"W" + b"L\6B", SHEET)) == ["W", "L 6,B"]


def test_no_more_labels_than_letters():
    stored = b"".join(b"BJ" + bytes([3 * n]) for n in range(7))
    assert inner(disassemble(stored, SHEET, labels=True))[-3:] == ["J 15", "B", "J 18"]
    assert assemble(disassemble(stored, SHEET, labels=True), SHEET, resolve=True).stored == stored


def test_target_inside_an_instruction_stays_a_number():
    assert inner(disassemble(b"R\x42J\1", SHEET, labels=True)) == ["R 66", "J 1"]


@rows(
    ("stored", "text"),
    [
        (b"K", ["??? 4B"]),
        (b"\x30\0", ["??? 30", "0"]),
        (b"QB", ["??? 51", "B"]),
        (b"BN\5", ["B", "??? 4E 05"]),
        (b"L", ["??? 4C"]),
        (b"R\xff", ["R 255"]),
        (b"J\xff", ["J 255"]),
        (b"", []),
    ],
)
def test_bytes_that_belong_to_no_program(stored, text):
    assert inner(disassemble(stored, SHEET)) == text


def test_listing():
    lines = listing(b"BN\x2c\1JAK", SHEET).splitlines()
    assert lines == ["00  42        B", "01  4E 2C 01  N 300", "04  4A 41     J A", "06  4B        ??? 4B"]
    assert listing(b"", SHEET) == ""
    assert listing(b"J\1", SHEET) == "00  4A 01     J 1"


def test_addresses():
    assert [(i.address, i.data, i.values) for i in instructions(b"N\x2c\1K\0L\3", SHEET)] == [
        (0, b"N\x2c\1", (300,)),
        (3, b"K", ()),
        (4, b"\0", ()),
        (5, b"L\3", ()),
    ]


@st.composite
def programs(draw):
    stored = b""
    for row in draw(st.lists(st.sampled_from(ROWS), max_size=20)):
        stored += row.pack([draw(st.integers(arg.low, arg.high)) for arg in row.args])
    return stored


@given(programs(), st.booleans())
def test_there_and_back(stored, labels):
    text = disassemble(stored, SHEET, labels=labels)
    assert assemble(text, SHEET, resolve=True).stored == stored
    if not labels:
        assert assemble(text, SHEET).stored == stored


@given(st.binary(max_size=60), st.booleans())
def test_any_bytes(stored, labels):
    text = disassemble(stored, SHEET, labels=labels)
    assert "".join(line[22:] for line in text.splitlines()[1:-1]).replace(" ", "") == stored.hex().upper() or labels
    assert b"".join(instruction.data for instruction in instructions(stored, SHEET)) == stored
