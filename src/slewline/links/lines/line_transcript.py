r"""The transcript of a server: the data in both directions of every line, and events, in virtual time.

         0.012292 x  < F\r                          on line x, from the host to the module
         0.017729 x  > R\r                          from the module to the host
         0.020000 y  < 2 6c                         6c is written to register 2 of a chipset
         0.020001 y  > 0 5c                         5c is read from its register 0
         0.500000 x  ! 127.0.0.1:40522 has gone     connections, faults, findings, discarded data

Characters in one direction share a row, up to a carriage return or 64 characters.  The instant of
a row is that of its first character: towards the module, when the server received it; from the module,
when its last bit ended.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from contextlib import suppress
from os import PathLike
from typing import TextIO

from ...core.time.kernel import Kernel
from ...core.time.timebase import PS_PER_S
from ...errors import UsageError

LONGEST = 64  # characters of one line of the transcript
TO_CHIP, TO_HOST, EVENT = "<", ">", "!"


class TranscriptFile:
    """The transcript of a server, in a file; without a path, nothing is written.

    Args:
        path: the file, to which the transcript is appended; "-" is standard error.
        failed: called once, with a message, when the file cannot be written; the transcript ends there.

    Raises:
        UsageError: the file cannot be written, or is not regular (a FIFO would block without a reader).
    """

    def __init__(
        self,
        kernel: Kernel,
        path: str | PathLike[str] | None = None,
        failed: Callable[[str], object] = lambda _text: None,
    ) -> None:
        self.kernel, self.path, self.failed = kernel, path, failed
        self.file: TextIO | None = None
        self.open: dict[str, tuple[str, int, bytearray]] = {}  # by line: direction, instant, characters so far
        self.on_terminal = path == "-"
        self.reopen()

    def move(self, kernel: Kernel) -> None:
        """Use the times of another kernel from now on."""
        self.kernel = kernel

    def reopen(self) -> None:
        """Open the file for appending, if a path was given and the file is not open."""
        if self.path is None or self.file is not None:
            return
        if self.on_terminal:
            self.file = sys.stderr
            return
        if os.path.exists(self.path) and not os.path.isfile(self.path):
            raise UsageError(f"log {self.path} is not a regular file; give a file, or - for standard error")
        try:
            self.file = open(self.path, "a", encoding="ascii", buffering=1)  # noqa: SIM115
        except OSError as error:
            raise UsageError(f"log {self.path}: {error.strerror}; give a file that can be written") from None

    def characters(self, line: str, to: str, data: bytes) -> None:
        """Collect characters that a line has transferred in the direction `to` ("<" or ">"); write full rows."""
        if self.file is None:
            return
        for byte in data:
            direction, since, so_far = self.open.get(line, ("", 0, bytearray()))
            if direction != to:
                self.end(line)
                since, so_far = self.kernel.now, bytearray()
                self.open[line] = to, since, so_far
            so_far.append(byte)
            if byte == 0x0D or len(so_far) >= LONGEST:
                self.end(line)

    def end(self, line: str) -> None:
        """Write the characters of a line that have been collected so far."""
        if line in self.open:
            to, since, data = self.open.pop(line)
            self.write(since, line, to, data.decode("latin-1").encode("unicode_escape").decode("ascii"))

    def event(self, line: str, text: str) -> None:
        """Write an event on a line."""
        if self.file is not None:
            self.end(line)
            self.write(
                self.kernel.now, line, EVENT, " ".join(text.split()).encode("ascii", "backslashreplace").decode()
            )

    def write(self, ps: int, line: str, to: str, text: str) -> None:
        """Write one row of the transcript; on failure (e.g. a full disk), end the transcript, not the server."""
        if self.file is None:
            return
        try:
            self.file.write(f"{ps // PS_PER_S:>8}.{ps % PS_PER_S // 10**6:06d} {line} {to} {text}\n")
        except OSError as error:
            self._let_go()
            self.failed(f"log {self.path}: {error.strerror or error}; the transcript ends here")

    def _let_go(self) -> None:
        file, self.file = self.file, None
        if file is not None and not self.on_terminal:
            with suppress(OSError):  # the failure was reported
                file.close()

    def close(self) -> None:
        """Write the characters still collected, and close the file; standard error stays open."""
        for line in list(self.open):
            self.end(line)
        self._let_go()
