"""Files of bytes in hexadecimal: all readers of such a file take and refuse the same, with line and column."""

from __future__ import annotations

import re
from itertools import product
from pathlib import Path

import pytest

import slewline
from slewline.bench.scripts.program_file import program_text
from slewline.errors import SlewlineError
from tests.rows import rows

PLAYED = """
[[chip]]
name = "x"
part = "cy525"
straps = {{ ascii_binary = 0 }}
[[host]]
file = "{file}"
"""
LOADED = """
[[chip]]
name = "x"
part = "cy545b"
[[part]]
kind = "ram"
name = "m"
to = "x"
file = "{file}"
"""
IMAGE = ":0400000041300D314D", ":0100040042B9", ":00000001FF"


def text(*lines: str, end: str = "\n", mark: bytes = b"") -> bytes:
    return mark + "".join(line + end for line in lines).encode()


PAIRS = "52 01 20 ; rate 32", "", "47 00"
GOOD = {  # how the same bytes may be written
    "plain": lambda lines: text(*lines),
    "mark": lambda lines: text(*lines, mark=b"\xef\xbb\xbf"),
    "CR LF": lambda lines: text(*lines, end="\r\n"),
    "mark and CR LF": lambda lines: text(*lines, end="\r\n", mark=b"\xef\xbb\xbf"),
    "CR": lambda lines: text(*lines, end="\r"),
    "blank lines": lambda lines: text("", "  ", *(each for line in lines for each in (line, "", "\t"))),
    "blanks": lambda lines: text(*(f"  {line}  " for line in lines)),
    "no end": lambda lines: text(*lines).rstrip(),
    "small letters": lambda lines: text(*(line.lower() for line in lines)),
}
BAD_PAIRS = {  # what a program is refused for
    "a wrong digit": (text("52 01 20", "47 0G"), "line 2, column 4: '47 0G': bytes are pairs of hexadecimal digits"),
    "after a mark": (text("47 0G", mark=b"\xef\xbb\xbf"), "line 1, column 4: "),
    "after CR": (text("52 01 20", "47 0G", end="\r"), "line 2, column 4: "),
    "an odd digit": (text("52 01 2"), "line 1, column 7: "),
    "an indented odd digit": (text("52 01", "   2 47"), "line 2, column 4: "),
    "empty": (b"", "is empty"),
    "blank": (b"\xef\xbb\xbf\r\n \n", "is empty"),
    "comments alone": (text("; nothing"), "has no bytes"),
    "binary": (b"52 01\n\x00\xff\x10", "line 2, column 1: byte 00; allowed: text"),
    "binary from the first byte": (b"\xff\x52", "line 1, column 1: byte FF; allowed: text"),
}
BAD_IMAGES = {
    "a wrong digit": (text(IMAGE[0], ":01000400G2B9", IMAGE[2]), "line 2: ':01000400G2B9' is not a record"),
    "an odd digit": (text(IMAGE[0][:-1], *IMAGE[1:]), "line 1: "),
    "a bad checksum": (text(IMAGE[0], ":0100040042BA", IMAGE[2], mark=b"\xef\xbb\xbf"), "line 2: checksum BA"),
    "a bad checksum after CR": (text(IMAGE[0], ":0100040042BA", IMAGE[2], end="\r"), "line 2: checksum BA"),
    "truncated": (text(*IMAGE[:2]), "no end record"),
    "empty": BAD_PAIRS["empty"],
    "blank": BAD_PAIRS["blank"],
    "binary": (b":01\x00\xff", "line 1, column 4: byte 00; allowed: text"),
}


def by_command(call, *command: str):
    """A reader on the command line: status, and what is printed with the name of the file left out."""

    def read(name: str) -> tuple[bool, str]:
        called = call(*(word.format(file=name) for word in command))
        assert called.status in (0, 2), (command, called)
        return called.status == 0, (called.out or called.err).replace(name, "FILE")

    return read


def by_call(function):
    """A reader in Python."""

    def read(name: str) -> tuple[bool, str]:
        try:
            return True, repr(function(name)).replace(name, "FILE")
        except SlewlineError as error:
            return False, str(error).replace(name, "FILE")

    return read


def by_bench(write, table: str, look):
    def read(name: str):
        path = write("b.toml", table.format(file=name))
        return by_call(lambda _: look(slewline.load(path)))(name)

    return read


def played(bench) -> list[int]:
    bench.run("50 ms")
    return [bench.chips["x"].registers["rate"], bench.chips["x"].position]


def programs(call, write):
    return {
        "dis": by_command(call, "dis", "--chip", "cy525", "{file}"),
        "dis --stream": by_command(call, "dis", "--chip", "cy525", "--stream", "{file}"),
        "run": by_command(call, "run", "--chip", "cy525", "{file}"),
        "lint": by_command(call, "lint", "--chip", "cy525", "{file}"),
        "a bench": by_bench(write, PLAYED, played),
        "the panel's and the debugger's text": by_call(program_text),
    }


def images(call, write):
    empty = write("x.cy545b", "Y 0")
    return {
        "dis": by_command(call, "dis", "--chip", "cy545b", "{file}"),
        "run --memory": by_command(call, "run", empty, "--memory", "{file}"),
        "read_image": by_call(slewline.read_image),
        "a bench": by_bench(write, LOADED, lambda bench: bytes(bench.parts["m"].content[:8])),
    }


@rows("ending", ["hex", "HEX", "ihx", "ihex"])
def test_a_program_is_the_same_however_it_is_written(call, write, ending: str) -> None:
    for reader, read in programs(call, write).items():
        if reader.startswith("the panel"):
            continue  # the text is what was written
        found = {}
        for form, spelled in GOOD.items():
            Path(f"a.{ending}").write_bytes(spelled(PAIRS))
            good, found[form] = read(f"a.{ending}")
            found[form] = re.sub(r"line \d+", "line", found[form])
            assert good, (reader, form, found[form])
        assert len(set(found.values())) == 1, (reader, found)


def test_an_image_is_the_same_however_it_is_written(call, write) -> None:
    for (reader, read), name in product(images(call, write).items(), ["a.hex", "a.ihx", "a.any"]):
        found = {}
        for form, spelled in GOOD.items():
            Path(name).write_bytes(spelled(IMAGE))
            good, found[form] = read(name)
            assert good, (reader, name, form, found[form])
        assert len(set(found.values())) == 1, (reader, found)


@rows(("wrong", "case"), BAD_PAIRS.items())
def test_no_reader_takes_a_damaged_program(call, write, wrong: str, case: tuple[bytes, str]) -> None:
    data, says = case
    Path("a.hex").write_bytes(data)
    for reader, read in programs(call, write).items():
        if reader.startswith("the panel") and says not in ("is empty",) and "allowed: text" not in says:
            continue  # its text is read once, the pairs when the script is made
        good, found = read("a.hex")
        assert not good and f"FILE{'' if says.startswith(('is', 'has')) else ','}" in found, (reader, found)
        assert says in found or (says == "has no bytes" and "has no commands" in found), (reader, found)


@rows(("wrong", "case"), BAD_IMAGES.items())
def test_no_reader_takes_a_damaged_image(call, write, wrong: str, case: tuple[bytes, str]) -> None:
    data, says = case
    Path("a.hex").write_bytes(data)
    for reader, read in images(call, write).items():
        good, found = read("a.hex")
        assert not good and says in found, (reader, found)


def test_pairs_are_not_an_image_and_an_image_is_not_a_program(call, write) -> None:
    Path("pairs.hex").write_bytes(text(*PAIRS))
    Path("image.hex").write_bytes(text(*IMAGE))
    for reader, read in images(call, write).items():
        good, found = read("pairs.hex")
        assert good if reader == "dis" else not good and "line 1: '52 01 20 ; rate 32' is not a record" in found, (
            reader,
            found,
        )
    for reader, read in programs(call, write).items():
        good, found = read("image.hex")
        assert good if reader.startswith("dis") else not good and "image of a memory in Intel HEX" in found, found


@pytest.mark.parametrize("command", [("asm",), ("push", "/dev/null")])
def test_commands_that_need_a_text_refuse_bytes(call, command: tuple[str, ...]) -> None:
    Path("a.hex").write_bytes(text(*PAIRS))
    called = call(*command, "--chip", "gs-c200s", "a.hex")
    assert called.status == 2
    assert "a.hex contains program bytes, judging by its extension; slewline dis a.hex" in called.err


def test_a_file_of_another_name_is_judged_by_its_content(call) -> None:
    """A dump whose bytes happen to be no digits is a dump; digits with comments and CR are digits."""
    for name, data, shows in (
        ("a.bin", bytes([0x52, 0x20, 0x47]), "R 32"),
        ("a.any", b"52 20 ; rate\r47 ; go\r", "R 32"),
    ):
        Path(name).write_bytes(data)
        called = call("dis", "--chip", "cy525", name)
        assert called.status == 0 and shows in called.out and "G" in called.out, called
    Path("digits.hex").write_text("52 3G 00\n")  # --format overrides the name
    assert call("dis", "--chip", "cy525", "--format", "bin", "digits.hex").status == 0
