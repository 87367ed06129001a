"""A byte stream to the outside: a socket that never blocks, with a bounded queue on the way out.

A reader that does not read costs `QUEUE` bytes of memory and no more: what comes on top is dropped and counted, as a
serial line drops what no host reads.  The other way round, a stream reads only as much as its owner has room for, so
that a writer without end is held up by its own system.
"""

from __future__ import annotations

import socket
from collections.abc import Callable

from .loop import Loop
from .system import Descriptor

QUEUE = 1 << 16
CHUNK = 4096


class SocketStream:
    """Bytes in and out of a socket, which belongs to the caller.

    Args:
        end: the socket, which does not block from now on, or a descriptor with the face of one.
        take: called with what has come in.
        gone: called once, with the reason, when the other side has hung up.
        ended: called when nothing more will come; without it, the other side has hung up then.  With it, bytes still
            go out, until `finish`; and what a host sends that reads no more is taken to the end.
        room: how many bytes may be read now; at 0 nothing is read until `resume`, or until the queue is sent.
        queue: bytes that may wait for a reader.
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
        self.ahead = bytearray()  # what was read before there was room for it
        self.dropped = 0
        self.reading = self.open = True
        self.dirty = self.blocked = self.at_end = self.finishing = self.deaf = False
        self.why = "hung up"
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
        except OSError as error:  # after the last byte that has come, never before it
            self.why = error.strerror or str(error)
            found = None
        if found is None:
            self._end()
        elif found:
            self.take(found)

    def read_now(self) -> None:
        """Read what is there in this moment, if there is room for it; the loop would do so in its turn."""
        if self.open and self.reading and not self.at_end:
            self._read()

    def fetch(self, room: int) -> bytes | None:
        """Read what is there; None: the other side has hung up."""
        return self.end.recv(room) or None

    def _end(self) -> None:
        if self.ended is None:
            self.hang_up(self.why)
            return
        self.at_end, self.reading = True, False
        self._watch()
        self.ended()

    def resume(self) -> None:
        """Read on: there is room again."""
        if self.open and not self.reading and not self.at_end:
            self.reading = True
            self._watch()
            self._go_on()

    def _go_on(self) -> None:
        """What was read ahead is not reported by the system: see to it in another turn."""
        if self.ahead and self.reading:
            self.loop.ask(self._read_on)

    def _read_on(self) -> None:
        if self.open and self.reading and self.ahead:
            self._read()

    def read_ahead(self, most: int) -> bool:
        """Read all that is here, at most so many bytes; return whether that is all there will be, or more than that."""
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
        """Send bytes, at the end of this turn; returns how many had to be dropped, because no host reads."""
        space = self.queue - len(self.outgoing)
        dropped = max(len(data) - space, 0) if self.open and not self.deaf else len(data)
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
            self.deafen(error.strerror or str(error))
            return
        if blocked is not self.blocked:
            self.blocked = blocked
            self._watch()
        if not blocked:
            self.resume()
            if self.finishing:
                self.hang_up(self.why)

    # ---------------------------------------------------------------------------------------------------------- end
    def deafen(self, why: str) -> None:
        """Drop what would be sent from now on; what the other side has sent before is still to be read."""
        self.why, self.deaf, self.blocked = why, True, False
        self.outgoing.clear()
        if self.ended is None or self.at_end:
            self.hang_up(why)
            return
        self._watch()
        self.resume()

    def finish(self) -> None:
        """Hang up as soon as everything is sent."""
        self.finishing = True
        if not self.outgoing:
            self.hang_up(self.why)

    def hang_up(self, why: str) -> None:
        """Close, and report that the other side has gone."""
        if self.open:
            self.close()
            self.gone(why)

    def close(self) -> None:
        """Stop reading and writing; the socket itself is the caller's."""
        if self.open:
            self.open = False
            self.loop.watch(self.fd)
