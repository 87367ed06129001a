"""A stepper motor with its driver and its load, which loses steps where a real motor does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from ...core.datasheet.option import Option
from ...core.datasheet.units import quantity
from ...core.time.inputs import from_outside
from ...core.time.timebase import Time, picoseconds
from ...errors import UsageError
from ..base.follower import Follower, start_rule
from ..base.part import AXIS, Part
from ..motors.drivers import driver_complaint
from ..motors.integration import Point
from ..motors.law import MotorLaw
from ..motors.laws import read_system
from ..motors.loads import load_complaint
from ..motors.motors import motor_complaint
from ..shafts.motor import EDGE, EDGES
from ..shafts.shaft import Blockable
from ..shafts.shaft_counter import CountScale
from ..shafts.shown import SwitchZone
from .feed import Feed, Pins, Reading, phases_asked, steps_asked
from .linkage import Linkage
from .losses import Losses
from .motor_run import Run
from .rest import RestCondition
from .stepper_curves import current_of, curve
from .turning import LinkageMotion, MotorShaft, pushed

if TYPE_CHECKING:
    from ...core.datasheet.table import Pin
    from ...core.motion.quantity import Quantity
    from ...core.time.kernel import Kernel

WINDINGS = ("i1", "i2", "i3", "i4")
PHASES = ("phase1", "phase2", "phase3", "phase4")
MOST_PUSHED = 1e6  # steps
STALLS = (True, False, True)  # state by the number of bounds (at -2 and 2 steps from the command) below the position


class Stepper(Blockable, Part):
    """A stepper motor with driver and load: it follows its pulses as far as its torque allows.

    Its shaft turns according to the equations of motion (`motors/law.py`), and an encoder, switches, a gear
    or a carriage can be mounted on it as on any other shaft.  `stall` is low while the rotor is within two
    steps of its command; a rotor that is further away does not return by itself.

    Nothing is integrated before it is queried, and a query changes nothing: the state at any instant is
    computed by one integrator step from the preceding point of a grid, which restarts at each input edge.

    Args:
        axis: the axis of the neighbour, the part that the motor is attached to.
        motor, driver, load: by name, as text, or as a table of figures; see
            [Motors](../reference/motors.md).
        inputs: "step": PULSE and DIRECTION; "phases": the phases of a chip or of a driver module.
        steps: the step mode: "full", "wave", "half" or "micro 8".
        edge: the step edge of PULSE, "fall" or "rise"; by default the step edge of the neighbour's pin.
        active: the level of a phase that is on; None: the active level of the neighbour's pin, or 1 if it
            has none.
        step: the step of the integrator; None: 20 µs, or 1 µs with a chopper.
        lag: the delay of each edge of `stall` after the instant at which the rotor comes within two steps
            of its command, or moves further away than that.
        engine: the engine of the integrator: "python"; "numba", which compiles before simulated time passes;
            None: Python at first, then Numba (if it is installed) as soon as Numba saves time.  The results
            are bit-identical.
    """

    _for_users = (
        "place",
        "lag",
        "speed",
        "lost",
        "command",
        "currents",
        "rests",
        "load",
        "block",
        "free",
        "push",
    )
    verbs = ("block", "free", "push")
    optional = frozenset({"mov", "ramp"})
    options = (
        AXIS,
        Option(
            "motor",
            "object",
            "QSH4218-51-10-049",
            "name of a motor, or its figures as text or as a table",
            check=motor_complaint,
        ),
        Option("driver", "object", "24 V, 1 A", "figures as text or as a table", check=driver_complaint),
        Option("load", "object", MappingProxyType({}), "figures as text or as a table", check=load_complaint),
        Option("inputs", "choice", "step", "kind of inputs: step and direction, or phases", choices=("step", "phases")),
        Option("steps", "text", "full", "size of a step: full, wave, half or micro 8", like="half"),
        EDGE,
        Option("active", "choice", None, "level at which a phase is on", choices=(0, 1), none=True),
        Option(
            "step",
            "time",
            None,
            "time step of the integrator; None: 20 µs, or 1 µs with a chopper",
            low=10**5,
            high=2 * 10**8,
            none=True,
        ),
        Option("lag", "time", "1 us", "delay from the rotor to the edge of `stall`", low=1),
        Option(
            "engine",
            "choice",
            None,
            "python, or numba (compiled immediately); None: python, and numba for long runs",
            choices=("python", "numba"),
            none=True,
        ),
    )
    shaft: MotorShaft
    rewired = start_rule

    def __init__(
        self,
        kernel: Kernel,
        name: str,
        *,
        axis: int = 1,
        motor: Any = "QSH4218-51-10-049",
        driver: Any = "24 V, 1 A",
        load: Any = MappingProxyType({}),
        inputs: str = "step",
        steps: str = "full",
        edge: str | None = None,
        active: int | None = None,
        step: Time | None = None,
        lag: Time = "1 us",
        engine: str | None = None,
    ) -> None:
        super().__init__(kernel, name)
        self.axis = axis
        system = read_system(motor, driver, load, f"{name}: ")
        self._phased = inputs == "phases"
        try:
            law = MotorLaw(
                *system, "half" if self._phased else steps, 0 if step is None else picoseconds(step),
                phased=self._phased,
            )  # fmt: skip
        except UsageError as error:
            raise UsageError(f"{name}: {error}") from None
        self._edge, self._active = edge, active
        self._clockwise = 1  # the level of DIRECTION that counts up
        self._add_pins(law)
        self._stalls_ps = picoseconds(lag)
        self._feed = Feed(steps_asked(law, Pins({})))
        self._run = Run(law, self._feed, Point(kernel.now, law.at_rest(), 0, 0), engine)
        if engine == "numba":
            law.compile()
        self.shaft = MotorShaft(kernel, self._run, self._alter)
        self._losses = Losses(self._run)
        self._begun_ps: int | None = None
        self.rule = Follower(self, self._read, schedule=self._promise, react=self._react, cut=self.shaft.cut)
        self.shaft.source = self.rule

    def _add_pins(self, law: MotorLaw) -> None:
        if self._phased:
            names = PHASES[: law.period]
            for n, name in enumerate(names):
                self.add_pin(name, "in", f"phase {n + 1}", pull=0 if self._active in (None, 1) else 1)
            self.wiring: Mapping[str, str] = MappingProxyType({name: name for name in names})
        else:
            names = ("pulse", "direction")
            self.add_pin("pulse", "in", f"step at each {self._edge or 'fall'}", pull=1)
            self.add_pin("direction", "in", "high: clockwise", pull=1)
            self.wiring = MappingProxyType({"pulse": "step", "direction": "direction"})
        self.add_pin("enable", "in", "low: no current", pull=1)
        self._read = (*names, "enable")
        if (law.driver.rest, law.driver.ramp) != (law.driver.slew, law.driver.slew):
            self.add_pin("mov", "in", "high: in motion", pull=0, active=1)
            self.add_pin("ramp", "in", "high: on a ramp", pull=0, active=1)
            self._read = (*self._read, "mov", "ramp")
            self.wiring = MappingProxyType({**self.wiring, "mov": "moving", "ramp": "ramping"})
        self.add_pin("stall", "out", "high: two steps or more from its command", initial=0)

    def attached(self, own: str, row: Pin) -> None:
        """Adopt the properties of the neighbour's pin to which a pin of the motor is wired.

        They are the polarity of DIRECTION, the step edge of PULSE, and the active level of the phases.  A step
        edge or an active level that the user has set is kept.
        """
        if own == "pulse" and row.sense is not None and self._edge is None:
            self._edge = {0: "fall", 1: "rise"}[row.sense]
        if own == "direction" and row.sense is not None:
            self._clockwise = row.sense
        if own in PHASES and row.sense is not None and self._active is None:
            self._active = row.sense

    # ----------------------------------------------------------------------------------------------- queries by a user
    @property
    def _law(self) -> MotorLaw:
        """Present law of motor, driver and load."""
        return self._run.law

    @property
    def place(self) -> float:
        """Position of the shaft, in full steps clockwise from the start."""
        return self.shaft.rotor.place(self.kernel.seen)

    @property
    def command(self) -> float:
        """Commanded position, in full steps."""
        return self._run.at_or_before(self.kernel.seen).command / self._law.micro

    @property
    def lag(self) -> float:
        """Lag of the rotor relative to its command, in full steps; negative if the rotor leads."""
        return self.command - self.place

    @property
    def speed(self) -> float:
        """Speed of the rotor, full steps/s."""
        return self._state["omega"] / self._law.motor.step

    @property
    def currents(self) -> tuple[float, ...]:
        """Currents of the windings, A."""
        state = self._state
        return tuple(value for name, value in state.items() if name in WINDINGS)

    @property
    def lost(self) -> int:
        """Number of full steps lost, a multiple of four; negative if the rotor has made too many steps."""
        self.be_caught_up()
        return self._losses.lost

    @property
    def _state(self) -> dict[str, float]:
        seen = self.kernel.seen
        return dict(zip(self._run.stretch_at(seen).law.names, self._run.state(seen), strict=True))

    @property
    def rests(self) -> RestCondition:
        """The condition that the motor has come to rest, for `bench.run_until`."""
        return RestCondition(self.name, self.kernel, self._run)

    def shows(self) -> dict[str, Any]:
        """Return position and lag in full steps, and the number of steps per revolution."""
        return {"angle": self.place, "per_turn": self.shaft.per_turn, "lag": self.lag}

    def catch_up(self) -> None:
        """Find and report the steps that were lost up to the last committed instant."""
        for ps, code, text in self._losses.look(self.kernel.seen):
            self.finding(code, text, ps)

    def quantities(self) -> tuple[Quantity, ...]:
        """Return the quantities of the motor over time: position, lag, speed, and currents."""
        of = partial(curve, self.kernel, self._run)
        windings = [name for name in self._law.names if name in WINDINGS]
        return (
            self.shaft.quantity("position"),
            of("lag", "steps", lambda law, points: points[2] / law.micro - points[1][:, 0] / law.motor.step),
            of("speed", "steps/s", lambda law, points: points[1][:, 1] / law.motor.step),
            *(of(f"current {n}", "A", partial(current_of, name)) for n, name in enumerate(windings, 1)),
        )

    def forget(self, before: int) -> None:
        """Drop the past before an instant (ps), after finding the steps lost until then."""
        if self._run.reached >= before:
            self.be_caught_up()
        self.shaft.forget(before)

    # -------------------------------------------------------------------------------------------------- turning by hand
    @from_outside
    def load(self, torque: float | str) -> None:
        """Change the load torque from now on: N m, or text such as "30 mNm".

        A positive torque opposes rotation in the direction in which the position increases.
        """
        newton_metres = quantity(torque, "N m", f"{self.name}: torque")
        self.input("load", torque)
        self._alter(torque=newton_metres)
        self.kernel.settle()

    @from_outside
    def push(self, steps: float) -> None:
        """Turn the shaft immediately by some full steps, backwards if negative."""
        if isinstance(steps, bool) or not isinstance(steps, int | float) or not abs(steps) < MOST_PUSHED:
            raise UsageError(f"{self.name}: push by {steps!r} steps; expected a number up to +/-{MOST_PUSHED:g}")
        self.input("push", steps)
        self._alter(push=float(steps))
        self.kernel.settle()

    def _alter(
        self,
        *,
        blocked: bool | None = None,
        torque: float | None = None,
        push: float = 0.0,
        stops: tuple[Fraction | None, Fraction | None] | None = None,
    ) -> None:
        """Continue from the last committed instant with another law, or at another position."""
        law, seen = self._law, self.kernel.seen
        if blocked is not None:
            law = replace(law, blocked=blocked)
        if torque is not None:
            law = replace(law, load=replace(law.load, torque=torque))
        if stops is not None:
            low, high = (None if stop is None else float(stop) * law.motor.step for stop in stops)
            law = replace(law, load=replace(law.load, low=low, high=high))
        states = pushed(law, self._state, push * law.motor.step) if push else {}
        if law.blocked:
            states["omega"] = 0.0
        self._run.alter(seen, law, **states)
        self.shaft.turned()
        if self._begun_ps is not None:
            self._show_stall()

    # ------------------------------------------------------------------------------------------------------- its inputs
    def _begin(self) -> None:
        """Begin at rest at the position that the driver now commands, once the part is wired."""
        import numpy as np

        columns = {}
        for n, name in enumerate(self._read):
            active = {"pulse": EDGES[self._edge or "fall"], "direction": self._clockwise}.get(name, 1)
            if name in PHASES:
                active = 1 if self._active is None else self._active
            columns[name] = n, bool(active)
        pins, law = Pins(columns), self._law
        here = Reading(np.array([self.kernel.now]), np.array([[self.high(name) for name in self._read]] * 2))
        if self._phased:
            names = [name for name in self._read if name in PHASES]
            _, (code,) = phases_asked(law, pins, names, law.fields)(here, 0)
            law = replace(law, origin=law.fields[code % len(law.fields)] or 0)
            fields = [None if field is None else (field - law.origin) % law.cycle for field in law.fields]
            self._feed.asked = phases_asked(law, pins, names, fields)
        else:
            self._feed.asked = steps_asked(law, pins)
        code = int(self._feed.asked(here, 0)[1][0])
        pushes = [stretch.first.state[0] for stretch in self._run.stretches if stretch.changed is not None]
        by = pushes[-1] if pushes else 0.0  # the shaft has already been turned by hand
        first = Point(self.kernel.now, law.at_rest(code=code), 0, code)
        self._run.begin(law, first)
        if by:
            self._run.alter(first.t, law, **pushed(law, dict(zip(law.names, first.state, strict=True)), by))
        self._losses = Losses(self._run)
        self._begun_ps = self.kernel.now

    def _promise(self) -> None:
        """Follow the inputs from now on."""
        if self._begun_ps in (None, self.kernel.now):  # in its first instant the inputs may still change
            self._begin()
        self._feed.show(self.kernel.now, [self.rule.shown(name) for name in self._read])
        self._run.follow(self.kernel.now - 1)
        self.shaft.turned()
        self._show_stall()

    def _react(self) -> None:
        """Process the input levels edge by edge, because the part is in a loop of parts."""
        self._promise()

    def _show_stall(self) -> None:
        """Renew the promise of `stall`, unless there is a promise already and nothing watches the wire."""
        driver = self.drivers["stall"]
        if driver.watched or driver.promise is None:
            driver.play(self._stall())

    def _stall(self) -> SwitchZone:
        off = Fraction(self._law.period, 2)
        counter = LinkageMotion(self._run, Linkage(is_lagging=True)).counter(
            CountScale(bounds=(-off, off)), self._stalls_ps
        )
        return SwitchZone(counter, self.kernel.seen, False, STALLS, (0, 1))
