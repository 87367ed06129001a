"""Write the tables of the part in C from the data sheet in Python: python tools/part_tables.py [--check].

Commands, ranges, times, rates, addresses, pins and answers of a GS-C200 and GS-C200S are defined once, in
src/slewline/chips/gs_c200/sheet.py.  Their handling by the part is in firmware/part/gs_c200, written by hand.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "src"))

from slewline.chips.gs_c200 import sheet  # noqa: E402  # of this checkout
from slewline.chips.gs_c200.eeprom import INVALID, LOOK_PS  # noqa: E402
from slewline.core.datasheet.command_rows import LineRow  # noqa: E402
from slewline.core.datasheet.table import Arg, Sheet  # noqa: E402
from slewline.core.wires.serial import CharacterFormat, bit_clock  # noqa: E402
from slewline.language.lines import KEPT  # noqa: E402

FOLDER = ROOT / "firmware" / "part" / "gs_c200"
SAYS = "Written by tools/part_tables.py from src/slewline/chips/gs_c200/sheet.py: change it there."
SIGNS = {  # sign, whether 0 is in the range, whether it is optional
    ("no", True, False): "UNSIGNED",
    ("may", True, False): "SIGNED",
    ("must", True, False): "WITH_SIGN",
    ("must", False, False): "WITH_SIGN_BUT_0",
    ("alone", True, False): "SIGN_ALONE",
    ("alone", True, True): "SIGN_IF_ANY",
}
STATES = {"i": "IDLE", "p": "ENTERING", "r": "RUNNING"}
OUTPUTS = ("rdy", "mov", "ramp", "dir", "reset", "uo1", "uo2", "uo3")  # in the order of gsc200.h
PARTS = (("C200", sheet.GS_C200), ("C200S", sheet.GS_C200S))


def main(args: list[str]) -> int:
    """Write the files; with --check, report outdated ones, and return 1 if there are any."""
    old = [path for path, text in files().items() if not path.exists() or path.read_text("ascii") != text]
    if args == ["--check"]:
        for path in old:
            print(f"{path.relative_to(ROOT)} is not up to date: run python tools/part_tables.py")
        return int(bool(old))
    for path in old:
        path.write_text(files()[path], "ascii")
        print(path.relative_to(ROOT))
    return 0


def files() -> dict[Path, str]:
    """Return the files, by path."""
    return {FOLDER / "sheet.h": "\n".join(header()) + "\n", FOLDER / "sheet.c": "\n".join(tables()) + "\n"}


def names() -> list[str]:
    """Return the names of all commands, in the order of the sheet."""
    return list(dict.fromkeys(row.name for _, each in PARTS for row in each.rows(LineRow)))


def header() -> Iterator[str]:
    """Yield the lines of sheet.h."""
    port, times = sheet.PORT, sheet.TIMES
    yield f"/* The GS-C200/GS-C200S data sheet as tables.  {SAYS} */"
    yield from ("#ifndef SHEET_H", "#define SHEET_H", "", "#include <stdbool.h>", "#include <stdint.h>", "")
    yield "/* Times, in picoseconds, each with its meaning and its section. */"
    for name, time in times.items():
        yield f"#define {name.upper()}_PS {time.ticks}ULL /* {ascii_of(time.description)}: {time.where} */"
    yield f"#define STORE_LOOK_PS {LOOK_PS}ULL /* interval of sampling an EEPROM that is still busy */"
    yield ""
    yield f"#define RATE_UNIT {sheet.RATE_UNIT}U /* steps/s: motion characteristics */"
    yield f"#define CHECKSUM_BIT 0x{KEPT:02x}U /* always set: data exchange protocol */"
    yield f"#define INVALID_BYTE 0x{INVALID[0]:02x}U /* not an opcode: the first byte after an interrupted write */"
    for name, each in PARTS:
        positions = sheet.POSITIONS[each.part]
        yield f"#define {name}_LEAST ({positions[0]}) /* of the position counter */"
        yield f"#define {name}_MOST {positions[-1]}"
    yield ""
    yield "enum command {"
    yield from (f"    {name}," for name in names())
    yield from ("    FOREIGN /* a command of the other part */", "};", "")
    yield "/* The form of an argument: a number, with or without a sign; a sign alone, which may be optional. */"
    yield f"enum sign {{ {', '.join(SIGNS.values())} }};"
    yield ""
    yield "/* The states in which a command is executed directly. */"
    yield "enum state { " + ", ".join(f"{name} = {1 << bit}" for bit, name in enumerate(STATES.values())) + " };"
    yield from ("", *STRUCTS, "")
    for name, each in PARTS:
        yield f"#define {name}_ROWS {len(rows(each))}"
        yield f"extern const struct row {name.lower()}_rows[{name}_ROWS];"
    yield f"extern const struct rate rates[{len(port.bauds)}]; /* by BR2, BR1, BR0 as a number */"
    yield f"extern const uint8_t addresses[{len(port.addresses)}]; /* by SEL2, SEL1, SEL0 as a number */"
    yield ""
    yield "#define LEVELS_AT_RESET (" + " | ".join(at_reset()) + ") /* pin description */"
    yield from ("", "#endif")


STRUCTS = (
    "struct arg {",
    "    int32_t low, high;",
    "    uint8_t sign;",
    "    uint8_t size; /* bytes in the program memory; 0: it is added to the opcode */",
    "};",
    "",
    "/* One form of a command.  Forms with the same letters are adjacent; the first that fits is used. */",
    "struct row {",
    "    char head[3]; /* empty: the sign of the argument */",
    "    char tail[3]; /* alternative last letters, the standard one first */",
    "    uint8_t command;",
    "    uint8_t args;",
    "    uint8_t code; /* in the program memory; the codes are the model's own */",
    "    uint8_t size; /* locations there; 0: it is never stored */",
    "    uint8_t when; /* states in which it is executed directly */",
    "    bool is_motion;",
    "    struct arg arg[2];",
    "};",
    "",
    "struct rate {",
    "    uint16_t baud;",
    "    uint64_t character_ps; /* start bit, 7 data bits, parity, 2 stop bits */",
    "};",
)


def at_reset() -> Iterator[str]:
    """Yield the outputs that are high after reset; RDY is low then, because the module is starting."""
    by_name = {pin.name: pin for pin in sheet.PINS}
    for number, name in enumerate(OUTPUTS):
        if by_name[name].reset:
            yield f"1U << {number} /* {name.upper()} */"


def tables() -> Iterator[str]:
    """Yield the lines of sheet.c."""
    port = sheet.PORT
    yield f"/* {SAYS} */"
    yield from ('#include "sheet.h"', "")
    for name, each in PARTS:
        yield f"const struct row {name.lower()}_rows[{name}_ROWS] = {{"
        yield from (f"    {line}" for line in rows(each))
        yield from ("};", "")
    word = CharacterFormat(port.bits, port.parity, port.stop)
    yield f"const struct rate rates[{len(port.bauds)}] = {{"
    for number in range(len(port.bauds)):
        baud = port.bauds[tuple(number >> bit & 1 for bit in range(len(port.baud_pins)))]
        yield f"    {{{baud}, {bit_clock(baud, '').ps(word.ticks)}ULL}},"
    yield from ("};", "")
    order = [int(name[-1]) for name in port.address_pins]
    found = [port.addresses[tuple(number >> bit & 1 for bit in order)] for number in range(len(port.addresses))]
    yield f"const uint8_t addresses[{len(found)}] = {{{', '.join(map(str, found))}}};"


def rows(of: Sheet) -> list[str]:
    """Return the rows of a part as initializers, the longest letters first, in parsing order."""
    found = [(row.head, initializer(row)) for row in of.rows(LineRow)]
    found += [(head, foreign(head)) for head in of.foreign]
    return [text for _, text in sorted(found, key=lambda pair: (-len(pair[0]), pair[0]))]


def foreign(head: str) -> str:
    """Return the initializer of letters that only the other part has."""
    return f'{{.head = "{head}", .command = FOREIGN}},'


def initializer(row: LineRow) -> str:
    """Return a row as an initializer."""
    head = "" if row.head == "±" else row.head
    when = " | ".join(STATES[letter] for letter in row.when) or "0"
    tail = f', .tail = "{"".join(row.tail)}"' if row.tail else ""
    size = row.size if row.stored else 0
    stored = f", .code = 0x{row.code:02x}, .size = {size}" if size else ""
    motion = ", .is_motion = true" if row.motion else ""
    args = ", ".join(argument(arg) for arg in row.args)
    taken = f", .args = {len(row.args)}, .arg = {{{args}}}" if row.args else ""
    return f'{{.head = "{head}"{tail}, .command = {row.name}{stored}, .when = {when}{motion}{taken}}},'


def argument(arg: Arg) -> str:
    """Return an argument as an initializer."""
    return f"{{{arg.low}, {arg.high}, {SIGNS[arg.sign, arg.zero, arg.optional]}, {arg.size}}}"


def ascii_of(text: str) -> str:
    """Return a text converted to ASCII."""
    return text.replace("µ", "u")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
