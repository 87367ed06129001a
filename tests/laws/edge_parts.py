"""Parts that count clock edges, edge by edge: the slow and obvious twins of those that work them out when asked.

They watch their inputs, step at every edge and drive levels; they share nothing with clock edges, counters and views.
"""

from __future__ import annotations

from math import sqrt

from slewline.core.time.timebase import PS_PER_S, picoseconds
from slewline.parts.base.part import Part

STATES = ("0101", "0001", "1001", "1000", "1010", "0010", "0110", "0100")
PHASES = "abcd"
PULSE_PS = 1_700_000


class EdgeTranslator(Part):
    """A step at each fall of PULSE."""

    edge = 0  # the level of PULSE with which a step begins

    def __init__(self, kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.add_pin("pulse", "in", f"step at each {'rise' if self.edge else 'fall'}", pull=1)
        self.add_pin("direction", "in", "high: clockwise", pull=1)
        self.position = 0  # steps clockwise since the beginning

    def rewired(self) -> None:
        self.pin("pulse").net.watch(self._pulsed)

    def _pulsed(self, net) -> None:
        if net.level == self.edge:
            self.stepped(1 if self.high("direction") else -1)

    def stepped(self, sign: int) -> None:
        """The motor takes a step."""
        self.position += sign


class EdgeMotor(EdgeTranslator):
    """A motor that may lose steps."""

    edge = 1

    def __init__(
        self,
        kernel,
        name: str,
        *,
        lag=0,
        pull_in=0,
        acceleration=0,
        loses=(),
    ) -> None:
        super().__init__(kernel, name)
        self.lag_ps, self.pull_in, self.acceleration = picoseconds(lag), pull_in, acceleration
        self.loses = frozenset(loses)
        for pin in "xy":
            self.add_pin(pin, "out", "detector signal", initial=0)
        self.pulses = self.lost = 0
        self.arrives_ps = 0  # when the step under way is made
        self.sign, self.rate, self.pulsed_ps = 0, 0.0, -PS_PER_S

    def stepped(self, sign: int) -> None:
        self.pulses += 1
        if sign != self.sign:
            self.sign, self.rate = sign, 0.0
        now = self.kernel.now
        interval, self.pulsed_ps = now - self.pulsed_ps, now
        follows = now >= self.arrives_ps and self.pulses not in self.loses and interval >= self._shortest_ps()
        self.rate = PS_PER_S / interval if follows and interval else 0.0
        self.lost += not follows
        if follows:
            self.arrives_ps = now + self.lag_ps
            self.kernel.call_at(self.arrives_ps, lambda: self._made(sign))

    def _shortest_ps(self) -> int:
        """The shortest interval before the next step."""
        if not self.pull_in:
            return 0
        return int(PS_PER_S / max(self.pull_in, sqrt(self.rate**2 + 2 * self.acceleration)))

    def _made(self, sign: int) -> None:
        super().stepped(sign)
        self.drivers["x"].drive(int(self.position % 4 in (1, 2)))
        self.drivers["y"].drive(int(self.position % 4 in (2, 3)))


class EdgeRotor(Part):
    """A rotor between two windings."""

    def __init__(self, kernel, name: str) -> None:
        super().__init__(kernel, name)
        for n in (1, 2, 3, 4):
            self.add_pin(f"phase{n}", "in", f"phase {n}, low energises", pull=1)
        self.position = 0  # steps clockwise since the beginning; at rest in the field of offset 0
        self.followed: int | None = None

    def rewired(self) -> None:
        for n in (1, 2, 3, 4):
            self.pin(f"phase{n}").net.watch(self._follow)

    @property
    def field(self) -> int | None:
        """The direction of the field, 0 to 3; None without current in both windings."""
        one, two, three, four = (self.high(f"phase{n}") for n in (1, 2, 3, 4))
        return {(-1, -1): 0, (1, -1): 1, (1, 1): 2, (-1, 1): 3}.get((one - two, three - four))

    def _follow(self, _net) -> None:
        field = self.field
        if field is None or field == self.followed:  # four pins tell of one change
            return
        self.followed = field
        turn = (field - self.position) % 4
        if turn == 2:
            self.finding("rotor-lost", "the field jumped by 180 electrical degrees: a real rotor could turn either way")
        else:
            self.position += {0: 0, 1: 1, 3: -1}[turn]


class EdgeGsD200(Part):
    """A driver module."""

    def __init__(self, kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.state = 1
        self.add_pin("clock", "in", "step at each rising edge", pull=1)
        self.add_pin("direction", "in", "high: clockwise", pull=1)
        self.add_pin("reset", "in", "low: state 1", pull=1)
        self.add_pin("enable", "in", "low: no current in any phase", pull=1)
        self.add_pin("half_full", "in", "high: half step, low: full step", pull=1)
        self.add_pin("control", "in", "current decay; high: slow, low: fast", pull=1)
        for phase, level in zip(PHASES, STATES[0], strict=True):
            self.add_pin(phase, "out", f"phase {phase}, high: on", initial=int(level))

    def rewired(self) -> None:
        self.pin("clock").net.watch(self._clocked)
        for pin in ("reset", "enable"):
            self.pin(pin).net.watch(lambda _: self._put())
        self._put()

    @property
    def decay(self) -> str:
        """How the current decays in the pauses of the chopper: "slow" or "fast"."""
        return "slow" if self.high("control") else "fast"

    def _clocked(self, net) -> None:
        if net.level == 1:
            way = 1 if self.high("direction") else -1
            self.state = (self.state - 1 + way * (1 if self.high("half_full") else 2)) % len(STATES) + 1
            self._put()

    def _put(self) -> None:
        if not self.high("reset"):
            self.state = 1
        for phase, level in zip(PHASES, STATES[self.state - 1], strict=True):
            self.drivers[phase].drive(int(level) if self.high("enable") else 0)


class EdgePhaseLatch(Part):
    """A latch between phase pins and motor."""

    def __init__(self, kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.add_pin("pulse", "in", "clock", pull=1)
        self.add_pin("off", "in", "high: coils off", pull=0)
        for n in (1, 2, 3, 4):
            self.add_pin(f"phase{n}", "in", f"phase {n} from the chip", pull=1)
            self.add_pin(f"coil{n}", "out", f"phase {n} to the motor", initial=1)
        self.held = (1, 1, 1, 1)

    def rewired(self) -> None:
        self.pin("pulse").net.watch(self._clocked)
        self.pin("off").net.watch(lambda _: self._put())

    def _clocked(self, net) -> None:
        if net.level == 1:
            one, two, three, four = (int(self.high(f"phase{n}")) for n in (1, 2, 3, 4))
            self.held = (one, two, three, four)
            self._put()

    def _put(self) -> None:
        off = self.high("off")
        for n, level in enumerate(self.held, 1):
            self.drivers[f"coil{n}"].drive(1 if off else level)


class EdgeDamping(Part):
    """A step back and a step forth behind a move."""

    def __init__(self, kernel, name: str, *, t1="2 ms", t2="3 ms") -> None:
        super().__init__(kernel, name)
        self.t1_ps, self.t2_ps = picoseconds(t1), picoseconds(t2)
        self.braked_ps = 0  # when the last motion is braked
        for pin, pull in (("clock", 1), ("dir", 1), ("mov", 0), ("ramp", 0)):
            self.add_pin(pin, "in", f"{pin.upper()} of the module", pull=pull)
        self.add_pin("a", "out", "high: in motion", initial=0)
        self.add_pin("b", "out", "high behind a motion: turns the direction round", initial=0)
        self.add_pin("c", "out", "two pulses behind a motion", initial=1)
        self.add_pin("clock_out", "out", "CLOCK of the driver", initial=1)
        self.add_pin("dir_out", "out", "direction of the driver", initial=1)

    def rewired(self) -> None:
        for pin in ("mov", "ramp"):
            self.pin(pin).net.watch(lambda _: self._detect())
        self.pin("a").net.watch(self._ended)
        for pin in ("clock", "dir", "a", "b", "c"):
            self.pin(pin).net.watch(lambda _: self._put())
        self._put()

    def _detect(self) -> None:
        """G1: the last pulse is over when both are low."""
        self.drivers["a"].drive(int(self.high("mov") or self.high("ramp")))

    def _ended(self, net) -> None:
        """The fall of a starts the timing generator."""
        now, c = self.kernel.now, self.drivers["c"]
        if net.level == 1:
            if now < self.braked_ps:
                self.finding(
                    "damping-cut",
                    "a motion begins before the previous one is fully braked; use longer pauses or a shorter t2",
                )
            return
        pulses = [self.t1_ps, *[self.t2_ps] * (self.t2_ps > 0)]
        self.braked_ps = now + pulses[-1] + PULSE_PS
        turned = (pulses[0] + pulses[-1]) // 2 + 2 * PULSE_PS
        self._later((self.drivers["b"], now + PULSE_PS, 1), (self.drivers["b"], now + turned, 0))
        for pulse in pulses:
            self._later((c, now + pulse, 0), (c, now + pulse + PULSE_PS, 1))

    def _later(self, *edges) -> None:
        for driver, ps, level in edges:
            self.kernel.call_at(ps, lambda driver=driver, level=level: driver.drive(level))

    def _put(self) -> None:
        """G2 turns the direction, and c joins the clock."""
        turned = self.high("b") and not self.high("a")
        self.drivers["dir_out"].drive(int(self.high("dir") ^ turned))
        self.drivers["clock_out"].drive(int(self.high("clock") and self.high("c")))


TWINS = {
    "translator": EdgeTranslator,
    "motor": EdgeMotor,
    "rotor": EdgeRotor,
    "gs_d200": EdgeGsD200,
    "phase_latch": EdgePhaseLatch,
    "damping": EdgeDamping,
}


def fitted(bench, kind: str, name: str, *, twin: bool, **options):
    """Put a part on a bench: that of the house, or its twin."""
    return bench.place(TWINS[kind](bench.kernel, name, **options)) if twin else bench.part(kind, name, **options)
