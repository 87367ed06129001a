"""slewline compare DIALOGUE: compare a module's answers with the model's answers to the same lines."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic
from typing import TYPE_CHECKING

import click

from ...chips import chip_class, sheet_of
from ...errors import BenchFileError, SlewlineError, UsageError
from ...gate import BOM, FileGate, opened
from ...modules.comparing.exchanges import are_checked, exchanges_of
from ...modules.comparing.replay import PS_PER_US
from ...modules.dialogue import KIND, DialogueFile, DialogueHeader, RecordedDialogue
from ...modules.failures import NoAnswer
from ...modules.speech import speech_of
from ...modules.spoken import Speech
from .. import FOUND
from ..files import read_options
from ..live.serve import remark
from ..programs import print_json
from .module_options import SettingOptions

if TYPE_CHECKING:
    from ...core.chip import Chip
    from ...modules.module import Module

PROGRESS_S = 3.0
BEGINNING = f'{{"slewline":"{KIND} '.encode()


def is_dialogue(path: str) -> bool:
    """Return whether a file begins like a dialogue, or cannot be read (reading it later reports the cause)."""
    try:
        with opened(path) as file:
            return file.read(len(BOM + BEGINNING)).removeprefix(BOM).startswith(BEGINNING)
    except (BenchFileError, OSError):
        return True


class SendableFile(DialogueFile):
    """A dialogue file that contains no remarks: these are printed to standard error instead."""

    def note(self, text: str) -> None:
        """Print a remark to standard error instead of writing it to the file."""
        remark(text)


class ComparisonProgress:
    """Progress messages of a long comparison, about 3 s apart."""

    def __init__(self) -> None:
        self.next_s = monotonic() + PROGRESS_S

    def __call__(self, number: int) -> None:
        """Print the number of the exchange that the model has reached, if 3 s have passed since the last message."""
        if monotonic() >= self.next_s:
            self.next_s += PROGRESS_S
            remark(f"the model is at exchange {number} ...")


@dataclass
class CompareDialogue(SettingOptions):
    """Files and options of `slewline compare DIALOGUE`."""

    dialogue: str
    part: str | None
    strap: tuple[tuple[str, int], ...]
    markings: str | None
    options: str | None
    memory: str | None
    port: str | None
    move: bool
    replace: bool
    report: str | None
    tolerance: int | None
    allow_code: bool
    as_json: bool

    def perform(self) -> int:
        """Compare a dialogue with the model, and print the result; return the exit status."""
        from ...modules.comparing.model_differences import DialogueComparison, usual_tolerance

        dialogue = RecordedDialogue.read(self.dialogue)
        if dialogue.torn:
            remark(f"{self.dialogue}: the last line is truncated, and is left out")
        cls = self.chip(dialogue)
        dialogue = replace(dialogue, header=self.header(dialogue))
        speech = self.speech(cls, dialogue.header)
        if self.port is not None:
            try:
                dialogue = self.played(dialogue, speech)
            except NoAnswer as failure:
                remark(str(failure))
                return FOUND
        elif self.report is not None:
            dialogue.write(self.report)
        if not exchanges_of(dialogue.entries, speech):
            lines = sum(entry.speaker == "host" for entry in dialogue.entries)
            whose = f"none of its {lines} lines is for address {speech.address}" if lines else "no host has sent data"
            raise UsageError(f"{self.dialogue}: nothing to compare: {whose}; name another dialogue, or give --address")
        tolerance = usual_tolerance(speech, dialogue.header.crystal_hz)
        if self.tolerance is not None:
            tolerance = tolerance._replace(fixed_us=self.tolerance / PS_PER_US)
        options = read_options(self.options, cls)
        progress = ComparisonProgress()
        found = DialogueComparison(dialogue, speech, tolerance, options, self.memory, cls, progress).compare()
        if self.as_json:
            print_json(found.as_json())
        else:
            click.echo(str(found))
        return 0 if found.agree else FOUND

    def chip(self, dialogue: RecordedDialogue) -> type[Chip]:
        """Return the class of the part that the user names or, if the user names none, of the part in the dialogue.

        A dialogue may name a class outside slewline, as module:Class, but only with --allow-code.
        """
        if self.part is not None:
            return chip_class(self.part)
        try:
            return FileGate(self.dialogue, allow_code=self.allow_code).code(chip_class, dialogue.header.part)
        except SlewlineError as error:
            raise UsageError(f"dialogue {self.dialogue}, line 1: part: {error}") from error

    def header(self, dialogue: RecordedDialogue) -> DialogueHeader:
        """Return the header of a dialogue, in which values from the command line replace the recorded ones."""
        header = dialogue.header
        checked = header.checksum if self.checksum is None else self.checksum
        return replace(
            header,
            part=self.part or header.part,
            baud=self.baud or header.baud,
            checksum=are_checked(dialogue.entries) if checked is None else checked,
            address=header.address if self.address is None else self.address,
            straps=dict(header.straps) | dict(self.strap),
            markings=header.markings if self.markings is None else self.markings,
            crystal_hz=header.crystal_hz if self.crystal_hz is None else self.crystal_hz,
        )

    def speech(self, cls: type[Chip], header: DialogueHeader) -> Speech:
        """Return the protocol of the module, with the rate, checksum setting and address of the header."""
        return speech_of(sheet_of(cls), header.baud, header.checksum, header.address)

    def played(self, dialogue: RecordedDialogue, speech: Speech) -> RecordedDialogue:
        """Repeat the commands of a dialogue with the module on the port; return the newly recorded dialogue."""
        from ...modules.comparing.playing import play

        with ExitStack() as stack:
            path = Path(self.report or Path(stack.enter_context(TemporaryDirectory(prefix="slewline-")), "now"))
            with self.module(path, dialogue.header, speech) as module:
                wait_s = (self.tolerance or 0) / PS_PER_US / 1e6
                play(exchanges_of(dialogue.entries, speech), module, self.replace, wait_s)
            return RecordedDialogue.read(path)

    @contextmanager
    def module(self, path: Path, header: DialogueHeader, speech: Speech) -> Iterator[Module]:
        """Yield the module, recording its dialogue in a file at `path`; remove the file if nothing was exchanged."""
        from ...modules.module import TIDY_S, Module
        from ...modules.module_port import ModulePort
        from .pull_push import raw_record, say_raw

        with (
            raw_record(self.report or self.dialogue) as raw,
            ModulePort(str(self.port), speech.setting, raw, self.echo) as port,
        ):
            file = SendableFile(path, replace(header, baud=speech.baud), remark)
            try:
                module = Module(port, speech, file, may_move=self.move, report=remark)
                if speech.wake:
                    module.send(speech.wake)
                    module.listen(TIDY_S)
                yield module
                say_raw(raw)
            finally:
                file.close()
                if not file.entries:
                    path.unlink()
