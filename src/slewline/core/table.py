"""What a data sheet is made of: pins, arguments, command rows, registers, times.  Data only, no behaviour.

Rules of this file: every number names its source (`where`) and how sure we are (`trust`): "stated" by the manual,
"derived" from statements of the manual, or "chosen" by us where the manual is silent.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from ..errors import SheetError

Trust = Literal["stated", "derived", "chosen"]
Way = Literal["in", "out", "both", "power", "none"]


@dataclass(frozen=True, slots=True)
class Pin:
    """A pin of the package, as the data sheet lists it.

    `pull` is the level that a built-in resistor gives an open input, `tie` the standard wiring that makes a bare part
    work, `reset` the level that an output shows after reset, `seen` says when the chip looks at an input.
    """

    number: int
    name: str
    way: Way
    says: str
    active: int | None = None
    pull: int | None = None
    tie: int | None = None
    reset: int | None = None
    seen: str = ""
    where: str = ""


@dataclass(frozen=True, slots=True)
class Arg:
    """An argument: `low` to `high`, in `size` bytes, low byte first; with `label`, a letter may stand for it."""

    name: str
    size: int
    low: int
    high: int
    label: bool = False
    unit: str = ""

    @property
    def modulus(self) -> int:
        """Numbers wrap at this value: 256 or 65536."""
        return 1 << (8 * self.size)

    def pack(self, value: int) -> bytes:
        """The value as it stands in the program buffer, low byte first."""
        return value.to_bytes(self.size, "little")


@dataclass(frozen=True, slots=True)
class Row:
    """One form of a command.

    `form` is what a host sends first (a letter), `code` the opcode in the program buffer, `time_us` the time that the
    last byte of the command takes in command mode (at the reference crystal, without conversion of digits),
    `program_us` the time that the instruction takes in a running program.
    """

    form: str
    name: str
    args: tuple[Arg, ...]
    time_us: int
    says: str
    where: str
    program_us: int = 40
    code: int = -1
    terminated: bool = True
    stored: bool = True
    motion: bool = False

    def __post_init__(self) -> None:
        if self.code < 0:
            object.__setattr__(self, "code", ord(self.form))

    @property
    def data_bytes(self) -> int:
        """How many data bytes the command has: the data count of the binary form."""
        return sum(arg.size for arg in self.args)

    @property
    def size(self) -> int:
        """How many bytes the instruction takes in the program buffer."""
        return (1 + self.data_bytes) if self.stored else 0

    @property
    def handler(self) -> str:
        """Name of the firmware method that performs it: do_loop for LOOP."""
        return "do_" + self.name.lower()

    def pack(self, values: Sequence[int]) -> bytes:
        """Opcode and arguments as stored in the program buffer."""
        return bytes([self.code]) + b"".join(arg.pack(value) for arg, value in zip(self.args, values, strict=True))

    def unpack(self, data: bytes) -> tuple[int, ...]:
        """Argument values from their stored bytes; bytes that are missing count as 0."""
        values, at = [], 0
        for arg in self.args:
            values.append(int.from_bytes(data[at : at + arg.size], "little"))
            at += arg.size
        return tuple(values)


@dataclass(frozen=True, slots=True)
class Register:
    """A register of the chip, by the manual's name; `letter` is the command that loads it."""

    name: str
    bits: int
    default: int
    says: str
    letter: str = ""
    where: str = ""


@dataclass(frozen=True, slots=True)
class Time:
    """A time of the data sheet, stated for a crystal; `ticks` is what the chip counts, whatever crystal is fitted."""

    us: float
    mhz: float
    says: str
    where: str
    trust: Trust = "stated"

    @property
    def ticks(self) -> int:
        """Whole crystal clocks (half a clock rounds up)."""
        return int(self.us * self.mhz + 0.5)


class Table(Sequence[Row]):
    """The command rows of a part, looked up by form or by stored opcode."""

    def __init__(self, *rows: Row) -> None:
        self.rows = rows
        self.by_form: dict[str, Row] = {row.form: row for row in rows}
        self.by_code: dict[int, Row] = {row.code: row for row in rows if row.stored}
        if len(self.by_form) != len(rows) or len(self.by_code) != sum(row.stored for row in rows):
            raise SheetError("two command rows share a form or an opcode")

    def __getitem__(self, key):  # type: ignore[no-untyped-def]
        return self.by_form[key] if isinstance(key, str) else self.rows[key]

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[Row]:
        return iter(self.rows)

    def named(self, name: str) -> Row:
        """The row of a command by its name, for example "LOOP"."""
        for row in self.rows:
            if row.name == name.upper():
                return row
        raise KeyError(name)


@dataclass(frozen=True)
class Sheet:
    """A whole data sheet: everything that tools may know about a part without running it."""

    part: str
    title: str
    manual: str
    crystal_hz: int
    crystal_low_hz: int
    crystal_high_hz: int
    pins: tuple[Pin, ...]
    commands: Table
    registers: tuple[Register, ...]
    times: Mapping[str, Time]
    buffer_bytes: int
    verify_bytes: Mapping[int, int] = field(default_factory=dict)
    labels: str = ""
    suffix: str = ""
    notes: Mapping[str, str] = field(default_factory=dict)

    def pin(self, name: str) -> Pin:
        """The pin of this name."""
        for pin in self.pins:
            if pin.name == name:
                return pin
        raise KeyError(name)
