"""Write headers of the firmware from the messages of the host: python tools/protocol.py [--check].

Definitions common to both ends are in src/slewline/drive/board only: names and numbers in wire.py, flags in records.py,
limits in boards.py.  The headers are for the compiler and the assembler, so they contain only #define.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "src"))

from slewline.drive.board import boards, frames, records, wire  # noqa: E402  # of this checkout

MESSAGES = ROOT / "firmware" / "common" / "protocol.h"  # of every board
LIMITS = ROOT / "firmware" / "uno" / "limits.h"
HEAD = """\
/* {says}  Written by tools/protocol.py from src/slewline/drive/board: change it there. */
#ifndef {name}
#define {name}
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
FLAGS = ("DOWN", "REST", "PAUSE", "OUT", "HALF", "RAMP_LEFT")  # of a record
UNO = boards.UNO
SIZES = (
    ("VERSION", wire.VERSION, "of the messages"),
    ("CHUNK_MOST", frames.LONGEST_CHUNK, "encoded bytes of a frame, without its zero"),
    ("RECORD_BYTES", wire.RECORD_BYTES, ""),
    ("RECORDS_MOST", wire.RECORDS_A_FRAME, "of a frame"),
    ("ENTRY_BYTES", wire.ENTRY_BYTES, "of an entry of the stop ramp"),
    ("ENTRIES_MOST", wire.ENTRIES_A_FRAME, "of a frame"),
    ("SHORTEST_PAUSE", records.SHORTEST_PAUSE, "ticks"),
    (
        "START_MOST_TICKS",
        f"{boards.START_MOST_TICKS}U",
        "from a START to the first step; more is a stale frame",
    ),
    ("INPUTS", wire.INPUTS, ""),
    ("INPUTS_MASK", (1 << wire.INPUTS) - 1, ""),
    ("USER_OUTPUTS", wire.USER_OUTPUTS, "bits of the outputs"),
    ("ENABLE", wire.ENABLE, "in addition to them"),
    ("POLARITY_UP_IS_HIGH", wire.UP_IS_HIGH, "bits of `polarity`: DIR is high upwards"),
    ("POLARITY_ENABLE_LOW", wire.ENABLE_LOW, "the driver is on while ENABLE is low"),
    ("HOST", wire.HOST, "`which` of an event without an input as its cause"),
)
OF_THE_BOARD = (
    ("BOARD_NUMBER", UNO.number, "of IDENT"),
    ("HZ", f"{UNO.hz}U", "ticks a second"),
    ("SLOTS", UNO.slots, "records in the queue"),
    ("TAIL_MOST", UNO.tail, "entries of the stop ramp"),
    ("RING", UNO.room + 1, "bytes received, a power of 2; ROOM may be unanswered"),
    ("ROOM", UNO.room, ""),
    ("SHORTEST", UNO.shortest, "ticks between two steps"),
    ("FAST_TICKS", boards.FAST_TICKS, "between steps: below this there is no time to brake at the next one"),
    ("SOONEST_TICKS", boards.SOONEST_TICKS, "from an edge, or a pause, to a step"),
    ("START_LEAD_TICKS", boards.START_LEAD_TICKS, "from the answer to a START to the first step"),
    ("LEAST_CHECK", boards.LEAST_CHECK, "ticks between the pulses of a self-test"),
)


def defined(name: str, value: object, says: str = "") -> str:
    """Return a line that defines a name."""
    return f"#define {name} {value}{f' /* {says} */' if says else ''}"


def messages() -> Iterator[str]:
    """Yield the lines of the header for all boards."""
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


def headers() -> dict[Path, str]:
    """Return the text of each header."""
    limits = (defined(*row) for row in OF_THE_BOARD)
    return {
        path: "\n".join((HEAD.format(says=says, name=f"{path.stem.upper()}_H"), *lines, "", "#endif", ""))
        for path, says, lines in (
            (MESSAGES, "Messages between host and board.", messages()),
            (LIMITS, "The limits of this board.", limits),
        )
    }


def main(words: list[str]) -> int:
    """Write the headers, or report those that differ from the messages; return the exit status."""
    wrong = 0
    for path, text in headers().items():
        if words != ["--check"]:
            path.write_text(text, "ascii")
        elif not path.exists() or path.read_text("ascii") != text:
            print(f"{path.relative_to(ROOT)} differs from the messages; run: python tools/protocol.py")
            wrong = 1
    return wrong


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
