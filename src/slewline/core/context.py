"""The interface of a chip for its firmware and for the objects inside it.

The interface for users is in [the reference](docs/reference/api.md).  Objects of the firmware receive the same chip as
a `ChipContext`, and a type checker proves that they use nothing else.  At run time there is no difference.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from .datasheet.table import Sheet
from .motion.axis import Axis
from .time.hook import Hook
from .time.kernel import Kernel, Task
from .time.timebase import Clock
from .wires.net import Bus, Driver, Net
from .wires.pin import Terminal


class ChipContext(Protocol):
    """A chip as its firmware and the objects inside it see it."""

    # ---------------------------------------------------------------------------------------------------- identity
    name: str
    sheet: Sheet
    options: Any  # every option of the sheet by its name, checked
    crystal_hz: int

    # ------------------------------------------------------------------------------------------------ virtual time
    kernel: Kernel
    clock: Clock
    tick: int  # the chip's own count of clocks: every sleep adds to it, so it does not drift

    def sync(self) -> None:
        """Set the tick count to the first clock tick at or after the current kernel instant."""

    def sync_forward(self) -> None:
        """Synchronize the tick count like `sync`, unless it is already ahead of this instant."""

    async def ticks(self, number: int) -> None:
        """Wait for `number` crystal clocks."""

    async def at_tick(self, tick: int) -> None:
        """Wait until a tick of the crystal; return immediately if it has passed."""

    async def polled(self, net: Net, wanted: int, every: int, *others: tuple[Net, int]) -> Net:
        """Sample a net periodically, starting now, until its level is `wanted`; return the net.

        Args:
            net: the net that is sampled.
            wanted: the level that ends the wait, 0 or 1.
            every: the period, in crystal clocks.
            others: further nets with levels that end the wait; then that net is returned.
        """
        raise NotImplementedError

    # ------------------------------------------------------------------------------------------------------- wires
    drivers: dict[str, Driver]
    bus: Bus
    bus_driver: Driver

    @property
    def pins(self) -> Mapping[str, Terminal]:
        """All pins, keyed by the manual's names; the data bus pins share the bus net."""

    # ---------------------------------------------------------------------------------------------------- motion
    axes: tuple[Axis, ...]

    # ------------------------------------------------------------------------------------------------------ reports
    idle: bool
    on_command: Hook[[str]]
    on_instruction: Hook[[int]]
    task: Task | None  # of the firmware; None if it has been killed or has not begun

    def switched(self, on: bool) -> None:
        """Report that the supply is switched on or off."""

    def finding(self, code: str, text: str, at: int | None = None) -> None:
        """Add a finding, now or at a past instant (ps): something that the manual forbids or does not specify."""

    def waits(self, text: str, since: int | None = None) -> None:
        """Record a text about what the firmware does, from now or from an instant (ps) on; `waiting` shows it."""
