"""What hosts on a serial line have in common: they forget, rest and wait as their UART does."""

from __future__ import annotations

from ..base.request_queue import RequestQueue
from ..lines.host_uart import HostUart, OverUart


class UartHost(OverUart):
    """The side of a host that is its UART's; it stands before `Host` among the bases."""

    queue: RequestQueue
    uart: HostUart

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
