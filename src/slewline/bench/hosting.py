"""Hosts of a bench: which one a channel has, and how it is wired to its chips."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..core.chip import Chip
from ..core.datasheet.channel import AdaptiveLine, BusHandshake, Channel, FlowBus, HostPort, SerialLine
from ..core.time.timebase import Time, picoseconds
from ..errors import UsageError, WiringError
from ..parts.base.part import Part
from .by_name import hosts
from .furnishing import Furnished
from .wiring import in_role, joints

if TYPE_CHECKING:
    from ..parts.hosts.adaptive_host import AdaptiveHost
    from ..parts.hosts.bus_host import BusHost
    from ..parts.hosts.connection import Connection
    from ..parts.hosts.flow_host import FlowHost
    from ..parts.hosts.host import Host
    from ..parts.hosts.packet_host import PacketHost
    from ..parts.hosts.serial_host import SerialHost

HOSTS: Mapping[type[Channel], str] = {  # the method that furnishes the host of a channel
    BusHandshake: "_bus_host",
    SerialLine: "_serial_host",
    HostPort: "_packet_host",
    FlowBus: "_flow_host",
    AdaptiveLine: "_adaptive_host",
}


class Hosted(Furnished):
    """A bench with hosts on it."""

    @hosts
    def host(
        self,
        *chips: Chip,
        name: str | None = None,
        delay: Time = 0,
        baud: int | None = None,
        line: Part | None = None,
        over: str | None = None,
    ) -> Host:
        """Put a host computer on the command port of a chip, or of several that share its bus or its line, at any time.

        Args:
            delay: what the host's own program takes before each byte (on a bus).
            baud: another rate than the chip is strapped for (on a serial line).
            line: a part of kind rs232_line between the host and the chips.
            over: "bus", "serial", "port" or "parallel", of a chip that has several channels; its first one by default.

        Raises:
            UsageError: no chip, a channel that one of them does not have, chips that are spoken to in different ways,
                or an argument that does not fit them.
            WiringError: a chip's serial line has a host already, or a chip of one's own has no pins for one.
        """
        if not chips:
            raise UsageError("host: which chip? bench.host(x)")
        for chip in chips:
            if not any(chip is own for own in self.chips.values()):
                raise UsageError(f"host: {getattr(chip, 'name', chip)!r}; expected chips of this bench")
        channels = [channel_over(chip, over) for chip in chips]
        kinds = sorted({channel.says for channel in channels})
        if len(kinds) > 1:
            raise UsageError(f"host: some of these chips have {', some '.join(kinds)}; one host speaks to one kind")
        channel = channels[0]
        if isinstance(channel, SerialLine | AdaptiveLine):
            if picoseconds(delay):
                raise UsageError(f"host: delay {delay!r}; on a serial line let the host's program pause")
        elif baud is not None or line is not None:
            wrong = f"baud {baud!r}" if baud is not None else "line"
            raise UsageError(f"host: {wrong}; {chips[0].name} has no serial line{_else_over(chips[0])}")
        asked = {} if over is None else {"over": over}  # journals of a part with one channel stay as they are
        furnish = getattr(self, HOSTS[type(channel)])
        host: Host = furnish(chips, channel, name, delay, asked, baud=baud, line=line)
        return host

    def _bus_host(
        self, chips: Sequence[Chip], channel: Channel, name: str | None, delay: Time, asked: dict[str, str], **_: None
    ) -> Host:
        """A host on a bus, which its chips share."""
        from ..parts.hosts.bus_host import BusHost

        return self._on_bus(BusHost, chips, channel, name, delay, asked)

    def _packet_host(
        self, chips: Sequence[Chip], channel: Channel, name: str | None, delay: Time, asked: dict[str, str], **_: None
    ) -> Host:
        """A host that sends packets over a bus, which its chips share."""
        from ..parts.hosts.packet_host import PacketHost

        self._alone(PacketHost, chips)
        return self._on_bus(PacketHost, chips, channel, name, delay, asked)

    def _flow_host(
        self, chips: Sequence[Chip], channel: Channel, name: str | None, delay: Time, asked: dict[str, str], **_: None
    ) -> Host:
        """A host on a bus that works both ways."""
        from ..parts.hosts.flow_host import FlowHost

        self._one_of_its_kind(FlowHost, chips)
        host = self._on_bus(FlowHost, chips, channel, name, delay, asked)
        assert isinstance(host, FlowHost)
        _tell_power(host.port.switched_on, chips)
        return host

    def _one_of_its_kind(self, kind: type[Host], chips: Sequence[Chip]) -> None:
        """Refuse a second host, or a host of several chips, where one host belongs to one chip."""
        if len(chips) > 1:
            names = ", ".join(chip.name for chip in chips)
            raise UsageError(f"host: {names} over one {kind.__name__}; such a chip has a host of its own")
        self._alone(kind, chips)

    def _alone(self, kind: type[Host], chips: Sequence[Chip]) -> None:
        """Refuse a second host where there is one."""
        for other in self.parts.values():
            taken = [chip.name for chip in chips if isinstance(other, kind) and chip.name in other.chips]
            if taken:
                raise WiringError(
                    f"host: {other.name} is on this side of {', '.join(taken)} already; one host a side: use "
                    f"bench[{other.name!r}]"
                )

    def _adaptive_host(
        self,
        chips: Sequence[Chip],
        channel: Channel,
        name: str | None,
        delay: Time,
        asked: dict[str, str],
        baud: int | None = None,
        line: Part | None = None,
    ) -> AdaptiveHost:
        """A host on a serial line whose rate the chip finds, with CTS."""
        from ..parts.hosts.adaptive_host import AdaptiveHost

        if line is not None:
            raise UsageError(
                f"host: line={line.name}; the serial side of {chips[0].name} has TTL levels, no RS-232 line"
            )
        self._one_of_its_kind(AdaptiveHost, chips)
        (chip,), name = chips, self._new_name(name, "host")
        strapped = getattr(chip.options, "fixed_baud", None)  # by somebody
        baud = strapped if baud is None else baud
        host = AdaptiveHost(self.kernel, name, [connection(chip, channel)], baud=baud, strapped=strapped)
        _tell_power(host.uart.switched_on, chips)
        pairs = joints("serial_port", host, chip)
        self.outside.tell("host", name=name, chips=[chip.name], delay_ps=0, baud=baud, line=None, **asked)
        self.place(host)
        for own, theirs in pairs:
            theirs.net.join(own.net)
        self.kernel.settle()
        return host

    def _on_bus(
        self,
        kind: type[BusHost | PacketHost | FlowHost],
        chips: Sequence[Chip],
        channel: Channel,
        name: str | None,
        delay: Time,
        asked: dict[str, str],
    ) -> Host:
        name, delay_ps = self._new_name(name, "host"), picoseconds(delay)
        for chip in chips[1:]:
            chips[0].bus.join(chip.bus)
        self.outside.tell("host", name=name, chips=[chip.name for chip in chips], delay_ps=delay_ps, **asked)
        host = kind(self.kernel, name, [connection(chip, channel) for chip in chips], delay_ps)
        self.place(host)
        self.kernel.settle()
        return host

    def _serial_host(
        self,
        chips: Sequence[Any],
        channel: Channel,
        name: str | None,
        delay: Time,
        asked: dict[str, str],
        baud: int | None = None,
        line: Part | None = None,
    ) -> SerialHost:
        """A host on an RS-232 line, wired to every module on it."""
        from ..parts.hosts.serial_host import SerialHost

        for other in self.parts.values():
            taken = [chip.name for chip in chips if isinstance(other, SerialHost) and chip.name in other.chips]
            if taken:
                raise WiringError(f"host: {other.name} is on the line of {', '.join(taken)} already; one host a line")
        for chip in chips:
            for role in ("serial_in", "serial_out"):
                in_role(chip, role)
        name = self._new_name(name, "host")
        host = SerialHost(self.kernel, name, [connection(chip, channel) for chip in chips], baud=baud)
        _tell_power(host.uart.switched_on, chips)
        pairs = [] if line is None else joints("rs232_line", line, host)
        names = [chip.name for chip in chips]
        self.outside.tell("host", name=name, chips=names, delay_ps=0, baud=baud, line=line and line.name, **asked)
        self.place(host)
        for own, theirs in pairs:
            theirs.net.join(own.net)
        self._connect(host if line is None else line, chips)
        return host

    def connect(self, connector: Part, chips: Sequence[Chip]) -> None:
        """Wire a serial connector to modules on one line; several need the pull-down of the last one.

        Raises:
            UsageError: no part, or no list of chips.
        """
        if not isinstance(connector, Part) or not all(isinstance(chip, Chip) for chip in chips):
            pins = f"; pins are joined by bench.wire({connector!r}, {chips!r})" if isinstance(connector, str) else ""
            raise UsageError(f"connect({connector!r}, {chips!r}): expected a part and a list of chips, [x, y]{pins}")
        self.outside.tell("connect", part=connector.name, chips=[chip.name for chip in chips])
        self._connect(connector, [chip for chip in chips if chip.sheet.channel(SerialLine) is not None])

    def _connect(self, connector: Part, chips: Sequence[Any]) -> None:
        from ..parts.hosts.serial_host import SerialHost
        from ..parts.hosts.strapped_uart import straps_of
        from ..parts.lines.rs232 import SerialPort

        out, rxd = in_role(connector, "computer_out").net, in_role(connector, "computer_in").net
        for chip in chips:
            out.join(in_role(chip, "serial_in").net)
            rxd.join(in_role(chip, "serial_out").net)
        if isinstance(connector, SerialPort | SerialHost):
            connector.uart.far.ears = {
                chip.name: straps_of(connection(chip, chip.sheet.channel(SerialLine))) for chip in chips
            }
        addresses = [chip.strapped_address() for chip in chips]
        for address in sorted({own for own in addresses if addresses.count(own) > 1 or (own == 0 and len(chips) > 1)}):
            who = ", ".join(chip.name for chip, own in zip(chips, addresses, strict=True) if own == address)
            what = "have the same address on one line" if address else "without an address on a line that modules share"
            pins = chips[0].sheet.channel(SerialLine).address_pins
            apart = f"; strap {', '.join(pins)} apart" if pins else ""
            connector.finding("same-address", f"{who} {what}: all of them answer{apart}")
        downs = [chip.pins[down.name].net for chip in chips if (down := chip.sheet.role("serial_pull_down"))]
        if downs and not any(down.hub is rxd.hub for down in downs):
            rxd.join(downs[-1])
        self.kernel.settle()


def connection(chip: Chip, channel: Channel) -> Connection:
    """Return what a host is handed of a chip that it reaches over a channel."""
    from ..parts.hosts.connection import Connection

    straps = getattr(chip, "straps", None)
    if straps is None and isinstance(channel, SerialLine):
        from ..core.wires.serial import Straps
        from ..language.lines import KEPT

        straps = Straps(channel, chip.pins, kept=KEPT)
    return Connection(
        name=chip.name,
        sheet=chip.sheet,
        channel=channel,
        pins=chip.pins,
        crystal_hz=chip.crystal_hz,
        bus=chip.bus,
        straps=straps,
        up_ps=getattr(chip, "up_ps", 0),
    )


def channel_over(chip: Chip, over: str | None) -> Channel:
    """Return the channel of a chip by its name, or its first one.

    Raises:
        UsageError: it has none, or none of this name; the message lists those there are.
    """
    channels = chip.sheet.channels
    found = channels[:1] if over is None else [channel for channel in channels if channel.name == over]
    if found:
        return found[0]
    has = ", ".join(channel.name for channel in channels) or "none"
    raise UsageError(f"host: over={over!r}; {chip.name} ({chip.sheet.part}) has these channels: {has}")


def _tell_power(switched_on: Callable[[], object], chips: Sequence[Chip]) -> None:
    """Tell a host when a chip is switched on."""
    for chip in chips:
        chip.on_power.add(lambda _chip, on: switched_on() if on else None)


def _else_over(chip: Chip) -> str:
    """Return the remedy where a chip has a serial line among its other channels."""
    others = [channel.name for channel in chip.sheet.channels if isinstance(channel, SerialLine | AdaptiveLine)]
    return f" here; over={others[0]!r} is one" if others else ""
