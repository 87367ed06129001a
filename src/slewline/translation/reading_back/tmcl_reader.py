"""TMCL: an assembler for its mnemonics, and a processor for its commands, according to the firmware manual."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import NamedTuple

from ..target_writer import PlayedTrace, WriterOptions
from .surroundings import Enough, RefusedLine, Surroundings

NUMBER = re.compile(r"-?\d+$")
LABEL = re.compile(r"[A-Za-z]\w*$")
# For each command: its number, and the kinds of its operands: a word, a number, a label.
COMMANDS: dict[str, tuple[int, tuple[object, ...]]] = {
    "ROR": (1, (int, int)),
    "ROL": (2, (int, int)),
    "MST": (3, (int,)),
    "MVP": (4, (("ABS", "REL"), int, int)),
    "SAP": (5, (int, int, int)),
    "GAP": (6, (int, int)),
    "SGP": (9, (int, int, int)),
    "GGP": (10, (int, int)),
    "RFS": (13, (("START", "STOP", "STATUS"), int)),
    "SIO": (14, (int, int, int)),
    "GIO": (15, (int, int)),
    "CALC": (19, (("ADD", "SUB", "MUL", "DIV", "MOD", "AND", "OR", "XOR", "NOT", "LOAD"), int)),
    "COMP": (20, (int,)),
    "JC": (21, (("ZE", "NZ", "EQ", "NE", "GT", "GE", "LT", "LE"), str)),
    "JA": (22, (str,)),
    "CSUB": (23, (str,)),
    "RSUB": (24, ()),
    "WAIT": (27, (("TICKS", "POS", "REFSW", "LIMSW", "RFS"), int, int)),
    "STOP": (28, ()),
    "CALCAV": (42, (("ADD", "SUB", "MUL"), int)),
    "MVPA": (46, (("ABS", "REL"), int)),
    "DJNZ": (49, (int, str)),
}
RANGES = {  # numbers of axis parameters
    0: (-(2**31), 2**31 - 1),
    1: (-(2**31), 2**31 - 1),
    4: (0, 7_999_774),
    5: (117, 7_629_278),
    16: (0, 1_000_000),
    17: (117, 7_629_278),
    19: (0, 249_999),
    20: (10, 249_999),
    35: (0, 1_000_000),
    140: (0, 8),
    193: (1, 8),
}
HOLDS: dict[str, Callable[[int], bool]] = {
    "ZE": lambda difference: difference == 0,
    "EQ": lambda difference: difference == 0,
    "NZ": lambda difference: difference != 0,
    "NE": lambda difference: difference != 0,
    "GT": lambda difference: difference > 0,
    "GE": lambda difference: difference >= 0,
    "LT": lambda difference: difference < 0,
    "LE": lambda difference: difference <= 0,
}
DEEPEST = 8  # subroutines


class _Command(NamedTuple):
    line: int
    text: str
    name: str
    operands: tuple[int | str, ...]


def assemble(text: str) -> list[_Command]:
    """Return the commands of a program, with addresses in place of labels.

    Raises:
        RefusedLine: the assembler would not accept a line.
    """
    commands: list[_Command] = []
    labels: dict[str, int] = {}
    for number, line in enumerate(text.splitlines(), 1):
        code = line.partition("//")[0].strip()
        label, mark, rest = code.partition(":")
        if mark:
            if not LABEL.match(label.strip()) or label.strip() in labels:
                raise RefusedLine(number, line, "invalid or repeated label")
            labels[label.strip()] = len(commands)
            code = rest.strip()
        if code:
            name, _, operands = code.partition(" ")
            words = [each.strip() for each in operands.split(",")] if operands.strip() else []
            commands.append(_Command(number, line, name, tuple(words)))
    return [_linked(each, labels) for each in commands]


def _linked(command: _Command, labels: dict[str, int]) -> _Command:
    kinds = COMMANDS.get(command.name, (0, None))[1]
    if kinds is None or len(kinds) != len(command.operands):
        raise RefusedLine(command.line, command.text, "unknown command, or a wrong number of operands")
    found: list[int | str] = []
    for kind, word in zip(kinds, command.operands, strict=True):
        word = str(word)
        if kind is int and NUMBER.match(word):
            found.append(int(word))
        elif kind is str and word in labels:
            found.append(labels[word])
        elif isinstance(kind, tuple) and word in kind:
            found.append(word)
        else:
            raise RefusedLine(command.line, command.text, f"no operand here: {word}")
    return command._replace(operands=tuple(found))


def binary(text: str, address: int = 1) -> bytes:
    """Return a program in the form in which a host sends it to the module with address `address`.

    Each command has nine bytes, including a checksum.
    """
    out = bytearray()
    for _, _, name, operands in assemble(text):
        code, kinds = COMMANDS[name]
        kind = motor = value = 0
        rest = list(operands)
        if rest and isinstance(kinds[0], tuple):
            kind = kinds[0].index(rest.pop(0))
        elif name not in ("ROR", "ROL", "MST", "JA", "CSUB", "COMP"):
            kind = int(rest.pop(0)) if rest else 0
        if len(rest) == 2 or name in ("ROR", "ROL", "MST", "GAP", "GGP", "GIO", "RFS", "MVPA", "CALCAV"):
            motor = int(rest.pop(0)) if rest else 0
        value = int(rest.pop(0)) if rest else 0
        command = bytes((address, code, kind, motor)) + (value & 0xFFFFFFFF).to_bytes(4, "big")
        out += command + bytes((sum(command) & 0xFF,))
    return bytes(out)


def read(text: str, options: WriterOptions) -> PlayedTrace:
    """Return the events of a TMCL program.

    Raises:
        RefusedLine: the assembler, or the module, would not accept a line.
    """
    processor = _Processor(assemble(text), options)
    stopped = False
    try:
        processor.run()
    except Enough:
        stopped = True
    return processor.around.trace("read back", stopped)


class _Processor:
    def __init__(self, program: list[_Command], options: WriterOptions) -> None:
        self.program, self.around = program, Surroundings(options)
        self.axis = {0: 0, 1: 0, 3: 0, 9: 1, 4: 0, 5: 0}
        self.variables = [0] * 256
        self.accumulator = self.difference = 0
        self.stack: list[int] = []
        self.at = 0
        self.reads = sorted({int(each.operands[0]) for each in program if each.name == "GIO"})
        waits = self.around.waits or list(range(1, len(self.reads) + 1))
        self.inputs = dict(zip(self.reads, waits, strict=False))

    def run(self) -> None:
        """Run the program until a STOP, or until its last command."""
        while self.at < len(self.program):
            self.around.statement()
            command = self.program[self.at]
            self.at += 1
            if command.name == "STOP":
                return
            getattr(self, f"on_{command.name}")(command, *command.operands)

    def refused(self, command: _Command, reason: str) -> RefusedLine:
        """Return the error for a command that the module does not accept, with the reason."""
        return RefusedLine(command.line, command.text, reason)

    # ---------------------------------------------------------------------------------------------------------- motion
    def on_ROR(self, command: _Command, motor: int, rate: int) -> None:
        self._rotate(command, motor, rate, 1)

    def on_ROL(self, command: _Command, motor: int, rate: int) -> None:
        self._rotate(command, motor, rate, -1)

    def _rotate(self, command: _Command, motor: int, rate: int, sign: int) -> None:
        if motor or rate <= 0:
            raise self.refused(command, "no such motor, or no rate")
        self.around.run(1, sign)

    def on_MST(self, command: _Command, motor: int) -> None:
        del command, motor

    def on_MVP(self, command: _Command, how: str, motor: int, value: int) -> None:
        if motor:
            raise self.refused(command, "no such motor")
        self.axis[0] = value if how == "ABS" else self.axis[0] + value

    def on_MVPA(self, command: _Command, how: str, motor: int) -> None:
        self.on_MVP(command, how, motor, self.accumulator)

    def on_WAIT(self, command: _Command, what: str, motor: int, ticks: int) -> None:
        if what == "TICKS":
            self.around.delay(ticks * 10**10)
        elif what == "POS":
            if self.axis[0] != self.axis[1] and not (self.axis.get(4) and (self.axis.get(5) or self.axis.get(19))):
                raise self.refused(command, "no rate, or no acceleration, has been set")
            self.around.move(1, self.axis[0] - self.axis[1])
            self.axis[1] = self.axis[0]
        elif what == "RFS":
            self.around.run(1, 1 if self.axis.get(193) in (6, 7) else -1)
            self.axis[0] = self.axis[1] = 0
        del motor

    def on_RFS(self, command: _Command, what: str, motor: int) -> None:
        del command, what, motor

    # ------------------------------------------------------------------------------------------------------ parameters
    def on_SAP(self, command: _Command, parameter: int, motor: int, value: int) -> None:
        least, most = RANGES.get(parameter, (1, 0))
        if motor or not least <= value <= most:
            raise self.refused(command, f"allowed: {least} to {most}")
        self.axis[parameter] = value

    def on_GAP(self, command: _Command, parameter: int, motor: int) -> None:
        del motor
        if parameter not in self.axis:
            raise self.refused(command, "unknown parameter")
        self.accumulator = self.axis[parameter]

    def on_SGP(self, command: _Command, number: int, bank: int, value: int) -> None:
        if bank != 2 or not 0 <= number < len(self.variables):
            raise self.refused(command, "not a user variable")
        self.variables[number] = value

    def on_GGP(self, command: _Command, number: int, bank: int) -> None:
        if bank != 2:
            raise self.refused(command, "not a user variable")
        self.accumulator = self.variables[number]

    def on_CALC(self, command: _Command, what: str, value: int) -> None:
        if what == "LOAD":
            self.accumulator = value
        elif what == "MUL":
            self.accumulator *= value
        else:
            raise self.refused(command, "not used")

    def on_CALCAV(self, command: _Command, what: str, number: int) -> None:
        del command, what
        self.accumulator *= self.variables[number]

    # ------------------------------------------------------------------------------------------------------------ lines
    def on_SIO(self, command: _Command, port: int, bank: int, level: int) -> None:
        if bank != 2 or not 0 <= port <= 2 or port in self.reads:
            raise self.refused(command, "not an output")
        self.around.output(port + 1, level)

    def on_GIO(self, command: _Command, port: int, bank: int) -> None:
        if bank != 0 or not 0 <= port <= 2:
            raise self.refused(command, "not an input")
        self.accumulator = self.around.level(self.inputs[port])

    # ------------------------------------------------------------------------------------------------------------ flow
    def on_COMP(self, command: _Command, value: int) -> None:
        del command
        self.difference = self.accumulator - value

    def on_JC(self, command: _Command, condition: str, to: int) -> None:
        waits = to == self.at - 3 and self.program[to].name == "GIO"
        if HOLDS[condition](self.difference):
            if waits and not self.around.waits:
                self._met(command, to)
                return
            self.at = to

    def _met(self, command: _Command, to: int) -> None:
        del command
        self.around.wait(self.inputs[int(self.program[to].operands[0])], int(self.program[to + 1].operands[0]))

    def on_JA(self, command: _Command, to: int) -> None:
        del command
        self.at = to

    def on_CSUB(self, command: _Command, to: int) -> None:
        if len(self.stack) == DEEPEST:
            raise self.refused(command, "subroutines are nested too deeply")
        self.stack.append(self.at)
        self.at = to

    def on_RSUB(self, command: _Command) -> None:
        if not self.stack:
            raise self.refused(command, "not a subroutine")
        self.at = self.stack.pop()

    def on_DJNZ(self, command: _Command, number: int, to: int) -> None:
        del command
        self.variables[number] -= 1
        if self.variables[number]:
            self.at = to
