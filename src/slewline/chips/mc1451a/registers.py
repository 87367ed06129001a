"""What the host sees of a chipset: its axes, the current one, the interrupting one, and the registers by name."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from ...core.axis import Axis
from ...core.chip import Chip
from ...core.kernel import Kernel
from .state import AxisState, saturated

if TYPE_CHECKING:
    from .cycles import ChipsetAxis

POSITIONS = range(-(1 << 30), 1 << 30)


class Moves(Protocol):
    """What works the cycles: motion.py, or its slow twin."""

    @property
    def cycle(self) -> int:
        """The present cycle, as of the last `catch_up`."""

    def start(self) -> None:
        """Reset is over: cycle 0 begins at this instant."""

    def stop(self) -> None:
        """Reset, or no supply: no pulse after this instant."""

    def catch_up(self) -> None:
        """Bring the registers up to this instant, a cycle that begins with it included."""

    def attend(self) -> None:
        """A command has written registers: the next cycle must look at them."""

    def declare(self, state: AxisState, value: int) -> None:
        """SET_ACTL_POS: the position of an axis, at once and without pulses."""


class Registers(Chip):
    """The registers of a chipset.  `states` are those of its axes."""

    motion: Moves

    def __init__(self, kernel: Kernel, name: str, /, crystal_hz: int | None = None, **given: Any) -> None:
        super().__init__(kernel, name, crystal_hz, **given)
        self.encoder = self.sheet.encoder
        self.axes = tuple(Axis(kernel, POSITIONS, 0) for _ in range(self.sheet.axes))
        self.origin = 0  # tick at which cycle 0 began
        self.forget()

    def forget(self) -> None:
        """Reset: every register as the manual lists it."""
        self.states = [AxisState(number) for number in range(1, self.sheet.axes + 1)]
        self.current = 1
        self.interrupting = 0  # the axis whose interrupt is pending; 0: none
        self.limit_sense = 0
        self.limits_on = True

    @property
    def state(self) -> AxisState:
        """The registers of the current axis."""
        return self.states[self.current - 1]

    def restart(self) -> None:
        """The same as RESET low for a moment."""
        raise NotImplementedError

    @property
    def registers(self) -> dict[str, int]:
        """The registers of axis 1, named after the commands that write and read them."""
        return self.registers_of(1)

    def axis(self, number: int) -> ChipsetAxis:
        """Axis 1, 2 ... of the chipset."""
        from .cycles import ChipsetAxis

        super().axis(number)
        return ChipsetAxis(self, number)

    def registers_of(self, number: int) -> dict[str, int]:
        """The registers of an axis."""
        self.motion.catch_up()
        state = self.states[number - 1]
        buffer = state.buffer
        return {
            "pos": buffer.position,
            "vel": buffer.velocity,
            "acc": buffer.acceleration,
            "max_acc": buffer.max_acceleration,
            "jerk": buffer.jerk,
            "ratio": buffer.ratio,
            "start_vel": state.start_velocity,
            "brk_pnt": state.comparison,
            "intrpt_mask": state.mask,
            "step_ratio": state.step_ratio,
            "pos_err": state.pos_err,
            "trgt_pos": state.target >> 16,
            "trgt_vel": state.velocity,
            "actl_pos": state.actual,
            "actl_pos_err": saturated(state.error),
            "capt": 0,
            "status": state.status,
            "mode": state.mode_word,
            "time": self.motion.cycle % (1 << 32),
        }
