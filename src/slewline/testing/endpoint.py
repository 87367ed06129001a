"""The program's end of a serial line, which holds the received characters and waits for more.

Each serial port library has a class that wraps this end (in protocol_slewline and for_serialx).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from ..core.messages.whole import counted
from ..core.time.timebase import PS_PER_S
from ..core.wires.serial import PARITIES, CharacterFormat, bit_clock
from ..errors import Timeout, UsageError
from .rig import NAMED, Rig, WallClockTime, never, seconds

STOPS: dict[float, int | str] = {1: 1, 1.5: "1.5", 2: 2}
SILENCE_PS = PS_PER_S  # a line that has been quiet for this long is taken to remain quiet


def word_of(where: str, baud: int, bits: int, parity: str, stop: float, xonxoff: bool) -> CharacterFormat:
    """Return the character format that a port's settings define.

    Raises:
        UsageError: there is a setting that no line of slewline supports.
    """
    if xonxoff:
        raise UsageError(
            f"{where}: xonxoff=True; a checksum byte may equal XON or XOFF (as in the line 'R1'); allowed False"
        )
    if parity not in PARITIES:
        raise UsageError(f"{where}: parity {parity!r}; allowed {', '.join(PARITIES)}")
    bit_clock(baud, where)
    return CharacterFormat(bits, PARITIES[parity], STOPS[stop])


class SerialEndpoint:
    """The program's end of a rig's serial line.

    Args:
        where: the program's name for the port, for messages.
        program: the name of the program in the transcript.
        gone: the exception class with which the serial port library reports that a port has gone.
    """

    lost = ""  # why the port has gone; "" if it has not

    def __init__(self, rig: Rig, where: str, program: str, gone: type[Exception] = OSError) -> None:
        self.rig, self.where, self.gone = rig, where, gone
        self.buffer = bytearray()
        self.connected, self.cancelled = True, False
        self.notify: Callable[[], object] | None = None  # called when characters have arrived
        rig.resume()
        rig.do(lambda: rig.line.attach(program, self._arrived, lambda: None))
        rig.program = self

    def lose(self, why: str) -> None:
        """Record that the port has gone: from now on, every call by the program fails, except closing the port."""
        self.lost, self.connected, self.rig.program = why, False, None
        self.rig.line.detach(why)
        if self.notify is not None:
            self.notify()

    def error(self) -> Exception:
        """Return the exception for a port that has gone."""
        return self.gone(f"{self.where}: the port is gone ({self.lost}); close it, and open it when it is back")

    def check(self) -> None:
        """Raise an exception if the port has gone."""
        if self.lost:
            raise self.error()

    def hang_up(self) -> None:
        """Release the line; the state of the module is unchanged, and the module's time stops."""
        self.rig.do(self._hang_up)
        if self.rig not in NAMED.values():
            self.rig.close()

    def _hang_up(self) -> None:
        if self.connected:
            self.rig.line.detach("closed")
            self.rig.program = None
        self.rig.leave()
        self.connected = False

    def change_line(self, baud: int, word: CharacterFormat) -> None:
        """Use the given baud rate and character format, starting with the next character."""
        host = self.rig.host
        if (baud, word) != (host.baud, host.word) or host.uart.fixed_baud is None:
            self.rig.do(lambda: host.change_line(baud, word.bits, word.parity, word.stop))

    # -------------------------------------------------------------------------------------------------------- reading
    def _arrived(self, data: bytes) -> int:
        self.buffer += data
        if self.notify is not None:
            self.notify()
        return 0

    def read(self, size: int, timeout: float | None, gap: float | None = None, least: int | None = None) -> bytes:
        """Return up to `size` characters, or fewer when the timeout (s) expires or the read is cancelled.

        Args:
            gap: a pause between two characters (s) that also ends the read.
            least: the number of characters after which the read does not wait for more; by default `size`.

        Raises:
            Timeout: `timeout` and `gap` are None, the URL states no rate, and no more characters can arrive.
        """
        least = size if least is None else min(least, size)
        if len(self.buffer) < least:
            if timeout == 0:
                self.rig.poll()
            else:
                self._gather(least, timeout, gap)
        data = bytes(self.buffer[:size])
        del self.buffer[: len(data)]  # more may have arrived while another thread lets time pass
        return data

    def _gather(self, size: int, timeout: float | None, gap: float | None) -> None:
        now = self.rig.present()
        end = None if timeout is None else now + seconds(timeout)
        while (had := len(self.buffer)) < size:
            self.check()
            if self.cancelled or not self.connected:
                self.cancelled = False
                return
            limit = SILENCE_PS if end is None else max(end - self.rig.pace.kernel.now, 0)
            pause = None if gap is None or not had else seconds(gap)
            if self.rig.wait(partial(self._has_more, had), limit if pause is None else min(limit, pause)):
                continue
            if end is not None or pause is not None:
                self.rig.do(self._check_ends)
                return
            self._complain(size)

    def _check_ends(self) -> None:
        """Report incomplete commands if the line is quiet; called when no answer has arrived in time."""
        if self.rig.line.quiet():
            self.rig.bench.conclude()

    def _has_more(self, than: int) -> bool:
        return len(self.buffer) > than or self.cancelled or not self.connected

    def cancel(self) -> None:
        """Cancel a read that waits in another thread or, if there is none, the next read that would wait."""
        self.rig.do(self._cancel)

    def _cancel(self) -> None:
        self.cancelled = True

    def _complain(self, size: int) -> None:
        """Raise Timeout after a long wait for `size` characters, unless more characters may still arrive."""
        if not isinstance(self.rig.pace, WallClockTime) and self.rig.line.quiet():
            why = "; ".join(filter(None, (self.rig.chip.waiting, self.rig.host.uart.far.disagreement)))
            raise Timeout(
                f"{self.where}: read({size}) without a timeout received {counted(len(self.buffer), 'byte')}, "
                f"and no more can arrive ({why}); set a timeout on the port or, if another thread writes, "
                "set a rate in its URL"
            )

    # -------------------------------------------------------------------------------------------------------- writing
    def write(self, data: bytes) -> int:
        """Queue characters and return their number; they are sent as fast as the line allows while time passes."""
        self.rig.do(lambda: self._send(data))
        return len(data)

    def _send(self, data: bytes) -> None:
        self.rig.present()
        self.rig.line.take(data)

    def flush(self) -> None:
        """Wait until everything has been sent."""
        while not self.rig.wait(self.sent, PS_PER_S):
            pass

    def sent(self) -> bool:
        """Return whether everything has been sent, or nothing more can be sent."""
        return bool(self.lost) or self.rig.host.idle

    def space(self, on: bool) -> None:
        """Set the line to space (`on`) or back to mark, once all written characters have been sent."""
        self.flush()
        self.rig.do(lambda: self.rig.host.space(on))

    def sleep(self, duration: float) -> None:
        """Let `duration` seconds of virtual time pass."""
        self.rig.wait(never, seconds(duration))
