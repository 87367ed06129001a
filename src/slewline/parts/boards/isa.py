r"""An ISA board, which maps the host port of a chipset to I/O addresses of a PC.

The board in the chipset's application note has the addresses below; other cards have others
(register_layouts.py).

    base + 0   data, read and write         + 2   command, write
         + 4   bit 7: HostRdy, read         + 8   reset, write

    clocks     |  0  |  1  |  2  |  3  |  4  |  5  |            of the bus, 8 MHz
    address    ---<================================>            selects the port; its bit A1 is HostCmd
    IOW, IOR   ‾‾‾‾‾‾\_______________________/‾‾‾‾‾‾
    HostWrite  ‾‾‾‾‾‾‾‾‾‾‾‾\_____/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾            shortened by the PAL, for data hold time
    HostRead   ‾‾‾‾‾‾\_______________________/‾‾‾‾‾‾            at its rising edge, the PC reads the byte

Bits 0 to 6 of the status (base + 4) float and read 1.  RESET on the bus also resets the chipset.
"""

from __future__ import annotations

from types import MappingProxyType

from ...core.datasheet.option import Option
from ...core.time.kernel import Kernel
from ...core.wires.net import Net
from ...core.wires.waits import first_of, until
from ..base.operation import HostLines, Operation
from .board import FLOATING, READY, Board, base_option
from .isa_cycle import IsaCycle
from .register_layouts import ALLOWED, COMMAND, DATA, RESET, STATUS, layout_of, wrong

RESET_PS = 2_000_000  # the chipset needs 1 µs; the strobe of the bus alone would be too short
HOSTRDY = 0x80


class Isa(Board):
    """An ISA board in a PC, with the host port of a chipset."""

    wiring = MappingProxyType(
        {
            "hostdata": "data",
            "hostslct": "chip_select",
            "hostcmd": "command",
            "hostread": "read",
            "hostwrite": "write",
            "hostrdy": "ready",
            "reset": "reset",
        }
    )

    options = (
        base_option(
            None,
            "; by default 0x340, or that of the card; the select lines of the application note allow 0x340, 0x350, "
            "0x370 and 0x390",
        ),
        Option("card", "text", "pmd", f"register layout: {ALLOWED}", like="pi-c842", check=wrong),
    )
    _remedy = '; if the host program is for another card, set the option card, such as card="pi-c842"'

    def __init__(self, kernel: Kernel, name: str, *, base: int | None, card: str) -> None:
        layout = layout_of(card)
        super().__init__(kernel, name, base=layout.base if base is None else base, layout=layout)
        self.add_bus("hostdata", "data bus of the chipset")
        for pin in ("hostslct", "hostread", "hostwrite", "reset"):
            self.add_pin(pin, "out", f"{pin} of the chipset", initial=1)
        self.add_pin("hostcmd", "out", "hostcmd of the chipset: address line A1", initial=0)
        self.add_pin("hostrdy", "in", "hostrdy of the chipset", pull=1)
        self.add_pin("reset_drv", "in", "RESET of the bus, high active", pull=0)
        names = ("hostslct", "hostcmd", "hostwrite", "hostread", "hostdata")
        self._operation = Operation(HostLines(*(self.drivers[name] for name in names)))
        self._reset_until = 0  # a write to base + 8 holds the chipset in reset for this time

    def rewired(self) -> None:
        """Start to follow the pins, now that the part is wired."""
        self.pin("reset_drv").net.watch(self._put_reset)
        self._put_reset()

    def _put_reset(self, _net: Net | None = None) -> None:
        in_reset = self.high("reset_drv") or self.kernel.now < self._reset_until
        self.drivers["reset"].drive(0 if in_reset else 1)

    # ------------------------------------------------------------------------------------------------------ bus cycles
    async def _reach(self, register: str, byte: int | None = None) -> int:
        """Perform a bus cycle, and return the byte written or read."""
        if register in (DATA, COMMAND):
            return await self._operate(byte, register == COMMAND)
        if byte is not None:
            if register == RESET:
                self._reset_until = self._clock(1) + RESET_PS
                self.kernel.call_at(self._clock(1), self._put_reset)
                self.kernel.call_at(self._reset_until, self._put_reset)
            return byte
        await until(self.kernel, self._clock(5))
        return FLOATING & ~HOSTRDY if register == STATUS and not self.high("hostrdy") else FLOATING

    async def _operate(self, byte: int | None, command: bool) -> int:
        """Write `byte` to the host port of the chipset, or read a byte if `byte` is None; return the byte.

        `command`: whether HostCmd is high.
        """
        cycle, data = IsaCycle(self._began, byte is None), None if byte is None else bytes([byte])
        if self._operation.begin(cycle, data, command):
            shown = await self._operation.take_place()
            return shown[0] if byte is None else byte
        self._operation.promise(cycle, data, command)
        if byte is not None:
            return byte
        await until(self.kernel, cycle.last)
        return self.byte("hostdata")

    async def until_ready(self, ps: int, what: str = READY) -> None:
        """Wait, without bus cycles, until HostRdy is high, but at most `ps` picoseconds."""
        await first_of(self.kernel, self.kernel.now + ps, (self.pins["hostrdy"].net, 1))
