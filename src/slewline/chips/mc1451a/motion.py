"""The cycles of a chipset: those in which an axis has a decision to make are processed, all others are skipped.

    commands, limits, HOME, encoders                 the kernel calls this object in each due cycle;
          |  attend: the next cycle is due           a query in between is answered from the present run (catch_up)
          v
    axis 1   due ------------>|                      due: the next cycle in which an axis has a decision to make,
    axis 2   due ---->|                                   if nothing happens before

A cycle uses the levels that its inputs have just before the instant at which it begins.  A command
that ends at that instant is processed after the cycle, and a pulse edge at that instant still belongs to
the preceding pulses.
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
        self.cycle = 0  # the last cycle that has begun, as of the last query
        self.calls: list[int] = []  # ticks of the requested kernel calls, the next one last
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
        """Begin cycle 0 at this instant, after reset."""
        self.running, self.cycle = True, 0
        for trajectory in self.trajectories:
            trajectory.begin()
        self._work(0)
        self._schedule()

    def stop(self) -> None:
        """Output no more pulses after this instant, because of a reset or the loss of supply."""
        if self.running:
            self.running, self.cycle = False, 0
            for trajectory in self.trajectories:
                trajectory.pulses.end()

    def catch_up(self) -> None:
        """Update the registers to the present cycle, because an observer is about to read or write them."""
        if not self.running:
            return
        n = self.cycle_clock.cycle_at(self.kernel.now)
        for trajectory in self.trajectories:
            if trajectory.due <= n:
                self._work(n)
                self._schedule()
                break
        if n != self.cycle:
            self.cycle = n
            for trajectory in self.trajectories:
                trajectory.sync(n)

    def attend(self) -> None:
        """Make the next cycle due, because a register or an input has changed."""
        if self.running:
            due = max(self.cycle, self.cycle_clock.cycle_at(self.kernel.now)) + 1
            for trajectory in self.trajectories:
                trajectory.due = min(trajectory.due, due)
            self._schedule()

    def attend_soon(self) -> None:
        """Call `attend` in the kernel's next round, not now, because a filtered input may be about to change."""
        if self.running:
            self.kernel.call_at(self.kernel.now, self.attend)

    def _schedule(self) -> None:
        """Ensure that the kernel calls this object at the next due cycle or earlier; each call schedules the next.

        Calls that are no longer needed are not cancelled, because such a call is cheap.  A cancelled call,
        however, leaves an entry in the kernel; with one for each host write, the entries would mount up in a
        motion that lasts for hours.
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
        """Process the cycle that begins now."""
        self.cycle = n
        for trajectory in self.trajectories:
            if trajectory.due <= n:
                trajectory.work(n)
            else:
                trajectory.sync(n)
        self.interrupt.look()
        self.activity.worked()

    def _limit(self, switches: LimitSwitches, limit: int, net: Net) -> None:
        """Record the new level of a limit input; a cycle that begins at this instant has sampled the old level."""
        if self.running:
            self.catch_up()
            switches.levels[limit] = net.value or 0
            self.attend()

    # -------------------------------------------------------------------------------------------------------- commands
    def declare(self, state: AxisState, value: int) -> None:
        """Set the position of an axis, immediately and without pulses."""
        self.trajectories[state.number - 1].updates.declare(self.cycle, value)
