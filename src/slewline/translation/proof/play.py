"""Runs a text with one of our parts on a bench, and returns a trace.

In a proof, no signals are connected to the inputs.  So an input that the program waits for begins at
the level opposite to the expected one, and all other inputs are open.  Whenever the part has waited for
longer than any delay of the program, one of the inputs tested by the program is changed.  For source and
result, the same inputs are changed in the same order, so that both take the same branches.  If the text
itself drives inputs, no others are changed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ...bench import Bench
from ...bench.memories import put_memory
from ...bench.scripts.program_file import program_script
from ...bench.scripts.script import check_script, run_script
from ...chips import sheet_of
from ...core.time.timebase import PS_PER_S
from ...errors import Timeout
from ...parts.hosts.packet_host import PacketHost
from ..target_writer import Happened, PlayedTrace

if TYPE_CHECKING:
    from ...core.chip import Chip

SLICE_PS = PS_PER_S // 2
MOST_PS = 3600 * PS_PER_S  # virtual time
ENDLESS_PS = 100 * PS_PER_S
MOST_CHANGES = 16  # maximum number of input changes
MOST_MOVES = 200
MOST_STEPS = 3_000_000


@dataclass(frozen=True, slots=True)
class Scene:
    """The surroundings of the parts in a proof, the same for source and result.

    Attributes:
        inputs: the numbers of the inputs that change while a part waits.
        start: pairs of an input's number and its level at the start; all other inputs are open.
        quiet_ps: the time without an event after which a part counts as waiting, ps.
        moves: the number of moves after which a run is cut off.
        endless: whether the program has an endless motion; its run is cut off after a long time with no
            event except steps.
    """

    inputs: tuple[int, ...] = ()
    start: tuple[tuple[int, int], ...] = ()
    quiet_ps: int = 2 * PS_PER_S
    moves: int = MOST_MOVES
    endless: bool = False


@dataclass(slots=True)
class Played:
    """The run of a program: its trace, and the bench and the part on which it ran."""

    trace: PlayedTrace
    bench: Bench
    chip: Chip
    started: dict[int, int] = field(default_factory=dict)  # levels of outputs at the start


def play(
    text: str, part: str, where: str, scene: Scene, wiring: Sequence[tuple[str, str]], crystal_hz: int | None = None
) -> Played:
    """Run a text with a part on a new bench, and return the run.

    Args:
        where: the name of the text in messages.
        wiring: pairs of a pin's purpose, such as "output1", and the pin's name.
        crystal_hz: the crystal of the part, Hz; None: its usual crystal.

    Raises:
        ProgramError: a line cannot be sent by a host.
    """
    sheet = sheet_of(part)
    bench = Bench()
    crystal = None if crystal_hz is None else f"{crystal_hz} Hz"
    chip = bench.add(part, name="x", crystal=crystal, straps=sheet.fastest | sheet.plain)
    put_memory(bench, chip)
    host = bench.host(chip)
    if isinstance(host, PacketHost):
        host.port.sparse = True  # the status queries are not observed
    script = program_script(text, where, sheet)
    check_script(bench, host, script)
    outputs, inputs = numbered(wiring, "output"), numbered(wiring, "input")
    bench.record(*(f"x.{name}" for name in outputs.values()))
    for number, level in scene.start:
        if number in inputs:
            chip.pin(inputs[number]).drive(level)
    run_script(bench, host, script)
    changes, stopped = passed(bench, chip, scene, inputs)
    happened, levels = record_of(bench, chip, outputs)
    return Played(trace_of(part, [*happened, *changes], stopped), bench, chip, levels)


def numbered(wiring: Sequence[tuple[str, str]], kind: str) -> dict[int, str]:
    """Return the pin names of the outputs or of the inputs, by number; `kind` is "output" or "input"."""
    return {int(role[-1]): name for role, name in wiring if role.startswith(kind) and name}


def record_of(bench: Bench, chip: Chip, outputs: Mapping[int, str]) -> tuple[list[Happened], dict[int, int]]:
    """Return a part's motions and output changes, and its output levels at the start, by output number.

    Args:
        outputs: the names of the recorded output pins, by output number.
    """
    levels: dict[int, int] = {}
    happened = moves(chip)
    for number, name in outputs.items():
        times, values = bench.edges(f"{chip.name}.{name}")
        levels[number] = chip.sheet.pin(name).reset or 0
        happened += [
            Happened("output", number, int(value), int(ps)) for ps, value in zip(times, values, strict=True) if ps > 0
        ]
    return happened, levels


def trace_of(part: str, happened: list[Happened], stopped: bool) -> PlayedTrace:
    """Return the events of a part as a trace, in order of time; `stopped` is True if the run was cut off."""
    order = {"input": 0, "output": 1, "move": 2, "run": 2, "delay": 3}
    in_order = sorted(happened, key=lambda each: (each.time_ps or 0, order[each.kind]))
    return PlayedTrace(f"the model of the {part}", tuple(in_order), stopped)


def passed(bench: Bench, chip: Chip, scene: Scene, inputs: dict[int, str]) -> tuple[list[Happened], bool]:
    """Let time pass until the run ends or is cut off, changing an input whenever the part waits.

    Returns:
        The input changes, and whether the run was cut off.
    """
    changes: list[Happened] = []
    levels = {n: chip.pin(inputs[n]).level for n in scene.inputs if n in inputs} | dict(scene.start)
    active, after = bench.now_ps, made(chip)
    began, seen = bench.now_ps, (len(chip.motions()), *after[1:])  # the last event besides steps
    while bench.now_ps < MOST_PS:
        before = after
        try:
            bench.run_until_idle(f"{SLICE_PS} ps")
            return changes, False
        except Timeout:
            after = made(chip)
        if after != before or chip.axis(1).motor.moving:
            active = bench.now_ps
        if seen != (seen := (len(chip.motions()), *after[1:])):
            began = bench.now_ps
        if scene.endless and bench.now_ps - began > ENDLESS_PS:
            return changes, True
        if after[0] > MOST_STEPS or len(chip.motions()) > scene.moves:
            return changes, True
        if bench.now_ps - active <= scene.quiet_ps:
            continue
        if len(changes) >= MOST_CHANGES or not levels:
            return changes, True
        number = scene.inputs[len(changes) % len(scene.inputs)]
        levels[number] = 0 if levels.get(number) else 1
        changes.append(Happened("input", number, levels[number] or 0, bench.now_ps))
        if number in inputs:
            chip.pin(inputs[number]).drive(levels[number] or 0)
        active, after = bench.now_ps, made(chip)
    return changes, True


def made(chip: Chip) -> tuple[int, ...]:
    """Return the total number of steps made by all axes of a part, followed by the levels of its outputs."""
    outputs = (pin.name for pin in chip.sheet.pins if pin.in_out in ("out", "both") and pin.role.startswith("output"))
    steps = [chip.axis(n).motor.made for n in range(1, chip.sheet.axes + 1)]
    return (sum(steps), *(chip.pin(name).level or 0 for name in outputs))


def moves(chip: Chip) -> list[Happened]:
    """Return the ended motions of a part as events: "move" if the end was reached, "run" if stopped."""
    found = []
    for number in range(1, chip.sheet.axes + 1):
        axis = chip.axis(number)
        for motion in axis.motions():
            if motion.end is None:
                continue
            steps = axis.steps(motion.time_ps or None, motion.end.time_ps)
            if not len(steps):
                continue
            times = steps.times_ps
            gaps = times[1:] - times[:-1]
            net = int(steps.directions.sum())
            rate = float(PS_PER_S / gaps.min()) if len(gaps) else None
            first, lasts = int(times[0]), int(times[-1] - times[0])
            if motion.end.why == "done":
                found.append(Happened("move", number, net, motion.time_ps, lasts, rate, first))
            else:
                found.append(Happened("run", number, 1 if net > 0 else -1, motion.time_ps, None, rate, net=net))
    return found
