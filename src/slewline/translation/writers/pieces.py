"""A program cut into pieces at waits and branches, for a language whose macros are evaluated before they run.

A piece contains actions without a wait; a decision is made when all motion has ended, and selects the piece or
decision that follows.  Empty pieces are left out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from ..meaning import EndProgram, Input, LeaveProgram, RunProgram, WaitInput
from .flow import AsLongAs, Forever, Fork, Node, Repeat, Stage, Stages

END = ""


@dataclass
class Portion:
    """A piece: actions without a wait, and the name of the piece or decision that follows, or END if none does."""

    name: str
    body: list[Node] = field(default_factory=list)
    then: str = END


@dataclass(frozen=True)
class Decision:
    """A decision about which piece or decision follows.

    Attributes:
        inputs: `to` follows if all these inputs have their given levels, otherwise `other`.
        waits: whether the decision is repeated until the inputs have these levels.
        passes: for a decision without inputs, the number of passes of a loop: `other` follows after the last
            pass, `to` after each earlier one.
        counter: the name of the variable that counts the passes.
        line: the line of the source.
    """

    name: str
    to: str
    other: str = END
    inputs: tuple[Input, ...] = ()
    waits: bool = False
    passes: int = 0
    counter: str = ""
    line: int = 0


def simple(node: Node) -> bool:
    """Return whether a node fits into one piece: it has no wait or decision, and does not run or end a program."""
    if isinstance(node, Repeat):
        return all(simple(each) for each in node.body)
    runs_one = isinstance(node, RunProgram) or (isinstance(node, LeaveProgram) and node.runs)
    return not isinstance(node, Forever | AsLongAs | Fork | Stages | WaitInput | EndProgram) and not runs_one


class Pieces:
    """Pieces of a program, and the decisions between them.

    Args:
        tree: the tree of the program that is cut into pieces.
        program: a function that returns the tree of the stored program that a given command runs.
        prefix: the prefix for the names of decisions.
    """

    def __init__(
        self, tree: Sequence[Node], program: Callable[[RunProgram | LeaveProgram], Sequence[Node]], prefix: str = ""
    ) -> None:
        self.pieces: dict[str, Portion] = {}
        self.decisions: dict[str, Decision] = {}
        self._program, self._prefix = program, prefix
        self._flow(tree, self._piece(), END, END)
        self._tidy()

    # ---------------------------------------------------------------------------------------------------------- making
    def _piece(self) -> str:
        name = f"piece{len(self.pieces)}"
        self.pieces[name] = Portion(name)
        return name

    def _decision(self, **values: object) -> str:
        name = f"{self._prefix}decision{len(self.decisions) + 1}"
        self.decisions[name] = Decision(name, **values)  # type: ignore[arg-type]
        return name

    def _flow(self, tree: Sequence[Node], name: str, then: str, leave: str) -> None:
        """Put the nodes of `tree` into the piece `name` and into further pieces that follow it.

        The last of these leads to the piece or decision `then`.  Where the program ends before that, `leave`
        follows.
        """
        piece = self.pieces[name]
        for place, node in enumerate(tree):
            if simple(node):
                piece.body.append(node)
                continue
            rest = tree[place + 1 :]
            after = self._piece()
            piece.then = self._cut(node, after, leave)
            self._flow(rest, after, then, leave)
            return
        piece.then = then

    def _cut(self, node: Node, after: str, leave: str) -> str:
        """Cut a node that is not `simple` into pieces and decisions, and return the name of the first of them.

        The node is followed by the piece `after`, or by `leave` where the program ends.
        """
        match node:
            case WaitInput():
                return self._decision(to=after, inputs=(node.input,), waits=True, line=node.line)
            case Forever():
                loop = self._piece()
                self._flow(node.body, loop, loop, leave)
                return loop
            case AsLongAs():
                loop = self._piece()
                again = self._decision(to=loop, other=after, inputs=node.inputs, line=node.line)
                self._flow(node.body, loop, again, leave)
                return loop
            case Repeat():
                loop = self._piece()
                self._flow(node.body, loop, self._count(loop, after, node.passes, node.line), leave)
                return loop
            case Fork():
                then, otherwise = self._piece(), self._piece()
                self._flow(node.then, then, after, leave)
                self._flow(node.otherwise, otherwise, after, leave)
                return self._decision(to=then, other=otherwise, inputs=node.inputs, line=node.line)
            case Stages():
                return self._states(node, leave)
            case RunProgram() | LeaveProgram():
                inside = self._piece()
                self._flow(self._program(node), inside, after, after)
                return inside
            case _:
                return leave

    def _count(self, to: str, other: str, passes: int, line: int) -> str:
        counter = f"{self._prefix}passes{1 + sum(bool(each.passes) for each in self.decisions.values())}"
        return self._decision(to=to, other=other, passes=passes, counter=counter, line=line)

    def _states(self, node: Stages, leave: str) -> str:
        names = {each.number: self._piece() for each in node.states}
        for each in node.states:
            self._flow(each.body, names[each.number], self._next(each, names, leave), leave)
        return names[node.states[0].number]

    def _next(self, state: Stage, names: dict[int, str], leave: str) -> str:
        to, below = names.get(state.to, leave), names.get(state.below, leave)
        if state.inputs:
            return self._decision(to=to, other=below, inputs=state.inputs, line=state.line)
        return self._count(to, below, state.passes, state.line) if state.passes else to

    # ---------------------------------------------------------------------------------------------------------- tidying
    def _tidy(self) -> None:
        """Remove empty and unreachable pieces."""
        for piece in self.pieces.values():
            piece.then = self._real(piece.then)
        for decision in self.decisions.values():
            known = replace(decision, to=self._real(decision.to), other=self._real(decision.other))
            self.decisions[decision.name] = known
        used, new = {"piece0"}, ["piece0"]
        while new:
            name = new.pop()
            found = self.pieces.get(name)
            leads = [found.then] if found else [self.decisions[name].to, self.decisions[name].other]
            for each in leads:
                if each and each not in used:
                    used.add(each)
                    new.append(each)
        self.pieces = {name: piece for name, piece in self.pieces.items() if name in used}
        self.decisions = {name: decision for name, decision in self.decisions.items() if name in used}

    def _real(self, name: str) -> str:
        """Return the name of the first decision or non-empty piece from `name` onwards; END if there is none."""
        seen = set()
        while name in self.pieces and not self.pieces[name].body and name not in seen:
            seen.add(name)
            name = self.pieces[name].then
        return name

    def returns(self, name: str) -> bool:
        """Return whether a piece leads back to itself through other pieces alone, without a decision in between."""
        at = self.pieces[name].then
        seen = set()
        while at in self.pieces and at not in seen:
            if at == name:
                return True
            seen.add(at)
            at = self.pieces[at].then
        return False
