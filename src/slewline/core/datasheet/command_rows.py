"""Classes of command rows, each with the columns of one family: commands as text, as lines, or as packets.

Code that reads such a column requests the rows of that family: `sheet.rows(PacketRow)`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

from ..messages.former_names import formerly, published
from .table import Arg, Order, Row


@formerly(description="says")
@dataclass(frozen=True, slots=True)
class TextRow(Row):
    """A command row of the dialects `Letters` and `Verbatim`.

    Attributes:
        terminated: True if the command ends with a carriage return.
    """

    terminated: bool = True


@formerly(description="says")
@dataclass(frozen=True, slots=True)
class LineRow(Row):
    """A command row of the dialect `Lines`.

    Attributes:
        head: the text that a host sends first, if different from `form`.
        room: the number of bytes that the instruction occupies in the program memory, if that is more than
            its opcode and arguments need; else 0.
        tail: fixed text after the arguments, in each spelling that a host may use, the official one first.
    """

    head: str = ""
    room: int = 0
    tail: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        Row.__post_init__(self)
        if not self.head:
            object.__setattr__(self, "head", self.form)

    @property
    def size(self) -> int:
        """The number of bytes of the instruction in the program memory; 0 if it cannot be stored."""
        return max(1 + self.data_bytes, self.room) if self.coded else 0

    def pack(self, values: Sequence[int]) -> bytes:
        """Return opcode and arguments as stored in the program memory, extended with zeros to `room` bytes."""
        return Row.pack(self, values).ljust(self.room, b"\0")


@formerly(description="says")
@dataclass(frozen=True, slots=True)
class PacketRow(Row):
    """A command row of the dialect `Packets`.

    Attributes:
        acts: the axes on which the packet acts: the "current" axis, the axis that it selects ("set"), the
            "interrupting" axis, the axes in a "mask", or all axes ("global").
        reads: the values that a host reads after it has sent the arguments.
        buffered: True if the command takes effect with the next update.
        encoder: True if the command is meant for parts with an encoder; other parts accept it, too.
    """

    stored: bool = False
    acts: str = ""
    reads: tuple[Arg, ...] = ()
    buffered: bool = False
    encoder: bool = False

    @property
    def coded(self) -> bool:
        """True: every packet has a command byte."""
        return True

    @property
    def order(self) -> Order:
        """The byte order of numbers in a packet: high byte first."""
        return "big"


def row_object(row: Row) -> dict[str, Any]:
    """Return a row as data, with the columns of every family; columns that the row lacks have their defaults."""
    found, own = published(row), {each.name for each in fields(row)}
    others = {each.name: each.default for kind in (TextRow, LineRow, PacketRow) for each in fields(kind)}
    return found | {name: getattr(row, name, value) for name, value in others.items() if name not in own}
