"""The actions of a program, in the order that the target needs.

For a target that can move only in a stored program, the commands that a host sends to the source are put
into programs, and settings sent before or after the entry of a program go to the head of that program.
For a target that acts immediately, the settings at the head of a program are moved to a place before its
entry, where they take no memory.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from ...core.datasheet.table import Sheet
from ..meaning import (
    Action,
    Delay,
    EnterProgram,
    HostDirective,
    LeaveProgram,
    Line,
    Motion,
    Program,
    RunEndless,
    RunProgram,
    SetDirection,
    SetDistance,
    SetEndless,
    SetOutput,
    SetPosition,
    SetProfile,
    SetTarget,
    WaitInput,
    acts_during_motion,
)

SETTINGS = (SetProfile, SetDistance, SetDirection, SetTarget)
STORABLE = (*SETTINGS, SetEndless, Motion, SetOutput, WaitInput, Delay)


@dataclass(slots=True)
class StreamStep:
    """An action, or a line of the program that has no action.

    `action` is None for a line without an action.  `first` is True if the line's comment belongs to this
    step.
    """

    action: Action | None
    line: Line
    first: bool = False
    moved: str = ""  # reason for the new position


def steps_of(program: Program) -> list[StreamStep]:
    """Return all actions of a program, and its lines without an action, in the order of the text."""
    found = []
    for line in program.lines:
        actions = line.actions or (None,)
        found += [StreamStep(action, line, first=n == 0) for n, action in enumerate(actions)]
    return found


def arranged(program: Program, source: Sheet, sheet: Sheet) -> list[StreamStep]:
    """Return the actions of a program in the order needed by the target `sheet`, a part that stores programs."""
    steps = steps_of(program)
    move = next(iter((*sheet.acting("move"), *sheet.acting("absolute"))), None)
    if move is not None and "i" not in move.when:
        return stored_only(steps)
    rates = next(iter(source.acting("top_rate")), None)
    return hoisted(steps) if rates is not None and "i" not in rates.when else steps


# ------------------------------------------------------------------------------------------------ programs for a module
def stored_only(steps: list[StreamStep]) -> list[StreamStep]:
    """Return the steps, after moving all motions, waits for inputs, delays and outputs into programs."""
    found: list[StreamStep] = []
    pending: list[StreamStep] = []
    over: list[StreamStep] = []  # the wait for the end of a program, after the directives that act while it runs
    program: list[StreamStep] = []  # the last one that the source stores
    replaced = False  # whether another program has been entered since
    number = max((step.action.number for step in steps if isinstance(step.action, EnterProgram)), default=-1)
    at = 0
    while at < len(steps):
        step = steps[at]
        if not (pending or step.action is None or acts_during_motion(step.action)):
            found += over
            over = []
        if step.action is None:
            (pending if pending else found).append(step)
        elif isinstance(step.action, EnterProgram):
            if any(isinstance(each.action, Motion) for each in pending):
                number += 1
                found += [*wrapped(pending, number), *waits(pending)]
                pending = []
            program, at = whole(steps, at, pending)
            replaced = False
            found += program
            pending = []
            continue
        elif getattr(step.action, "implied", False):  # part of a command that the host sends
            (pending if pending else found).append(step)
        elif isinstance(step.action, STORABLE):
            pending.append(step)
        elif isinstance(step.action, SetPosition) and not any(acts(each) for each in pending):
            found.append(step)
        else:
            for moves in programs(pending, step.action):
                number += 1
                found += [*over, *wrapped(moves, number)]
                over, pending, replaced = waits(moves), [], True
            if not acts_during_motion(step.action):
                found += over
                over = []
            if isinstance(step.action, RunProgram) and replaced and program:
                number += 1
                found += again(program, number)
                replaced = False
            else:
                found.append(step)
        at += 1
    if any(acts(each) for each in pending):
        return [*found, *wrapped(pending, number + 1), *waits(pending)]
    return [*found, *over, *pending]


def again(program: list[StreamStep], number: int) -> list[StreamStep]:
    """Return the steps that enter and run a stored program once more, because another program has replaced it."""
    found: list[StreamStep] = []
    for step in program:
        match step.action:
            case EnterProgram():
                found.append(StreamStep(EnterProgram(number=number), Line(0)))
            case LeaveProgram():
                return [*found, StreamStep(LeaveProgram(runs=True), Line(0))]
            case Action():
                found.append(StreamStep(within(step.action, number), step.line))
    return found


def acts(step: StreamStep) -> bool:
    """Return whether a step has an effect of its own, rather than being a setting for a later step."""
    implied = getattr(step.action, "implied", False)
    return isinstance(step.action, STORABLE) and not implied and not isinstance(step.action, (*SETTINGS, SetEndless))


def programs(steps: list[StreamStep], after: Action) -> Iterator[list[StreamStep]]:
    """Yield the steps as one program, or as two if the host's action `after` acts during the last motion.

    If there are several motions, and `after` does not wait for the last one to end, the second program
    begins with that motion.  Nothing is yielded if no step has an effect of its own.
    """
    if not any(acts(each) for each in steps):
        return
    last = max((n for n, each in enumerate(steps) if isinstance(each.action, Motion)), default=0)
    if acts_during_motion(after) and any(isinstance(each.action, Motion) for each in steps[:last]):
        yield steps[:last]
        steps = steps[last:]
    yield steps


def wrapped(steps: list[StreamStep], number: int) -> list[StreamStep]:
    """Return the steps as program `number`, with the commands that begin its entry, end its entry and run it."""
    nowhere = Line(0)
    inside = [replace(each, action=within(each.action, number)) for each in steps]
    last = max((n for n, each in enumerate(steps) if each.action is not None), default=len(steps) - 1) + 1
    enter, leave = StreamStep(EnterProgram(number=number), nowhere), StreamStep(LeaveProgram(runs=True), nowhere)
    return [enter, *inside[:last], leave, *steps[last:]]


def waits(steps: list[StreamStep]) -> list[StreamStep]:
    """Return a wait for the end of a program that has these steps; an empty list if the program is endless."""
    endless = any(isinstance(each.action, RunEndless) and each.action.until is None for each in steps)
    return [] if endless else [StreamStep(HostDirective(text="@until ready"), Line(0))]


def whole(steps: list[StreamStep], at: int, before: list[StreamStep]) -> tuple[list[StreamStep], int]:
    """Return the steps of the program entered at index `at`, and the index of the step that follows them.

    The head of the returned program contains the settings `before`, which preceded the entry of the program.
    It also contains the settings between the end of the entry and the command that runs the program.
    """
    enter = steps[at]
    assert isinstance(enter.action, EnterProgram)  # noqa: S101
    number = enter.action.number
    leave = at + 1
    while leave < len(steps) and not isinstance(steps[leave].action, LeaveProgram):
        leave += 1
    after, trailing = leave + 1, []
    while after < len(steps) and isinstance(steps[after].action, SETTINGS):
        trailing.append(steps[after])
        after += 1
    run = after < len(steps) and isinstance(steps[after].action, RunProgram)
    if not run or (leave < len(steps) and getattr(steps[leave].action, "runs", False)):
        trailing, after = [], leave + 1
    head = [replace(each, action=within(each.action, number)) for each in (*before, *trailing)]
    for each in head[len(before) :]:
        each.moved = "to the head of the program"
    body = steps[at + 1 : leave]
    end = steps[leave : leave + 1]
    if run and end and isinstance(end[0].action, LeaveProgram) and not end[0].action.runs:
        ran = steps[after]
        end = [replace(end[0], action=replace(end[0].action, runs=True)), StreamStep(None, ran.line, ran.first)]
        after += 1
    more = next((each.action for each in steps[after:] if each.action is not None), None)
    if more is not None and not isinstance(more, HostDirective):
        end.append(StreamStep(HostDirective(text="@until ready"), Line(0)))
    return [enter, *head, *body, *end], after


def within(action: Action | None, number: int) -> Action | None:
    """Return a copy of an action, assigned to program `number`; return None if the action is None."""
    return None if action is None else replace(action, block=number)


# ------------------------------------------------------------------------------------------- programs for other parts
def hoisted(steps: list[StreamStep]) -> list[StreamStep]:
    """Return all steps; rate settings at a program's head are moved ahead of the command that begins its entry.

    They are not moved if the body of the program also sets rates.
    """
    found: list[StreamStep] = []
    at = 0
    while at < len(steps):
        step = steps[at]
        found.append(step)
        at += 1
        if not isinstance(step.action, EnterProgram):
            continue
        end = at
        while end < len(steps) and (steps[end].action is None or isinstance(steps[end].action, SetProfile)):
            end += 1
        head, body = (
            steps[at:end],
            [
                each.action
                for each in steps[end:]
                if each.action is not None and each.action.block == step.action.number
            ],
        )
        while head and head[-1].action is None:
            head.pop()
        again = any(isinstance(each, SetProfile) for each in body)
        if not head or again:
            continue
        outside = [
            replace(each, action=None if each.action is None else replace(each.action, block=-1)) for each in head
        ]
        for each in outside:
            each.moved = "before the program, where it takes no memory"
        found[-1:] = [*outside, step]
        at += len(head)
    return found
