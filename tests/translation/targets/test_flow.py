"""The flow of a program as a tree, and in pieces: random programs do the same as with their jumps."""

from __future__ import annotations

import random
from contextlib import suppress

import pytest

from slewline.translation.meaning import Action, EndProgram, Input, Jump, Label, Loop, SetOutput, WaitInput
from slewline.translation.writers.flow import AsLongAs, Forever, Fork, Node, Repeat, Stages, structured
from slewline.translation.writers.pieces import Pieces

MOST = 60  # events of a program without end


class _Enough(Exception):
    """As many events as are compared."""


class _Ended(Exception):
    """The program has ended."""


class World:
    """Events, and inputs whose levels are drawn: the same ones for the same seed and the same order of questions."""

    def __init__(self, seed: int) -> None:
        self.random, self.events, self.idle = random.Random(seed), [], 0

    def goes_on(self) -> None:
        self.idle += 1
        if self.idle > 5_000:  # a loop in which nothing happens
            raise _Enough

    def does(self, what: object) -> None:
        self.idle = 0
        self.events.append(what)
        if len(self.events) >= MOST:
            raise _Enough

    def holds(self, inputs: tuple[Input, ...]) -> bool:
        drawn = self.random.random() < 0.5
        self.does((inputs, drawn))
        return drawn


def direct(actions: list[Action], world: World) -> None:
    """Run a program by its jumps."""
    places = {each.name: at for at, each in enumerate(actions) if isinstance(each, Label)}
    counts: dict[int, int] = {}
    at = 0
    while at < len(actions):
        world.goes_on()
        each = actions[at]
        at += 1
        if isinstance(each, Jump):
            if not each.inputs or world.holds(each.inputs):
                at = places[each.to]
        elif isinstance(each, Loop):
            counts[at] = counts.get(at, 0) + 1
            if counts[at] < each.passes:
                at = places[each.to]
            else:
                counts[at] = 0
        elif isinstance(each, EndProgram):
            return
        elif not isinstance(each, Label):
            world.does(each.number if isinstance(each, SetOutput) else each)


def walk(tree: tuple[Node, ...], world: World) -> None:
    """Run a tree."""
    for node in tree:
        match node:
            case Repeat():
                for _ in range(node.passes):
                    walk(node.body, world)
            case Forever():
                while True:
                    world.goes_on()
                    walk(node.body, world)
            case AsLongAs():
                walk(node.body, world)
                while world.holds(node.inputs):
                    walk(node.body, world)
            case Fork():
                walk(node.then if world.holds(node.inputs) else node.otherwise, world)
            case Stages():
                _states(node, world)
                raise _Ended
            case EndProgram():
                raise _Ended
            case Label():
                pass
            case _:
                world.does(node.number if isinstance(node, SetOutput) else node)


def _states(node: Stages, world: World) -> None:
    counts: dict[int, int] = {}
    at = 0
    while at >= 0:
        world.goes_on()
        state = node.states[at]
        assert state.number == at
        walk(state.body, world)
        if state.inputs:
            at = state.to if world.holds(state.inputs) else state.below
        elif state.passes:
            counts[at] = counts.get(at, 0) + 1
            if counts[at] < state.passes:
                at = state.to
            else:
                counts[at] = 0
                at = state.below
        else:
            at = state.to


def seen(run, seed: int) -> list[object]:
    world = World(seed)
    with suppress(_Enough, _Ended):
        run(world)
    return world.events


def drawn(seed: int, nested: bool) -> list[Action]:
    """Return a random program; `nested`: only with loops and branches that a tree has."""
    rnd = random.Random(seed)
    if nested:
        return _nest(rnd, 3, iter(range(10_000)))
    size = rnd.randrange(4, 12)
    actions: list[Action] = []
    for n in range(size):
        actions.append(Label(name=f"L{n}"))
        kind = rnd.randrange(6)
        if kind == 0:
            actions.append(Jump(to=f"L{rnd.randrange(size)}", inputs=(Input(rnd.randrange(1, 4), 1),)))
        elif kind == 1 and n:
            actions.append(Loop(to=f"L{rnd.randrange(n)}", passes=rnd.randrange(1, 4)))
        elif kind == 2:
            actions.append(Jump(to=f"L{rnd.randrange(size)}"))
        elif kind == 3 and rnd.random() < 0.3:
            actions.append(EndProgram())
        actions.append(SetOutput(number=n, level=1))
    return actions


def _nest(rnd: random.Random, depth: int, names) -> list[Action]:
    actions: list[Action] = []
    for _ in range(rnd.randrange(1, 4)):
        kind = rnd.randrange(6) if depth else 5
        label, inputs = f"N{next(names)}", (Input(rnd.randrange(1, 4), rnd.randrange(2)),)
        inside = _nest(rnd, depth - 1, names) if kind < 5 else []
        if kind == 0:
            actions += [Label(name=label), *inside, Loop(to=label, passes=rnd.randrange(1, 4))]
        elif kind == 1:
            actions += [Label(name=label), *inside, Jump(to=label, inputs=inputs)]
        elif kind == 2:
            actions += [Jump(to=label, inputs=inputs), *inside, Label(name=label)]
        elif kind == 3:
            other = f"N{next(names)}"
            more = _nest(rnd, depth - 1, names)
            actions += [Jump(to=label, inputs=inputs), *inside, Jump(to=other), Label(name=label), *more]
            actions.append(Label(name=other))
        else:
            actions.append(SetOutput(number=rnd.randrange(100), level=1))
    return actions


@pytest.mark.parametrize("nested", [True, False])
def test_a_tree_does_what_the_jumps_do(nested):
    states = 0
    for seed in range(400):
        actions = drawn(seed, nested)
        tree = structured(actions)
        states += isinstance(tree[0], Stages) if tree else 0
        wanted = seen(lambda world, actions=actions: direct(actions, world), seed)
        assert seen(lambda world, tree=tree: walk(tree, world), seed) == wanted, seed
    assert (states == 0) == nested  # what nests becomes a tree; of the others most do not


def test_pieces_do_what_the_jumps_do():
    for seed in range(400):
        actions = drawn(seed, seed % 2 == 0)
        pieces = Pieces(structured(actions), lambda action: ())
        wanted = seen(lambda world, actions=actions: direct(actions, world), seed)
        assert seen(lambda world, pieces=pieces: _pieces(pieces, world), seed) == wanted, seed


def _pieces(pieces: Pieces, world: World) -> None:
    counts: dict[str, int] = {}
    at = "piece0"
    while at:
        world.goes_on()
        if at in pieces.pieces:
            walk(tuple(pieces.pieces[at].body), world)
            at = pieces.pieces[at].then
            continue
        decision = pieces.decisions[at]
        if decision.inputs:
            at = decision.to if world.holds(decision.inputs) else decision.other
            continue
        counts[at] = counts.get(at, 0) + 1
        if counts[at] < decision.passes:
            at = decision.to
        else:
            counts[at] = 0
            at = decision.other


def test_a_wait_is_taken_again_until_its_input_has_the_level():
    wait = WaitInput(input=Input(1, 0))
    pieces = Pieces([wait, SetOutput(number=1, level=1)], lambda action: ())
    (decision,) = pieces.decisions.values()
    assert decision.waits and decision.inputs == (Input(1, 0),)
    assert pieces.pieces["piece0"].then == decision.name
    assert pieces.pieces[decision.to].body == [SetOutput(number=1, level=1)]


def test_a_jump_out_of_a_loop_makes_pieces_and_no_tree():
    actions = [
        Label(name="A"),
        SetOutput(number=1, level=1),
        Jump(to="B", inputs=(Input(1, 1),)),
        Jump(to="A"),
        Label(name="B"),
        SetOutput(number=2, level=1),
    ]
    assert isinstance(structured(actions)[0], Stages)
