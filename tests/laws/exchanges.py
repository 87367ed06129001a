"""What happens to two ends that exchange bytes, and what is compared with the twin: the same, edge by edge.

A dialogue is data: what is said, and acts at given instants, often in the middle of an operation or a bus cycle: at an
edge of the quiet run, or a picosecond beside it.  An act is done between two runs, or from within one, in the first
round of its instant.  The twin does the same, and something samples its wires, so that its exchanges never begin and
each edge is played.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random
from typing import Any, NamedTuple

import slewline
from slewline.errors import SlewlineError

NS, US, MS = 10**3, 10**6, 10**9
FALLS = 5  # so often a run may end with an exception, which is noted, and goes on


class Act(NamedTuple):
    """Something that is done at an instant (ps), or as soon as the act before is over."""

    at: int
    what: str
    args: tuple[Any, ...] = ()
    within: bool = False  # a run, in the first round of the instant


@dataclass
class Dialogue:
    """One dialogue."""

    seed: int
    part: str
    sent: str
    options: dict[str, Any] = field(default_factory=dict)  # of whatever the maker of the world wants to know
    until_ps: int = 0
    acts: list[Act] = field(default_factory=list)


class World:
    """A bench, and what is asked of it; families fill in the rest."""

    wires: tuple[str, ...]  # of the exchange, which a twin records from the beginning

    def __init__(self, dialogue: Dialogue, shuffle: int | None) -> None:
        self.dialogue, self.bench = dialogue, slewline.Bench(shuffle=shuffle)
        self.noted: list[Any] = []  # what acts have found
        self.glances: list[Any] = []  # what a listener has seen when it was told something
        self.commits: dict[int, list[Any]] = {}  # the last look of a listener in each instant that it has heard of
        self.since: dict[str, int] = {}  # the instant from which on a wire is recorded
        self.failed = 0
        self.furnish()
        self.pins = {name: self.bench.pin(name) for name in self.wires}
        self.hear()

    def furnish(self) -> None:
        """Put chips, parts and hosts on the bench."""
        raise NotImplementedError

    def state(self) -> dict[str, Any]:
        """What is left in the end, besides findings and what has been noted."""
        raise NotImplementedError

    def hear(self) -> None:
        """Let listeners look at the wires when they are told something."""
        for name in [*self.bench]:
            one: Any = self.bench[name]
            one.on_finding.add(self.told)
            if hasattr(one, "on_command"):
                one.on_command.add(self.hear_of)

    def told(self, found: Any) -> None:
        """Note a finding."""
        self.hear_of(found.code)

    def note(self, *what: Any) -> None:
        """Note something, with its instant and the level on each wire."""
        self.noted.append((self.bench.now_ps, *what, self.levels()))

    def hear_of(self, what: str) -> None:
        """Note what a listener is told, and what it sees: as the twin does, unless a wire changes in that instant."""
        self.noted.append((self.bench.now_ps, what))
        if what != "conflict":  # which is told in the middle of a commit
            self.glances.append((self.bench.now_ps, what, self.levels()))

    def levels(self) -> list[Any]:
        """What stands on all wires."""
        return [pin.level for pin in self.pins.values()]

    # ------------------------------------------------------------------------------------------------------------ acts
    def do(self, act: Act) -> None:
        """Do something; what is said against it is noted."""
        try:
            getattr(self, act.what)(*act.args)
        except SlewlineError as error:
            self.note(type(error).__name__, str(error))

    def look(self) -> None:
        self.note("look")

    def record(self, name: str) -> None:
        if name not in self.since:
            self.since[name] = self.bench.now_ps
            self.bench.record(name)

    def drive(self, name: str, level: int) -> None:
        self.pins[name].drive(level)

    def release(self, name: str) -> None:
        self.pins[name].release()

    def pulse(self, name: str, level: int, width: int) -> None:
        self.pins[name].pulse(level, width)

    def power(self, name: str, on: bool) -> None:
        self.bench[name].power(on)

    def edges(self, name: str, number: int, timeout: int) -> None:
        self.bench.run_until(self.pins[name].edges(number), timeout)
        self.note("edges")

    def level(self, name: str, level: int, timeout: int) -> None:
        self.bench.run_until(self.pins[name].is_(level), timeout)
        self.note("level")

    def function(self, name: str, level: int, timeout: int) -> None:
        self.bench.run_until(lambda: self.pins[name].level == level, timeout)
        self.note("function")

    def listen(self) -> None:
        def heard(ps: int) -> None:
            self.commits[ps] = self.levels()

        self.bench.on_commit.add(heard)

    def gate(self, name: str, number: int) -> None:
        """An inverter on a wire."""
        self.bench.part("inverter", name=f"gate{number}")
        self.bench.wire(name, f"gate{number}.in1")
        self.pins[f"gate{number}.out"] = self.bench.pin(f"gate{number}.out")

    def add(self, kind: str, number: int) -> None:
        """Another part on the same wires."""
        self.bench.part(kind, name=f"more{number}", to=self.bench["x"])

    # ---------------------------------------------------------------------------------------------------------- playing
    def play(self) -> None:
        """Let everything happen."""
        for act in self.dialogue.acts:
            if act.within:
                self.bench.at(act.at, lambda act=act: self.do(act))
        for act in self.dialogue.acts:
            if not act.within:
                self.pass_to(act.at)
                self.do(act)
        self.pass_to(self.dialogue.until_ps)
        for name in self.wires:  # in the middle of an exchange the ends know then how far it has come
            self.bench.pin(name).net.sample(lambda: None)
            self.bench.record(name)

    def pass_to(self, ps: int) -> None:
        """Let time pass; what a run fails with is noted, and it goes on."""
        while self.bench.now_ps < ps and self.failed < FALLS:
            try:
                self.bench.run_to(ps)
            except SlewlineError as error:
                self.failed += 1
                self.note(type(error).__name__, str(error))

    # -------------------------------------------------------------------------------------------------------- comparing
    def recorded(self, name: str, start: int) -> list[tuple[int, int]]:
        """The edges of a recorded wire behind an instant."""
        times, levels = self.bench.edges(name, max(start, self.since.get(name, 0)))
        return [(time, level) for time, level in zip(times.tolist(), levels.tolist(), strict=True) if time > start]

    def left(self) -> dict[str, Any]:
        """What is left in the end."""
        return {
            "end": self.bench.now_ps,
            "noted": sorted(self.noted, key=repr),  # those of an instant come in any order
            "findings": sorted((found.time_ps, found.code, found.text) for found in self.bench.findings),
            "levels": self.levels(),
            **self.state(),
        }


def played(make: Callable[[Dialogue, int | None], World], dialogue: Dialogue, twin: str = "", seed: int = 0) -> World:
    """Play a dialogue.

    Args:
        twin: "kept": by value, and its wires are recorded from the beginning; "played": its exchanges never begin;
            "recorded": the same, and its wires are recorded from the beginning.
    """
    world = make(dialogue, seed if twin else None)
    for name in world.wires:
        if twin in ("recorded", "kept"):
            world.record(name)
        if twin in ("recorded", "played"):
            world.pins[name].net.sample(lambda: None)  # something looks, so no exchange begins
    world.play()
    return world


def differences(fast: World, twin: World) -> list[str]:
    """Where a run and its twin part; empty: nowhere."""
    found = []
    one, two = fast.left(), twin.left()
    recorded = all(twin.since.get(name) == 0 for name in twin.wires)
    if recorded:  # while a wire is recorded, two that disagree are heard of without a look
        for left in (one, two):
            left["noted"] = [note for note in left["noted"] if note[1] != "conflict"]
            left["findings"] = [found for found in left["findings"] if found[1] != "conflict"]
    for key in one:
        if one[key] != two[key]:
            text = f"{one[key]} and {two[key]}"
            if isinstance(one[key], list) and isinstance(two[key], list):
                pairs = zip(one[key], two[key], strict=False)
                text = f"{next((pair for pair in pairs if pair[0] != pair[1]), 'one is longer')}"
            found.append(f"{key}: {text}")
    if recorded:
        busy = {time for name in twin.since for time, _ in twin.recorded(name, -1)}
        busy |= {act.at for act in twin.dialogue.acts}
        one, two = ([look for look in world.glances if look[0] not in busy] for world in (fast, twin))
        if sorted(one, key=repr) != sorted(two, key=repr):
            found.append(f"glances: {next((pair for pair in zip(one, two, strict=False) if pair[0] != pair[1]), None)}")
    for name, since in fast.since.items():
        a, b = fast.recorded(name, since), twin.recorded(name, since)
        if a != b:
            pairs = zip(a, b, strict=False)
            first = next((pair for pair in pairs if pair[0] != pair[1]), (a[len(b) :] or b[len(a) :])[:1])
            found.append(f"{name} from {since} on: {len(a)} and {len(b)} edges, first difference {first}")
    return found + heard(fast, twin)


def heard(fast: World, twin: World) -> list[str]:
    """Where a listener to committed time has seen what the twin's wires did not show."""
    if not fast.commits or not all(twin.since.get(name) == 0 for name in fast.wires):
        return []
    found = []
    for number, name in enumerate(fast.wires):
        start = twin.recorded(name, -1)
        times = [time for time, _ in start]
        for ps, levels in fast.commits.items():
            level = start[bisect_right(times, ps) - 1][1] if times and times[0] <= ps else None
            seen = -1 if levels[number] is None else levels[number]
            if level is not None and isinstance(seen, int) and seen != level:
                found.append(f"{name} at {ps}: a listener saw {seen}, the wire shows {level}")
    return found[:3]


# --------------------------------------------------------------------------------------------------------- disturbances
class Disturber:
    """Makes up acts.

    Args:
        marks: instants at which something happens on the wires, ascending.
        wires: of the exchange.
        lines: those of them that can be driven.
    """

    def __init__(self, rnd: Random, marks: list[int], wires: tuple[str, ...], lines: tuple[str, ...]) -> None:
        self.rnd, self.marks, self.wires, self.lines = rnd, marks, wires, lines
        self.acts: list[Act] = []
        self.joined = 0

    def instant(self) -> int:
        """An edge of the quiet run, an instant beside it, or any."""
        rnd, marks = self.rnd, self.marks
        number = rnd.randrange(len(marks) - 1)
        beside = rnd.choice((0, 0, 0, 1, -1, 1000, -1000, rnd.randrange(-9 * NS, 9 * NS)))
        if rnd.random() < 0.7:
            return max(marks[number] + beside, 1000)
        low, high = marks[number], marks[number + 1]
        return (low + high) // 2 if rnd.random() < 0.3 else rnd.randrange(low, high + 1)

    def act(self, at: int, what: str, *args: Any, within: bool | None = None) -> None:
        self.acts.append(Act(at, what, args, self.rnd.random() < 0.5 if within is None else within))

    def width(self) -> int:
        """How long something lasts."""
        marks, rnd = self.marks, self.rnd
        return rnd.choice((1000, 40 * NS, US, 20 * US, rnd.randrange(1000, 300 * US), marks[-1] // 10))

    def disturb(self) -> None:
        """One thing that happens, of those that every family knows."""
        rnd = self.rnd
        what, at = rnd.choice(KINDS), self.instant()
        if what == "look":
            self.act(at, "look")
        elif what == "record":
            for name in rnd.sample(self.wires, rnd.choice((1, 1, 2, len(self.wires)))):
                self.act(at, "record", name, within=False)
        elif what in ("edges", "level"):
            number = rnd.choice((1, 1, 2, 5, 30)) if what == "edges" else rnd.randrange(2)
            self.act(at, what, rnd.choice(self.lines), number, rnd.choice((US, MS, 10 * MS)), within=False)
        elif what == "drive":
            self.hold(at, rnd.choice(self.lines))
        elif what == "pulse":
            self.act(at, "pulse", rnd.choice(self.lines), rnd.randrange(2), self.width())
        elif what == "gate":
            self.joined += 1
            self.act(at, "gate", rnd.choice(self.lines), self.joined, within=False)
        elif what == "listen":
            self.act(at, "listen", within=False)
        else:
            self.more(what, at)

    def hold(self, at: int, name: str) -> None:
        """Drive a wire, and let it go."""
        self.act(at, "drive", name, self.rnd.randrange(2))
        self.act(at + self.width(), "release", name)

    def more(self, what: str, at: int) -> None:
        """One thing that only this family knows."""

    def made(self) -> list[Act]:
        """All acts in order of time; from within a run, a wire is told one thing in an instant."""
        once = {(act.at, act.within, act.what in ("drive", "release", "pulse"), act.args[:1]): act for act in self.acts}
        return sorted(once.values(), key=lambda act: act.at)


KINDS = (
    *("look",) * 5, *("record",) * 3, "edges", "level", *("drive",) * 2, "pulse", "gate", "listen", *("own",) * 5,
)  # fmt: skip


def edges_of(world: World, names: tuple[str, ...], start: int = 0) -> list[int]:
    """The instants at which something happens on some wires of a recorded world, ascending."""
    times = sorted({time for name in names for time, _ in world.recorded(name, start)})
    return times[bisect_left(times, start) :]
