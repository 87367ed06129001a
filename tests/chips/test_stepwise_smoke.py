"""The slow twin of the CY525's motion by itself: step times computed by hand, in crystal clocks at 11 MHz."""

from __future__ import annotations

from itertools import pairwise

import pytest

from slewline.chips.cy525.firmware import Cy525
from slewline.core.time.kernel import Kernel
from slewline.core.wires.net import Driver
from slewline.core.wires.waits import level

MHZ = 11
US = 1_000_000  # ps
HIGH = 28  # PULSE high between steps: 2.5 us
POLL = 33  # a held step looks every 3 us
RAMP = dict(firstrate=10, rate=12, slope=245, divisor=10)  # one unit every 10 * 11 * 452 = 49720 clocks
UP = [11000] * 5 + [10000] * 5  # rate 10 for 49720 clocks of ramp time, rate 11 to 99440
FULL = 9167


class Rig:
    """A chip, a host and the edges of its outputs in clocks since READY fell for the motion."""

    def __init__(self, **registers: int) -> None:
        self.kernel = Kernel()
        self.chip = Cy525(self.kernel, "x", stepwise=True, **registers)
        self.inputs: dict[str, Driver] = {}
        self.nets = {name: driver.net for name, driver in self.chip.drivers.items() if name != "clk15"}
        self.seen: list[tuple[int, str, int]] = []
        for name, net in self.nets.items():
            net.watch(lambda net, name=name: self.seen.append((self.kernel.now, name, net.level)))
        self.origin = 0

    def put(self, pin: str, value: int, clocks: int | None = None) -> None:
        """Drive an input now or at a clock of the motion."""
        if clocks is not None:
            self.kernel.call_at(self.chip.clock.ps(self.origin + clocks), lambda: self.put(pin, value))
            return
        if pin not in self.inputs:
            self.inputs[pin] = Driver(self.chip.pins[pin].net, "host")
        self.inputs[pin].drive((0xFF, value) if pin.startswith("db") else value)
        self.kernel.settle()

    async def host(self, text: str) -> None:
        ready = self.chip.pins["ready"].net
        for byte in text.encode():
            await level(ready, 1)
            self.put("db0", byte)
            self.put("io_request", 0)
            await level(ready, 0)
            self.put("io_request", 1)

    def send(self, text: str) -> None:
        self.put("io_request", 1)
        self.kernel.spawn(self.host, text, name="host")

    def begin(self, text: str = "G\r") -> None:
        """Send a motion command and run up to its first fall of PULSE; that instant is clock 0."""
        self.send(text)
        self.kernel.settle()
        while self.chip.pins["pulse"].net.level == 1:
            self.kernel.run(self.kernel.next_time() or 0)
        self.origin = self.chip.clock.ticks_until(self.kernel.now)
        self.seen.clear()

    def run(self, clocks: int) -> None:
        self.kernel.run(self.chip.clock.ps(self.origin + clocks))

    def edges(self, pin: str) -> list[tuple[int, int]]:
        return [(self.chip.clock.ticks_until(ps) - self.origin, value) for ps, name, value in self.seen if name == pin]

    def begins(self, clocks: int) -> list[int]:
        """Begins of the steps in the first so many clocks."""
        start = self.chip.clock.ps(self.origin)
        times = self.chip.axes[0].steps(start, self.chip.clock.ps(self.origin + clocks)).times_ps
        return [self.chip.clock.ticks_until(int(time)) - self.origin for time in times]

    def periods(self, clocks: int) -> list[int]:
        begins = self.begins(clocks)
        return [b - a for a, b in pairwise(begins)]

    def falls(self, pin: str) -> list[int]:
        return [time for time, value in self.edges(pin) if value == 0]


def test_three_steps_at_the_first_rate() -> None:
    rig = Rig(number=3, firstrate=10, rate=10, position=65535)
    rig.begin()
    rig.run(40_000)
    assert rig.begins(40_000) == [0, 11000, 22000]
    rises = [time for time, value in rig.edges("pulse") if value == 1 and time > 0]
    assert rises == [11000 - HIGH, 22000 - HIGH, 33000 - HIGH]
    assert rig.edges("motion_complete")[-1] == (33000, 0)
    assert rig.edges("ready")[-1] == (33000 + 180, 1)  # 30 us at 6 MHz
    assert rig.chip.position == 2
    assert [driver.net.level for driver in rig.chip._outputs.phases] == [0, 1, 1, 0]  # offset 3
    assert not rig.falls("slew")


def test_short_move_turns_in_the_middle() -> None:
    rig = Rig(number=15, **RAMP)
    rig.begin()
    rig.run(200_000)
    assert rig.periods(200_000) == [*UP[:7], *UP[6::-1]]  # and one more at the first rate
    assert rig.falls("motion_complete") == [2 * sum(UP[:7]) + 11000]
    assert not rig.falls("slew")


@pytest.mark.parametrize("rest", [0, 5, 255])
def test_short_rest_is_made_at_the_first_rate(rest: int) -> None:
    rig = Rig(number=20 + rest, **RAMP)
    rig.begin()
    rig.run(4_000_000)
    assert rig.periods(4_000_000) == ([*UP, *UP[::-1]] + [11000] * rest)[:-1]
    assert not rig.falls("slew")


def test_slewing() -> None:
    rig = Rig(number=20 + 256, **RAMP)
    rig.begin()
    rig.run(4_000_000)
    assert rig.periods(4_000_000) == [*UP, *[FULL] * 256, *UP[:0:-1]]
    assert rig.edges("slew")[-2:] == [(105_000, 0), (105_000 + 256 * FULL, 1)]


def test_inhibited_step() -> None:
    rig = Rig(number=3, firstrate=10, rate=10)
    rig.begin()
    rig.put("step_inhibit", 1, 100)
    rig.put("step_inhibit", 0, 12_000)
    rig.run(40_000)
    looks = 11000 - HIGH
    seen = looks + -(-(12_000 - looks) // POLL) * POLL
    assert rig.begins(40_000) == [0, seen + HIGH, seen + HIGH + 11000]


@pytest.mark.parametrize("held", [True, False])
def test_abort_while_ramping(held: bool) -> None:
    rig = Rig(number=1000, **RAMP)
    rig.begin()
    rig.put("abort", 0, 65_001)  # in the seventh step
    if not held:
        rig.put("abort", 1, 76_000)
    rig.run(30_000_000)
    # seven steps up, the last at rate 11; the fresh way up to rate 11 has five steps below it
    expected = UP[:7] + [11000] * 5 + [11000] * (0 if held else 1000 - 12)
    assert rig.periods(30_000_000) == expected[:-1]
    assert rig.falls("motion_complete") == [sum(expected)]


def test_read_out_stretches_a_ramp_step() -> None:
    rig = Rig(number=15, position=0x12FE, **RAMP)
    rig.send("G\r")
    bus = rig.chip.bus
    seen: list[tuple[int, object, object]] = []
    rig.chip.pins["outstrobe"].net.watch(
        lambda net: seen.append((net.level, bus.byte, rig.chip.pins["motion_complete"].net.level))
    )
    rig.begin("")
    rig.inputs["db0"].drive(None)  # the host lets go of the bus
    rig.put("io_select", 1, 1)
    rig.put("io_select", 0, 11_001)
    rig.run(200_000)
    assert rig.periods(200_000)[:4] == [11_000, 11_220, 11_000, 11_000]
    assert seen == [(0, 0x13, 1), (1, 0x13, 1), (0, 0x00, 0), (1, 0x00, 0)]
    assert bus.level is None
    assert [(t - 11_000, v) for t, v in rig.edges("motion_complete")[:2]] == [(44 + 55, 0), (44 + 55 + 110, 1)]


def test_rates_on_the_fly() -> None:
    rig = Rig(number=60000, **RAMP)
    rig.begin("H\rG\r")
    rig.put("db0", 11, 130_000)
    rig.put("io_request", 0, 200_000)  # in the eleventh slew step
    rig.put("io_request", 1, 220_000)
    rig.put("abort", 0, 400_000)
    rig.run(1_000_000)
    look = 105_000 + 11 * FULL
    # down from 12 to 11: ramp time from rate 11 on, five steps at rate 11; then slewing at 11, stopped without ramp
    steps = [*UP, *[FULL] * 11, *[10000] * 20]
    assert rig.periods(1_000_000) == steps[:-1]
    assert rig.edges("slew")[-4:] == [(105_000, 0), (look, 1), (look + 50_000, 0), (look + 200_000, 1)]
    assert rig.falls("motion_complete") == [look + 200_000]
