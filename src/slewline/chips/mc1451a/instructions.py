"""The commands of the chipset that do more than set, load or show a register, in the order of the manual.

The effects of all other commands are stated in their rows of the command table (sheet.py).  A handler is
named after its command's row.  If the host writes a number, this is the handler's argument (its words
combined, unsigned); if the host will read a number, the handler returns it.
`self.state` is the current axis.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from operator import attrgetter
from typing import Protocol

from ...core.context import ChipContext
from ...core.datasheet.table import Arg, Row
from ...errors import SheetError
from ...language.dialect import spoken_as
from ...language.packets import Packets
from . import sheet
from .activity import Activity
from .interrupt import HostInterrupt
from .omissions import NEXT_START, STARTING
from .profiles.ideal import mark_deviation
from .registers import CAPTURED, MOTION_ERROR, TRAPEZOIDAL, AxisState, Registers, signed
from .sheet import RegisterRow
from .supply import Supply


class Moves(Protocol):
    """The object that processes the cycles: motion.py, or its slow twin."""

    @property
    def cycle(self) -> int:
        """The cycle that was in progress at the last `catch_up`."""

    def start(self) -> None:
        """Begin cycle 0 at this instant, after reset."""

    def stop(self) -> None:
        """Output no more pulses after this instant, because of a reset or the loss of supply."""

    def catch_up(self) -> None:
        """Update the registers to this instant; a cycle that begins at this instant is included."""

    def attend(self) -> None:
        """Make the next cycle read the registers, because a command has written to them."""

    def declare(self, state: AxisState, value: int) -> None:
        """Set the position of an axis, immediately and without pulses."""


class Instructions:
    """Handlers of all commands."""

    def __init__(
        self,
        chip: ChipContext,
        registers: Registers,
        interrupt: HostInterrupt,
        activity: Activity,
        supply: Supply,
        motion: Moves,
    ) -> None:
        self.chip, self.registers, self.interrupt = chip, registers, interrupt
        self.activity, self.supply, self.motion = activity, supply, motion
        self.limits = [chip.pins[f"{sign}limit{state.number}"] for state in registers.states for sign in ("pos", "neg")]
        self.homes = [chip.pins[f"home{state.number}"] for state in registers.states]
        rows = chip.sheet.rows(RegisterRow)
        self.handlers: dict[int, Callable[..., int | None]] = {
            row.code: getattr(self, row.handler, None) or self.from_row(row) for row in rows
        }
        self.writes = {row.code for row in rows if not row.reads and row.name != "RESET"}  # registers read by a cycle

    def perform(self, row: Row, value: int) -> int | None:
        """Execute the command of a complete packet; return the number that the host will read, or None."""
        handler = self.handlers[row.code]
        found = handler(value) if row.args else handler()
        if row.code in self.writes:
            self.activity.unprocessed = True
            self.motion.attend()
        return found

    @property
    def state(self) -> AxisState:
        """The registers of the current axis."""
        return self.registers.axis

    def from_row(self, row: RegisterRow) -> Callable[..., int | None]:
        """Return a handler for a command whose row states its effect on a register."""
        if not (row.loads or row.sets or row.shows):
            raise SheetError(f"{row.name}: no method do_{row.name.lower()}, and its row names no register")
        of = "registers.axis" if row.acts == "current" else "registers"
        if row.loads:
            whose, put = attrgetter(of), AxisState.load if row.buffered else setattr
            arg, bits, name = row.args[0], row.bits, row.loads
            return lambda value: put(whose(self), name, self.kept(arg, value, bits))
        if row.buffered:
            of += ".buffer"
        whose, show = attrgetter(of), attrgetter(f"{of}.{row.shows}")
        if not row.sets:
            return partial(show, self)
        (register, becomes), shows = row.sets, row.shows

        def act() -> int | None:
            setattr(whose(self), register, becomes)
            return show(self) if shows else None

        return act

    def kept(self, what: Arg, value: int, bits: int) -> int:
        """Return `value` as a register stores it, and report a finding if the value is out of range.

        `bits` is the width of the register, negative for a signed register.
        """
        kept = signed(value, -bits) if bits < 0 else value & (1 << bits) - 1
        written = what.unpack(what.pack(value, "big"), "big")
        if not what.allows(written):
            text = f"{what.name} {written}; allowed {what.low}..{what.high}: {kept} is stored"
            self.chip.finding("out-of-range", f"axis {self.registers.current}: {text}")
        return kept

    # ---------------------------------------------------------------------------------------------------- axis control
    def do_set_i(self) -> int:
        """SET_I: make the interrupting axis, if any, the current axis; return the status of the current axis."""
        self.registers.current = self.interrupt.axis or self.registers.current
        return self.state.status

    # ----------------------------------------------------------------------------------------------- profile generation
    def do_set_acc(self, value: int) -> None:
        """SET_ACC: load the acceleration; report a finding if it is negative in trapezoidal mode."""
        number = self.kept(sheet.ACCELERATION, value, -32)
        self.state.load("acceleration", number)
        if sheet.ACCELERATION.low <= number < 0 and self.state.mode == TRAPEZOIDAL:
            text = f"axis {self.registers.current}: acceleration {number} in trapezoidal mode: {-number} is used"
            self.chip.finding("out-of-range", text)

    def do_set_start_vel(self, value: int) -> None:
        """SET_START_VEL: load the start velocity; report a finding if it changes in a motion whose mode uses it."""
        state, number = self.state, self.kept(sheet.START_VELOCITY, value, 31)
        if state.in_motion and number != state.start_velocity and state.mode in STARTING:
            self.chip.finding("start-velocity", f"axis {state.number}: {NEXT_START}")
        state.start_velocity = number

    # ------------------------------------------------------------------------------------------------- parameter update
    def do_update(self) -> None:
        """UPDATE: apply the buffered values of the current axis."""
        self.state.take("UPDATE")

    def do_multi_update(self, mask: int) -> None:
        """MULTI_UPDATE: apply the buffered values of all axes whose bits in `mask` are set, simultaneously."""
        kept = self.kept(sheet.AXES, mask, 4)
        for state in self.registers.states:
            if kept >> (state.number - 1) & 1:
                state.take("MULTI_UPDATE")

    # --------------------------------------------------------------------------------------------- interrupt processing
    def do_get_intrpt(self) -> int:
        """GET_INTRPT: return the status of the interrupting axis or, if there is none, of the current axis."""
        return self.registers.states[(self.interrupt.axis or self.registers.current) - 1].status

    def do_rst_intrpt(self, mask: int) -> None:
        """RST_INTRPT: clear those events of the interrupting axis whose bits in `mask` are 0; end the interrupt."""
        if self.interrupt.axis:
            state = self.registers.states[self.interrupt.axis - 1]
            state.reported |= state.motion_error and not mask & MOTION_ERROR
            state.clear(mask)
            self.interrupt.end()

    # ------------------------------------------------------------------------------------------------- status and mode
    def do_clr_status(self) -> None:
        """CLR_STATUS: clear all events of the current axis."""
        self.state.clear(0)

    def do_rst_status(self, mask: int) -> None:
        """RST_STATUS: clear those events of the current axis whose bits in `mask` are 0."""
        self.state.clear(mask)

    # ------------------------------------------------------------------------------------------------ pulse generation
    def do_mtr_off(self) -> None:
        """MTR_OFF: stop the pulses of the current axis."""
        self.state.switch_off()

    # ---------------------------------------------------------------------------------------------------------- encoder
    def do_get_capt(self) -> int:
        """GET_CAPT: clear the capture event and return 0."""
        self.state.events &= ~CAPTURED
        return 0

    # ---------------------------------------------------------------------------------------------------- miscellaneous
    def do_set_actl_pos(self, value: int) -> None:
        """SET_ACTL_POS: set the actual position and the target, in counts, -2^30 to 2^30 - 1."""
        position = self.kept(sheet.POSITION, value, -31)
        mark_deviation(self.chip, self.state, "command", f"SET_ACTL_POS {position}")
        self.motion.declare(self.state, position)

    def do_get_lmt_swtch(self) -> int:
        """GET_LMT_SWTCH: return the levels of all axes' limit switches, one bit each."""
        return sum((pin.level == 1) << bit for bit, pin in enumerate(self.limits))

    def do_get_home(self) -> int:
        """GET_HOME: return the levels of all axes' home inputs, one bit each."""
        return sum((pin.level == 1) << bit for bit, pin in enumerate(self.homes))

    def do_reset(self) -> None:
        """RESET: request a reset of the chipset."""
        self.supply.request()

    def do_get_vrsn(self) -> int:
        """GET_VRSN: return the version of the part."""
        return spoken_as(self.chip.sheet, Packets).version

    def do_get_time(self) -> int:
        """GET_TIME: return the number of cycles since the reset, modulo 2^32."""
        return self.motion.cycle % (1 << 32)
