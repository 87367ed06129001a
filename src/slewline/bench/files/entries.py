"""The entries of a journal, read one at a time and checked.

A journal may come from an untrusted source, and may have any length.

`FIELDS` lists the fields of every entry; `replaying.py` relies on it.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator
from itertools import islice
from os import PathLike
from typing import Any, BinaryIO, NamedTuple

from ...core.messages.calls import level_of_caller
from ...errors import BenchFileError, TornJournal
from ...gate import BOM, from_json, opened
from ...gate import LATEST_PS as LATEST
from .journal import VERSION

LONGEST = 1 << 26  # bytes of a line: the length with the longest script
NO_HEADER = f"the first line is not the header of a journal of version {VERSION}"


class Kind(NamedTuple):
    """The allowed values of a field: their description for messages, and their types."""

    description: str
    types: tuple[type, ...]


TEXT, LIST, TABLE = Kind("text", (str,)), Kind("a list", (list,)), Kind("an object", (dict,))
WHOLE, TRUTH = Kind("a whole number", (int,)), Kind("true or false", (bool,))
TEXT_OR_NONE, WHOLE_OR_NONE = Kind("text or null", (str, type(None))), Kind("a whole number or null", (int, type(None)))
TIME = Kind(f"picoseconds, 0 to {LATEST - 1}", (int,))
LEVEL = Kind("0, 1 or null", (int, type(None)))
HOST_CALL: dict[str, Kind] = {"host": TEXT, "args": LIST}

FIELDS: dict[str, dict[str, Kind]] = {
    "journal": {"version": WHOLE, "seed": WHOLE},
    "add": {"part": TEXT, "name": TEXT, "crystal_hz": WHOLE_OR_NONE, "straps": TABLE, "bare": TRUTH, "options": TABLE},
    "part": {"kind": TEXT, "name": TEXT, "options": TABLE},
    "host": {"name": TEXT, "chips": LIST, "delay_ps": TIME},
    "connect": {"part": TEXT, "chips": LIST},
    "wire": {"a": TEXT, "b": TEXT, "invert": TRUTH},
    "input": {"part": TEXT, "verb": TEXT, "args": LIST},
    "drive": {"pin": TEXT, "level": LEVEL},
    "power": {"chip": TEXT, "on": TRUTH},
    "run": {"to": TIME},
    "conclude": {},
    "store": {"of": TEXT, "call": WHOLE},
    **dict.fromkeys(("script", "send", "clear", "drop", "give_up", "call"), HOST_CALL),
}
OPTIONAL: dict[str, Kind] = {  # in any entry that has them
    "behaviour": WHOLE,
    "round": WHOLE,
    "slewline": TEXT,
    "baud": WHOLE_OR_NONE,
    "line": TEXT_OR_NONE,
    "over": TEXT_OR_NONE,
    "to": TEXT_OR_NONE,
    "on": TEXT_OR_NONE,
    "error": TEXT,
    "content": LIST,
    "pending": TRUTH,
}


class Entries:
    """The entries of a journal file, with their line numbers; each iteration starts at the first entry.

    If `begin` is given, reading starts at that byte offset, which must be the start of a line; `before` is
    the number of lines before that offset, and line numbers continue from this number.  A truncated last
    line is left out, and the first iteration issues the warning TornJournal.

    Raises:
        BenchFileError: the file is not readable or not a journal; or, during reading, an entry is invalid.
    """

    def __init__(self, path: str | PathLike[str], begin: int = 0, before: int = 0) -> None:
        self.path, self.begin, self.before = path, begin, before
        try:
            self.file: BinaryIO = opened(path)
        except BenchFileError as error:
            raise BenchFileError(f"journal {error}") from None
        self.count: int | None = None  # their number, known after the first reading; later readings stop there

    def __iter__(self) -> Iterator[tuple[int, dict[str, Any]]]:
        self.file.seek(self.begin)
        yield from islice(self._read(), self.count)

    def error(self, number: int, message: str) -> BenchFileError:
        """Return an error that states the journal file and a line number."""
        return BenchFileError(f"journal {self.path}, line {number}: {message}")

    def _read(self) -> Iterator[tuple[int, dict[str, Any]]]:
        number, found, last = self.before, 0, 0
        while line := self.file.readline(LONGEST):
            number += 1
            if number == 1 and not self.begin:
                line = line.removeprefix(BOM)
            if line.strip() == b"":
                continue
            entry = self._parsed(number, line)
            if entry is None:
                break
            if not found and not self.begin:
                self._check_first(entry)
            self._check(number, entry, last)
            last = entry.get("t", 0)
            found += 1
            yield number, entry
        if not found and not self.begin:
            raise BenchFileError(f"journal {self.path}: {NO_HEADER}")
        self.count = found

    def _parsed(self, number: int, line: bytes) -> dict[str, Any] | None:
        """Return the entry in a line; None if the line is truncated."""
        try:
            line.decode("ascii")
            entry = from_json(line)
            if isinstance(entry, dict) and isinstance(entry.get("do"), str) and "t" in entry:
                return entry
        except ValueError as error:
            if isinstance(error, UnicodeDecodeError):
                raise BenchFileError(f"journal {self.path} is not text") from None
        if line.endswith(b"\n") or len(line) == LONGEST:
            found = ascii(line[:60].decode("ascii").rstrip("\n"))[1:-1]
            raise self.error(number, f"not a journal entry: {found}")
        if self.count is None:
            torn = f"journal {self.path}, line {number}: cut off; the replay ends before it"
            warnings.warn(torn, TornJournal, stacklevel=level_of_caller())
        return None

    def _check_first(self, entry: dict[str, Any]) -> None:
        if entry["do"] != "journal" or entry.get("version") != VERSION:
            raise BenchFileError(f"journal {self.path}: {NO_HEADER}")

    def _check(self, number: int, entry: dict[str, Any], last: int) -> None:
        """Check that an entry has the fields of its kind, and that it is not earlier than `last` (ps)."""
        do = entry["do"]
        fields = FIELDS.get(do)
        if fields is None:
            raise self.error(number, f"unknown entry {do!r}; allowed {', '.join(FIELDS)}")
        for name, kind in fields.items():
            if name not in entry:
                raise self.error(number, f"{do}: needs {name}, {kind.description}")
            self._check_field(number, entry, name, kind)
        for name in entry.keys() - fields.keys():
            if name in OPTIONAL:
                self._check_field(number, entry, name, OPTIONAL[name])
        self._check_field(number, entry, "t", TIME)
        if entry["t"] < last:
            raise self.error(number, f"{do}: t {entry['t']} is before {last}, the t of the entry above")

    def _check_field(self, number: int, entry: dict[str, Any], name: str, kind: Kind) -> None:
        value = entry[name]
        good = type(value) in kind.types
        if kind is TIME:
            good = good and 0 <= value < LATEST
        elif kind is LEVEL:
            good = good and value in (0, 1, None)
        if not good:
            raise self.error(number, f"{entry['do']}: {name}: found {json.dumps(value)}; allowed {kind.description}")
