"""The interface of a chip for its firmware and for the objects inside it.

The interface for users is in [the reference](docs/reference/api.md).  Firmware objects receive the same
chip typed as `ChipContext`; a type checker proves that they use nothing else.  This has no effect at run
time.
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
    """The members of a chip that its firmware and the objects inside it may use."""

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
        """Set the tick count as `sync` does, but leave it unchanged if it is already ahead of the present instant."""

    async def ticks(self, number: int) -> None:
        """Wait for `number` crystal clocks."""

    async def at_tick(self, tick: int) -> None:
        """Wait until the tick count is `tick`; return immediately if the tick count is already that high."""

    async def polled(self, net: Net, wanted: int, every: int, *others: tuple[Net, int]) -> Net:
        """Sample a net periodically, starting now, until its level is `wanted`; return the net.

        Args:
            net: the net that is sampled.
            wanted: the level that ends the wait, 0 or 1.
            every: the period, in crystal clocks.
            others: further nets, each with a level that also ends the wait; the net that ends it is returned.
        """
        raise NotImplementedError

    # ------------------------------------------------------------------------------------------------------- wires
    drivers: dict[str, Driver]
    bus: Bus
    bus_driver: Driver

    @property
    def pins(self) -> Mapping[str, Terminal]:
        """All pins, keyed by the manual's names in lower case; all pins of the data bus share one net, `bus`."""

    # ---------------------------------------------------------------------------------------------------- motion
    axes: tuple[Axis, ...]

    # ------------------------------------------------------------------------------------------------------ reports
    idle: bool
    on_command: Hook[[str]]
    on_instruction: Hook[[int]]
    task: Task | None  # of the firmware; None if it has been killed or has not begun

    def switched(self, on: bool) -> None:
        """Record that the supply is switched on (True) or off (False), and call the chip's hook `on_power`."""

    def finding(self, code: str, text: str, at: int | None = None) -> None:
        """Add a finding (something that the manual forbids or leaves open), dated now or at a past instant (ps)."""

    def waits(self, text: str, since: int | None = None) -> None:
        """Record, for `waiting`, a text about the firmware's activity, which began at `since` (ps; None: now)."""
