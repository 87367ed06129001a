"""A host computer on a serial line that finds its rate."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from ...core.time.inputs import from_outside
from ...errors import Timeout
from .ends.adaptive_uart import AdaptiveUart
from .host import Host
from .uart_host import UartHost

if TYPE_CHECKING:
    from ...core.time.kernel import Kernel
    from ...core.time.timebase import Time
    from ..base.request_queue import RequestQueue
    from .connection import Connection


class AdaptiveHost(UartHost, Host):
    """A host computer on the serial line of one chip that finds the rate.

    `send` and `ask` begin with two carriage returns as long as the chip does not know the rate; `write` sends
    characters as they are.

    Args:
        baud: the rate at which it speaks.
        strapped: the rate that the chip has without looking for one; None: it looks.
    """

    queue: RequestQueue
    uart: AdaptiveUart
    _for_users: ClassVar[tuple[str, ...]] = ("write", "change_line", "faulty", "baud", "word", "heed")
    wiring = MappingProxyType({"txd": "serial_in", "rxd": "serial_out", "cts": "flow"})

    def __init__(
        self,
        kernel: Kernel,
        name: str,
        chips: Sequence[Connection],
        *,
        baud: int | None = None,
        strapped: int | None = None,
    ) -> None:
        super().__init__(kernel, name, chips)
        self.uart = AdaptiveUart(self, chips[0], baud, strapped)
        self.received: bytearray = self.uart.received
        self.on_character = self.uart.on_character

    @from_outside
    def change_line(self, baud: int | str, bits: int, parity: str, stop: int | str) -> None:
        """Take another rate or format."""
        self.uart.change_line(baud, bits, parity, stop)

    @from_outside
    def opened_at(self, baud: int) -> None:
        """Take notice of a rate that changes nothing: the chip would have found it."""
        self.uart.opened_at(baud)

    @from_outside
    def heed(self, on: bool | None) -> None:
        """Go by CTS from now on (True), or not (False), or as the host's own mode commands have it (None).

        Raises:
            UsageError: none of the three.
        """
        self.uart.control.heed(on, self)

    # -------------------------------------------------------------------------------------------------- out and back
    @from_outside
    def write(self, data: str | bytes, fault: str = "") -> None:
        """Queue characters as they are; they go out one after the other.

        Args:
            fault: "parity", "framing" or "late": every one of them goes out with this fault.
        """
        self.uart.write(data, fault)

    def send(self, data: str | bytes) -> None:
        """Queue characters; two carriage returns go first if the chip does not know the rate.

        Raises:
            UsageError: text that is not ASCII, or neither text nor bytes.
        """
        self.uart.send(data)

    def ask(self, command: str, timeout: Time = "5 s") -> str | bytes:
        """Send a query such as "? P", and return what the chip answers on the line: text, or bytes in binary mode.

        Raises:
            UsageError: a command that is not answered.
            Timeout: no answer; the mode register may send it elsewhere.
        """
        uart = self.uart
        query = uart.shadow.query(self.name, command)
        since = uart.recent.total

        def answered() -> str | bytes | None:
            return query.answered(self.received, uart.recent.place(since))

        self.send(uart.shadow.sent(command))
        try:
            self.queue.let_pass(lambda: answered() is not None, f"an answer to {command!r}", timeout)
        except Timeout as error:
            if not (why := "\n  ".join(filter(None, (uart.far.disagreement, uart.control.why_silent())))):
                raise
            raise Timeout(f"{error}\n  {why}") from None
        return answered() or ""
