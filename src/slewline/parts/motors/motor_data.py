"""The data of a motor, a driver and a load: the figures of their data sheets, in SI units.

MotorData   windings, holding torque, inertia     a row of motors.py, or user-defined
DriverData  supply, current, kind of switching    a row of drivers.py, or user-defined
LoadData    load on the shaft                     loads.py
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt
from typing import Literal

Windings = Literal["bipolar", "unipolar", "reluctance"]
DriverKind = Literal["current", "averaged", "chopper", "voltage", "bilevel"]
Decay = Literal["slow", "fast", "mixed", "auto"]
IRON_S = 2.66e-3  # default drag by iron loss, N m s, per N m of holding torque


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorData:
    """A stepper motor, as its data sheet describes it.

    `torque` is the holding torque at `current` when `rated` phases are on (two, on most makers' sheets).
    `iron` is the drag due to iron loss, in N m s; None: 2.66e-3 s times the holding torque, since no data sheet lists
    it.

    Hybrid and PM motors have `teeth` pole pairs, with four full steps each; "unipolar" motors have two halves per
    winding, and `resistance` and `inductance` are those of one half.  "reluctance" motors have `phases` windings, and
    `phases` full steps per tooth; `inductance` is the mean, and `swing` the amplitude of its variation.
    """

    name: str
    windings: Windings = "bipolar"
    teeth: int = 50
    phases: int = 4  # number of phases of a reluctance motor
    current: float  # A per phase
    resistance: float  # ohms per phase
    inductance: float  # H per phase
    swing: float = 0.0  # H, of a reluctance motor
    torque: float = 0.0  # N m
    rated: Literal["two", "one"] = "two"
    detent: float = 0.0  # N m
    inertia: float  # kg m2
    iron: float | None = None  # N m s
    viscous: float = 0.0  # N m s, bearings
    friction: float = 0.0  # N m, friction of bearings and seals
    source: str = ""

    @property
    def constant(self) -> float:
        """Torque constant of one phase, N m/A, which is also its EMF constant, V s/rad."""
        return self.torque / self.current / (sqrt(2) if self.rated == "two" else 1.0)

    @property
    def full_steps(self) -> int:
        """Full steps per revolution."""
        return self.teeth * (self.phases if self.windings == "reluctance" else 4)

    @property
    def step(self) -> float:
        """The angle of a full step, rad."""
        return 2 * pi / self.full_steps

    def holding_torque(self, current: float) -> float:
        """Return the maximum torque with two phases on, N m, for a current per phase, A."""
        if self.windings == "reluctance":
            return self.teeth * self.swing * current**2 / sqrt(2)
        return sqrt(2) * self.constant * current

    @property
    def drag(self) -> float:
        """Total viscous drag, N m s."""
        return self.viscous + (IRON_S * self.torque if self.iron is None else self.iron)


@dataclass(frozen=True, slots=True, kw_only=True)
class DriverData:
    """A driver and its settings.

    "current"   the current follows its set point with a first-order lag `lag` (0: no lag), for any supply
    "averaged"  a current source limited by the supply: the mean of a chopper, without its ripple and damping
    "chopper"   regulates the peak current, at a fixed frequency or, with `off_time`, with a fixed off-time;
                while off, the current decays in slow mode (shorted), fast (against the supply), mixed (fast
                for `fast_part` of a period or off-time, then slow), or auto (slow, but mixed after a step at
                which the current is to decrease)
    "voltage"   the supply through `series` ohms: L/R, and L/nR
    "bilevel"   `high` volts for `high_time` after each change of a phase, then the supply

    `current` is the current per phase with two phases on; with `boost`, a phase that is on alone gets
    sqrt(2) times as much, for half steps with an even torque.  `rest`, `slew` and `ramp` are factors by
    which this current is multiplied at rest, at constant speed and on ramps, as signalled by MOV and RAMP.
    A half winding that is switched off drives its current into `clamp` volts (0.7 for a diode, or the
    voltage of a Zener diode).
    """

    name: str = ""
    kind: DriverKind
    supply: float = 0.0  # V
    current: float = 0.0  # A
    series: float = 0.0  # ohm
    lag: float = 0.0  # s
    high: float = 0.0  # V
    high_time: float = 0.0  # s
    frequency: float = 20e3  # Hz
    off_time: float = 0.0  # s, off-time of a chopper without a clock; 0: it has a clock
    decay: Decay = "slow"
    fast_part: float = 0.3
    least_on: float = 0.0  # s, blanking: minimum on-time of a phase
    diode: float = 0.0  # V, dropped during the off-time of a chopper
    clamp: float = 0.7  # V
    boost: bool = False
    rest: float = 1.0
    slew: float = 1.0
    ramp: float = 1.0
    source: str = ""

    @property
    def period(self) -> float:
        """The period of a chopper's clock, or its off-time, s; 0 if the driver has neither."""
        return self.off_time or (1 / self.frequency if self.frequency else 0.0)

    def phase_current(self, motor: MotorData) -> float:
        """Return the phase current of a motor at rest with two phases on, A: as set, or as limited by resistance."""
        if self.kind in ("voltage", "bilevel"):
            return self.supply / (motor.resistance + self.series)
        return self.current


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadData:
    """The load of a motor, in addition to its rotor.

    `friction` is Coulomb friction, and `stiction` the torque that a shaft at rest resists (None: equal to
    the friction).  `torque` acts backwards, against forward motion, like a weight being lifted.  If
    `stiffness` is not 0, a coupling connects the inertia, and friction and torque act beyond that coupling.
    A damper is an inertia of `damper_inertia`, dragged along by `damper_drag`.
    """

    inertia: float = 0.0  # kg m2
    viscous: float = 0.0  # N m s
    friction: float = 0.0  # N m
    stiction: float | None = None  # N m
    torque: float = 0.0  # N m
    stiffness: float = 0.0  # N m/rad; 0: rigid
    coupling_drag: float = 0.0  # N m s
    damper_inertia: float = 0.0  # kg m2
    damper_drag: float = 0.0  # N m s
    low: float | None = None  # rad, hard stop
    high: float | None = None  # rad, hard stop

    @property
    def stops(self) -> bool:
        """True if there is a hard stop."""
        return self.low is not None or self.high is not None
