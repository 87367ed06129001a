"""A byte stream to the outside world: a socket that never blocks, with a bounded output queue.

A client that does not read costs at most `QUEUE` bytes of memory: further output is dropped and counted,
as a serial line drops bytes that no host reads.  In the other direction, a stream reads only as many
bytes as its owner has room for, so that an endless sender is blocked by its own system.
"""

from __future__ import annotations

import socket
from collections.abc import Callable

from .loop import Loop
from .system import Descriptor

QUEUE = 1 << 16
CHUNK = 4096


class SocketStream:
    """The input and output of a socket; the socket belongs to the caller.

    Args:
        end: the socket, which is made non-blocking, or a descriptor with the methods of a socket.
        take: called with received bytes.
        gone: called once, with the reason, when the other side has disconnected.
        ended: called when the other side has sent its last byte; output then continues until `finish`.  If the
            other side stops reading, bytes that it has already sent are still received.  If `ended` is None,
            the other side counts as disconnected as soon as it stops sending or reading.
        room: returns the number of bytes that may be read now; 0 stops reading until `resume`, or until the
            output queue is sent.
        queue: the size of the output queue, in bytes.
    """

    def __init__(
        self,
        loop: Loop,
        end: socket.socket | Descriptor,
        take: Callable[[bytes], object],
        gone: Callable[[str], object],
        room: Callable[[], int] = lambda: CHUNK,
        queue: int = QUEUE,
        ended: Callable[[], object] | None = None,
    ) -> None:
        self.loop, self.end, self.take, self.gone, self.room = loop, end, take, gone, room
        self.outgoing, self.queue, self.ended = bytearray(), queue, ended
        self.ahead = bytearray()  # bytes read before there was room for them
        self.dropped = 0
        self.reading = self.open = True
        self.dirty = self.blocked = self.at_end = self.finishing = self.is_shut = False
        self.why = "closed the connection"
        self.fd = end.fileno()
        if isinstance(end, socket.socket):
            end.setblocking(False)
        self._watch()

    def _watch(self) -> None:
        self.loop.watch(self.fd, self._read if self.reading else None, self._flush if self.blocked else None)

    # -------------------------------------------------------------------------------------------------------- input
    def _read(self) -> None:
        room = min(self.room(), CHUNK)
        if room <= 0:
            self.reading = False
            self._watch()
            return
        if self.ahead:
            data = bytes(self.ahead[:room])
            del self.ahead[:room]
            self.take(data)
            self._go_on()
            return
        try:
            found = self.fetch(room)
        except BlockingIOError:
            return
        except OSError as error:  # after the last received byte, never before it
            self.why = error.strerror or str(error)
            found = None
        if found is None:
            self._end()
        elif found:
            self.take(found)

    def read_now(self) -> None:
        """Read available bytes now, if there is room, without waiting for the loop."""
        if self.open and self.reading and not self.at_end:
            self._read()

    def fetch(self, room: int) -> bytes | None:
        """Read and return available bytes, at most `room`; None if the other side has disconnected."""
        return self.end.recv(room) or None

    def _end(self) -> None:
        if self.ended is None:
            self.hang_up(self.why)
            return
        self.at_end, self.reading = True, False
        self._watch()
        self.ended()

    def resume(self) -> None:
        """Continue to read, because there is room again."""
        if self.open and not self.reading and not self.at_end:
            self.reading = True
            self._watch()
            self._go_on()

    def _go_on(self) -> None:
        """Let the loop continue with the bytes read ahead, because the system no longer reports them as readable."""
        if self.ahead and self.reading:
            self.loop.ask(self._read_on)

    def _read_on(self) -> None:
        if self.open and self.reading and self.ahead:
            self._read()

    def read_ahead(self, most: int) -> bool:
        """Read available bytes before the owner has room for them, until about `most` bytes are stored.

        Returns:
            True if at least `most` bytes are stored, or if the other side has ended the stream.
        """
        over = False
        try:
            while not over and len(self.ahead) < most:
                data = self.end.recv(QUEUE)
                self.ahead += data
                over = not data
        except BlockingIOError:
            pass
        except OSError:
            over = True
        self._go_on()
        return over or len(self.ahead) >= most

    # ------------------------------------------------------------------------------------------------------- output
    def write(self, data: bytes) -> int:
        """Queue bytes to be sent at the end of this turn; return how many are dropped (queue full or stream shut)."""
        space = self.queue - len(self.outgoing)
        dropped = max(len(data) - space, 0) if self.open and not self.is_shut else len(data)
        self.outgoing += data[: len(data) - dropped]
        self.dropped += dropped
        if self.outgoing and not (self.dirty or self.blocked):
            self.dirty = True
            self.loop.dirty.append(self._flush)
        return dropped

    def _flush(self) -> None:
        self.dirty = False
        if not self.open:
            return
        blocked = False
        try:
            while self.outgoing and not blocked:
                sent = self.end.send(self.outgoing)
                del self.outgoing[:sent]
        except BlockingIOError:
            blocked = True
        except OSError as error:
            self.shut(error.strerror or str(error))
            return
        if blocked is not self.blocked:
            self.blocked = blocked
            self._watch()
        if not blocked:
            self.resume()
            if self.finishing:
                self.hang_up(self.why)

    # ---------------------------------------------------------------------------------------------------------- end
    def shut(self, why: str) -> None:
        """Drop queued and later output; if `ended` is given, still read bytes already sent by the other side."""
        self.why, self.is_shut, self.blocked = why, True, False
        self.outgoing.clear()
        if self.ended is None or self.at_end:
            self.hang_up(why)
            return
        self._watch()
        self.resume()

    def finish(self) -> None:
        """Close the stream as soon as all queued bytes are sent."""
        self.finishing = True
        if not self.outgoing:
            self.hang_up(self.why)

    def hang_up(self, why: str) -> None:
        """Close the stream, and report that the other side has disconnected."""
        if self.open:
            self.close()
            self.gone(why)

    def close(self) -> None:
        """Stop reading and writing; the caller closes the socket."""
        if self.open:
            self.open = False
            self.loop.watch(self.fd)
