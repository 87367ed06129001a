"""The equations of motors, drivers and loads, as text; each piece contains only the lines specific to it.

The same equations run in plain Python and compiled by Numba, with bit-identical results.  So they are written once,
as assignments of numbers, from which `integrator.py` makes a function.  Names in capitals are parameters, constant
during a run; the others are:

    theta omega         position and speed of the rotor, rad and rad/s; theta is 0 at rest at command 0
    s c                 sine and cosine of the electrical angle
    i1 i2 (i3 i4)       currents of the windings, A
    r1 r2 (r3 r4)       set points of the driver: amperes, or volts, or 1 for a winding that is on
    v1 v2 (v3 v4)       volts, which the driver sets at a grid point for the whole step after it
    d_...               rates of change, one per state

The motor (two phases): torque and EMF have the same constant K, so that energy is conserved.

    L di1/dt = v1 - R i1 + K omega s            torque = K (i2 c - i1 s) - D sin(4 x)       x: electrical angle
    L di2/dt = v2 - R i2 - K omega c            J domega/dt = torque - DRAG omega - pull

The detent torque has its stable positions where a single phase holds the rotor, so it softens the full-step positions.
"""

from __future__ import annotations

from dataclasses import dataclass, replace


@dataclass(frozen=True, slots=True)
class Equations:
    """A piece of a model, such as a driver: its equations as source text.

    Attributes:
        states: names of the integrated states.
        kept: names of values set at a grid point and kept until the next grid point: latches and timers.
        begin: assignments at a grid point, before all others.
        torque: the torque, as a function of position and currents.
        decide: decisions at a grid point; s, c and torque are those of the grid point.
        fixed: values that follow from the decisions, constant for the whole step.
        rates: the rates of change of the states.
        settle: assignments after each step; a state before the step has a 0 after its name: `omega0`.
        edge: the effect of an edge of the inputs; r1 is the new set point, o1 the previous one.
        rest: the conditions for rest: when all of them are true, nothing changes any more.
    """

    states: tuple[str, ...] = ()
    kept: tuple[str, ...] = ()
    begin: str = ""
    torque: str = ""
    decide: str = ""
    fixed: str = ""
    rates: str = ""
    settle: str = ""
    edge: str = ""
    rest: tuple[str, ...] = ()


def each(text: str, *numbers: int) -> str:
    """Return the lines of a text once for each numbered winding, with # replaced by the winding's number."""
    return "\n".join(text.replace("#", str(n)) for n in numbers)


def still(*states: str) -> tuple[str, ...]:
    """Return the conditions under which the named currents no longer change, one condition per current."""
    return tuple(f"absolute(d_{state}) * H < STILL" for state in states)


# ---------------------------------------------------------------------------------------------------------- windings
TWO_PHASES = Equations(
    states=("i1", "i2"),
    decide="e1 = -K * omega * s\ne2 = K * omega * c",
    fixed=each("push# = v# * INV_L", 1, 2),
    rates="emf = K_L * omega\nd_i1 = push1 - R_L * i1 + emf * s\nd_i2 = push2 - R_L * i2 - emf * c",
    torque="torque = K * (i2 * c - i1 * s)",
    rest=still("i1", "i2"),
)
HALF_WINDINGS = Equations(  # two halves per winding, 1 and 2, 3 and 4; the second acts in the opposite direction
    states=("i1", "i2", "i3", "i4"),
    decide="e1 = -K * omega * s\ne2 = -e1\ne3 = K * omega * c\ne4 = -e3",
    fixed=each("push# = v# * INV_L", 1, 2, 3, 4),
    rates="emf = K_L * omega * s\n"
    "d_i1 = push1 - R_L * i1 + emf\n"
    "d_i2 = push2 - R_L * i2 - emf\n"
    "emf = K_L * omega * c\n"
    "d_i3 = push3 - R_L * i3 - emf\n"
    "d_i4 = push4 - R_L * i4 + emf",
    torque="torque = K * ((i3 - i4) * c - (i1 - i2) * s)",
    rest=still("i1", "i2", "i3", "i4"),
)
# An imposed current needs no volts, and no state of a winding.
GIVEN = Equations(
    kept=("i1", "i2"),
    begin="i1 = r1\ni2 = r2",
    torque="torque = K * (i2 * c - i1 * s)",
)
LAGGING = Equations(
    states=("i1", "i2"),
    rates="d_i1 = (r1 - i1) * INV_LAG\nd_i2 = (r2 - i2) * INV_LAG",
    torque="torque = K * (i2 * c - i1 * s)",
    rest=still("i1", "i2"),
)


def reluctance(phases: int) -> Equations:
    """Return the equations of a variable reluctance motor, which has no magnet.

    A phase has the inductance L + SWING cos(x - position of the phase), x being the electrical angle.  The
    torque is proportional to the square of the current; without current there is neither torque nor EMF.
    """
    if phases == 4:
        turned = [("c", "s"), ("s", "-c"), ("-c", "-s"), ("-s", "c")]
    else:
        turned = [
            ("c", "s"),
            ("(c * COS3 + s * SIN3)", "(s * COS3 - c * SIN3)"),
            ("(c * COS3 - s * SIN3)", "(s * COS3 + c * SIN3)"),
        ]
    numbers = range(1, phases + 1)
    slopes = [f"slope{n} = -TEETH * SWING * {sine}" for n, (_, sine) in zip(numbers, turned, strict=True)]
    torques = " + ".join(f"i{n} * i{n} * slope{n}" for n in numbers)
    rates = [
        f"d_i{n} = (v{n} - R * i{n} - i{n} * slope{n} * omega) / (L + SWING * {cosine})"
        for n, (cosine, _) in zip(numbers, turned, strict=True)
    ]
    states = tuple(f"i{n}" for n in numbers)
    return Equations(
        states=states,
        torque="\n".join([*slopes, f"torque = 0.5 * ({torques})"]),
        decide=each("e# = 0.0 * omega", *numbers),
        rates="\n".join(rates),
        rest=still(*states),
    )


DETENT = Equations(torque="torque = torque - DETENT8 * s * c * (0.5 - s * s)")

# ----------------------------------------------------------------------------------------------------------- drivers
# A winding that is switched off drives its current into the supply until it is zero, and stays at zero.
_OPEN = "v# = where(r# == 0.0, where(i# == 0.0, R * i# + e#, -VS * sign(i#)), {on})"
_ENDS = "i# = where((r# == 0.0) and (i# * i#0 <= 0.0), 0.0 * i#, i#)"

VOLTAGE = Equations(
    decide=each(_OPEN.format(on="r#"), 1, 2),
    settle=each(_ENDS, 1, 2),
)
AVERAGED = Equations(  # the volts that bring the current to its set point in two steps, if the supply has them
    decide=each("v# = clip(R * i# + e# + LH * (r# - i#), -VS, VS)", 1, 2),
)
BILEVEL = Equations(  # until1, until2: s, the ends of the high volts
    kept=("until1", "until2"),
    decide="now = t * 1e-12 + HALF_H\n" + each(_OPEN.format(on="r# * where(until# > now, HIGH, VS)"), 1, 2),
    settle=each(_ENDS, 1, 2),
    edge=each("until# = where(r# == o#, until#, t * 1e-12 + HIGH_TIME)", 1, 2),
    rest=tuple(each("until# <= now", 1, 2).splitlines()),
)


# At rest with a chopper: since the last edge the clock has ticked, and the current has peaked and is falling.
RIPPLES = "(on# == 0.0) and (absolute(i# - 0.7 * r#) <= 0.32 * absolute(r#))"


def chopper(decay: str, blanked: bool, timed: bool) -> Equations:
    """Return the equations of a chopper: a latch keeps a phase on until its current reaches the set point.

    Args:
        decay: slow, fast, mixed, or auto; auto is slow, but mixed after an edge at which the current is to
            decrease.
        blanked: whether a phase stays on for a minimum time.
        timed: whether each phase is switched on again after an off-time; if not, a clock sets both latches.
    """
    if timed:
        lines, kept = ["now = t * 1e-12"], ["asked", "on1", "on2", "off1", "off2"]
        phase = ["off# = off# - H", "ticks = (on# == 0.0) and (off# < HALF_H)"]
    else:
        lines = ["tick = t // PERIOD_PS", "ticks = tick > clock", "clock = tick * 1.0"]
        kept, phase = ["clock", "asked", "on1", "on2"], []
    if blanked:
        kept += ["blank1", "blank2"]
    if decay in ("mixed", "auto"):
        kept += ["fast1", "fast2"]
    phase.append("on# = where(ticks, 1.0, on#)")
    high = "i# * sign(r#) >= absolute(r#)"
    if blanked:
        phase.append("blank# = where(ticks, LEAST_ON, blank# - H)")
        high = f"({high}) and (blank# < HALF_H)"
    phase.append(f"trips = (on# > 0.0) and ({high})")
    if decay in ("mixed", "auto"):
        phase.append("fast# = where(trips, FAST_TIME, fast# - H)")
    if timed:
        phase.append("off# = where(trips, OFF_TIME, off#)")
    phase.append("on# = where(trips, 0.0, on#)")
    slow, fast = "-DIODE * sign(i#)", "-VS * sign(i#)"
    mixed = f"where(fast# > HALF_H, {fast}, {slow})"
    off = {"slow": slow, "fast": fast, "mixed": mixed, "auto": f"where(falls# > 0.0, {mixed}, {slow})"}[decay]
    on = f"where(on# > 0.0, VS * sign(r#), {off})"
    phase.append(_OPEN.format(on=on))
    lines += [each(line, n) for n in (1, 2) for line in phase]
    edge = ["asked = t * 1e-12" if timed else "asked = clock"]
    if decay == "auto":
        kept += ["falls1", "falls2"]
        less = "where(absolute(r#) < absolute(o#), 1.0, 0.0)"
        edge.append(each(f"falls# = where(r# == o#, falls#, {less})", 1, 2))
    return Equations(
        kept=tuple(kept),
        decide="\n".join(lines),
        settle=each(_ENDS, 1, 2) + "\n" + each("i# = where((on# == 0.0) and (i# * i#0 < 0.0), 0.0 * i#, i#)", 1, 2),
        edge="\n".join(edge),
        rest=("now > asked + OFF_TIME" if timed else "clock > asked", *each(RIPPLES, 1, 2).splitlines()),
    )


def switched(count: int) -> Equations:
    """Return the equations of transistors, one per winding or half winding.

    While a transistor is off, the current of its winding decays through the clamp.
    """
    numbers = range(1, count + 1)
    return Equations(
        decide=each("v# = where(r# > 0.0, VS, where(i# > 0.0, -CLAMP, R * i# + e#))", *numbers),
        settle=each("i# = where(i# < 0.0, 0.0 * i#, i#)", *numbers),
    )


# ------------------------------------------------------------------------------------------------------------- loads
RIGID = Equations(
    states=("theta", "omega"),
    rates="d_theta = omega\nd_omega = (torque - DRAG * omega - PULL) * INV_J",
    rest=("absolute(omega) < SLOW", "absolute(d_omega) < SETTLED"),
)
# Friction is decided at a grid point: a shaft at rest stays at rest up to a torque of STICTION; a shaft that
# reverses comes to rest only if it would stay there.
RUBBING = Equations(
    states=("theta", "omega"),
    decide="pulls = torque - PULL\n"
    "stands = omega == 0.0\n"
    "free = where(stands and (absolute(pulls) <= STICTION), 0.0, INV_J)\n"
    "holds = PULL + FRICTION * sign(where(stands, pulls, omega))",
    rates="d_theta = omega\nd_omega = (torque - DRAG * omega - holds) * free",
    settle="omega = where((omega * omega0 < 0.0) and (absolute(torque - PULL) <= STICTION), 0.0 * omega, omega)",
    rest=("absolute(omega) < SLOW", "absolute(d_omega) < SETTLED"),
)
# Two masses: the rotor, and the load on the coupling.
COUPLED = Equations(
    states=("theta", "omega", "theta2", "omega2"),
    decide="twist = STIFFNESS * (theta - theta2) + COUPLING_DRAG * (omega - omega2)\n"
    "pulls = twist - PULL\n"
    "stands = omega2 == 0.0\n"
    "free = where(stands and (absolute(pulls) <= STICTION), 0.0, INV_J2)\n"
    "holds = PULL + FRICTION * sign(where(stands, pulls, omega2))",
    rates="twist = STIFFNESS * (theta - theta2) + COUPLING_DRAG * (omega - omega2)\n"
    "d_theta = omega\n"
    "d_omega = (torque - DRAG * omega - twist) * INV_J\n"
    "d_theta2 = omega2\n"
    "d_omega2 = (twist - DRAG2 * omega2 - holds) * free",
    settle="omega2 = where((omega2 * omega20 < 0.0) and (absolute(twist - PULL) <= STICTION), 0.0 * omega2, omega2)",
    rest=(
        "absolute(omega) < SLOW",
        "absolute(d_omega) < SETTLED",
        "absolute(omega2) < SLOW",
        "absolute(d_omega2) < SETTLED",
    ),
)
DAMPED = Equations(  # a ring dragged along (Lanchester damper); before the load, since it affects the friction
    states=("omega3",),
    torque="drags = DAMPER_DRAG * (omega - omega3)\ntorque = torque - drags",
    rates="d_omega3 = drags * INV_J3",
    rest=("absolute(omega3) < SLOW",),
)
BLOCKED = Equations(rates="d_theta = 0.0 * omega\nd_omega = 0.0 * omega", settle="theta = theta0\nomega = 0.0 * omega")


def stopped(suffix: str = "") -> Equations:
    """Return the equations of hard stops without bounce, for the rotor ("") or the load on the coupling ("2")."""
    theta, omega = f"theta{suffix}", f"omega{suffix}"
    return Equations(
        decide=f"free = where({omega} == 0.0, where(({theta} >= STOP_HIGH) and (pulls > 0.0), 0.0, free), free)\n"
        f"free = where({omega} == 0.0, where(({theta} <= STOP_LOW) and (pulls < 0.0), 0.0, free), free)",
        settle=f"beyond = {theta} > STOP_HIGH\n"
        f"{theta} = where(beyond, STOP_HIGH, {theta})\n"
        f"{omega} = where(beyond, minimum({omega}, 0.0), {omega})\n"
        f"beyond = {theta} < STOP_LOW\n"
        f"{theta} = where(beyond, STOP_LOW, {theta})\n"
        f"{omega} = where(beyond, maximum({omega}, 0.0), {omega})",
    )


def without_rest(of: Equations) -> Equations:
    """Return equations without their rest conditions, to be used with a piece that has its own rest conditions."""
    return replace(of, rest=())
