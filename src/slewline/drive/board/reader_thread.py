"""A separate thread that reads a terminal, so that the loop of the drive never blocks.

Reading or polling a Linux terminal waits for a kernel worker that delivers the bytes.  The worker has
the priority of ordinary processes, whatever the reader's priority; on a busy machine, a wait of half a
second was measured.
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
    """The input of a terminal, read through a pipe that never blocks.

    Args:
        terminal: the terminal's descriptor, which the caller closes after `close`.
    """

    def __init__(self, terminal: int) -> None:
        self._terminal = terminal
        self._failure: OSError | None = None
        self._out, self._into = os.pipe()
        self._over, self._end = os.pipe()  # `_end` becomes readable when the other end is closed
        os.set_blocking(self._out, False)
        self._thread = Thread(target=self._carry, name="reader of a board", daemon=True)
        self._thread.start()

    def _carry(self) -> None:
        """Copy bytes from the terminal to the pipe until the terminal fails or the reader is closed."""
        try:
            while self._over not in (ready := select([self._terminal, self._over], [], [])[0]):
                with suppress(BlockingIOError):
                    data = os.read(ready[0], CHUNK)
                    if not data:
                        raise OSError(errno.EIO, "the terminal was closed")
                    os.write(self._into, data)
        except OSError as error:
            self._failure = error
        os.close(self._into)
        os.close(self._over)

    def fileno(self) -> int:
        """Return the descriptor of the pipe's reading end, for which a loop can wait."""
        return self._out

    def read(self) -> bytes:
        """Return the bytes received since the last call.

        Raises:
            OSError: the terminal is gone, and all earlier bytes have been read.
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
