"""The cycles of a chipset: works those in which an axis has something to decide, and passes over all others.

    commands, limits, HOME, encoders                 a cycle that must be worked is an instant of the kernel;
          |  attend: the next cycle is due           whoever asks in between is shown what holds since (catch_up)
          v
    axis 1   due ------------>|                      due: the next cycle in which an axis decides, by itself
    axis 2   due ---->|

In the instant at which a cycle begins, inputs count as they were just before it, a command that ends there comes after
it, and the last edge of the pulses before it belongs to them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...core.net import Net
from .horizon import NEVER
from .sheet import CYCLE_TICKS
from .state import POSITIVE_LIMIT, AxisState
from .trajectory import Trajectory

if TYPE_CHECKING:
    from .firmware import Chipset


class Motion:
    """The trajectory generators of all axes."""

    def __init__(self, chip: Chipset) -> None:
        self.chip, self.kernel = chip, chip.kernel
        self.running = False
        self.cycle = 0  # the one that has begun last, as far as anybody has asked
        self.calls: list[int] = []  # ticks at which the kernel calls, the next one last
        self.levels: dict[str, int] = {}  # of the limit inputs
        self.trajectories = [Trajectory(self, state) for state in chip.states]
        for trajectory in self.trajectories:
            n = trajectory.state.number
            for name in (f"poslimit{n}", f"neglimit{n}"):
                chip.pins[name].net.watch(lambda net, name=name: self._limit(name, net))  # type: ignore[misc]
            trajectory.home.reading.on_change.add(self.attend_soon)
            if trajectory.encoder is not None:
                trajectory.encoder.watch(self.attend_soon)

    # ------------------------------------------------------------------------------------------------------------ time
    def tick(self, n: int) -> int:
        """The tick at which a cycle begins."""
        return self.chip.origin + n * CYCLE_TICKS

    def start(self) -> None:
        """Reset is over: cycle 0 begins."""
        self.running, self.cycle = True, 0
        for trajectory, state in zip(self.trajectories, self.chip.states, strict=True):
            trajectory.begin(state)
            n = state.number
            for name in (f"poslimit{n}", f"neglimit{n}"):
                self.levels[name] = self.chip.pins[name].level or 0
        self._work(0)
        self._schedule()

    def stop(self) -> None:
        """Reset, or no supply: no pulse after this instant."""
        if self.running:
            self.running, self.cycle = False, 0
            for trajectory in self.trajectories:
                trajectory.end()

    def catch_up(self) -> None:
        """Show the present cycle in the registers, which an observer is about to read or write."""
        if not self.running:
            return
        n = (self.chip.clock.ticks_until(self.kernel.now) - self.chip.origin) // CYCLE_TICKS
        if min(trajectory.due for trajectory in self.trajectories) <= n:
            self._work(n)
            self._schedule()
        if n != self.cycle:
            self.cycle = n
            for trajectory in self.trajectories:
                trajectory.sync(n)

    def attend(self) -> None:
        """Something has been written, or an input has changed: the next cycle is due."""
        if self.running:
            due = max(self.cycle, self._begun()) + 1
            for trajectory in self.trajectories:
                trajectory.due = min(trajectory.due, due)
                trajectory.was_off |= not trajectory.state.motor_on  # even if it is on again in time
            self._schedule()

    def attend_soon(self) -> None:
        """A filtered input is about to change: it may count in the next cycle, or in the one after."""
        if self.running:
            self.kernel.call_at(self.kernel.now, self.attend)

    def _begun(self) -> int:
        return (self.chip.clock.ticks_until(self.kernel.now) - self.chip.origin) // CYCLE_TICKS

    def _schedule(self) -> None:
        """Be called for the next cycle that is due, or for an earlier one.

        A call that comes for nothing is cheap.  To cancel it would leave it behind in the kernel, as often as a host
        writes while a motion goes on for hours.
        """
        due = min(trajectory.due for trajectory in self.trajectories)
        tick = self.tick(due)
        if due < NEVER and (not self.calls or tick < self.calls[-1]):
            self.calls.append(tick)
            self.kernel.call_at(self.chip.clock.ps(tick), self._called)

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
        self.chip.interrupt()
        self.chip.worked()

    # ---------------------------------------------------------------------------------------------------------- inputs
    def _limit(self, name: str, net: Net) -> None:
        """A limit input has changed; the cycle that begins now has not seen it."""
        if self.running:
            self.catch_up()
            self.levels[name] = net.value or 0
            self.attend()

    def active(self, number: int, limit: int) -> bool:
        """Is the limit switch of an axis active?"""
        positive = limit == POSITIVE_LIMIT
        bit = 2 * (number - 1) + (not positive)
        level = self.levels[f"{'pos' if positive else 'neg'}limit{number}"]
        return bool(level ^ self.chip.limit_sense >> bit & 1)

    # -------------------------------------------------------------------------------------------------------- commands
    def declare(self, state: AxisState, value: int) -> None:
        """The present position is this, at once."""
        self.trajectories[state.number - 1].declare(self.cycle, value)
