"""The state of a drive: one object that all pieces of the drive read, and that only its own methods change.

    DriveState              the present run of the model, the configuration of the board, the phase, the counts
    DrivePath               clock, line, ticks, feeder and cable: the path between model and board
    Stopping                interface of the pieces that react when the board stops by itself

No piece has access to the drive: each has only these objects, and the pieces that it works with.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol

from ..core.time.timebase import PS_PER_S
from .board.board_link import Link
from .board.clock import BoardClock
from .cable import Cable
from .feeder import Feeder, PlannedOutput
from .ticks import TickMap

if TYPE_CHECKING:
    from ..bench import Bench
    from ..core.chip import Chip
    from ..core.motion.axis import Axis
    from ..core.time.kernel import Kernel
    from ..core.wires.net import Net
    from .board.boards import BoardModel
    from .board.wire import BoardConfig, BoardEvent

Phase = Literal["closed", "ok", "halted", "unknown"]


@dataclass(slots=True)
class DriveState:
    """The state shared by all pieces of a drive.

    Attributes:
        final: True if the board is at rest after a halt, and its count is known.
        known: True if the position register holds the position of the motor, as far as can be known.
        undecided: True if the model may yet be taken back to the point where the motor comes to rest.
    """

    bench: Bench
    chip: Chip
    number: int  # number of the axis, from 1
    board: BoardModel
    config: BoardConfig
    horizon_ps: int
    start_stop: int | None  # steps/s
    enable: bool
    keep_count: bool
    outputs: Mapping[int, str]  # pins that set outputs of the board, by the numbers of the outputs
    phase: Phase = "closed"
    final: bool = False
    known: bool = True
    undecided: bool = False
    count_origin: int = 0  # count of the board at travel 0 of the model
    counted_from: int = 0  # count of the board before the feeder has fed a step
    axis: Axis = field(init=False)
    kernel: Kernel = field(init=False)
    horizon: int = field(init=False)  # ticks

    def __post_init__(self) -> None:
        self.horizon = self.horizon_ps * self.board.hz // PS_PER_S
        self.axis, self.kernel = self.chip.axis(self.number).motor, self.bench.kernel

    def move(self, bench: Bench) -> None:
        """Continue on another bench that is at the same instant as this one, with a chip of the same name."""
        self.bench, self.kernel = bench, bench.kernel
        self.chip = bench.chips[self.chip.name]
        self.axis = self.chip.axis(self.number).motor

    def nets(self) -> list[tuple[Net, int]]:
        """Return each net that sets a board output, paired with the number of that output."""
        return [(self.chip.pin(name).net, number) for number, name in self.outputs.items()]

    def half_steps(self) -> bool:
        """Return whether the chip makes half steps now."""
        return bool(getattr(getattr(self.chip, "state", None), "half", False))

    def configure(self, config: BoardConfig) -> None:
        """Record the configuration that the board has from now on."""
        self.config = config

    def begin(self) -> None:
        """Record that from now on the board follows the model, at the start of the session or after a halt."""
        self.phase = "ok"

    def halt(self, *, final: bool = False) -> None:
        """Record that the board no longer follows the model; `final`: the board is at rest, and its count is known."""
        self.phase, self.final = "halted", final

    def finish(self) -> None:
        """Record that the board of a halted drive is at rest, and that its count is known."""
        self.final = True

    def lose(self) -> None:
        """Record that the board has lost its count."""
        self.phase, self.known = "unknown", False

    def close(self) -> None:
        """Record that the session has ended."""
        self.phase = "closed"

    def trust(self, known: bool = True) -> None:
        """Record whether the position register holds the position of the motor."""
        self.known = known

    def leave_open(self, undecided: bool) -> None:
        """Record whether the model may yet be taken back to the point where the motor comes to rest."""
        self.undecided = undecided

    def count_from(self, counted: int, travel: int, net: int) -> None:
        """Record the count of the board that corresponds to the present travel of the model.

        Args:
            counted: the count of the board.
            travel: the travel of the model at that count, in steps.
            net: the net number of steps fed to the board, up minus down.
        """
        self.count_origin, self.counted_from = counted - travel, travel - net

    def correct(self, steps: int) -> None:
        """Accept a board count that exceeds the expected count by `steps` (negative if it is lower)."""
        self.counted_from += steps


class DrivePath:
    """The path between the model and its board: clock, line, ticks, feeder and cable.

    Args:
        wall: a function that returns the wall-clock time, ns.
    """

    def __init__(self, state: DriveState, wall: Callable[[], int]) -> None:
        board, horizon = state.board, state.horizon
        self.state, self.wall = state, wall
        self.clock = BoardClock(board.hz)
        self.link = Link(self.clock)
        self.ticks = ticks = TickMap(board.hz)
        of = state.axis, state.kernel, self.link, ticks, horizon, board.shortest
        self.feeder = Feeder(*of, self._put, state.half_steps)
        self.cable = Cable(horizon, lambda: ticks.at(state.kernel.now) >> 16, self._in_motion)

    def _in_motion(self) -> bool:
        """Return whether steps are pending, or the rest position of the motor is undecided."""
        return self.feeder.busy or self.state.undecided

    def gate(self, call: Callable[[], object], ps: int) -> None:
        """Make a call when the motor reaches an instant of the model (ps), one horizon after the model does.

        If no steps or calls are pending, make the call immediately.
        """
        self.cable.send_at((self.ticks.at(ps) >> 16) + self.state.horizon, call)

    def _put(self, output: PlannedOutput) -> None:
        """Send a frame that changes outputs: at the tick of the change, or immediately if no output is pending."""
        self.cable.send_at(output.tick16 >> 16, lambda: self.link.outputs(output.mask, output.value))

    def send_tail(self, entries: list[tuple[int, int]], ps: int) -> None:
        """Send the board the stop ramp of a new motion, after the motor has finished its previous motion.

        Args:
            entries: the table of the stop ramp.
            ps: the instant at which the new motion begins in the model (ps).
        """
        if self.feeder.running:
            self.gate(lambda: self.link.tail(entries), ps)
        else:
            self.link.tail(entries)

    def move(self) -> None:
        """Let the feeder take its steps from the bench that `state` now refers to."""
        self.feeder.axis, self.feeder.kernel = self.state.axis, self.state.kernel


class Stopping(Protocol):
    """The actions of a drive when its board stops by itself.

    After a stop, `stopped` is called first, once; `turn` is called repeatedly; `halted` is called when the
    board is at rest and its count is final; `clear` is called when the user lets the drive continue.
    """

    def expects(self, event: BoardEvent) -> bool:
        """Return whether this event also makes the chip itself stop the motor, so that the stop is expected."""

    def stopped(self, event: BoardEvent) -> None:
        """Handle a stop of the board: it outputs no further steps of the model; a stop ramp may follow."""

    def halted(self, event: BoardEvent) -> None:
        """Handle the board's report that it is at rest after a stop.

        The event has the position and tick of the last step.
        """

    def turn(self) -> None:
        """Do the work that is due while the drive is halted; called in each turn."""

    @property
    def settled(self) -> bool:
        """True while the chip is at rest at the position of the motor."""

    def clear(self) -> None:
        """Release the chip if it was stopped, so that it can move again."""


class Movable(Protocol):
    """A motor that can stop, and then continue along another run of the model."""

    def stop(self, at_once: bool = False) -> None:
        """Stop the motor, by ramping down or, with `at_once`, immediately."""

    def move(self, bench: Bench) -> None:
        """Continue with another bench that is at the same instant as this one, with a chip of the same name."""

    def resume(self, position: int, since_ps: int) -> None:
        """Let a stopped board continue: it counts from a position, and outputs the model's steps after `since_ps`."""


class FoundBoard(NamedTuple):
    """The condition of a board when it was opened.

    It consists of its state, its count, whether it was in motion, and whether the position of the motor may
    differ from the count.
    """

    state: int
    counted: int
    moving: bool
    unsure: bool
