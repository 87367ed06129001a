"""The elements of a data sheet: pins, arguments, command rows, registers, times.  Data only, no behaviour.

Rules of this file: every number states its source (`where`) and its certainty (`trust`): "stated" by the manual,
"derived" from statements of the manual, "chosen" by us where the manual is silent, or "inferred" from sister parts and
other publications if no source about the part itself states the number.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, Literal, Protocol, Self, TypeVar, overload

from ...errors import SheetError
from ..messages.former_names import formerly
from .channel import Channel
from .option import Option
from .roles import AT_ONCE, AXIS_ROLES, REFLEXES, ROLES, ROW_ROLES

Trust = Literal["stated", "derived", "chosen", "inferred"]
InOut = Literal["in", "out", "both", "power", "none"]
Order = Literal["little", "big"]


@formerly(in_out="way", description="says", transcript="told")
@dataclass(frozen=True, slots=True)
class Pin:
    """A pin of the package, as the data sheet lists it.

    Attributes:
        number: the number of the pin.
        name: the name in the manual, in lower case.
        in_out: the direction: "in", "out", "both", "power" or "none" (not connected).
        description: text that describes the function of the pin.
        active: the active level, 0 or 1; None if the pin has none.
        pull: the level to which a built-in resistor pulls an open input; None if there is no resistor.
        tie: the level at which the standard wiring holds the pin; None if there is none.  A bare part works
            only if the pin is wired to this level.
        reset: the level of an output after reset; None if it is undefined.
        seen: text that states when the chip samples an input.
        where: the section of the manual.
        role: the purpose of the pin, a word from ROLES, which all parts share; wiring connects pins by role.
        axis: the axis that the role belongs to, counted from 1.
        sense: the level at which the role is active, by default `active`; it differs if the pin is named for the
            opposite of its role (ATREST is low while the motor is moving).  A driver steps when its step pin
            takes this level.
        transcript: the transcript texts for the pin going low and for it going high; None for no text.
        reflex: the direct effect of an active input on a running motor, a word from REFLEXES; for a pin that enables
            steps, the effect of its inactive level.
        trust: how certain the row is: "stated", "derived", "chosen" or "inferred".

    Raises:
        SheetError: an unknown role or reflex, or a reflex of a pin without an active level.
    """

    number: int
    name: str
    in_out: InOut
    description: str
    active: int | None = None
    pull: int | None = None
    tie: int | None = None
    reset: int | None = None
    seen: str = ""
    where: str = ""
    role: str = ""
    axis: int = 1
    sense: int | None = None
    transcript: tuple[str, str] | None = None
    reflex: str = ""
    trust: Trust = "stated"

    def __post_init__(self) -> None:
        if self.reflex and (self.reflex not in REFLEXES or self.acts is None):
            names = ", ".join(REFLEXES)
            raise SheetError(f"pin {self.name}: reflex {self.reflex!r}; required: an active level, and one of {names}")
        if self.role and self.role not in ROLES:
            raise SheetError(f"pin {self.name}: no role {self.role!r}; available: {', '.join(ROLES)}")
        if self.sense is None:
            object.__setattr__(self, "sense", self.active)

    @property
    def acts(self) -> int | None:
        """The level that triggers the reflex of the pin; None if the pin has no active level."""
        level = self.active if self.sense is None else self.sense
        return 1 - level if self.role == "enable" and level is not None else level

    @property
    def output_only(self) -> bool:
        """True if nothing external may drive the pin."""
        return self.in_out == "out"

    def plays(self, role: str, axis: int = 1) -> bool:
        """Return whether the pin has the given role (on the given axis, if the role belongs to an axis)."""
        return self.role == role and (self.axis == axis or role not in AXIS_ROLES)


@dataclass(frozen=True, slots=True)
class Arg:
    """An argument of a command.

    Attributes:
        name: the name in the manual.
        size: the number of bytes; an argument of size 0 is added to the opcode.
        low: the minimum.
        high: the maximum.
        label: True if a letter may be used instead of the value.
        unit: the unit that the value counts, such as "steps".
        sign: how a sign is written: "no", "may" (no sign: plus), "must", or "alone" (a direction: + is 1, - is -1).
        zero: False if 0 is not allowed, even if it is between `low` and `high`.
        optional: True if the argument may be left out; its value is then `high`.
        fraction: the number of bits after the binary point: with 16 the value counts 1/65536 of its unit.
        cycles: the power of the chip's cycle in the denominator of the unit: 1 for a speed, 2 for an acceleration.
        alias: pairs (value, value that the chip uses instead), such as (256, 255); if any other
            value is too large, the chip uses its low bytes.
    """

    name: str
    size: int
    low: int
    high: int
    label: bool = False
    unit: str = ""
    sign: Literal["no", "may", "must", "alone"] = "no"
    zero: bool = True
    optional: bool = False
    fraction: int = 0
    cycles: int = 0
    alias: tuple[tuple[int, int], ...] = ()

    @property
    def modulus(self) -> int:
        """The value at which numbers wrap: 256 for an argument of one byte, 65536 for two bytes."""
        return 1 << (8 * self.size)

    def fit(self, number: int) -> int:
        """Return the value that the part uses for a number, which may be out of range."""
        return dict(self.alias).get(number, number % self.modulus)

    def allows(self, value: int) -> bool:
        """Return whether a value is allowed: within the range, and not 0 if `zero` is False."""
        return self.low <= value <= self.high and (self.zero or value != 0)

    def pack(self, value: int, order: Order = "little") -> bytes:
        """Return a value as `size` bytes, a negative one in two's complement."""
        return (value % self.modulus).to_bytes(self.size, order)

    def unpack(self, data: bytes, order: Order = "little") -> int:
        """Return the value that bytes encode; missing bytes count as 0."""
        return int.from_bytes(data.ljust(self.size, b"\0"), order, signed=self.low < 0)

    def spell(self, value: int) -> str:
        """Return a value as text without leading zeros, signed unless `sign` is "no"; if "alone", only the sign."""
        if self.sign == "alone":
            return "+" if value > 0 else "-"
        return f"{value:+d}" if self.sign != "no" else str(value)


@formerly(description="says")
@dataclass(frozen=True, slots=True)
class Row:
    """One form of a command, with the columns shared by all dialects; `LineRow`, `TextRow`, `PacketRow` add more.

    Attributes:
        form: the text that identifies the form: the letter or name that a host sends first.
        name: the command name, which determines the name of the firmware method: do_loop for LOOP.
        args: the arguments, in order.
        time_us: the time that the part takes in command mode for the last byte of the command, µs, with the
            usual crystal, excluding the conversion of digits.
        description: text that describes the effect of the command.
        where: the section of the manual.
        program_us: the time that the instruction takes in a running program, µs, with the usual crystal.
        code: the opcode in the program memory, or the command byte of a packet; by default the ASCII code
            of the first letter of `form`.
        stored: True if the command can be stored in a program.
        motion: True if the command makes the motor step.
        when: the states in which the command is executed immediately: "i" idle, "p" program entry, "r" program running.
        flow: where a program continues after the command: "n" next instruction, "t" target, "0" location 0,
            "l" start of the loop; "" if the program ends.
        role: the purpose of the command, a word from ROW_ROLES, which all parts share.
        at_once: the effect that the command has on a running motor before the end of the motion: a word from
            AT_ONCE, or "" if it has none; a buffered command has this effect at the update.
        starts: True if the command itself outputs no steps, but outside program entry may start a program or a homing
            run.
        trust: how certain the row is: "stated", "derived", "chosen" or "inferred".

    Raises:
        SheetError: an unknown role, or an unknown word in `at_once`.
    """

    form: str
    name: str
    args: tuple[Arg, ...]
    time_us: int
    description: str
    where: str
    program_us: int = 40
    code: int = -1
    stored: bool = True
    motion: bool = False
    when: str = "i"
    flow: str = "n"
    role: str = ""
    at_once: str = ""
    starts: bool = False
    trust: Trust = "stated"

    def __post_init__(self) -> None:
        if self.role and self.role not in ROW_ROLES:
            raise SheetError(f"command {self.name}: no role {self.role!r}; available: {', '.join(ROW_ROLES)}")
        if self.at_once and self.at_once not in AT_ONCE:
            raise SheetError(f"command {self.name}: at_once {self.at_once!r}; allowed {', '.join(AT_ONCE)}")
        if self.code < 0:
            object.__setattr__(self, "code", ord(self.form[0]))

    @property
    def data_bytes(self) -> int:
        """The number of data bytes of the command, which its binary form contains as the data count."""
        return sum([arg.size for arg in self.args])

    @property
    def takes(self) -> str:
        """Text that lists the names of the arguments; "no argument" if there are none."""
        return " and ".join(arg.name for arg in self.args) or "no argument"

    @property
    def may_step(self) -> bool:
        """True if the command may make the motor step when a host sends it outside program entry."""
        return self.motion or self.starts or self.role == "run"

    @property
    def head(self) -> str:
        """The text that a host sends first."""
        return self.form

    @property
    def coded(self) -> bool:
        """True if the command has a code: its opcode in the program buffer, or the first byte of its packet."""
        return self.stored

    @property
    def size(self) -> int:
        """The size in bytes of the instruction in the program buffer, or of the host's packet; 0 if it has no code."""
        return 1 + self.data_bytes if self.coded else 0

    @property
    def order(self) -> Order:
        """The byte order of a number in a program buffer: low byte first."""
        return "little"

    @property
    def handler(self) -> str:
        """The name of the firmware method that executes the command: do_loop for LOOP."""
        return "do_" + self.name.lower()

    def pack(self, values: Sequence[int]) -> bytes:
        """Return opcode and arguments as stored in the program buffer, or as written in a packet."""
        code, data = self.code, b""
        for arg, value in zip(self.args, values, strict=True):
            if arg.size:
                data += arg.pack(value, self.order)
            else:
                code += value
        return bytes([code]) + data

    def unpack(self, data: bytes, code: int | None = None) -> tuple[int, ...]:
        """Return the argument values that bytes encode; missing bytes count as 0.

        An argument of size 0 is taken from `code`, the stored opcode; without `code` it is 0.
        """
        values, at = [], 0
        for arg in self.args:
            if arg.size:
                values.append(arg.unpack(data[at : at + arg.size], self.order))
                at += arg.size
            else:
                values.append((self.code if code is None else code) - self.code)
        return tuple(values)

    @classmethod
    def of(cls, row: Row) -> Self:
        """Convert a row to this class, which adds the columns of a family; return a row of this class unchanged.

        Raises:
            SheetError: the row is of another family.
        """
        if isinstance(row, cls):
            return row
        if not issubclass(cls, type(row)):
            raise SheetError(f"command {row.name}: a {type(row).__name__}; expected a {cls.__name__}")
        return cls(**{each.name: getattr(row, each.name) for each in fields(row)})

    @property
    def codes(self) -> range:
        """The opcodes of the instruction: several if an argument is part of the opcode."""
        return range(self.code, self.code + next((arg.high + 1 for arg in self.args if not arg.size), 1))


@formerly(description="says")
@dataclass(frozen=True, slots=True)
class Register:
    """A register of the chip.

    Attributes:
        name: the name in the manual, in lower case.
        bits: the number of bits.
        default: the value after power-up.
        description: text that describes the meaning of the value.
        letter: the letter of the command that loads the register; "" if there is none.
        where: the section of the manual.
        unit: the unit of the value, such as "steps".
    """

    name: str
    bits: int
    default: int
    description: str
    letter: str = ""
    where: str = ""
    unit: str = ""


@formerly(description="says")
@dataclass(frozen=True, slots=True)
class Timing:
    """A time that an operation of the chip takes, as given in the data sheet.

    Attributes:
        us: the time, µs.
        mhz: the crystal frequency for which the time is given, MHz.
        description: text that describes the operation.
        where: the section of the manual.
        trust: how certain the row is: "stated", "derived", "chosen" or "inferred".
    """

    us: float
    mhz: float
    description: str
    where: str
    trust: Trust = "stated"

    @property
    def ticks(self) -> int:
        """The time in crystal clocks, the same number for every crystal, rounded to the nearest (halves up)."""
        return int(self.us * self.mhz + 0.5)


@formerly(description="says")
@dataclass(frozen=True, slots=True)
class Limit:
    """A data sheet limit for the time between two edges.

    An edge names a pin, or the data bus, and a change: "falls", "rises", "changes"; for a bus also "appears"
    (an output starts driving it) and "vanishes" (the output stops).  The time is measured from the last
    `start` to the first `end` after it: with two strobes while a chip is selected, the first strobe ends a
    set-up time and the second begins a hold time.  If a start and an end occur at the same instant, the time
    is 0.  But if the limit has only a typical time, an end at the instant of a start belongs to the previous
    start.

    Attributes:
        start: the edge at which the time begins, such as "io_request falls".
        end: the edge at which the time ends.
        description: text that describes the purpose of the limit.
        where: the section of the manual.
        least: the minimum, ps; None if there is none.
        typical: the typical time, ps; None if none is given.
        most: the maximum, ps; None if there is none.
        symbol: the symbol in the data sheet, such as "t14".
        mhz: the crystal frequency for which the limit is given, MHz; 0 if it holds with every crystal.
        keeper: the side that must comply: "part", or "host" (any driver of the inputs of the part).
        given: the levels that pins must have at `end` for the limit to apply.
        before: the levels that pins must have had at `start` for the limit to apply.
        trust: how certain the row is: "stated", "derived", "chosen" or "inferred".
    """

    start: str
    end: str
    description: str
    where: str
    least: int | None = None
    typical: int | None = None
    most: int | None = None
    symbol: str = ""
    mhz: int = 0
    keeper: Literal["part", "host"] = "part"
    given: tuple[tuple[str, int], ...] = ()
    before: tuple[tuple[str, int], ...] = ()
    trust: Trust = "stated"

    def at(self, crystal_hz: int) -> tuple[int | None, int | None, int | None]:
        """Return the minimum, typical and maximum time with this crystal, ps, rounded in favour of the `keeper`."""
        if not self.mhz:
            return self.least, self.typical, self.most
        up, down = self.mhz * 10**6, crystal_hz
        least, typical = (None if ps is None else ps * up // down for ps in (self.least, self.typical))
        return least, typical, None if self.most is None else -(-self.most * up // down)

    @property
    def edges(self) -> str:
        """Text that names both edges, such as "io_request falls to ready falls"."""
        return f"{self.start} to {self.end}"


R_co = TypeVar("R_co", bound=Row, covariant=True)
R = TypeVar("R", bound=Row)


class Table(Sequence[R_co]):
    """The command table of a part: a sequence of rows, which are also accessible by form, as in table["R"].

    Attributes:
        rows: the rows.
        by_form: the rows, keyed by form.
        by_code: the rows of commands with a code, keyed by opcode or command byte.

    Raises:
        SheetError: two rows have the same form, or the same opcode or command byte.
    """

    def __init__(self, *rows: R_co) -> None:
        self.rows = rows
        self.by_form: dict[str, R_co] = {row.form: row for row in rows}
        self.by_code: dict[int, R_co] = {code: row for row in rows if row.coded for code in row.codes}
        self._of: dict[type[Row], Table[Any]] = {}
        if len(self.by_form) != len(rows) or len(self.by_code) != sum(len(row.codes) for row in rows if row.coded):
            raise SheetError("two command rows share a form or an opcode")

    @overload
    def __getitem__(self, key: str | int) -> R_co: ...

    @overload
    def __getitem__(self, key: slice) -> Sequence[R_co]: ...

    def __getitem__(self, key: str | int | slice) -> R_co | Sequence[R_co]:
        return self.by_form[key] if isinstance(key, str) else self.rows[key]

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[R_co]:
        return iter(self.rows)

    def __repr__(self) -> str:
        return f"<Table: {len(self)} commands>"

    def named(self, name: str) -> R_co:
        """Return the first row of the command with this name, such as "LOOP", in upper or lower case.

        Raises:
            KeyError: there is no such command.
        """
        for row in self.rows:
            if row.name == name.upper():
                return row
        raise KeyError(name)

    def of(self, kind: type[R]) -> Table[R]:
        """Return the table with rows of the class `kind`; columns that a row lacks are added with their defaults.

        Raises:
            SheetError: a row is of another family.
        """
        if kind not in self._of:
            self._of[kind] = self if all(isinstance(row, kind) for row in self) else Table(*map(kind.of, self))
        return self._of[kind]


@formerly(description="says")
@dataclass(frozen=True, slots=True)
class Bits:
    """A field of a stored word: `width` bits from bit `low` up; its value is the number there plus `first`."""

    name: str
    low: int
    description: str
    width: int = 1
    first: int = 0

    @property
    def mask(self) -> int:
        """The word with ones in this field, and zeros elsewhere."""
        return (1 << self.width) - 1 << self.low

    def of(self, word: int) -> int:
        """Return the meaning of this field in a word: the number in its bits, plus `first`."""
        return ((word & self.mask) >> self.low) + self.first


class DialectSpec(Protocol):
    """The dialect attributes that a sheet uses; the complete class is in language/dialect.py."""

    @property
    def name(self) -> str:
        """The name of the dialect, such as "letters", "lines" or "packets"."""

    @property
    def row_type(self) -> type[Row]:
        """The class of the command rows in this dialect."""


C = TypeVar("C", bound=Channel)


@dataclass(frozen=True, eq=False)
class Sheet:
    """A complete data sheet: all facts about a part that tools need without running it.

    Attributes:
        part: the part number, in lower case.
        title: one line that describes the part.
        manual: the source of the facts.
        pins: the pin table.
        commands: the command table.
        behaviour: a number that is increased whenever a change to the model makes the same inputs
            produce different outputs; a journal records the number with which its run was made.
        crystal_hz: the usual crystal frequency, Hz; 10^12 (ticks of 1 ps) if no crystal can be selected.
        crystal_low_hz: the lowest crystal frequency allowed, Hz.
        crystal_high_hz: the highest crystal frequency allowed, Hz; 0 if there is no selectable crystal.
        registers: the register table.
        options: the options with which the part is created.
        rates: the rate for each value of the rate parameter, steps/s, with the usual crystal.
        times: the times that the part takes, keyed by names chosen for this project.
        limits: the limits for the times between edges.
        buffer_bytes: the size of the program memory, in units of `memory_unit`.
        buffer_where: the section of the manual that states the size of the program memory.
        labels: the letters that can be labels in a program.
        suffix: the file extension of programs.
        notes: further text for `slewline describe`, keyed by heading.
        dialect: how commands are written, sent and stored.
        channels: the channels over which a host can reach the part, the usual one first.
        axes: the number of motors.
        wires: for a part in several packages, groups of pins (their names) that are connected to each other.
        foreign: commands of sister parts, which this part refuses as unknown.
        slips: the remedies for characters that are often used by mistake, keyed by character.
        sections: the sections of the manual to which linter rules refer, keyed by subject.
        key: the abbreviation that stands for the manual in `where`.
        memory_unit: the unit in which the manual states the size of the program memory.
    """

    part: str
    title: str
    manual: str
    pins: tuple[Pin, ...]
    commands: Table[Row]
    behaviour: int = 1
    crystal_hz: int = 10**12
    crystal_low_hz: int = 0
    crystal_high_hz: int = 0
    registers: tuple[Register, ...] = ()
    options: tuple[Option, ...] = ()
    rates: tuple[int, ...] = ()
    times: Mapping[str, Timing] = field(default_factory=dict)
    limits: tuple[Limit, ...] = ()
    buffer_bytes: int = 0
    buffer_where: str = ""
    labels: str = ""
    suffix: str = ""
    notes: Mapping[str, str] = field(default_factory=dict)
    dialect: DialectSpec | None = None
    channels: tuple[Channel, ...] = ()
    axes: int = 1
    wires: tuple[tuple[str, ...], ...] = ()
    foreign: tuple[str, ...] = ()
    slips: Mapping[str, str] = field(default_factory=dict)
    sections: Mapping[str, str] = field(default_factory=dict)
    key: str = ""
    memory_unit: str = "byte"

    def __post_init__(self) -> None:
        if self.dialect is not None:
            object.__setattr__(self, "commands", self.commands.of(self.dialect.row_type))

    def __repr__(self) -> str:
        return f"<Sheet {self.part}: {len(self.pins)} pins, {len(self.commands)} commands>"

    @property
    def keeps(self) -> bool:
        """True if the part has non-volatile memory; the option `store` then sets where its content is kept."""
        return any(row.name == "store" for row in self.options)

    @property
    def encoder(self) -> bool:
        """True if the part reads encoders."""
        return self.role("encoder_a") is not None

    @property
    def enter(self) -> Row | None:
        """The command that begins program entry; None if the part stores no programs."""
        return next(iter(self.acting("enter")), None)

    @property
    def leave(self) -> tuple[Row, ...]:
        """The commands that end program entry; a command with no other effect comes last."""
        return self.acting("leave")

    @property
    def takes_live(self) -> bool:
        """True if a host may send commands while a program runs, by pulling the program entry pin low."""
        entry = self.role("program_entry")
        return entry is not None and entry.in_out == "both"

    @property
    def bus(self) -> str:
        """The common prefix of the names of the data bus pins, such as "db"."""
        data = self.role("data")
        return data.name.rstrip("0123456789") if data is not None else "db"

    @property
    def fastest(self) -> dict[str, int]:
        """The straps, as levels keyed by pin, that select the highest rate of every channel."""
        return {pin: level for channel in self.channels for pin, level in channel.fastest.items()}

    @property
    def plain(self) -> dict[str, int]:
        """The straps that switch off features not used in program files, such as checksums: levels keyed by pin.

        They include the straps of all channels.
        """
        return {pin: level for channel in self.channels for pin, level in channel.plain.items()}

    def elsewhere(self, name: str, value: object) -> str:
        """Return advice on setting what is not an option, such as a baud rate; "" if it cannot be set."""
        return next((message for channel in self.channels if (message := channel.elsewhere(name, value))), "")

    def channel(self, kind: type[C]) -> C | None:
        """Return the first channel of the class `kind`; None if the part has no such channel."""
        return next((channel for channel in self.channels if isinstance(channel, kind)), None)

    def through(self, kind: type[C]) -> C:
        """Return the first channel of the class `kind`.

        Raises:
            SheetError: the part has no such channel.
        """
        channel = self.channel(kind)
        if channel is None:
            has = ", ".join(type(other).__name__ for other in self.channels) or "none"
            raise SheetError(f"{self.part} needs a {kind.__name__} among its channels; it has {has}: add one")
        return channel

    def rows(self, kind: type[R]) -> Table[R]:
        """Return the command table with rows of the class `kind`, which has the columns of a family.

        Raises:
            SheetError: the commands are of another family.
        """
        return self.commands.of(kind)

    def acting(self, role: str) -> tuple[Row, ...]:
        """Return the rows of all commands with the given role."""
        return tuple(row for row in self.commands if row.role == role)

    def role(self, role: str, axis: int = 1) -> Pin | None:
        """Return the first pin with a role (on the given axis, if it belongs to one); None if there is none."""
        return self._by_role.get((role, axis if role in AXIS_ROLES else 0))

    def in_role(self, role: str) -> Pin:
        """Return the first pin with a role, on axis 1 if the role belongs to an axis.

        Raises:
            SheetError: no pin has the role.
        """
        pin = self.role(role)
        if pin is None:
            raise SheetError(
                f"{self.part} needs a pin with the role {role!r}, but none has this role; set it for one pin"
            )
        return pin

    def pin(self, name: str) -> Pin:
        """Return the pin with the given name.

        Raises:
            KeyError: there is no such pin.
        """
        return self._by_name[name]

    @cached_property
    def _by_name(self) -> dict[str, Pin]:
        return {pin.name: pin for pin in reversed(self.pins)}  # the first one if several share a name

    @cached_property
    def _by_role(self) -> dict[tuple[str, int], Pin]:
        """The first pin of each role, keyed by role and axis; the axis is 0 for a role that belongs to no axis."""
        return {(pin.role, pin.axis if pin.role in AXIS_ROLES else 0): pin for pin in reversed(self.pins)}
