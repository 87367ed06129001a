"""Waits and branches in the language of the target.

Some tests are a single command of the target; others are composed of several commands.
"""

from __future__ import annotations

from collections.abc import Collection

from ...core.datasheet.table import Row, Sheet
from ..meaning import Input
from ..rows_of_roles import rows_by_role
from .layout import Goto, ResultPiece
from .limits import no_command, no_pin

LOW_BIT, FIRST_INPUT_BIT = (
    0x10,
    3,
)  # bit set for low in a number that selects a bit; inputs follow the outputs, bits 0 to 2
WAIT_INPUT, BRANCH_INPUT = 1, 2  # input of commands that name no input


class CannotTest(Exception):
    """An error: the target cannot test a condition; `limit` prevents it, and `remedy` is advice to the user."""

    def __init__(self, limit: str, remedy: str = "") -> None:
        super().__init__(limit)
        self.limit, self.remedy = limit, remedy


class Conditions:
    """The input conditions that a part can wait for and branch on."""

    def __init__(self, sheet: Sheet, used: Collection[int]) -> None:
        self.sheet, self.rows = sheet, rows_by_role(sheet)
        self.used = used  # inputs that the program tests; the others are open, and high
        self._fresh = 0

    def fresh(self) -> str:
        """Return a label name that has not been used yet."""
        self._fresh += 1
        return f"here{self._fresh}"

    def check(self, number: int) -> None:
        """Raise CannotTest if the target has no input with this number."""
        if "wait_bits" not in self.rows and self.sheet.role(f"input{number}") is None:
            raise CannotTest(no_pin(self.sheet, "input", number), "let the host wait for it")

    # ----------------------------------------------------------------------------------------------------------- waits
    def wait(self, one: Input) -> list[ResultPiece]:
        """Return the instructions that wait until an input has the required level."""
        self.check(one.number)
        row = self.rows.get("wait_high" if one.level else "wait_low")
        if "wait_bits" in self.rows:
            return [ResultPiece(self.rows["wait_bits"], (bit(one),))]
        if row is not None and row.args:
            return [ResultPiece(row, (one.number,))]
        if row is not None and one.number == WAIT_INPUT:
            return [ResultPiece(row)]
        here = self.fresh()
        try:
            found = self.branch((Input(one.number, 1 - one.level),), here, at_start=False)
        except CannotTest:
            role = "wait_high" if one.level else "wait_low"
            limit = (
                no_command(self.sheet, role)
                if row is None
                else f"{row.form} tests only input {WAIT_INPUT} ({row.where})"
            )
            raise CannotTest(limit, "let the host wait for it, or wire it to another input") from None
        found[0].labels.append(here)
        return found

    # -------------------------------------------------------------------------------------------------------- branches
    def jump(self, to: str, at_start: bool) -> list[ResultPiece]:
        """Return the instructions that continue at label `to`; `at_start`: the label is at the program's start."""
        if "jump" in self.rows:
            return [ResultPiece(self.rows["jump"], (Goto(to),))]
        again = self.rows.get("run")
        if at_start and again is not None and again.stored and again.flow == "0":
            return [ResultPiece(again)]
        raise CannotTest(no_command(self.sheet, "jump"), "let the host run the program again")

    def branch(self, inputs: tuple[Input, ...], to: str, at_start: bool) -> list[ResultPiece]:
        """Return the instructions that continue at the label `to` if all inputs have their required levels."""
        for one in inputs:
            self.check(one.number)
        if "branch_inputs" in self.rows:
            return self._all_inputs(inputs, to)
        needed = tuple(one for one in inputs if one.number in self.used)
        if len(inputs) > 1 and any(one.number not in self.used and not one.level for one in inputs):
            needed = inputs
        if len(needed) != 1:
            raise CannotTest(f"a branch of the {self.sheet.part.upper()} tests one input", "let the host decide")
        (one,) = needed
        if "branch_bits" in self.rows:
            return [ResultPiece(self.rows["branch_bits"], (bit(Input(one.number, 1 - one.level)), Goto(to)))]
        return self._one_input(one, to, at_start)

    def _all_inputs(self, inputs: tuple[Input, ...], to: str) -> list[ResultPiece]:
        """Return the branch instructions for a part whose branch command compares inputs 1 to 3 with three levels.

        There is one instruction for each combination of levels that fulfils the condition.  An input that the
        program never uses is assumed to be high; any other input that is not in `inputs` may have either level.
        """
        given = {one.number: one.level for one in inputs}
        row = self.rows["branch_inputs"]
        wanted = [
            levels
            for levels in range(8)
            if all(
                (levels >> n - 1 & 1) == given.get(n, (levels >> n - 1 & 1) if n in self.used else 1) for n in (1, 2, 3)
            )
        ]
        return [ResultPiece(row, (levels, Goto(to))) for levels in wanted]

    def _one_input(self, one: Input, to: str, at_start: bool) -> list[ResultPiece]:
        """Return the instructions of a branch, made with a command that tests a single input for one level."""
        for role, level in (("branch_low", 0), ("branch_high", 1)):
            row = self.rows.get(role)
            if row is None:
                continue
            names = bool(row.args) and row.args[0].name == "input"
            if not names and one.number != BRANCH_INPUT:
                raise CannotTest(f"{row.form} tests only input {BRANCH_INPUT} ({row.where})", "wire it to that input")
            if one.level == level and (at_start or "t" in row.flow):
                return [ResultPiece(row, self._arguments(row, one, to, names))]
            if one.level != level and "t" in row.flow and "jump" in self.rows:
                past = self.fresh()
                return [ResultPiece(row, (Goto(past),)), *self.jump(to, at_start), ResultPiece(labels=[past])]
            where = "the start of the program" if "0" in row.flow else "its target"
            only = f"{row.form} continues at {where} while an input is {'high' if level else 'low'} ({row.where})"
            raise CannotTest(only, "invert the input, or let the host run the program again")
        raise CannotTest(no_command(self.sheet, "branch_low"), "let the host decide")

    @staticmethod
    def _arguments(row: Row, one: Input, to: str, names: bool) -> tuple[int | Goto, ...]:
        if names:
            return (one.number,)
        return (Goto(to),) if "t" in row.flow else ()


def bit(one: Input) -> int:
    """Return the number with which a command selects an input and a level."""
    return FIRST_INPUT_BIT + one.number - 1 + (0 if one.level else LOW_BIT)
