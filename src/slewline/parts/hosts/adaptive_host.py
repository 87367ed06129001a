"""A host computer on the serial line of a chip that detects the baud rate."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from ...core.messages.calls import answering
from ...core.time.inputs import from_outside
from ...errors import Timeout
from .ends.adaptive_uart import AdaptiveUart
from .host import TO_ONE, Host
from .uart_host import UartHost

if TYPE_CHECKING:
    from ...core.time.kernel import Kernel
    from ...core.time.timebase import Time
    from ..base.request_queue import RequestQueue
    from .connection import Connection


class AdaptiveHost(UartHost, Host):
    """A host computer on the serial line of one chip that detects the baud rate.

    While the chip does not know the rate, `send` and `ask` (not `write`) first send two carriage returns.

    Args:
        baud: the rate of the host; None: 9600.
        strapped: the fixed rate of the chip; None: the chip detects the rate.
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
        self.on_character = self.uart.on_character

    @from_outside
    def heed(self, on: bool | None) -> None:
        """Obey CTS from now on (True), ignore it (False), or decide by the mode commands that the host has sent (None).

        Raises:
            UsageError: `on` is not True, False or None.
        """
        self.uart.cut()
        self.uart.control.heed(on, self)

    # -------------------------------------------------------------------------------------------------- out and back
    def send(self, data: str | bytes) -> None:
        """Queue characters, after two carriage returns if the chip does not know the rate.

        Raises:
            UsageError: the text is not ASCII, or the data are neither text nor bytes.
        """
        self.uart.send(data)

    @answering("host.ask()", TO_ONE)
    def ask(self, command: str, timeout: Time = "5 s") -> str | bytes:
        """Send a query such as "? P", and return the chip's answer on the line: text, or bytes in binary mode.

        Raises:
            UsageError: the command has no answer.
            Timeout: no answer arrives in time; the chip's mode register may direct its answers to the bus.
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
