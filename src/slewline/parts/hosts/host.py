"""A host computer: the calls that every host has, regardless of its channel.

    send(data)       queue data unchanged; they are sent as fast as the chip accepts them
    ask(command)     send a command, let time pass until the answer, and return it
    received         the data received: bytes, characters, or the words of a chipset
    got(data)        condition for `run_until`: these data have been received
    drop()           drop the queue; a request that is being sent is completed
    clear()          drop all requests, and release the lines
    idle             True while nothing is queued
    waiting          the current activity, in words

A host sees the wires and the data sheet of a chip (`connection.py`), never the chip itself.  It has an
end on the channel, a request queue, and, if the chip's mode cannot be read, shadow registers.  The
hosts, their ends on the channel, and the calls that they add:

    BusHost         a CommandPort for each chip (ends/)                verify, live, change_rate ...
    PacketHost      a PacketPort for each chipset                 command, query, axis, wait ...
    FlowHost        a FlowPort, which has a Shadow                prefix, heed
    SerialHost      a StrappedUart (ends/strapped_uart.py)           write, change_line, answers ...
    AdaptiveHost    an AdaptiveUart, which has two Shadows        write, change_line, heed
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar, Self

from ...core.messages.instead import missing
from ...core.time.hook import Hook
from ...core.time.inputs import from_outside
from ...core.time.kernel import Kernel
from ..base.part import Part, served
from ..base.request_queue import RequestQueue
from ..base.written_data import Data

if TYPE_CHECKING:
    from ...core.chip import Chip
    from ...core.datasheet.channel import Channel
    from ...core.time.timebase import Time
    from ...core.wires.pin import Condition
    from .connection import Connection

TO_ONE = "; host.to(x) selects one of several chips"


class Host(Part):
    """A host computer that commands one chip, or several chips that share a bus or a line.

    Each kind of channel has a subclass, which adds the calls for that channel.

    Attributes:
        name: its name on the bench.
        chips: its connections, by the names of the chips.
        received: the data received: bytes of read-outs, characters, or the words of a chipset.
        pins: its own pins, by their names.
        on_finding: hook, called with each `Finding` about the host.
        on_event: hook, called with a description of each activity, such as a script line or an answer.
    """

    _for_users: ClassVar[tuple[str, ...]] = (
        *("send", "ask", "received", "got", "to", "drop", "clear", "idle", "waiting", "chip", "chips", "channel"),
        *("name", "pin", "pins", "findings", "on_event", "on_finding"),
    )

    def __init__(self, kernel: Kernel, name: str, chips: Sequence[Connection]) -> None:
        super().__init__(kernel, name)
        self.queue: RequestQueue = RequestQueue(kernel, name, give_up=self.give_up, rest=self._rest)
        self.on_event: Hook[[str]] = Hook()  # descriptions of its activities, such as a script line or an answer
        self.chips = {chip.name: chip for chip in chips}
        self._chip = chips[0]

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name} of {', '.join(self.chips)}: {self.waiting.partition(': ')[2]}>"

    @property
    def chip(self) -> Connection:
        """The chip selected with `to`; initially the first chip."""
        return self._chip

    @property
    def channel(self) -> Channel:
        """Channel between the host and the selected chip."""
        return self.chip.channel

    def to(self, chip: str | Chip | Connection) -> Self:
        """Select the chip for later calls; return the host.

        Raises:
            UnknownName: the host is not connected to this chip.
        """
        self._chip = self.chips[served(self.name, self.chips, chip).name]
        return self

    # -------------------------------------------------------------------------------------------------- out and back
    if TYPE_CHECKING:

        @property
        def received(self) -> Sequence[int]:
            """Data received: bytes of read-outs, characters, or the words of a chipset."""

    def send(self, data: str | bytes) -> None:
        """Queue data to be sent unchanged; no time passes.

        Raises:
            UsageError: the text is not ASCII, or the data cannot be sent.
        """
        raise NotImplementedError

    def ask(self, command: str, timeout: Time = "5 s") -> str | bytes | int:
        """Send a command, let virtual time pass until it is answered, and return the answer.

        Raises:
            UsageError: the text is not a command, or the command has no answer.
            ChecksumError: the answer has a wrong checksum, or a character with a parity or framing error.
            Timeout: no answer within `timeout`, in virtual time; the message names the missing event.
        """
        raise NotImplementedError

    def got(self, data: Data) -> Condition:
        """Return a condition for `bench.run_until`: these data have been received, consecutively."""
        raise NotImplementedError

    # ---------------------------------------------------------------------------------------------------------- queue
    @from_outside
    def drop(self) -> None:
        """Drop the queue; a request that is already being sent is completed."""
        if not self._begun:
            self.clear()
            return
        self.input("drop")
        self.queue.cancel_after(1, "drop()")

    @property
    def _begun(self) -> bool:
        """True if the first request in the queue has already affected the lines."""
        return self.queue.begun

    @from_outside
    def clear(self) -> None:
        """Drop all requests, including one being sent, and release the lines, like a restart of the host's program."""
        self.input("clear")
        self.queue.cancel_after(0, "clear()")
        self.queue.halt()

    @from_outside
    def give_up(self) -> None:
        """Cancel the last request in the queue, which took too long; requests queued later are performed as usual."""
        self.input("give_up")
        self.queue.cancel_last()

    def _rest(self) -> None:
        """Release the lines, because the request under way has been cut short."""
        raise NotImplementedError

    @property
    def waiting(self) -> str:
        """Description of the host's current activity: the request under way, or that there is nothing to send."""
        return f"{self.name}: nothing to send" if self.idle else self.queue.waiting


missing(
    Host,
    command="{it}.send(...) queues data to send, {it}.ask(...) waits for the answer",
    query="{it}.ask(...)",
    **dict.fromkeys(("write_line", "sendline", "send_line", "put", "execute", "transmit"), "{it}.send(...)"),
    **dict.fromkeys(
        ("read", "read_until", "readline", "readlines", "read_all", "receive", "recv", "answer_to"),
        "{it}.received has the received data, {it}.ask(...) waits",
    ),
    in_waiting="len({it}.received)",
    **dict.fromkeys(
        ("open", "close", "reset_input_buffer"),
        "there is nothing to open or close; {it}.clear() drops the queue",
    ),
    position="the chip has the position: x.position, with x = bench.add(...)",
    **dict.fromkeys(("run", "sleep", "wait", "flush", "run_until_idle"), "the bench runs time: bench.run_until_idle()"),
)
missing(
    Host,
    "",
    baudrate="bench.host(x, baud=9600) sets it, {it}.change_line(...) changes it on a serial line",
    **dict.fromkeys(("bytesize", "parity", "stopbits"), "{it}.change_line(...) changes the format of a serial line"),
    **dict.fromkeys(("timeout", "read_timeout"), '{it}.ask(..., timeout="5 s") takes one'),
)
