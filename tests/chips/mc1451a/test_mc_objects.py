"""The objects that an MC1451A is made of, each by itself or with a stand-in for its neighbours."""

from __future__ import annotations

from dataclasses import fields

import pytest

import slewline
from slewline.chips.mc1451a.cycle_clock import CycleClock
from slewline.chips.mc1451a.instructions import Instructions
from slewline.chips.mc1451a.interrupt import HostInterrupt
from slewline.chips.mc1451a.registers import MOTION_COMPLETE, POSITIVE_LIMIT, AxisState, Profile, Registers
from slewline.core.time.timebase import Clock


def test_a_reset_clears_all_registers():
    registers = Registers(2)
    registers.current, registers.limit_sense, registers.limits_on = 2, 0xF, False
    state = registers.axis
    for each in fields(state):
        if each.name != "number":
            setattr(state, each.name, Profile(position=7) if isinstance(getattr(state, each.name), Profile) else 7)
    assert all(getattr(state, each.name) != getattr(AxisState(2), each.name) for each in fields(state)[1:])
    registers.clear()
    assert registers.states == [AxisState(1), AxisState(2)] and registers.states[1] is state
    assert (registers.current, registers.limit_sense, registers.limits_on) == (1, 0, True)
    assert state.buffer is not state.active


def test_cycles_are_counted_from_the_origin():
    cycle_clock = CycleClock(Clock(25_000_000), 8192)
    cycle_clock.origin = 100
    assert [cycle_clock.tick(n) for n in (0, 1, 5)] == [100, 8292, 41060]
    begin = cycle_clock.ps(5)
    assert begin == 41060 * 40_000
    assert [cycle_clock.cycle_at(ps) for ps in (begin - 1, begin, cycle_clock.ps(0) - 1)] == [4, 5, -1]


class Line:
    """Stands for the driver of HostIntrpt."""

    def __init__(self):
        self.shown = []

    def activate(self):
        self.shown.append("active")

    def deactivate(self):
        self.shown.append("inactive")


def test_an_interrupt_lasts_until_its_end_and_the_lowest_axis_comes_next():
    registers, line = Registers(3), Line()
    interrupt = HostInterrupt(line, registers)
    for state in registers.states[1:]:
        state.mask, state.events = POSITIVE_LIMIT, POSITIVE_LIMIT | MOTION_COMPLETE
    interrupt.look()
    registers.states[0].mask = registers.states[0].events = 1
    interrupt.look()
    assert interrupt.axis == 2 and line.shown == ["active"]
    interrupt.end()
    assert interrupt.axis == 0 and line.shown == ["active", "inactive"]
    interrupt.look()
    assert interrupt.axis == 1 and line.shown == ["active", "inactive", "active"]


class Moves:
    """Stands for what works the cycles."""

    cycle, attended = 41, 0

    def attend(self):
        self.attended += 1


@pytest.mark.parametrize(
    ("command", "attended"),
    [("SET_POS", 1), ("UPDATE", 1), ("MTR_OFF", 1), ("GET_TIME", 0), ("SET_2", 0), ("SET_I", 0), ("RESET", 0)],
)
def test_a_cycle_uses_the_values_written_by_a_command(command, attended):
    chip = slewline.Bench().add("mc1251a")
    moves = Moves()
    instructions = Instructions(chip, chip.state, chip._interrupt, chip._activity, chip._supply, moves)
    found = instructions.perform(chip.sheet.commands[command], 5)
    assert moves.attended == attended
    assert found == {"GET_TIME": 41, "SET_2": 0x1300, "SET_I": 0x0300}.get(command)


def test_a_reset_by_command_begins_when_its_packet_is_over():
    chip = slewline.Bench().add("mc1151a")
    chip._instructions.perform(chip.sheet.commands["RESET"], 0)
    starts = chip._supply.starts
    assert chip._supply.restarting
    assert chip._supply.restarted() and not chip._supply.restarting
    assert chip._supply.starts == starts + 1 and not chip._supply.restarted()
