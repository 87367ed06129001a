"""Program text: lines in, statements with places out.  Assembler and linter read the same statements.

A text holds what a host would send, a command a line.  To a CY525:

    ; weld.cy525                 a comment runs to the end of the line
    R 80                         before E: command mode
    E                            program entry begins
    A$N 100                      a label stands directly in front of its instruction, or alone on the line above
    L 6,A                        two arguments: a comma or a space between them
    Q                            program entry ends; QX on one line is Q and then X
    X
    @wait 20 ms                  a directive to the host, none of the chip's business

and to a GS-C200S, whose commands are lines without address and checksum:

    Po                           program entry begins
    S10
    jc1,18
    E                            program entry ends, and the program runs

and to an MC1451A, which has no programs, only packets:

    SET_POS 12345                a mnemonic and a number; language/packets.py
    wait motion_complete         a directive to the host

Nothing here raises.  What is wrong with a text becomes a `Problem` with a place, so that all of them can be shown at
once; a statement that the chip would still take is kept beside its problem, so that the
addresses behind it are right.
"""

from __future__ import annotations

import re
from dataclasses import replace

from ..core.table import Arg, Row, Sheet
from . import packets
from .dialects import LINE_LIMIT, Command, slip_remedy, unknown_remedy
from .lines import SIGN, Refusal, parse, places, usage
from .problems import Place
from .statements import Block, Directive, Operand, Source, Statement

LABELS = "s.3"  # the manual's section about labels
_WORD = re.compile(r"[^ ,]+")
_ARGUMENTS = re.compile(r"[^ ,]+(?:(?: *, *| +)[^ ,]+)*")


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

    A text that never enters a program is one stored program if `bare` is set, else it is what a host sends in command
    mode.
    """
    source = Source(sheet)
    kind = _CommandLine if sheet.in_lines else _PacketLine if sheet.in_packets else _Line
    pending: tuple[str, ...] = ()
    line = None
    for number, column, body in host_lines(text):
        if body.startswith("@") or (sheet.in_packets and body.split()[0].lower() in packets.DIRECTS):
            source.items.append(Directive(number, column, body))
        else:
            line = kind(source, number, column, body)
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
        letters = " ".join(row.form for row in self.sheet.commands)
        remedy = unknown_remedy(self.sheet, letter)
        self.error(at, at + 1, "unknown-command", f"{letter} is no command", letters, "", remedy)

    def behind_quit(self, row: Row, at: int) -> None:
        argument = self.text[at:].lstrip()
        first, end = len(self.text) - len(argument), len(self.text)
        remedy = slip_remedy(self.sheet, argument, row) or f"{row.form} stands alone: it ends by itself"
        found = f"{argument} behind {row.name}, which takes no argument"
        self.error(first, end, "extra-argument", found, "", row.where, remedy)

    def operands(self, row: Row, at: int) -> tuple[Operand, ...] | None:
        """The arguments; None if there are too few, or one of them is no number."""
        rest, needed = self.text[at:], len(row.args)
        words = list(_WORD.finditer(rest))
        end = len(self.text)
        if len(words) > needed:
            first = at + words[needed].start()
            found = f"{self.text[first:]} behind {row.name}, which takes {row.takes}"
            self.error(
                first, end, "extra-argument", found, "", row.where, slip_remedy(self.sheet, self.text[first:], row)
            )
        elif len(words) < needed:
            arg = row.args[len(words)]
            found, remedy = f"{row.name} without {arg.name}", slip_remedy(self.sheet, rest, row)
            self.error(end, end + 1, "missing-argument", found, self.allowed(arg), row.where, remedy)
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
        place = self.spot(at, at + len(word))
        if word.isascii() and word.isdigit():
            number = int(word)
            if not arg.low <= number <= arg.high:
                remedy = f"the nearest is {min(max(number, arg.low), arg.high)}"
                self.error(at, at + len(word), "range", named, f"{arg.low}..{arg.high}", section, remedy)
            return Operand(*place, arg.fit(number))
        if arg.label and len(word) == 1 and word in self.sheet.labels:
            return Operand(*place, ord(word), word)
        remedy = slip_remedy(self.sheet, word) or "numbers are decimal digits alone"
        self.error(at, at + len(word), "bad-number", named, self.allowed(arg), section, remedy)
        return None

    def allowed(self, arg: Arg) -> str:
        """Return what an argument may be, in words."""
        letters = self.sheet.labels if arg.label else ""
        return f"{arg.low}..{arg.high}" + (f" or a label {letters[0]}..{letters[-1]}" if letters else "")


class _CommandLine(_Line):
    """A line that is one command, as the GS-C modules take them."""

    def take(self, labels: tuple[str, ...]) -> tuple[str, ...]:
        port, text = self.sheet.port, self.text
        if port is not None and len(text) > port.longest:
            self.error(
                0, len(text), "too-long", f"{len(text)} characters", f"{port.longest}", port.where.split("; ")[-1]
            )
            return ()
        found = parse(self.sheet, text)
        if isinstance(found, Refusal):
            self.refused(found)
            return ()
        pairs = zip(places(found.row, text), found.values, strict=True)
        operands = tuple(Operand(*self.spot(at, end), value) for (at, end), value in pairs)
        self.add(0, len(text), found.row, operands, ())
        return ()

    def refused(self, found: Refusal) -> None:
        letter = SIGN if self.text[0] in "+-" else self.text[0]
        alike = [row for row in self.sheet.commands if row.head[0] == letter]
        unknown, remedy = found.code == "unknown", ""
        code = {"unknown": "unknown-command", "argument": "bad-argument"}.get(found.code, found.code)
        if word := slip_remedy(self.sheet, self.text):
            remedy = word
        elif meant := self.meant():
            remedy = f"write {meant}: no blanks, and capitals count"
        elif unknown and alike:
            remedy = f"with this letter it has {', '.join(map(usage, alike))}"
        elif unknown and self.text.startswith(self.sheet.foreign):
            remedy = "a sister part has this command"
        where = "" if unknown else alike[0].where
        self.error(found.at, found.end, code, found.found, found.allowed, where, remedy)

    def meant(self) -> str:
        """The command that the line would be with other capitals, or without blanks."""
        tight = self.text.replace(" ", "")
        spellings = (tight, tight.lower(), tight.capitalize())
        return next((spelling for spelling in spellings if isinstance(parse(self.sheet, spelling), Command)), "")


class _PacketLine(_Line):
    """A line that is one packet, as the MC1451A takes them."""

    def take(self, labels: tuple[str, ...]) -> tuple[str, ...]:
        found = packets.parse(self.sheet, self.text)
        if isinstance(found, Refusal):
            where = self.sheet.packets.where if self.sheet.packets else ""
            self.error(found.at, found.end, found.code, found.found, found.allowed, where, found.remedy)
            return ()
        at = len(self.text) - len(self.text.split()[-1])
        operands = tuple(Operand(*self.spot(at, len(self.text)), value) for value in found.values)
        self.add(0, len(self.text), found.row, operands, ())
        return ()


# --------------------------------------------------------------------------------------------------- the programs in it


def _lay_out(source: Source, bare: bool) -> None:
    """Tell programs from command mode, and give the instructions of each program their addresses."""
    items, source.items = source.items, []
    enter, leave = source.sheet.enter, source.sheet.leave
    has_entry = any(isinstance(item, Statement) and item.row.name == enter for item in items)
    block = Block() if bare and not has_entry else None
    if block:
        source.blocks.append(block)
    for item in items:
        if isinstance(item, Directive):
            pass
        elif block is not None and item.row.coded:
            item = _place(source, block, item)
        elif item.row.name == enter:
            block = Block(entry=item)
            source.blocks.append(block)
        elif block is not None and item.row.name in leave:
            block.quit, block = item, None
        else:
            _outside(source, item, block)
        source.items.append(item)


def _outside(source: Source, item: Statement, block: Block | None) -> None:
    """A command that does not become part of a program: may it come here?"""
    row = item.row
    if item.labels:
        remedy = "labels name instructions of a program, between E and Q"
        source.report(item, "label-outside", "warning", "a label in command mode", section=LABELS, remedy=remedy)
    if block is not None and "p" not in row.when:
        ends = " or ".join(source.sheet.commands.named(name).form for name in source.sheet.leave)
        remedy = f"end program entry first, with {ends}"
        source.report(item, "not-now", "error", f"{item.text} during program entry", section=row.where, remedy=remedy)
    elif block is None and "i" not in row.when:
        enter = source.sheet.commands.named(source.sheet.enter).form
        remedy = f"begin program entry with {enter}"
        source.report(item, "not-now", "error", f"{item.text} outside a program", section=row.where, remedy=remedy)


def _place(source: Source, block: Block, statement: Statement) -> Statement:
    statement = replace(statement, block=len(source.blocks) - 1, address=block.size)
    for letter in statement.labels:
        if letter in block.labels:
            found = f"label {letter}$ a second time; the chip would take the last one"
            source.report(statement, "label-twice", "error", found, section=LABELS, remedy="use another letter")
        block.labels[letter] = statement.address
    block.statements.append(statement)
    return statement
