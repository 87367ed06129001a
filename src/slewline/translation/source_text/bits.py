"""The outputs and inputs of parts whose commands select a bit, and its level, by a single number.

A number below 40 hexadecimal selects a single bit.  Its low three bits give the number of that bit, and
its bit 4 is set for a low level.  The outputs that a program uses are numbered in the order of their
bits, and so are the inputs.
"""

from __future__ import annotations

from ...core.datasheet.table import Sheet
from ...language.statements import Source, Statement
from ..meaning import Input

SINGLE, LOW, NUMBER = 0x40, 0x10, 0x07
ON_THE_BUS = 0x08
WAITS = ("wait_bits", "branch_bits")


class Numbers:
    """The bits that a program uses as outputs and as inputs; their order gives the output and input numbers."""

    def __init__(self, sheet: Sheet, source: Source | None = None) -> None:
        statements = source.statements if source is not None else []
        self.sheet = sheet
        self.outs = self._used(statements, ("bits",))
        self.ins = self._used(statements, WAITS)

    @staticmethod
    def _used(statements: list[Statement], roles: tuple[str, ...]) -> list[int]:
        bits = {
            each.values[0] & (NUMBER | ON_THE_BUS)
            for each in statements
            if each.row.role in roles and each.values[0] < SINGLE
        }
        return sorted(bits)

    def outputs(self, statement: Statement) -> list[tuple[int, int]] | None:
        """Return a list with one pair: the output that a command sets, and its level.

        The result is None if the command does not set a single bit.
        """
        level = self._one(statement)
        return None if level is None else [(self.outs.index(level[0]) + 1, level[1])]

    def input(self, statement: Statement) -> Input | None:
        """Return the input that a command tests, with the expected level, or None if it does not test a single bit."""
        level = self._one(statement)
        return None if level is None else Input(self.ins.index(level[0]) + 1, level[1])

    @staticmethod
    def _one(statement: Statement) -> tuple[int, int] | None:
        value = statement.values[0]
        if value >= SINGLE:
            return None
        inverted = "/" in statement.text.split()[0]
        return value & (NUMBER | ON_THE_BUS), int(bool(value & LOW) == inverted)

    def wiring(self) -> dict[str, str]:
        """Return the names of the pins by their purpose, such as "output1" or "input1"."""
        found = {f"output{n}": self._pin(bit) for n, bit in enumerate(self.outs, 1)}
        return found | {f"input{n}": self._pin(bit) for n, bit in enumerate(self.ins, 1)}

    @staticmethod
    def _pin(bit: int) -> str:
        return f"db{bit & NUMBER}" if bit & ON_THE_BUS else f"usrb{bit}"
