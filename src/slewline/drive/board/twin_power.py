"""Rules for ENABLE, by which a board switches its driver on and off; no host can bypass them.

    off -> on    an OUTPUTS frame, in IDLE, if every emergency-stop contact is closed, a driver is known,
                 the run is not dry, and RESET has unlocked the driver since power-up and since the board
                 last switched it off by itself
    on -> off    an OUTPUTS frame at rest; an emergency stop, in any state; and, if CONFIG allows it, when
                 the board has been in HALT, or at rest without a host, for the configured time; CONFIG
                 can also select this for a board that is at rest with a host

In motion, only an emergency stop cuts the current: without current, the motor would coast, and the count
would then be wrong.
"""

from __future__ import annotations

from collections.abc import Callable

from .wire import ENABLE, BoardConfig, BoardState, DriverFlag, EnableOff, PowerFlag, ResetFlag

IDLE, HALT = BoardState.IDLE, BoardState.HALT
HOLD_SHIFT = 16  # `enable_hold` counts 65,536 ticks


class TwinPower:
    """The driver current of a simulated board.

    Args:
        switch: a function that sets ENABLE, called with True or False and a tick.

    Attributes:
        on: True while the driver is enabled.
        unsure: True if the position of the motor may differ from the count.
        locked: True from power-up, and after the board has switched the driver off by itself, until RESET.
    """

    def __init__(self, switch: Callable[[bool, int], object]) -> None:
        self._switch = switch
        self.on = self.unsure = False
        self.locked = True  # RESET must also unlock it after power-up
        self._seen = self._resting = 0

    def flags(self, estop: bool) -> int:
        """Return the flags for ANSWER; `estop`: an emergency stop is active."""
        unsure, locked = PowerFlag.UNSURE * self.unsure, PowerFlag.LOCKED * self.locked
        return PowerFlag.ENERGISED * self.on | PowerFlag.ESTOP * estop | unsure | locked

    def may_switch(self, mask: int, value: int, state: BoardState, config: BoardConfig, estop: bool) -> bool:
        """Return whether a board accepts the ENABLE bit of an OUTPUTS frame; True if the frame does not change it."""
        wanted = bool(value & ENABLE)
        if not mask & ENABLE or wanted == self.on:
            return True
        if not wanted:
            return state in (IDLE, HALT)
        return state == IDLE and config.driver == DriverFlag.ENABLE and not self.locked and not estop

    def switch(self, on: bool, tick: int) -> None:
        """Switch the driver on or off at a tick."""
        if on != self.on:
            self.on = on
            self._switch(on, tick)

    def unlock(self, flags: int) -> None:
        """Apply the flags of a RESET frame: KNOWN or POWER unlocks the driver; KNOWN also clears `unsure`."""
        if flags & (ResetFlag.KNOWN | ResetFlag.POWER):
            self.locked = False
        if flags & ResetFlag.KNOWN:
            self.unsure = False

    def begin_motion(self) -> None:
        """Record the start of a motion; if there is no current, the motor cannot follow, so `unsure` becomes True."""
        self.unsure |= not self.on

    def cut(self, moving: bool, tick: int) -> None:
        """Switch the driver off on the board's own initiative; `moving`: the motor was moving."""
        self.unsure |= moving or self.on
        self.locked |= self.on
        self.switch(False, tick)

    def watch(self, tick: int, state: BoardState, config: BoardConfig, silent: bool) -> None:
        """Switch the driver off if the board has been inactive for the configured time; called by the main loop.

        CONFIG selects when a board counts as inactive: never; in HALT, or at rest while the host is `silent`; or
        also at rest with a host.
        """
        passed, self._seen = (tick >> HOLD_SHIFT) - self._seen, tick >> HOLD_SHIFT
        off = config.enable_off
        abandoned = state == HALT or (state == IDLE and silent)
        if not self.on or off == EnableOff.NEVER or not (abandoned or (state == IDLE and off == EnableOff.REST)):
            self._resting = 0
            return
        self._resting += passed
        if self._resting < config.enable_hold:
            return
        if abandoned:
            self.cut(False, tick)
        else:
            self.switch(False, tick)
