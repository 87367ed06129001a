"""What a line echoes: an adapter for two wires receives what it sends, and some modules and modems send it back.

    sent       V 2 CR
    comes      V 2 CR Y CR      the echo first, then the answer
    comes      Y CR V 2 CR      or the echo after the answer, or within the next one, where it is late

Dropped are lines that are exactly what was sent, in the order in which they were sent, for a time.  The beginning of
such a line is kept back until its end has come, or something else, which shows that it was none; nothing else is lost.
"""

from __future__ import annotations

END = 0x0D  # of a line
LATE_S = 0.5  # which an echo may come after the time that its characters take
ENOUGH = 2  # lines that come back: one might be an answer
SHORTEST = 2  # characters of a line that counts for that


class EchoFilter:
    """Separates the echo on a line from the answers.

    Args:
        drops: the line echoes: return what comes without its echo.  Else only notice what looks like one.

    Attributes:
        seen: lines that have come as they were sent.
    """

    def __init__(self, drops: bool) -> None:
        self.drops, self.seen = drops, 0
        self.until = 0.0  # from then on no echo of what was sent is expected
        self._wanted, self._kept = bytearray(), bytearray()  # what may still come back; the beginning of a line of it

    @property
    def shows(self) -> bool:
        """Return whether the line echoes, and that was not given as `drops`."""
        return not self.drops and self.seen >= ENOUGH

    @property
    def keeps(self) -> bool:
        """Return whether characters are kept back."""
        return bool(self._kept)

    def sent(self, data: bytes, now: float, seconds: float) -> None:
        """Record what goes out.

        Args:
            now: seconds, of any clock.
            seconds: that these characters take.
        """
        self._wanted += data
        self.until = max(self.until, now + LATE_S) + seconds

    def rest(self, data: bytes, now: float) -> bytes:
        """Return what has come without its echo, and what was kept back in vain."""
        if not self._wanted:
            return data
        found = bytearray()
        for byte in data:
            found += self._one(byte)
        if now > self.until:
            found += self._kept
            self._wanted.clear()
            self._kept.clear()
        return bytes(found) if self.drops else data

    def _one(self, byte: int) -> bytes:
        """Take a character; return those that are no echo."""
        self._kept.append(byte)
        found = bytearray()
        while not self._wanted.startswith(self._kept):
            found.append(self._kept.pop(0))
        if self._kept and (byte == END or len(self._kept) == len(self._wanted)):
            self.seen += len(self._kept) >= SHORTEST
            del self._wanted[: len(self._kept)]
            self._kept.clear()
        return bytes(found)
