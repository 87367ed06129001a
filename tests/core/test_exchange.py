"""Exchanges as values: when one may begin, what its wires show meanwhile, and all that makes them waves again."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from random import Random

import pytest

from slewline.core.time.kernel import Kernel
from slewline.core.wires.exchange import SEGMENT, Exchange
from slewline.core.wires.net import Bus, Driver, Net, Wave
from slewline.core.wires.waits import edge, first_of, level, until
from slewline.record.recording.recorder import Recorder
from tests.rows import rows

START, STOP = 1000, 5000  # of the strobe; the answer stands on the bus from 40 ps behind each of its edges on
LATER = 40


class Toy:
    """A strobe that one end leads, and a byte with which the other one answers."""

    def __init__(self, shuffle: int | None = None) -> None:
        self.kernel = kernel = Kernel(None if shuffle is None else Random(shuffle))
        self.strobe, self.bus, self.other = Net(kernel, "strobe"), Bus(kernel, "bus"), Net(kernel, "other")
        self.led, self.answering = Driver(self.strobe, "led"), Driver(self.bus, "answering")
        self.outside = Driver(self.other, "outside")
        self.led.drive(1)
        self.start, self.byte = START, 0x5A
        self.heard: list[tuple[int, object]] = []
        self.withdrawn: list[int] = []
        self.watches = [(self.strobe, self.hear), (self.other, self.hear)]
        for net, observer in self.watches:
            net.watch(observer)
        self.exchange = Exchange(
            {self.led: self.strobed}, {self.answering: self.answered}, [self], self.withdrawn.append
        )
        kernel.settle()
        self.heard.clear()

    def hear(self, net: Net) -> None:
        """The end hears of a change."""
        self.heard.append((self.kernel.now, net.level))
        if net is self.strobe:
            shown = (0xFF, self.byte) if net.level == 0 else None
            self.answering.play(Wave(self.answering.at(self.kernel.seen), (self.kernel.now + LATER,), (shown,)))

    def strobed(self, start: int) -> Wave:
        return Wave(1, (start, start + STOP - START), (0, 1))

    def answered(self, start: int) -> Wave:
        times = start + LATER, start + LATER + STOP - START
        return Wave(None, times, ((0xFF, self.byte), None))

    def play(self) -> None:
        """The twin: the strobe as a wave."""
        wave = self.strobed(self.start)
        self.led.wave(wave.before, wave.times, wave.levels)

    def levels(self) -> tuple[object, object]:
        return self.strobe.level, self.bus.level


@pytest.fixture
def toy() -> Toy:
    return Toy()


async def wait(task: Callable[[], object]) -> None:
    await task()  # type: ignore[misc]


# ------------------------------------------------------------------------------------------------------- how it begins
def test_an_unwatched_exchange_is_not_an_event(toy: Toy) -> None:
    assert toy.exchange.begin(toy.start) and toy.exchange.begin(toy.start)
    assert toy.kernel.next_time() is None
    toy.kernel.run(9000)
    assert (toy.heard, toy.withdrawn) == ([], [])


WATCHING: dict[str, Callable[[Toy], object]] = {
    "watched": lambda toy: toy.strobe.watch(lambda _net: None),
    "the bus is watched": lambda toy: toy.bus.watch(lambda _net: None),
    "sampled": lambda toy: toy.bus.sample(lambda: None),
    "awaited": lambda toy: toy.kernel.spawn(lambda: wait(lambda: level(toy.strobe, 0)), name="waits"),
    "any edge is awaited": lambda toy: toy.kernel.spawn(lambda: wait(lambda: edge(toy.bus)), name="waits"),
    "latched": lambda toy: setattr(toy.strobe, "latched", True),
    "driven": lambda toy: Driver(toy.strobe, "another").drive(0),
    "another one watches a joined wire": lambda toy: joined(toy).watch(lambda _net: None),
}


def joined(toy: Toy) -> Net:
    """A net that is one wire with the bus."""
    net = Bus(toy.kernel, "more")
    net.join(toy.bus)
    toy.kernel.settle()
    return net


@pytest.mark.parametrize("how", WATCHING)
def test_no_exchange_goes_by_value_while_another_task_samples_or_drives(toy: Toy, how: str) -> None:
    WATCHING[how](toy)
    toy.kernel.settle()
    assert not toy.exchange.begin(toy.start)
    assert toy.exchange.nets == () and toy.strobe.exchange is None


def test_no_exchange_goes_by_value_while_a_driver_has_pending_edges(toy: Toy) -> None:
    toy.answering.drive((0xFF, 0))
    assert not toy.exchange.begin(toy.start)


def test_a_driver_that_drives_nothing_and_an_ended_wait_are_not_obstacles(toy: Toy) -> None:
    Driver(toy.strobe, "silent")

    async def waits() -> None:
        await first_of(toy.kernel, 500, (toy.strobe, 0))

    toy.kernel.spawn(waits, name="waits")
    toy.kernel.settle()
    assert not toy.exchange.begin(toy.start)
    toy.kernel.run(600)
    assert toy.exchange.begin(toy.start)


def test_a_joined_wire_goes_by_value_and_shows_it_everywhere(toy: Toy) -> None:
    more = joined(toy)
    assert toy.exchange.begin(toy.start)
    toy.kernel.run(3000)
    assert more.level == toy.bus.level == (0xFF, 0x5A)
    assert more.exchange is toy.bus.exchange is toy.exchange
    toy.bus.log = []
    assert more.exchange is toy.bus.exchange is None


def test_a_wire_carries_one_exchange_at_a_time(toy: Toy) -> None:
    assert toy.exchange.begin(toy.start)
    other = Exchange({toy.led: toy.strobed}, {toy.answering: toy.answered}, [], lambda _ps: None)
    assert not other.begin(0) and toy.exchange.by_value


# -------------------------------------------------------------------------------------------------------- what is shown
@rows("ps", [0, 999, 1000, 1039, 1040, 4999, 5000, 5039, 5040, 9000])
def test_an_exchange_by_value_shows_the_same_levels_on_its_wires(ps: int) -> None:
    value, twin = Toy(), Toy()
    assert value.exchange.begin(value.start)
    twin.play()
    for one in (value, twin):
        one.kernel.run(ps)
    assert value.levels() == twin.levels()
    assert value.exchange.by_value


def test_a_line_knows_its_edges_and_that_it_lets_go(toy: Toy) -> None:
    assert toy.exchange.begin(toy.start)
    line, bus = toy.led.promise, toy.answering.promise
    assert line is not None and bus is not None
    assert [line.after(ps) for ps in (0, 999, 1000, 4999, 5000)] == [1000, 1000, 5000, 5000, None]
    assert line.edges(0, 4999) == ([1000], [0]) and line.edges(1000, 5000) == ([5000], [1])
    assert (line.until, getattr(line, "floats", None), getattr(bus, "floats", None)) == (None, False, True)
    assert toy.strobe.edges_ahead(0, 9000) == ([1000, 5000], [0, 1])
    assert toy.exchange.begin(2000)  # the next exchange: the same line
    assert line.after(0) == 2000


@pytest.mark.parametrize("disturbed", [False, True])
@pytest.mark.parametrize("apart", [10_000, STOP])
def test_recorded_exchanges_are_kept_by_their_states_and_expand_to_the_edges_of_the_twin(
    apart: int, disturbed: bool
) -> None:
    """More of them than one entry of a log stands for; or each begins in the instant in which the one before ends."""
    recorder, logs, found = Recorder(), [], []
    for by_value in (True, False):
        toy = Toy()
        nets = (toy.strobe, toy.bus) if apart > STOP else (toy.strobe,)  # the answer outlasts the strobe
        for net in nets:
            recorder.record(net)
        for number in range(SEGMENT + 100):
            toy.kernel.run(apart * number)
            toy.start = toy.kernel.now + START
            if by_value:
                assert toy.exchange.begin(toy.start)
            else:
                toy.play()
        toy.kernel.run(toy.kernel.now + 2 * START)
        if disturbed:
            Driver(toy.bus, "another").drive((0xFF, 0x5B))
        toy.kernel.run(toy.kernel.now + 20_000)
        end = toy.kernel.now
        arrays = [recorder.edges(net, start, end) for net in nets for start in (0, end // 2)]
        found.append([[part.tolist() for part in array] for array in arrays])
        found[-1].append([[*recorder.each_edge(net, 0, end)] for net in nets])
        found[-1].append([recorder.level(nets[-1], ps) for ps in range(0, end, 77_777)])
        logs.append(len(toy.strobe.log or ()))
    assert found[0] == found[1] and len(found[0][0][0]) == 2 * (SEGMENT + 100)
    assert 2 <= logs[0] < 10 < logs[1]


# ------------------------------------------------------------------------------------------------- how it is withdrawn
DISTURBING: dict[str, Callable[[Toy], object]] = {
    "recording": lambda toy: setattr(toy.strobe, "log", []),
    "recording the bus": lambda toy: setattr(toy.bus, "log", []),
    "watching": lambda toy: toy.strobe.watch(lambda _net: None),
    "watching the bus": lambda toy: toy.bus.watch(lambda _net: None),
    "sampling": lambda toy: toy.bus.sample(lambda: None),
    "waiting for a level": lambda toy: toy.kernel.spawn(lambda: wait(lambda: level(toy.bus, 7)), name="waits"),
    "waiting for an edge": lambda toy: toy.kernel.spawn(lambda: wait(lambda: edge(toy.strobe)), name="waits"),
    "waiting for the first of two": lambda toy: toy.kernel.spawn(
        lambda: wait(lambda: first_of(toy.kernel, 99_000, (toy.bus, None))), name="waits"
    ),
    "driving": lambda toy: Driver(toy.strobe, "another").drive(1),
    "joining": lambda toy: Net(toy.kernel, "more").join(toy.strobe),
    "joining the other way": lambda toy: toy.strobe.join(Net(toy.kernel, "more")),
    "a wave of another driver": lambda toy: Driver(toy.strobe, "another").wave(1, (9000,), (1,)),
    "giving up": lambda toy: toy.exchange.withdraw(),
}


@rows("ps", [0, 999, 1000, 1001, 1040, 3000, 5000, 5040, 6000])
@rows("how", DISTURBING)
def test_any_task_that_samples_or_drives_makes_the_rest_real(how: str, ps: int) -> None:
    toy, twin = Toy(), Toy()
    toy.exchange.begin(toy.start)
    twin.play()
    for one in (toy, twin):
        one.kernel.run(ps)
        one.byte = 0x77 if ps < START else 0x5A  # the end knows nothing of the byte any more, but by what it hears
        DISTURBING[how](one) if one is toy or how != "giving up" else None
        one.kernel.settle()
    assert toy.withdrawn == [ps] and not toy.exchange.by_value and toy.exchange.nets == ()
    assert all(net.exchange is None for net in (toy.strobe, toy.bus))
    assert toy.strobe.level == twin.strobe.level
    assert toy.strobe.value == twin.strobe.level, "what a net without a promise remembers"
    for one in (toy, twin):
        one.kernel.run(9000)
    assert toy.heard == [entry for entry in twin.heard if entry[0] > ps]
    assert toy.strobe.level == 1


@rows("ps", [999, 1000, 1001, 3000, 4999, 5000, 5001])
@rows("shuffle", [None, 1, 2])
def test_a_level_that_is_put_on_the_wire_within_a_run_meets_the_edges_of_its_instant(
    ps: int, shuffle: int | None
) -> None:
    seen = []
    for by_value in (True, False):
        toy = Toy(shuffle)
        if by_value:
            toy.exchange.begin(toy.start)
        else:
            toy.play()
        another = Driver(toy.strobe, "another")
        toy.kernel.call_at(ps, lambda another=another: another.drive(0))
        toy.kernel.call_at(ps + 500, lambda another=another: another.drive(None))
        levels = []
        for look in (ps, ps + 499, ps + 500, 4999, 5000, 6000):
            if look >= toy.kernel.now:
                toy.kernel.run(look)
                levels.append((look, toy.strobe.level))
        seen.append((levels, [entry for entry in toy.heard if entry[0] >= ps]))
    assert seen[0] == seen[1]


def test_an_answer_does_not_come_when_the_strobe_is_taken_back(toy: Toy) -> None:
    assert toy.exchange.begin(toy.start)
    toy.kernel.run(500)
    toy.led.drive(1)
    toy.kernel.run(3000)
    assert toy.levels() == (1, None) and toy.heard == []


def test_an_unwatched_net_shows_the_level_of_its_wire(toy: Toy) -> None:
    more, another = Net(toy.kernel, "more"), Driver(toy.strobe, "another")
    more.join(toy.strobe)
    toy.kernel.settle()
    toy.play()
    for ps, told in ((3000, 0), (3500, None)):
        toy.kernel.run(ps)
        another.drive(told)
    toy.kernel.run(6000)
    toy.start = 7000
    assert toy.exchange.begin(toy.start)
    toy.kernel.run(20_000)
    toy.exchange.withdraw()
    assert more.level == toy.strobe.level == 1


def test_nets_watched_only_at_the_end_remain_watched(toy: Toy) -> None:
    assert toy.exchange.begin(toy.start)
    toy.outside.drive(1)  # on a net without a line
    toy.kernel.run(3000)
    assert toy.heard == [(0, 1)] and toy.exchange.by_value
    toy.exchange.withdraw()
    assert [len(net.observers) for net, _ in toy.watches] == [1, 1]
    toy.kernel.run(9000)
    assert toy.heard == [(0, 1), (5000, 1)]


def test_it_may_begin_again_after_a_disturbance(toy: Toy) -> None:
    assert toy.exchange.begin(toy.start)
    toy.kernel.run(3000)
    look = lambda _net: None  # noqa: E731
    toy.strobe.watch(look)
    toy.kernel.run(6000)
    toy.start = 8000
    assert not toy.exchange.begin(toy.start)
    toy.strobe.unwatch(look)
    assert toy.exchange.begin(toy.start)
    toy.kernel.run(8500)
    assert toy.levels() == (0, (0xFF, 0x5A)) and len(toy.withdrawn) == 1


def test_the_past_of_a_wire_begins_with_its_level_at_the_start_of_the_recording(toy: Toy) -> None:
    assert toy.exchange.begin(toy.start)
    toy.kernel.run(3000)
    toy.strobe.log = [(3000, toy.strobe.level)]
    toy.kernel.run(9000)
    assert [entry[0] for entry in toy.strobe.log] == [3000] or toy.strobe.log[-1][1] in (1, toy.led.promise)
    assert toy.withdrawn == [3000] and toy.strobe.level == 1


# ------------------------------------------------------------------------------------------------ a wait without a wait
def test_a_task_that_is_alone_passes_to_a_later_instant_by_itself() -> None:
    kernel, seen = Kernel(), []

    async def alone() -> None:
        for ps in (10, 20, 30, 40):
            await until(kernel, ps)
            seen.append((kernel.now, kernel.seen))

    kernel.spawn(alone, name="alone")
    kernel.run(30)
    assert seen == [(10, 9), (20, 19), (30, 29)] and (kernel.now, kernel.seen) == (30, 30)
    assert kernel.next_time() == 40
    kernel.run(100)
    assert seen[-1] == (40, 39) and kernel.now == 100


def passed(
    prepare: Callable[[Kernel, list[object]], object], runs: Callable[[Kernel], object], does: str
) -> list[object]:
    """What happens while a task waits for 10, 20, 30 and 40 ps, and drives a wire or begins a task before some."""
    kernel: Kernel = Kernel()
    log: list[object] = []
    net = Net(kernel, "net")
    driver = Driver(net, "alone")

    async def alone() -> None:
        for number, ps in enumerate((10, 20, 30, 40)):
            if number % 2 and does == "spawns":
                kernel.spawn(partial(second, kernel, log), name="spawned")
            if number % 2 and does == "drives":
                driver.drive(number // 2)
            await until(kernel, ps)
            log.append(("task", kernel.now, kernel.seen, net.level))

    kernel.spawn(alone, name="alone")
    prepare(kernel, log)
    runs(kernel)
    log.append((kernel.now, kernel.seen))
    return log


def note(kernel: Kernel, log: list[object], what: str) -> Callable[..., None]:
    return lambda *_: log.append((what, kernel.now, kernel.seen))


DISTURBED: dict[str, Callable[[Kernel, list[object]], object]] = {
    "nothing": lambda _kernel, _log: None,
    "a call before": lambda kernel, log: kernel.call_at(15, note(kernel, log, "call")),
    "a call at the end of the wait": lambda kernel, log: kernel.call_at(20, note(kernel, log, "call")),
    "a call behind": lambda kernel, log: kernel.call_at(21, note(kernel, log, "call")),
    "a listener": lambda kernel, log: kernel.on_commit.add(note(kernel, log, "commit")),
    "a listener that comes": lambda kernel, log: kernel.call_at(
        15, lambda: kernel.on_commit.add(note(kernel, log, "commit"))
    ),
    "another task": lambda kernel, log: kernel.spawn(lambda: second(kernel, log), name="second"),
}


def reached(kernel: Kernel, ps: int) -> bool:
    return kernel.now >= ps


async def second(kernel: Kernel, log: list[object]) -> None:
    for ps in (10, 25, 30):
        await until(kernel, ps)
        log.append(("second", kernel.now, kernel.seen))


@rows("does", ["", "drives", "spawns"])
@rows("disturbed", DISTURBED)
@rows(
    "runs",
    [
        lambda kernel: kernel.run(100),
        lambda kernel: kernel.run(20),
        lambda kernel: [kernel.run(ps) for ps in range(0, 45, 5)],
        lambda kernel: kernel.run_while(lambda: kernel.now >= 20, 100),
        lambda kernel: kernel.run_while(lambda: kernel.now >= 20, 15),
        lambda kernel: [kernel.run_while(partial(reached, kernel, ps), 100) for ps in (10, 10, 25, 40)],
    ],
)
def test_to_pass_on_in_the_task_is_what_a_wait_comes_to(
    disturbed: str, does: str, runs: Callable[[Kernel], object]
) -> None:
    found = passed(DISTURBED[disturbed], runs, does)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Kernel, "pass_to", lambda _kernel, _ps: False)
        assert found == passed(DISTURBED[disturbed], runs, does)
