"""What the tests of motion ask of a chipset of the MC1451A family besides: what it shows in every cycle.

    rig = mover("mc1451a", "dir1")
    n = rig.begin(*T1)
    rig.trace(2)                      # [Look(pos=0, vel=0x400, status=0x700, phase=0), ...]: cycles n and n + 1
    rig.heeds(n + 500, "STOP", "UPDATE")     # so that cycle n + 500 is the first to heed the last command

Times are cycles, and clocks within a cycle.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping
from itertools import groupby, pairwise
from typing import Any, NamedTuple

import numpy as np
from mc import ENCODERS, PARTS, Rig, of_parts

IN_MOTION = 0x400
without_encoder = of_parts([part for part in PARTS if part not in ENCODERS])


class Look(NamedTuple):
    """What the registers of an axis show in a cycle."""

    pos: int  # target position
    vel: int  # target velocity: the displacement of this cycle
    status: int
    phase: int


class Mover(Rig):
    """A chipset, and its registers cycle by cycle."""

    def __init__(
        self,
        part: str,
        record: tuple[str, ...],
        straps: Mapping[str, int],
        options: Mapping[str, object],
        shafts: Mapping[str, Mapping[str, Any]],
    ) -> None:
        super().__init__(part, tuple(dict.fromkeys(("atrest1", *record))), straps, options)
        self.shafts = {kind: self.bench.part(kind, to=self.x, **how) for kind, how in shafts.items()}

    # ---------------------------------------------------------------------------------------------------------- time
    def heeds(self, cycle: int, *commands: str) -> None:
        """Give commands, so that this cycle is the first to heed the last one; time passes into that cycle."""
        *before, last = commands
        self.do(*before)
        self.to(cycle - 1)
        self.do(last)
        if self.cycle < cycle:
            self.to(cycle)
        assert self.cycle == cycle

    # ----------------------------------------------------------------------------------------------------- registers
    def look(self, axis: int = 1) -> Look:
        """This cycle."""
        shown = self.x.axis(axis).registers
        return Look(shown["trgt_pos"], shown["trgt_vel"], shown["status"], shown["mode"] >> 13)

    def trace(self, cycles: int, axis: int = 1) -> list[Look]:
        """This cycle and those behind it; time passes up to the begin of the next one."""
        found = []
        for _ in range(cycles):
            found.append(self.look(axis))
            self.next()
        return found

    def speeds(self, axis: int = 1, most: int = 100_000) -> list[int]:
        """The velocities of this cycle and of all others up to the end of the motion."""
        found = []
        while (look := self.look(axis)).status & IN_MOTION:
            found.append(look.vel)
            assert len(found) < most, "it does not end"
            self.next()
        return found

    # --------------------------------------------------------------------------------------------------------- steps
    def ticks(self, cycle: int = 0, axis: int = 1) -> list[int]:
        """When the steps came, from a cycle on: clocks since its begin."""
        clock, begun = self.x.clock, self.x._cycle_clock.origin + 8192 * cycle
        return [clock.ticks_until(time) - begun for time in self.pulses(self.at(cycle), axis)]

    def counts(self, cycle: int, axis: int = 1) -> list[int]:
        """How many steps came in each cycle, from one on up to the present one."""
        times = self.x.axis(axis).steps(self.at(cycle)).times_ps
        ticks = self.x.clock.ticks_array(times) - (self.x._cycle_clock.origin + 8192 * cycle)
        return np.bincount(
            (ticks - 1) // 8192, minlength=self.cycle - cycle + 1
        ).tolist()  # what ends a cycle is its own

    def moves(self, cycle: int = 0, axis: int = 1) -> list[int]:
        """Steps in one direction before the other one: +500, -380 ..."""
        ways = self.x.axis(axis).steps(self.at(cycle)).directions.tolist()
        return [sum(run) for _, run in groupby(ways)]


def differences(numbers: list[int]) -> list[int]:
    """From each number to the next."""
    return [after - before for before, after in pairwise(numbers)]


def trapezoid(distance: int, top: int, acceleration: int, start: int = 0, speed: int = 0) -> list[int]:
    """Displacements on the way to a destination ahead: each the greatest from which the rest suffices for braking."""
    start = min(start, top)
    step = max(acceleration, start)

    def fits(speed: int) -> bool:
        return sum(range(speed, start, -acceleration)) + start <= distance

    found = []
    while True:
        if distance <= min(max(top, speed - acceleration), step) and speed <= distance + step:
            return [*found, distance]
        high = max(min(top, max(speed + acceleration, start)), speed - acceleration)
        low = max(start, speed - acceleration)
        speed = high - bisect_left(range(high - low + 1), True, key=lambda less, high=high: fits(high - less))
        found.append(speed)
        distance -= speed


def mover(
    part: str,
    *record: str,
    straps: Mapping[str, int] | None = None,
    options: Mapping[str, object] | None = None,
    **shafts: Mapping[str, Any],
) -> Mover:
    """A chipset that is ready; AtRest 1 and these pins are recorded: mover("mc1451a-e", encoder={"steps": 400})."""
    rig = Mover(part, record, straps or {}, options or {}, shafts)
    rig.bench.run_until(rig.x.pin("hostrdy").is_(1))
    return rig
