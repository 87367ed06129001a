"""The service for each kind of channel: the line to a chip, and the part in which the line ends."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, cast

from ..bench.hosting import channel_over
from ..core.datasheet.channel import AdaptiveLine, BusHandshake, Channel, FlowBus, HostPort, row_for
from ..core.datasheet.channel import SerialLine as SerialChannel
from ..errors import UsageError
from .lines.connectors import board, connector, gpib, uart
from .lines.framing import FramedLine
from .lines.served_line import ConnectorLine, HostLine
from .ports.prologix import PrologixLine
from .ports.register_port import RegisterLine

if TYPE_CHECKING:
    from ..core.chip import Chip
    from ..parts.hosts.adaptive_host import AdaptiveHost
    from ..parts.hosts.bus_host import BusHost
    from .face import ServerFace

NOT_RECEIVING = (
    "the UART of {chip} only receives: commands are not answered; use --framing (in a bench file framing = "
    "true), with which ?0 to ?3 read back"
)


def line_to(
    server: ServerFace, name: str, chips: Sequence[Chip], framing: bool, over: str | None, card: str | None = None
) -> HostLine:
    """Return a line to chips on their channel named `over`, by default their first channel.

    Raises:
        UsageError: the chips cannot share a line, or a card is named for a chip that has none.
    """
    channels = [channel_over(chip, over) for chip in chips]
    for chip, channel in zip(chips, channels, strict=True):
        if len(chips) > 1 and not isinstance(channel, SerialChannel):
            has = "a point-to-point line" if isinstance(channel, AdaptiveLine) else "a bus"
            raise UsageError(
                f"{name}: {chip.name} has {has}, so it cannot share a port; give {chip.name} a port of its own"
            )
    if card is not None:
        if not isinstance(channels[0], HostPort):
            raise UsageError(
                f"{name}: only a chipset has a card, which maps the host port to registers; leave out the card"
            )
        return register_line(server, name, chips, framing, over, card)
    return row_for(channels[0], LINES, "serves")(server, name, chips, framing, over)


def prologix_line(server: ServerFace, name: str, chips: Sequence[Chip]) -> HostLine:
    """Return a line to the GPIB controller of a bus on which the chips are devices.

    Raises:
        UsageError: a chip has no port for a GPIB interface.
    """
    for chip in chips:
        if chip.sheet.channel(BusHandshake) is None:
            raise UsageError(f"{name}: {chip.name} has no port for a GPIB interface; leave out prologix")
    controller, devices = gpib(server.bench, chips)
    return PrologixLine(name, server.pace, server.log, controller, devices)


def serial_line(server: ServerFace, name: str, chips: Sequence[Chip], framing: bool, over: str | None) -> HostLine:
    """Return a serial line to modules that share it."""
    if framing:
        raise UsageError(f"{name}: already has a serial line, which needs no framing; leave out framing")
    port = connector(server.bench, name, chips)
    server.troubles += [found.text for found in port.findings]  # wrong characters are reported as findings
    return ConnectorLine(name, chips, server.pace, server.log, port)


def register_line(
    server: ServerFace, name: str, chips: Sequence[Chip], framing: bool, over: str | None, card: str | None = None
) -> HostLine:
    """Return a line to the registers of an interface board on a chip's host port or bidirectional bus."""
    if framing:
        raise UsageError(f"{name} is served as registers, which need no framing; leave out framing")
    return RegisterLine(name, chips[0], server.pace, server.log, board(server.bench, chips[0], over, card))


def adaptive_line(server: ServerFace, name: str, chips: Sequence[Chip], framing: bool, over: str | None) -> HostLine:
    """Return a serial line to a chip that detects its host's rate; if the chip has CTS, characters wait for it."""
    if framing:
        raise UsageError(f"{name}: already has a serial line, which needs no framing; leave out framing")
    host = server.bench.host(chips[0], name=f"{name}_line", over=channel_over(chips[0], over).name)
    return ConnectorLine(name, chips, server.pace, server.log, cast("AdaptiveHost", host))


def bus_line(server: ServerFace, name: str, chips: Sequence[Chip], framing: bool, over: str | None) -> HostLine:
    """Return a line to a chip on a bus, for text lines with read-back or for the characters of a UART.

    If `framing` is True, a host computer on the bench translates the text lines to bus transfers.  Otherwise, the
    line ends in a UART whose output is connected to the bus.
    """
    if framing:
        host = server.bench.host(chips[0], name=f"{name}_host", over=over)
        return FramedLine(name, chips[0], server.pace, server.log, cast("BusHost", host))
    server.say(chips[0].name, NOT_RECEIVING.format(chip=chips[0].name))
    return ConnectorLine(name, chips, server.pace, server.log, uart(server.bench, chips[0]))


LINES: Mapping[type[Channel], Callable[[ServerFace, str, Sequence[Chip], bool, str | None], HostLine]] = {
    BusHandshake: bus_line,
    SerialChannel: serial_line,
    HostPort: register_line,
    FlowBus: register_line,
    AdaptiveLine: adaptive_line,
}  # by kind of channel
