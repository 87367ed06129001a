"""Hosts of a bench: the host for each channel, and its wiring to the chips."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from ..core.chip import Chip
from ..core.datasheet.channel import AdaptiveLine, BusHandshake, Channel, FlowBus, HostPort, SerialLine, row_for
from ..core.messages.calls import answering
from ..core.time.timebase import Time, picoseconds
from ..errors import UsageError, WiringError
from ..parts.base.part import Part
from .wiring import in_role, joints

if TYPE_CHECKING:
    from ..core.wires.pin import Terminal
    from ..parts.hosts.adaptive_host import AdaptiveHost
    from ..parts.hosts.bus_host import BusHost
    from ..parts.hosts.connection import Connection
    from ..parts.hosts.flow_host import FlowHost
    from ..parts.hosts.host import Host
    from ..parts.hosts.packet_host import PacketHost
    from ..parts.hosts.serial_host import SerialHost
    from .circuit import Circuit

OnBus = TypeVar("OnBus", "BusHost", "PacketHost", "FlowHost")


class HostRequest(NamedTuple):
    """A request for a host on some chips of a circuit, over a channel that all of them have."""

    circuit: Circuit
    chips: Sequence[Any]
    channel: Channel
    name: str | None
    delay: Time
    baud: int | None
    line: Part | None
    over: str | None

    def new_name(self) -> str:
        """Return the name for the new host: the requested one, or by default an unused one."""
        return self.circuit.new_name(self.name, "host")

    def connections(self) -> list[Connection]:
        """Return the connections of the host to its chips."""
        return [connection(chip, self.channel) for chip in self.chips]

    def of(self, kind: type[Host]) -> tuple[Host, list[str]] | None:
        """Return an existing host of this kind on some of the chips, and the names of these chips; else None."""
        for other in self.circuit.parts.values():
            taken = [chip.name for chip in self.chips if isinstance(other, kind) and chip.name in other.chips]
            if isinstance(other, kind) and taken:
                return other, taken
        return None

    def refuse_second(self, kind: type[Host]) -> None:
        """Refuse a second host of the same kind on any of the chips.

        Raises:
            WiringError: a chip has a host of this kind already.
        """
        if found := self.of(kind):
            name, taken = found[0].name, ", ".join(found[1])
            raise WiringError(f"host: {taken} has a host on this channel already; use bench[{name!r}]")

    def refuse_several(self, kind: type[Host]) -> None:
        """Refuse a host for several chips, or a second host, on a channel that allows one host per chip."""
        if len(self.chips) > 1:
            names = ", ".join(chip.name for chip in self.chips)
            raise UsageError(f"host: {names} cannot share one {kind.__name__}; give each chip a host of its own")
        self.refuse_second(kind)

    def record_host(self, name: str, **what: Any) -> None:
        """Report the addition of the host, with the details `what`, as an external input."""
        asked = {} if self.over is None else {"over": self.over}  # so journals of single-channel parts are unchanged
        self.circuit.outside.record("host", name=name, chips=[chip.name for chip in self.chips], **what, **asked)

    def place(self, host: Host, pairs: Sequence[tuple[Terminal, Terminal]]) -> None:
        """Put a host on the bench, and connect its pins to pins of the chips, pair by pair."""
        self.circuit.place(host)
        for own, theirs in pairs:
            theirs.net.join(own.net)

    def follow_power(self, switched_on: Callable[[], object]) -> None:
        """Arrange for a function of the host to be called whenever one of its chips is switched on."""
        for chip in self.chips:
            chip.on_power.add(lambda _chip, on: switched_on() if on else None)


@answering("host()", "; the straps of the chip set the address of a module")
def host(
    circuit: Circuit,
    *chips: Chip,
    name: str | None = None,
    delay: Time = 0,
    baud: int | None = None,
    line: Part | None = None,
    over: str | None = None,
) -> Host:
    """Put a host computer on the command port of a chip, or of several chips on one bus or serial line, at any time.

    Args:
        chips: the chips that the host commands.
        name: the name on the bench; by default "host", with a number if there are several.
        delay: on a bus, the time that the host's program takes before each byte.
        baud: on a serial line, a rate other than the one that the chip is strapped for.
        line: a part of kind rs232_line between the host and the chips.
        over: "bus", "serial", "port" or "parallel", for a chip with several channels; by default its first one.

    Raises:
        UsageError: no chip is given, one of them does not have the channel, their channels differ, or an argument does
            not apply to the channel.
        WiringError: a chip has a host on a channel that allows only one, or a custom chip has no pins for a host.
    """
    if not chips:
        raise UsageError("host: no chip given; name one: bench.host(x)")
    for chip in chips:
        if not any(chip is own for own in circuit.chips.values()):
            meant = f": bench.host(bench[{chip!r}])" if isinstance(chip, str) else ""
            if isinstance(chip, list | tuple):
                meant = ", one argument each: bench.host(*chips)"
            raise UsageError(f"host: {getattr(chip, 'name', chip)!r}; expected chips of this bench{meant}")
    channels = [channel_over(chip, over) for chip in chips]
    kinds = sorted({channel.description for channel in channels})
    if len(kinds) > 1:
        raise UsageError(f"host: some of these chips have {', some '.join(kinds)}; use one host for each kind")
    channel = channels[0]
    if isinstance(channel, SerialLine | AdaptiveLine):
        if picoseconds(delay):
            raise UsageError(f"host: delay {delay!r} does not apply to a serial line; let the host's program pause")
    elif baud is not None or line is not None:
        wrong = f"baud {baud!r}" if baud is not None else "line="
        raise UsageError(f"host: {wrong}; {chips[0].name} has no serial line{_else_over(chips[0])}")
    return row_for(channel, HOSTS, "makes a host for")(
        HostRequest(circuit, chips, channel, name, delay, baud, line, over)
    )


def _bus_host(request: HostRequest) -> BusHost:
    """Return a host on the bus that its chips share."""
    from ..parts.hosts.bus_host import BusHost

    return _on_bus(request, BusHost)


def _packet_host(request: HostRequest) -> PacketHost:
    """Return a host that sends packets over the bus that its chips share."""
    from ..parts.hosts.packet_host import PacketHost

    request.refuse_second(PacketHost)
    return _on_bus(request, PacketHost)


def _flow_host(request: HostRequest) -> FlowHost:
    """Return a host on the bidirectional bus of a single chip."""
    from ..parts.hosts.flow_host import FlowHost

    request.refuse_several(FlowHost)
    host = _on_bus(request, FlowHost)
    request.follow_power(host.port.switched_on)
    return host


def _on_bus(request: HostRequest, kind: type[OnBus]) -> OnBus:
    name, delay_ps = request.new_name(), picoseconds(request.delay)
    for chip in request.chips[1:]:
        request.chips[0].bus.join(chip.bus)
    host = kind(request.circuit.kernel, name, request.connections(), delay_ps)
    request.record_host(name, delay_ps=delay_ps)  # not earlier: only now can the host be created
    request.circuit.place(host)
    request.circuit.kernel.settle()
    return host


def _adaptive_host(request: HostRequest) -> AdaptiveHost:
    """Return a host on a serial line with CTS, whose baud rate the chip detects."""
    from ..parts.hosts.adaptive_host import AdaptiveHost

    chip = request.chips[0]
    if request.line is not None:
        raise UsageError(
            f"host: line={request.line.name}; the serial side of {chip.name} has TTL levels, not RS-232; omit line="
        )
    request.refuse_several(AdaptiveHost)
    name = request.new_name()
    strapped = getattr(chip.options, "fixed_baud", None)  # by the user
    baud = strapped if request.baud is None else request.baud
    host = AdaptiveHost(request.circuit.kernel, name, request.connections(), baud=baud, strapped=strapped)
    request.follow_power(host.uart.switched_on)
    pairs = joints("serial_port", host, chip)
    request.record_host(name, delay_ps=0, baud=baud, line=None)
    request.place(host, pairs)
    request.circuit.kernel.settle()
    return host


def _serial_host(request: HostRequest) -> SerialHost:
    """Return a host on an RS-232 line, wired to every module on the line."""
    from ..parts.hosts.serial_host import SerialHost

    line = request.line
    if found := request.of(SerialHost):
        raise WiringError(
            f"host: {found[0].name} is on the line of {', '.join(found[1])} already; a line can have only one host"
        )
    for chip in request.chips:
        for role in ("serial_in", "serial_out"):
            in_role(chip, role)
    name = request.new_name()
    host = SerialHost(request.circuit.kernel, name, request.connections(), baud=request.baud)
    request.follow_power(host.uart.switched_on)
    pairs = [] if line is None else joints("rs232_line", line, host)
    request.record_host(name, delay_ps=0, baud=request.baud, line=line and line.name)
    request.place(host, pairs)
    _connect(request.circuit, host if line is None else line, request.chips)
    return host


HOSTS: Mapping[type[Channel], Callable[[HostRequest], Host]] = {  # the function that makes the host of a channel
    BusHandshake: _bus_host,
    SerialLine: _serial_host,
    HostPort: _packet_host,
    FlowBus: _flow_host,
    AdaptiveLine: _adaptive_host,
}


def connect(circuit: Circuit, connector: Part, chips: Sequence[Chip]) -> None:
    """Wire a serial connector to the modules on one line.

    If the modules have pull-down resistors, the resistor of the last module is connected, unless the line already
    has one.

    Args:
        connector: a part such as "serial_port".
        chips: the modules, in their order on the line.

    Raises:
        UsageError: `connector` is not a part, or `chips` is not a list of chips.
    """
    if not isinstance(connector, Part) or not all(isinstance(chip, Chip) for chip in chips):
        pins = f"; pins are joined by bench.wire({connector!r}, {chips!r})" if isinstance(connector, str) else ""
        raise UsageError(
            f"connect({connector!r}, {chips!r}): expected a part and a list of chips, such as [x, y]{pins}"
        )
    circuit.outside.record("connect", part=connector.name, chips=[chip.name for chip in chips])
    _connect(circuit, connector, [chip for chip in chips if chip.sheet.channel(SerialLine) is not None])


def _connect(circuit: Circuit, connector: Part, chips: Sequence[Any]) -> None:
    from ..parts.hosts.ends.strapped_uart import straps_of
    from ..parts.hosts.serial_host import SerialHost
    from ..parts.lines.rs232 import SerialPort

    out, rxd = in_role(connector, "computer_out").net, in_role(connector, "computer_in").net
    for chip in chips:
        out.join(in_role(chip, "serial_in").net)
        rxd.join(in_role(chip, "serial_out").net)
    if isinstance(connector, SerialPort | SerialHost):
        connector.uart.far.receivers = {
            chip.name: straps_of(connection(chip, chip.sheet.channel(SerialLine))) for chip in chips
        }
    addresses = [chip.strapped_address() for chip in chips]
    for address in sorted({own for own in addresses if addresses.count(own) > 1 or (own == 0 and len(chips) > 1)}):
        names = ", ".join(chip.name for chip, own in zip(chips, addresses, strict=True) if own == address)
        what = "have the same address on one line" if address else "have no address on a shared line"
        pins = chips[0].sheet.channel(SerialLine).address_pins
        apart = f"; strap {', '.join(pins)} differently" if pins else ""
        connector.finding("same-address", f"{names} {what}: all of them answer{apart}")
    downs = [chip.pins[down.name].net for chip in chips if (down := chip.sheet.role("serial_pull_down"))]
    if downs and not any(down.root is rxd.root for down in downs):
        rxd.join(downs[-1])
    circuit.kernel.settle()


def connection(chip: Chip, channel: Channel) -> Connection:
    """Return the connection of a host to a chip over a channel."""
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
    """Return the channel of a chip that is named `over`; its first channel if `over` is None.

    Raises:
        UsageError: the chip has no channel, or none with this name; the message lists the existing ones.
    """
    channels = chip.sheet.channels
    found = channels[:1] if over is None else [channel for channel in channels if channel.name == over]
    if found:
        return found[0]
    has = ", ".join(channel.name for channel in channels) or "none"
    raise UsageError(f"host: over={over!r}; {chip.name} ({chip.sheet.part}) has these channels: {has}")


def _else_over(chip: Chip) -> str:
    """Return a hint that names the serial line of a chip, to be selected with `over`; "" if there is none."""
    others = [channel.name for channel in chip.sheet.channels if isinstance(channel, SerialLine | AdaptiveLine)]
    return f" here; over={others[0]!r} selects one" if others else ""
