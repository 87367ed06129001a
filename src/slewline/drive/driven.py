"""What the pieces of a drive know of the whole, and what can be put in their places."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol

if TYPE_CHECKING:
    from ..bench import Bench
    from ..core.chip import Chip
    from ..core.motion.axis import Axis
    from ..core.time.hook import Hook
    from ..core.time.kernel import Kernel
    from ..core.wires.net import Net
    from .board.boards import BoardModel
    from .board.clock import BoardClock
    from .board.link import Link
    from .board.port import BoardPort
    from .board.wire import BoardConfig, BoardEvent
    from .cable import Cable
    from .feeder import Feeder
    from .ticks import TickMap

DriveState = Literal["closed", "ok", "halted", "unknown"]


class Stopping(Protocol):
    """What a drive does when its board stops by itself.

    `stopped` comes first, once; `halted` when the board stands and its count is final; `turn` again and again
    meanwhile; `clear` when the user goes on.
    """

    def expects(self, event: BoardEvent) -> bool:
        """Return whether the chip itself stops the motor there, by its own law: that is no trouble."""

    def stopped(self, event: BoardEvent) -> None:
        """Take note that the board makes no more steps of the model; a way down may follow."""

    def halted(self, event: BoardEvent) -> None:
        """Take note that the board stands; position and tick of the event are those of the last step."""

    def turn(self) -> None:
        """Do what is to be done while the drive is halted; called each turn."""

    @property
    def settled(self) -> bool:
        """Whether the chip is at rest where the motor is."""

    def clear(self) -> None:
        """Let the chip go on."""


class Exchanger(Protocol):
    """Puts another bench in the place of the present one, such as a server that has hosts on its ports."""

    def exchange(self, bench: Bench, since_ps: int) -> None:
        """Go on with another bench, which did the same as the present one up to an instant (ps)."""

    def listen(self, bench: Bench) -> object:
        """Hear what another bench does, before it does anything."""

    def forget(self, before_ps: int) -> None:
        """Take note that no other bench begins before an instant (ps)."""


class FoundBoard(NamedTuple):
    """What a board was as it was opened.

    Its state, its count, whether it was in motion, and whether the motor may be elsewhere than it has counted.
    """

    state: int
    counted: int
    moving: bool
    unsure: bool


class Current(Protocol):
    """The current of the driver, and what is known of the position."""

    @property
    def on(self) -> bool:
        """Whether the driver is enabled."""

    def doubt(self) -> None:
        """Record that the motor may be elsewhere than the register."""


class Telling(Protocol):
    """Reports troubles of a drive."""

    @property
    def final(self) -> bool:
        """Whether the count of a halted board at rest is known."""

    def report(self, code: str, text: str, position: int | None = None) -> None:
        """Report a trouble as a finding of the chip, and, with a position, set its register."""

    def taken_over(self, missing: int, known: bool) -> None:
        """Report that the chip has made steps that the motor has not: so many, net; set its register."""

    def goes_on(self, found: FoundBoard, keep_count: bool) -> None:
        """Report that a board was in use before; with `keep_count`, set the register of the chip to its count."""

    def too_fast(self, error: Exception) -> None:
        """Halt the drive: the model makes steps faster than the board can."""

    def moved_by_itself(self) -> None:
        """Halt the drive: the chip moves, and nobody has told it to."""

    def not_started(self) -> None:
        """Halt the drive: the board has not taken the start of a motion."""

    def stopped_at_rest(self) -> None:
        """Halt the drive: the host stops a motor that is at rest, and steps are to come."""

    def switched_off(self) -> None:
        """Halt the drive: the board has switched the driver off."""

    def clock_jumped(self) -> None:
        """Continue, or halt the drive: this computer slept, and the board did not."""


class Driven(Protocol):
    """A drive, as its pieces see it."""

    bench: Bench
    chip: Chip
    axis: Axis
    axis_number: int
    kernel: Kernel
    board: BoardModel
    config: BoardConfig
    horizon: int  # ticks
    horizon_ps: int
    start_stop: int | None  # steps/s
    count_origin: int  # the count of the board where the travel of the model is 0
    counted_from: int  # the count of the board that belongs to a feeder that has laid nothing
    enable: bool
    keep_count: bool
    state: DriveState
    clock: BoardClock
    link: Link
    ticks: TickMap
    feeder: Feeder
    cable: Cable
    port: BoardPort
    wall: Callable[[], int]  # ns
    on_event: Hook[[BoardEvent]]
    stopping: Stopping
    watch: Telling

    @property
    def power(self) -> Current:
        """The current of the driver."""

    def nets(self) -> list[tuple[Net, int]]:
        """Return the nets that set outputs of the board, and the number of each output."""

    def turn(self) -> None:
        """Hear the board, lay what the model has done, let what is due leave, and speak."""

    def due(self) -> float:
        """Return in how many seconds the next turn is due at the latest, unless something comes from outside before."""

    def catch_up(self) -> None:
        """Align the model if, at rest, the program has done something else meanwhile."""

    def stop(self, at_once: bool = False) -> None:
        """Stop the motor, by its way down or at once; the drive is halted then."""

    def move(self, bench: Bench) -> None:
        """Go on with another bench, which is at the same instant and has a chip of the same name."""

    def resume(self, position: int, since_ps: int) -> None:
        """Let a board that has stopped go on: it counts from a position, and makes the steps after an instant (ps)."""

    def take_over(self, position: int, known: bool = True) -> None:
        """Set the position register of the chip to where the board has counted the motor to be."""
