"""Write the header of the firmware from the messages of the host: python tools/protocol.py [--check].

What both ends must agree on is written once, in src/slewline/drive/board: names and numbers of wire.py, flags of
records.py, limits of boards.py.  The header is for the compiler and the assembler, so it has nothing but #define.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "src"))

from slewline.drive.board import boards, frames, records, wire  # noqa: E402  # of this checkout

HEADER = ROOT / "firmware" / "uno" / "protocol.h"
HEAD = """\
/* Written by tools/protocol.py from src/slewline/drive/board: change it there. */
#ifndef PROTOCOL_H
#define PROTOCOL_H
"""
GROUPS = (  # prefix in C, enumeration
    ("FRAME", wire.FrameKind),
    ("RESULT", wire.FrameResult),
    ("STATE", wire.BoardState),
    ("EVENT", wire.Happening),
    ("REFLEX", wire.Reflex),
    ("DRIVER", wire.DriverFlag),
    ("OFF", wire.EnableOff),
    ("RESET", wire.ResetFlag),
    ("POWER", wire.PowerFlag),
)
FLAGS = ("DOWN", "REST", "PAUSE", "OUT", "HALF", "WAY")  # of a record
UNO = boards.UNO
SIZES = (
    ("VERSION", wire.VERSION, "of the messages"),
    ("BOARD_NUMBER", UNO.number, "of IDENT"),
    ("HZ", f"{UNO.hz}UL", "ticks a second"),
    ("SLOTS", UNO.slots, "records in the queue"),
    ("TAIL_MOST", UNO.tail, "entries of the stop ramp"),
    ("RING", UNO.room + 1, "bytes received, a power of 2; ROOM may be unanswered"),
    ("ROOM", UNO.room, ""),
    ("CHUNK_MOST", frames.LONGEST_CHUNK, "encoded bytes of a frame, without its zero"),
    ("RECORD_BYTES", wire.RECORD_BYTES, ""),
    ("RECORDS_MOST", wire.RECORDS_A_FRAME, "of a frame"),
    ("ENTRY_BYTES", wire.ENTRY_BYTES, "of an entry of the stop ramp"),
    ("ENTRIES_MOST", wire.ENTRIES_A_FRAME, "of a frame"),
    ("SHORTEST", UNO.shortest, "ticks between two steps"),
    ("SHORTEST_PAUSE", records.SHORTEST_PAUSE, "ticks"),
    ("FAST_TICKS", boards.FAST_TICKS, "between steps: with less there is no time to brake at the next one"),
    ("SOONEST_TICKS", boards.SOONEST_TICKS, "from an edge, or a pause, to a step"),
    ("START_LEAD_TICKS", boards.START_LEAD_TICKS, "from the answer to a START to the first step"),
    ("START_MOST_TICKS", f"{boards.START_MOST_TICKS}UL", "the same at most: what is farther ahead is a stale frame"),
    ("LEAST_CHECK", boards.LEAST_CHECK, "ticks between the pulses of a self-test"),
    ("INPUTS", wire.INPUTS, ""),
    ("USER_OUTPUTS", wire.USER_OUTPUTS, "bits of the outputs"),
    ("ENABLE", wire.ENABLE, "beside them"),
    ("POLARITY_UP_IS_HIGH", wire.UP_IS_HIGH, "bits of `polarity`: DIR is high upwards"),
    ("POLARITY_ENABLE_LOW", wire.ENABLE_LOW, "the driver is on while ENABLE is low"),
    ("HOST", wire.HOST, "`which` of an event that no input caused"),
)


def defined(name: str, value: object, says: str = "") -> str:
    """Return a line that defines a name."""
    return f"#define {name} {value}{f' /* {says} */' if says else ''}"


def lines() -> Iterator[str]:
    """Yield the lines of the header."""
    yield from (defined(*row) for row in SIZES)
    for prefix, kind in GROUPS:
        says = (kind.__doc__ or "").partition("\n")[0]
        yield f"\n/* {says} */"
        yield from (defined(f"{prefix}_{each.name}", int(each)) for each in kind)
    yield "\n/* Flags of a record, and the numbers of their bits. */"
    for name in FLAGS:
        flag = getattr(records, name)
        yield defined(f"RECORD_{name}", flag)
        yield defined(f"RECORD_{name}_BIT", flag.bit_length() - 1)


def header() -> str:
    """Return the header."""
    return "\n".join((HEAD, *lines(), "", "#endif", ""))


def main(words: list[str]) -> int:
    """Write the header, or say that it is not what the messages are."""
    if words == ["--check"]:
        if HEADER.read_text("ascii") != header():
            print(f"{HEADER.relative_to(ROOT)} is not what the messages are; run: python tools/protocol.py")
            return 1
        return 0
    HEADER.write_text(header(), "ascii")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
