"""Source and result run, and are compared with the report."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ..meaning import Delay, HostDirective, Jump, Motion, Program, SetProfile, WaitInput
from ..own.part_writer import linted
from ..target_writer import PlayedTrace
from ..translation_report import Report
from ..writers import TARGETS, target
from .compare_runs import Compared, StatedBounds, compared
from .play import Played, Scene, play

if TYPE_CHECKING:
    from ..translate import Translation

EXTRA_PS = 2 * 10**12
LEAST_EVENTS, MORE_EVENTS = 100, 4


@dataclass(frozen=True, slots=True)
class Proof:
    """What a proof found.

    Attributes:
        source, result: the runs; None: not run.
        compared: how they differ; None: the target cannot be run here.
        by: what ran the result.
        lint: errors of the linter in the result.
    """

    source: Played
    result: Played | None
    trace: PlayedTrace | None
    compared: Compared | None
    by: str
    lint: tuple[str, ...] = ()

    @property
    def proven(self) -> bool:
        """Whether the result was run, and did what the report states."""
        return self.compared is not None and self.compared.proven and not self.lint


def prove(done: Translation) -> Proof:
    """Run source and result of a translation, and compare them.

    Raises:
        ProgramError: a line that no host can send.
    """
    program, report = done.program, done.report
    scene = scene_of(program)
    theirs = [(role, name) for role, name in program.wiring.items()]
    source = play(done.source, program.part, program.where, scene, theirs, done.source_hz)
    if report.to in TARGETS:
        other = target(report.to)
        options = replace(done.options, values={**done.options.values, **around(scene, source)})
        trace = other.ran(done.text, options) or other.read_back(done.text, options)
        if trace is None:
            return Proof(source, None, None, None, "not run")
        return Proof(source, None, trace, compared(source.trace, trace, bounds_of(program, report)), trace.ran)
    mine = [(role, name) for role, _, name in report.wiring]
    result = play(done.text, report.to, f"{program.where} for {report.to}", scene, mine, done.options.crystal_hz)
    wired = [int(role[-1]) for role, name in mine if role.startswith("output") and name]
    levels = ({n: source.started[n] for n in source.started if n in wired}, result.started)
    found = compared(source.trace, result.trace, bounds_of(program, report), levels, wired)
    return Proof(source, result, result.trace, found, result.trace.ran, tuple(linted(done.text, report.to)))


def around(scene: Scene, source: Played) -> dict[str, str]:
    """Return what surrounds a program that is read back: its inputs change as those of the source do."""
    found = {
        "waits": " ".join(map(str, scene.inputs)),
        "inputs": " ".join(f"{number}={level}" for number, level in scene.start),
    }
    if source.trace.stopped:  # no more of the result is compared, delays and all
        found["events"] = str(LEAST_EVENTS + MORE_EVENTS * len(source.trace.happened))
    return found


def scene_of(program: Program) -> Scene:
    """Return what surrounds the parts: the inputs that the program tests, and how long it may do nothing."""
    inputs = {action.input.number for action in program.actions if isinstance(action, WaitInput)}
    inputs |= {one.number for action in program.actions if isinstance(action, Jump) for one in action.inputs}
    driven = any(
        isinstance(action, HostDirective) and action.text.startswith(("@drive", "@pulse")) for action in program.actions
    )
    longest = max((action.time_ps for action in program.actions if isinstance(action, Delay)), default=0)
    if driven:
        return Scene(quiet_ps=2 * longest + EXTRA_PS)
    start: dict[int, int] = {}
    for action in program.actions:
        if isinstance(action, WaitInput):
            start.setdefault(action.input.number, 1 - action.input.level)
    return Scene(tuple(sorted(inputs)), tuple(start.items()), 2 * longest + EXTRA_PS)


def bounds_of(program: Program, report: Report) -> StatedBounds:
    """Return what a report states: the greatest difference of the time of a motion, and of a rate."""
    moving = {action.line for action in program.actions if isinstance(action, Motion)}
    rates = {action.line for action in program.actions if isinstance(action, SetProfile) and action.sets != "ramp"}
    offs = [(line.number, verdict.off) for line in report.lines for verdict in line.verdicts]
    time = max((off for number, off in offs if number in moving), default=0.0)
    rate = max((off for number, off in offs if number in rates), default=0.0)
    tops = [
        each.profile.top
        for each in program.actions
        if isinstance(each, SetProfile | Motion) and each.profile is not None
    ]
    return StatedBounds(time, rate, max(tops, default=float("inf")) * (1 + rate))
