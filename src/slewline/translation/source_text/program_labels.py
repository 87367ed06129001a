"""The names of the instructions to which a program's branches, or its host, jump."""

from __future__ import annotations

from ...language.statements import Block, Source, Statement
from .source_registers import start_of


class ProgramLabels:
    """The labels of all programs in a text.

    Attributes:
        labels: the names of the labels, by program number and address.
        loops: the names of the labels of loops that begin at a mark command, by program number and address.
    """

    def __init__(self, source: Source) -> None:
        self.source = source
        self.labels: dict[tuple[int, int], str] = {}
        self.loops: dict[tuple[int, int], str] = {}
        self._name_labels()

    def goal(self, statement: Statement) -> str:
        """Return the label that a command jumps to."""
        number, address = self._goal(statement)
        if "l" in statement.row.flow and (number, address) in self.loops:
            return self.loops[number, address]
        return self.labels[number, address]

    def _goal(self, statement: Statement) -> tuple[int, int]:
        number = statement.block if statement.block >= 0 else self._block_before(statement)
        block = self.source.blocks[number] if number >= 0 else Block()
        if statement.block < 0:
            return number, start_of(statement, block)
        target, flow = statement.target, statement.row.flow
        if target is not None:
            return number, block.address_of(target) or 0
        return number, block.loop_start(statement) if "l" in flow else block.base

    def _mark(self, number: int, address: int) -> Statement | None:
        """Return the command that marks a loop start at an address of program `number`, or None if there is none."""
        marks = (each for each in self.source.blocks[number].statements if each.row.role == "mark")
        return next((each for each in marks if each.end == address), None)

    def _block_before(self, statement: Statement) -> int:
        """Return the number of the last program entered before a host command, or -1 if none is entered before it."""
        found = -1
        for item in self.source.statements:
            if item is statement:
                break
            found = max(found, item.block)
        return found

    def _name_labels(self) -> None:
        """Name every instruction to which a branch, a loop or a host command leads."""
        for number, block in enumerate(self.source.blocks):
            for letter, address in block.labels.items():
                self.labels[number, address] = letter
        leads = [
            statement
            for statement in self.source.statements
            if statement.target is not None or (statement.row.flow in ("0", "n0", "nl") and statement.block >= 0)
        ]
        for statement in leads:
            number, address = self._goal(statement)
            if "l" in statement.row.flow and (mark := self._mark(number, address)) is not None:
                self.loops[number, address] = f"line{mark.line}"
                continue
            if number < 0 or (number, address) in self.labels:
                continue
            at = next((each for each in self.source.blocks[number].statements if each.address == address), None)
            name = f"line{at.line}" if at is not None else f"end{number}" if address else f"start{number}"
            taken = set(self.labels.values())
            self.labels[number, address] = name if name not in taken else f"{name}_{address}"
