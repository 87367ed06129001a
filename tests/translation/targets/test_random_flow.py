"""Random programs with loops, jumps and conditions, written for every target with a flow of its own, and read back."""

from __future__ import annotations

import pytest

from slewline.translation.meaning import (
    Action,
    EndProgram,
    EnterProgram,
    Jump,
    Label,
    LeaveProgram,
    Line,
    Loop,
    MoveBy,
    Profile,
    Program,
    RunProgram,
    SetOutput,
    SetProfile,
)
from slewline.translation.target_writer import WriterOptions
from slewline.translation.writers import TARGETS, target

from .test_flow import drawn

PROFILE = Profile(start=100.0, top=1000.0, time_ps=10**11, steps=55)
FLOWING = [name for name in TARGETS if name != "grbl"]
MOST = 60  # moves
LEVELS = {1: 1, 2: 1, 3: 1}


def moved(action: Action, line: int) -> Action:
    """Return an action of a stored program; what sets an output is a move of so many steps."""
    values = {"line": line, "block": 0}
    match action:
        case SetOutput():
            return MoveBy(distance=action.number + 1, sign=1, profile=PROFILE, **values)
        case Jump():
            return Jump(to=action.to, inputs=action.inputs, **values)
        case Loop():
            return Loop(to=action.to, passes=action.passes, **values)
        case Label():
            return Label(name=action.name, **values)
        case _:
            return EndProgram(**values)


def program(actions: list[Action]) -> Program:
    """Return a program that is entered and run once."""
    inside = [moved(each, line) for line, each in enumerate(actions, 3)]
    last = len(inside) + 3
    rate = SetProfile(line=1, sets="top rate", value=1000.0, profile=PROFILE)
    whole = [rate, EnterProgram(line=2, number=0), *inside, LeaveProgram(line=last), RunProgram(line=last + 1)]
    return Program("cy525", "text", tuple(Line(each.line, "code", actions=(each,)) for each in whole))


def direct(actions: list[Action]) -> tuple[list[int], bool]:
    """Return the moves of a program by its jumps, and whether it has an end."""
    places = {each.name: at for at, each in enumerate(actions) if isinstance(each, Label)}
    counts: dict[int, int] = {}
    moves: list[int] = []
    at = steps = 0
    while at < len(actions) and len(moves) < MOST and steps < 50_000:
        each = actions[at]
        at += 1
        steps += 1
        match each:
            case Jump():
                if all(LEVELS[one.number] == one.level for one in each.inputs):
                    at = places[each.to]
            case Loop():
                counts[at] = (counts.get(at, 0) + 1) % each.passes
                at = places[each.to] if counts[at] else at
            case EndProgram():
                return moves, True
            case SetOutput():
                moves.append(each.number + 1)
    return moves, at >= len(actions)


@pytest.mark.parametrize("nested", [True, False])
@pytest.mark.parametrize("name", FLOWING)
def test_a_program_moves_as_its_jumps_say(name, nested):
    to = target(name)
    levels = " ".join(f"{n}={level}" for n, level in LEVELS.items())
    options = WriterOptions(values={"inputs": levels, "events": str(MOST + 1)})
    compared = 0
    for seed in range(30):
        actions = drawn(seed, nested)
        wanted, ends = direct(actions)
        if not ends and len(wanted) < MOST:
            continue  # it goes round in a circle in which nothing moves
        text = "\n".join(to.joined(line) for line in to.write(program(actions), options).lines)
        found = [each.value for each in to.read_back(text, options).happened if each.kind == "move"]
        if ends:
            assert found == wanted, (seed, text)
        else:
            assert found[: len(wanted)] == wanted, (seed, text)
        compared += len(wanted)
    assert compared > 100
