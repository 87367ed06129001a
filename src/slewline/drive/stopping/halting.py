"""Halting of a chip whose board has stopped the motor: the chip stops, and takes over the board's count."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...errors import UsageError

if TYPE_CHECKING:
    from ...core.chip import Chip
    from ..board.wire import BoardEvent
    from ..drive_state import DriveState
    from .findings import DriveFindings

STOP_MODES = ("abort", "kill", "reset", "power")  # stop modes of chips
KEEPING = ("abort", "kill")  # modes that keep the registers


def stop_modes_of(chip: Chip) -> list[str]:
    """Return the stop modes of a chip: each of "abort", "kill", "reset" and "power" that can stop it."""
    roles = {row.role for row in chip.sheet.pins if row.in_out in ("in", "both")}
    return [
        mode for mode in STOP_MODES if mode in roles or mode == "power" or (mode == "kill" and hasattr(chip, "kill"))
    ]


def stop_mode(chip: Chip, how: str | None) -> str:
    """Return the stop mode of a chip: the given mode, or, for None, the first mode that the chip has.

    Raises:
        UsageError: the chip does not have the given mode.
    """
    allowed = stop_modes_of(chip)
    if how is not None and how not in allowed:
        raise UsageError(f"{chip.name}: stop={how!r}; allowed {', '.join(map(repr, allowed))}")
    return how or allowed[0]


class StopChip:
    """The piece that stops the chip, and makes it take over the board's count once the chip is at rest.

    Depending on `how`, it uses the chip's abort inputs, the effect of its kill command (K of a GS-C), its
    reset, or its supply.  After a reset or a loss of supply, the registers have power-up values; the user
    must then home the motor.

    Args:
        how: "abort", "kill", "reset" or "power".
    """

    def __init__(self, state: DriveState, findings: DriveFindings, how: str) -> None:
        self.state, self.findings, self.how = state, findings, how
        self._position: int | None = None  # count to be taken over
        self._acting = self._at_rest = False  # the chip is being stopped from here; it has come to rest since

    def expects(self, event: BoardEvent) -> bool:
        """Return False, because no event of the board makes the chip stop by itself; this piece must stop it."""
        return False

    def stopped(self, event: BoardEvent) -> None:
        """Stop the chip immediately."""
        self._acting, self._at_rest = True, False
        self._act()

    def _act(self) -> None:
        chip = self.state.chip
        if self.how == "abort":
            for pin in self._pins():
                chip.pin(pin).drive(self._active(pin))
        elif self.how == "kill":
            chip.kill()  # type: ignore[attr-defined]  # a chip that can be stopped so
        elif self.how == "reset":
            chip.reset()
        else:
            chip.power(False)

    def _pins(self) -> list[str]:
        """Return the names of the inputs that stop the motion of the axis."""
        rows = [row for row in self.state.chip.sheet.pins if row.plays("abort", self.state.number)]
        return [row.name for row in rows if row.in_out in ("in", "both")]

    def _active(self, pin: str) -> int:
        return self.state.chip.pin(pin).row.active or 0

    def halted(self, event: BoardEvent) -> None:
        """Record the board's count, which `turn` takes over as soon as the chip is at rest."""
        self._position = event.position

    def turn(self) -> None:
        """Take over the board's count if the chip is now at rest; afterwards, stop any motion that its host begins.

        The input that stops the chip is released once the chip is at rest, because some chips ignore an
        input that is active when a motion begins.
        """
        axis = self.state.axis
        if axis.moving or axis.log.in_progress:
            if self._at_rest:
                self._at_rest = False
                self._act()
            return
        if self._acting and not self._at_rest:
            self._at_rest = True
            if self.how == "abort":
                self._let_go()
        if self._position is not None:
            position, self._position = self._position, None
            self.findings.take_over(position, self.how in KEEPING)

    @property
    def settled(self) -> bool:
        """True while the chip is at rest and has taken over the board's count."""
        return self._position is None and (self._at_rest or not self._acting)

    def clear(self) -> None:
        """Let the chip move again: release the input that stops it, or switch its supply on."""
        if self._acting:
            self._acting = False
            if not (self._at_rest and self.how == "abort"):
                self._let_go()

    def _let_go(self) -> None:
        chip = self.state.chip
        if self.how == "abort":
            for pin in self._pins():
                chip.pin(pin).release()
        elif self.how == "power":
            chip.power(True)
