"""The driver current, as requested by the host; the board decides (`board/twin_power.py` has its rules).

Effect of opening, clearing and closing a drive on the current:

    open    on, if the user enables the driver
    clear   unchanged; on again only if the user confirms the position (homed), or homes now (homing)
    close   off when the motor has come to rest and its steps are counted; "never" leaves it on

The position is unknown if steps may have been lost or were made without current, or if the board has
switched the driver off by itself.  It is known again when the user confirms it, or when a homing run has
ended.  The homing run may be the chip's own; or the host homes the motor, and then sets the position
register while the motor is at rest.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from .board.wire import ENABLE, EnableOff, PowerFlag
from .terminals import HOLD_TICKS

if TYPE_CHECKING:
    from .board.board_link import Link
    from .cable import Cable
    from .drive_state import DriveState


class Power:
    """The driver current of a drive."""

    def __init__(self, state: DriveState, link: Link, cable: Cable, off: EnableOff) -> None:
        self.state, self.link, self.cable, self.off = state, link, cable, off
        self._was_on = False
        self._homed_from: tuple[int, int] = (0, 0)  # direction of the chip's homing, and register minus travel

    @property
    def known(self) -> bool:
        """True while the position register holds the position of the motor, as far as can be known."""
        return self.state.known

    @property
    def flags(self) -> int:
        """Flags (PowerFlag) in the last answer of the board."""
        answer = self.link.answer
        return 0 if answer is None else answer.flags

    @property
    def on(self) -> bool:
        """True while the driver is enabled, according to the last answer of the board."""
        return bool(self.flags & PowerFlag.ENERGISED)

    @property
    def bears_silence(self) -> bool:
        """True while a second without a message from the host would not make the board switch the driver off."""
        state, off = self.state, self.off
        hold = state.config.enable_hold * HOLD_TICKS
        return not self.on or off == EnableOff.NEVER or (off == EnableOff.HALT and hold > state.board.hz)

    def began(self, *, known: bool) -> None:
        """Record that the board has been set up, and whether the user confirms the position."""
        self._was_on = self.on
        self.state.trust(known or (self.known and not self.flags & PowerFlag.UNSURE))
        self._homed_from = self._seen()

    def before_start(self) -> None:
        """Switch the driver on again before a motion, if the board has switched it off at rest."""
        if self.state.enable and self.off == EnableOff.REST and self._was_on:
            self.link.outputs(ENABLE, ENABLE)

    def turn(self) -> bool:
        """Check whether a homing run has ended; return whether the board has switched the driver off by itself.

        If `enable_off` is "rest", this is usual at rest, so the result is always False.
        """
        if self.state.phase != "ok":
            return False
        if not self.state.known and self.on:
            self._look_for_homing()
        if not self._was_on or self.off == EnableOff.REST or self.on:
            return False
        self._was_on = False
        self.state.trust(False)
        return True

    def _look_for_homing(self) -> None:
        """Trust the position if a homing run has ended with the register at 0, or the host has set the register.

        This is checked only while the motor is at rest.
        """
        axis, (homing, offset) = self.state.axis, self._homed_from
        if axis.homing:
            self._homed_from = axis.homing, offset
        elif not self.cable.in_progress and not axis.moving:
            seen = self._seen()
            if axis.position == 0 if homing else seen[1] != offset:  # a register need not count a homing run
                self.state.trust()
                self.link.reset(None, known=True)
            self._homed_from = seen

    def _seen(self) -> tuple[int, int]:
        axis = self.state.axis
        return axis.homing, (axis.position - axis.travel) % axis.modulus

    def switch_off(self) -> None:
        """Switch the driver off at the end of a session, unless `enable_off` is "never"."""
        self._was_on = False
        if self.off != EnableOff.NEVER and self.on:
            self.link.outputs(ENABLE, 0)
