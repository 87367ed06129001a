"""slewline pull and push: save the program of a real module to a file, and send it back."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ...core.time.timebase import PS_PER_S
from ...errors import UsageError
from ...modules.dialogue import DialogueFile, DialogueHeader
from ...modules.failures import ModuleFailure
from ...modules.programs.backup import check_new, check_push, check_recall, check_store, pull, push
from ...modules.programs.restore import STORED_BYTE_S, ProgramText
from ...modules.raw import RawRecord
from ...modules.speech import speech_of
from .. import FOUND
from ..files import read_program, sheet_for
from ..live.serve import remark
from .module_options import SettingOptions

if TYPE_CHECKING:
    from ...core.datasheet.table import Sheet
    from ...modules.module import Module

DIALOGUE, RAW = ".dialogue", ".raw"


@dataclass
class PortOptions(SettingOptions):
    """The port, the part and the settings of a module."""

    port: str
    part: str | None
    dialogue: str | None
    markings: str | None

    @contextmanager
    def module(self, sheet: Sheet, beside: str, may_move: bool = False) -> Iterator[Module]:
        """Yield the module; record its dialogue and raw characters, by default in files next to the file `beside`."""
        speech_of(sheet, self.baud, self.checksum, self.address)  # a mistake here opens no port
        path = free(beside, DIALOGUE) if self.dialogue is None else Path(self.dialogue)
        check_new(path, replace=None)
        with raw_record(beside) as raw:
            found = self.found(self.port, sheet, raw, may_move=may_move)
            speech = found.speech
            markings = self.markings or ""
            header = DialogueHeader(sheet.part, markings, self.crystal_hz, speech.baud, speech.checked, speech.address)
            with found.port, DialogueFile(path, header, remark) as file:
                found.transcript = file
                goes = f"the dialogue is recorded in {path}, raw characters in {raw.path}"
                remark(f"{found.name}, {speech.setting}{', with checksums' * speech.checked}; {goes}")
                yield found


def free(beside: str, ending: str) -> Path:
    """Return a path at which no file exists: `beside` plus the ending, with a number between them if necessary."""
    path, number = Path(beside + ending), 1
    while path.exists():
        number += 1
        path = Path(f"{beside}-{number}{ending}")
    return path


@contextmanager
def raw_record(beside: str) -> Iterator[RawRecord]:
    """Yield a record of raw characters, in a new file in the same folder; on an error, report the file's path."""
    raw = RawRecord(free(beside, RAW), remark)
    try:
        yield raw
    except BaseException:
        say_raw(raw)
        raise
    finally:
        raw.close()


def say_raw(raw: RawRecord) -> None:
    """Report the path of the file with the raw characters received, if that file exists."""
    if raw.is_kept:
        remark(f"the raw characters received are in {raw.path}")


def performed(work: Callable[[], object]) -> int:
    """Perform a task on a module; return the exit status, which is 1 if the task failed or was interrupted."""
    try:
        work()
    except ModuleFailure as failure:
        remark(str(failure))
        return FOUND
    except KeyboardInterrupt:
        remark("interrupted")
        return FOUND
    return 0


@dataclass
class PullCommand(PortOptions):
    """Options of `slewline pull`."""

    output: str
    base: int | None
    eeprom: bool
    replace: bool

    def perform(self) -> int:
        """Save the program of the module to a file; return the exit status."""
        sheet = sheet_for(self.output, self.part, speech_of)
        check_new(Path(self.output), self.replace)
        check_recall(sheet, self.eeprom)
        if not Path(self.output).parent.is_dir():
            raise UsageError(f"{self.output}: there is no directory {str(Path(self.output).parent)!r}")
        return performed(lambda: self._pull(sheet))

    def _pull(self, sheet: Sheet) -> None:
        with self.module(sheet, self.output) as module:
            pull(module, self.output, base=self.base, recall=self.eeprom, replace=self.replace, report=remark)


@dataclass
class PushCommand(PortOptions):
    """Options of `slewline push`."""

    file: str
    store: bool
    keep: str | None
    pace: int | None  # ps
    move: bool

    def perform(self) -> int:
        """Send the program to the module, and verify it; return the exit status."""
        sheet = sheet_for(self.file, self.part, check_push)
        check_push(sheet)
        check_store(sheet, self.store)
        wanted = ProgramText.read(read_program(self.file, source=True), sheet, self.file)
        return performed(lambda: self._push(sheet, wanted))

    def _push(self, sheet: Sheet, wanted: ProgramText) -> None:
        pace = STORED_BYTE_S if self.pace is None else self.pace / PS_PER_S
        with self.module(sheet, self.file, self.move) as module:
            push(module, wanted, self.file, store=self.store, keep=self.keep, pace=pace, report=remark)
