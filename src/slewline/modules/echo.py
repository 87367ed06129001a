"""The echo on a line: a two-wire adapter receives its own output; some modules and modems return all data.

    sent       V 2 CR
    received   V 2 CR Y CR      the echo first, then the answer
    received   Y CR V 2 CR      or a late echo after the answer, or within the next answer

For a limited time after lines have been sent, received lines that exactly equal them, in the same order,
are dropped.  The beginning of a line that may be an echo is held back until the rest of it arrives, or
until other characters or the end of that time show that it is not an echo; no other data is dropped.
"""

from __future__ import annotations

END = 0x0D  # end of a line
LATE_S = 0.5  # longest delay of an echo after the time of its characters
ENOUGH = 2  # number of returned lines: a single line might be an answer
SHORTEST = 2  # minimum length of a returned line that counts


class EchoFilter:
    """A filter that separates the echo on a line from the answers.

    Args:
        drops: True if the line echoes; the echo is then dropped from the received data.  If False,
            an apparent echo is only detected.

    Attributes:
        seen: the number of received lines that equal sent ones, and have at least `SHORTEST` characters.
    """

    def __init__(self, drops: bool) -> None:
        self.drops, self.seen = drops, 0
        self.until = 0.0  # end of the time for the echo of sent lines
        self._wanted, self._kept = bytearray(), bytearray()  # lines that may still come back; the start of one of them

    @property
    def shows(self) -> bool:
        """True if `drops` is False, but the line appears to echo."""
        return not self.drops and self.seen >= ENOUGH

    @property
    def keeps(self) -> bool:
        """True while received characters are held back because they may be the start of an echo."""
        return bool(self._kept)

    def sent(self, data: bytes, now: float, seconds: float) -> None:
        """Record sent characters, which may come back as an echo.

        Args:
            now: the time in seconds, on the clock that is also used for `rest`.
            seconds: the time that these characters take on the line.
        """
        self._wanted += data
        self.until = max(self.until, now + LATE_S) + seconds

    def rest(self, data: bytes, now: float) -> bytes:
        """Return received data without the echo, preceded by held-back characters that proved not to be an echo.

        If `drops` is False, the data is returned unchanged.
        """
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
        """Add a received character; return the characters that are now known not to be an echo."""
        self._kept.append(byte)
        found = bytearray()
        while not self._wanted.startswith(self._kept):
            found.append(self._kept.pop(0))
        if self._kept and (byte == END or len(self._kept) == len(self._wanted)):
            self.seen += len(self._kept) >= SHORTEST
            del self._wanted[: len(self._kept)]
            self._kept.clear()
        return bytes(found)
