"""A host on a bidirectional bus."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ...core.messages.calls import answering
from ...core.time.inputs import from_outside
from ...core.wires.pin import Condition, GotCondition
from ...errors import Timeout, UsageError
from ..base.part import served
from ..base.written_data import Data, as_bytes
from .ends.flow_port import FlowPort
from .host import TO_ONE, Host

if TYPE_CHECKING:
    from ...core.time.kernel import Kernel
    from ...core.time.timebase import Time
    from ..base.request_queue import Request
    from .connection import Connection


class FlowHost(Host):
    """A host computer on the parallel bus of one chip.

    Args:
        delay_ps: the time that the host's program takes before each byte, ps.

    Attributes:
        received: the bytes of the chip's messages.
    """

    _for_users: ClassVar[tuple[str, ...]] = (
        "heed",
        "prefix",
        "sent",
    )

    def __init__(self, kernel: Kernel, name: str, chips: Sequence[Connection], delay_ps: int = 0) -> None:
        super().__init__(kernel, name, chips)
        self.port = FlowPort(chips[0], self, self.queue, delay_ps)
        self.received: bytearray = self.port.received

    def rewired(self) -> None:
        """Start to receive, now that the host is wired."""
        self.port.listen()

    @property
    def _begun(self) -> bool:
        self.port.catch_up()
        return super()._begun

    @property
    def sent(self) -> int:
        """The number of bytes sent so far, empty handshakes not counted."""
        return self.port.all_sent

    @property
    def idle(self) -> bool:
        """True while nothing is queued and no message from the chip is being read."""
        return not self.port.taken and not self.port.offered and self.queue.idle

    def _rest(self) -> None:
        self.port.rest()

    # ------------------------------------------------------------------------ the queue, which is what a journal keeps
    @from_outside
    def write(self, chip: str, data: Sequence[int]) -> None:
        """Queue bytes to be sent to the chip with the given name."""
        served(self.name, self.chips, chip)
        data = as_bytes(self.name, data)
        self.input("write", chip, data)
        if data:
            self.queue.post(f"sending to {chip}", lambda: self.port.send(data))

    @from_outside
    def query(self, chip: str, command: str) -> Request[str | bytes]:
        """Queue a query to a chip; the mode at the time of sending decides whether it is sent as text or in binary."""
        served(self.name, self.chips, chip)
        self.port.shadow.query(self.name, command)
        self.input("query", chip, command)

        async def ask() -> str | bytes:
            shadow = self.port.shadow
            return await self.port.ask(shadow.sent(command), shadow.query(self.name, command))

        return self.queue.submit(f"querying {chip} with {command!r}", ask)

    @from_outside
    def heed(self, on: bool | None) -> None:
        """Obey FPL from now on (True), ignore FPL (False), or decide by the host's own mode commands (None).

        Raises:
            UsageError: `on` is not True, False or None.
        """
        self.port.control.heed(on, self)

    @from_outside
    def prefix(self, on: bool) -> None:
        """Begin every command with the empty handshake (True, the default), or directly with its letter (False).

        Raises:
            UsageError: `on` is neither True nor False.
        """
        if not isinstance(on, bool):
            raise UsageError(f"{self.name}: prefix({on!r}); allowed True, False")
        self.input("prefix", on)
        self.port.empty_first = on

    # -------------------------------------------------------------------------------------------------- out and back
    def send(self, data: str | bytes) -> None:
        """Queue bytes, which are sent as fast as the handshake allows; no time passes in the call.

        Raises:
            UsageError: the text is not ASCII, or the data are neither text nor bytes.
        """
        self.write(self.chip.name, as_bytes(self.name, data))

    def got(self, data: Data) -> Condition:
        """Return a condition for `bench.run_until`: these bytes have arrived in messages, consecutively."""
        return GotCondition(self.name, self.received, as_bytes(self.name, data))

    @answering("host.ask()", TO_ONE)
    def ask(self, command: str, timeout: Time = "5 s") -> str | bytes:
        """Send a query such as "? P", and return the chip's answer on the bus: text, or bytes in binary mode.

        Raises:
            UsageError: the command has no answer.
            Timeout: no answer arrives in time; the mode register may direct answers to the serial line.
        """
        try:
            return self.queue.result(self.query(self.chip.name, command), timeout)
        except Timeout as error:
            self.port.catch_up()
            if not (why := self.port.control.why_silent()):
                raise
            raise Timeout(f"{error}\n  {why}") from None
