"""The tables of a bench file and their keys; file.py explains them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

from ...errors import SlewlineError
from ...extras import needs

try:
    import msgspec
    from msgspec import ValidationError, convert
except ImportError:
    raise SlewlineError(needs("bench files need", "files")) from None

__all__ = ["Place", "Tables", "ValidationError", "convert", "keys_of"]

Level = Literal[0, 1]
Written = str | int  # a time as written in a file
Place = Sequence[str | int]  # ("chip", 0, "crystal")


class FileTable(msgspec.Struct, forbid_unknown_fields=True, kw_only=True, frozen=True):
    """A table of a bench file."""


class BenchTable(FileTable, frozen=True):
    """The [bench] table."""

    seed: int = 0
    until: Written | None = None
    timeout: Written = "60 s"


class ChipTable(FileTable, frozen=True):
    """A [[chip]] table."""

    part: str
    name: str | None = None
    crystal: str | int | None = None
    straps: dict[str, Level] = {}
    bare: bool = False
    options: dict[str, Any] = {}


class WireTable(FileTable, frozen=True):
    """A [[wire]] table."""

    from_: str = msgspec.field(name="from")
    to: str
    invert: bool = False


class HostTable(FileTable, frozen=True):
    """A [[host]] table."""

    chips: list[str] = []
    name: str | None = None
    delay: Written = 0
    baud: int | None = None
    over: str | None = None
    script: str | list[str] | None = None
    file: str | None = None


class ServeTable(FileTable, frozen=True):
    """A [[serve]] table."""

    chips: list[str] = []
    tcp: str | int | None = None
    pty: str | None = None
    rfc2217: str | int | None = None
    serial: str | None = None
    framing: bool = False
    prologix: bool = False
    over: str | None = None
    card: str | None = None


class DriveTable(FileTable, frozen=True):
    """A [[drive]] table."""

    pin: str
    level: Level
    at: Written = 0


class RecordTable(FileTable, frozen=True):
    """A [[record]] table."""

    pins: list[str] = []
    keep: Written | None = None


class Tables(FileTable, frozen=True):
    """A whole bench file."""

    bench: BenchTable = BenchTable()
    chip: list[ChipTable] = []
    part: list[dict[str, Any]] = []
    wire: list[WireTable] = []
    host: list[HostTable] = []
    serve: list[ServeTable] = []
    drive: list[DriveTable] = []
    record: list[RecordTable] = []


def keys_of(place: Place) -> tuple[str, ...]:
    """Return the keys allowed in the table that a place belongs to; if to none, the names of all tables."""
    tables: dict[Any, type[FileTable]] = {
        "bench": BenchTable,
        "chip": ChipTable,
        "wire": WireTable,
        "host": HostTable,
        "serve": ServeTable,
        "drive": DriveTable,
        "record": RecordTable,
    }
    table = tables.get(place[0], Tables) if place else Tables
    return table.__struct_encode_fields__
