"""How a host reaches a part: the channels of a data sheet.  Data only; what makes a host of one is in bench/hosting.py.

A sheet may have several: a part with a bus and a serial port takes commands over both, and each has its own host.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar, Literal, TypeVar

from ...errors import UsageError

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Channel:
    """A way to reach a part.  `name` is what `bench.host(x, over=name)` calls it, `says` what messages do.

    The pins that every such channel has are found by their roles; those that only some parts have it names.  `instead`
    says what a chip has, where a directive is for another channel.
    """

    name: ClassVar[str]
    says: ClassVar[str]
    instead: ClassVar[str]

    @property
    def fastest(self) -> dict[str, int]:
        """The straps of its highest rate; none, where there is nothing to choose."""
        return {}

    @property
    def plain(self) -> dict[str, int]:
        """The straps that leave out what a program file does not hold, such as checksums."""
        return {}

    def elsewhere(self, name: str, value: object) -> str:
        """Return what sets something that is no option, with this value, in words; empty: nothing does."""
        return ""


@dataclass(frozen=True, eq=False)
class BusHandshake(Channel):
    """A data bus with a request and an answer for every byte; its pins are found by their roles."""

    name = "bus"
    says = "a bus"
    instead = "has a bus"


@dataclass(frozen=True, eq=False)
class HostPort(Channel):
    """A data bus with strobes, of which the pin in role "command" is high with a command and low with a word."""

    name = "port"
    says = "a port for packets"
    instead = "has a bus"


def ways(pin: str) -> str:
    """Return how a strap is given in Python and on the command line."""
    return f'straps={{"{pin}": 0, ...}}, or --strap {pin}=0'


@dataclass(frozen=True, eq=False)
class SerialLine(Channel):
    """A serial port: how characters look, and which pins set them.

    `bauds` maps the levels of `baud_pins` to rates, `addresses` those of `address_pins` to addresses (0: none is sent);
    `checksum_pin` at 1 asks for checksums.  A part without such pins has one entry, for the empty tuple.
    """

    name = "serial"
    says = "a serial line"
    instead = "is on a serial line"

    bits: int
    parity: str
    stop: int
    bauds: Mapping[tuple[int, ...], int]
    baud_pins: tuple[str, ...] = ()
    addresses: Mapping[tuple[int, ...], int] = field(default_factory=dict)
    address_pins: tuple[str, ...] = ()
    checksum_pin: str = ""
    where: str = ""

    @property
    def fastest(self) -> dict[str, int]:
        """Return the straps of the highest rate."""
        levels = max(self.bauds, key=lambda levels: self.bauds[levels])
        return dict(zip(self.baud_pins, levels, strict=True))

    def elsewhere(self, name: str, value: object) -> str:
        """Return which straps set rate and checksums, and that nothing sets the format."""
        if name in ("baud", "baudrate") and self.baud_pins:
            given = self.strapping(value)  # type: ignore[arg-type]
            rates = ", ".join(map(str, sorted(self.bauds.values())))
            return f"straps set its rate: {given or f'allowed {rates}'}; " + ways(self.baud_pins[0])
        if name in ("checksum", "checksums") and self.checksum_pin:
            return f"a strap sets it: {self.checksum_pin}=0 switches checksums off; " + ways(self.checksum_pin)
        if name in ("bits", "parity", "stop", "bytesize", "stopbits"):
            return (
                f"its format is fixed: {self.bits} data bits, {self.parity} parity, {self.stop} stop bits; leave it out"
            )
        return ""

    def strapping(self, baud: int | str) -> str:
        """Return the straps of a rate, such as "br0=0, br1=0, br2=0"; empty: no strap gives it."""
        levels = next((levels for levels, rate in self.bauds.items() if str(rate) == str(baud)), ())
        return ", ".join(f"{pin}={level}" for pin, level in zip(self.baud_pins, levels, strict=False))

    @property
    def plain(self) -> dict[str, int]:
        """Return the straps without checksums."""
        return {self.checksum_pin: 0} if self.checksum_pin else {}


@dataclass(frozen=True, eq=False)
class FlowBus(Channel):
    """A data bus with a request and an answer for every byte, and a line that says which way the bytes go.

    The pins have the roles "request", "ready" and "flow".  `ends` says when the line ends a message of the part:
    "before" it answers the request of the last byte, or "after" that request is over.  `live` says whether the part
    takes commands while its program runs, after a first request without a byte.  The line is in use while the mode
    register, under the mask `in_use[0]`, is `in_use[1]`; otherwise its pin says something else.
    """

    name = "parallel"
    says = "a bus that works both ways"
    instead = "is queried by its own commands"

    ends: Literal["before", "after"] = "after"
    live: bool = True
    in_use: tuple[int, int] = (0, 0)

    @property
    def answers(self) -> tuple[int, int]:
        """The mode register, under a mask, with which answers come over this channel."""
        return self.in_use


@dataclass(frozen=True, eq=False)
class AdaptiveLine(Channel):
    """A serial port that measures the rate of two carriage returns, unless one of `bauds` is fixed by an option.

    `flow_pin` is the part's own: low lets the host send, while the mode register, under the mask `in_use[0]`, is one of
    the numbers after it; otherwise the pin says something else.  Answers come over it while the mode register, under
    the mask `answers[0]`, is `answers[1]`.
    """

    name = "serial"
    says = "a serial line that finds its rate"
    instead = "is queried by its own commands"

    bauds: tuple[int, ...]
    bits: int = 8
    parity: str = "none"
    stop: int = 1
    flow_pin: str = ""
    in_use: tuple[int, ...] = (0, 0)
    answers: tuple[int, int] = (0, 0)
    where: str = ""


def row_for(channel: Channel, table: Mapping[type[Channel], T], what: str) -> T:
    """Return the row of a table for a channel, or for the channel that its class is derived from.

    Args:
        what: what the rows do, for the message: "makes a host for".

    Raises:
        UsageError: no row.
    """
    for kind in type(channel).__mro__:
        if kind in table:
            return table[kind]
    raise UsageError(
        f"nothing {what} {type(channel).__name__} ({channel.says}); allowed {', '.join(k.__name__ for k in table)}"
    )
