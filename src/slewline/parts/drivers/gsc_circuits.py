"""The circuits between a GS-C module and its driver or motor (figures 10, 19 and 23)."""

from __future__ import annotations

from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING

from ...core.datasheet.option import Option
from ...core.time.kernel import Kernel
from ...core.time.timebase import Time, picoseconds
from ...core.wires.net import Driver, Net
from ...core.wires.views import gated
from ...errors import UsageError
from ..base.follower import Stateless, start_rule
from ..base.part import AXIS, Part

if TYPE_CHECKING:
    from ...core.datasheet.table import Pin

PULSE_PS = 1_700_000  # CLOCK low time, as on the module
TWO_CLOCKS = MappingProxyType({"cw": (1, 1, 0, 1), "ccw": (0, 1, 1, 1)})  # by DIR and CLOCK: low low, low high ...


class TwoClocks(Part):
    """A separate clock line for each direction, for drivers that need two clocks (figure 10)."""

    wiring = MappingProxyType({"clock": "step", "dir": "direction"})
    options = (AXIS,)
    rewired = start_rule

    def __init__(self, kernel: Kernel, name: str, *, axis: int = 1) -> None:
        super().__init__(kernel, name)
        self.axis = axis
        self.add_pin("clock", "in", "CLOCK of the module", pull=1)
        self.add_pin("dir", "in", "DIR of the module", pull=1, active=1)
        self.add_pin("cw", "out", "CLOCK while DIR is high, else high", initial=1)
        self.add_pin("ccw", "out", "CLOCK while DIR is low, else high", initial=1)
        views = {pin: partial(gated, table=table) for pin, table in TWO_CLOCKS.items()}
        self.rule = Stateless(self, ("clock", "dir"), views)

    def objection(self, own: str, row: Pin) -> str:
        """Return the reason why a neighbour's pin (`row`) cannot be wired to this part's pin `own`; "" if it can.

        The pin that drives `clock` must not idle at its active level, because that level causes a step.
        """
        if own == "clock" and row.reset is not None and row.reset == row.active:
            return "rests at the level of a step: with each change of direction the other clock would step"
        return super().objection(own, row)


class StepCheck(Part):
    """A closed step loop: ENABLE is low from a CLOCK pulse until the motor has completed the step (figure 19).

    The detector signals x and y show each step of the motor and its direction (figure 18):

        x   0 1 1 0        clockwise: left to right
        y   0 0 1 1

    If the motor never completes a step, the module stops forever; if the load undoes a step, the step must be
    made again.
    """

    _for_users = ("behind",)
    wiring = MappingProxyType({"clock": "step", "dir": "direction", "enable": "enable"})

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.add_pin("clock", "in", "CLOCK of the module", pull=1)
        self.add_pin("dir", "in", "DIR of the module", pull=1)
        self.add_pin("x", "in", "detector signal", pull=0)
        self.add_pin("y", "in", "detector signal", pull=0)
        self.add_pin("enable", "out", "ENABLE of the module", initial=1)
        self.behind = 0  # steps that the motor still has to make, clockwise positive
        self._lets = 1  # the ENABLE level that permits the next step

    def attached(self, own: str, row: Pin) -> None:
        """Use the active level of the chip's enable input; the CY525's STEP INHIBIT, for example, is active high."""
        if own == "enable" and row.active is not None:
            self._lets = row.active
            self._put(0)

    def rewired(self) -> None:
        """Start to follow the pins, now that the part is wired."""
        self.quarter = self._quarter()
        self.pin("clock").net.watch(self._clocked)
        for pin in "xy":
            self.pin(pin).net.watch(lambda _: self._turned())

    def _quarter(self) -> int:
        return {(False, False): 0, (True, False): 1, (True, True): 2, (False, True): 3}[self.high("x"), self.high("y")]

    def _clocked(self, net: Net) -> None:
        if net.level == 0:
            self._put(1 if self.high("dir") else -1)

    def _turned(self) -> None:
        before, self.quarter = self.quarter, self._quarter()
        self._put({0: 0, 1: -1, 2: 0, 3: 1}[(self.quarter - before) % 4])

    def _put(self, owed: int) -> None:
        self.behind += owed
        self.drivers["enable"].drive(1 - self._lets if self.behind else self._lets)


class Damping(Part):
    """A circuit that damps the last step of a move by a step back and a step forward (figures 22 and 23).

        a          ‾‾‾‾‾‾‾‾|______________________   high while MOV or RAMP is high; falls with the last step
        b          __________|‾‾‾‾‾‾‾‾‾‾|_________   DIR is inverted while a is low and b is high
        c          ‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾|_|‾‾‾‾‾|_|‾‾‾   two extra clock pulses
                           |<- t1 -->|       |
                           |<----- t2 ------>|
        phase       n-1  n |           n-1     n

    t1 and t2 depend on the motor and its load: the pulse at t1 brakes the rotor, and the pulse at t2 holds
    it again before it turns back.
    """

    wiring = MappingProxyType({"clock": "step", "dir": "direction", "mov": "moving", "ramp": "ramping"})

    options = (
        Option("t1", "time", "2 ms", "time from the last step to the first pulse"),
        Option(
            "t2",
            "time",
            "3 ms",
            "time from the last step to the second pulse; 0: no second pulse, so the motor stops one step short",
        ),
    )

    def __init__(self, kernel: Kernel, name: str, *, t1: Time, t2: Time) -> None:
        super().__init__(kernel, name)
        self._t1_ps, self._t2_ps = picoseconds(t1), picoseconds(t2)
        if self._t1_ps <= PULSE_PS or (self._t2_ps and self._t2_ps <= self._t1_ps + 4 * PULSE_PS):
            raise UsageError(f"{name}: t1 {t1!r}, t2 {t2!r}; allowed t1 above 1.7 µs, t2 either 0 or above t1 + 6.8 µs")
        self._braked_ps = 0  # when the last motion is braked
        for pin, pull in (("clock", 1), ("dir", 1)):
            self.add_pin(pin, "in", f"{pin.upper()} of the module", pull=pull)
        for pin in ("mov", "ramp"):
            self.add_pin(pin, "in", f"{pin.upper()} of the module", pull=0, active=1)
        self.add_pin("a", "out", "high: in motion", initial=0)
        self.add_pin("b", "out", "high after a motion: inverts the direction", initial=0)
        self.add_pin("c", "out", "two pulses after a motion", initial=1)
        self.add_pin("clock_out", "out", "CLOCK of the driver", initial=1, role="step")
        self.add_pin("dir_out", "out", "direction of the driver", initial=1, role="direction")

    def rewired(self) -> None:
        """Start to follow the pins, now that the part is wired."""
        for pin in ("mov", "ramp"):
            self.pin(pin).net.watch(lambda _: self._detect())
        self.pin("a").net.watch(self._ended)
        for pin in ("clock", "dir", "a", "b", "c"):
            self.pin(pin).net.watch(lambda _: self._put())
        self._put()

    def _detect(self) -> None:
        """Drive `a`, the output of the gate G1: it falls after the last pulse, when both MOV and RAMP are low."""
        self.drivers["a"].drive(int(self.net("mov").is_active or self.net("ramp").is_active))

    def _ended(self, net: Net) -> None:
        """Start the timing generator if `a` has fallen; report a motion that begins during the damping."""
        now, c = self.kernel.now, self.drivers["c"]
        if net.level == 1:
            if now < self._braked_ps:
                self.finding(
                    "damping-cut",
                    "a motion begins before the previous one is fully braked; use longer pauses or a shorter t2",
                )
            return
        pulses = [self._t1_ps, *[self._t2_ps] * (self._t2_ps > 0)]
        self._braked_ps = now + pulses[-1] + PULSE_PS
        turned = (pulses[0] + pulses[-1]) // 2 + 2 * PULSE_PS
        self._later((self.drivers["b"], now + PULSE_PS, 1), (self.drivers["b"], now + turned, 0))
        for pulse in pulses:
            self._later((c, now + pulse, 0), (c, now + pulse + PULSE_PS, 1))

    def _later(self, *edges: tuple[Driver, int, int]) -> None:
        for driver, ps, level in edges:
            self.kernel.call_at(ps, lambda driver=driver, level=level: driver.drive(level))  # type: ignore[misc]

    def _put(self) -> None:
        """Drive direction and clock: gate G2 inverts the direction, and the pulses of `c` are added to the clock."""
        turned = self.high("b") and not self.high("a")
        self.drivers["dir_out"].drive(int(self.high("dir") ^ turned))
        self.drivers["clock_out"].drive(int(self.high("clock") and self.high("c")))
