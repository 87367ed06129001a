"""Program text of the CY5xx: lines in, statements with places out.  Assembler and linter read the same statements.

A text holds what a host would send, a command a line:

    ; weld.cy525                 a comment runs to the end of the line
    R 80                         before E: command mode
    E                            program entry begins
    A$N 100                      a label stands directly in front of its instruction, or alone on the line above
    L 6,A                        two arguments: a comma or a space between them
    Q                            program entry ends; QX on one line is Q and then X
    X
    @wait 20 ms                  a directive to the host, none of the chip's business

Nothing here raises.  What is wrong with a text becomes a `Problem` with a place, so that all of them can be shown at
once; a statement that the chip would still take is kept beside its problem, so that the
addresses behind it are right.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace

from ..core.table import Arg, Row, Sheet
from .dialects import LINE_LIMIT
from .problems import Place, Problem, Severity, Spot

LABELS = "s.3"  # the manual's section about labels
_WORD = re.compile(r"[^ ,]+")
_ARGUMENTS = re.compile(r"[^ ,]+(?:(?: *, *| +)[^ ,]+)*")


@dataclass(frozen=True, slots=True)
class Operand:
    """An argument as written.  `value` fits the argument's bytes; for a label it is the code of the letter."""

    line: int
    column: int
    length: int
    value: int
    label: str = ""


@dataclass(frozen=True, slots=True)
class Statement:
    """A command.  `block` numbers the program that it belongs to, `address` is its byte there; -1: command mode."""

    line: int
    column: int
    text: str
    row: Row
    operands: tuple[Operand, ...] = ()
    labels: tuple[str, ...] = ()
    block: int = -1
    address: int = -1

    @property
    def length(self) -> int:
        """Characters."""
        return len(self.text)

    @property
    def values(self) -> tuple[int, ...]:
        """The operands as numbers, ready to be packed."""
        return tuple(operand.value for operand in self.operands)

    @property
    def end(self) -> int:
        """The address behind it."""
        return self.address + self.row.size

    @property
    def target(self) -> Operand | None:
        """The operand that says where to branch."""
        pairs = zip(self.row.args, self.operands, strict=True)
        return next((operand for arg, operand in pairs if arg.name == "target"), None)


@dataclass(frozen=True, slots=True)
class Directive:
    """A line that begins with @: the host's, not the chip's."""

    line: int
    column: int
    text: str

    @property
    def length(self) -> int:
        """Characters."""
        return len(self.text)


Item = Statement | Directive


@dataclass(slots=True)
class Block:
    """A stored program, from E to Q."""

    statements: list[Statement] = field(default_factory=list)
    labels: dict[str, int] = field(default_factory=dict)
    entry: Statement | None = None
    quit: Statement | None = None

    @property
    def size(self) -> int:
        """Bytes in the buffer."""
        return self.statements[-1].end if self.statements else 0

    def address_of(self, target: Operand) -> int | None:
        """Where a branch goes; None if its label is nowhere."""
        return self.labels.get(target.label) if target.label else target.value


@dataclass(slots=True)
class Source:
    """A text that was read: its items in order, its programs, its problems."""

    sheet: Sheet
    items: list[Item] = field(default_factory=list)
    blocks: list[Block] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)

    @property
    def statements(self) -> list[Statement]:
        """The commands, without the directives."""
        return [item for item in self.items if isinstance(item, Statement)]

    def report(
        self,
        spot: Spot,
        code: str,
        severity: Severity,
        found: str,
        *,
        allowed: str = "",
        section: str = "",
        remedy: str = "",
    ) -> None:
        """Note a problem at a statement, an operand, a directive or a bare place."""
        where = f"{self.sheet.part.upper()} manual, {section}" if section else ""
        place = spot.line, spot.column, spot.length
        self.problems.append(Problem(*place, code, severity, found, allowed, where, remedy))


def host_lines(text: str) -> list[tuple[int, int, str]]:
    """(line, column, text) of every line that says something, without comment and surrounding blanks."""
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        code = line.split(";", 1)[0].rstrip()
        body = code.lstrip()
        if body:
            found.append((number, len(code) - len(body) + 1, body))
    return found


def read(text: str, sheet: Sheet, bare: bool = False) -> Source:
    """The whole text, taken apart.

    A text without E is one stored program if `bare` is set, else it is what a host sends in command mode.
    """
    source = Source(sheet)
    pending: tuple[str, ...] = ()
    line = None
    for number, column, body in host_lines(text):
        if body.startswith("@"):
            source.items.append(Directive(number, column, body))
        else:
            line = _Line(source, number, column, body)
            pending = line.take(pending)
    if line and pending:
        line.error(0, len(line.text), "bad-label", f"{pending[-1]}$ without an instruction", "", LABELS)
    _lay_out(source, bare)
    return source


# ------------------------------------------------------------------------------------------------------ a single line


class _Line:
    """Takes one line apart; `at` is an index into its text."""

    def __init__(self, source: Source, number: int, column: int, text: str) -> None:
        self.source = source
        self.sheet = source.sheet
        self.number = number
        self.column = column
        self.text = text

    def spot(self, at: int, end: int) -> Place:
        return Place(self.number, self.column + at, end - at)

    def error(
        self, at: int, end: int, code: str, found: str, allowed: str = "", section: str = "", remedy: str = ""
    ) -> None:
        place = self.spot(at, end)
        self.source.report(place, code, "error", found, allowed=allowed, section=section, remedy=remedy)

    def take(self, labels: tuple[str, ...]) -> tuple[str, ...]:
        """The commands of the line; the first is named by the labels of the line above.

        Returns labels at the end of the line, which name the first command of the next one.
        """
        if len(self.text) > LINE_LIMIT:
            self.error(0, len(self.text), "too-long", f"{len(self.text)} characters", f"{LINE_LIMIT}")
            return ()
        at = begin = 0
        while at < len(self.text):
            row = self.sheet.commands.by_form.get(self.text[at])
            if self.text[at + 1 : at + 2] == "$":
                if not self.is_label(at):
                    return ()
                labels, at = (*labels, self.text[at]), at + 2
            elif row is None:
                self.unknown(at)
                return ()
            elif row.terminated:
                operands = self.operands(row, at + 1)
                if operands is not None:
                    self.add(begin, len(self.text), row, operands, labels)
                return ()
            else:  # Q has no terminator, so the next command may stand directly behind it
                if labels:
                    self.error(begin, at + 1, "bad-label", f"{labels[-1]}$ without an instruction", "", LABELS)
                self.add(at, at + 1, row, (), ())
                labels, at = (), at + 1
                begin = at
                if self.text[at : at + 1].isspace():
                    self.behind_quit(row, at)
                    return ()
        return labels

    def add(self, begin: int, end: int, row: Row, operands: tuple[Operand, ...], labels: tuple[str, ...]) -> None:
        place = self.spot(begin, end)
        self.source.items.append(Statement(place.line, place.column, self.text[begin:end], row, operands, labels))

    def is_label(self, at: int) -> bool:
        letter, letters = self.text[at], self.sheet.labels
        if letter not in letters:
            allowed = f"{letters[0]}..{letters[-1]}" if letters else "no labels on this part"
            self.error(at, at + 2, "bad-label", f"label {letter}$", allowed, LABELS)
            return False
        if self.text[at + 2 : at + 3].isspace():
            remedy = f"write the instruction directly behind {letter}$"
            self.error(at, at + 2, "bad-label", f"{letter}$ with a space behind it", "", LABELS, remedy)
            return False
        return True

    def unknown(self, at: int) -> None:
        letter = self.text[at]
        known = letter.upper() in self.sheet.commands.by_form
        letters = " ".join(row.form for row in self.sheet.commands)
        remedy = f"write {letter.upper()}: command letters are upper case" if known else ""
        self.error(at, at + 1, "unknown-command", f"{letter} is no command", letters, "", remedy)

    def behind_quit(self, row: Row, at: int) -> None:
        argument = self.text[at:].lstrip()
        first, end = len(self.text) - len(argument), len(self.text)
        remedy = f"{row.form} stands alone: it ends by itself"
        self.error(first, end, "extra-argument", f"{row.name} with {argument}", "no argument", row.where, remedy)

    def operands(self, row: Row, at: int) -> tuple[Operand, ...] | None:
        """The arguments; None if there are too few, or one of them is no number."""
        rest, needed = self.text[at:], len(row.args)
        words = list(_WORD.finditer(rest))
        takes = " and ".join(arg.name for arg in row.args) or "no argument"
        if len(words) > needed:
            first = at + words[needed].start()
            self.error(
                first, len(self.text), "extra-argument", f"{row.name} with {self.text[first:]}", takes, row.where
            )
        elif len(words) < needed:
            found = f"{row.name} without {row.args[len(words)].name}"
            self.error(len(self.text), len(self.text) + 1, "missing-argument", found, takes, row.where)
            return None
        elif needed:
            self.spacing(row, at)
        operands = [
            self.operand(row, arg, word[0], at + word.start()) for arg, word in zip(row.args, words, strict=False)
        ]
        known = tuple(operand for operand in operands if operand is not None)
        return known if len(known) == needed else None

    def spacing(self, row: Row, at: int) -> None:
        """The chip is expected to forgive spaces; a text that shall stay readable writes one."""
        rest, end = self.text[at:], len(self.text)
        if not _ARGUMENTS.fullmatch(rest.strip(" ")):
            allowed = "one comma or one space between arguments"
            self.error(at, end, "bad-number", f"{row.name} {rest.strip()}", allowed, row.where)
        elif not rest.startswith(" ") or re.search("  |, | ,", rest):
            remedy = f"write {row.form} {','.join(_WORD.findall(rest))}"
            found = f"spacing of {row.form}{rest}"
            self.source.report(self.spot(at, end), "spacing", "note", found, section="s.3", remedy=remedy)

    def operand(self, row: Row, arg: Arg, word: str, at: int) -> Operand | None:
        named = f"{row.name} {arg.name} {word}" if len(row.args) > 1 else f"{row.name} {word}"
        section = row.where.split("; ")[-1]  # ranges stand in the table, which is named last
        allowed = f"{arg.low}..{arg.high}"
        place = self.spot(at, at + len(word))
        if word.isascii() and word.isdigit():
            number = int(word)
            if not arg.low <= number <= arg.high:
                remedy = f"the nearest is {min(max(number, arg.low), arg.high)}"
                self.error(at, at + len(word), "range", named, allowed, section, remedy)
            return Operand(*place, number % arg.modulus)
        if arg.label and len(word) == 1 and word in self.sheet.labels:
            return Operand(*place, ord(word), word)
        if arg.label and self.sheet.labels:
            allowed += f" or a label {self.sheet.labels[0]}..{self.sheet.labels[-1]}"
        self.error(at, at + len(word), "bad-number", named, allowed, section, "numbers are decimal digits alone")
        return None


# --------------------------------------------------------------------------------------------------- the programs in it


def _lay_out(source: Source, bare: bool) -> None:
    """Tell programs from command mode, and give the instructions of each program their addresses."""
    items, source.items = source.items, []
    has_entry = any(isinstance(item, Statement) and item.row.name == "ENTER" for item in items)
    block = Block() if bare and not has_entry else None
    if block:
        source.blocks.append(block)
    for item in items:
        if isinstance(item, Directive):
            pass
        elif block is not None and item.row.stored:
            item = _place(source, block, item)
        elif block is not None:
            block.quit, block = item, None
        elif item.row.name == "ENTER":
            block = Block(entry=item)
            source.blocks.append(block)
        elif item.labels:
            remedy = "labels name instructions of a program, between E and Q"
            source.report(item, "label-outside", "warning", "a label in command mode", section=LABELS, remedy=remedy)
        source.items.append(item)


def _place(source: Source, block: Block, statement: Statement) -> Statement:
    statement = replace(statement, block=len(source.blocks) - 1, address=block.size)
    for letter in statement.labels:
        if letter in block.labels:
            found = f"label {letter}$ a second time; the chip would take the last one"
            source.report(statement, "label-twice", "error", found, section=LABELS, remedy="use another letter")
        block.labels[letter] = statement.address
    block.statements.append(statement)
    return statement
