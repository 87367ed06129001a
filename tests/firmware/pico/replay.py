"""The random dialogues of the core, at the pins of boards: what the model was given, and how the boards differ from it.

Nothing is aimed at an instant here, for a board is some microseconds late in all it does, and the supply comes once.
"""

from __future__ import annotations

import random
from typing import NamedTuple

from slewline.core.wires.wave import Wave
from slewline.record.recording.recorder import Recorder
from tests.firmware.part import library
from tests.firmware.part.dialogues import MS, US, Dialogue, S
from tests.firmware.part.witness import BAUDS, Module

from .emulated import HZ, PINS, Emulator, Pico, cycles_of, ps_of

SLOW = ("mov", "ramp", "dir", "reset", "uo1", "uo2", "uo3", "rdy")
LATE_PS = 100 * US  # an edge of an output


class BoardDialogue(Dialogue):
    """A dialogue that a board can follow."""

    def due(self) -> int | None:
        """Return nothing: no input comes at the very instant of something else."""
        return None

    def power_cycle(self) -> None:
        """Let time pass in place of it."""
        self.wait(self.rng.randint(0, 50 * MS))

    def _module(self, name: str, part: str, address: int) -> Module:
        module = super()._module(name, part, address)
        module.x.store.looks = 0  # the flash is no slower than the model
        return module

    def kept(self, part: str) -> bytes:
        """Return what the EEPROM holds: nothing."""
        super().kept(part)
        return b""

    def play(self) -> None:
        """Play it on the model, without failing writes."""
        for module in self.modules.values():
            module.fail = lambda on: None  # type: ignore[method-assign]
        super().play()
        self.wait(100 * MS)


def without_glitches(edges: list[tuple[float, int]]) -> list[tuple[float, int]]:
    """Return edges without pulses of less than 50 us, between two instants that are one in the model."""
    out: list[tuple[float, int]] = []
    for at, level in edges:
        if out and at - out[-1][0] < 50 * US:
            out.pop()
        else:
            out.append((at, level))
    return out


class Shown(NamedTuple):
    """How a board compares: in words if it differs; steps, answers, and the worst deviations (ps)."""

    difference: str
    steps: int = 0
    answers: int = 0
    first: float = 0
    later: float = 0
    answer: float = 0
    pin: float = 0
    bit: int = 0  # cycles


def replay(emulator: Emulator, module: Module, number: int = 0) -> Pico:
    """Give a board what a module of the model was given; return it, run to the same instant."""
    on = next(event.at for event in module.events if event.kind == library.ON)
    rate = sum(level << n for n in range(3) for _, _, pin, level in module.changes if pin == f"br{n}")
    straps = {pin: level for at, _, pin, level in module.changes if at <= on and pin in PINS}
    shown = [promise for since, promise in module.waves if since <= on][-1]
    straps["rxd"] = shown.level(on) if isinstance(shown, Wave) else shown
    board = Pico(emulator, number, **straps)
    board.bit = HZ // BAUDS[rate]
    board._ask(times=[2000 * 132, 400 * 132])
    board.power_up()
    board.up -= cycles_of(on)

    def cycle(ps: int) -> int:
        return board.up + cycles_of(ps)

    later = [(at, kind, pin, level) for at, kind, pin, level in module.changes if at > on and pin in PINS]
    now = module.bench.kernel.now
    ends = [since for since, _ in module.waves[1:]] + [now]
    for (since, shown), end in zip(module.waves, ends, strict=True):
        if isinstance(shown, Wave):
            edges = zip(shown.times, shown.levels, strict=True)
            later += [(at, library.INPUTS_NOW, "rxd", level) for at, level in edges if since <= at < end]
        elif since > on:
            later.append((since, library.INPUTS_NOW, "rxd", shown))
    later.sort(key=lambda change: change[:2])
    levels = ((PINS[pin], 1 - level if pin == "rxd" else level, at) for at, _, pin, level in later)
    board._ask(inputs=[[number, level, cycle(at)] for number, level, at in levels])
    board.run(cycle(now))
    return board


def quiet(module: Module, at: int) -> int:
    """Return an instant, at or before another one, with no edge of an output around it."""
    while any(
        len(Recorder().edges(module.x.pins[pin], at - 100 * US, at + 100 * US)[0]) > 1
        for pin in (*SLOW, "clock", "txd")
    ):
        at -= 70 * US
    return at


def compare(module: Module, board: Pico) -> Shown:
    """Compare a board with a module."""
    kernel, recorder = module.bench.kernel, Recorder()
    end = quiet(module, kernel.now - 50 * MS)

    def wanted(pin: str) -> list[tuple[int, int]]:
        times, levels = recorder.edges(module.x.pins[pin], 0, kernel.now)
        return [(at, level) for at, level in zip(times.tolist(), levels.tolist(), strict=True) if at <= end]

    def found(pin: str) -> list[tuple[float, int]]:
        edges = [(float(ps_of(cycle - board.up)), level) for cycle, level in board.edges(pin)]
        return [(at, level) for at, level in edges if at <= end]

    on = next(event.at for event in module.events if event.kind == library.ON)
    length = 11 * S * board.bit // HZ
    frames = Pico.frames(board, [(board.up + cycles_of(at), max(level, 0)) for at, level in wanted("txd")])
    said = [(float(ps_of(at - board.up)), bits) for at, bits in frames if ps_of(at - board.up) <= end - length]
    heard = [
        (float(ps_of(at - board.up)), bits)
        for at, bits in board.frames()
        if ps_of(at - board.up) <= end - length + US * 30
    ]
    one, other = (["".join(map(str, bits)) for _, bits in each] for each in (said, heard))
    if one != other:
        at = next(
            (n for n, pair in enumerate(zip(one, other, strict=False)) if pair[0] != pair[1]), min(len(one), len(other))
        )
        return Shown(
            f"characters: {len(one)} and {len(other)}, first at {at}, {said[at : at + 1]}, {heard[at : at + 1]}"
        )
    answer = max((abs(a - b) for (a, _), (b, _) in zip(said, heard, strict=True)), default=0.0)
    steps, made = (
        [at for at, level in wanted("clock") if level == 0 and at > on],
        [at for at, level in found("clock") if level == 0],
    )
    if len(steps) != len(made):
        return Shown(f"steps: {len(steps)} and {len(made)}")
    anew = sorted(
        [at for at, level in wanted("mov") if level == 1]
        + [at for at, level in wanted("dir") if at > on]
        + [at for at, _, pin, level in module.changes if pin == "enable" and level]
    )
    first = later = reference = 0.0
    before, index = 0, 0
    for model, own in zip(steps, made, strict=True):
        while index < len(anew) and anew[index] <= before:
            index += 1
        if index < len(anew) and anew[index] <= model:
            reference = own - model
            first = max(first, abs(reference))
        later = max(later, abs(own - model - reference))
        before = model
    pin_late = 0.0
    for pin in SLOW:
        expected = [edge for edge in wanted(pin) if edge[0] > on]
        shown = [edge for edge in found(pin) if edge[0] > on + US * 10]
        if pin == "rdy":
            expected, shown = without_glitches(expected), without_glitches(shown)
        if [level for _, level in expected] != [level for _, level in shown]:
            return Shown(f"edges of {pin}: {len(expected)} and {len(shown)}", len(steps))
        pin_late = max([pin_late, *(abs(a - b) for (a, _), (b, _) in zip(expected, shown, strict=True))])
    answers = sum(bits[1:8] == [1, 0, 1, 1, 0, 0, 0] for _, bits in heard)  # carriage returns
    return Shown("", len(steps), answers, first, later, answer, pin_late, board.bit)


def converse(emulator: Emulator, seed: int, part: str = "gs-c200s") -> list[Shown]:
    """Play the dialogue of a seed on modules of the model, then on a board for each."""
    random.seed(seed)
    dialogue = BoardDialogue(seed, part)
    dialogue.play()
    return [compare(module, replay(emulator, module, n)) for n, module in enumerate(dialogue.modules.values())]
