"""The model as the witness: modules on a bench, whose inputs and outputs are kept as the core has to have them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache
from typing import Any
from unittest.mock import patch

import numpy as np

import slewline
from slewline.chips import line
from slewline.core.memory.store import Memory
from slewline.core.wires.net import Driver, Net
from slewline.core.wires.receiver import Character, Receiver
from slewline.core.wires.serial import RS232, CharacterFormat, bit_clock
from slewline.core.wires.wave import Wave
from slewline.record.recording.recorder import Recorder

from . import library
from .library import Event, Outcome

WORD = CharacterFormat(7, "odd", 2)
START_PS = 400_000_000  # of the RESET pulse
RECORDED = ("rdy", "mov", "ramp", "dir", "reset", "uo1", "uo2", "uo3", "txd", "clock")
BAUDS = {0: 9600, 1: 4800, 2: 2400, 3: 1200, 4: 600, 5: 300, 6: 150, 7: 110}  # by BR2, BR1, BR0 as a number
CLOCK_PS = 1_700_000


class Tapped:
    """A receiver whose characters are kept, each as it comes; around it, as a compiled class has no subclasses."""

    modules: Mapping[str, Module] = {}

    def __init__(self, net: Net, *line: Any) -> None:
        self.net, self.inner = net, Receiver(net, *line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.inner, name)

    async def receive(self, taken: Callable[[Character], object], *_: Any) -> None:
        """Take characters one by one, whoever would take lines."""
        module = self.modules[self.net.name.partition(".")[0]]

        def note(character: Character) -> None:
            faults = library.PARITY * character.parity_wrong + library.FRAMING * character.framing_wrong
            module.note(library.CHARACTER, character.byte | faults << 8, character.end_ps)
            taken(character)

        await self.inner.receive(note)


class SlowMemory(Memory):
    """A store that is still busy for some looks after each write."""

    def __init__(self, data: bytes, looks: int) -> None:
        super().__init__(data)
        self.looks, self.left = looks, 0

    def write(self, data: bytes) -> None:
        super().write(data)
        self.left = self.looks

    def pending(self) -> bool:
        """Return whether it is busy."""
        self.left -= 1
        return self.left >= 0


class Module:
    """A module of the model, without supply at first.

    Args:
        straps: levels of inputs that are driven, from the beginning and perhaps otherwise later.
        fixed: levels of inputs for good.
        kept: what the EEPROM holds.
        looks: how often it is found busy when a write should be over.
    """

    def __init__(
        self,
        bench: slewline.Bench,
        name: str,
        part: str,
        straps: Mapping[str, int],
        fixed: Mapping[str, int],
        kept: bytes = b"",
        looks: int = 0,
    ) -> None:
        self.bench, self.part, self.kept, self.looks = bench, part, kept, looks
        self.x: Any = bench.add(part, name=name, straps=fixed, cold=True, store=SlowMemory(kept, looks))
        self.rests = -1 if fixed else 0  # TXD when it is released: a module alone on its line pulls it down
        bench.record(*(f"{name}.{pin}" for pin in RECORDED))
        self.events: list[Event] = []
        self.changes: list[tuple[int, int, str, int]] = []  # instant, library.INPUTS_..., pin, level
        self.rxd = Driver(self.x.pins["rxd"].net, "host")
        self.waves: list[tuple[int, Wave | int]] = []
        self.put(0)
        self.changes += [(0, library.INPUTS_AFTER, pin, level) for pin, level in fixed.items()]
        for pin, level in straps.items():
            self.drive(pin, level)

    def note(self, kind: int, value: int = 0, end: int = 0) -> None:
        """Keep what comes in now."""
        self.events.append(Event(self.bench.kernel.now, kind, value, end))

    def drive(self, pin: str, level: int, at: int | None = None) -> None:
        """Give an input a level: now, after all else of this instant; or at a later one (ps), with what it brings."""
        now = self.bench.kernel.now
        if at is None or at <= now:
            self.changes.append((now, library.INPUTS_AFTER, pin, level))
            self.x.pin(pin).drive(level)
        else:
            self.changes.append((at, library.INPUTS_NOW, pin, level))
            self.x.pin(pin).drive(level, at=f"{at} ps")

    def put(self, promise: Wave | int) -> None:
        """Let RXD show a level or a wave from now on."""
        self.waves.append((self.bench.kernel.now, promise))
        self.rxd.drive(promise)
        self.bench.kernel.settle()

    def power(self, on: bool) -> None:
        """Switch the supply."""
        if on != self.x.powered:
            self.note(library.ON if on else library.OFF)
            self.x.power(on)

    def fail(self, on: bool) -> None:
        """Let writes to the EEPROM fail."""
        self.note(library.FAULT, int(on))
        self.x.fail_eeprom(on)

    # ------------------------------------------------------------------------------------------------ for the replay
    def came(self) -> list[Event]:
        """Return what came in, ascending in time; the last event is now."""
        found = [*self.events, *self._inputs(), Event(self.bench.kernel.now, library.END)]
        found.sort(key=lambda event: (event.at, ORDER[event.kind]))  # of one instant and kind, as they came
        levels, after = self.first_levels(), []
        for event in found:
            if event.kind in (library.INPUTS_NOW, library.INPUTS_AFTER):
                levels = event.value
            after.append(event._replace(value=levels) if event.kind == library.ON else event)
        return after

    def first_levels(self) -> int:
        """Return the levels of open inputs."""
        return 0x7FFF & ~(1 << library.INPUTS.index("rxd"))

    def _inputs(self) -> Iterator[Event]:
        changes = list(self.changes)
        for at, kind, *_ in self.events:
            if kind == library.ON:
                changes.append((at + START_PS - 1, library.INPUTS_NOW, "rxd", self._rxd(at + START_PS - 1)))
        levels, made = self.first_levels(), {}
        for at, kind, pin, level in sorted(changes, key=lambda change: change[:2]):
            bit = 1 << library.INPUTS.index(pin)
            levels = levels | bit if level else levels & ~bit
            made[at, kind] = levels
        now = self.bench.kernel.now
        return (Event(at, kind, value) for (at, kind), value in made.items() if at <= now)

    def _rxd(self, ps: int) -> int:
        shown = [promise for since, promise in self.waves if since <= ps][-1]
        return shown.level(ps) if isinstance(shown, Wave) else shown

    def went(self) -> Outcome:
        """Return what the model did, with CLOCK and TXD among the edges."""
        now, recorder = self.bench.kernel.now, Recorder()
        steps = self.x.steps()
        edges = {}
        for name in RECORDED:
            times, levels = recorder.edges(self.x.pins[name], 0, now)
            edges[name] = list(zip(times.tolist(), levels.tolist(), strict=True))
        return Outcome(steps.times_ps, steps.directions, steps.positions, [], edges, kept=self.x.store.read())


ORDER = {
    library.CHARACTER: 0,
    library.INPUTS_NOW: 1,
    **dict.fromkeys((library.INPUTS_AFTER, library.ON, library.OFF, library.FAULT), 2),
    library.END: 3,
}


@contextmanager
def tapped(modules: Mapping[str, Module]) -> Iterator[None]:
    """Keep the characters that the receivers of modules take, within the block."""
    Tapped.modules = modules
    with patch.object(line, "Receiver", Tapped):
        yield


@lru_cache(maxsize=4096)
def character_of(byte: int, baud: int, spoiled: int) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the edges of a character that begins at 0 (ps), and the levels from there on; `spoiled`: inverted bits."""
    clock = bit_clock(baud, "host")
    bits = [RS232 if bit else 1 - RS232 for bit in (*WORD.levels(byte), 1)]
    times = [clock.ps(16 * n) for n in range(len(bits))]
    levels = [level ^ (spoiled >> n & 1) for n, level in enumerate(bits)]
    if spoiled >> (len(bits) - 1) & 1:  # no first stop bit
        times.append(length_of(1, baud) - clock.ps(16))
        levels.append(RS232)
    return tuple(times), tuple(levels)


def characters_of(data: bytes, baud: int, start: int, damage: Mapping[int, int] | None = None) -> Wave:
    """Return characters on RXD; `damage`: bits that are inverted, by the number of the character; bit 0 its start."""
    times: list[int] = []
    levels: tuple[int, ...] = ()
    for number, byte in enumerate(data):
        after, shown = character_of(byte, baud, (damage or {}).get(number, 0))
        begin = start + length_of(number, baud)
        times += [begin + ps for ps in after]
        levels += shown
    return Wave(RS232, tuple(times), levels)


@lru_cache(maxsize=4096)
def length_of(count: int, baud: int) -> int:
    """Return how long so many characters take, ps."""
    return count * bit_clock(baud, "host").ps(WORD.ticks)


# ------------------------------------------------------------------------------------------------------------- compare
def difference(model: Outcome, core: Outcome, baud_at: Mapping[int, int], rests: int) -> str:
    """Return in what the core differs from the model, in words; empty: nothing.

    Args:
        baud_at: the rate of the module after each power-up, by its instant (ps).
        rests: the level of TXD when it is released.
    """
    if core.wrong:
        return f"{core.wrong} steps were foreseen wrongly, or levels reported twice"
    if core.baud and core.baud != baud_at[max(baud_at)]:
        return f"the line has {core.baud} baud in the core, {baud_at[max(baud_at)]} in the model"
    if model.kept != core.kept:
        return f"the EEPROM holds {model.kept!r} in the model, {core.kept!r} in the core"
    if len(model.times) != len(core.times):
        return f"steps: model {len(model.times)}, core {len(core.times)}{first_of(model.times, core.times)}"
    for name in ("times", "directions", "positions"):
        wanted, found = getattr(model, name), getattr(core, name)
        if not np.array_equal(wanted, found):
            at = int(np.argmax(wanted != found))
            return f"{name} of step {at} of {len(wanted)}: model {wanted[at]}, core {found[at]}"
    shown = {**core.edges, "txd": line_of(core, baud_at, rests), "clock": clock_of(core)}
    for name in RECORDED:
        wanted = model.edges[name]
        found = [(at, level) for at, level in lifted(shown[name], name)]
        if wanted != found:
            pairs = [pair for pair in zip(wanted, found, strict=False) if pair[0] != pair[1]]
            where = pairs[0] if pairs else (wanted[len(found) :][:1], found[len(wanted) :][:1])
            return f"edges of {name}: model {len(wanted)}, core {len(found)}, first {where}"
    return ""


def first_of(wanted: Any, found: Any) -> str:
    """Return where two arrays of steps part."""
    count = min(len(wanted), len(found))
    apart = np.nonzero(wanted[:count] != found[:count])[0]
    at = int(apart[0]) if len(apart) else count
    return f", from step {at}: model {wanted[at : at + 2]}, core {found[at : at + 2]}"


def lifted(edges: list[tuple[int, int]], name: str) -> list[tuple[int, int]]:
    """Return edges of an output as a net shows them: RDY is pulled up without supply."""
    return (
        library.settled([(0, 1), *((at, 1 if level < 0 else level) for at, level in edges)])[1:]
        if name == "rdy"
        else edges
    )


def clock_of(core: Outcome) -> list[tuple[int, int]]:
    """Return the edges of CLOCK."""
    changes = []
    for at, level in core.edges["dir"]:
        if level < 0 or not changes or changes[-1][1] < 0:
            changes.append((at, 1 if level >= 0 else -1))
    offs = [at for at, level in changes if level < 0]
    pulses = []
    for begin in core.times.tolist():
        end = begin + CLOCK_PS
        cut = any(begin <= off < end for off in offs)
        pulses += [(begin, 0)] if cut or end > core.end else [(begin, 0), (end, 1)]
    found = sorted([*pulses, *changes], key=lambda change: (change[0], change in changes))
    return library.settled(found)


def line_of(core: Outcome, baud_at: Mapping[int, int], rests: int) -> list[tuple[int, int]]:
    """Return the edges of TXD."""
    talks, supply = core.edges["talk"], [at for at, level in core.edges["dir"] if level < 0]
    changes: list[tuple[int, int, int]] = [(at, 2, rests) for at, level in talks if level != 1]
    rates = sorted(baud_at.items())
    for at, byte in core.characters:
        baud = [rate for since, rate in rates if since <= at][-1]
        last = min([core.end, *(cut - 1 for cut in supply if cut >= at)])
        after, levels = character_of(byte, baud, 0)
        changes += [(at + ps, 3, level) for ps, level in zip(after, levels, strict=True) if at + ps <= last]
    found = [(at, level) for at, _, level in sorted(changes)]
    return [edge for edge in library.settled([(-1, rests), *found])[1:]]
