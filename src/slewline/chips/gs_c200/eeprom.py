"""The EEPROM (it keeps the program without supply): its write time, and its contents after a failed write."""

from __future__ import annotations

from collections.abc import Callable

from ...core.context import ChipContext
from ...core.memory.store import Store, is_pending
from ...core.time.kernel import Task
from ...core.time.timebase import PS_PER_S
from ...core.wires.waits import until
from .activity import EEPROM, Activity
from .dialogue.program_memory import Program

LOOK_PS = PS_PER_S // 100  # interval at which a store that is still writing is queried
INVALID = b"\xff"  # not an opcode; the first byte after a failed write


class ProgramEeprom:
    """A store for one program, followed by a check byte.

    Args:
        refresh_idle: is called when a write ends.
        write_ps: the time to write a full memory and the check byte, ps.
        fails: True if programming the EEPROM fails.
    """

    def __init__(
        self,
        chip: ChipContext,
        refresh_idle: Callable[[], None],
        activity: Activity,
        program: Program,
        store: Store,
        write_ps: int,
        fails: bool,
    ) -> None:
        self.refresh_idle = refresh_idle
        self.chip, self.kernel, self.activity, self.program = chip, chip.kernel, activity, program
        self.store, self.write_ps, self.fails = store, write_ps, fails
        self.full = chip.sheet.buffer_bytes + 1  # bytes, with the check byte
        self.spoiled = ""  # why the last write failed: until one succeeds, the content is not valid
        self.saving: tuple[bytes, int] | None = None  # bytes being written, and since when
        self.task: Task | None = None

    @property
    def writing(self) -> bool:
        """True during a write."""
        return self.task is not None

    # ---------------------------------------------------------------------------------------------------------- write
    def write(self, over: Callable[[bool], None]) -> None:
        """Begin to write the program; `over` is called at the end, with True if the write succeeded."""
        self.task = self.kernel.spawn(self._write, bytes(self.program.memory), over, name=f"{self.chip.name} writes")
        self.activity.begin(EEPROM)

    async def _write(self, program: bytes, over: Callable[[bool], None]) -> None:
        """Write all bytes, one after the other, then a check byte, and verify them."""
        self.chip.waits("writing the EEPROM")
        self.activity.works_on("M")
        self.saving = program, self.kernel.now
        await until(self.kernel, self.kernel.now + self.write_ps * (len(program) + 1) // self.full)
        self.spoiled = await self._programmed(program)
        if self.spoiled:
            self.chip.finding("E6", f"the EEPROM was not written: {self.spoiled}")
        self.task = self.saving = None
        self.activity.works_on("")
        self.activity.end(EEPROM)
        self.chip.waits("waiting for a command")
        over(not self.spoiled)
        self.refresh_idle()

    async def _programmed(self, program: bytes) -> str:
        """Write a program to the store, and wait until it is stored; return the reason for a failure, or ""."""
        try:
            self.store.write(INVALID if self.fails else program)
            while is_pending(self.store):
                await until(self.kernel, self.kernel.now + LOOK_PS)
            return "" if self.store.read() == program else "it does not contain the program"
        except OSError as error:
            return str(error)

    def cut(self) -> None:
        """Abort a write at power-down: the bytes written so far are new, all others are old.

        If this has changed the content, the content is invalid, because its check byte does not match.
        """
        if self.task is not None:
            self.task.kill()
            self.task = None
        if self.saving is None:
            return
        (program, since), self.saving = self.saving, None
        done = (self.kernel.now - since) * self.full // self.write_ps
        try:
            before = self.store.read()
            torn = program[:done] + before.removeprefix(INVALID)[done:]
            if torn != before:
                self.store.write(INVALID + torn)
            elif done > len(program):  # all bytes are written; only the end has not been processed
                self.spoiled = ""
        except OSError as error:
            self.spoiled = str(error)

    # ----------------------------------------------------------------------------------------------------------- read
    def recall(self) -> str:
        """Load the program into the memory and return ""; on failure, change nothing and return the reason."""
        try:
            data = self.store.read()
        except OSError as error:
            return f"the EEPROM cannot be read: {error}"
        if self.spoiled or not self.program.accepts(data):
            why = f": the last write failed ({self.spoiled})" if self.spoiled else ""
            return f"the EEPROM contains no valid program{why}"
        self.program.load(data)
        return ""
