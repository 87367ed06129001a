"""The cycles of a chipset: works those in which an axis has something to decide, and passes over all others.

    commands, limits, HOME, encoders                 a cycle that must be worked is an instant of the kernel;
          |  attend: the next cycle is due           a question in between is answered by what holds since (catch_up)
          v
    axis 1   due ------------>|                      due: the next cycle in which an axis decides, by itself
    axis 2   due ---->|

In the instant at which a cycle begins, inputs count as they were just before it, a command that ends there comes after
it, and the last edge of the pulses before it belongs to them.
"""

from __future__ import annotations

from functools import partial

from ...core.context import ChipContext
from ...core.wires.net import Net
from .activity import Activity
from .axis.horizon import NEVER
from .axis.switches import LimitSwitches
from .axis.trajectory import Trajectory
from .cycle_clock import CycleClock
from .interrupt import HostInterrupt
from .registers import AxisState, Registers


class Motion:
    """The trajectory generators of all axes."""

    def __init__(
        self,
        chip: ChipContext,
        registers: Registers,
        cycle_clock: CycleClock,
        interrupt: HostInterrupt,
        activity: Activity,
    ) -> None:
        self.kernel, self.cycle_clock, self.interrupt, self.activity = chip.kernel, cycle_clock, interrupt, activity
        self.running = False
        self.cycle = 0  # the one that has begun last, as far as anybody has asked
        self.calls: list[int] = []  # ticks at which the kernel calls, the next one last
        self.trajectories = [Trajectory(chip, registers, state, cycle_clock) for state in registers.states]
        for trajectory in self.trajectories:
            switches, encoder = trajectory.switches, trajectory.feedback.encoder
            for limit, net in switches.nets.items():
                net.watch(partial(self._limit, switches, limit))
            trajectory.home.reading.on_change.add(self.attend_soon)
            if encoder is not None:
                encoder.watch(self.attend_soon)

    # ------------------------------------------------------------------------------------------------------------ time
    def start(self) -> None:
        """Begin cycle 0 at this instant: reset is over."""
        self.running, self.cycle = True, 0
        for trajectory in self.trajectories:
            trajectory.begin()
        self._work(0)
        self._schedule()

    def stop(self) -> None:
        """Make no pulse after this instant: reset, or no supply."""
        if self.running:
            self.running, self.cycle = False, 0
            for trajectory in self.trajectories:
                trajectory.pulses.end()

    def catch_up(self) -> None:
        """Show the present cycle in the registers, which an observer is about to read or write."""
        if not self.running:
            return
        n = self.cycle_clock.cycle_at(self.kernel.now)
        if min(trajectory.due for trajectory in self.trajectories) <= n:
            self._work(n)
            self._schedule()
        if n != self.cycle:
            self.cycle = n
            for trajectory in self.trajectories:
                trajectory.sync(n)

    def attend(self) -> None:
        """Make the next cycle due: something has been written, or an input has changed."""
        if self.running:
            due = max(self.cycle, self.cycle_clock.cycle_at(self.kernel.now)) + 1
            for trajectory in self.trajectories:
                trajectory.due = min(trajectory.due, due)
            self._schedule()

    def attend_soon(self) -> None:
        """Make the next cycle due when this round is over: a filtered input is about to change, and may count then."""
        if self.running:
            self.kernel.call_at(self.kernel.now, self.attend)

    def _schedule(self) -> None:
        """Be called for the next cycle that is due, or for an earlier one.

        A call that comes for nothing is cheap.  To cancel it would leave it behind in the kernel, as often as a host
        writes while a motion goes on for hours.
        """
        due = min(trajectory.due for trajectory in self.trajectories)
        tick = self.cycle_clock.tick(due)
        if due < NEVER and (not self.calls or tick < self.calls[-1]):
            self.calls.append(tick)
            self.kernel.call_at(self.cycle_clock.clock.ps(tick), self._called)

    def _called(self) -> None:
        self.calls.pop()
        if self.running:
            self.catch_up()
            self._schedule()

    def _work(self, n: int) -> None:
        """Work the cycle that begins now."""
        self.cycle = n
        for trajectory in self.trajectories:
            if trajectory.due <= n:
                trajectory.work(n)
            else:
                trajectory.sync(n)
        self.interrupt.look()
        self.activity.worked()

    def _limit(self, switches: LimitSwitches, limit: int, net: Net) -> None:
        """Take the new level of a limit input, which the cycle that begins now has not seen."""
        if self.running:
            self.catch_up()
            switches.levels[limit] = net.value or 0
            self.attend()

    # -------------------------------------------------------------------------------------------------------- commands
    def declare(self, state: AxisState, value: int) -> None:
        """Set the position of an axis, at once and without pulses."""
        self.trajectories[state.number - 1].updates.declare(self.cycle, value)
