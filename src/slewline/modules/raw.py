r"""A file with all raw characters on a line, recorded before they are interpreted in any way.

    ; slewline raw 1: us since 2026-11-29 17:20:00 UTC, > to the module or < from it, characters (\r, \n, \\ and \xNN)
               0 = 9600 7O2
            1042 > V2\r
           18231 < V70\r\n

Each line is written immediately.  However, no file is created until a character has been received; lines
recorded earlier are written then.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from contextlib import suppress
from os import PathLike
from pathlib import Path
from time import gmtime, monotonic_ns, strftime
from typing import BinaryIO

LARGEST = 16_000_000  # bytes of a file
KEPT_LINES = 1000  # bytes kept of the data sent before the first character arrived
HEAD = r"; slewline raw 1: us since {}, > to the module or < from it, characters (\r, \n, \\ and \xNN)"
FULL = f"; {LARGEST // 1_000_000} MB: the rest is not recorded"


class RawRecord:
    """A recorder of all characters on a serial line, in a file.

    Args:
        path: the file to create; it must not exist.
        failed: called once, with a message, if the recording ends early.

    Attributes:
        path, failed: the arguments.
        is_kept: whether the file has been created.
    """

    def __init__(self, path: str | PathLike[str], failed: Callable[[str], object] = lambda _text: None) -> None:
        self.path, self.failed = Path(path), failed
        self.is_kept = False
        self._began_ns = monotonic_ns()
        self._size = 0
        self._file: BinaryIO | None = None
        self._over = False
        head = HEAD.format(strftime("%Y-%m-%d %H:%M:%S UTC", gmtime()))
        self._waiting: deque[str] = deque([head], KEPT_LINES)

    def sent(self, data: bytes, ns: int) -> None:
        """Record characters that were sent at an instant (ns of `time.monotonic_ns`)."""
        self._line(ns, ">", _shown(data))

    def came(self, data: bytes, ns: int) -> None:
        """Record characters that were received at an instant (ns of `time.monotonic_ns`)."""
        if data and self._file is None and not self._over:
            self._open()
        if data:
            self._line(ns, "<", _shown(data))

    def note(self, text: str) -> None:
        """Record the new settings of the line, given as text."""
        self._line(monotonic_ns(), "=", text)

    def close(self) -> None:
        """Close the file."""
        self._over = True
        if self._file is not None:
            with suppress(OSError):  # every line has been written, or has failed, already
                self._file.close()
            self._file = None

    def _line(self, ns: int, mark: str, text: str) -> None:
        line = f"{(ns - self._began_ns) // 1000:12} {mark} {text}"
        if self._file is None:
            self._waiting.append(line)
        elif self._size + len(line) + len(FULL) + 2 > LARGEST:
            self._write(FULL)
            self._end("16 MB are full")
        else:
            self._write(line)

    def _open(self) -> None:
        try:
            self._file = self.path.open("xb", buffering=0)
        except OSError as error:
            self._end(error.strerror or str(error))
            return
        self.is_kept = True
        for line in self._waiting:
            self._write(line)
        self._waiting.clear()

    def _write(self, line: str) -> None:
        if self._file is None:
            return
        left = memoryview(line.encode("ascii") + b"\n")
        try:
            while left:
                left = left[self._file.write(left) :]
        except OSError as error:
            with suppress(OSError):
                self._file.truncate(self._size)
            self._end(error.strerror or str(error))
            return
        self._size += len(line) + 1

    def _end(self, why: str) -> None:
        self.close()
        self.failed(f"{self.path}: {why}; {'the record ends here' if self.is_kept else 'characters are not recorded'}")


def _shown(data: bytes) -> str:
    r"""Return bytes as printable ASCII: \r, \n, \t and \\ as shown here, other unprintable bytes as \xNN."""
    return data.decode("latin-1").encode("unicode_escape").decode("ascii")
