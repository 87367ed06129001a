"""A terminal is read by a thread of its own, so that a turn of the drive waits for nothing.

Who reads a terminal of Linux, or asks whether it can be read, waits for a worker of the kernel that brings the bytes.
The worker has the priority of usual processes, whoever waits; beside many of them that took half a second.
"""

from __future__ import annotations

import errno
import os
from contextlib import suppress
from select import select
from threading import Thread

CHUNK = 4096
END_S = 1.0


class PortReader:
    """What comes on a terminal, as the end of a pipe that never waits.

    Args:
        terminal: its descriptor, which stays the caller's, and open until `close`.
    """

    def __init__(self, terminal: int) -> None:
        self._terminal = terminal
        self._failure: OSError | None = None
        self._out, self._into = os.pipe()
        self._over, self._end = os.pipe()  # the former can be read when the latter is closed
        os.set_blocking(self._out, False)
        self._thread = Thread(target=self._carry, name="reader of a board", daemon=True)
        self._thread.start()

    def _carry(self) -> None:
        """Carry bytes until the terminal fails, or nobody wants them."""
        try:
            while self._over not in (ready := select([self._terminal, self._over], [], [])[0]):
                with suppress(BlockingIOError):
                    data = os.read(ready[0], CHUNK)
                    if not data:
                        raise OSError(errno.EIO, "the terminal has been hung up")
                    os.write(self._into, data)
        except OSError as error:
            self._failure = error
        os.close(self._into)
        os.close(self._over)

    def fileno(self) -> int:
        """Return the end of the pipe, for a loop that waits."""
        return self._out

    def read(self) -> bytes:
        """Return what has come since the last call.

        Raises:
            OSError: the terminal is gone, and all that came before has been read.
        """
        with suppress(BlockingIOError):
            data = os.read(self._out, CHUNK)
            if not data:
                raise self._failure or OSError(errno.EBADF, "closed")
            return data
        return b""

    def close(self) -> None:
        """End the thread."""
        os.close(self._end)
        os.close(self._out)
        self._thread.join(END_S)
