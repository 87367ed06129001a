"""Code shared by hosts on a serial line: dropping queued characters, freeing the line, reporting activity."""

from __future__ import annotations

from ..base.request_queue import RequestQueue
from ..lines.host_uart import HostUart, OverUart


class UartHost(OverUart):
    """Mixin for hosts with a UART; list it before `Host` among the base classes."""

    queue: RequestQueue
    uart: HostUart

    def drop(self) -> None:
        """Drop the queue, except for the request under way and characters that are already on the line."""
        self.uart.drop("drop")
        self.queue.cancel_after(1, "drop()")

    def give_up(self) -> None:
        """Drop the queued characters, because a command was not answered in time."""
        self.uart.drop("give_up")

    def _rest(self) -> None:
        self.uart.rest()

    @property
    def idle(self) -> bool:
        """True while no request is queued and no character is waiting to be sent."""
        return self.uart.idle and self.queue.idle

    @property
    def waiting(self) -> str:
        """Description of the host's current activity."""
        busy = self.queue.idle and not self.uart.idle
        return self.uart.waiting if busy else super().waiting  # type: ignore[misc]
