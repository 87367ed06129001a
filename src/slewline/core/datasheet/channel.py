"""The channels of a data sheet: how a host reaches a part.  Data only; bench/hosting.py creates the hosts.

A sheet may have several channels: a part with a bus and a serial port takes commands over both, each with its own host.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar, Literal, TypeVar

from ...errors import UsageError
from ..messages.former_names import formerly

T = TypeVar("T")


@formerly(description="says")
@dataclass(frozen=True, eq=False)
class Channel:
    """A channel over which a host reaches a part.

    Some pins exist on every part with this class of channel; they are found by their roles.  A pin that only
    some of these parts have is named by an attribute of the channel.

    Attributes:
        name: the name that selects the channel in `bench.host(x, over=name)`.
        description: the name of the channel in messages.
        instead: a phrase, such as "has a bus", for the message about a script directive that belongs to
            another kind of channel; it follows the name of the part.
    """

    name: ClassVar[str]
    description: ClassVar[str]
    instead: ClassVar[str]

    @property
    def fastest(self) -> dict[str, int]:
        """The straps that select the highest rate, as levels keyed by pin; empty if the rate cannot be selected."""
        return {}

    @property
    def plain(self) -> dict[str, int]:
        """The straps (levels keyed by pin) that switch off features that program files lack, such as checksums."""
        return {}

    def elsewhere(self, name: str, value: object) -> str:
        """Return text on how to set `name`, which is not an option, to `value`; "" if there is no such setting."""
        return ""


@dataclass(frozen=True, eq=False)
class BusHandshake(Channel):
    """A data bus with a handshake (request and answer) for every byte; its pins are found by their roles.

    Attributes:
        verify_bytes: the number of bytes in each group of data that can be read out, keyed by group number.
        ccw_bit: the mask of the direction bit in the last status byte: 1 means counter-clockwise.
    """

    name = "bus"
    description = "a bus"
    instead = "has a bus"

    verify_bytes: Mapping[int, int] = field(default_factory=dict)
    ccw_bit: int = 0


@dataclass(frozen=True, eq=False)
class HostPort(Channel):
    """A data bus with strobes; the pin with the role "command" is high for a command byte, and low for a data word."""

    name = "port"
    description = "a port for packets"
    instead = "has a bus"


def other_settings(pin: str) -> str:
    """Return text that explains how to set a strap in Python and on the command line."""
    return f'straps={{"{pin}": 0, ...}}, or --strap {pin}=0'


@dataclass(frozen=True, eq=False)
class SerialLine(Channel):
    """A serial port whose rate and address are set by strap pins.

    Attributes:
        bits: the number of data bits, 5 to 8.
        parity: "none", "odd" or "even".
        stop: the number of stop bits.
        bauds: the rates in baud, keyed by the levels of `baud_pins`; if there are no such pins, one rate,
            keyed by ().
        baud_pins: the pins that select the rate.
        addresses: the addresses, keyed by the levels of `address_pins`; for address 0, no address is sent.
        address_pins: the pins that select the address.
        checksum_pin: the pin that switches checksums on while at level 1; "" if there is none.
        where: the section of the manual.
    """

    name = "serial"
    description = "a serial line"
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
        """The straps that select the highest rate, as levels keyed by pin."""
        levels = max(self.bauds, key=lambda levels: self.bauds[levels])
        return dict(zip(self.baud_pins, levels, strict=True))

    def elsewhere(self, name: str, value: object) -> str:
        """Return text on the straps that set the rate or checksums, or on the fixed format; "" for other settings."""
        if name in ("baud", "baudrate") and self.baud_pins:
            given = self.strapping(value)  # type: ignore[arg-type]
            rates = ", ".join(map(str, sorted(self.bauds.values())))
            return f"straps set its rate: {given or f'allowed {rates}'}; " + other_settings(self.baud_pins[0])
        if name in ("checksum", "checksums") and self.checksum_pin:
            return f"a strap sets it: {self.checksum_pin}=0 switches checksums off; " + other_settings(
                self.checksum_pin
            )
        if name in ("bits", "parity", "stop", "bytesize", "stopbits"):
            return (
                f"its format is fixed: {self.bits} data bits, {self.parity} parity, {self.stop} stop bits; leave it out"
            )
        return ""

    def strapping(self, baud: int | str) -> str:
        """Return the straps for a rate, such as "br0=0, br1=0, br2=0"; "" if no strap selects it."""
        levels = next((levels for levels, rate in self.bauds.items() if str(rate) == str(baud)), ())
        return ", ".join(f"{pin}={level}" for pin, level in zip(self.baud_pins, levels, strict=False))

    @property
    def plain(self) -> dict[str, int]:
        """The strap that switches off checksums, as a level keyed by pin; empty if no pin selects checksums."""
        return {self.checksum_pin: 0} if self.checksum_pin else {}


@dataclass(frozen=True, eq=False)
class FlowBus(Channel):
    """A data bus with a handshake for every byte, and a flow line that shows the direction of the bytes.

    The pins have the roles "request", "ready" and "flow".

    Attributes:
        ends: when the flow line shows the end of a message: "before" the part answers the request for the
            last byte, or "after" that request has ended.
        live: True if the part accepts commands while its program runs; the host must first make a request
            that carries no byte.
        in_use: a mask and a value: the flow line is in use while the mode register, masked, has this value;
            otherwise its pin has another function.
    """

    name = "parallel"
    description = "a bidirectional bus"
    instead = "is queried by its own commands"

    ends: Literal["before", "after"] = "after"
    live: bool = True
    in_use: tuple[int, int] = (0, 0)

    @property
    def answers(self) -> tuple[int, int]:
        """A mask and a value: answers are sent over this channel while the mode register, masked, has this value."""
        return self.in_use


@dataclass(frozen=True, eq=False)
class AdaptiveLine(Channel):
    """A serial port that detects the rate from two carriage returns, unless an option fixes the rate.

    Attributes:
        bauds: the rates, in baud.
        bits: the number of data bits, 5 to 8.
        parity: "none", "odd" or "even".
        stop: the number of stop bits.
        flow_pin: the part's output that, while low, permits the host to send.
        in_use: a mask and values: `flow_pin` is in use while the mode register, masked, has one of these
            values; otherwise the pin has another function.
        answers: a mask and a value: answers use this port while the mode register, masked, has this value.
        where: the section of the manual.
    """

    name = "serial"
    description = "a serial line that detects the rate"
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
    """Return the row of a table for a channel's class, or for the nearest of its base classes that has a row.

    Args:
        what: a phrase about the purpose of the rows, for the error message: "makes a host for".

    Raises:
        UsageError: neither the class nor any of its base classes has a row.
    """
    for kind in type(channel).__mro__:
        if kind in table:
            return table[kind]
    raise UsageError(
        f"nothing {what} {type(channel).__name__} ({channel.description}); allowed "
        f"{', '.join(k.__name__ for k in table)}"
    )
