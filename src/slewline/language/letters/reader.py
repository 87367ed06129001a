"""A line of letters with numbers after them, taken apart: R 80, A$N 100, L 6,A."""

from __future__ import annotations

import re

from ...core.datasheet.table import Arg, Row
from ..dialect import dialect_of, number_meant, slip_remedy, unknown_remedy
from ..reader import Reader
from ..statements import Operand, Source
from .decoder import LINE_LIMIT

_WORD = re.compile(r"[^ ,]+")
_ARGUMENTS = re.compile(r"[^ ,]+(?:(?: *, *| +)[^ ,]+)*")


class LetterReader(Reader):
    """Takes one line apart, in which several commands may stand one after the other."""

    def __init__(self, source: Source, number: int, column: int, text: str) -> None:
        super().__init__(source, number, column, text)
        self.dialect = dialect_of(self.sheet)
        self.about_labels = self.sheet.sections.get("labels", "")

    def take(self, labels: tuple[str, ...]) -> tuple[str, ...]:
        """Read the line after its labels; return the labels that still wait for an instruction."""
        if len(self.text) > LINE_LIMIT:
            self.error(0, len(self.text), "too-long", f"{len(self.text)} characters", f"{LINE_LIMIT}")
            return ()
        at = begin = 0
        while at < len(self.text):
            row = self.sheet.commands.by_form.get(self.text[at])
            if self.dialect.mark and self.text[at + 1 : at + 2] == self.dialect.mark:
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
            else:  # without a terminator, so the next command may stand directly after it
                if labels:
                    self.unnamed(begin, at + 1, labels)
                self.add(at, at + 1, row, (), ())
                labels, at = (), at + 1
                begin = at
                if self.text[at : at + 1].isspace():
                    self.behind(row, at)
                    return ()
        return labels

    def end(self, labels: tuple[str, ...]) -> None:
        """Report labels at the end of a text, without an instruction."""
        self.unnamed(0, len(self.text), labels)

    def unnamed(self, at: int, end: int, labels: tuple[str, ...]) -> None:
        """Report the last of some labels as one without an instruction, in columns `at` to `end`."""
        found = f"{self.dialect.label(labels[-1])} without an instruction"
        self.error(at, end, "bad-label", found, "", self.about_labels)

    def is_label(self, at: int) -> bool:
        """Return whether the letter at a column begins a label; report a letter that the part does not have."""
        letter, letters = self.text[at], self.sheet.labels
        label = self.dialect.label(letter)
        if letter not in letters:
            allowed = f"{letters[0]}..{letters[-1]}" if letters else "no labels on this part"
            self.error(at, at + 2, "bad-label", f"label {label}", allowed, self.about_labels)
            return False
        if self.text[at + 2 : at + 3].isspace():
            remedy = f"write the instruction directly after {label}"
            self.error(at, at + 2, "bad-label", f"{label} with a space after it", "", self.about_labels, remedy)
            return False
        return True

    def unknown(self, at: int) -> None:
        """Report the letter at a column: no command begins with it."""
        letter = self.text[at]
        letters = " ".join(row.form for row in self.sheet.commands)
        remedy = unknown_remedy(self.sheet, letter)
        self.error(at, at + 1, "unknown-command", f"{letter} is not a command", letters, "", remedy)

    def behind(self, row: Row, at: int) -> None:
        """Report text after a command that takes no argument."""
        argument = self.text[at:].lstrip()
        first, end = len(self.text) - len(argument), len(self.text)
        remedy = self.without(row, argument)
        found = f"{argument} after {row.name}, which takes no argument"
        self.error(first, end, "extra-argument", found, "", row.where, remedy)

    def without(self, row: Row, extra: str) -> str:
        """Return the remedy for text after the end of a command: another command has a line of its own."""
        if odd := slip_remedy(self.sheet, extra):  # a character, which explains all
            return odd
        elsewhere = "" if row.args else slip_remedy(self.sheet, "", row)
        extra = extra.lstrip(" ,;\t").rstrip()
        begins = not extra[:1].isdigit() and extra[:1] in self.sheet.commands.by_form
        says = f"write {extra} on a line of its own" if begins else f"leave out {extra}"
        return f"{says}; {elsewhere}" if elsewhere else says

    def operands(self, row: Row, at: int) -> tuple[Operand, ...] | None:
        """The arguments; None if there are too few, or one of them is no number."""
        rest, needed = self.text[at:], len(row.args)
        words = list(_WORD.finditer(rest))
        end = len(self.text)
        if len(words) > needed:
            first = at + words[needed].start()
            found = f"{self.text[first:]} after {row.name}, which takes {row.takes}"
            remedy = self.without(row, self.text[first:])
            self.error(first, end, "extra-argument", found, "", row.where, remedy)
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
            section = self.sheet.sections.get("text", "")
            self.source.report(self.spot(at, end), "spacing", "note", found, section=section, remedy=remedy)

    def operand(self, row: Row, arg: Arg, word: str, at: int) -> Operand | None:
        """Return the value of an argument from its word at a column; None, with a report: it is none."""
        named = f"{row.name} {arg.name} {word}" if len(row.args) > 1 else f"{row.name} {word}"
        section = row.where.split("; ")[-1]  # ranges are in the table, which is named last
        place = self.spot(at, at + len(word))
        if word.isascii() and word.isdigit():
            number = int(word)
            if not arg.low <= number <= arg.high:
                remedy = self.into_range(row, arg, number)
                self.error(at, at + len(word), "range", named, f"{arg.low}..{arg.high}", section, remedy)
            return Operand(*place, arg.fit(number))
        if arg.label and len(word) == 1 and word in self.sheet.labels:
            return Operand(*place, ord(word), word)
        remedy = number_meant(word) or slip_remedy(self.sheet, word) or "numbers are decimal digits alone"
        self.error(at, at + len(word), "bad-number", named, self.allowed(arg), section, remedy)
        return None

    def into_range(self, row: Row, arg: Arg, number: int) -> str:
        """Return the remedy for a number out of range: the nearest one, but no other place for a target."""
        if "t" in row.flow and arg is row.args[-1]:
            return "a target is the address of an instruction of this program, as slewline asm lists them"
        return f"the nearest is {min(max(number, arg.low), arg.high)}"

    def allowed(self, arg: Arg) -> str:
        """Return what an argument may be, in words."""
        letters = self.sheet.labels if arg.label else ""
        return f"{arg.low}..{arg.high}" + (f" or a label {letters[0]}..{letters[-1]}" if letters else "")
