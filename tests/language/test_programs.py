"""The programs of the manual: as streams that a host sends, and as the files in examples/programs."""

from pathlib import Path

import pytest

from slewline.chips.cy525.checks import checks
from slewline.chips.cy525.sheet import SHEET
from slewline.language.assemble import assemble, to_ascii, to_binary
from slewline.language.dialect import Command, dialect_of
from slewline.language.disassemble import disassemble
from slewline.language.lint import lint
from slewline.language.source import read
from tests.rows import rows

EXAMPLES = Path(__file__).parents[2] / "examples" / "programs"

WELD = "57 2B 4E 64 00 42 44 F4 01 43 47 4C 06 43 50 00 00 54 42 00"
HANDOFF = (
    "55 50 00 00 2B 43 44 5A 00 50 0E 00 44 5A 00 50 6C 00 2D 50 7A 00 42 44 5A 00 50 6C 00 44 5A 00 "
    "52 14 50 00 00 50 0E 00 52 78 54 00 00"
)
PROGRAMS = {  # name: (what the host sends, with | for a carriage return; the program buffer)
    "three_routes": ("E|R 127|N 300|+|G|N 750|-|G|0|Q", "52 7F 4E 2C 01 2B 47 4E EE 02 2D 47 00"),
    "pulse": ("E|B|C|0|QX|", "42 43 00"),
    "conditional_loop": (
        "R 80|E|C$N 5|+|G|-|N 5|G|T C|B|R 60|X|QX|",
        "4E 05 00 2B 47 2D 4E 05 00 47 54 43 42 52 3C 58",
    ),
    "jump": (
        "E|C|R 127|P 0|+|N 75|R 101|A$B|W|C|G|J A|QS 20|F 3|X|",
        "43 52 7F 50 00 00 2B 4E 4B 00 52 65 42 57 43 47 4A 41",
    ),
    "labels": ("E|A$P 40|C|P 0|B|J A|Q", "50 28 00 43 50 00 00 42 4A 41"),
    "weld": ("E|B$W|+|N 100|C$B|D 500|C|G|L 6,C|P 0|T B|0|Q", WELD),
    "handoff": (
        "A 0|R 120|S 25|F 5|P 14|E|U|P 0|+|C|D 90|P 14|D 90|P 108|-|P 122|B|D 90|P 108|D 90|"
        "R 20|P 0|P 14|R 120|T 0|0|QX|",
        HANDOFF,
    ),
    "two_groups": (
        "R 80|F 10|N 1|C|E|B|G|D 500|L 3,1|C|U|B|G|D 330|L 3,11|C|T 0|0|QX|",
        "42 47 44 F4 01 4C 03 01 43 55 42 47 44 4A 01 4C 03 0B 43 54 00 00",
    ),
    "four_steps": ("R 80|S 255|F 10|N 4|G|", ""),
    "to_and_fro": ("C|R 90|S 200|F 10|N 3|E|B|+|G|C|-|G|T 0|B|C|0|QX|", "42 2B 47 43 2D 47 54 00 42 43 00"),
    "five_steps": ("C|B|R 100|S 254|F 3|N 5|G|", ""),
    "continuous": ("N 1000|G|H|G|G|", ""),
    "continuous_start": ("N 65000|Z 1|S 200|F 3|R 80|H|G|", ""),
    "directions": ("P 2|P 0|+|G|-|G|", ""),
    "panel": ("F 3|R 10|S 1|Z 1|N 1|A 0|E|C|P 1250|B|P 0|J 0|QX|", "43 50 E2 04 42 50 00 00 4A 00"),
}
BINARY = {
    "five_steps": "43 00 42 00 52 01 64 53 01 FE 46 01 03 4E 02 05 00 47 00",
    "oscilloscope": "43 00 52 01 64 53 01 FF 46 01 03 4E 02 05 00 2B 00 47 00",
}
STORED = {name: bytes.fromhex(buffer) for name, (_, buffer) in PROGRAMS.items() if buffer}


def text_of(name, suffix=".cy525"):
    return (EXAMPLES / (name + suffix)).read_text()


def entered(stream, ascii=True):
    """What a chip keeps of a stream: the program, the other commands, what it has to complain about."""
    decoder, entering, buffer, direct = dialect_of(SHEET).decoder(SHEET), False, b"", []
    for byte in stream:
        item = decoder.feed(byte, ascii, entering)
        if isinstance(item, Command):
            if item.row.name in ("ENTER", "QUIT"):
                entering = item.row.name == "ENTER"
            elif entering:
                buffer += item.stored
            else:
                direct.append((item.row.form, item.values))
    return buffer, direct, decoder.take_notes()


def sent(text):
    """The stream that a host sends for a text."""
    return "".join(s.text + ("|" if s.row.terminated else "") for s in read(text, SHEET).statements)


def test_every_example_is_listed():
    assert {path.stem for path in EXAMPLES.glob("*.cy525")} == set(PROGRAMS)
    assert {path.stem for path in EXAMPLES.glob("*.hex")} == set(BINARY)


@rows("name", PROGRAMS)
def test_the_file_sends_the_program_printed_in_the_manual(name):
    stream, _ = PROGRAMS[name]
    kept = sent(text_of(name))
    if name == "continuous":
        kept = kept.removeprefix("F 3|R 10|S 255|Z 1|")
    assert stream in kept


@rows("name", PROGRAMS)
def test_the_stream_leaves_the_buffer(name):
    stream, buffer = PROGRAMS[name]
    assert entered(stream.replace("|", "\r").encode())[::2] == (bytes.fromhex(buffer), [])


@pytest.mark.fact("PROG-2", "LABEL-2")
@rows("name", STORED)
def test_the_file_assembles_to_the_buffer(name):
    assert assemble(text_of(name), SHEET).stored == STORED[name]


@rows("name", STORED)
def test_every_route_into_the_chip(name):
    assembly = assemble(text_of(name), SHEET)
    resolved = assemble(text_of(name), SHEET, resolve=True).stored
    assert entered(to_ascii(assembly))[::2] == (STORED[name], [])
    assert entered(to_binary(assembly), ascii=False)[::2] == (resolved, [])
    assert entered(to_binary(assembly, single_count=True), ascii=False)[::2] == (resolved, [])


@rows("name", STORED)
def test_there_and_back(name):
    resolved = assemble(text_of(name), SHEET, resolve=True).stored
    assert assemble(disassemble(resolved, SHEET), SHEET).stored == resolved
    assert assemble(disassemble(resolved, SHEET, labels=True), SHEET, resolve=True).stored == resolved


@pytest.mark.parametrize(
    ("name", "after"),
    [
        ("conditional_loop", "4E 05 00 2B 47 2D 4E 05 00 47 54 00 42 52 3C 58"),
        ("jump", "43 52 7F 50 00 00 2B 4E 4B 00 52 65 42 57 43 47 4A 0C"),
        ("labels", "50 28 00 43 50 00 00 42 4A 00"),
    ],
)
def test_labels_become_addresses(name, after):
    assert assemble(text_of(name), SHEET, resolve=True).stored == bytes.fromhex(after)


@pytest.mark.fact("EXAMPLE-WELD-3")
def test_size_of_the_welding_program():
    assembly = assemble(text_of("weld"), SHEET)
    assert (len(assembly.stored), assembly.labels) == (20, {"B": 0, "C": 5})


@pytest.mark.fact("EXAMPLE-BIN")
def test_lengths_of_the_three_routes():
    assembly = assemble(text_of("three_routes"), SHEET)
    routes = to_ascii(assembly), to_binary(assembly), to_binary(assembly, single_count=True)
    assert [len(route) for route in routes] == [31, 24, 17]


@pytest.mark.parametrize("name", BINARY)
def test_binary_files(name):
    data = bytes.fromhex("".join(line.split(";")[0] for line in text_of(name, ".hex").splitlines()))
    assert data == bytes.fromhex(BINARY[name])
    assert entered(data, ascii=False)[2] == []


def test_five_steps_in_both_modes():
    stream, _ = PROGRAMS["five_steps"]
    ascii, binary = stream.replace("|", "\r").encode(), bytes.fromhex(BINARY["five_steps"])
    assert (len(ascii), len(binary)) == (26, 19)
    assert entered(ascii) == entered(binary, ascii=False)


@rows("name", PROGRAMS)
def test_examples_have_no_warnings(name):
    found = [problem for problem in lint(text_of(name), SHEET, checks(SHEET)) if problem.severity != "note"]
    assert found == []
