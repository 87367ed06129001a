"""What a line ends in on a bench: the serial connector of a computer, a UART, an interface board."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, cast

from ...bench.hosting import channel_over
from ...core.datasheet.channel import Channel, FlowBus, HostPort
from ...core.datasheet.channel import SerialLine as SerialChannel
from ...core.wires.pin import strapped
from ...errors import UsageError
from ...parts.boards.board import Board
from ...parts.lines.rs232 import SerialPort

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.chip import Chip

UART_BAUD = 9600
BOARDS: Mapping[type[Channel], tuple[str, str]] = {  # the kind of board on a channel, and how its name ends
    HostPort: ("isa", "isa"),
    FlowBus: ("parallel_card", "card"),
}


def connector(bench: Bench, line: str, chips: Sequence[Chip]) -> SerialPort:
    """Return the serial connector of a computer, wired to modules.

    Raises:
        UsageError: their lines differ in speed or format.
    """
    formats = {strapped_line(chip) for chip in chips}
    if len(formats) != 1:
        raise UsageError(f"{', '.join(chip.name for chip in chips)}: their lines differ in speed or format")
    baud, bits, parity, stop = formats.pop()
    name = f"{chips[0].name if len(chips) > 1 else line}_line"
    port: SerialPort = bench.part("serial_port", name=name, baud=baud, bits=bits, parity=parity, stop=stop)
    bench.connect(port, chips)
    return port


def uart(bench: Bench, chip: Chip) -> SerialPort:
    """Return the same, wired to the UART of figure 10.16, which only receives."""
    name = f"{chip.name}_line"
    receiver = bench.part("uart", name=f"{chip.name}_uart", to=chip, baud=UART_BAUD)
    port = bench.part("serial_port", name=name, ttl=True, baud=UART_BAUD, bits=8, parity="none", stop=1)
    bench.wire(f"{name}.txd", f"{chip.name}_uart.rxd")
    port.uart.far.ears = {receiver.name: receiver}
    return port


def board(bench: Bench, chip: Chip, over: str | None) -> Board:
    """Return an interface board on a chip."""
    kind, tail = BOARDS[type(channel_over(chip, over))]
    return cast("Board", bench.part(kind, name=f"{chip.name}_{tail}", to=chip))


def strapped_line(chip: Chip) -> tuple[int, int, str, int]:
    """Speed and format of a chip's serial port, as its pins are strapped: baud, bits, parity, stop bits."""
    port = chip.sheet.through(SerialChannel)
    return port.bauds[strapped(chip.pins, port.baud_pins)], port.bits, port.parity, port.stop
