"""The text of a program for a module, and the state of its transfer to the module."""

from __future__ import annotations

from dataclasses import dataclass

from ...core.datasheet.table import Sheet
from ...errors import UsageError
from ...language.assemble import assemble
from ...language.source import COMMENT, read
from ...language.statements import Statement
from ..failures import DamagedAnswer, ListingDiffers, MotionRefused, NoAnswer, RefusedCommand
from ..module import Module
from ..spoken import STORED_S
from .contents import ModuleContents
from .readers import Report

ROUNDS = 8  # attempts to send a program, or its damaged parts
STORED_BYTE_S = 0.021  # per character stored in an EEPROM: it may take 20 ms until it reads back


@dataclass(frozen=True)
class ProgramText:
    """A program text: the program, commands before it (such as register settings), and commands after it."""

    sheet: Sheet
    before: tuple[Statement, ...]
    program: tuple[Statement, ...]
    after: tuple[Statement, ...]
    stored: bytes
    base: int

    @classmethod
    def read(cls, text: str, sheet: Sheet, where: str) -> ProgramText:
        """Parse a program text for a part; `where` names the text in messages.

        Raises:
            ProgramError: the assembler does not accept the text.
            UsageError: the part stores no program; or the text has no program, has a comment that looks like
                commands, or has a line that only `slewline run` accepts.
        """
        if sheet.enter is None:
            raise UsageError(
                f"{where}: the {sheet.part.upper()} stores no programs; allowed: a part that stores programs"
            )
        assembly = assemble(text, sheet, where)
        for problem in assembly.findings:
            if problem.code == COMMENT:
                raise UsageError(f"{where}, line {problem.line}: {problem.found}; {problem.remedy}")
        source = read(text, sheet)
        for item in source.items:
            if not isinstance(item, Statement):
                raise UsageError(
                    f"{where}, line {item.line}: {item.text} is only for slewline run; allowed: commands of the "
                    f"{sheet.part.upper()}; leave out this line"
                )
        if not source.blocks:
            raise UsageError(f"{where} has no program; write {sheet.enter.form} before the instructions")
        (block,) = source.blocks[:1]
        items = source.statements
        framing = [items.index(each) for each in (block.entry, block.quit) if each is not None]
        outside = [(at, each) for at, each in enumerate(items) if each.block < 0 and at not in framing]
        begin = framing[0] if framing else 0
        before = tuple(each for at, each in outside if at < begin)
        after = tuple(each for at, each in outside if at > begin)
        return cls(sheet, before, assembly.statements, after, assembly.stored, assembly.base)

    def check_motion(self, module: Module, where: str) -> None:
        """Check that no command outside the program may step the motor, unless the module allows motion.

        Raises:
            MotionRefused: such a command exists, and motion is not allowed; no command has been sent.
        """
        for each in (*self.before, *self.after):
            if each.row.may_step and not module.may_move:
                raise MotionRefused(
                    f"{where}, line {each.line}: {each.text} may step the motor: {each.row.description}; no command "
                    "was sent; leave out this line, or allow motion with --move"
                )


class Restore:
    """A transfer of a program to a module; `status` describes the module's present content.

    Args:
        wanted: the program.
        contents: the content of the module before sending.
        report: called with progress messages.
        pace: the pause after each character, in seconds, if the program is written into an addressed memory.
    """

    def __init__(
        self,
        module: Module,
        wanted: ProgramText,
        contents: ModuleContents,
        report: Report = lambda _text: None,
        pace: float = STORED_BYTE_S,
    ) -> None:
        self.module, self.wanted, self.contents, self.report, self.pace = module, wanted, contents, report, pace
        self.sheet = wanted.sheet
        self.holds = "its program is unchanged"  # content before sending, in words
        self.status = self.holds  # present content of the module, in words
        self.is_known = True  # `contents` are up to date

    @property
    def is_there(self) -> bool:
        """True if the module already holds the program."""
        present, wanted = self.contents, self.wanted
        whole = present.stored == wanted.stored or not self.sheet.acting("list")
        same = present.base == wanted.base and whole and present.stored.startswith(wanted.stored)
        return self.is_known and same

    @property
    def was_cut(self) -> bool:
        """True if the content of the module is the beginning of the program, as after an interrupted `send`."""
        present, wanted = self.contents, self.wanted
        return present.base == wanted.base and bool(present.stored) and wanted.stored.startswith(present.stored)

    def set(self, statement: Statement) -> None:
        """Send a command outside the program; if the command sets a register that can be queried, verify its value."""
        module, text = self.module, statement.text
        question = next((name for name in module.speech.questions if self._sets(statement, name)), None)
        for _ in range(ROUNDS):
            module.ask(text)
            if question is None or int(module.value(question)) == statement.values[0]:
                return
        raise ListingDiffers(
            f"{module.name}: {text} was sent {ROUNDS} times, but the module still reports a different value"
        )

    def _sets(self, statement: Statement, name: str) -> bool:
        letter = next((row.letter for row in self.sheet.registers if row.name == name), "")
        return letter == statement.row.form and len(statement.values) == 1

    def recall(self) -> None:
        """Make the module load the program from its EEPROM into its RAM.

        Raises:
            RefusedCommand: no program is stored; the program in RAM is unchanged.
            ModuleFailure: it is unknown whether the stored program or the earlier one is in RAM.
        """
        (row,) = self.sheet.acting("recall")
        before = self.holds
        self.holds = self.status = f"{row.form} was not answered: its RAM has either of its two programs"
        try:
            self.module.ask(row.form)
        except RefusedCommand:
            self.holds = self.status = before
            raise
        self.holds = self.status = "its RAM has the stored program"

    def store(self) -> None:
        """Make the module store the program in its EEPROM.

        Raises:
            RefusedCommand: the program could not be stored.
            ModuleFailure: it is unknown whether the program was stored.
        """
        (row,) = self.sheet.acting("store")
        outcome = "the module holds the program (verified)"
        self.status = f"{outcome}; it is unknown whether it was stored: push again, with --store"
        self.report(f"{row.form}: {row.description} ...")
        try:
            self.module.ask(row.form)
        except (NoAnswer, DamagedAnswer) as failure:
            self.module.transcript.note(f"sent again: {failure}")
            self.module.wait_until_ready(STORED_S)
            self.module.ask(row.form)  # store the same program again
        except RefusedCommand as refused:
            self.status = f"{outcome}; it was not stored ({refused.code}: {refused.description})"
            raise
        self.status = f"{outcome} and has stored it in its EEPROM"


def can_store(sheet: Sheet) -> bool:
    """Return whether a part has a command that stores its program in an EEPROM."""
    return bool(sheet.acting("store"))
