"""The commands of the chipset, in the order of the manual: what each does to the registers, or reads there.

A handler is named after its row.  It gets the number that the host has written (words put together, unsigned) if its
row has one, and returns the number to be read, if its row has one.  `self.state` is the current axis.
"""

from __future__ import annotations

from typing import Protocol

from ...core.context import ChipContext
from ...core.datasheet.table import Arg, Row
from ...language.dialect import spoken_as
from ...language.packets import Packets
from . import sheet
from .activity import Activity
from .ideal import mark_deviation
from .interrupt import HostInterrupt
from .registers import (
    CAPTURED,
    GEAR,
    MOTION_ERROR,
    ONE,
    S_CURVE,
    TRAPEZOIDAL,
    VELOCITY,
    AxisState,
    Registers,
    saturated,
    signed,
)
from .supply import Supply


class Moves(Protocol):
    """What works the cycles: motion.py, or its slow twin."""

    @property
    def cycle(self) -> int:
        """The present cycle, as of the last `catch_up`."""

    def start(self) -> None:
        """Begin cycle 0 at this instant: reset is over."""

    def stop(self) -> None:
        """Make no pulse after this instant: reset, or no supply."""

    def catch_up(self) -> None:
        """Bring the registers up to this instant, a cycle that begins with it included."""

    def attend(self) -> None:
        """Look at the registers in the next cycle: a command has written them."""

    def declare(self, state: AxisState, value: int) -> None:
        """Set the position of an axis, at once and without pulses."""


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
        rows = chip.sheet.commands
        self.handlers = {row.code: getattr(self, row.handler) for row in rows}
        self.writes = {row.code for row in rows if not row.reads and row.name != "RESET"}  # what a cycle looks at

    def perform(self, row: Row, value: int) -> int | None:
        """Do what a complete packet says; the registers show the present cycle.  Returns what is to be read."""
        handler = self.handlers[row.code]
        found: int | None = handler(value) if row.args else handler()
        if row.code in self.writes:
            self.activity.unprocessed = True
            self.motion.attend()
        return found

    @property
    def state(self) -> AxisState:
        """The registers of the current axis."""
        return self.registers.axis

    def within(self, what: Arg, value: int, kept: int) -> int:
        """Return the part of a value that a register keeps, with a finding if the value is out of range."""
        written = what.unpack(what.pack(value, "big"), "big")
        if not what.allows(written):
            text = f"{what.name} {written}; allowed {what.low}..{what.high}: {kept} is kept"
            self.chip.finding("out-of-range", f"axis {self.registers.current}: {text}")
        return kept

    def unsigned(self, what: Arg, value: int) -> int:
        """Return what a register without a sign keeps: the top bit is dropped."""
        return self.within(what, value, value & (1 << (8 * what.size - 1)) - 1)

    def to_position(self, what: Arg, value: int) -> int:
        """Return what a position register keeps: 31 bits with their sign."""
        return self.within(what, value, signed(value, 31))

    # ---------------------------------------------------------------------------------------------------- axis control
    def select(self, number: int) -> int:
        """Make an axis the current one; its status is read."""
        self.registers.current = number
        return self.state.status

    def do_set_1(self) -> int:
        return self.select(1)

    def do_set_2(self) -> int:
        return self.select(2)

    def do_set_3(self) -> int:
        return self.select(3)

    def do_set_4(self) -> int:
        return self.select(4)

    def do_set_i(self) -> int:
        return self.select(self.interrupt.axis or self.registers.current)

    # ----------------------------------------------------------------------------------------------- profile generation
    def do_set_prfl_trap(self) -> None:
        self.state.mode = TRAPEZOIDAL

    def do_set_prfl_vel(self) -> None:
        self.state.mode = VELOCITY

    def do_set_prfl_s_crv(self) -> None:
        self.state.mode = S_CURVE

    def do_set_prfl_gear(self) -> None:
        self.state.mode = GEAR

    def do_set_pos(self, value: int) -> None:
        self.state.load("position", self.to_position(sheet.POSITION, value))

    def do_set_vel(self, value: int) -> None:
        self.state.load("velocity", self.unsigned(sheet.VELOCITY, value))

    def do_set_acc(self, value: int) -> None:
        number = self.within(sheet.ACCELERATION, value, signed(value, 32))
        self.state.load("acceleration", number)
        if sheet.ACCELERATION.low <= number < 0 and self.state.mode == TRAPEZOIDAL:
            text = f"axis {self.registers.current}: acceleration {number} in trapezoidal mode: {-number}"
            self.chip.finding("out-of-range", text)

    def do_set_jerk(self, value: int) -> None:
        self.state.load("jerk", self.unsigned(sheet.JERK, value))

    def do_set_ratio(self, value: int) -> None:
        self.state.load("ratio", self.within(sheet.RATIO, value, signed(value, 32)))

    def do_set_max_acc(self, value: int) -> None:
        self.state.load("max_acceleration", self.unsigned(sheet.MAX_ACCELERATION, value))

    def do_set_start_vel(self, value: int) -> None:
        self.state.start_velocity = self.unsigned(sheet.START_VELOCITY, value)

    def do_stop(self) -> None:
        self.state.buffer.stop = True

    def do_smooth_stop(self) -> None:
        self.state.buffer.smooth_stop = True

    def do_synch_prfl(self) -> None:
        self.state.buffer.synch_prfl = True

    def do_get_pos(self) -> int:
        return self.state.buffer.position

    def do_get_vel(self) -> int:
        return self.state.buffer.velocity

    def do_get_acc(self) -> int:
        return self.state.buffer.acceleration

    def do_get_max_acc(self) -> int:
        return self.state.buffer.max_acceleration

    def do_get_jerk(self) -> int:
        return self.state.buffer.jerk

    def do_get_ratio(self) -> int:
        return self.state.buffer.ratio

    def do_get_start_vel(self) -> int:
        return self.state.start_velocity

    def do_get_trgt_pos(self) -> int:
        return self.state.target // ONE

    def do_get_trgt_vel(self) -> int:
        return self.state.velocity

    # ------------------------------------------------------------------------------------------------- parameter update
    def do_set_time_brk(self) -> None:
        self.state.breakpoint = "time"

    def do_set_pos_brk(self) -> None:
        self.state.breakpoint = "pos"

    def do_set_neg_brk(self) -> None:
        self.state.breakpoint = "neg"

    def do_set_actl_pos_brk(self) -> None:
        self.state.breakpoint = "actl_pos"

    def do_set_actl_neg_brk(self) -> None:
        self.state.breakpoint = "actl_neg"

    def do_set_mtn_cmplt_brk(self) -> None:
        self.state.breakpoint = "mtn_cmplt"

    def do_set_ext_brk(self) -> None:
        self.state.breakpoint = "ext"

    def do_set_brk_off(self) -> None:
        self.state.breakpoint = ""

    def do_set_brk_pnt(self, value: int) -> None:
        self.state.comparison = value

    def do_update(self) -> None:
        self.state.take("UPDATE")

    def do_multi_update(self, mask: int) -> None:
        kept = self.within(sheet.AXES, mask, mask & 0xF)
        for state in self.registers.states:
            if kept >> (state.number - 1) & 1:
                state.take("MULTI_UPDATE")

    def do_set_auto_update_on(self) -> None:
        self.state.auto_update = True

    def do_set_auto_update_off(self) -> None:
        self.state.auto_update = False

    def do_get_brk_pnt(self) -> int:
        return self.state.comparison

    # --------------------------------------------------------------------------------------------- interrupt processing
    def do_set_intrpt_mask(self, mask: int) -> None:
        self.state.mask = self.within(sheet.MASK, mask, mask & 0xFF)

    def do_get_intrpt(self) -> int:
        return self.registers.states[(self.interrupt.axis or self.registers.current) - 1].status

    def do_rst_intrpt(self, mask: int) -> None:
        if self.interrupt.axis:
            state = self.registers.states[self.interrupt.axis - 1]
            state.reported |= state.motion_error and not mask & MOTION_ERROR
            state.clear(mask)
            self.interrupt.end()

    def do_get_intrpt_mask(self) -> int:
        return self.state.mask

    # ------------------------------------------------------------------------------------------------- status and mode
    def do_clr_status(self) -> None:
        self.state.clear(0)

    def do_rst_status(self, mask: int) -> None:
        self.state.clear(mask)

    def do_get_status(self) -> int:
        return self.state.status

    def do_get_mode(self) -> int:
        return self.state.mode_word

    # ------------------------------------------------------------------------------------------------ pulse generation
    def do_set_output_stndrd(self) -> None:
        self.state.high_speed = False

    def do_set_output_high(self) -> None:
        self.state.high_speed = True

    def do_mtr_on(self) -> None:
        self.state.motor_on = True

    def do_mtr_off(self) -> None:
        self.state.switch_off()

    # ---------------------------------------------------------------------------------------------------------- encoder
    def do_get_actl_pos(self) -> int:
        return self.state.actual

    def do_set_capt_index(self) -> None:
        self.state.capture_home = False

    def do_set_capt_home(self) -> None:
        self.state.capture_home = True

    def do_get_capt(self) -> int:
        self.state.events &= ~CAPTURED
        return 0

    def do_set_step_ratio(self, value: int) -> None:
        self.state.step_ratio = self.unsigned(sheet.STEP_RATIO, value)

    def do_get_step_ratio(self) -> int:
        return self.state.step_ratio

    def do_set_auto_stop_on(self) -> None:
        self.state.auto_stop = True

    def do_set_auto_stop_off(self) -> None:
        self.state.auto_stop = False

    def do_set_pos_err(self, value: int) -> None:
        self.state.pos_err = self.unsigned(sheet.LIMIT, value)

    def do_get_pos_err(self) -> int:
        return self.state.pos_err

    def do_get_actl_pos_err(self) -> int:
        return saturated(self.state.error)

    # ---------------------------------------------------------------------------------------------------- miscellaneous
    def do_set_actl_pos(self, value: int) -> None:
        position = self.to_position(sheet.POSITION, value)
        mark_deviation(self.chip, self.state, "command", f"SET_ACTL_POS {position}")
        self.motion.declare(self.state, position)

    def do_set_lmt_sense(self, bits: int) -> None:
        self.registers.limit_sense = self.within(sheet.SWITCHES, bits, bits & 0xFF)

    def do_get_lmt_swtch(self) -> int:
        return sum((pin.level == 1) << bit for bit, pin in enumerate(self.limits))

    def do_lmts_on(self) -> None:
        self.registers.limits_on = True

    def do_lmts_off(self) -> None:
        self.registers.limits_on = False

    def do_get_home(self) -> int:
        return sum((pin.level == 1) << bit for bit, pin in enumerate(self.homes))

    def do_reset(self) -> None:
        self.supply.request()

    def do_get_vrsn(self) -> int:
        return spoken_as(self.chip.sheet, Packets).version

    def do_get_time(self) -> int:
        return self.motion.cycle % (1 << 32)
