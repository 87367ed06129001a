"""A line of a program text, taken apart: R 87H, /B 2, L #,16, ? M,2, "done"."""

from __future__ import annotations

from ...core.datasheet.table import Arg, Row
from ..dialect import slip_remedy, spoken_as
from ..letters.reader import LetterReader
from ..statements import Operand, Source
from .forms import Forms
from .grammar import BETWEEN, LINE_LIMIT, hint, number, query_meant


class VerbatimReader(LetterReader):
    """Takes one line apart, which is one command, kept as it stands; after one that ends by itself is another."""

    def __init__(self, source: Source, number: int, column: int, text: str) -> None:
        super().__init__(source, number, column, text)
        self.spoken: Forms = spoken_as(self.sheet, Forms)

    def take(self, labels: tuple[str, ...]) -> tuple[str, ...]:
        """Read the line after its labels; return the labels that still wait for an instruction."""
        text, spoken = self.text, self.spoken
        if len(text) > LINE_LIMIT:
            self.error(0, len(text), "too-long", f"{len(text)} characters", f"{LINE_LIMIT}")
            return ()
        odd = next((at for at, letter in enumerate(text) if ord(letter) > 0xFF), None)
        if odd is not None:
            remedy = slip_remedy(self.sheet, text[odd])
            self.error(odd, odd + 1, "bad-character", f"{text[odd]!r}, which is not a byte", "", "", remedy)
            return ()
        begin = 0
        while begin < len(text):
            at = begin + text.startswith(spoken.negate, begin)
            row = self.sheet.commands.by_form.get(text[at : at + 1])
            if row is None:
                self.unknown(min(at, len(text) - 1))
                return ()
            if at > begin and row.form not in spoken.negated:
                found, allowed = f"{spoken.negate} in front of {row.name}", f"in front of {', '.join(spoken.negated)}"
                self.error(begin, at, "slash", found, allowed, row.where)
                return ()
            operands = self.rest(row, at + 1)
            if operands is None:
                return ()
            end = len(text) if row.terminated else at + 1
            self.add(begin, end, row, operands, ())
            begin = end
        return ()

    def rest(self, row: Row, at: int) -> tuple[Operand, ...] | None:
        """What stands after the letter; None: it cannot be sent so."""
        if row.form == self.spoken.quote:
            return self.string(row, at)
        if row.form == self.spoken.query:
            return self.asked(row, at)
        if row.form == self.spoken.display:
            return self.shown(row, at)
        if row.terminated:
            return self.operands(row, at)
        if self.text[at : at + 1].isspace():
            self.behind(row, at)
            return None
        return ()

    def string(self, row: Row, at: int) -> tuple[Operand, ...] | None:
        """Characters up to the next quotation mark, which ends the line."""
        end = self.text.find(row.form, at)
        if end < 0:
            remedy = "a string ends with a quotation mark; a semicolon here would start a comment"
            self.error(0, len(self.text), "no-end-of-string", self.text, "", row.where, remedy)
            return None
        if self.text[end + 1 :]:
            found = f"{self.text[end + 1 :]} after a string"
            self.error(end + 1, len(self.text), "extra-argument", found, "", row.where)
        return ()

    def asked(self, row: Row, at: int) -> tuple[Operand, ...] | None:
        """? R, or ? M,2."""
        words = BETWEEN.split(self.text[at:].strip()) if self.text[at:].strip() else []
        spoken, end = self.spoken, len(self.text)
        allowed = f"{', '.join(spoken.queries)} and {spoken.listing},n"
        known = len(words) == 2 and number(words[1]) is not None if words[:1] == [spoken.listing] else len(words) == 1
        if not known or words[0] not in (*spoken.queries, spoken.listing):
            found = f"{row.name} {' '.join(words)}".rstrip()
            meant = query_meant(words[0], (*spoken.queries, spoken.listing)) if words else ""
            self.error(at, max(end, at + 1), "unknown-query", found, allowed, row.where, meant)
            return None
        return ()

    def shown(self, row: Row, at: int) -> tuple[Operand, ...] | None:
        """[38H,2,65,66: address, count and as many data."""
        words = BETWEEN.split(self.text[at:].strip().removesuffix("]"))
        numbers = [number(word) for word in words]
        if len(words) < 2 or None in numbers or any(found is not None and found > 0xFF for found in numbers):
            found, allowed = f"{row.name} {self.text[at:]}", "address, count and data, each 0..255"
            self.error(at, max(len(self.text), at + 1), "bad-number", found, allowed, row.where)
            return None
        if numbers[1] != len(numbers) - 2:
            found = f"{numbers[1]} values announced, {len(numbers) - 2} found"
            self.error(at, len(self.text), "count", found, "", row.where, "the smaller number would count")
        return ()

    def operand(self, row: Row, arg: Arg, word: str, at: int) -> Operand | None:
        """Return the value of an argument from its word at a column; None, with a report: it is none."""
        place = self.spot(at, at + len(word))
        if word == self.spoken.switches and arg is row.args[0]:
            return Operand(*place, 0, word)
        found = number(word)
        named = f"{row.name} {arg.name} {word}" if len(row.args) > 1 else f"{row.name} {word}"
        if found is None:
            switches = word == self.spoken.switches
            remedy = (
                "switches give the first argument only" if switches else hint(word) or slip_remedy(self.sheet, word)
            )
            self.error(at, at + len(word), "bad-number", named, self.allowed(arg), row.where, remedy)
            return None
        if not arg.low <= found <= arg.high:
            remedy = self.into_range(row, arg, found)
            self.error(at, at + len(word), "range", named, f"{arg.low}..{arg.high}", row.where, remedy)
        return Operand(*place, arg.fit(found))
