"""A reader that executes LinuxCNC G-code without a machine, as far as the writers use it.

It handles words, parameters, expressions and O-words.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import suppress
from typing import NamedTuple

from ..target_writer import PlayedTrace, WriterOptions
from .surroundings import Enough, RefusedLine, Surroundings

AXES = "XYZABCUVW"
LONGEST = 255  # maximum number of characters in a line, including its comment
O_WORD = re.compile(r"o(?:(\d+)|<(\w+)>)\s*(\w+)\s*(.*)$", re.IGNORECASE)
TOKEN = re.compile(r"\s*(?:(\d+\.?\d*|\.\d+)|#(?:<(\w+)>|(\d+))|([A-Za-z]+)|(.))")
LOGIC: dict[str, Callable[[float, float], float]] = {
    "EQ": lambda a, b: float(abs(a - b) < 1e-6),
    "NE": lambda a, b: float(abs(a - b) >= 1e-6),
    "GT": lambda a, b: float(a > b),
    "GE": lambda a, b: float(a >= b),
    "LT": lambda a, b: float(a < b),
    "LE": lambda a, b: float(a <= b),
    "AND": lambda a, b: float(bool(a) and bool(b)),
    "OR": lambda a, b: float(bool(a) or bool(b)),
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
}
BINDS = {"*": 4, "/": 4, "+": 3, "-": 3, "EQ": 2, "NE": 2, "GT": 2, "GE": 2, "LT": 2, "LE": 2, "AND": 1, "OR": 1}
PLAIN = {"G1", "G4", "G21", "G38.3", "G38.5", "G61.1", "G90", "G91", "G92", "G94", "M2", "M64", "M65", "M66"}


class _Line(NamedTuple):
    number: int
    text: str
    label: str  # name of an O-word
    word: str  # "sub", "while" ...
    rest: str


class _Ended(Exception):
    """The end of the program: M2, or the end of the file."""


class _Return(Exception):
    """The return from a subroutine."""


def read(text: str, options: WriterOptions) -> PlayedTrace:
    """Return the events of a LinuxCNC program.

    Raises:
        RefusedLine: LinuxCNC would not accept a line.
    """
    machine = _OWordMachine(text, options)
    stopped = False
    try:
        machine.run(0, len(machine.lines))
    except _Ended:
        pass
    except Enough:
        stopped = True
    return machine.around.trace("read back", stopped)


class _OWordMachine:
    def __init__(self, text: str, options: WriterOptions) -> None:
        self.around = Surroundings(options)
        self.lines = list(self._lines(text))
        self.parameters: dict[str, float] = {"5399": 0.0}
        self.at: dict[str, float] = dict.fromkeys(AXES, 0.0)  # position of the machine, mm
        self.offset: dict[str, float] = dict.fromkeys(AXES, 0.0)  # G92 offset
        self.absolute, self.feed, self.metric = True, 0.0, False
        self.subs: dict[str, tuple[int, int]] = {}

    @staticmethod
    def _lines(text: str) -> list[_Line]:
        found = []
        for number, line in enumerate(text.splitlines(), 1):
            if len(line) > LONGEST:
                raise RefusedLine(number, line[:40], f"more than {LONGEST} characters")
            code = re.sub(r"\([^)]*\)", "", line.partition(";")[0]).strip()
            if not code:
                continue
            word = O_WORD.match(code)
            if word:
                label = word[1] or word[2].lower()
                found.append(_Line(number, code, label, word[3].lower(), word[4].strip()))
            else:
                found.append(_Line(number, code, "", "", ""))
        return found

    # -------------------------------------------------------------------------------------------------------- o-words
    def run(self, start: int, end: int) -> None:
        """Run the lines from index `start` up to, but not including, `end`."""
        place = start
        while place < end:
            self.around.statement()
            line = self.lines[place]
            if not line.label:
                self._block(line)
                place += 1
                continue
            place = self._flow(line, place)

    def _flow(self, line: _Line, place: int) -> int:
        """Run the O-word line at index `place`, and any block that it begins; return the next index to run."""
        match line.word:
            case "sub":
                last = self._find(place, line.label, "endsub")
                self.subs[line.label] = (place + 1, last)
                return last + 1
            case "call":
                if line.label not in self.subs:
                    raise RefusedLine(line.number, line.text, "called before it is defined")
                with suppress(_Return):
                    self.run(*self.subs[line.label])
                return place + 1
            case "return":
                raise _Return
            case "repeat":
                last = self._find(place, line.label, "endrepeat")
                for _ in range(round(self._value(line.rest, line))):
                    self.run(place + 1, last)
                return last + 1
            case "while":
                last = self._find(place, line.label, "endwhile")
                while self._value(line.rest, line):
                    self.around.statement()
                    self.run(place + 1, last)
                return last + 1
            case "do":
                last = self._find(place, line.label, "while")
                self.run(place + 1, last)
                while self._value(self.lines[last].rest, line):
                    self.run(place + 1, last)
                return last + 1
            case "if":
                return self._if(line, place)
            case _:
                raise RefusedLine(line.number, line.text, "unknown O-word")

    def _if(self, line: _Line, place: int) -> int:
        last = self._find(place, line.label, "endif")
        middle = next(
            (at for at in range(place + 1, last) if self.lines[at][2:4] == (line.label, "else")),
            last,
        )
        if self._value(line.rest, line):
            self.run(place + 1, middle)
        elif middle < last:
            self.run(middle + 1, last)
        return last + 1

    def _find(self, place: int, label: str, word: str) -> int:
        for at in range(place + 1, len(self.lines)):
            if self.lines[at].label == label:
                if self.lines[at].word == word:
                    return at
                if self.lines[at].word not in ("else", "return"):
                    break
        raise RefusedLine(self.lines[place].number, self.lines[place].text, f"o{label} {word} is missing")

    # --------------------------------------------------------------------------------------------------- expressions
    def _value(self, text: str, line: _Line) -> float:
        if not (text.startswith("[") and text.endswith("]")):
            raise RefusedLine(line.number, line.text, "a condition is in brackets")
        value, rest = self._primary(text, line)
        if rest.strip():
            raise RefusedLine(line.number, line.text, f"unread: {rest}")
        return value

    def _primary(self, text: str, line: _Line) -> tuple[float, str]:
        """Return the value at the start of `text`, and the text after it.

        The value is a number, a parameter or an expression in brackets, with or without a sign.
        """
        found = TOKEN.match(text)
        if not found:
            raise RefusedLine(line.number, line.text, "a value is missing")
        digits, name, place, word, sign = found.groups()
        rest = text[found.end() :]
        if digits:
            return float(digits), rest
        if name or place:
            key = (name or place).lower()
            if key == "5420":
                return self.at["X"] - self.offset["X"], rest
            if key not in self.parameters:
                raise RefusedLine(line.number, line.text, f"#<{key}> has no value")
            return self.parameters[key], rest
        if sign in "+-":
            value, rest = self._primary(rest, line)
            return (-value if sign == "-" else value), rest
        if sign == "[":
            value, rest = self._sum(rest, line, 0)
            if not rest.lstrip().startswith("]"):
                raise RefusedLine(line.number, line.text, "] is missing")
            return value, rest.lstrip()[1:]
        raise RefusedLine(line.number, line.text, f"no value: {word or sign}")

    def _sum(self, text: str, line: _Line, least: int) -> tuple[float, str]:
        """Return the value of the expression at the start of `text`, and the text after it.

        The expression ends before the first operator that does not bind more tightly than `least`.
        """
        value, rest = self._primary(text, line)
        while found := TOKEN.match(rest):
            operator = (found[4] or found[5] or "").upper()
            if BINDS.get(operator, 0) <= least:
                break
            right, rest = self._sum(rest[found.end() :], line, BINDS[operator])
            value = LOGIC[operator](value, right)
        return value, rest

    # ---------------------------------------------------------------------------------------------------------- blocks
    def _block(self, line: _Line) -> None:
        """Run a line without an O-word: G-code words, or the assignment of a value to a parameter."""
        assigned = re.match(r"#(?:<(\w+)>|(\d+))\s*=\s*(.+)$", line.text)
        if assigned:
            value, rest = self._sum(assigned[3], line, 0)
            if rest.strip():
                raise RefusedLine(line.number, line.text, f"unread: {rest}")
            self.parameters[(assigned[1] or assigned[2]).lower()] = value
            return
        codes: list[str] = []
        words: dict[str, float] = {}
        rest = line.text
        while rest.strip():
            letter, rest = rest.strip()[0].upper(), rest.strip()[1:]
            value, rest = self._primary(rest, line)
            if letter in "GM":
                codes.append(f"{letter}{value:g}")
            elif letter in words:
                raise RefusedLine(line.number, line.text, f"{letter} twice")
            else:
                words[letter] = value
        unknown = [code for code in codes if code not in PLAIN]
        if unknown:
            raise RefusedLine(line.number, line.text, f"unknown: {unknown[0]}")
        self._do(line, codes, words)

    def _do(self, line: _Line, codes: list[str], words: dict[str, float]) -> None:
        self.feed = words.get("F", self.feed)
        for code in codes:
            if code in ("G90", "G91"):
                self.absolute = code == "G90"
            elif code == "G21":
                self.metric = True
        for code in codes:
            self._code(line, code, words)

    def _code(self, line: _Line, code: str, words: dict[str, float]) -> None:
        match code:
            case "G4":
                self.around.delay(round(words["P"] * 10**12))
            case "G92":
                for letter in words.keys() & set(AXES):
                    self.offset[letter] = self.at[letter] - words[letter]
            case "G1" | "G38.3" | "G38.5":
                if not self.feed or not self.metric:
                    raise RefusedLine(line.number, line.text, "no feed rate, or no unit, has been set")
                self._move(words, runs=code != "G1")
            case "M64" | "M65":
                self.around.output(round(words["P"]) + 1, int(code == "M64"))
            case "M66":
                self._input(round(words["P"]) + 1, round(words["L"]), words.get("Q", 0), line)
            case "M2":
                raise _Ended
            case _:
                pass

    def _input(self, number: int, mode: int, timeout: float, line: _Line) -> None:
        if mode and timeout <= 0:
            raise RefusedLine(line.number, line.text, "a wait needs Q above 0")
        if mode:
            self.around.wait(number, {3: 1, 4: 0}[mode])
        self.parameters["5399"] = {3: 1, 4: 0}.get(mode, self.around.level(number))

    def _move(self, words: dict[str, float], runs: bool) -> None:
        for letter in AXES:
            if letter not in words:
                continue
            base = self.offset[letter] if self.absolute else self.at[letter]
            spm = self.around.steps_per_mm
            before, self.at[letter] = self.at[letter], base + words[letter]
            steps = round(self.at[letter] * spm) - round(before * spm)
            if runs:
                self.around.run(AXES.index(letter) + 1, 1 if steps > 0 else -1)
            else:
                self.around.move(AXES.index(letter) + 1, steps)
