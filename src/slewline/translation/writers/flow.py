"""The flow of a program as a tree, for languages that have loops and branches but no jumps.

    A:  move       Repeat 3 times
        L 3,A  ->      move

An endless loop is `Forever`; a loop that repeats while inputs have given levels is `AsLongAs`.  A
forward jump that depends on inputs is a `Fork` around the skipped actions.

Jumps that do not nest become `Stages`: numbered pieces of the program, each of which selects the next.
A writer converts the pieces to a loop that contains one branch per piece.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count

from ..meaning import Action, EndProgram, Input, Jump, Label, Loop, RunProgram

START = ""  # the label at the start of a stored program, used by RunProgram


@dataclass(frozen=True)
class Repeat:
    """A loop, from source line `head` to source line `line`, that runs `body` a given number of times."""

    passes: int
    body: tuple[Node, ...]
    head: int = 0
    line: int = 0


@dataclass(frozen=True)
class Forever:
    """An endless loop of `body`."""

    body: tuple[Node, ...]
    head: int = 0
    line: int = 0


@dataclass(frozen=True)
class AsLongAs:
    """A loop that runs `body` and repeats it while all inputs have their given levels at the end of a pass."""

    inputs: tuple[Input, ...]
    body: tuple[Node, ...]
    head: int = 0
    line: int = 0


@dataclass(frozen=True)
class Fork:
    """A branch: `then` if all inputs have their given levels, else `otherwise`; one of the two may be empty."""

    inputs: tuple[Input, ...]
    then: tuple[Node, ...]
    otherwise: tuple[Node, ...]
    line: int = 0


@dataclass(frozen=True)
class Stage:
    """A piece of a program, and the rule that selects the piece that follows it.

    Attributes:
        number: the number of the piece.
        body: the actions of the piece.
        to: the number of the piece that normally follows; -1: the program ends.
        below: the number of the piece that follows if `to` does not; -1: the program ends.
        inputs: if not empty, `to` follows only if all these inputs have their given levels.
        passes: if not 0, `to` follows only until this piece has been run `passes` times.
        line: the line of the source.
    """

    number: int
    body: tuple[Action, ...]
    to: int
    below: int = -1
    inputs: tuple[Input, ...] = ()
    passes: int = 0
    line: int = 0


@dataclass(frozen=True)
class Stages:
    """The pieces of a program, in source order; the first one is run first, and each one selects its successor."""

    states: tuple[Stage, ...]
    line: int = 0


Node = Action | Repeat | Forever | AsLongAs | Fork | Stages


class _NotNested(Exception):
    """The error for a jump into or out of a loop, which a tree of loops and branches cannot express."""


def structured(actions: Sequence[Action]) -> tuple[Node, ...]:
    """Return a program as a tree: loops and branches that contain its actions, without any labels or jumps."""
    items: list[Action] = [Label(name=START, line=actions[0].line if actions else 0)]
    items += [
        Jump(to=each.at, line=each.line, text=each.text) if isinstance(each, RunProgram) else each for each in actions
    ]
    wanted = Counter(each.to for each in items if isinstance(each, Jump | Loop))
    try:
        tree = _nested(items, wanted)
        if +wanted:
            raise _NotNested
    except _NotNested:
        return (_pieces(items),)
    return tree


def _nested(items: list[Action], wanted: Counter[str]) -> tuple[Node, ...]:
    """Return the tree for a part of a program, and update `wanted`.

    `wanted` holds the number of jumps to each label; the jumps that the tree replaces are subtracted.
    """
    out: list[Node] = []
    place = 0
    while place < len(items):
        item = items[place]
        if isinstance(item, Label):
            last = max((at for at in range(place + 1, len(items)) if _leads_to(items[at], item.name)), default=None)
            if last is None:
                place += 1
                continue
            out.append(_loop(items[place:last], items[last], wanted))
            place = last + 1
        elif isinstance(item, Loop):
            raise _NotNested
        elif isinstance(item, Jump):
            node, place = _branch(items, place, wanted)
            out.append(node)
        else:
            out.append(item)
            place += 1
    return tuple(out)


def _leads_to(item: Action, label: str) -> bool:
    return isinstance(item, Jump | Loop) and item.to == label


def _loop(inside: list[Action], back: Action, wanted: Counter[str]) -> Node:
    """Return the loop that the jump `back` makes; `inside` lists the actions from its label up to the jump."""
    assert isinstance(back, Jump | Loop)  # noqa: S101
    wanted[back.to] -= 1
    head = inside[0].line
    # Other backward jumps to the same label make inner loops.
    body = _nested(inside if any(_leads_to(each, back.to) for each in inside) else inside[1:], wanted)
    if isinstance(back, Loop):
        return Repeat(back.passes, body, head, back.line)
    return AsLongAs(back.inputs, body, head, back.line) if back.inputs else Forever(body, head, back.line)


def _branch(items: list[Action], place: int, wanted: Counter[str]) -> tuple[Node, int]:
    """Return the branch made by the forward jump at index `place`, and the index of the first action after it."""
    jump = items[place]
    assert isinstance(jump, Jump)  # noqa: S101
    target = next((at for at in range(place + 1, len(items)) if _is_label(items[at], jump.to)), None)
    if target is None or not jump.inputs:
        raise _NotNested
    wanted[jump.to] -= 1
    left_out = items[place + 1 : target]
    over = left_out[-1] if left_out else None
    if isinstance(over, Jump) and not over.inputs:  # ... skip the target of the first jump
        end = next((at for at in range(target + 1, len(items)) if _is_label(items[at], over.to)), None)
        if end is not None:
            wanted[over.to] -= 1
            then, otherwise = items[target + 1 : end], left_out[:-1]
            return Fork(jump.inputs, _nested(then, wanted), _nested(otherwise, wanted), jump.line), end
    return Fork(jump.inputs, (), _nested(left_out, wanted), jump.line), target


def _is_label(item: Action, name: str) -> bool:
    return isinstance(item, Label) and item.name == name


# -------------------------------------------------------------------------------------------------------------- pieces
def _pieces(items: list[Action]) -> Stages:
    """Return a program's pieces: a new piece begins after each jump, and at each label that is jumped to."""
    wanted = {each.to for each in items if isinstance(each, Jump | Loop)}
    begins: list[tuple[list[Action], Action | None]] = []
    number: dict[str, int] = {}
    body: list[Action] = []

    def close(end: Action | None) -> None:
        nonlocal body
        begins.append((body, end))
        body = []

    for item in items:
        if isinstance(item, Label):
            if body and item.name in wanted:
                close(None)
            number[item.name] = len(begins)
        elif isinstance(item, Jump | Loop | EndProgram):
            close(item)
        else:
            body.append(item)
    close(None)
    states = []
    for here, (does, end) in enumerate(begins):
        after = here + 1 if here + 1 < len(begins) else -1
        line = end.line if end else does[-1].line if does else 0
        if isinstance(end, Jump):
            to, below = number[end.to], after if end.inputs else -1
            states.append(Stage(here, tuple(does), to, below, end.inputs, line=line))
        elif isinstance(end, Loop):
            states.append(Stage(here, tuple(does), number[end.to], after, passes=end.passes, line=line))
        else:
            states.append(Stage(here, tuple(does), -1 if end else after, line=line))
    return Stages(tuple(states), items[0].line)


def nodes(tree: Sequence[Node]) -> list[Node]:
    """Return all nodes of a tree; each loop or branch is followed by the nodes inside it."""
    out: list[Node] = []
    for node in tree:
        out.append(node)
        if isinstance(node, Repeat | Forever | AsLongAs):
            out += nodes(node.body)
        elif isinstance(node, Fork):
            out += nodes(node.then) + nodes(node.otherwise)
        elif isinstance(node, Stages):
            out += [action for state in node.states for action in state.body]
    return out


def counters() -> count[int]:
    """Return an iterator over the numbers 1, 2 ..., which make generated names distinct."""
    return count(1)
