"""Ends of lines on a bench: serial connector of a computer, UART, interface board, IEEE-488 bus."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, cast

from ...bench.hosting import channel_over
from ...core.datasheet.channel import Channel, FlowBus, HostPort
from ...core.datasheet.channel import SerialLine as SerialChannel
from ...core.wires.pin import strapped
from ...errors import UsageError
from ...parts.boards.board import Board
from ...parts.boards.gpib import HANDSHAKE, MANAGEMENT, GpibListener
from ...parts.boards.gpib_device import GpibController, GpibDevice
from ...parts.lines.rs232 import SerialPort

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.chip import Chip
    from ...core.wires.net import Net

UART_BAUD = 9600
FIRST_ADDRESS, LAST_ADDRESS = 5, 30  # of devices on an IEEE-488 bus
BUS_LINES = ("dio", *HANDSHAKE, *MANAGEMENT)
BOARDS: Mapping[type[Channel], tuple[str, str]] = {  # the kind of board on a channel, and the suffix of its name
    HostPort: ("isa", "isa"),
    FlowBus: ("parallel_card", "card"),
}


def connector(bench: Bench, line: str, chips: Sequence[Chip]) -> SerialPort:
    """Create the serial connector of a computer, wire it to modules, and return it.

    Raises:
        UsageError: the modules differ in rate or format.
    """
    formats = {strapped_line(chip) for chip in chips}
    if len(formats) != 1:
        names = ", ".join(chip.name for chip in chips)
        raise UsageError(
            f"{names}: their serial lines differ in rate or format; connect modules with the same rate and format"
        )
    baud, bits, parity, stop = formats.pop()
    name = f"{chips[0].name if len(chips) > 1 else line}_line"
    port: SerialPort = bench.part("serial_port", name=name, baud=baud, bits=bits, parity=parity, stop=stop)
    bench.connect(port, chips)
    return port


def uart(bench: Bench, chip: Chip) -> SerialPort:
    """Connect a chip to the UART of figure 10.16, which only receives; return a serial connector wired to it."""
    name = f"{chip.name}_line"
    receiver = bench.part("uart", name=f"{chip.name}_uart", to=chip, baud=UART_BAUD)
    port = bench.part("serial_port", name=name, ttl=True, baud=UART_BAUD, bits=8, parity="none", stop=1)
    bench.wire(f"{name}.txd", f"{chip.name}_uart.rxd")
    port.uart.far.receivers = {receiver.name: receiver}
    return port


def board(bench: Bench, chip: Chip, over: str | None, card: str | None = None) -> Board:
    """Create a board on the channel `over` of a chip, and return it; `card` selects one of several boards."""
    kind, tail = BOARDS[type(channel_over(chip, over))]
    which = {} if card is None else {"card": card}
    return cast("Board", bench.part(kind, name=f"{chip.name}_{tail}", to=chip, **which))


def gpib(bench: Bench, chips: Sequence[Chip]) -> tuple[GpibController, dict[int, Chip]]:
    """Return a controller on an IEEE-488 bus with chips, and a dictionary of these chips, keyed by address.

    A chip that is not yet connected to such a bus by a device is connected to a new device.  The new device
    has the next free address (5 or higher), and the interrupt logic that it needs.

    Raises:
        UsageError: two chips have the same address, or a chip is a listener without an address on the bus.
        WiringError: a chip has no port for such a device.
    """
    devices = [device_of(bench, chip) for chip in chips]
    found: dict[int, tuple[GpibDevice, Chip]] = {}
    for device, chip in zip(devices, chips, strict=True):
        if device is None:
            taken = [each.address for each in devices if each is not None] + [*found]
            address = next(free for free in range(FIRST_ADDRESS, LAST_ADDRESS + 1) if free not in taken)
            device = new_device(bench, chip, address)
        if device.address in found:
            before = found[device.address][1].name
            raise UsageError(f"{before} and {chip.name}: both have address {device.address}; give each its own address")
        found[device.address] = device, chip
    first, *others = [device for device, _ in found.values()]
    for other in others:
        for line in BUS_LINES if not same(first.net("dav"), other.net("dav")) else ():
            bench.wire(f"{first.name}.{line}", f"{other.name}.{line}")
    controllers = [part for part in bench.parts.values() if isinstance(part, GpibController)]
    controller = next((part for part in controllers if same(part.net("dav"), first.net("dav"))), None)
    if controller is None:
        controller = bench.part("gpib_controller", name=f"{chips[0].name}_controller", to=first)
    return controller, {address: chip for address, (_, chip) in found.items()}


def same(one: Net, other: Net) -> bool:
    """Return whether two nets are wired together."""
    return one.root is other.root


def device_of(bench: Bench, chip: Chip) -> GpibDevice | None:
    """Return the device that connects a chip to an IEEE-488 bus; None if there is none."""
    request = chip.pins[chip.sheet.in_role("request").name].net
    for part in bench.parts.values():
        if not isinstance(part, GpibDevice | GpibListener) or not same(part.net("io_request"), request):
            continue
        if isinstance(part, GpibListener):
            raise UsageError(
                f"{chip.name}: {part.name} has no address, and cannot answer; replace it with a gpib_device"
            )
        return part
    return None


def new_device(bench: Bench, chip: Chip, address: int) -> GpibDevice:
    """Connect a chip to a new IEEE-488 device, with the interrupt logic of figure 12.9; return the device."""
    name, logic = f"{chip.name}_gpib", f"{chip.name}_interrupts"
    device = bench.part("gpib_device", name=name, to=chip, address=address)
    bench.part("gpib_interrupts", name=logic, to=chip)
    for own, theirs in (("clr", "clear"), ("trig", "trigger"), ("srq", "srq")):
        bench.wire(f"{name}.{own}", f"{logic}.{theirs}")
    return device


def strapped_line(chip: Chip) -> tuple[int, int, str, int]:
    """Return the rate and format of a chip's serial port, as set by straps: baud, bits, parity, stop bits."""
    port = chip.sheet.through(SerialChannel)
    return port.bauds[strapped(chip.pins, port.baud_pins)], port.bits, port.parity, port.stop
