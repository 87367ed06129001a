"""GS-D200 and GS-D200S, driver modules for a GS-C: translator (figure 7), phase current (figures 6, 11).

    state   1  2  3  4  5  6  7  8   a 3-bit counter; a clockwise half step moves one column to the right
    a       0  0  1  1  1  0  0  0   a, b: the ends of one winding; c, d: those of the other winding
    b       1  0  0  0  0  0  1  1
    c       0  0  0  0  1  1  1  0
    d       1  1  1  0  0  0  0  0

Half stepping goes through all states.  Full stepping leaves the lowest counter bit unchanged: if full
stepping is selected at an odd state, two phases are on; at an even state, one phase.  The state advances
at the rising edge of CLOCK, and RESET sets it to 1.

Phase current.  Inside the driver, the set-point input has a resistor of 10 kohm to 5 V and another
(`ground`) to ground; the current is 2 A per volt at this input.  Figure 11 adds external resistors:

    5 V --- 10k ---.--- ground --- 0 V         MOV RAMP   on
    5 V - Tr1 - R1 -                            0   0     Tr2        rest
                   .--- R3 ------- 0 V          1   1     Tr1        ramp
                   .- R2 - Tr2 --- 0 V          1   0     neither    slew
"""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from ...core.datasheet.option import Option
from ...core.motion.history import History
from ...core.time.events import Events, NoEvents
from ...core.time.kernel import Kernel
from ...core.time.timebase import Time, moment, moments
from ...core.wires.views import gated
from ...errors import UsageError
from ..base.clocked import Clocked
from ..base.counted import Counted
from ..base.follower import start_rule
from ..base.part import AXIS, Part, check_kept
from ..motors.drivers import DRIVERS

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ...core.motion.quantity import Quantity

STATES = ("0101", "0001", "1001", "1000", "1010", "0010", "0110", "0100")  # a, b, c, d in states 1 to 8
PHASES = "abcd"
AND = (0, 0, 0, 1)
SUPPLY_V = 5.0
PULL_UP_OHM = 10e3
AMPERES_PER_VOLT = 2.0


# ------------------------------------------------------------------------------------------------------- translator
class GsD200(Part):
    """A driver module: translator and enable input; `bench.part(to=...)` wires CLOCK, DIR and RESET."""

    _for_users = ("state", "decay")
    wiring = MappingProxyType({"clock": "step", "direction": "direction", "reset": "driver_reset"})
    optional = frozenset({"reset"})
    options = (AXIS,)
    rewired = start_rule

    def __init__(self, kernel: Kernel, name: str, *, axis: int = 1) -> None:
        super().__init__(kernel, name)
        self.axis = axis
        self._state = 0  # 0 to 7, and its future, given the clock
        self._by = 0
        self._counted: Events = NoEvents()
        self.add_pin("clock", "in", "step at each rising edge", pull=1)
        self.add_pin("direction", "in", "high: clockwise", pull=1, active=1)
        self.add_pin("reset", "in", "low: state 1", pull=1, active=0)
        self.add_pin("enable", "in", "low: no current in any phase", pull=1)
        self.add_pin("half_full", "in", "high: half step, low: full step", pull=1)
        self.add_pin("control", "in", "current decay; high: slow, low: fast", pull=1)
        for n, (phase, level) in enumerate(zip(PHASES, STATES[0], strict=True), 1):
            self.add_pin(phase, "out", f"phase {phase}, high: on", initial=int(level), role=f"phase{n}", active=1)
        steers = ("direction", "half_full", "reset")
        self.rule = Clocked(
            self, ("clock", *steers, "enable"), clock="clock", edge=1, steers=steers, acts=("reset",),
            advance=self._advance, step=self._make_step, follow=self._follow,
        )  # fmt: skip

    @property
    def state(self) -> int:
        """State of the translator, 1 to 8."""
        if self.net("reset").is_active:
            return 1
        by = self._by * self._counted.count(self.kernel.seen) + self._step * self.rule.due
        return (self._state + by) % len(STATES) + 1

    @property
    def decay(self) -> str:
        """Current decay while the chopper is off: "slow" or "fast"."""
        return "slow" if self.high("control") else "fast"

    @property
    def _step(self) -> int:
        """The number of states per clock pulse: 1 in half steps, 2 in full steps; negative if counterclockwise."""
        return (1 if self.high("direction") else -1) * (1 if self.high("half_full") else 2)

    # ------------------------------------------------------------------------------------------------------- changes
    def _advance(self, ps: int) -> None:
        """Process the steps up to an instant (ps)."""
        self._state = (self._state + self._by * self._counted.count(ps)) % len(STATES)
        self._counted = NoEvents()

    def _make_step(self) -> None:
        """Process the step whose clock edge is at this instant."""
        self._state = (self._state + self._step) % len(STATES)

    def _follow(self, clock: Events) -> None:
        """Follow the promised edges of the clock from now on, and promise the outputs."""
        if self.net("reset").is_active:
            self._state, clock = 0, NoEvents()
        self._by, self._counted = self._step, clock
        states = [STATES[(self._state + self._by * n) % len(STATES)] for n in range(len(STATES))]
        enable = self.rule.shown("enable")
        for n, phase in enumerate(PHASES):
            levels = tuple(int(state[n]) for state in states)
            on = levels[0] if isinstance(clock, NoEvents) else Counted(clock, self.rule.shown("clock"), levels)
            self.rule.put(self.drivers[phase], gated((on, enable), AND))


# ----------------------------------------------------------------------------------------------------- phase current


class Network(NamedTuple):
    """Data of a driver module: its internal resistor to ground, in ohms; its maximum phase current, in amperes."""

    ground: float
    most: float


# The sheet has 1200 ohm for the GS-D200 and 750 for the GS-D200S; the numbers of its example follow from 1200.
NETWORKS = MappingProxyType(
    {"gs-d200": Network(1200.0, DRIVERS["GS-D200"].most), "gs-d200s": Network(750.0, DRIVERS["GS-D200S"].most)}
)
GROUND_OHM = NETWORKS["gs-d200"].ground


def parallel(*resistors: float) -> float:
    """Return the resistance, in ohms, of several resistors (ohms) in parallel."""
    return 1 / sum(1 / r for r in resistors)


def set_point(*to_ground: float, to_supply: float | None = None, ground: float = GROUND_OHM) -> float:
    """Return the phase current, in amperes, that these resistors set.

    Args:
        to_ground: resistors from the set-point input to ground, ohms.
        to_supply: resistor from the set-point input to 5 V, ohms; None: there is none.
        ground: the driver's internal resistor to ground, ohms.
    """
    upper = parallel(PULL_UP_OHM, to_supply) if to_supply is not None else PULL_UP_OHM
    lower = parallel(ground, *to_ground)
    return AMPERES_PER_VOLT * SUPPLY_V * lower / (upper + lower)


def to_ground(amperes: float, ground: float = GROUND_OHM) -> float:
    """Return the external resistor to ground, in ohms, that lowers the phase current to `amperes`.

    With an internal resistor (`ground`) of 1200 ohm this is I / (1 - 0.933 I) kohm, with I in amperes.
    """
    volts = amperes / AMPERES_PER_VOLT
    return _rest(volts / ((SUPPLY_V - volts) / PULL_UP_OHM), ground, f"{amperes} A by a resistor to ground")


def to_supply(amperes: float, *others: float, ground: float = GROUND_OHM) -> float:
    """Return the external resistor to 5 V, in ohms, that sets the phase current to `amperes`.

    `others` are external resistors to ground, `ground` is the internal one, all in ohms.
    """
    volts = amperes / AMPERES_PER_VOLT
    upper = (SUPPLY_V - volts) * parallel(ground, *others) / volts
    return _rest(upper, PULL_UP_OHM, f"{amperes} A by a resistor to 5 V")


def beside(total: float, present: float) -> float:
    """Return the resistor, in ohms, that makes `total` ohms when connected in parallel with `present` ohms."""
    return _rest(total, present, f"{total:g} ohm with {present:g} ohm in parallel")


def _rest(total: float, present: float, what: str) -> float:
    if not 0 < total < present:
        raise UsageError(
            f"{what}: not possible; a resistor to ground only lowers the current, a resistor to 5 V only raises it"
        )
    return 1 / (1 / total - 1 / present)


def _resists(ohms: float) -> str:
    return "" if ohms > 0 else "allowed more than 0 ohm"


class PhaseCurrent(Part):
    """The phase current that MOV and RAMP select through Tr1 and Tr2 (figure 11).

    The default resistors are those of the data sheet's example: 1.5 A on ramps, 0.25 A at rest, 0.5 A while slewing.
    """

    _for_users = ("amperes", "past", "current_at", "currents_at", "transistors")
    wiring = MappingProxyType({"mov": "moving", "ramp": "ramping"})

    options = (
        Option("r1", "float", 4245, "resistor from Tr1 to the supply", unit="ohm", check=_resists),
        Option("r2", "float", 500, "resistor at Tr2", unit="ohm", check=_resists),
        Option("r3", "float", 937, "permanent resistor", unit="ohm", check=_resists),
        Option("driver", "choice", "gs-d200", "driver module", choices=tuple(NETWORKS)),
    )

    def __init__(self, kernel: Kernel, name: str, *, r1: float, r2: float, r3: float, driver: str) -> None:
        super().__init__(kernel, name)
        ground, most = NETWORKS[driver]
        self._currents = {  # by the states of Tr1 and Tr2
            (tr1, tr2): set_point(r3, *[r2] * tr2, to_supply=r1 if tr1 else None, ground=ground)
            for tr1 in (False, True)
            for tr2 in (False, True)
        }
        if self._currents[True, False] > most:
            raise UsageError(
                f"{name}: {self._currents[True, False]:.3g} A on ramps; the {driver} allows up to {most:g} A; use a "
                "larger r1"
            )
        self.add_pin("mov", "in", "high: in motion", pull=0, active=1)
        self.add_pin("ramp", "in", "high: on a ramp", pull=0, active=1)
        self._history: History | None = None  # since the instant at which the part is wired

    def rewired(self) -> None:
        """Start to follow the pins, now that the part is wired."""
        for pin in ("mov", "ramp"):
            self.pin(pin).net.watch(lambda _: self._note())
        self._note()

    @property
    def transistors(self) -> tuple[bool, bool]:
        """States of Tr1 and Tr2: True if the transistor is on."""
        return self.net("ramp").is_active, not self.net("mov").is_active

    @property
    def amperes(self) -> float:
        """Present phase current, in amperes."""
        return self._currents[self.transistors]

    def _note(self) -> None:
        self._known.note(self.kernel.now, self.amperes)

    @property
    def _known(self) -> History:
        if self._history is None:
            self._history = History(self.amperes, self.kernel.now)
        return self._history

    def quantities(self) -> tuple[Quantity, ...]:
        """Return the quantities of the part over time, for pictures, files and queries."""
        return (self._known.quantity(self.kernel, "current", "A"),)

    def forget(self, before: int) -> None:
        """Drop the record of the currents before an instant (ps)."""
        self._known.forget(before)

    @property
    def past(self) -> list[tuple[int, float]]:
        """Past currents: pairs of the instant (ps) of a change and the new current in amperes."""
        return [*self._known]

    def current_at(self, time: Time) -> float:
        """Return the current, in amperes, at one instant of the past.

        Raises:
            NotRecorded: the past is no longer kept that far back (`Bench(keep=)`).
        """
        instant = moment(time)
        check_kept(self, instant)
        return self._known.at(instant)

    def currents_at(self, times: Sequence[Time] | NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the currents, in amperes, at many instants of the past: float64, the same shape as `times`.

        Raises:
            NotRecorded: the past is no longer kept that far back (`Bench(keep=)`).
        """
        import numpy as np

        instants = np.asarray(moments(times))
        if instants.size:
            check_kept(self, int(instants.min()))
        return self._known.values_at(instants)
