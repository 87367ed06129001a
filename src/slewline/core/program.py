"""The stored program of a chip, as whoever looks at it sees it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from ..errors import UsageError
from .pin import Condition

if TYPE_CHECKING:
    from .hook import Hook


@dataclass(frozen=True, slots=True)
class ProgramRow:
    """An instruction of a stored program: where it begins, its bytes, and how it is written.

    A byte that is no instruction stands alone, with ??? and its value as text.
    """

    address: int
    data: bytes
    text: str


class Running(Protocol):
    """What plays a stored program."""

    name: str
    on_instruction: Hook[[int]]


class InstructionCondition(Condition):
    """An instruction of the stored program begins, at an address or at any (None)."""

    def __init__(self, chip: Running, address: int | None) -> None:
        if address is not None and (type(address) is not int or address < 0):
            raise UsageError(f"{chip.name}: instruction at {address!r}; allowed an address, 0 and up, or none for any")
        self.chip, self.address, self.hit = chip, address, False
        self.text = f"{chip.name} at {'its next instruction' if address is None else f'instruction {address}'}"

    def begin(self) -> None:
        """Listen for instructions from now on."""
        self.hit = False
        if self.begun not in self.chip.on_instruction.listeners:
            self.chip.on_instruction.add(self.begun)

    def begun(self, address: int) -> None:
        """Take notice that the instruction at an address begins."""
        if self.address in (None, address):
            self.hit = True
            self.chip.on_instruction.remove(self.begun)

    def met(self) -> bool:
        """Return whether the condition holds now."""
        return self.hit
