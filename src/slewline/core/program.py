"""The stored program of a chip, as users see it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from ..errors import UsageError
from .messages.whole import whole
from .wires.pin import Condition

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .time.hook import Hook
    from .time.kernel import Kernel


@dataclass(frozen=True, slots=True)
class ProgramRow:
    """An instruction of a stored program, or a byte that is not part of any instruction.

    The text for such a byte is three question marks and the value of the byte.

    Attributes:
        address: the address of the first byte.
        data: the bytes.
        text: the instruction as text.
    """

    address: int
    data: bytes
    text: str


class Running(Protocol):
    """An object that runs a stored program."""

    name: str
    kernel: Kernel
    on_instruction: Hook[[int]]

    def program_rows(self) -> Sequence[ProgramRow]:
        """Return the stored program, one instruction per row."""


class InstructionCondition(Condition):
    """The condition that a stored instruction begins: the one at `address`, or any if `address` is None.

    Args:
        room: the number of addresses in the program memory; 0 if unknown.
    """

    def __init__(self, chip: Running, address: int | None, room: int = 0) -> None:
        at = whole(address)
        if address is not None and (at is None or at < 0 or at >= (room or at + 1)):
            allowed = f"0..{room - 1}, the addresses of a program" if room else "an address, 0 and up"
            raise UsageError(f"{chip.name}: instruction at {address!r}; allowed {allowed}, or none for any instruction")
        self.chip, self.address, self.hit = chip, at, False
        self.text = f"{chip.name} at {'its next instruction' if at is None else f'instruction {at}'}"

    def begin(self) -> None:
        """Start watching the instructions that the chip begins."""
        self.hit = False
        if self.begun not in self.chip.on_instruction.listeners:
            self.chip.on_instruction.add(self.begun)

    def begun(self, address: int) -> None:
        """Record that the instruction at an address begins; if it is the awaited one, the condition is now met."""
        if self.address in (None, address):
            self.hit = True
            self.chip.on_instruction.remove(self.begun)

    def belongs(self, kernel: Kernel) -> bool:
        """Return whether the chip is on the bench of this kernel."""
        return self.chip.kernel is kernel

    def __str__(self) -> str:
        rows = self.chip.program_rows()
        if self.address is None or any(row.address == self.address for row in rows):
            return self.text
        there = f"they begin at {', '.join(str(row.address) for row in rows)}" if rows else "no program is stored"
        return f"{self.text}, where no instruction begins: {there}"

    def met(self) -> bool:
        return self.hit
