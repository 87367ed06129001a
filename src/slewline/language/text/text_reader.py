"""The parser for lines of letters with arguments: R 80, A$N 100, L 6,A; R 87H, /B 2, L #,16, ? M,2, "done"."""

from __future__ import annotations

import re

from ...core.datasheet.command_rows import TextRow
from ...core.datasheet.table import Arg, Row
from ..dialect import slip_remedy, spoken_as, unknown_remedy
from ..line_reader import Reader
from ..statements import Operand, Source
from .forms import TextDialect
from .written_values import BETWEEN, number, query_meant

_WORD = re.compile(r"[^ ,]+")
_ARGUMENTS = re.compile(r"[^ ,]+(?:(?: *, *| +)[^ ,]+)*")


class TextReader(Reader):
    """A parser of one line, which may contain several commands."""

    def __init__(self, source: Source, number: int, column: int, text: str) -> None:
        super().__init__(source, number, column, text)
        self.spoken = spoken_as(self.sheet, TextDialect)

    def take(self, labels: tuple[str, ...]) -> tuple[str, ...]:
        """Read the commands of the line; return the labels that have no instruction yet.

        `labels` are labels from the lines above; they name the first command of this line.
        """
        text, spoken = self.text, self.spoken
        if not self.fits():
            return ()
        at = begin = 0
        while at < len(text):
            if spoken.mark and text[at + 1 : at + 2] == spoken.mark:
                if not self.is_label(at):
                    return ()
                labels, at = (*labels, text[at]), at + 2
                continue
            letter = at + (spoken.negate != "" and text.startswith(spoken.negate, at))
            row = self.sheet.rows(TextRow).by_form.get(text[letter : letter + 1])
            if row is None:
                self.unknown(min(letter, len(text) - 1))
                return ()
            if letter > at and row.form not in spoken.negated:
                found, allowed = f"{spoken.negate} in front of {row.name}", f"in front of {', '.join(spoken.negated)}"
                self.error(at, letter, "slash", found, allowed, row.where)
                return ()
            if row.terminated:
                operands = self.rest(row, letter + 1)
                if operands is not None:
                    self.add(begin, len(text), row, operands, labels)
                return ()
            at = letter + 1  # without a terminator, so the next command may stand directly after it
            if labels:
                self.unnamed(begin, at, labels)
            self.add(letter, at, row, (), ())
            labels, begin = (), at
            if text[at : at + 1].isspace():
                self.check_rest(row, at)
                return ()
        return labels

    def fits(self) -> bool:
        """Return whether the line can be sent; if not, report its length, or a character with a code above 255."""
        text, limit = self.text, self.spoken.line_limit
        odd = next((at for at, letter in enumerate(text) if ord(letter) > 0xFF), None)
        if len(text) > limit:
            self.error(0, len(text), "too-long", f"{len(text)} characters", f"{limit}")
            return False
        if odd is None or self.spoken.tokens:
            return True
        remedy = slip_remedy(self.sheet, text[odd])
        self.error(odd, odd + 1, "bad-character", f"{text[odd]!r}, which is not a byte", "", "", remedy)
        return False

    def unknown(self, at: int) -> None:
        """Report that the letter at a column is not a command."""
        letter = self.text[at]
        letters = " ".join(row.form for row in self.sheet.commands)
        remedy = unknown_remedy(self.sheet, letter)
        self.error(at, at + 1, "unknown-command", f"{letter} is not a command", letters, "", remedy)

    def check_rest(self, row: Row, at: int) -> None:
        """Report text after a command that takes no arguments."""
        argument = self.text[at:].lstrip()
        first, end = len(self.text) - len(argument), len(self.text)
        found = f"{argument} after {row.name}, which takes no argument"
        self.error(first, end, "extra-argument", found, "", row.where, self.without(row, argument))

    def without(self, row: Row, extra: str) -> str:
        """Return the remedy for text after a command: leave it out or, if it begins a command, use a new line."""
        if odd := slip_remedy(self.sheet, extra):  # a character that in itself explains the problem
            return odd
        elsewhere = "" if row.args else slip_remedy(self.sheet, "", row)
        extra = extra.lstrip(" ,;\t").rstrip()
        begins = not extra[:1].isdigit() and extra[:1] in self.sheet.commands.by_form
        message = f"write {extra} on a line of its own" if begins else f"leave out {extra}"
        return f"{message}; {elsewhere}" if elsewhere else message

    # ------------------------------------------------------------------------------------------------------- labels
    def end(self, labels: tuple[str, ...]) -> None:
        """Report that the text ends before the instruction to which `labels` refer."""
        self.unnamed(0, len(self.text), labels)

    def unnamed(self, at: int, end: int, labels: tuple[str, ...]) -> None:
        """Report, in columns `at` to `end`, that the last of `labels` has no instruction."""
        self.bad_label(at, end, f"{self.spoken.label(labels[-1])} without an instruction")

    def is_label(self, at: int) -> bool:
        """Return whether the label at a column is valid, and has no space after it; if not, report the label."""
        letter, letters = self.text[at], self.sheet.labels
        label = self.spoken.label(letter)
        if letter not in letters:
            allowed = f"{letters[0]}..{letters[-1]}" if letters else "no labels on this part"
            self.bad_label(at, at + 2, f"label {label}", allowed)
            return False
        if self.text[at + 2 : at + 3].isspace():
            remedy = f"write the instruction directly after {label}"
            self.bad_label(at, at + 2, f"{label} with a space after it", remedy=remedy)
            return False
        return True

    def bad_label(self, at: int, end: int, found: str, allowed: str = "", remedy: str = "") -> None:
        """Report a problem with a label, in columns `at` to `end`."""
        self.error(at, end, "bad-label", found, allowed, self.sheet.sections.get("labels", ""), remedy)

    # ---------------------------------------------------------------------------------------------------- arguments
    def rest(self, row: Row, at: int) -> tuple[Operand, ...] | None:
        """Return the arguments or, after reporting a problem, None if they cannot be sent.

        For a string, a query or a display command that can be sent, the arguments are ().
        """
        forms = {self.spoken.quote: self.string, self.spoken.query: self.asked, self.spoken.display: self.shown}
        if row.form not in forms:
            return self.operands(row, at)
        return () if forms[row.form](row, at) else None

    def operands(self, row: Row, at: int) -> tuple[Operand, ...] | None:
        """Return the arguments; None, after a report, if one is missing or is neither a number nor a label."""
        rest, needed = self.text[at:], len(row.args)
        words = list(_WORD.finditer(rest))
        end = len(self.text)
        if len(words) > needed:
            first = at + words[needed].start()
            found = f"{self.text[first:]} after {row.name}, which takes {row.takes}"
            self.error(first, end, "extra-argument", found, "", row.where, self.without(row, self.text[first:]))
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
        """Report wrong separators of arguments, and note unusual spaces, which the chip is expected to accept."""
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
        """Return the argument in a word at a column; None, after a report, if the word is not a valid argument.

        A number out of range is reported as well, but an argument is still returned.
        """
        end, place = at + len(word), self.spot(at, at + len(word))
        where = row.where.split("; ")[-1] if self.spoken.tokens else row.where  # a table of ranges is named last
        named = f"{row.name} {arg.name} {word}" if len(row.args) > 1 else f"{row.name} {word}"
        value, other = self.spoken.value(word), self.spoken.other(self.sheet, row, arg, word)
        if value is None:
            if other is not None:
                return Operand(*place, other, word)
            remedy = self.spoken.instead(self.sheet, word) or slip_remedy(self.sheet, word) or self.spoken.no_number
            self.error(at, end, "bad-number", named, self.allowed(arg), where, remedy)
            return None
        if not arg.low <= value <= arg.high:
            self.error(at, end, "range", named, f"{arg.low}..{arg.high}", where, self.into_range(row, arg, value))
        return Operand(*place, arg.fit(value))

    def into_range(self, row: Row, arg: Arg, number: int) -> str:
        """Return the remedy for a number out of range: the nearest allowed number.

        For a branch target, the remedy instead names the listing that shows the possible addresses.
        """
        if "t" in row.flow and arg is row.args[-1]:
            return "a target is the address of an instruction of this program, as slewline asm lists them"
        return f"the nearest is {min(max(number, arg.low), arg.high)}"

    def allowed(self, arg: Arg) -> str:
        """Return the allowed values of an argument, as text."""
        letters = self.sheet.labels if arg.label else ""
        return f"{arg.low}..{arg.high}" + (f" or a label {letters[0]}..{letters[-1]}" if letters else "")

    # ---------------------------------------------------------------------------------------- arguments of other kinds
    def string(self, row: Row, at: int) -> bool:
        """Read a string; report any text after its closing quotation mark; return whether it has that mark."""
        end = self.text.find(row.form, at)
        if end < 0:
            remedy = "a string ends with a quotation mark; a semicolon here would start a comment"
            self.error(0, len(self.text), "no-end-of-string", self.text, "", row.where, remedy)
            return False
        if self.text[end + 1 :]:
            found = f"{self.text[end + 1 :]} after a string"
            self.error(end + 1, len(self.text), "extra-argument", found, "", row.where)
        return True

    def asked(self, row: Row, at: int) -> bool:
        """Read a query, such as ? R or ? M,2; return whether it is valid, and report it if not."""
        words = BETWEEN.split(self.text[at:].strip()) if self.text[at:].strip() else []
        letters = (*self.spoken.queries, self.spoken.listing)
        listed = words[:1] == [self.spoken.listing]
        known = len(words) == 2 and number(words[1]) is not None if listed else len(words) == 1
        if known and words[0] in letters:
            return True
        found = f"{row.name} {' '.join(words)}".rstrip()
        allowed = f"{', '.join(self.spoken.queries)} and {self.spoken.listing},n"
        meant = query_meant(words[0], letters) if words else ""
        self.error(at, max(len(self.text), at + 1), "unknown-query", found, allowed, row.where, meant)
        return False

    def shown(self, row: Row, at: int) -> bool:
        """Read a display command (address, count, data), such as `[38H,2,65,66`, and return whether it can be sent."""
        words = BETWEEN.split(self.text[at:].strip().removesuffix("]"))
        numbers = [number(word) for word in words]
        if len(words) < 2 or None in numbers or any(found is not None and found > 0xFF for found in numbers):
            found, allowed = f"{row.name} {self.text[at:]}", "address, count and data, each 0..255"
            self.error(at, max(len(self.text), at + 1), "bad-number", found, allowed, row.where)
            return False
        if numbers[1] != len(numbers) - 2:
            found = f"{numbers[1]} values announced, {len(numbers) - 2} found"
            self.error(at, len(self.text), "count", found, "", row.where, "the smaller number would be used")
        return True
