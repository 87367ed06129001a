"""The EEPROM: what keeps the program without supply, how long a write takes, and what one that fails leaves there."""

from __future__ import annotations

from collections.abc import Callable

from ...core.context import ChipContext
from ...core.memory.store import Store, is_pending
from ...core.time.kernel import Task
from ...core.time.timebase import PS_PER_S
from ...core.wires.waits import until
from .activity import EEPROM, Activity
from .dialogue.program_memory import Program

LOOK_PS = PS_PER_S // 100  # after which a store that is still writing is asked again
INVALID = b"\xff"  # no opcode; the first byte that a failed write leaves


class ProgramEeprom:
    """A store for one program, and a check byte after it.

    Args:
        refresh_idle: called when a write is over.
        write_ps: what a write of a full memory takes.
        fails: programming it fails.
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
        self.saving: tuple[bytes, int] | None = None  # what is being written, since when
        self.task: Task | None = None

    @property
    def writing(self) -> bool:
        """Is it being written?"""
        return self.task is not None

    # ---------------------------------------------------------------------------------------------------------- write
    def write(self, over: Callable[[bool], None]) -> None:
        """Begin to write the program; `over` is called at the end, with whether that has succeeded."""
        self.task = self.kernel.spawn(self._write, bytes(self.program.memory), over, name=f"{self.chip.name} writes")
        self.activity.begin(EEPROM)

    async def _write(self, program: bytes, over: Callable[[bool], None]) -> None:
        """Write byte after byte, a check byte after them, and verify all of it."""
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
        """Keep a program; return why that failed, empty if it did not.  The EEPROM takes as long as its store does."""
        try:
            self.store.write(INVALID if self.fails else program)
            while is_pending(self.store):
                await until(self.kernel, self.kernel.now + LOOK_PS)
            return "" if self.store.read() == program else "it does not hold the program"
        except OSError as error:
            return str(error)

    def cut(self) -> None:
        """The supply is gone: what has been written is new, the rest as before, and the check byte fits neither."""
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
            elif done > len(program):  # all of it is there; only its end has not been noticed
                self.spoiled = ""
        except OSError as error:
            self.spoiled = str(error)

    # ----------------------------------------------------------------------------------------------------------- read
    def recall(self) -> str:
        """Take the program into the memory; return why that failed, and the memory is as it was; empty: it did not."""
        try:
            data = self.store.read()
        except OSError as error:
            return f"the EEPROM cannot be read: {error}"
        if self.spoiled or not self.program.accepts(data):
            why = f": the last write failed ({self.spoiled})" if self.spoiled else ""
            return f"the EEPROM holds no valid program{why}"
        self.program.load(data)
        return ""
