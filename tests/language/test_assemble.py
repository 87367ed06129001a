"""The assembler: text to bytes and streams, and every mistake with its place."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slewline.chips.cy525.sheet import SHEET
from slewline.errors import ProgramError
from slewline.language.assemble import assemble, to_ascii, to_binary
from slewline.language.dialect import Command, dialect_of
from slewline.language.source import host_lines, read
from slewline.language.text import spell
from tests.rows import rows

ROWS = [row for row in SHEET.commands if row.stored]


def problems(text):
    with pytest.raises(ProgramError) as caught:
        assemble(text, SHEET)
    return [(problem.line, problem.column, problem.length, problem.code) for problem in caught.value.problems]


@rows("row", ROWS)
def test_every_row_at_its_bounds(row):
    for pick in ("low", "high"):
        values = [getattr(arg, pick) for arg in row.args]
        assert assemble(f"E\n{spell(row, values)}\nQ\n", SHEET).stored == row.pack(values)


@rows("row", [row for row in ROWS if row.args])
def test_every_row_beyond_its_bounds(row):
    for place, arg in enumerate(row.args):
        for number in {arg.low - 1, arg.high + 1} - {-1}:
            values = [number if at == place else other.low for at, other in enumerate(row.args)]
            text = spell(row, values)
            assert problems(text) == [(1, text.index(str(number), 2) + 1, len(str(number)), "range")]


@rows(
    ("text", "found"),
    [
        ("R 200", [(1, 3, 3, "range")]),
        ("  R 128  ; fast", [(1, 5, 3, "range")]),
        ("\tR 128", [(1, 4, 3, "range")]),
        ("N 70000", [(1, 3, 5, "range")]),
        ("J 60", [(1, 3, 2, "range")]),
        ("L 0,60", [(1, 3, 1, "range"), (1, 5, 2, "range")]),
        ("K 5", [(1, 1, 1, "unknown-command")]),
        ("r 5", [(1, 1, 1, "unknown-command")]),
        ("R", [(1, 2, 1, "missing-argument")]),
        ("L 3", [(1, 4, 1, "missing-argument")]),
        ("L 3,", [(1, 5, 1, "missing-argument")]),
        ("B 5", [(1, 3, 1, "extra-argument")]),
        ("R 5 6", [(1, 5, 1, "extra-argument")]),
        ("L 3,0 0", [(1, 7, 1, "extra-argument")]),
        ("R -1", [(1, 3, 2, "bad-number")]),
        ("R x", [(1, 3, 1, "bad-number")]),
        ("R ²", [(1, 3, 1, "bad-number")]),
        ("J F", [(1, 3, 1, "bad-number")]),
        ("A A", [(1, 3, 1, "bad-number")]),
        ("L 3,,0", [(1, 2, 5, "bad-number")]),
        ("B\nJ A", [(2, 3, 1, "missing-label")]),
        ("L 3,E", [(1, 5, 1, "missing-label")]),
        ("A$B\nC\nA$0", [(3, 1, 3, "label-twice")]),
        ("F$B", [(1, 1, 2, "bad-label")]),
        ("B\nA$", [(2, 1, 2, "bad-label")]),
        ("E\nB\nA$Q", [(3, 1, 3, "bad-label")]),
        ("E\nB\nA$\nQ", [(4, 1, 1, "bad-label")]),
        ("A$ B", [(1, 1, 2, "bad-label")]),
        ("A$K", [(1, 3, 1, "unknown-command")]),
        ("E\nB\nQ 1", [(3, 3, 1, "extra-argument")]),
        ("E\nB\nQE\nC\nQ", [(3, 2, 1, "second-program")]),
        ("N 1\n" * 20 + "A$B\n", [(21, 1, 3, "overflow")]),
        ("B\n" * 59 + "R 5\nB", [(60, 1, 3, "overflow")]),
        ("R " + "1" * 5000, [(1, 1, 5002, "too-long")]),
        ("A$" * 5000, [(1, 1, 10000, "too-long")]),
        ("E\nQQ Q", [(2, 4, 1, "extra-argument")]),
        ("J C\nR 200", [(1, 3, 1, "missing-label"), (2, 3, 3, "range")]),
        ("R 200\nb\n\nJ C\n", [(1, 3, 3, "range"), (2, 1, 1, "unknown-command"), (4, 3, 1, "missing-label")]),
    ],
)
def test_mistakes_have_places(text, found):
    assert problems(text) == found


def test_message():
    with pytest.raises(ProgramError) as caught:
        assemble("E\nB\nR 200\nQ\n", SHEET, "weld.cy525")
    assert str(caught.value).splitlines() == [
        "weld.cy525, line 3, column 3: RATE 200: allowed 0..127 (CY525 manual, T.V)",
        "    R 200",
        "      ^^^",
        "    the nearest is 127",
    ]


@rows(
    ("line", "says", "remedy"),
    [
        ("A", "ABSOLUTE without position: allowed 0..65535", "in the CY512 A took no number: write A 0"),
        (
            "D",
            "DELAY without delay: allowed 1..65535",
            "in the CY512 D ran the program: here X does, and D is the delay",
        ),
        ("X 5", "5 after EXECUTE, which takes no argument", "leave out 5; in the CY512 X was the delay: here D is"),
        ("R", "RATE without rate: allowed 0..127", ""),
        ("L 3", "LOOP without target: allowed 0..59 or a label A..E", ""),
        ("D 20 ms", "ms after DELAY, which takes delay", "leave out ms"),
        ("H 5", "5 after HALTMODE, which takes no argument", "leave out 5; in the CY512 H was half step"),
        ("R 20 G", "G after RATE, which takes rate", "write G on a line of its own"),
        ("J 200", "JUMP 200", "a target is the address of an instruction of this program"),
        ("L 3,0 0", "0 after LOOP, which takes count and target", "leave out 0"),
        ("B}", "} after BITSET, which takes no argument", "the manual prints } for the return key: leave it out"),
        ("A 0}", "ABSOLUTE 0}: allowed 0..65535", "the manual prints } for the return key: leave it out"),
        ("A}", "ABSOLUTE }: allowed 0..65535", "the manual prints } for the return key: leave it out"),
        ("X}", "} after EXECUTE, which takes no argument", "the manual prints } for the return key: leave it out"),
        ("R x", "RATE x: allowed 0..127", "write decimal digits only"),
        ("A x", "ABSOLUTE x: allowed 0..65535", "write decimal digits only"),
        ("R \u00d8", "RATE \u00d8: allowed 0..127", "the manual prints \u00d8 for the digit zero: write 0"),
        ("\u00d8", "\u00d8 is not a command: ", "the manual prints \u00d8 for the digit zero: write 0"),
        ("}", "} is not a command: ", "the manual prints } for the return key: leave it out"),
        ("$A", "$ is not a command: ", "$ follows the letter of a label, as in A$"),
        ("b", "b is not a command: ", "write B: command letters are upper case"),
        ("K", "K is not a command: ", ""),
    ],
)
def test_copies_from_the_manual_or_for_a_cy512_get_a_remark(line, says, remedy):
    with pytest.raises(ProgramError) as caught:
        assemble(f"E\n{line}\nQ", SHEET)
    (problem,) = caught.value.problems
    assert problem.message.startswith(says)
    assert problem.remedy.startswith(remedy) and bool(problem.remedy) == bool(remedy)


def test_the_return_sign_after_q():
    with pytest.raises(ProgramError) as caught:
        assemble("E\n0\nQ }", SHEET)
    (problem,) = caught.value.problems
    assert problem.message.startswith("} after QUIT, which takes no argument") and "leave it out" in problem.remedy


def test_carets_stand_below_tabs():
    with pytest.raises(ProgramError) as caught:
        assemble("\tR\t200", SHEET)
    assert str(caught.value).splitlines()[1:3] == ["    \tR\t200", "    \t ^^^^"]


def test_all_mistakes_in_one_message():
    with pytest.raises(ProgramError) as caught:
        assemble("R 200\nB\nK\n", SHEET)
    assert [part.splitlines()[0][:14] for part in str(caught.value).split("\n\n")] == [
        "<text>, line 1",
        "<text>, line 3",
    ]


def test_longest_line():
    assert assemble("R " + "0" * 253 + "7", SHEET).stored == b"R\7"
    assert problems("R " + "0" * 254 + "7") == [(1, 1, 257, "too-long")]


def test_full_buffer():
    assert len(assemble("B\n" * 59 + "0", SHEET).stored) == 60


# ------------------------------------------------------------------------------------------------------------- layout


def test_lines_and_labels():
    assembly = assemble("; two places\nE\nN 5 ; steps\n@wait 5 ms\n  B$G\nL 3,B\nJ A\nA$0\nQ\n", SHEET)
    assert list(assembly.lines) == [(0, 3, "N 5"), (3, 5, "B$G"), (4, 6, "L 3,B"), (7, 7, "J A"), (9, 8, "A$0")]
    assert assembly.labels == {"B": 3, "A": 9}
    assert assembly.stored == b"N\5\0GL\3BJA\0"


@pytest.mark.fact("LABEL-6")
def test_labels_before_and_after():
    text = "E\nJ B\nA$C\nB$B\nT A\n0\nQ"
    assert assemble(text, SHEET).stored == b"JBCBTA\0"
    assert assemble(text, SHEET, resolve=True).stored == b"J\3CBT\2\0"


@pytest.mark.fact("LABEL-7")
def test_a_letter_is_a_label_with_its_mark_only():
    assert assemble("E\nC$C\nC\nQ", SHEET).stored == b"CC"
    assert assemble("E\nA$A 5\nQ", SHEET).stored == b"A\5\0"


def test_two_labels_for_one_instruction():
    assembly = assemble("A$B$C\nJ A\nJ B", SHEET, resolve=True)
    assert (assembly.stored, assembly.labels) == (b"CJ\0J\0", {"A": 0, "B": 0})
    assert to_ascii(assembly) == b"E\rA$B$C\rJ A\rJ B\rQ"


@pytest.mark.parametrize("text", ["B\nA$\nC\nJ A", "B\nA$\n@wait 1 s\n\n; here\n  C\nJ A"])
def test_label_on_the_line_above(text):
    assembly = assemble(text, SHEET)
    assert (assembly.stored, assembly.labels) == (b"BCJA", {"A": 1})
    assert to_ascii(assembly) == b"E\rB\rA$C\rJ A\rQ"


def test_labels_of_two_lines():
    assembly = assemble("A$B$\n C$G\nJ B", SHEET)
    assert assembly.labels == {"A": 0, "B": 0, "C": 0}
    assert (assembly.statements[0].column, assembly.statements[0].text) == (2, "C$G")


@rows(
    ("text", "stored", "preset"),
    [
        ("B\n0", b"B\0", ()),
        ("", b"", ()),
        ("E\nQ", b"", ()),
        ("R 5\nE\nB\nQ\nX", b"B", ("R 5", "X")),
        ("E\nB\nQS 20\nX", b"B", ("S 20", "X")),
        ("B\nQX", b"B", ("X",)),
        ("R 5\nE\nB\nE\n0", b"BE\0", ("R 5",)),
    ],
)
def test_entry_may_be_written_or_not(text, stored, preset):
    assembly = assemble(text, SHEET)
    assert (assembly.stored, assembly.preset) == (stored, preset)


def test_odd_lines_are_not_mistakes():
    assembly = assemble("R100\nL 3, 0\nL 3 0\nR  5\nR 6", SHEET)
    assert assembly.stored == b"R\x64L\3\0L\3\0R\5R\6"
    assert [(problem.line, problem.code) for problem in assembly.findings] == [
        (1, "spacing"),
        (2, "spacing"),
        (4, "spacing"),
    ]


def test_listing():
    assert assemble("A$N 300\nJ A", SHEET).listing().splitlines() == ["00  4E 2C 01  A$N 300", "03  4A 41     J A"]


def test_streams():
    assembly = assemble("A$N 300\nL 6,A\n0", SHEET)
    assert to_ascii(assembly) == b"E\rA$N 300\rL 6,A\r0\rQ"
    assert to_binary(assembly) == b"E\0N\2\x2c\1L\2\6\0000\0Q"
    assert to_binary(assembly, single_count=True) == b"E\0N\6\x2c\1L\6\0\0Q"


def test_streams_of_little():
    assert to_binary(assemble("", SHEET), single_count=True) == b"E\0Q"
    assert to_binary(assemble("0", SHEET), single_count=True) == b"E\x000\0Q"
    assert to_ascii(assemble("", SHEET)) == b"E\rQ"


def test_values_fit_even_if_they_are_wrong():
    assert [s.values for s in read("N 70000\nR 300\nJ E", SHEET).statements] == [(4464,), (44,), (69,)]


def test_host_lines():
    text = "; only\n\n  R 5 ; rate\n@wait 3 ms ; here\nA$B\n"
    assert host_lines(text) == [(3, 3, "R 5"), (4, 1, "@wait 3 ms"), (5, 1, "A$B")]


# ---------------------------------------------------------------------------------------------------------- properties


@st.composite
def program_texts(draw):
    """Programs with labels that fit into the buffer."""
    rows = draw(st.lists(st.sampled_from(ROWS), min_size=1, max_size=20))
    marks = dict(draw(st.lists(st.tuples(st.sampled_from("ABCDE"), st.integers(0, len(rows) - 1)), max_size=5)))
    lines = []
    for at, row in enumerate(rows):
        shown = [
            draw(st.sampled_from(sorted(marks)))
            if arg.label and marks and draw(st.booleans())
            else draw(st.integers(arg.low, arg.high))
            for arg in row.args
        ]
        lines.append("".join(f"{letter}$" for letter, place in marks.items() if place == at) + spell(row, shown))
    return "\n".join(["E", *lines, "Q"])


@given(program_texts())
def test_size_and_places(text):
    assembly = assemble(text, SHEET)
    assert [line.address for line in assembly.lines] == [s.address for s in assembly.statements]
    assert b"".join(s.row.pack(s.values) for s in assembly.statements) == assembly.stored
    ends = [s.end for s in assembly.statements]
    assert ends[-1] == len(assembly.stored)
    assert [s.address for s in assembly.statements[1:]] == ends[:-1]


@given(program_texts())
def test_streams_assemble_again(text):
    assembly = assemble(text, SHEET)
    stream = to_ascii(assembly).decode().replace("\r", "\n")
    assert assemble(stream, SHEET).stored == assembly.stored


@given(program_texts())
def test_the_decoder_stores_the_same(text):
    assembly = assemble(text, SHEET)
    resolved = assemble(text, SHEET, resolve=True).stored
    streams = [
        (True, to_ascii(assembly)),
        (False, to_binary(assembly)),
        (False, to_binary(assembly, single_count=True)),
    ]
    for ascii, stream in streams:
        decoder = dialect_of(SHEET).decoder(SHEET)
        items = [decoder.feed(byte, ascii, at >= 2) for at, byte in enumerate(stream)]
        stored = b"".join(item.stored for item in items[2:] if isinstance(item, Command))
        assert stored == (assembly.stored if ascii else resolved)
        assert decoder.at_letter


@given(st.text(max_size=60))
def test_any_text_assembles_or_is_refused(text):
    try:
        assembly = assemble(text, SHEET)
    except ProgramError as error:
        assert error.problems
    else:
        assert len(assembly.stored) <= SHEET.buffer_bytes
