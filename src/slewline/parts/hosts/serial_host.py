"""A host computer that sends commands to modules on a serial line, in the form set by their straps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar, Self

from ...core.messages.calls import answering
from ...core.time.kernel import Kernel
from ...core.wires.serial import Straps
from ...errors import ChecksumError, Timeout
from .ends.strapped_uart import StrappedUart, straps_of
from .host import TO_ONE, Host
from .uart_host import UartHost

if TYPE_CHECKING:
    from ...core.chip import Chip
    from ...core.time.timebase import Time
    from ..base.request_queue import RequestQueue
    from .connection import Connection


class SerialHost(UartHost, Host):
    """A host computer on the serial line of one module, or of several modules that share the line.

    The host follows the straps of the selected module: rate, checksum, address.  `ask` sends a command and
    returns the answer.

    Args:
        baud: a fixed rate, used regardless of the straps; None: the module's rate.

    Attributes:
        received: the characters received, a bytearray.
        answers: the lines received since the last `ask` began.
        on_character: hook, called with each character received.
    """

    queue: RequestQueue
    uart: StrappedUart
    _for_users: ClassVar[tuple[str, ...]] = (
        *("write", "change_line", "faulty", "baud", "word", "answers", "straps", "space"),
    )

    def __init__(self, kernel: Kernel, name: str, chips: Sequence[Connection], *, baud: int | None = None) -> None:
        super().__init__(kernel, name, chips)
        self.uart = StrappedUart(self, chips, baud)
        self.answers, self.on_character = self.uart.answers, self.uart.on_character

    # --------------------------------------------------------------------------------------------------- the line
    @property
    def straps(self) -> Straps:
        """Straps of the selected module."""
        return self.uart.straps

    def to(self, chip: str | Chip | Connection) -> Self:
        super().to(chip)
        self.uart.straps = straps_of(self.chip)
        return self

    # -------------------------------------------------------------------------------------------------- out and back
    def send(self, data: str | bytes) -> None:
        """Queue characters to be sent unchanged: no address or checksum is added.

        Raises:
            UsageError: the text is not ASCII, or the data are neither text nor bytes.
        """
        self.write(data)

    @answering("host.ask()", TO_ONE)
    def ask(self, command: str, timeout: Time = "5 s") -> str:
        r"""Send a command, with address and checksum as strapped; let time pass until the answer, and return it.

        The answer is returned without checksum and carriage return; the lines of a program listing are separated by
        "\r".

        Raises:
            ChecksumError: the answer has a wrong checksum, or one of its characters has a parity or framing error.
            Timeout: no answer arrives in time; the message names the missing answer.
        """
        uart = self.uart
        uart.begin()
        before = uart.faulty
        self.write(uart.framed(command))
        try:
            self.queue.let_pass(uart.answered(command), f"an answer to {command!r}", timeout)
        except Timeout as error:
            if not (why := uart.far.disagreement):
                raise
            raise Timeout(f"{error}\n  {why}") from None
        if uart.faulty != before:
            raise ChecksumError(f"{self.name}: parity or framing error in the answer to {command!r}: {self.answers!r}")
        return "\r".join(map(uart.stripped, self.answers))
