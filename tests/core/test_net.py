"""Nets: who wins on a wire, what a reader sees, and promises that say the same however they are asked."""

from __future__ import annotations

from itertools import product
from random import Random

import pytest

import slewline
from slewline.core.time.kernel import Kernel
from slewline.core.wires.net import Bus, Driver, Net, Wave
from slewline.core.wires.waits import edge, level, until
from slewline.errors import WiringError
from tests.rows import rows


def net_with(*levels, pull=None, tie=None, kind=Net):
    kernel = Kernel()
    net = kind(kernel, "net", pull, tie) if kind is Net else kind(kernel, "net")
    clashes = []
    net.on_conflict.add(lambda _: clashes.append(kernel.now))
    drivers = [Driver(net, f"d{i}") for i in range(len(levels))]
    for driver, value in zip(drivers, levels, strict=True):
        driver.drive(value)
    kernel.settle()
    return net, drivers, clashes


# ------------------------------------------------------------------------------------------------------- who drives


@rows(("pull", "tie", "expected"), [(None, None, None), (1, None, 1), (0, None, 0), (1, 0, 0), (0, 1, 1), (None, 1, 1)])
def test_an_undriven_net_takes_its_tie_then_its_pull(pull, tie, expected):
    assert net_with(pull=pull, tie=tie)[0].level == expected
    assert net_with(None, None, pull=pull, tie=tie)[0].level == expected


@rows("levels", list(product([0, 1, None], repeat=3)))
def test_drivers_that_disagree_give_low_and_one_report(levels):
    net, drivers, clashes = net_with(*levels, pull=1)
    strong = [value for value in levels if value is not None]
    assert net.level == (min(strong) if strong else 1)
    assert len(clashes) == (len(set(strong)) == 2)
    for driver in drivers[1:]:
        driver.drive(None)
    net.kernel.settle()
    assert net.level == (1 if levels[0] is None else levels[0])


def test_open_collectors_share_a_wire_without_a_clash():
    net, (one, two), clashes = net_with(None, None, pull=1)
    seen = []
    net.watch(lambda net: seen.append(net.level))
    for step in (lambda: one.drive(0), lambda: two.drive(0), lambda: one.drive(None), lambda: two.drive(None)):
        step()
        net.kernel.settle()
    assert seen == [0, 1]
    assert clashes == []


def test_a_clash_is_reported_when_it_begins_however_often_the_net_is_read():
    net, (_, two), clashes = net_with(0, None)
    kernel = net.kernel
    two.play(Wave(None, (100, 200, 300), (1, None, 1)))
    net.watch(lambda _: None)
    for ps in range(0, 400, 7):
        kernel.run(ps)
        assert net.level == net.level == 0
    assert clashes == [100, 300]


@rows("told", list(product([0, 1, None], repeat=4)))
@rows("kind", [Net, Bus])
def test_levels_of_two_drivers_in_one_round_take_effect_as_one_change(kind, told):
    one_was, two_was, one_is, two_is = (value if value is None or kind is Net else (1, value) for value in told)
    for swapped in (False, True):
        net, (one, two), _ = net_with(one_was, two_was, kind=kind)
        before, changes, seen = net.level, net.changes, []
        net.watch(lambda net, seen=seen: seen.append(net.level))
        orders = [(one, one_is), (two, two_is)]
        for driver, value in reversed(orders) if swapped else orders:
            driver.drive(value)
        net.kernel.settle()
        strong = [value for value in (one_is, two_is) if value is not None]
        assert net.level == (min(strong) if strong else None)
        assert seen == [net.level] * (net.level != before)
        assert net.changes - changes == len(seen)


@pytest.mark.parametrize("kind", [Net, Bus])
def test_a_clash_that_ended_may_begin_again(kind):
    high, low = ((1, 1), (1, 0)) if kind is Bus else (1, 0)
    net, (one, _), clashes = net_with(high, low, kind=kind)
    for ps, told in ((10, None), (20, high), (30, low), (40, high)):
        net.kernel.run(ps)
        one.drive(told)
        net.kernel.settle()
    assert clashes == [0, 20, 40]


def test_changes_are_counted_on_watched_nets():
    net, (driver,), _ = net_with(0)
    net.watch(lambda _: None)
    start = net.changes
    driver.play(Wave(0, (10, 20, 30), (1, 1, 0)))
    net.kernel.run(100)
    assert (net.changes - start, net.changed_at) == (2, 30)


# ------------------------------------------------------------------------------------------------------------ buses


def test_wires_of_a_bus_are_driven_and_read_apart():
    bus, _, clashes = net_with((0x0F, 0x05), (0xC0, 0x80), None, kind=Bus)
    assert bus.byte == 0b1011_0101  # wires 4 and 5 are open and read 1
    assert [bus.bit(n) for n in range(8)] == [1, 0, 1, 0, None, None, 0, 1]
    assert clashes == []


def test_an_undriven_bus_floats_and_reads_ff():
    bus, _, _ = net_with(None, kind=Bus)
    assert bus.level is None
    assert bus.byte == 0xFF
    assert bus.bit(3) is None


def test_only_wires_with_two_different_drivers_clash():
    assert net_with((0x0F, 0x05), (0x0F, 0x05), kind=Bus)[2] == []
    assert net_with((0x0F, 0x05), (0xF0, 0x00), kind=Bus)[2] == []
    bus, (one, two, _), clashes = net_with((0x0F, 0x05), (0x1C, 0x18), (0x01, 0x01), kind=Bus)
    assert clashes == [0]
    assert bus.byte == 0b1111_0001  # wires 2 and 3 disagree and read 0
    two.drive((0x10, 0x10))
    bus.kernel.run(50)
    assert bus.byte == 0b1111_0101
    one.drive((0x01, 0x00))
    bus.kernel.settle()
    assert clashes == [0, 50]


# --------------------------------------------------------------------------------------------------------- promises


def test_a_promise_moves_an_unwatched_net_without_any_event():
    net, (driver,), _ = net_with(0)
    driver.play(Wave(0, (100, 200), (1, 0)))
    net.kernel.settle()
    assert net.kernel.next_time() is None
    for ps, expected in ((99, 0), (100, 1), (199, 1), (200, 0)):
        net.kernel.run(ps)
        assert net.level == expected


def test_a_watched_promise_costs_one_entry_at_a_time():
    net, (driver,), _ = net_with(0)
    seen = []
    net.watch(lambda net: seen.append((net.kernel.now, net.level)))
    driver.play(Wave(0, (100, 200, 300), (1, 0, 1)))
    net.kernel.settle()
    assert len([entry for entry in net.kernel.heap if entry[3] == entry[2].token]) == 1
    net.kernel.run(1000)
    assert seen == [(100, 1), (200, 0), (300, 1)]


def test_a_new_promise_replaces_the_old_one_and_a_moved_bound_silences_it():
    net, (driver,), _ = net_with(0)
    kernel, seen = net.kernel, []
    net.watch(lambda net: seen.append((kernel.now, net.level)))
    old = Wave(0, (100, 200, 300), (1, 0, 1))
    driver.play(old)
    kernel.run(150)
    old.until = 180
    driver.renew()
    kernel.run(250)
    assert seen == [(100, 1)]
    driver.play(Wave(1, (270, 400), (0, 1)))
    kernel.run(300)
    driver.drive(1)
    kernel.run(500)
    assert seen == [(100, 1), (270, 0), (300, 1)]


def test_a_wave_given_in_advance_begins_with_the_level_that_is_there():
    for watched in (False, True):
        net, (driver,), _ = net_with(1)
        kernel, seen = net.kernel, []
        if watched:
            net.watch(lambda net, seen=seen, kernel=kernel: seen.append((kernel.now, net.level)))
        driver.wave(1, (10, 20), (0, 1))
        kernel.run(15)
        driver.wave(0, (17,), (1,))
        assert net.level == 0
        kernel.run(17)
        assert net.level == 1
        driver.drive(0)
        driver.wave(0, (30,), (1,))  # told in the same round as a level
        kernel.settle()
        assert net.level == 0
        kernel.run(40)
        assert net.level == 1
        assert seen == ([(10, 0), (17, 1), (17, 0), (30, 1)] if watched else [])


@pytest.mark.parametrize("ends", [None, 0, 1])
def test_a_wave_that_is_over_leaves_what_it_ended_with_and_not_the_pull(ends):
    net, (driver,), clashes = net_with(1, pull=1)
    driver.wave(1, (10, 20), (0, ends))
    net.watch(lambda _: None)
    net.kernel.run(30)
    assert net.level == (1 if ends is None else ends)
    other = Driver(net, "other")
    other.drive(0)
    net.kernel.settle()
    assert net.level == 0
    assert clashes == ([30] if ends == 1 else [])


def test_two_promises_on_one_net_are_both_followed():
    net, (one, two), clashes = net_with(None, None, pull=1)
    seen = []
    net.watch(lambda net: seen.append((net.kernel.now, net.level)))
    one.play(Wave(None, (10, 30), (0, None)))
    two.play(Wave(None, (20, 50, 60, 70), (0, None, 0, None)))
    net.kernel.run(100)
    assert seen == [(10, 0), (50, 1), (60, 0), (70, 1)]
    assert clashes == []


def random_wave(random: Random) -> Wave:
    times = sorted(random.sample(range(1, 60), random.randrange(1, 8)))
    wave = Wave(random.choice([0, 1, None]), tuple(times), tuple(random.choice([0, 1, None]) for _ in times))
    wave.until = random.choice([None, random.randrange(1, 70)])
    return wave


def test_level_after_and_edges_of_a_wave_agree_at_every_instant():
    random = Random(5)
    for _ in range(200):
        wave = random_wave(random)
        plain = dict(zip(wave.times, wave.levels, strict=True))
        value, levels = wave.before, []
        for ps in range(75):
            if wave.until is None or ps < wave.until:
                value = plain.get(ps, value)
            levels.append(value)
            assert wave.level(ps) == levels[ps]
        edges = [ps for ps in plain if wave.until is None or ps < wave.until]
        changes = [ps for ps in range(1, 75) if levels[ps] != levels[ps - 1]]
        for start in range(-1, 75, 3):
            assert wave.after(start) == min((ps for ps in changes if ps > start), default=None)
            for stop in range(start, 75, 7):
                times, values = wave.edges(start, stop)
                assert times == [ps for ps in edges if start < ps <= stop]
                assert values == [levels[ps] for ps in times]


# ----------------------------------------------------------------------------------------------------------- wiring


def test_joined_nets_are_one_wire():
    kernel = Kernel()
    one, two = Net(kernel, "one", tie=1), Net(kernel, "two", pull=1)
    out, back = Driver(one, "out"), Driver(two, "back")
    log = []
    two.watch(lambda net: log.append(("told", net.level)))

    async def waits():
        await level(two, 0)
        log.append("waited")

    kernel.spawn(waits, name="waits")
    kernel.settle()
    one.join(two)
    kernel.settle()
    assert one.level == 1  # the pull of the second net; the tie of the first has ended
    back.drive(0)
    kernel.settle()
    assert one.level == 0
    assert log == [("told", 0), "waited"]
    back.drive(None)
    out.drive(0)
    kernel.settle()
    assert log[2:] == []


def test_a_joint_notifies_both_sides_of_the_resulting_level():
    kernel = Kernel()
    one, two = Net(kernel, "one", 1), Net(kernel, "two", 1)
    out, heard = Driver(one, "out"), []
    out.drive(0)
    kernel.settle()
    one.watch(lambda net: heard.append(("one", net.level)))
    two.watch(lambda net: heard.append(("two", net.level)))
    kernel.run(5)
    one.join(two)
    assert two.value == 1, "levels change at the end of the round"
    kernel.settle()
    assert (heard, two.level, two.changed_at) == ([("two", 0)], 0, 5)
    kernel.call_at(9, lambda: out.drive(None))
    kernel.run(9)
    assert heard[1:] == [("one", 1), ("two", 1)]


def test_a_joint_in_mid_instant_shows_with_the_next_round():
    kernel = Kernel()
    one, two = Net(kernel, "one", 0), Net(kernel, "two", 0)
    Driver(one, "out").drive(1)
    kernel.settle()
    seen = []
    kernel.call_at(5, lambda: one.join(two))
    kernel.call_at(5, lambda: seen.append(two.level))
    two.watch(lambda net: seen.append((kernel.now, net.level)))
    kernel.run(6)
    assert seen == [0, (5, 1)]


def test_three_wires_joined_in_one_round_are_one():
    kernel = Kernel()
    nets = [Net(kernel, name, 1) for name in "abc"]
    drivers = [Driver(net, "out") for net in nets]
    nets[1].join(nets[2])
    nets[0].join(nets[1])
    drivers[2].drive(0)
    kernel.settle()
    assert [net.value for net in nets] == [0, 0, 0]
    drivers[0].wave(0, (10, 20), (1, 0))
    drivers[2].drive(None)
    kernel.run(15)
    assert [net.level for net in nets] == [1, 1, 1]
    nets[2].join(nets[0])  # nothing new
    assert len(nets[2].joined) == 3


def test_a_clash_on_a_joint_wire_is_reported_once():
    kernel = Kernel()
    one, two = Net(kernel, "one"), Net(kernel, "two")
    reports = []
    one.on_conflict.add(reports.append)
    two.on_conflict.add(reports.append)
    high, low = Driver(one, "high"), Driver(two, "low")
    high.drive(1)
    low.drive(0)
    kernel.settle()
    one.join(two)
    kernel.settle()
    assert (reports, two.level) == ([one], 0)
    low.drive(None)
    kernel.settle()
    assert (one.level, two.level) == (1, 1)
    low.play(Wave(1, (10,), (0,)))
    kernel.settle()
    kernel.run(20)
    assert two.level == 0 and reports == [one, one]


def test_recordings_made_before_two_wires_were_joined_stay():
    bench = slewline.Bench()
    x, y = bench.add("cy525", name="x"), bench.add("cy525", name="y")
    bench.record("x.wait", "y.dowhile")
    x.pin("wait").drive(0, at="1 us")
    y.pin("dowhile").drive(0, at="2 us")
    y.pin("dowhile").release(at="3 us")
    bench.run("4 us")
    bench.wire("x.wait", "y.dowhile")
    x.pin("wait").drive(1, at="5 us")
    bench.run("2 us")
    assert [column.tolist() for column in bench.edges("x.wait")] == [[10**6, 5 * 10**6], [0, 1]]
    times, levels = bench.edges("y.dowhile")
    assert times.tolist() == [2 * 10**6, 3 * 10**6, 4 * 10**6, 5 * 10**6]
    assert levels.tolist() == [0, 1, 0, 1]


@rows("pulls", [(0, 1), (1, 0), (None, 1), (1, None), (0, None), (None, 0), (None, None)])
def test_the_order_of_wiring_does_not_decide_what_an_open_wire_reads(pulls):
    kernel = Kernel()
    one, two = (Net(kernel, "net", pull) for pull in pulls)
    one.join(two)
    kernel.settle()
    assert one.level == max((pull for pull in pulls if pull is not None), default=None)


def test_edges_promised_before_two_nets_are_joined_are_reported_once():
    kernel = Kernel()
    one, two = Net(kernel, "one"), Net(kernel, "two")
    told = []
    two.watch(lambda net: told.append(kernel.now))
    Driver(two, "two").play(Wave(0, (10, 20), (1, 0)))
    kernel.settle()
    one.join(two)
    kernel.settle()
    woken = []

    async def waits():
        while True:
            await edge(one)
            woken.append(kernel.now)

    kernel.spawn(waits, name="waits")
    kernel.run(50)
    assert told == [0, 10, 20]
    assert woken == [10, 20]


def bench_with_two():
    bench = slewline.Bench()
    return bench, bench.add("cy525", name="x"), bench.add("cy525", name="y")


def test_wired_pins_have_one_level_and_lose_their_tie():
    bench, x, y = bench_with_two()
    assert x.pin("abort").level == 1
    bench.wire("x.abort", "y.abort")
    assert (x.pin("abort").level, y.pin("abort").level) == (0, 0)  # no tie, no pull-up
    y.pin("abort").drive(1)
    assert (x.pin("abort").level, y.pin("abort").level) == (1, 1)


def test_wiring_is_transitive_in_any_order():
    for wires in (
        ["x.abort y.abort", "y.abort x.wait", "x.wait y.wait"],
        ["x.wait y.wait", "x.abort y.abort", "y.wait y.abort"],
    ):
        bench, x, y = bench_with_two()
        for wire in wires:
            bench.wire(*wire.split())
        y.pin("wait").drive(0)
        assert [chip.pin(name).level for chip in (x, y) for name in ("abort", "wait")] == [0] * 4
        x.pin("abort").release()
        y.pin("wait").drive(1)
        assert [chip.pin(name).level for chip in (x, y) for name in ("abort", "wait")] == [1] * 4


def test_an_inverter_drives_its_second_pin_from_the_first():
    bench, x, y = bench_with_two()
    bench.wire("x.programmable_output", "y.wait", invert=True)
    host = bench.host(x)
    assert y.pin("wait").level == 0
    seen = []
    y.pin("wait").net.watch(lambda net: seen.append(net.level))
    host.send("C\rB\r")
    bench.run_until_idle()
    assert seen == [1, 0]


def test_an_inverter_of_a_promise_follows_each_edge():
    bench, x, y = bench_with_two()
    bench.wire("x.clk15", "y.wait", invert=True)
    edges = []
    y.pin("wait").net.watch(lambda net: edges.append((bench.now_ps, net.level)))
    bench.run("3 us")
    clock = x.clock
    expected = [
        (clock.ps(tick), level) for n in range(3) for tick, level in ((15 * n, 1), (15 * n + 5, 0)) if tick <= 33
    ]
    assert edges in (expected, expected[1:])


def test_a_bus_does_not_fit_a_pin():
    bench, _, _ = bench_with_two()
    with pytest.raises(WiringError, match="bus"):
        bench.wire("x.db", "y.wait")


def test_a_task_waits_for_any_change_of_a_shared_wire():
    net, (one, two), _ = net_with(1, 1)
    seen = []

    async def task():
        while True:
            await edge(net)
            seen.append(net.kernel.now)

    net.kernel.spawn(task, name="task")
    net.kernel.settle()
    net.kernel.call_at(10, lambda: one.drive(0))
    net.kernel.call_at(20, lambda: two.drive(0))
    net.kernel.call_at(30, lambda: one.drive(1))
    net.kernel.call_at(40, lambda: two.drive(1))
    net.kernel.run(100)
    assert seen == [10, 40]


@pytest.mark.parametrize("watched", [True, False])
def test_a_wave_that_begins_with_the_last_edge_of_another_one_leaves_that_edge_to_be_reported(watched):
    net, (driver,), _ = net_with(1)
    kernel, seen = net.kernel, []
    if watched:
        net.watch(lambda net: seen.append((kernel.now, net.level)))
    driver.wave(1, (100, 200), (0, 1))
    kernel.call_at(200, lambda: driver.wave(1, (300, 400), (0, 1)))
    kernel.run(250)
    assert net.level == 1
    kernel.run(500)
    assert seen == ([(100, 0), (200, 1), (300, 0), (400, 1)] if watched else [])


# ------------------------------------------------------------------------------------------------ levels put at once
WAYS = {
    "nothing": lambda net, log: None,
    "a watcher": lambda net, log: net.watch(lambda net: log.append(("watcher", net.kernel.now, net.value))),
    "a sampler": lambda net, log: net.sample(lambda: log.append(("sampler", net.kernel.now, net.value))),
    "a recording": lambda net, log: setattr(net, "log", []),
    "another driver": lambda net, log: Driver(net, "other").drive(1),
    "another wire": lambda net, log: net.join(Net(net.kernel, "other")),
}


def answered(drive, way, shuffle=None, beside=False):
    """What is seen of a wire that a task puts to 0, 1 and None, and another one answers, at the instants 10, 20 ..."""
    kernel, log = Kernel(shuffle), []
    net, back = Net(kernel, "net", pull=1), Net(kernel, "back")
    driver, answer = Driver(net, "one"), Driver(back, "two")
    driver.drive(1)
    answer.drive(1)
    kernel.settle()
    WAYS[way](net, log)
    kernel.settle()

    async def asks():
        for number, wanted in enumerate((0, 1, 0, None, 0, 1), 1):
            await until(kernel, 10 * number)
            drive(driver, wanted)
            log.append(("asked", kernel.now, back.level))

    async def answers():
        while True:
            await edge(net)
            log.append(("woken", kernel.now, net.level, net.changes))
            drive(answer, net.level)

    async def looks():
        for number in range(1, 7):
            await until(kernel, 10 * number)
            log.append(("looks", kernel.now, net.level, back.level))

    for task in (asks, answers, *([looks] if beside else [])):
        kernel.spawn(task, name=task.__name__)
    kernel.run(100)
    log += net.log or []
    return sorted(map(repr, log)) if beside else log, net.changes, back.changes, net.changed_at


@rows("beside", [False, True])
@rows("way", WAYS)
def test_a_level_that_is_set_immediately_notifies_no_observer(way, beside):
    driven = answered(Driver.drive, way, beside=beside)
    assert len(driven[0]) > 8
    assert answered(Driver.put, way, beside=beside) == driven
    if beside:
        assert answered(Driver.put, way, shuffle=Random(1), beside=True) == driven


def test_a_level_is_set_immediately_where_it_can_be():
    kernel = Kernel()
    net = Net(kernel, "net")
    driver = Driver(net, "one")
    driver.drive(0)
    kernel.settle()
    seen = []

    async def puts():
        await until(kernel, 10)
        driver.put(1)
        seen.append((net.value, kernel.pending))

    kernel.spawn(puts, name="puts")
    kernel.run(20)
    assert seen == [(1, [])] and net.changes == 2 and net.changed_at == 10


# ------------------------------------------------------------------------------------------------------ by its activity
@pytest.mark.parametrize("active", [0, 1])
def test_a_pin_is_read_and_driven_by_the_name_of_its_activity(active):
    kernel = Kernel()
    net = Net(kernel, "net", active=active)
    driver = Driver(net, "d")
    assert not net.is_active and not net.is_inactive, "it floats"
    seen = []
    for act in (driver.activate, driver.deactivate, lambda: driver.activate(True), lambda: driver.activate(False)):
        act()
        kernel.settle()
        seen.append((net.level == active, net.is_active, net.is_inactive))
    assert seen == [(True, True, False), (False, False, True)] * 2
    assert (driver.level_when(True), driver.level_when(False)) == (active, 1 - active)
    assert (net.when_active, net.when_inactive) == ((net, active), (net, 1 - active))


@pytest.mark.parametrize("active", [0, 1])
def test_a_strobe_is_active_from_each_instant_to_the_next_and_then_inactive(active):
    kernel = Kernel()
    net = Net(kernel, "net", active=active)
    driver = Driver(net, "d")
    driver.deactivate()
    kernel.settle()
    driver.strobe(0, 5, 7, 9)
    kernel.settle()
    assert [net.resolve(ps) == active for ps in (0, 4, 5, 6, 7, 8, 9)] == [True, True, False, False, True, True, False]


def test_pins_of_one_wire_keep_their_own_activity():
    kernel = Kernel()
    busy, ready = Net(kernel, "busy", active=0), Net(kernel, "ready", active=1)
    out = Driver(busy, "out")
    busy.join(ready)
    other = Driver(ready, "other")
    out.activate()
    kernel.settle()
    assert busy.is_active and ready.is_inactive
    out.drive(None)
    other.activate()
    kernel.settle()
    assert ready.is_active and busy.is_inactive


def test_a_pin_whose_row_names_no_activity_is_not_queried_for_one():
    net = Net(Kernel(), "direction")
    driver = Driver(net, "d")
    for ask in (lambda: net.is_active, lambda: net.is_inactive, driver.activate, driver.deactivate):
        with pytest.raises(AttributeError):
            ask()
    assert driver.next is None, "nothing is driven"
