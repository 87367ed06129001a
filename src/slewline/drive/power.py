"""The current of the driver, as the host asks for it; the board decides (`board/twin_power.py` has its rules).

    open    on, if the drive is to enable its driver: a word of the user
    clear   unchanged; on again only if the user says that the position is known (homed), or homes now (homing)
    close   off when the motor has come to rest and is counted; "never" leaves it on

A position is unknown where steps may have been lost, where they were made without current, and where the board has
switched the driver off by itself.  It is known again when the user says so, or when a homing has ended: one of the
chip's own, or the host's, which sets the position register at rest.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ..core.time.timebase import Time, picoseconds, readable
from ..errors import UsageError
from .board.wire import ENABLE, EnableOff, PowerFlag

if TYPE_CHECKING:
    from .board.boards import BoardModel
    from .driven import Driven

ENABLE_OFF: Mapping[str, EnableOff] = {"rest": EnableOff.REST, "halt": EnableOff.HALT, "never": EnableOff.NEVER}
USUAL_OFF, USUAL_HOLD = "halt", "60 s"
HOLD_TICKS = 1 << 16


def off_policy(word: str) -> EnableOff:
    """Return when a board is to switch the driver off by itself.

    Raises:
        UsageError: not one of "rest", "halt" and "never".
    """
    if word not in ENABLE_OFF:
        raise UsageError(f"enable_off {word!r}; allowed {', '.join(ENABLE_OFF)}")
    return ENABLE_OFF[word]


def hold_of(board: BoardModel, hold: Time) -> int:
    """Return how long the driver stays on, as the board counts it: in 65,536 ticks.

    Raises:
        TimeError: it is not a time.
        UsageError: it is longer than the board can count.
    """
    ps, most = picoseconds(hold), HOLD_TICKS * 0xFFFF * 10**12 // board.hz
    if not 0 <= ps <= most:
        raise UsageError(f"enable_hold {hold!r}; allowed 0 s to {readable(most // 10**12 * 10**12)}")
    return min(ps * board.hz // (HOLD_TICKS * 10**12), 0xFFFF)


def least_hold(off: EnableOff, horizon: int) -> int:
    """Return the shortest `enable_hold` of CONFIG: a driver that goes off at rest is on until the first step.

    Args:
        horizon: from a message of the host to that step, in ticks.
    """
    return horizon // HOLD_TICKS + 2 if off == EnableOff.REST else 0


class Power:
    """The current of the driver of a drive.

    Attributes:
        known: whether the position register is where the motor is, as far as anybody can know.
    """

    def __init__(self, drive: Driven, off: EnableOff) -> None:
        self.drive, self.off = drive, off
        self.known = True
        self._was_on = False
        self._homed_from: tuple[int, int] = (0, 0)  # direction of the chip's homing, and register minus travel

    @property
    def flags(self) -> int:
        """The flags of the last answer of the board: PowerFlag."""
        answer = self.drive.link.answer
        return 0 if answer is None else answer.flags

    @property
    def on(self) -> bool:
        """Whether the driver is enabled, by the last answer of the board."""
        return bool(self.flags & PowerFlag.ENERGISED)

    @property
    def bears_silence(self) -> bool:
        """Whether the board would leave the driver on though its host sends nothing for a second."""
        hold = self.drive.config.enable_hold * HOLD_TICKS
        return not self.on or self.off == EnableOff.NEVER or (self.off == EnableOff.HALT and hold > self.drive.board.hz)

    def began(self, *, known: bool) -> None:
        """Note that the board has been set up, and whether the user says that the position is known."""
        self._was_on = self.on
        self.known = known or (self.known and not self.flags & PowerFlag.UNSURE)
        self._homed_from = self._seen()

    def doubt(self) -> None:
        """Record that the motor may be elsewhere than the register."""
        self.known = False

    def before_start(self) -> None:
        """Switch the driver on again before a motion, if the board switches it off at rest."""
        if self.drive.enable and self.off == EnableOff.REST and self._was_on:
            self.drive.link.outputs(ENABLE, ENABLE)

    def turn(self) -> None:
        """Look whether a homing has ended, and whether the board has switched the driver off."""
        drive = self.drive
        if drive.state != "ok":
            return
        if not self.known and self.on:
            self._look_for_homing()
        if self._was_on and not self.on and self.off != EnableOff.REST:
            self._was_on = False
            self.doubt()
            drive.watch.switched_off()

    def _look_for_homing(self) -> None:
        """The position is known when the motor rests, and a homing has ended at 0, or the register was set."""
        drive, (homing, offset) = self.drive, self._homed_from
        if drive.axis.homing:
            self._homed_from = drive.axis.homing, offset
        elif not drive.cable.under_way and not drive.axis.moving:
            seen = self._seen()
            if drive.axis.position == 0 if homing else seen[1] != offset:  # a register need not count a homing
                self.known = True
                drive.link.reset(None, known=True)
            self._homed_from = seen

    def _seen(self) -> tuple[int, int]:
        """The direction of the chip's homing, 0 for none, and its register minus its travel."""
        axis = self.drive.axis
        return axis.homing, (axis.position - axis.travel) % axis.modulus

    def switch_off(self) -> None:
        """Switch the driver off at the end of a session, if it is to be."""
        self._was_on = False
        if self.off != EnableOff.NEVER and self.on:
            self.drive.link.outputs(ENABLE, 0)
