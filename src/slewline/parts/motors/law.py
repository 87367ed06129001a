"""A motor with its driver and its load: the law by which a shaft follows its commands, or loses steps.

A command is a position at which the driver holds the rotor.  Commands are numbered up and down from 0, with `micro`
commands per full step.  Two phases are on at command 0, except in a wave drive.  `table` holds the set points of the
driver: for each current level, one row for every command of an electrical turn, which has `cycle` commands.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import atan2, cos, pi, sin, sqrt
from typing import TYPE_CHECKING, Any

from ...errors import UsageError
from . import equations as eq
from .integration import Integration, MotorTrace, Point
from .integrator import Model
from .motor_data import DriverData, LoadData, MotorData

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

BARE = LoadData()
LEVELS = ("slew", "ramp", "rest", "off")  # current levels: the rows of a table come in this order
STEP_PS = 20_000_000
CHOPPED_PS = 1_000_000  # the grid step for a chopper
SLOW = 1e-5  # rad/s, below which a rotor may be at rest
STILL = 1e-7  # A, the most by which a current at rest changes in a step
SETTLED = 1e-7  # rad/s, the most by which the speed of a rotor at rest changes in a step
NEAR = 0.1  # full steps
LAGS = 0.7  # full steps, the lag of a rotor that turns evenly
LEFT = 0.02  # fraction of a phase's torque that acts on a rotor at rest with a chopper
_STEPS = re.compile(r"full|wave|half|micro ?([1-9]\d{0,3})")


def check_steps(steps: str) -> str:
    """Return a step mode after checking it: "full", "wave", "half", or "micro" and a number, such as "micro 8".

    Raises:
        UsageError: the text is not a step mode.
    """
    if not isinstance(steps, str) or not _STEPS.fullmatch(steps):
        raise UsageError(f"steps {steps!r}; allowed 'full', 'wave', 'half', or 'micro' and a number ('micro 8')")
    return steps


def usual_step(driver: DriverData) -> int:
    """Return the default grid step for a driver, ps."""
    return CHOPPED_PS if driver.kind == "chopper" else STEP_PS


@dataclass(frozen=True)
class MotorLaw:
    """The equations of motion of a stepper motor with driver and load.

    Args:
        motor, driver, load: the data of each.
        steps: the step mode: "full" (two phases on), "wave" (one phase on), "half", or "micro 8" (8 per full step).
        step_ps: the grid step, ps; 0: 20 µs, or 1 µs for a switching chopper.  The grid restarts at each edge.
        blocked: whether the rotor is blocked.
        phased: whether the inputs are phases, not steps; `steps` is then "half", and the table has a row per
            combination of phases, numbered by a sum: 1 if phase 1 is on, 2 if phase 2 is on, 4 for phase 3 ...
        origin: if `phased`, the position of command 0, in half steps from the position that `fields` counts as 0.
        restless: whether to integrate also at rest, to include the chopper ripple.

    Raises:
        UsageError: motor, driver, load and step mode do not match.
    """

    motor: MotorData
    driver: DriverData
    load: LoadData = BARE
    steps: str = "full"
    step_ps: int = 0
    blocked: bool = False
    phased: bool = False
    origin: int = 0
    restless: bool = False

    def __post_init__(self) -> None:
        check_steps(self.steps)
        if not self.step_ps:
            object.__setattr__(self, "step_ps", usual_step(self.driver))
        if self.motor.windings != "bipolar" and self.driver.kind != "voltage":
            raise UsageError(
                f"{self.motor.name}: {self.motor.windings} windings with a driver of kind {self.driver.kind!r}; "
                "allowed: kind 'voltage' (L/R, L/nR)"
            )
        if self.motor.windings == "reluctance" and self.motor.phases not in (3, 4):
            raise UsageError(f"{self.motor.name}: {self.motor.phases} phases of a reluctance motor; allowed 3, 4")
        if self.load.stiffness > 0 and self.load.inertia <= 0:
            raise UsageError(f"load: inertia {self.load.inertia} on a coupling; allowed more than 0")
        if self.motor.windings == "reluctance" and self.steps not in ("full", "wave", "half"):
            raise UsageError(f"{self.motor.name} (reluctance): steps {self.steps!r}; allowed 'full', 'wave', 'half'")

    # ------------------------------------------------------------------------------------------------------- components
    @cached_property
    def micro(self) -> int:
        """Commands per full step."""
        found = _STEPS.fullmatch(self.steps)
        return int(found[1]) if found and found[1] else 2 if self.steps == "half" else 1

    @property
    def step(self) -> float:
        """The angle of a full step, rad."""
        return self.motor.step

    @property
    def period(self) -> int:
        """Full steps per electrical turn; a rotor that loses steps loses this number, or a multiple of it."""
        return self.motor.phases if self.motor.windings == "reluctance" else 4

    @property
    def lost_at(self) -> float:
        """Lag or lead of the rotor beyond which steps are lost: 3.9 full steps, or 2.9 with three phases."""
        return self.period - NEAR

    @property
    def cycle(self) -> int:
        """Commands per electrical turn."""
        return self.period * self.micro

    @cached_property
    def model(self) -> Model:
        """The equations of motor, driver and load."""
        return model(
            self.motor.windings, self.motor.phases, self.driver.kind, self.driver.decay, self.driver.least_on > 0,
            self.driver.off_time > 0, self.driver.lag > 0, self.motor.detent > 0, self._rubs, self.load.stiffness > 0,
            self.load.damper_inertia > 0, self.load.stops, self.blocked,
        )  # fmt: skip

    @property
    def _rubs(self) -> bool:
        return self.motor.friction + self.load.friction > 0 or bool(self.load.stiction) or self.load.stops

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the state variables."""
        return self.model.whole

    @property
    def resistance(self) -> float:
        """Resistance of a phase, including series resistors, ohms."""
        return self.motor.resistance + self.driver.series

    @cached_property
    def parameters(self) -> tuple[Any, ...]:
        """Values of the parameters that `model.parameters` names, in the same order."""
        motor, driver, load = self.motor, self.driver, self.load
        h = self.step_ps * 1e-12
        coupled = load.stiffness > 0
        inertia = motor.inertia + (0.0 if coupled else load.inertia)
        friction = load.friction + motor.friction  # beyond a coupling, if there is one
        stiction = max(load.friction, load.stiction or 0.0) + motor.friction
        chopped = driver.kind == "chopper"
        settled = LEFT * motor.constant * driver.current / inertia if chopped else SETTLED / h
        values = {
            "K": motor.constant, "R": self.resistance, "INV_L": 1 / motor.inductance, "L": motor.inductance,
            "K_L": motor.constant / motor.inductance, "R_L": self.resistance / motor.inductance,
            "SWING": motor.swing, "TEETH": float(motor.teeth), "COS3": -0.5, "SIN3": sqrt(0.75),
            "DETENT8": 8 * motor.detent, "INV_LAG": 1 / driver.lag if driver.lag else 0.0,
            "VS": driver.supply, "HIGH": driver.high, "HIGH_TIME": driver.high_time, "CLAMP": driver.clamp,
            "DIODE": driver.diode, "LEAST_ON": driver.least_on, "LH": motor.inductance / (2 * h),
            "FAST_TIME": driver.fast_part * driver.period, "OFF_TIME": driver.off_time,
            "PERIOD_PS": max(round(1e12 * driver.period), 1),
            "DRAG": motor.drag + (0.0 if coupled else load.viscous), "PULL": load.torque, "INV_J": 1 / inertia,
            "FRICTION": friction, "STICTION": stiction,
            "STIFFNESS": load.stiffness, "COUPLING_DRAG": load.coupling_drag, "DRAG2": load.viscous,
            "INV_J2": 1 / load.inertia if load.inertia else 0.0,
            "DAMPER_DRAG": load.damper_drag, "INV_J3": 1 / load.damper_inertia if load.damper_inertia else 0.0,
            "STOP_LOW": -1e300 if load.low is None else load.low,
            "STOP_HIGH": 1e300 if load.high is None else load.high,
            "TURNS": motor.teeth / (2 * pi), "ZERO": self._zero, "H": h, "HALF_H": h / 2, "STEP_PS": self.step_ps,
            "SLOW": -1.0 if self.restless else 100 * SLOW if chopped else SLOW, "STILL": STILL, "SETTLED": settled,
            "STEPS_COMMAND": 1 / self.micro, "STEPS_RAD": 1 / motor.step,
        }  # fmt: skip
        # Always the same types: Numba compiles once.
        return tuple(values[name] if name.endswith("_PS") else float(values[name]) for name in self.model.parameters)

    @property
    def _zero(self) -> float:
        """Electrical angle at command 0, in turns."""
        return self._first + self.origin / self.cycle

    @property
    def _first(self) -> float:
        if self.motor.windings == "reluctance":
            return 0.0 if self.steps == "wave" else 0.5 / self.motor.phases
        return 0.0 if self.steps == "wave" else 0.125

    @cached_property
    def table(self) -> tuple[tuple[float, ...], ...]:
        """Set points (A, V, or 1 for on): for each of `LEVELS`, a row per command or combination of phases."""
        return table(self.motor, self.driver, self.steps, self.phased, self.origin)

    def asked(self) -> tuple[tuple[float, ...], ...]:
        """Return the rows of `table`, computed from the data of motor and driver."""
        factors = (self.driver.slew, self.driver.ramp, self.driver.rest, 0.0)  # as LEVELS
        if self.phased:
            return tuple(self._phases(bits, factor) for factor in factors for bits in range(1 << self.period))
        angles = [2 * pi * (self._zero + n / self.cycle) for n in range(self.cycle)]
        return tuple(self._row(angle, factor) for factor in factors for angle in angles)

    @cached_property
    def rows(self) -> NDArray[np.float64]:
        """`table` as an array: (rows, windings) float64."""
        import numpy as np

        return np.array(self.table, np.float64)

    def _row(self, angle: float, factor: float) -> tuple[float, ...]:
        """Return the set points at an electrical angle (rad), with the current multiplied by a factor."""
        if self.motor.windings == "reluctance":
            return tuple(float(factor > 0 and cos(angle - 2 * pi * n / self.period) > 0.1) for n in range(self.period))
        field = cos(angle), sin(angle)
        if self.steps.startswith("micro"):
            signs = field if self._volts else tuple(part if abs(part) > 1e-9 else 0.0 for part in field)
            factor *= 1.0 if self._volts else sqrt(2)
        else:
            signs = tuple(0.0 if abs(part) < 0.1 else 1.0 if part > 0 else -1.0 for part in field)
            factor *= sqrt(2) if 0.0 in signs and self.driver.boost else 1.0
        return self.asked_for(signs, factor)

    def _phases(self, bits: int, factor: float) -> tuple[float, ...]:
        """Return the set points for the phases that are on (`bits`), with the current multiplied by a factor."""
        on = [float(bits >> n & 1) for n in range(self.period)]
        if self.motor.windings in ("reluctance", "unipolar"):
            return tuple(part * (factor > 0) for part in on)
        signs = on[0] - on[1], on[2] - on[3]
        return self.asked_for(signs, factor * (sqrt(2) if 0.0 in signs and self.driver.boost else 1.0))

    @cached_property
    def fields(self) -> tuple[int | None, ...]:
        """The command, 0 to `cycle` - 1, for each combination of phases; None if there is no field.

        The index is the combination: bit 0 is set if phase 1 is on, bit 1 if phase 2 is on ...  With two windings,
        phases 1 and 2 are the ends of one, 3 and 4 those of the other; at command 0, phases 1 and 3 are on.
        """
        found: list[int | None] = []
        for bits in range(1 << self.period):
            on = [bits >> n & 1 for n in range(self.period)]
            if self.motor.windings == "reluctance":
                angles = [2 * pi * n / self.period for n in range(self.period)]
                x, y = (sum(turn(a) for a, yes in zip(angles, on, strict=True) if yes) for turn in (cos, sin))
            else:
                x, y = float(on[0] - on[1]), float(on[2] - on[3])
            here = atan2(y, x) / (2 * pi) - self._first
            found.append(None if x * x + y * y < 0.1 else round(here * self.cycle) % self.cycle)
        return tuple(found)

    @property
    def _volts(self) -> bool:
        return self.driver.kind in ("voltage", "bilevel")

    def asked_for(self, signs: Sequence[float], factor: float) -> tuple[float, ...]:
        """Return the set points for a field (-1 to 1 per winding), the current multiplied by `factor` (0: off)."""
        on = factor > 0
        if self.motor.windings == "unipolar":
            one, two = signs
            return tuple(float(on and part) for part in (one > 0, one < 0, two > 0, two < 0))
        if self.driver.kind == "voltage":
            return tuple(on * self.driver.supply * sign for sign in signs)
        if self.driver.kind == "bilevel":
            return tuple(on * float(sign) for sign in signs)
        return tuple(self.driver.current * factor * sign for sign in signs)

    # ------------------------------------------------------------------------------------------------------ to and from
    def at_rest(self, command: int = 0, level: str = "slew", code: int | None = None) -> tuple[float, ...]:
        """Return the state of the motor at rest at the position of `command`, with settled currents.

        The set points are those of row `code` of `table`; None: the row of `command` at the current level `level`.
        """
        row = self.table[self.code(command, level) if code is None else code]
        place = command / self.micro * self.motor.step
        amperes = dict(zip(("i1", "i2", "i3", "i4"), self._settled(row), strict=False))
        given = {"theta": place, "theta2": place, "asked": -1.0} | amperes
        return tuple(given.get(name, 0.0) for name in self.names)

    def turning(self, rate: float) -> tuple[float, ...]:
        """Return the state, at the start of command 0, of a rotor that turns in step at a rate (full steps/s)."""
        named = dict(zip(self.names, self.at_rest(), strict=True))
        named |= {name: -LAGS * self.step for name in ("theta", "theta2") if name in named}
        named |= {name: rate * self.step for name in ("omega", "omega2", "omega3") if name in named}
        return tuple(named.values())

    def _settled(self, row: Sequence[float]) -> Sequence[float]:
        if self.driver.kind == "voltage":
            volts = self.driver.supply if self.motor.windings != "bipolar" else 1.0
            return [volts * part / self.resistance for part in row]
        if self.driver.kind == "bilevel":
            return [self.driver.supply * part / self.resistance for part in row]
        if self.driver.kind == "current":
            return row
        most = self.driver.supply / self.resistance  # the supply limits it
        return [min(max(part, -most), most) for part in row]

    def code(self, command: int, level: str = "slew") -> int:
        """Return the number of the row of `table` for a command at a current level."""
        return command % self.cycle + self.cycle * LEVELS.index(level)

    def compile(self) -> None:
        """Compile the functions with Numba now, rather than on first use.

        Raises:
            UsageError: Numba is not installed.
        """
        self.integrate((), (), 0, engine="numba")
        self.model.numba.crossing(
            self.parameters, self.rows, 0, self.at_rest(), 0, 0, self.step_ps, 0, 1 / self.step, 0.0, True
        )

    def after(self, t: int, state: Sequence[float], code: int, span: int) -> tuple[float, ...]:
        """Return the state `span` ps after the grid point at `t`, at most until the next grid point."""
        found: tuple[float, ...] = self.model.python.after(self.parameters, self.table, t, tuple(state), code, span)
        return found

    def integrate(
        self,
        times: Sequence[int] | NDArray[np.int64],
        commands: Sequence[int] | NDArray[np.int64],
        stop: int,
        *,
        codes: Sequence[int] | NDArray[np.int64] | None = None,
        start: int = 0,
        state: Sequence[float] | None = None,
        command: int = 0,
        code: int | None = None,
        limit: float = float("inf"),
        engine: str | None = None,
    ) -> MotorTrace:
        """Integrate the equations of motion from `start` to `stop`; return the motion at the grid points.

        Args:
            times: the instants of the commands, (n,) int64 ps, ascending, after `start`.
            commands: the command in force from each instant, (n,) int64, counted from command 0.
            start, stop: the first and the last instant, ps.
            codes: the table row for each command, (n,) int64; by default the row of the command at level "slew".
            state, command, code: the state, command and row at `start`; by default the rotor rests at `command`.
            limit: the distance of the rotor from its command, in full steps, beyond which the integration ends.
            engine: "python" or "numba"; None: Numba for long runs, if it is installed.

        Raises:
            UsageError: the instants are not ascending or not one per command; the engine is unknown or not installed.
        """
        import numpy as np

        edges, asked = np.asarray(times, np.int64), np.asarray(commands, np.int64)
        if len(edges) != len(asked):
            raise UsageError(f"{len(edges)} edges with {len(asked)} commands; pass one command for each edge")
        late = np.flatnonzero(np.diff(edges, prepend=start) <= 0)
        if len(late):
            n = int(late[0])
            before = f"after the previous edge ({edges[n - 1]} ps)" if n else f"after the start ({start} ps)"
            raise UsageError(f"edge {n} at {edges[n]} ps; it must be {before}")
        run = Integration(self, engine)
        return run.trace(
            edges,
            asked,
            np.asarray(asked % self.cycle if codes is None else codes, np.int64),
            stop,
            Point(start, tuple(self.at_rest(command) if state is None else state), command,
                  self.code(command) if code is None else code),
            limit,
        )  # fmt: skip


@lru_cache(maxsize=64)
def table(motor: MotorData, driver: DriverData, steps: str, phased: bool, origin: int) -> tuple[tuple[float, ...], ...]:
    """Return the table of set points for a motor, driver and step mode; it does not depend on the load."""
    return MotorLaw(motor, driver, steps=steps, phased=phased, origin=origin).asked()


@lru_cache(maxsize=64)
def model(
    windings: str, phases: int, kind: str, decay: str, blanked: bool, timed: bool, lags: bool, detent: bool, rubs: bool,
    coupled: bool, damped: bool, stops: bool, blocked: bool,
) -> Model:  # fmt: skip
    """Return the equations of a motor, driver and load with the given properties."""
    count = {"bipolar": 2, "unipolar": 4, "reluctance": phases}[windings]
    winding = {"bipolar": eq.TWO_PHASES, "unipolar": eq.HALF_WINDINGS}.get(windings) or eq.reluctance(phases)
    if kind == "current":
        electric = [eq.LAGGING if lags else eq.GIVEN]
    elif windings != "bipolar":
        electric = [winding, eq.switched(count)]
    elif kind == "chopper":
        electric = [eq.without_rest(winding), eq.chopper(decay, blanked, timed)]
    else:
        electric = [winding, {"voltage": eq.VOLTAGE, "bilevel": eq.BILEVEL, "averaged": eq.AVERAGED}[kind]]
    pieces = [electric[0], *[eq.DETENT] * detent, *[eq.DAMPED] * damped, *electric[1:]]
    pieces.append(eq.COUPLED if coupled else eq.RUBBING if rubs else eq.RIGID)
    pieces += [eq.stopped("2" if coupled else "")] * stops + [eq.BLOCKED] * blocked
    text = "\n".join(
        "\n".join((p.begin, p.torque, p.decide, p.fixed, p.rates, p.settle, p.edge, *p.rest)) for p in pieces
    )
    always = {"TURNS", "ZERO", "STEP_PS", "STEPS_COMMAND", "STEPS_RAD"}
    return Model(tuple(pieces), tuple(sorted(always | set(re.findall(r"\b[A-Z][A-Z0-9_]*\b", text)))), count)
