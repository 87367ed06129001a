"""Work in progress in a chipset: a packet, motions, or a breakpoint that waits for a time."""

from __future__ import annotations

from ...core.context import ChipContext
from .registers import Registers

FOR_A_COMMAND = "waiting for a command"


class Activity:
    """The work in progress, which determines the chip's properties `idle` and `waiting`."""

    def __init__(self, chip: ChipContext, registers: Registers) -> None:
        self.chip, self.registers = chip, registers
        self.waiting = ""  # text of `waiting`
        self.unprocessed = False  # a command has written a value that no cycle has read yet
        self.clear()

    def clear(self) -> None:
        """Handle a reset: allow no command yet."""
        self.started = False
        self.serving = True  # HostRdy is low
        self.waiting = ""
        self.chip.idle = False

    def begin(self) -> None:
        """Record that the first command may arrive."""
        self.started, self.serving = True, False
        self.refresh()

    def serve(self) -> None:
        """Record that a command or a word from the host is in progress."""
        self.serving, self.chip.idle = True, False

    def served(self) -> None:
        """Record that the command or word has been processed."""
        self.serving = False
        self.refresh()

    def worked(self) -> None:
        """Record that a cycle has been processed, and whether an update still waits for a later cycle."""
        self.unprocessed = any(state.update is not None for state in self.registers.states)
        self.refresh()

    def refresh(self) -> None:
        """Update `idle` and `waiting`.  An axis whose breakpoint waits for a time is not idle."""
        awaited = FOR_A_COMMAND
        for state in self.registers.states:
            if state.in_motion or state.breakpoint == "time":
                awaited = self.awaited()
                break
        self.chip.idle = awaited is FOR_A_COMMAND and not (self.unprocessed or self.serving)
        if self.started and awaited != self.waiting:
            self.waiting = awaited
            self.chip.waits(awaited)

    def awaited(self) -> str:
        """Return the text for `waiting`: the awaited event (the end of motions, a time, or a command)."""
        states = self.registers.states
        moving = [state.number for state in states if state.in_motion]
        if moving:
            axes = f"{'axis' if len(moving) == 1 else 'axes'} {', '.join(map(str, moving))}"
            return f"waiting for the end of the motion of {axes}"
        for state in states:
            if state.breakpoint == "time":
                return f"waiting for time {state.comparison}, the breakpoint of axis {state.number}"
        return FOR_A_COMMAND

    @property
    def armed(self) -> bool:
        """True if an axis has a breakpoint: an input may meet the breakpoint's condition at any time."""
        return any(state.breakpoint for state in self.registers.states)
