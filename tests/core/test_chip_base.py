"""What every chip has: pins, waits of a firmware, position, conditions.  A made-up part with a sheet of its own."""

from __future__ import annotations

from bisect import bisect_right
from random import Random

import numpy as np
import pytest

import slewline
from slewline.core.chip import Chip
from slewline.core.component import Finding
from slewline.core.datasheet.channel import FlowBus
from slewline.core.datasheet.table import Pin, Sheet, Table
from slewline.core.motion.axis import Axis
from slewline.core.motion.train import Playing, StepTrain
from slewline.core.time.kernel import Kernel
from slewline.core.time.timebase import Clock
from slewline.core.wires.net import Driver, Net
from slewline.core.wires.waits import level
from slewline.errors import (
    LONGEST_FINDING,
    LONGEST_LINE,
    ProgramError,
    SheetError,
    StoreError,
    TimeError,
    Timeout,
    UnknownName,
    UsageError,
    WiringError,
)
from tests.rows import rows

SHEET = Sheet(
    part="toy",
    title="a toy",
    manual="none",
    crystal_hz=1_000_000,
    crystal_low_hz=1,
    crystal_high_hz=10**12,
    pins=(
        Pin(1, "free", "in", "without pull-up"),
        Pin(2, "pulled", "in", "with pull-up", pull=1),
        Pin(3, "tied", "in", "tied high", tie=1),
        Pin(4, "out", "out", "an output"),
        Pin(5, "vcc", "power", "+5 V"),
        Pin(6, "nc", "none", "leave open"),
        Pin(7, "db0", "both", "bus"),
        Pin(8, "db1", "both", "bus"),
    ),
    commands=Table(),
    registers=(),
    times={},
    buffer_bytes=0,
)
US = 1_000_000


class Toy(Chip):
    """Does what a test hands in."""

    sheet = SHEET

    def __init__(self, kernel, program=None, **options):
        super().__init__(kernel, "toy", **options)
        self.program_ = program
        self.log = []
        self.axes = (Axis(kernel, range(256), 0),)
        if program is not None:
            self.start()

    async def run(self):
        await self.program_(self)

    def net(self, name):
        return self.pin(name).net


# ---------------------------------------------------------------------------------------------------------- firmware
def test_a_firmware_that_runs_is_not_started_a_second_time():
    async def program(toy):
        await toy.ticks(10)
        toy.log.append(toy.kernel.now)

    toy = Toy(Kernel(), program)
    with pytest.raises(UsageError, match=r"^toy: the firmware is running already; call stop\(\)"):
        toy.start()
    toy.kernel.run(5 * US)
    with pytest.raises(UsageError, match="is running already"):
        toy.start()
    toy.kernel.run(20 * US)
    assert toy.log == [10 * US]
    toy.stop()
    toy.start()
    toy.kernel.run(25 * US)
    toy.stop()
    toy.start()
    toy.kernel.run(100 * US)
    assert toy.log == [10 * US, 35 * US]


def test_a_missing_channel_or_pin_in_a_sheet_is_named():
    with pytest.raises(SheetError, match=r"^toy needs a FlowBus among its channels; it has none: add one"):
        SHEET.through(FlowBus)
    with pytest.raises(SheetError, match=r"^toy needs a pin with the role 'ready', but none has this role"):
        SHEET.in_role("ready")


@rows("part", ["cy525", "cy545", "gs-c200", "mc1451a"])
def test_internal_actions_of_a_chip_are_not_public_calls(part):
    bench = slewline.Bench()
    x = bench.add(part)
    bench.run("30 ms")
    for name in ("cleared", "powered_up", "powered_off", "driven", "clock_runs", "restart", "released"):
        assert not hasattr(x, name)
    with pytest.raises(UsageError, match="a Mc1451A has no firmware" if part == "mc1451a" else "is running already"):
        x.start()
    bench.run("1 ms")  # and nothing has come of it


# -------------------------------------------------------------------------------------------------------------- pins


def test_an_open_pin_reads_its_tie_its_pull_or_low():
    assert [Toy(Kernel()).pin(name).level for name in ("free", "pulled", "tied", "out", "db0")] == [0, 1, 1, None, None]
    assert [Toy(Kernel(), bare=True).pin(name).level for name in ("free", "pulled", "tied")] == [0, 1, 0]
    toy = Toy(Kernel(), straps={"free": 1, "pulled": 0})
    assert [toy.pin(name).level for name in ("free", "pulled", "tied")] == [1, 0, 1]


def test_only_open_inputs_without_pull_up_are_reported():
    toy = Toy(Kernel(), bare=True)
    toy.check_wiring()
    assert [found.code for found in toy.findings] == ["open-pin", "open-pin"]
    assert [found.text[:5] for found in toy.findings] == ["pin 1", "pin 3"]
    toy = Toy(Kernel(), bare=True, straps={"free": 0})
    toy.pin("tied").drive(0)
    toy.check_wiring()
    assert toy.findings == []


def test_a_drive_overrides_the_tie_until_it_is_released():
    toy = Toy(Kernel())
    pin = toy.pin("tied")
    pin.drive(0)
    assert pin.level == 0
    pin.release()
    assert pin.level == 1


def test_pins_are_driven_at_instants_and_for_a_while():
    kernel = Kernel()
    toy = Toy(kernel)
    edges = []
    toy.net("pulled").watch(lambda net: edges.append((kernel.now, net.level)))
    toy.pin("pulled").pulse(0, "3 us", at="10 us")
    toy.pin("pulled").drive(0, at=20 * US)
    toy.pin("pulled").release(at="21 us")
    kernel.run(5 * US)
    toy.pin("pulled").pulse(0, US)
    kernel.run(100 * US)
    assert edges == [(ps * US, value) for ps, value in ((5, 0), (6, 1), (10, 0), (13, 1), (20, 0), (21, 1))]


def test_bits_of_the_bus_are_pins():
    toy = Toy(Kernel())
    toy.pin("db1").drive(0)
    assert (toy.pin("db0").level, toy.pin("db1").level, toy.bus.byte) == (None, 0, 0xFD)
    toy.pin("db1").release()
    assert toy.pin("db1").level is None


@pytest.mark.parametrize("name", ["vcc", "nc"])
def test_pins_without_signal_are_refused_immediately_also_for_later(name):
    kernel = Kernel()
    pin = Toy(kernel).pin(name)
    for act in (lambda: pin.drive(1), lambda: pin.drive(1, at="1 ms"), pin.release, lambda: pin.pulse(0, "1 us")):
        with pytest.raises(WiringError, match=f"toy.{name} .*carries no signal"):
            act()
    assert kernel.next_time() is None


@pytest.mark.fact("README-LEVELS")
def test_mistakes_at_a_pin_are_explained():
    kernel = Kernel()
    toy = Toy(kernel)
    with pytest.raises(UsageError, match=r"toy\.free: level 2; allowed 0, 1"):
        toy.pin("free").drive(2)
    with pytest.raises(UsageError, match=r"level None; allowed 0, 1 \(release\(\) releases the pin\)"):
        toy.pin("free").drive(None)
    kernel.run(10 * US)
    with pytest.raises(UsageError, match=r"toy\.free: 9 µs is in the past; the time is 10 µs"):
        toy.pin("free").drive(1, at="9 us")
    with pytest.raises(TimeError, match="float"):
        toy.pin("free").drive(1, at=0.5)
    with pytest.raises(UnknownName, match="no pin 'fee'; its pins: free, pulled, tied, out, db0, db1"):
        toy.pin("fee")


@pytest.mark.parametrize(("length", "told"), [(LONGEST_FINDING, False), (LONGEST_FINDING + 1, True), (300_000, True)])
def test_a_text_from_outside_does_not_make_a_finding_as_long_as_it_likes(length, told):
    text = "begin" + "x" * (length - 8) + "end"
    found = Finding(0, "toy", "code", text).text
    assert found.startswith("begin") and found.endswith("end") and len(found) < LONGEST_FINDING + 50
    assert (f" ... ({length} characters in all) ... " in found) is told and (found == text) is not told


@rows("kind", [UsageError, UnknownName, StoreError, Timeout, ProgramError])
def test_nor_an_error(kind):
    long = "x" * 300_000
    found = str(kind(f"file, line 3: {long}: allowed y\n    {long}\n    a remedy"))
    assert found.startswith("file, line 3: xx") and ": allowed y\n    xx" in found and found.endswith("x\n    a remedy")
    assert "(300025 characters in all)" in found and len(found) < 3 * LONGEST_LINE
    short = "x" * LONGEST_LINE
    assert str(kind(f"{short}\n{short}")) == f"{short}\n{short}"


def test_outputs_that_disagree_are_one_finding():
    toy = Toy(Kernel())
    toy.drivers["out"].drive(1)
    toy.pin("out").drive(0)
    assert toy.pin("out").level == 0
    assert [(found.code, found.text) for found in toy.findings] == [
        ("conflict", "two outputs disagree on toy.out; the low one wins")
    ]


@pytest.mark.parametrize("first", ["the pin", "the other end"])
def test_a_conflict_on_a_wire_is_reported_to_the_chip_whichever_end_was_named_first(first):
    toy = Toy(Kernel())
    pin, other = toy.pin("out").net, Net(toy.kernel, "other")
    driver = Driver(other, "part")
    pin.join(other) if first == "the pin" else other.join(pin)
    toy.drivers["out"].drive(1)
    driver.drive(0)
    toy.kernel.settle()
    assert pin.level == 0 and [found.code for found in toy.findings] == ["conflict"]


def test_a_recurring_conflict_is_reported_once_until_a_millisecond_has_had_none():
    toy = Toy(Kernel())
    heard = []
    toy.pin("out").net.on_conflict.add(lambda net: heard.append(toy.kernel.now))
    toy.drivers["out"].drive(1)
    disagree = [10 * US + n * 20 * US for n in range(100)]
    disagree += [disagree[-1] + 1000 * US - 1, disagree[-1] + 2000 * US - 1, disagree[-1] + 3000 * US]
    for ps in disagree:
        toy.pin("out").drive(0, at=ps)
        toy.pin("out").release(at=ps + 10 * US)
    toy.kernel.run(20_000 * US)
    assert heard == disagree
    assert [found.time_ps for found in toy.findings] == [disagree[0], disagree[-2], disagree[-1]]


# ----------------------------------------------------------------------------------------------- waits of a firmware


def looks_of(origin_ps, every, changes, crystal_hz=1_000_000):
    """When `polled` sees level 1 on a net that changes at some instants."""
    kernel = Kernel()

    async def program(toy):
        found = await toy.polled(toy.net("free"), 1, every)
        toy.log.append((kernel.now, toy.tick, found.name))

    toy = Toy(kernel, crystal_hz=crystal_hz)
    toy.program_ = program
    driver = Driver(toy.net("free"), "test")
    driver.drive(0)
    for ps, value in changes:
        kernel.call_at(ps, lambda value=value: driver.drive(value))
    kernel.call_at(origin_ps, toy.start)
    kernel.run(10**10)
    return toy.log


@rows(
    ("changes", "seen"),
    [
        ([(0, 1)], 5),  # there already: the first look is at once
        ([(6, 1)], 12),
        ([(11, 1)], 12),
        ([(12, 1)], 19),  # exactly at a look: the next one sees it
        ([(13, 1), (18, 0), (30, 1)], 33),  # gone again before a look
        ([(13, 1), (19, 0), (40, 1)], 19),  # gone exactly at a look: it is still seen
        ([(700, 1)], 705),
    ],
)
def test_a_polled_pin_is_sampled_on_a_grid(changes, seen):
    (entry,) = looks_of(5 * US, 7, [(us * US, value) for us, value in changes])
    assert entry == (seen * US, seen, "toy.free")


def test_the_grid_does_not_drift_with_an_odd_crystal():
    clock = Clock(3_579_545)
    (entry,) = looks_of(clock.ps(1000), 33, [(9 * 10**9, 1)], crystal_hz=3_579_545)
    tick = 1000 + -(-(clock.ticks_from(9 * 10**9) - 1000) // 33) * 33
    assert entry == (clock.ps(tick), tick, "toy.free")


def test_the_first_of_several_polled_pins_wins_and_the_order_decides_a_tie():
    kernel = Kernel()

    async def program(toy):
        toy.log.append((await toy.polled(toy.net("free"), 1, 10, (toy.net("pulled"), 0))).name)
        toy.log.append((await toy.polled(toy.net("pulled"), 1, 10, (toy.net("free"), 1))).name)
        toy.log.append((await toy.polled(toy.net("free"), 0, 10, (toy.net("pulled"), 1))).name)

    toy = Toy(kernel, program)
    toy.pin("pulled").drive(0, at="15 us")
    toy.pin("free").drive(1, at="12 us")
    kernel.run(10**9)
    assert toy.log == ["toy.free", "toy.free"]  # at 20 us both had come; then `free` still was high
    toy.pin("pulled").drive(1)
    kernel.run(2 * 10**9)
    assert toy.log[2] == "toy.pulled"


def test_ticks_are_counted_and_converted_once():
    kernel = Kernel()

    async def program(toy):
        for _ in range(1000):
            await toy.ticks(7)
            toy.log.append(kernel.now)
        await toy.at_tick(7000)
        await toy.at_tick(6000)
        toy.log.append(kernel.now)
        await level(toy.net("free"), 1)
        toy.sync()
        toy.log.append(toy.tick)

    toy = Toy(kernel, program, crystal_hz=10_999_999)
    clock = toy.clock
    kernel.run(clock.ps(7000))
    assert toy.log == [clock.ps(7 * n) for n in range(1, 1001)] + [clock.ps(7000)]
    toy.pin("free").drive(1, at=clock.ps(8000) + 1)
    kernel.run(clock.ps(9000))
    assert toy.log[-1] == 8001


def test_waiting_has_the_cause_and_the_start_time():
    kernel = Kernel()

    async def program(toy):
        await toy.ticks(3200)
        toy.waits("G held by step_inhibit=1")
        await level(toy.net("free"), 1)

    toy = Toy(kernel, program)
    kernel.run(10**10)
    assert toy.waiting == "toy: G held by step_inhibit=1 since 3.2 ms"
    assert not toy.idle


def test_a_stopped_firmware_is_over_and_may_start_again():
    kernel = Kernel()

    async def program(toy):
        try:
            while True:
                await toy.ticks(10)
                toy.log.append(toy.tick)
        finally:
            toy.log.append("over")

    toy = Toy(kernel, program)
    kernel.run(25 * US)
    toy.stop()
    kernel.run(43 * US)
    toy.start()
    kernel.run(60 * US)
    assert toy.log == [10, 20, "over", 53]


# ---------------------------------------------------------------------------------------------------------- position


class Travel:
    """An axis that is led through random trains, bounds, loads and turns, beside a plain list of its steps."""

    def __init__(self, seed, bits=8, hz=3_579_545):
        self.random, self.kernel, self.clock = Random(seed), Kernel(), Clock(hz)
        self.modulus = 1 << bits
        self.axis = Axis(self.kernel, range(1 << bits), 250)
        self.steps: list[tuple[int, int]] = []  # (instant, sign)
        self.loads = [(0, 250)]

    def expected(self, ps):
        """Position after everything at an instant: the last load before, and the steps since."""
        position = 0
        events = [(when, 0, value) for when, value in self.loads] + [(when, 1, sign) for when, sign in self.steps]
        for when, kind, value in sorted(events, key=lambda event: event[0]):
            if when <= ps:
                position = value if kind == 0 else position + value
        return position % self.modulus

    def go(self, number=12):
        random, axis, clock = self.random, self.axis, self.clock
        for _ in range(number):
            sign = random.choice([1, -1])
            start = clock.ticks_from(self.kernel.now) + 1
            self.kernel.run(clock.ps(start))
            train = StepTrain(clock, start, [(random.randrange(5, 30), random.randrange(1, 9)) for _ in range(3)])
            playing = Playing(train)
            axis.follow(playing, sign)
            end = train.end(train.steps)
            if random.random() < 0.5:
                end = random.randrange(start + 1, end + 1)
            playing.until = clock.ps(end)
            self.steps += [(int(ps), sign) for ps in train.times(1, train.steps) if ps < playing.until]
            for tick in [*sorted(random.sample(range(start, end), min(6, end - start))), end]:
                self.kernel.run(clock.ps(tick))
                self.check_now()
            if random.random() < 0.3:
                value = random.randrange(256)
                axis.load(value)
                self.loads.append((self.kernel.now, value))
                self.check_now()

    def check_now(self):
        now = self.kernel.now
        assert self.axis.position == self.expected(now)
        assert self.axis.travel == sum(sign for when, sign in self.steps if when <= now)


@rows("seed", range(6))
def test_position_is_exact_now_and_in_the_past(seed):
    travel = Travel(seed)
    travel.go()
    axis, now = travel.axis, travel.kernel.now
    asked = sorted(travel.random.randrange(now + 1) for _ in range(200))
    asked += [when + d for when, _ in travel.steps + travel.loads if when for d in (-1, 0, 1) if when + d <= now]
    expected = [travel.expected(ps) for ps in asked]
    assert [axis.position_at(ps) for ps in asked] == expected
    assert axis.positions_at(np.array(asked)).tolist() == expected


@pytest.mark.parametrize("seed", range(6))
def test_every_window_of_steps_is_a_slice_of_the_list(seed):
    travel = Travel(seed)
    travel.go()
    done = [(when, sign) for when, sign in travel.steps if when <= travel.kernel.now]
    times = [when for when, _ in done]
    for _ in range(60):
        start, stop = sorted(
            travel.random.choice([*times, travel.random.randrange(travel.kernel.now)]) for _ in range(2)
        )
        window = travel.axis.steps(start, stop)
        inside = [(when, sign) for when, sign in done if start <= when <= stop]
        assert window.times_ps.tolist() == [when for when, _ in inside]
        assert window.directions.tolist() == [sign for _, sign in inside]
        assert window.positions.tolist() == [travel.expected(when) for when, _ in inside]
        assert len(window) == len(inside)
        assert (window.times_ps.dtype, window.directions.dtype, window.positions.dtype) == (np.int64, np.int8, np.int64)


def test_an_axis_reports_its_arrival():
    kernel, clock = Kernel(), Clock(11_000_000)
    axis = Axis(kernel, range(1 << 16), 65_534)
    train = StepTrain(clock, 100, ((50, 10),))
    playing = Playing(train)
    assert axis.arrives(3) is None
    axis.follow(playing, 1)
    begins = train.times(1, train.steps).tolist()
    assert [axis.arrives(position) for position in (65_535, 0, 1, 8)] == [begins[n] for n in (0, 1, 2, 9)]
    assert axis.arrives(9) is None
    assert axis.arrives(65_534) is None  # only after 65536 steps
    kernel.run(begins[4])
    assert axis.arrives(3) is None
    assert axis.arrives(4) == begins[5]
    playing.until = begins[6]
    assert axis.arrives(4) == begins[5]
    assert axis.arrives(5) is None
    axis.follow(Playing(StepTrain(clock, clock.ticks_from(kernel.now), ((50, 10),))), -1)
    assert axis.position == 2  # a train that begins now has begun
    assert axis.arrives(65_533) == clock.ps(clock.ticks_from(kernel.now) + 5 * 50)


def test_forgetting_leaves_the_rest_in_place():
    travel = Travel(1)
    travel.go()
    middle = travel.steps[len(travel.steps) // 2][0]
    asked = [middle, travel.kernel.now]
    expected = [travel.expected(ps) for ps in asked]
    travel.axis.forget(middle)
    assert travel.axis.positions_at(asked).tolist() == expected
    travel.check_now()


# -------------------------------------------------------------------------------------------------------- conditions


def test_a_run_ends_at_the_very_instant_of_its_condition():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x", firstrate=10, rate=10, position=0, number=5)
    host = bench.host(x)
    host.send("G\r")
    bench.run_until(x.pin("ready").edges(3))  # down and up for G, down for the carriage return
    bench.run_until(x.pin("pulse").is_(0))
    first = bench.now_ps
    period = x.clock.ps(11_000)
    bench.run_until(x.reaches(3))
    assert (x.position, bench.now_ps) == (3, first + 2 * period)
    begins = x.steps().times_ps.tolist()
    assert begins == [first, first + period, first + 2 * period]
    bench.run_until(x.pin("pulse").edges(2))
    assert bench.now_ps == first + 3 * period
    bench.run_until(lambda: x.idle)
    assert bisect_right(x.steps().times_ps.tolist(), bench.now_ps) == 5
    assert x.position_at(first - 1) == 0
    assert x.position_at([first - 1, first, bench.now_ps]).tolist() == [0, 1, 5]


def test_a_condition_that_is_met_already_takes_no_time():
    bench = slewline.Bench()
    x = bench.add("cy525", position=7)
    bench.run("1 ms")
    for condition in (x.pin("ready").is_(1), x.reaches(7), lambda: True):
        bench.run_until(condition)
        assert bench.now_ps == 10**9


def test_a_timeout_names_the_condition_the_time_and_the_waiting_task():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    host = bench.host(x)
    host.send("D 9000\r")
    with pytest.raises(slewline.Timeout) as caught:
        bench.run_until(x.pin("slew").is_(0), timeout="1 s")
    text = str(caught.value)
    assert text.startswith("waited 1 s for x.slew=0; the time is 1 s\n")
    assert "x: waiting 9 s (D 9000) since " in text
    assert bench.now_ps == 10**12


def test_a_timeout_reports_a_deadlock():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    with pytest.raises(slewline.Timeout, match="deadlock: no event is pending, so the condition cannot become true"):
        bench.run_until(x.reaches(5), timeout="1 s")


def test_axes_count_from_one():
    x = slewline.Bench().add("cy525", name="x")
    assert x.axis(1) is x
    for number in (0, 2, -1):
        with pytest.raises(UnknownName, match="its only axis is 1"):
            x.axis(number)
