"""G-code as accepted by grbl 1.1: it has no expressions, O-words or inputs.

A line has at most 79 characters, not counting comments.
"""

from __future__ import annotations

import re
import struct

from ..target_writer import PlayedTrace, WriterOptions
from .surroundings import RefusedLine, Surroundings

LONGEST = 79  # LINE_BUFFER_SIZE is 80, with the end of the line
AXES = "XYZ"
GROUPS = (  # groups of modal words; two words of one group in a line are an error
    {"G0", "G1", "G38.2", "G38.3", "G38.4", "G38.5"},
    {"G90", "G91"},
    {"G20", "G21"},
    {"G93", "G94"},
    {"G4", "G92"},
    {"M0", "M2", "M30"},
    {"M3", "M4", "M5"},
    {"M8", "M9"},
)
WORD = re.compile(r"([A-Z])([-+]?\d+\.?\d*|[-+]?\.\d+)")


def single(value: float) -> float:
    """Return a number rounded to a 32-bit float, the format of all numbers in grbl."""
    return float(struct.unpack("f", struct.pack("f", value))[0])


def read(text: str, options: WriterOptions) -> PlayedTrace:
    """Return the events of a program.

    Raises:
        RefusedLine: grbl answers a line with an error.
    """
    machine = Machine(options)
    for number, line in enumerate(text.splitlines(), 1):
        machine.line(number, line)
    return machine.around.trace("read back")


class Machine:
    """A grbl board that processes one line after another, and that returns a status report on request."""

    def __init__(self, options: WriterOptions) -> None:
        self.around = Surroundings(options)
        self.at = dict.fromkeys(AXES, 0.0)  # position of the machine, mm
        self.offset = dict.fromkeys(AXES, 0.0)
        self.absolute, self.inches, self.feed = True, False, 0.0
        self.motion = "G0"
        self.ended = False

    def line(self, number: int, line: str) -> None:
        """Process a line.

        Raises:
            RefusedLine: grbl answers with an error.
        """
        code = re.sub(r"\([^)]*\)", "", line.partition(";")[0]).replace(" ", "").upper()
        if not code or self.ended:
            return
        if code.startswith("$"):
            return
        if len(code) > LONGEST:
            raise RefusedLine(number, line, f"more than {LONGEST} characters")
        found = WORD.findall(code)
        if "".join(letter + value for letter, value in found) != code:
            raise RefusedLine(number, line, "error 1 or 2: no word and number")
        codes = [f"{letter}{float(value):g}" for letter, value in found if letter in "GM"]
        words: dict[str, float] = {}
        for letter, value in found:
            if letter in "GM":
                continue
            if letter in words:
                raise RefusedLine(number, line, "error 25: a word twice")
            words[letter] = single(float(value))
        self._check(number, line, codes, words)
        self._do(number, line, codes, words)

    def _check(self, number: int, line: str, codes: list[str], words: dict[str, float]) -> None:
        for code in codes:
            if not any(code in group for group in GROUPS):
                raise RefusedLine(number, line, f"error 20: {code} is not supported")
        for group in GROUPS:
            if len(group & set(codes)) > 1 or len(codes) != len(set(codes)):
                raise RefusedLine(number, line, "error 21: two words of one group")
        unused = words.keys() - set(AXES) - {"F", "P", "S", "N"}
        if unused or ("P" in words) != ("G4" in codes):
            raise RefusedLine(number, line, "error 28 or 36: P is missing, or a word is not used")

    def _do(self, number: int, line: str, codes: list[str], words: dict[str, float]) -> None:
        self.feed = words.get("F", self.feed)
        for code in codes:
            self._code(code, words)
        axis_words = {letter: value for letter, value in words.items() if letter in AXES}
        if "G92" in codes:
            for letter, value in axis_words.items():
                self.offset[letter] = single(self.at[letter] - value)
        elif axis_words:
            if self.motion != "G0" and self.feed <= 0:
                raise RefusedLine(number, line, "error 22: no feed rate has been set")
            self._move(axis_words)
        if "M2" in codes or "M30" in codes:
            self.ended = True

    def _code(self, code: str, words: dict[str, float]) -> None:
        match code:
            case "G90" | "G91":
                self.absolute = code == "G90"
            case "G4":
                self.around.delay(round(words["P"] * 1e6) * 10**6)
            case "M8" | "M9":
                self.around.output(1, int(code == "M8"))
            case "M3" | "M5":
                self.around.output(2, int(code == "M3"))
            case _ if code in GROUPS[0]:
                self.motion = code
            case _:
                pass

    def _move(self, words: dict[str, float]) -> None:
        spm = single(self.around.steps_per_mm)
        for letter, value in words.items():
            base = self.offset[letter] if self.absolute else self.at[letter]
            before, self.at[letter] = self.at[letter], single(base + value)
            steps = round(single(self.at[letter] * spm)) - round(single(before * spm))
            axis = AXES.index(letter) + 1
            if self.motion.startswith("G38"):
                self.around.run(axis, 1 if steps > 0 else -1)
            else:
                self.around.move(axis, steps)

    def status(self, pins: str = "") -> str:
        """Return a status report that includes `pins`, the letters of the triggered pins."""
        fields = ["Idle", "MPos:" + ",".join(f"{self.at[letter]:.3f}" for letter in AXES), "FS:0,0"]
        return "<" + "|".join([*fields, f"Pn:{pins}"] if pins else fields) + ">"
