"""Facts about a whole program, such as its outputs and inputs, its stored programs, and its maximum rate."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

from ..chips import sheet_of
from ..core.datasheet.table import Sheet
from .host_directives import waits_for_end
from .meaning import (
    Action,
    EnterProgram,
    HostDirective,
    Jump,
    LeaveProgram,
    Loop,
    Motion,
    MoveBy,
    MoveTo,
    Profile,
    Program,
    RunEndless,
    RunProgram,
    SetOutput,
    SetProfile,
    Special,
    Stop,
    WaitInput,
)
from .special_commands import ADD_IT, BRANCHED, BY_HAND, ELSEWHERE, IN_PROGRAM, STOPS_IT, WHILE_IT_RUNS


def profiles(actions: Iterable[Action]) -> list[Profile]:
    """Return the known profiles of the motions; if no motion has one, those of the rate and ramp settings."""
    known = list(actions)
    found = [each.profile for each in known if isinstance(each, Motion) and each.profile]
    return found or [each.profile for each in known if isinstance(each, SetProfile) and each.profile]


def top_rate(actions: Iterable[Action]) -> float:
    """Return the maximum rate of all known profiles, steps/s; 0 if no profile is known."""
    return max((each.top for each in profiles(actions)), default=0.0)


def one_acceleration(actions: Iterable[Action]) -> float:
    """Return one acceleration for all moves, steps/s^2, for a target with only one: the lowest of all ramps.

    If no move has a ramp, the value is so high that the top rate is reached within half a step.
    """
    known = list(actions)
    ramps = [round(each.acceleration, 3) for each in profiles(known) if each.ramped]
    return min(ramps, default=round((top_rate(known) or 1000.0) ** 2))


def variables(actions: Iterable[Action]) -> tuple[bool, bool]:
    """Return whether a relative move has a variable distance, and whether one has a variable direction.

    A distance or direction is variable if it depends on the path that the program takes to the move.
    """
    moves = [each for each in actions if isinstance(each, MoveBy)]
    return any(each.distance is None for each in moves), any(each.sign is None for each in moves)


def stored(program: Program) -> list[int]:
    """Return the numbers of the stored programs, in ascending order."""
    return sorted({each.block for each in program.actions if each.block >= 0})


def runs(program: Program) -> dict[int, int]:
    """Return the numbers of the stored programs that the host runs, keyed by the line of the command.

    The number is -1 if the text has not entered a program before this command.
    """
    found: dict[int, int] = {}
    entered = -1
    for action in program.actions:
        entered = max(entered, action.block, action.number if isinstance(action, EnterProgram) else -1)
        if (isinstance(action, RunProgram) and action.block < 0) or (isinstance(action, LeaveProgram) and action.runs):
            found[action.line] = entered
    return found


def started_plainly(program: Program) -> Program:
    """Return a copy of a program in which host commands that need manual translation are `Special` actions.

    These commands are: loops and branches; directives that drive a pin of the part other than a program
    input; stops while a motion or a program may be running; and commands that run a stored program which the
    text does not contain.  Commands that run a stored program of the text remain unchanged.
    """
    its, sheet = runs(program), sheet_of(program.part)
    pins = [pin.name for pin in sheet.pins if pin.role and not pin.role.startswith("input")]
    steering = re.compile(rf"@(?:drive|pulse|release)\s+(?:\w+\.)?({'|'.join(pins)})\b")
    running = False

    def plain(action: Action) -> Action:
        nonlocal running
        if isinstance(action, Stop) and running:
            running = False
            return Special.of(action, STOPS_IT, WHILE_IT_RUNS)
        running = isinstance(action, Motion | RunProgram) or getattr(action, "runs", running)
        if isinstance(action, HostDirective) and waits_for_end(action.text, sheet):
            running = False
        if action.block < 0 and isinstance(action, Jump | Loop):
            return Special.of(action, BRANCHED, IN_PROGRAM)
        if isinstance(action, HostDirective) and (pin := steering.match(action.text)):
            return Special.of(action, f"drives {pin[1]} of the {sheet.part.upper()}", BY_HAND)
        if isinstance(action, RunProgram) and its.get(action.line, 0) < 0:
            return Special.of(action, ELSEWHERE, ADD_IT)
        return action

    lines = [replace(line, actions=tuple(map(plain, line.actions))) for line in program.lines]
    return replace(program, lines=tuple(lines))


def axes(program: Program) -> list[int]:
    """Return the numbers of the axes that the program moves, counted from 1."""
    return sorted({each.axis for each in program.actions}) or [1]


def outputs(program: Program) -> list[tuple[int, int]]:
    """Return the number of each output that the program sets, and its level after a reset of the source.

    The level is 0 if it is not known.
    """
    used = sorted({each.number for each in program.actions if isinstance(each, SetOutput) and not each.implied})
    return [(each, _reset_level(program, each)) for each in used]


def _reset_level(program: Program, output: int) -> int:
    about = f"output {output} ("
    return int(any(each.about.startswith(about) and each.value.startswith("high") for each in program.assumed))


def inputs(program: Program) -> list[int]:
    """Return the numbers of the inputs that the program waits for or branches on, or that end its motions."""
    found = {each.input.number for each in program.actions if isinstance(each, WaitInput)}
    found |= {each.number for action in program.actions if isinstance(action, Jump) for each in action.inputs}
    found |= {each.until.number for each in program.actions if isinstance(each, RunEndless) and each.until}
    return sorted(found)


def counts_positions(program: Program) -> bool:
    """Return whether a program has relative and absolute moves, so that the position counter's limits matter."""
    actions = list(program.actions)
    return all(any(isinstance(action, kind) for action in actions) for kind in (MoveBy, MoveTo))


def counter_of(sheet: Sheet) -> tuple[int, int] | None:
    """Return the lowest and the highest position that the command for a move to a position accepts.

    They are the limits of the position counter.  The result is None if the part has no such command.
    """
    row = next((row for role in ("absolute", "goto", "target") for row in sheet.acting(role)), None)
    return None if row is None else (row.args[0].low, row.args[0].high)
