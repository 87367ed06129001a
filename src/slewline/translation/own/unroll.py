"""Stored programs as host commands, for a part that stores no program: a loop becomes one set of lines per pass.

Positions are tracked, since such a part makes only moves to positions.  The position is assumed to be 0 at the start;
after a motion that may have ended early, it is unknown.  A branch on an input cannot be unrolled, and neither can a
program that restarts forever; both are left unchanged, and the writer reports them.
"""

from __future__ import annotations

from dataclasses import replace

from ...core.datasheet.table import Sheet
from ..host_directives import ends_motion
from ..meaning import (
    Action,
    EndProgram,
    EnterProgram,
    Home,
    HostDirective,
    Jump,
    Label,
    LeaveProgram,
    Loop,
    Motion,
    MoveBy,
    MoveTo,
    RunEndless,
    RunProgram,
    SetPosition,
    Stop,
)
from .line_stream import StreamStep

ENTERED = "the host sends the commands of the program where it is run"


def unrolled(steps: list[StreamStep], most: int, source: Sheet, interrupted: bool) -> list[StreamStep]:
    """Return the steps with each stored program replaced by host commands where it is run.

    Args:
        most: the maximum number of lines to which a program is unrolled.
        source: the data sheet of the source.
        interrupted: whether something outside the program may end a motion early.
    """
    blocks: dict[int, list[StreamStep]] = {}
    for step in steps:
        if step.action is not None and step.action.block >= 0:
            blocks.setdefault(step.action.block, []).append(step)
    found: list[StreamStep] = []
    current = -1
    for step in steps:
        action = step.action
        if isinstance(action, EnterProgram):
            current = action.number
        elif isinstance(action, LeaveProgram):
            if action.runs:
                found += executed(blocks.get(current, []), "", most)
        elif isinstance(action, RunProgram):
            found += executed(blocks.get(current, []), action.at, most)
        elif action is None or action.block < 0:
            found.append(step)
            continue
        else:
            continue
        found.append(StreamStep(None, step.line, step.first, ENTERED))
    kept = {step.line.number for step in found if step.first}
    left = [step for step in steps if step.first and step.line.comment and step.line.number not in kept]
    return followed([*found, *(StreamStep(None, step.line, True) for step in left)], source, interrupted)


def executed(block: list[StreamStep], at: str, most: int) -> list[StreamStep]:
    """Return the steps that a program executes, in order, from the label `at`; from its start if `at` is empty."""
    places = {step.action.name: n for n, step in enumerate(block) if isinstance(step.action, Label)}
    counts: dict[int, int] = {}
    found: list[StreamStep] = []
    seen: set[int] = set()
    pc = places.get(at, 0)
    while pc < len(block):
        step, here = block[pc], pc
        action = step.action
        pc += 1
        if isinstance(action, EndProgram):
            found.append(outside(step, here, seen))
            break
        if isinstance(action, Loop):
            counts[here] = counts.get(here, 0) + 1
            if counts[here] < action.passes and action.to in places:
                if len(found) > most:
                    found.append(outside(step, here, seen))
                    break
                pc = places[action.to]
                continue
            counts[here] = 0
            found.append(StreamStep(None, step.line, step.first and here not in seen))
        elif isinstance(action, Jump):
            found.append(outside(step, here, seen))
            if not action.inputs:
                break
        elif not isinstance(action, Label):
            found.append(outside(step, here, seen))
        seen.add(here)
    return found


def outside(step: StreamStep, here: int, seen: set[int]) -> StreamStep:
    """Return a step of a stored program as a host command.

    Its comment is left out if the step has been executed before, that is, if its index `here` is in `seen`.
    """
    action: Action | None = step.action
    return StreamStep(None if action is None else replace(action, block=-1), step.line, step.first and here not in seen)


def followed(steps: list[StreamStep], source: Sheet, interrupted: bool) -> list[StreamStep]:
    """Return the steps with each relative move from a known position replaced by a move to a position."""
    found: list[StreamStep] = []
    position: int | None = 0
    for step in steps:
        action = step.action
        if isinstance(action, SetPosition):
            position = action.position
        elif isinstance(action, MoveTo):
            action = replace(action, begins=position)
            position = action.position
        elif isinstance(action, MoveBy):
            goal = None if position is None or action.steps is None else position + action.steps
            if goal is not None:
                action = MoveTo(
                    line=action.line,
                    text=action.text,
                    axis=action.axis,
                    profile=action.profile,
                    begins=position,
                    position=goal,
                )
            position = goal
        elif isinstance(action, Home):
            position = 0
        elif isinstance(action, Stop | RunEndless) or (
            isinstance(action, HostDirective) and ends_motion(action.text, source)
        ):
            position = None
        if interrupted and isinstance(action, Motion):
            position = None
        found.append(replace(step, action=action))
    return found
