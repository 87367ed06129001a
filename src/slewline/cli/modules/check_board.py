"""slewline firmware NAME --check PORT: compare the answers of a module's replacement with the model's."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import click

from ...chips import PARTS, chip_class, sheet_of
from ...core.datasheet.command_rows import LineRow
from ...errors import UsageError
from ...modules.comparing.exchanges import RecordedExchange
from ...modules.comparing.replay import PS_PER_US
from ...modules.dialogue import DialogueFile, DialogueHeader, RecordedDialogue
from ...modules.spoken import Speech
from .. import FOUND
from ..live.ready_made import FIRMWARE, firmware_of, write_firmware
from ..live.serve import remark
from .compare_dialogue import ComparisonProgress
from .module_options import SettingOptions
from .pull_push import performed

GAP_US = 20_000  # between an answer and the next line
LASTS_US = {"E": 2_500_000, "I1": 50_000}  # longer waits
HARMLESS = ("F", "V1", "V2", "A3", "S50", "L0", "K", "Z", "F")
ENTERED = ("S50", "T200", "R20", "L0", "A1", "+30", "D2", "-30", "C1", "A2", "L2", "Q")
FAULTY = ("S0", "T1001", "R1000", "A4", "D256", "+1000000", "zoo", "12345678901")  # a module may accept it and move


def entry(part: str) -> tuple[str, list[str]]:
    """Return the command that begins program entry, and any commands that end it without running the program."""
    rows = sheet_of(part).rows(LineRow)
    begin = next(row.head for row in rows if row.role == "enter")
    return begin, [row.head for row in rows if row.role == "leave" and not row.may_step]


def dialogue_for(part: str, *, replace: bool, move: bool) -> list[str]:
    """Return the lines of the check dialogue.

    Args:
        part: the module that the board replaces.
        replace: also enter a program, which replaces the one in RAM; the EEPROM is not written.
        move: if `replace`, also run that program: the motor makes 60 steps in each direction.
    """
    begin, end = entry(part)
    lines = [*HARMLESS]
    if replace:
        lines += [begin, *ENTERED, *FAULTY * move, *end, "Q", "F"]
    if replace and move:
        lines += ["I1", "E", "F", "V1", "V2", "I2", "V2", *FAULTY]
    return lines


def exchanges_with(speech: Speech, lines: list[str]) -> list[RecordedExchange]:
    """Return recorded exchanges that send the given lines one after another, with pauses, and have no answers."""
    found: list[RecordedExchange] = []
    at_us = 0
    for number, line in enumerate(lines, start=1):
        data = speech.framed(line)
        over_us = at_us + len(data) * speech.character_s * 1e6
        found.append(RecordedExchange(number, at_us, over_us, [(at_us, byte) for byte in data]))
        at_us = round(over_us) + LASTS_US.get(line, GAP_US)
    return found


ONLY_CHECKED = ("baud", "checksum", "address", "echo", "replace", "move", "dialogue", "tolerance")


def firmware(
    name: str | None, board: str | None, output: str | None, source: str | None, port: str | None, **check: Any
) -> int:
    """Write firmware or, if a port is given, check the board on that port; return the exit status.

    Raises:
        UsageError: options are missing or do not fit together, or the board does not replace a module.
    """
    if port is None:
        if given := [option for option in ONLY_CHECKED if check[option] not in (None, False)]:
            raise UsageError(f"{', '.join(f'--{option}' for option in given)}: allowed only with --check PORT")
        return write_firmware(name, board, output, source)
    if name is None:
        raise UsageError(f"--check: no firmware named; name the firmware on the board: {', '.join(FIRMWARE)}")
    firmware_of(name, board)
    if name not in PARTS:
        modules = ", ".join(each for each in FIRMWARE if each in PARTS)
        raise UsageError(f"--check: {name} does not replace a module; boards that can be checked: {modules}")
    if output or source:
        raise UsageError("--check: does not write firmware; leave out --output and --from")
    if check["move"] and not check["replace"]:
        raise UsageError("--move: the motor is moved by a program, which replaces the stored one; add --replace")
    if check["replace"] and not check["move"] and not entry(name)[1]:
        raise UsageError(
            f"--replace: a {name.upper()} ends program entry only with E, which runs the program; add --move"
        )
    return CheckBoard(**check, crystal=None, part=name, port=port).perform()


@dataclass
class CheckBoard(SettingOptions):
    """Options of `slewline firmware --check`."""

    part: str
    port: str
    dialogue: str | None
    tolerance: int | None
    move: bool
    replace: bool

    def perform(self) -> int:
        """Run the check; return the exit status."""
        with ExitStack() as stack:
            folder = stack.enter_context(TemporaryDirectory(prefix="slewline-"))
            path = Path(self.dialogue or Path(folder, "said"))
            return performed(lambda: self._play(path)) or self._compare(path)

    def _play(self, path: Path) -> None:
        """Send the check dialogue to the board, and record it with the answers in a file at `path`."""
        from ...modules.comparing.playing import play

        module = self.found(self.port, sheet_of(chip_class(self.part)), may_move=self.move)
        speech = module.speech
        remark(f"{module.name}, {speech.setting}{', with checksums' * speech.checked}")
        header = DialogueHeader(self.part, "", None, speech.baud, speech.checked, speech.address)
        lines = dialogue_for(self.part, replace=self.replace, move=self.move)
        with module.port, DialogueFile(path, header, remark) as module.transcript:
            play(exchanges_with(speech, lines), module, self.replace, (self.tolerance or 0) / PS_PER_US / 1e6)

    def _compare(self, path: Path) -> int:
        """Compare the recorded answers of the board with those of the model; return the exit status."""
        from ...modules.comparing.model_differences import DialogueComparison, usual_tolerance
        from ...modules.speech import speech_of

        dialogue = RecordedDialogue.read(path)
        header, cls = dialogue.header, chip_class(self.part)
        speech = speech_of(sheet_of(cls), header.baud, header.checksum, header.address)
        tolerance = usual_tolerance(speech, None)
        if self.tolerance is not None:
            tolerance = tolerance._replace(fixed_us=self.tolerance / PS_PER_US)
        found = DialogueComparison(dialogue, speech, tolerance, {}, None, cls, ComparisonProgress()).compare()
        click.echo(str(found))
        return 0 if found.agree else FOUND
