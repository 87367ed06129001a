"""RS-232: the serial connector of a computer.

computer   txd --------> rxd   module          three wires; mark, the idle state, is the negative voltage,
           rxd <-------- txd                   which is level 0 here
"""

from __future__ import annotations

from types import MappingProxyType

from ...core.datasheet.option import Option
from ...core.time.inputs import from_outside
from ...core.time.kernel import Kernel
from ...core.wires.serial import BAUD, RS232, TTL, CharacterFormat, LineSetting, word_options
from ..base.part import Part
from .host_uart import HostUart, OverUart


class SerialPort(OverUart, Part):
    """A serial connector: characters out on txd, characters in on rxd, at the line rate."""

    _for_users = ("write", "received", "got", "drop", "change_line", "baud", "word", "faulty", "on_character")
    wiring = MappingProxyType({"txd": "serial_in", "rxd": "serial_out"})
    optional = frozenset({"rxd"})  # a neighbour that only receives has no txd
    options = (
        BAUD,
        *word_options(7, "odd", 2),
        Option("ttl", "bool", False, "TTL levels (mark is 1) instead of RS-232 levels"),
    )

    def __init__(
        self, kernel: Kernel, name: str, *, baud: int | str, bits: int, parity: str, stop: int | str, ttl: bool
    ) -> None:
        super().__init__(kernel, name)
        self.uart = HostUart(self, LineSetting(baud, CharacterFormat(bits, parity, stop)), TTL if ttl else RS232)
        self.on_character = self.uart.on_character

    @property
    def idle(self) -> bool:
        """True while no character is waiting to be sent."""
        return self.uart.idle

    @property
    def waiting(self) -> str:
        """Description of the port's current activity."""
        return super().waiting if self.idle else self.uart.waiting

    @from_outside
    def drop(self) -> None:
        """Drop the queued characters, except characters already on the line."""
        self.uart.drop("drop")
