"""A kernel, nets driven by hand, and a recorder."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

import pytest

from slewline.core.motion.step_views import PatternView, PulseView
from slewline.core.motion.train import Playing, StepTrain
from slewline.core.time.kernel import Kernel
from slewline.core.time.timebase import Clock
from slewline.core.wires.net import Bus, Driver, Net, Wave
from slewline.record.recording.recorder import Recorder

Change = tuple[int, int]


class Rig:
    """Nets by name, each with a driver of the same name; `on` runs to an instant and lets something happen there."""

    def __init__(self) -> None:
        self.kernel, self.recorder = Kernel(), Recorder()
        self.nets: dict[str, Net] = {}
        self.drivers: dict[str, Driver] = {}

    def net(self, name: str, kind: type[Net] = Net, **options: object) -> Net:
        self.nets[name] = net = kind(self.kernel, name, **options)  # type: ignore[arg-type]
        self.drivers[name] = Driver(net, name)
        return net

    def bus(self, name: str) -> Net:
        return self.net(name, Bus)

    def on(self, ps: int, **driven: object) -> None:
        """Drive nets at an instant; "x_slew" stands for the net "x.slew"."""
        self.kernel.run(ps)
        for name, what in driven.items():
            self.drivers[name.replace("_", ".", 1)].drive(what)
        self.kernel.settle()

    def at(self, ps: int, function: Callable[[], object]) -> None:
        self.kernel.call_at(ps, function)

    def pulses(self, clock: Clock, origin: int, *runs: tuple[int, int], high: int = 28) -> PulseView:
        return PulseView(Playing(StepTrain(clock, origin, runs)), high)

    def edges(self, name: str, start: int = 0, stop: int = 1 << 62) -> list[Change]:
        times, levels = self.recorder.edges(self.nets[name], start, stop)
        return list(zip(times.tolist(), levels.tolist(), strict=True))


@pytest.fixture
def rig() -> Rig:
    return Rig()


@pytest.fixture
def lively() -> Callable[..., Rig]:
    return make_lively


def make_lively(seed: int, *, count: int = 3, events: int = 30, span: int = 60_000_000, keep: int | None = None) -> Rig:
    """A rig on which everything happens: levels, waves, trains withdrawn half-way, a second driver, a bus."""
    random, rig = Random(seed), Rig()
    clock = Clock(11_000_000)
    for number in range(count):
        pull = random.choice([None, 0, 1])
        net = rig.net(f"x.n{number}", pull=pull)
        rig.drivers[f"x.m{number}"] = Driver(net, "second")
        rig.recorder.record(net, keep)
    rig.recorder.record(rig.bus("x.db"), keep)

    def happen() -> None:
        number, now = random.randrange(count), rig.kernel.now
        driver = rig.drivers[f"x.n{number}"]
        what = random.randrange(8)
        if what < 2:
            driver.drive(random.choice([0, 1, None]))
        elif what == 2:
            rig.drivers[f"x.m{number}"].drive(random.choice([0, 1, None, None]))
        elif what == 3:
            rig.drivers["x.db"].drive(random.choice([None, (255, random.randrange(256)), (15, random.randrange(16))]))
        elif what == 4:
            times = sorted({now + random.randrange(1, span // 20) for _ in range(4)})
            driver.play(Wave(random.choice([0, 1]), tuple(times), tuple(random.choice([0, 1, None]) for _ in times)))
        else:
            train = StepTrain(
                clock, clock.ticks_from(now + random.randrange(3)), [(40, 5), (30, random.randrange(1, 9))]
            )
            playing = Playing(train)
            pulse, pattern = PulseView(playing, 7), PatternView(playing, (0, 1, 1, 0), random.randrange(4), 1, 1)
            driver.play(pulse if what == 5 else pattern)
            if what == 7:
                cut = now + random.randrange(1, span // 20)
                rig.at(cut, lambda: withdraw(driver, playing, cut))
        if random.random() < 0.3:
            rig.at(now, happen)  # twice in one instant

    def withdraw(driver: Driver, playing: Playing, cut: int) -> None:
        if getattr(driver.promise, "of", None) is playing:
            playing.until = cut
            driver.drive(random.choice([0, 1]))

    for _ in range(events):
        rig.at(random.randrange(span // 1000) * 1000 + random.randrange(3), happen)
    return rig
