"""What hosts on a serial line have in common: they forget, rest and wait as their UART does."""

from __future__ import annotations

from ...core.time.inputs import from_outside
from ..base.request_queue import RequestQueue
from ..lines.host_uart import HostUart, OverUart


class UartHost(OverUart):
    """The side of a host that is its UART's; it stands before `Host` among the bases."""

    queue: RequestQueue
    uart: HostUart

    @from_outside
    def change_line(self, baud: int | str, bits: int, parity: str, stop: int | str) -> None:
        """Change rate and format, whatever those of the other end are.

        Args:
            baud: the rate, such as 9600 or "37.5"; sixteen times the rate must be whole hertz.
            bits: the number of data bits, 5 to 8.
            parity: "none", "odd" or "even".
            stop: the number of stop bits: 1, "1.5" or 2.

        Raises:
            UsageError: another rate or format.
        """
        self.uart.change_line(baud, bits, parity, stop)

    @from_outside
    def opened_at(self, baud: int) -> None:
        """Report a rate that a program has set on a port where it changes nothing, if on a cable it would."""
        self.uart.opened_at(baud)

    @from_outside
    def write(self, data: str | bytes, fault: str = "") -> None:
        """Queue characters to be sent unchanged, at the rate of the line.

        Args:
            data: the characters.
            fault: "parity", "framing" or "late": send every one of them with this fault.

        Raises:
            UsageError: text that is not ASCII, neither text nor bytes, or another fault.
        """
        self.uart.write(data, fault)

    def drop(self) -> None:
        """Forget what is queued; characters that are on the line already, and the command asked last, go on."""
        self.uart.drop("drop")
        self.queue.cancel_after(1, "drop()")

    def give_up(self) -> None:
        """Take back the last command, which was not answered in time."""
        self.uart.drop("give_up")

    def _rest(self) -> None:
        self.uart.rest()

    @property
    def idle(self) -> bool:
        """Is nothing queued, and nothing to be sent?"""
        return self.uart.idle and self.queue.idle

    @property
    def waiting(self) -> str:
        """What the host waits for, in words."""
        busy = self.queue.idle and not self.uart.idle
        return self.uart.waiting if busy else super().waiting  # type: ignore[misc]
