"""The destination of replies and strings, selected by the mode: TXD (plain or to an LCD), parallel port or HP display.

The LCD controller's codes are on no legible page of the manual, so TXD sends it the same characters as a plain device
(quirk CY545-UND-LCD).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from .. import sheet

if TYPE_CHECKING:
    from ....core.context import ChipContext
    from ..registers import Registers
    from .local_bus import LocalBus
    from .parallel_side import ParallelPort
    from .serial_side import SerialSide

CR = 0x0D
HP_FIRST, HP_ROOM = 0x38, 8  # the characters of an HDSP-211x


class Display:
    """The output devices, of which the mode register selects one."""

    def __init__(
        self, chip: ChipContext, registers: Registers, local_bus: LocalBus, port: ParallelPort, serial: SerialSide
    ) -> None:
        self.chip, self.registers = chip, registers
        self.local_bus, self.port, self.serial = local_bus, port, serial

    @property
    def device(self) -> Literal["serial", "lcd", "parallel", "hp"]:
        """The device that the mode register selects."""
        has = self.registers.has
        if has(sheet.MB_PARALLEL):
            return "hp" if has(sheet.MB_HP) else "parallel"
        return "lcd" if has(sheet.MB_LCD) else "serial"

    # ---------------------------------------------------------------------------------------------------------- answers
    async def reply(self, letter: str, value: int) -> None:
        """Answer a query: letter, equals sign, and as many digits or bytes as the register's width requires."""
        await self.put(self.reply_of(letter, value))

    def reply_of(self, letter: str, value: int) -> bytes:
        """Return the answer to a query: R=00100 and a carriage return; in binary, R= and bytes, high byte first."""
        digits = sheet.QUERIES[letter]
        head = f"{letter}=".encode()
        if self.registers.ascii:
            return head + b"%0*d\r" % (digits, value)
        return head + value.to_bytes(sheet.ANSWER_BYTES[digits], "big")

    async def position(self) -> None:
        """Show the position after a jog or homing step if the mode selects this (ch.16, Automatic Position Display)."""
        if self.registers.has(sheet.MB_SHOW):
            await self.reply("P", self.chip.axes[0].position)
            self.chip.sync_forward()  # the host, or TXD, has taken some time
            await self.chip.ticks(0)

    async def listing(self, lines: int) -> None:
        """Send the pointer, then the given number of memory lines from there on; the pointer itself is unchanged."""
        await self.put(self.reply_of("Y", self.registers.pointer))
        line, address = bytearray(), self.registers.pointer
        while lines and address < sheet.MEMORY_BYTES:
            line.append(await self.local_bus.read(address))
            address += 1
            if line[-1] == CR or address == sheet.MEMORY_BYTES:
                await self.put(bytes(line))
                line.clear()
                lines -= 1

    async def put(self, data: bytes) -> None:
        """Send bytes to the selected device, at its speed."""
        if not data:
            return
        device = self.device
        if device == "parallel":
            await self.port.send(data, each=not self.registers.ascii)
        elif device == "hp":
            text = data.removesuffix(b"\r") if self.registers.ascii else data  # in binary an 0D is a value
            await self.local_bus.show(HP_FIRST, text[-HP_ROOM:].ljust(HP_ROOM))
        else:
            await self.serial.send(data)
