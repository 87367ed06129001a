"""The journal: every external input, one JSON object per line; a replay repeats the run bit for bit.

    {"do": "journal", "version": 1, "seed": 0, "slewline": "0.1.0"}
    {"do": "add", "t": 0, "part": "cy525", "behaviour": 2, "name": "x", ...}
    {"do": "drive", "t": 12000000000, "round": 1, "pin": "x.abort", "level": 0}

`t` is the instant in picoseconds; `round` 1 marks inputs made in the first round of that instant, before its changes
commit; all other inputs follow the changes of the instant.  Lines are written immediately, so the journal of a killed
run is valid up to its last complete line.

    {"do": "store", "t": 15000000000, "of": "x", "call": 3, "error": "x.eeprom: cannot write the memory: ..."}

The journal also records the faults of an external store: failed calls, changed content, and delays.
`call` is the number of the call, counted since the owner of the store was put on the bench, and a replay
repeats the fault at that call (`core/memory/store.py`).  `entries.py` lists the fields of each entry.

`part` (of a chip) and `kind` (of a part) are names by which the class can be found again: a built-in name, the name of
an entry point, or module:Class.

A run is repeated bit for bit only if the parts still behave in the same way: `behaviour` is copied from
the field of that name in the part's sheet.  A journal without `behaviour` is older than
that field; the value is then taken to be 1.
"""

from __future__ import annotations

import json
from contextlib import suppress
from fractions import Fraction
from numbers import Integral
from os import PathLike
from pathlib import Path
from typing import Any, Literal, TextIO
from weakref import finalize

from ...core.time.hook import Hook
from ...core.time.kernel import Kernel
from ...errors import BenchFileError
from ...version import __version__

VERSION = 1
FIRST = b'{"do":"journal",'  # its start


class Journal:
    """A journal that is being written; an existing journal is replaced.

    Attributes:
        path: the path of the file.
        failure: the reason why the journal can no longer be written; "" while it can.
        on_failure: hook, called once with that reason; if it has a listener, the run continues without a
            journal.

    Raises:
        BenchFileError: the file exists and is not a journal, or cannot be written.  A later failure to write raises it
            too, unless `on_failure` has a listener.
    """

    def __init__(self, path: str | PathLike[str], kernel: Kernel, seed: int) -> None:
        replaced(path)
        self._open(path, kernel, "w")
        self.write("journal", {"version": VERSION, "seed": seed, "slewline": __version__})

    def _open(self, path: str | PathLike[str], kernel: Kernel, mode: Literal["w", "a"]) -> None:
        self.path, self.kernel = Path(path), kernel
        self.failure = ""
        self.on_failure: Hook[[str]] = Hook()
        try:
            self.file: TextIO = open(path, mode, encoding="ascii", buffering=1)  # noqa: SIM115
        except OSError as error:
            raise BenchFileError(self._refusal(error)) from None
        finalize(self, closed, self.file)  # a bench needs no closing

    def __repr__(self) -> str:
        return f"<Journal {self.path}{': ' + self.failure if self.failure else ''}>"

    def write(self, do: str, what: dict[str, Any]) -> None:
        """Write one input, with the current instant.

        Raises:
            BenchFileError: an argument that a journal cannot hold, such as a function; or the file cannot be written.
        """
        if self.failure:
            if not self.on_failure:
                raise BenchFileError(self.failure)
            return
        kernel = self.kernel
        entry: dict[str, Any] = {"do": do, "t": kernel.now}
        if kernel.running and kernel.seen < kernel.now:
            entry["round"] = 1
        try:
            self.file.write(json.dumps(entry | what, separators=(",", ":"), default=_plain) + "\n")
        except TypeError as error:
            raise BenchFileError(f"journal {self.path}: {do}: {error}; journals store only numbers and text") from None
        except OSError as error:
            self.failure = self._refusal(error)
            closed(self.file)
            if not self.on_failure:
                raise BenchFileError(self.failure) from None
            self.on_failure(f"journal {self.path}: {error.strerror or error}; the journal ends here")

    def _refusal(self, error: OSError) -> str:
        return f"journal {self.path}: {error.strerror or error}; give a file that can be written"

    @classmethod
    def continued(cls, path: str | PathLike[str], kernel: Kernel) -> Journal:
        """Return a journal that continues an existing file at its end."""
        journal = cls.__new__(cls)
        journal._open(path, kernel, "a")
        return journal

    def close(self) -> None:
        """Close the file; no more entries are written."""
        closed(self.file)


def _plain(value: Any) -> Any:
    """Return a value in a type that JSON supports: an int for a NumPy integer, text for a fraction."""
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Fraction):
        return str(value)
    raise TypeError(repr(value))


def closed(file: TextIO) -> None:
    """Close a file; ignore an error in writing its last lines."""
    with suppress(OSError):
        file.close()


def replaced(path: str | PathLike[str]) -> bool:
    """Return whether a journal written to this path will replace an existing journal.

    Raises:
        BenchFileError: the file exists and is not a journal, so it must not be lost; or it is a FIFO.
    """
    place = Path(path)
    try:
        if place.is_fifo():  # opening it would wait for a reader
            raise BenchFileError(f"journal {path} is a FIFO; give a regular file")
        if not place.is_file() or not place.stat().st_size:
            return False
        with place.open("rb") as file:
            if file.read(len(FIRST)) == FIRST:
                return True
    except OSError as error:
        raise BenchFileError(f"journal {path}: {error.strerror or error}; give a file that can be written") from None
    raise BenchFileError(f"journal {path}: this file exists and is not a journal; name a new file")
