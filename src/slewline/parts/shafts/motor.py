"""Motors: a pulse-to-step translator with its motor, a motor with limits, and a rotor between two windings."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Protocol

from ...core.datasheet.option import Option
from ...core.time.events import Events, Later, earliest
from ...core.time.kernel import Kernel
from ...core.time.timebase import Time, picoseconds
from ...core.wires.clocking import ScanWindow
from ...core.wires.views import Repeated
from ...errors import UsageError
from ..base.clocked import Clocked
from ..base.follower import Follower, start_rule
from ..base.part import AXIS, Part
from .followed_steps import FollowedSteps, MotorLimits, PulseFollowing
from .shaft import Shaft, forget_shaft, shaft_quantities
from .shaft_counter import CountScale, StepCounter
from .shaft_motion import Once
from .shown import EncoderChannel, LevelPattern

if TYPE_CHECKING:
    from ...core.datasheet.table import Pin
    from ...core.wires.wave import Level

EDGES = {"fall": 0, "rise": 1}
EDGE = Option(
    "edge", "choice", None, "step edge of the pulse; by default that of the neighbour's pin",
    choices=tuple(EDGES), none=True,
)  # fmt: skip
WINDINGS = MappingProxyType({(-1, -1): 0, (1, -1): 1, (1, 1): 2, (-1, 1): 3})  # the field by windings a and b
FIELDS = tuple(  # the field, by the levels of phases 1 to 4 as bits
    WINDINGS.get(((n & 1) - (n >> 1 & 1), (n >> 2 & 1) - (n >> 3 & 1))) for n in range(16)
)
STEP_WIRING = MappingProxyType({"pulse": "step", "direction": "direction"})
STEP_OPTIONS = (AXIS, EDGE)
DETECTOR = MappingProxyType({"x": LevelPattern(0, 1, 1, 0), "y": LevelPattern(0, 0, 1, 1)})  # levels by the position


class StepDrive:
    """PULSE and DIRECTION of a part, and the shaft that they turn: each active edge of PULSE is a step.

    DIRECTION high means clockwise, unless `to` has wired it to a neighbour's pin with the opposite meaning.

    Args:
        part: the part, to which the pins are added.
        edge: the step edge, "fall" or "rise", as set by the user.
        default: the edge if neither user nor neighbour sets one.
        advance, step, follow: functions for `Clocked`; by default each pulse is a step, without delay.
    """

    def __init__(
        self,
        part: Part,
        edge: str | None = None,
        default: str = "fall",
        *,
        advance: Callable[[int], None] | None = None,
        step: Callable[[], None] | None = None,
        follow: Callable[[Events], None] | None = None,
    ) -> None:
        self.part, self.shaft = part, Shaft(part.kernel)
        self._chosen = edge is not None
        self._clockwise = True  # DIRECTION high is clockwise
        part.add_pin("pulse", "in", f"step at each {edge or default}", pull=1)
        part.add_pin("direction", "in", "high: clockwise", pull=1)
        self.rule = Clocked(
            part, ("pulse", "direction"), clock="pulse", edge=EDGES[edge or default], steers=("direction",),
            advance=advance or self.shaft.cut, step=step or self._step, follow=follow or self._follow,
        )  # fmt: skip
        self.shaft.source = self.rule

    def attached(self, own: str, row: Pin) -> None:
        """Take the polarity of DIRECTION from the neighbour's pin, and also the step edge unless a user has set it."""
        if own == "pulse" and row.sense is not None and not self._chosen:
            self.rule.edge = row.sense
        if own == "direction" and row.sense is not None:
            self._clockwise = bool(row.sense)

    @property
    def position(self) -> int:
        """Steps clockwise since the start."""
        return self.shaft.place // 1 + (self.sign if self.rule.due else 0)

    @property
    def sign(self) -> int:
        """Direction of a step made now: 1 clockwise, -1 counterclockwise."""
        return 1 if self.part.high("direction") is self._clockwise else -1

    def _step(self) -> None:
        self.shaft.step(self.part.kernel.now, self.sign)

    def _follow(self, clock: Events) -> None:
        self.shaft.turn(clock, self.sign, self.part.kernel.now)


class HasDrive(Protocol):
    """A part with a `StepDrive`."""

    drive: StepDrive


def attach_drive(self: HasDrive, own: str, row: Pin) -> None:
    """Take step edge and DIRECTION polarity from a neighbour's pin; parts with a drive use this as `attached`."""
    self.drive.attached(own, row)


class Translator(Part):
    """A translator and its motor: a falling edge of PULSE is a step in the direction of DIRECTION (CY525 fig. 10.4).

    These two lines are its only inputs, so a PULSE that one of the commands O 128 to O 255 outputs for a phase
    latch is also a step.  Parts on its `shaft`, such as an encoder, switches or a gear, turn with it.

    Args:
        axis: the neighbour's axis.
        edge: the step edge of PULSE, "fall" or "rise"; by default the step edge of the neighbour's pin.
    """

    _for_users = ("position",)
    wiring = STEP_WIRING
    options = STEP_OPTIONS
    attached = attach_drive
    rewired = start_rule
    quantities, forget = shaft_quantities, forget_shaft

    def __init__(self, kernel: Kernel, name: str, *, axis: int = 1, edge: str | None = None) -> None:
        super().__init__(kernel, name)
        self.axis = axis
        self.drive = StepDrive(self, edge)
        self.rule, self.shaft = self.drive.rule, self.drive.shaft

    @property
    def position(self) -> int:
        """Steps clockwise since the start."""
        return self.drive.position

    def shows(self) -> dict[str, Any]:
        """Return the position of the shaft, in steps, and the number of steps per revolution."""
        return {"angle": float(self.shaft.place), "per_turn": self.shaft.per_turn}


class Motor(Part):
    """A motor that can lose steps, with its driver and its step detector (GS-C figures 14, 17, 18).

    A pulse is lost if the preceding step is still under way, or if the pulse comes too soon: the rate, measured from
    the preceding pulse, may be at most `pull_in`, or the rate that the motor reaches from its present rate in one
    step, sqrt(rate^2 + 2 acceleration).  A motor that loses a step stops, and starts again at a pulse with a rate up
    to `pull_in`.

        x   0 1 1 0        the detector signals; clockwise: left to right
        y   0 0 1 1

    Args:
        axis: the neighbour's axis.
        edge: the step edge of PULSE, "fall" or "rise"; by default the step edge of the neighbour's pin.
        lag: the duration of a step.
        pull_in: maximum rate from rest, steps/s; 0: any rate at any time.
        acceleration: the acceleration, steps/s^2, at most pull_in^2 / 2, so that the first step from rest does not
            exceed pull_in either.
        loses: the numbers of the pulses that the motor misses in any case; the first pulse is number 1.
    """

    _for_users = ("position", "lost", "pulses")
    wiring = STEP_WIRING
    options = (
        *STEP_OPTIONS,
        Option("lag", "time", 0, "duration of a step"),
        Option(
            "pull_in",
            "float",
            0,
            "highest rate at which the motor starts from rest; 0: no limit on rate or acceleration",
            low=0,
            unit="steps/s",
        ),
        Option("acceleration", "float", 0, "highest acceleration", low=0, unit="steps/s2"),
        Option("loses", "ints", (), "numbers of pulses, counted from 1, that the motor also misses", low=1),
    )
    attached = attach_drive
    rewired = start_rule
    quantities, forget = shaft_quantities, forget_shaft

    def __init__(
        self,
        kernel: Kernel,
        name: str,
        *,
        axis: int = 1,
        edge: str | None = None,
        lag: Time = 0,
        pull_in: float = 0,
        acceleration: float = 0,
        loses: Iterable[int] = (),
    ) -> None:
        super().__init__(kernel, name)
        if acceleration > pull_in**2 / 2:
            most = f"up to {pull_in**2 / 2:g} with pull_in {pull_in}" if pull_in else "0 without pull_in"
            raise UsageError(f"{name}: acceleration {acceleration}; allowed {most}")
        self._limits = MotorLimits(picoseconds(lag), pull_in, acceleration, frozenset(loses))
        self.axis = axis
        self.drive = StepDrive(self, edge, "rise", advance=self._advance, step=self._step, follow=self._follow)
        self.rule, self.shaft = self.drive.rule, self.drive.shaft
        for pin in DETECTOR:
            self.add_pin(pin, "out", "detector signal", initial=0)
            self.drivers[pin].source = self.rule
        self._pulsed = PulseFollowing()
        self._made: FollowedSteps | None = None  # the followed edges of the clock
        self._step_direction = 0  # the sign of the step that is under way; 0: none
        self.shaft.on_cut.add(lambda ps: self.rule.bound_outputs(ps + 1))
        self.shaft.on_turn.add(self._show)

    @property
    def pulses(self) -> int:
        """Number of pulses so far."""
        return self._now.pulses

    @property
    def lost(self) -> int:
        """Number of pulses that did not become steps."""
        return self._now.lost

    @property
    def _now(self) -> PulseFollowing:
        return self._pulsed if self._made is None else self._made.onward(self.kernel.seen)

    @property
    def position(self) -> int:
        """Full steps clockwise since the start, at the last committed instant."""
        return self.shaft.place // 1

    def shows(self) -> dict[str, Any]:
        """Return the position of the shaft, in steps, and the number of steps per revolution."""
        return {"angle": float(self.shaft.place), "per_turn": self.shaft.per_turn}

    # ------------------------------------------------------------------------------------------------------- changes
    def _advance(self, ps: int) -> None:
        """Process the steps up to an instant (ps)."""
        if self._made is not None:
            self._pulsed = self._made.onward(ps)
            self._made = None
            if self._pulsed.arrives_ps > ps:
                self._step_direction = self._pulsed.direction
        self.shaft.cut(ps)

    def _step(self) -> None:
        """Process the pulse whose edge is at this instant; it becomes a step if the motor follows it."""
        self._arrive()
        self._pulsed = self._limits.after(self._pulsed, self.kernel.now, self.drive.sign)
        if self._pulsed.follows:
            self._step_direction = self.drive.sign
            self._arrive()

    def _arrive(self) -> None:
        """Complete the step that is under way, if it is due."""
        if self._step_direction and self._pulsed.arrives_ps <= self.kernel.now:
            self.shaft.step(self.kernel.now, self._step_direction)
            self._step_direction = 0

    def _follow(self, clock: Events) -> None:
        """Follow the pulses of `clock` from now on."""
        now = self.kernel.now
        self._arrive()
        self._made = FollowedSteps(clock, self._limits, self._pulsed, self.drive.sign)
        if self._step_direction:
            self.shaft.turn(Once(self._pulsed.arrives_ps), self._step_direction, now)
            self.kernel.call_at(self._pulsed.arrives_ps, self.rule.look)
        elif self._limits.free:
            self.shaft.turn(clock, self.drive.sign, now)
        else:
            self.shaft.turn(Later(self._made, self._limits.lag_ps), self.drive.sign, now)

    def _show(self) -> None:
        """Promise the detector signals for the present motion of the shaft."""
        counter = StepCounter(self.shaft.motion, CountScale(Fraction(1)), 0)
        for name, code in DETECTOR.items():
            level = code[counter.level(self.kernel.seen)]
            self.rule.put(
                self.drivers[name], level if self.rule.edge_driven else Repeated(EncoderChannel(counter, code))
            )


class Rotor(Part):
    """A rotor between two windings: phases 1 and 2 are the ends of one, 3 and 4 of the other (CY525 s.10).

        winding a   -1 +1 +1 -1         the end with the low phase pin is energised
        winding b   -1 -1 +1 +1
        field        0  1  2  3         quarters of an electrical turn, clockwise

    The rotor follows the field by one quarter at a time.  Unless both windings carry current, its position
    is unchanged.  If the field jumps to the opposite side, the position is also unchanged, and a finding is
    reported: a real rotor could turn either way.
    """

    _for_users = ("position", "field")
    wiring = MappingProxyType({f"phase{n}": f"phase{n}" for n in (1, 2, 3, 4)})
    rewired = start_rule

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        for n in (1, 2, 3, 4):
            self.add_pin(f"phase{n}", "in", f"phase {n}, low energises", pull=1, active=0)
        self._position = 0
        self._followed: int | None = None
        self._read_ps: int | None = None  # the instant up to which the phases have been read; None: not yet read
        self._levels: list[Level] = []  # levels of the phases at that instant
        self._strides = ScanWindow()
        self.rule = Follower(self, tuple(self.pins), schedule=self._promise, react=self._look, cut=self._cut)

    @property
    def position(self) -> int:
        """Steps clockwise since the start; at position 0 the rotor is at rest in field 0."""
        self.be_caught_up()
        return self._position

    def shows(self) -> dict[str, Any]:
        """Return the position, in steps."""
        return {"angle": float(self.position), "per_turn": 200}

    @property
    def field(self) -> int | None:
        """The direction of the field, 0 to 3; None unless both windings carry current."""
        return FIELDS[sum(self.high(name) << n for n, name in enumerate(self.pins))]

    def catch_up(self) -> None:
        """Turn the rotor as the phase pins require, up to the last committed instant."""
        if self._read_ps is not None:
            if self.rule.scheduling:
                self._look()
            else:
                self._read(self._read_ps, self.kernel.seen)

    # ------------------------------------------------------------------------------------------------------- changes
    def _cut(self, ps: int) -> None:
        """Process the inputs up to an instant (ps), because their levels up to then cannot be queried later."""
        if self._read_ps is not None:
            self._read(self._read_ps, ps)
            self._levels = [lookahead.level(ps) for lookahead in self.rule.lookaheads.values()]

    def _promise(self) -> None:
        """Follow the field up to this instant; a rotor has no outputs to promise."""
        if self._read_ps is not None:
            self._look()
        self._read_ps = self.kernel.now

    def _look(self) -> None:
        """Follow the field if the level of a phase pin has changed."""
        if [self.pins[name].net.level for name in self.pins] != self._levels:
            self._follow(self.field, self.kernel.now)

    def _read(self, since: int, ps: int) -> None:
        """Follow the phases from the instant `since` to the instant `ps`, one stretch of time after another."""
        while since < ps:
            stop = self._strides.stop(since, ps)
            edges = [lookahead.edges(since, stop) for lookahead in self.rule.lookaheads.values()]
            if count := sum(len(times) for times, _ in edges):
                self._turn(since, edges)
            self._strides.adapt(count)
            self._read_ps = since = stop
            if not count:
                following = earliest([lookahead.after(stop) for lookahead in self.rule.lookaheads.values()])
                self._read_ps = since = max(stop, ps if following is None else min(ps, following - 1))
                self._strides.skipped(since - stop)

    def _turn(self, since: int, edges: list[tuple[Any, Any]]) -> None:
        """Turn the rotor according to the edges of each phase pin after the instant `since` (ps)."""
        import numpy as np

        times = np.unique(np.concatenate([np.asarray(own, np.int64) for own, _ in edges]))
        number = np.zeros(len(times), np.int64)
        for n, ((own, shown), lookahead) in enumerate(zip(edges, self.rule.lookaheads.values(), strict=True)):
            high = np.array([lookahead.level(since) != 0, *(level != 0 for level in shown)])
            number |= high[np.searchsorted(np.asarray(own, np.int64), times, side="right")].astype(np.int64) << n
        fields = np.array([-1 if field is None else field for field in FIELDS], np.int64)[number]
        times, fields = times[fields >= 0], fields[fields >= 0]
        if self._followed is not None and self._followed == self._position % 4:
            turns = np.diff(fields, prepend=self._followed) % 4
            if not (turns == 2).any():
                self._position += int(np.count_nonzero(turns == 1)) - int(np.count_nonzero(turns == 3))
                self._followed = int(fields[-1]) if len(fields) else self._followed
                return
        for time, field in zip(times.tolist(), fields.tolist(), strict=True):
            self._follow(field, time)

    def _follow(self, field: int | None, ps: int) -> None:
        if field is None or field == self._followed:
            return
        self._followed = field
        turn = (field - self._position) % 4
        if turn == 2:
            text = "the field jumped by 180 electrical degrees: a real rotor could turn either way"
            self.finding("rotor-lost", text, ps)
        else:
            self._position += {0: 0, 1: 1, 3: -1}[turn]
