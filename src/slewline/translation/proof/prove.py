"""Runs source and result of a translation, and compares them within the bounds in its report."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ...chips import sheet_of
from ..meaning import (
    Action,
    Delay,
    HostDirective,
    Jump,
    LeaveProgram,
    Motion,
    Program,
    RunEndless,
    RunProgram,
    SetOutput,
    SetProfile,
    WaitInput,
)
from ..own.part_writer import linted
from ..target_writer import PlayedTrace
from ..translation_report import Report
from ..writers import TARGETS, target
from .compare_runs import Compared, StatedBounds, compared
from .play import Played, Scene, play

if TYPE_CHECKING:
    from ..translate import Translation

EXTRA_PS = 2 * 10**12
COMMAND_PS = 25 * 10**9  # time that parts need for commands between two motions, plus a step at a low rate
EXCHANGE_PS = 10**12 // 4  # the same time, if a host sends each command
LONG, LONG_BESIDES = 4, 3000  # ramps, and steps, of a move that reaches its rate on both sides
LEAST_EVENTS, MORE_EVENTS = 100, 4


@dataclass(frozen=True, slots=True)
class Proof:
    """The result of a proof.

    Attributes:
        source, result: the runs on a bench; None: not run on a bench.
        compared: the comparison of the runs; None: the target cannot be run here.
        by: the name of the interpreter that ran the result.
        lint: the linter's errors in the result.
    """

    source: Played
    result: Played | None
    trace: PlayedTrace | None
    compared: Compared | None
    by: str
    lint: tuple[str, ...] = ()

    @property
    def proven(self) -> bool:
        """True if the result was run, agrees with the source within the report's bounds, and has no linter errors."""
        return self.compared is not None and self.compared.proven and not self.lint


def prove(done: Translation, source: Played | None = None) -> Proof:
    """Run source and result of a translation, and compare them.

    Args:
        source: an earlier run of the source; None: the source is run here.

    Raises:
        ProgramError: a line cannot be sent by a host.
    """
    program, report = done.program, done.report
    scene = scene_of(program)
    source = source or played(program, done.source, done.source_hz)
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


def played(program: Program, text: str, crystal_hz: int | None = None) -> Played:
    """Return a run of the source of a translation.

    Args:
        program: the source as a `Program`: its lines, each with the actions that it causes.
        text: the text of the source.
        crystal_hz: the crystal of the source's part, Hz; None: its usual crystal.

    Raises:
        ProgramError: a line cannot be sent by a host.
    """
    return play(text, program.part, program.where, scene_of(program), list(program.wiring.items()), crystal_hz)


def around(scene: Scene, source: Played) -> dict[str, str]:
    """Return the settings, as text, with which the result of a translation is read back.

    They make the inputs of the result change in the same way as the inputs of the source.  If the run of the
    source was cut off, they also limit the number of events.
    """
    found = {
        "waits": " ".join(map(str, scene.inputs)),
        "inputs": " ".join(f"{number}={level}" for number, level in scene.start),
    }
    if source.trace.stopped:  # nothing more of the result is compared, not even delays
        found["events"] = str(LEAST_EVENTS + MORE_EVENTS * len(source.trace.happened))
    return found


def scene_of(program: Program) -> Scene:
    """Return the surroundings for a proof of a program, such as the inputs that change while a part waits."""
    inputs = {action.input.number for action in program.actions if isinstance(action, WaitInput)}
    inputs |= {one.number for action in program.actions if isinstance(action, Jump) for one in action.inputs}
    driven = any(
        isinstance(action, HostDirective) and action.text.startswith(("@drive", "@pulse")) for action in program.actions
    )
    endless = any(isinstance(action, RunEndless) for action in program.actions)
    longest = max((action.time_ps for action in program.actions if isinstance(action, Delay)), default=0)
    if driven:
        return Scene(quiet_ps=2 * longest + EXTRA_PS, endless=endless)
    start: dict[int, int] = {}
    for action in program.actions:
        if isinstance(action, WaitInput):
            start.setdefault(action.input.number, 1 - action.input.level)
    return Scene(tuple(sorted(inputs)), tuple(start.items()), 2 * longest + EXTRA_PS, endless=endless)


def bounds_of(program: Program, report: Report) -> StatedBounds:
    """Return the bounds for a comparison, such as the greatest differences in times and rates in the report."""
    moving = {action.line for action in program.actions if isinstance(action, Motion)}
    rates = {action.line for action in program.actions if isinstance(action, SetProfile) and action.sets != "ramp"}
    delays = {action.line for action in program.actions if isinstance(action, Delay)}
    offs = [(line.number, verdict.off) for line in report.lines for verdict in line.verdicts]
    time, rate, pause = (
        max((off for line, off in offs if line in those), default=0.0) for those in (moving, rates, delays)
    )
    profiles = [
        each.profile for each in program.actions if isinstance(each, SetProfile | Motion) and each.profile is not None
    ]
    return StatedBounds(
        time,
        rate,
        max((each.top for each in profiles), default=float("inf")) * (1 + rate),
        pause,
        COMMAND_PS if report.to in TARGETS or sheet_of(report.to).enter is not None else EXCHANGE_PS,
        hosted(program),
        max(sum(runs_it(action) for action in program.actions if action.block < 0), 1),
        max((LONG * each.steps for each in profiles), default=0.0) + LONG_BESIDES,
    )


def hosted(program: Program) -> int | None:
    """Return the number of events that host commands cause before the host runs a stored program.

    The result is None if host commands also cause events after such a run, or if no stored program is run.
    """
    found, ran = 0, False
    for action in program.actions:
        if runs_it(action):
            ran = True
        elif action.block < 0 and isinstance(action, Motion | SetOutput | WaitInput):
            if ran:
                return None
            found += 1
    return found if ran else None


def runs_it(action: Action) -> bool:
    """Return whether a command runs a stored program."""
    return isinstance(action, RunProgram) or (isinstance(action, LeaveProgram) and action.runs)
