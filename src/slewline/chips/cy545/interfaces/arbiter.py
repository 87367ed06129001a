"""The arbiter of the two sources of commands, the parallel and the serial side.

The side that begins a command owns the chip until the command ends; meanwhile the other side waits: the
parallel host with IO_REQUEST low, the serial host's characters in a buffer.  Characters from both sides
are never mixed in one command (ch. 16 states this for memory and host).
"""

from __future__ import annotations

from ....core.context import ChipContext
from ....core.wires.net import Net
from ....core.wires.waits import edge
from .parallel_side import EMPTY, LETTER, REST, ParallelPort
from .serial_side import WAITING, SerialSide


class InputArbiter:
    """The bytes of commands, in the order in which the chip reads them.  `owner` is the side that owns the chip."""

    def __init__(self, chip: ChipContext, port: ParallelPort, serial: SerialSide) -> None:
        self.chip, self.kernel, self.port, self.serial = chip, chip.kernel, port, serial
        self.owner: ParallelPort | SerialSide | None = None
        self.at_work = False
        self.program = False  # a program runs, and waits for the rest of a command

    def reset(self) -> None:
        """Handle RESET: end either side's ownership of the chip; the serial side measures its baud rate again."""
        self._owned_by(None)
        self.at_work = False
        self.port.reset()
        self.serial.restart()
        self._show()

    def restart(self) -> None:
        """Handle command I: let the serial side measure its baud rate again; a handshake in progress continues."""
        self.serial.restart()

    def killed(self, powered: bool) -> None:
        """End all input in progress, and set the outputs to their idle levels or, without supply, release them."""
        self._owned_by(None)
        self.at_work = False
        self.port.reset()
        self.serial.killed()
        self.port.rest(powered)
        self.serial.rest(1 if powered else None)

    # ------------------------------------------------------------------------------------------------------------- CTS
    def _show(self) -> None:
        """Drive CTS high while the chip is busy or reads from the parallel side, otherwise low."""
        self.serial.listening(not self.at_work and self.owner is not self.port)

    def executing(self, on: bool) -> None:
        """Record whether a command is being executed."""
        self.at_work = on
        self._show()

    def _hold(self, side: ParallelPort | SerialSide | None) -> None:
        self._owned_by(side)
        self._show()

    def _owned_by(self, side: ParallelPort | SerialSide | None) -> None:
        self.owner, self.serial.owned, self.serial.free = side, side is self.serial, side is None

    # ----------------------------------------------------------------------------------------------------------- bytes
    @property
    def pending(self) -> bool:
        """True while a request of the parallel host or a character from the serial host waits."""
        return self.port.asked or bool(self.serial.buffer)

    @property
    def answering(self) -> bool:
        """True during a command from the serial side, or while a serial character waits and may be read.

        A character may not be read while the chip waits for the parallel host to continue a command or message.
        """
        if self.owner is self.serial and self.at_work:
            return True
        return bool(self.serial.buffer) and not self.port.host_is_next

    @property
    def unfinished(self) -> bool:
        """True while the chip waits for the rest of a command on RXD."""
        return self.owner is self.serial and not self.at_work and not self.serial.buffer

    async def letter(self, *others: tuple[Net, int | None], running: bool = False) -> int:
        """Return the first byte of a command, from the side that begins one.

        An FF on the bus while a program runs is the empty handshake: the program waits for the letter after it.
        Any other FF is ignored, and either side may then begin a command.

        Args:
            others: inputs that end the wait, each with the level that ends it; None for any change.
            running: a program runs, so that the parallel side begins with the empty handshake.

        Returns:
            The byte; -1 if no command has begun: one of the other inputs has ended the wait, a request was
            withdrawn, or the byte was an ignored FF.
        """
        self.program = running
        if self.owner is None and not self.pending and not (running or await self._begins(others)):
            return -1
        byte = await self._first(running)
        if running and byte == EMPTY and self.owner is self.port:
            while byte == EMPTY:
                byte = await self.byte()
        elif byte == EMPTY:
            await self.release(self.chip.tick)
            return -1
        return byte

    async def _begins(self, others: tuple[tuple[Net, int | None], ...]) -> bool:
        """Wait, idle, until a side begins a command or another input ends the wait; return whether a side has begun."""
        self.chip.waits(f"waiting for {LETTER}")
        self.chip.idle = True
        await self.port.requested((self.serial.arrived, None), *others)
        self.chip.idle = False
        return self.pending

    async def _first(self, running: bool) -> int:
        """Return the next byte from the owner of the chip or, if it has none, from the side that begins a command.

        The result is -1 if the parallel host has withdrawn its request.
        """
        if self.owner is not None:
            return await self.byte()
        if not self.port.asked:
            self._hold(self.serial)
            return await self.byte()
        self.serial.one_by_one()
        byte = await self.port.byte(running)
        if byte >= 0:
            self._hold(self.port)
        return byte

    async def byte(self) -> int:
        """Return the next byte from the side that owns the chip."""
        chip, port, serial = self.chip, self.port, self.serial
        if self.owner is port:
            if not port.come:
                await port.done()
            while True:
                if not port.come and port.halfway is None:
                    chip.waits(f"waiting for {REST}")
                    chip.idle = not self.program
                    await port.requested()
                    chip.idle = False
                byte = await port.byte()
                if byte >= 0:
                    return byte
        while not serial.buffer:
            chip.waits(WAITING)
            chip.idle = not self.program
            await edge(serial.arrived)
            chip.idle = False
        chip.sync_forward()
        return serial.take()

    async def taken(self, tick: int) -> None:
        """Wait until the chip has processed a byte, at a tick, and can accept the next byte."""
        if self.owner is self.port:
            await self.port.done(tick)
        else:
            await self.chip.at_tick(tick)

    async def release(self, tick: int = 0) -> None:
        """Finish the last byte of a command at a tick, after which either side may begin the next command."""
        await self.taken(tick)
        self._hold(None)
