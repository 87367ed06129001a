r"""The inputs of the slow twin: HOME, the encoder and the limit switches.

HOME and the encoder are filtered, and watched edge by edge:

        |<- 12 ->|           clocks
pin   __/‾‾‾‾‾‾‾‾‾‾‾‾\_/‾\_____________
seen  ___________/‾‾‾‾‾‾‾‾‾‾‾‾\_______    a sample at an edge reads the level before the edge
"""

from __future__ import annotations

from collections.abc import Iterator

from ....core.context import ChipContext
from ....core.wires.net import Net
from .. import sheet
from ..registers import NEGATIVE_LIMIT, POSITIVE_LIMIT, AxisState, Registers

DWELL = 20  # clocks of an encoder state at 1.25 Mcounts/s
LIMITS = {1: POSITIVE_LIMIT, -1: NEGATIVE_LIMIT}  # events of the switches, by direction
FORWARD = ((0, 0), (1, 0), (1, 1), (0, 1))  # the encoder's A and B in positive direction


class TwinFilter:
    """An input with its filter: a level is accepted when it has lasted for three clocks of 160 ns."""

    def __init__(self, chip: ChipContext, name: str) -> None:
        self.chip, self.name = chip, name
        chip.pins[name].net.watch(self.change)
        self.begin()

    def begin(self) -> None:
        """Start with the input's level at the end of this instant, and discard any edges."""
        self.begun = self.chip.kernel.now
        self.level = self.raw = int(self.chip.pins[self.name].net.level or 0)
        self.since = 0  # tick of the last change
        self.edges: dict[int, int] = {}  # tick: level; edges accepted since the last sample

    def change(self, net: Net) -> None:
        """Record a change of the input at this instant."""
        if net.kernel.now == self.begun:
            self.level = self.raw = int(net.level or 0)
            return
        tick = self.chip.clock.ticks_from(net.kernel.now)
        self.pass_time(tick)
        self.raw, self.since = int(net.level or 0), tick

    def pass_time(self, tick: int) -> None:
        """Accept the present level of the input if, at the given tick, it has lasted for the filter time."""
        if self.raw != self.level and self.since + sheet.FILTER_TICKS <= tick:
            self.level = self.raw
            self.edges[self.since + sheet.FILTER_TICKS] = self.level

    def look(self, tick: int) -> dict[int, int]:
        """Return the filtered edges accepted since the last call, up to but excluding a tick: {tick: level}."""
        self.pass_time(tick - 1)
        edges, self.edges = self.edges, {}
        return edges


class TwinEncoder:
    """A quadrature encoder with its filters: four counts per period, counting up when A leads B."""

    def __init__(self, chip: ChipContext, number: int) -> None:
        self.chip, self.number = chip, number
        self.a, self.b = TwinFilter(chip, f"quada{number}"), TwinFilter(chip, f"quadb{number}")
        self.begin()

    def begin(self) -> None:
        """Start counting again from 0."""
        self.a.begin()
        self.b.begin()
        self.state: tuple[int, int] | None = None  # output of the filters; not yet known
        self.since = -DWELL  # tick of the last change
        self.fast = False  # until a state lasts twice the minimum

    def counts(self, tick: int) -> int:
        """Return the signed net number of counts since the last call, up to but excluding a tick."""
        if self.state is None:
            if self.chip.kernel.now == self.a.begun:
                return 0
            self.state = self.a.level ^ len(self.a.edges) & 1, self.b.level ^ len(self.b.edges) & 1
        a, b = self.a.look(tick), self.b.look(tick)
        return sum(self.count(at, (a.get(at, self.state[0]), b.get(at, self.state[1]))) for at in sorted({*a, *b}))

    def count(self, tick: int, state: tuple[int, int]) -> int:
        """Return the count for a change to `state` (A, B) at a tick: 1 or -1; 0 if A and B have changed together."""
        lasted, self.since = tick - self.since, tick
        if lasted < DWELL and not self.fast:
            self.chip.finding("encoder-fast", f"axis {self.number}: encoder faster than 1.25 Mcounts/s")
        self.fast = lasted < DWELL or (self.fast and lasted < 2 * DWELL)
        moved = (FORWARD.index(state) - FORWARD.index(self.state)) % 4
        self.state = state
        if moved == 2:
            self.chip.finding("encoder-illegal", f"axis {self.number}: A and B changed together; not counted")
            return 0
        return 1 if moved == 1 else -1


class Switches:
    """The limit switches of an axis.  They are sampled once per cycle; directions are 1 and -1."""

    def __init__(self, chip: ChipContext, registers: Registers, state: AxisState) -> None:
        self.chip, self.registers, self.state = chip, registers, state
        self.armed = {1: True, -1: True}  # the next active level trips the switch

    @property
    def flagged(self) -> bool:
        """True if the limit switches are enabled and the event of one is still set, so that the axis cannot move."""
        return bool(self.registers.limits_on and self.state.events & (POSITIVE_LIMIT | NEGATIVE_LIMIT))

    def active(self, direction: int) -> bool:
        """Return whether the limit switch of a direction is enabled and active."""
        number = self.state.number
        level = int(self.chip.pins[f"{'pos' if direction > 0 else 'neg'}limit{number}"].net.level or 0)
        low = self.registers.limit_sense >> (2 * (number - 1) + (direction < 0)) & 1
        return self.registers.limits_on and level != low

    def tripped(self) -> Iterator[int]:
        """Yield the direction of each switch that becomes active; while one is tripped, the other is ignored."""
        for direction in (1, -1):
            self.armed[direction] |= not self.active(direction)
        for direction in (1, -1):
            other_in_charge = self.state.events & LIMITS[-direction] or (
                self.active(-direction) and not self.armed[-direction]
            )
            if not other_in_charge and self.active(direction) and self.armed[direction]:
                self.armed[direction] = False
                yield direction
