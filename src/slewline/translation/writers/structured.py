"""Base of the writers for languages with loops and branches: the walk through a program's tree (`flow.py`).

A language defines how a loop or a branch is opened and closed, how a variable is set, and how a
condition on inputs is written.  It also has a method for each kind of action.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence

from ..meaning import Action, Input, Label, Program, SetProfile
from ..target_writer import Target, WriterOptions
from .flow import AsLongAs, Forever, Fork, Node, Repeat, Stages, counters, nodes, structured
from .language_writer import LanguageWriter


class Structured(LanguageWriter):
    """A writer for one program in a language with loops and branches; `nothing` is its empty statement."""

    nothing = ""
    true = "true"

    def __init__(self, target: Target, program: Program, options: WriterOptions, indent: str = "  ") -> None:
        super().__init__(target, program, options, indent)
        self.numbers = counters()
        self.final: Action | None = None  # with which a stored program ends anyway

    def program_tree(self, actions: Sequence[Action]) -> None:
        """Write the actions of a stored program, as loops and branches."""
        self.final = actions[-1] if actions else None
        self.tree(structured(actions))

    # ------------------------------------------------------------------------------------------------ the language
    @abstractmethod
    def assign(self, name: str, value: int, source: int) -> None:
        """Write the command that sets a variable to a number."""

    @abstractmethod
    def count(self, name: str, source: int) -> None:
        """Write the command that increases a variable by 1."""

    @abstractmethod
    def compare(self, name: str, sign: str, value: int) -> str:
        """Return the condition that a variable is equal to (`sign` ==), at least (>=) or less than (<) a number."""

    @abstractmethod
    def condition(self, inputs: Sequence[Input], source: int) -> str:
        """Return the condition that all inputs have their given levels; first write any lines that it needs."""

    @abstractmethod
    def repeat(self, passes: int, source: int) -> str:
        """Write the head of a loop with a given number of passes; return its closing text."""

    def forever(self, source: int) -> str:
        """Write the head of an endless loop; return its closing text."""
        return self.while_true(self.true, source)

    @abstractmethod
    def while_true(self, condition: str, source: int) -> str:
        """Write the head of a loop that repeats as long as a condition holds; return its closing text."""

    @abstractmethod
    def as_long_as(self, node: AsLongAs) -> None:
        """Write a loop that tests its condition after each pass."""

    @abstractmethod
    def if_true(self, condition: str, source: int) -> tuple[str, str]:
        """Write the head of a branch; return the text for "else", and the closing text."""

    def negated(self, condition: str) -> str:
        """Return the opposite of a condition."""
        return f"!({condition})"

    # ------------------------------------------------------------------------------------------------------ the walk
    def inside(self, tree: Sequence[Node], close: str, source: int) -> None:
        """Write the body of a loop or a branch, and its closing text."""
        self.forget(tree)
        self.sheet.depth += 1
        before = len(self.sheet.lines)
        self.tree(tree)
        if self.nothing and len(self.sheet.lines) == before:
            self.sheet.add(self.nothing, source)
        self.sheet.depth -= 1
        if close:
            self.sheet.add(close, source)
        self.forget(tree)

    def forget(self, tree: Sequence[Node]) -> None:
        """Drop the register values that a tree may change, since several paths meet at its start and at its end."""
        if any(isinstance(each, SetProfile) for each in nodes(tree)):
            self.registers.profile, self.known = None, {}
        self.registers.position = None

    def tree(self, tree: Sequence[Node]) -> None:
        """Write the commands of a program tree."""
        for node in tree:
            match node:
                case Repeat():
                    self.inside(node.body, self.repeat(node.passes, node.head), node.line)
                    self.sheet.same(node.line)
                case Forever():
                    self.inside(node.body, self.forever(node.head), node.line)
                    self.sheet.same(node.line)
                case AsLongAs():
                    self.as_long_as(node)
                    self.sheet.same(node.line)
                case Fork():
                    self._branch(node)
                    self.sheet.same(node.line)
                case Stages():
                    self._states(node)
                case Label():
                    pass
                case _:
                    self.action(node)
                    self.registers.note(node)

    def _branch(self, node: Fork) -> None:
        condition = self.condition(node.inputs, node.line)
        if not node.then:
            _, close = self.if_true(self.negated(condition), node.line)
            self.inside(node.otherwise, close, node.line)
            return
        otherwise, close = self.if_true(condition, node.line)
        self.inside(node.then, "" if node.otherwise else close, node.line)
        if node.otherwise:
            self.sheet.add(otherwise, node.line)
            self.inside(node.otherwise, close, node.line)

    def _states(self, node: Stages) -> None:
        """Write a part of the program as a state machine: a loop with a branch for each piece.

        Each piece ends by selecting the piece that follows it.
        """
        number = next(self.numbers)
        state = "state" if number == 1 else f"state{number}"
        counted = [piece.number for piece in node.states if piece.passes]
        first = next((action.line for each in node.states for action in each.body), node.line)
        self.assign(state, 0, first)
        for piece_number in counted:
            self.assign(f"passes{piece_number}", 0, first)
        close = self.while_true(self.compare(state, ">=", 0), first)
        self.forget([node])
        self.sheet.depth += 1
        for each in node.states:
            here = each.body[0].line if each.body else each.line
            _, end = self.if_true(self.compare(state, "==", each.number), here)
            self.sheet.depth += 1
            self.forget([node])
            self.tree(each.body)
            if each.inputs:
                self._either(self.condition(each.inputs, each.line), state, each.to, each.below, each.line)
            elif each.passes:
                self.count(f"passes{each.number}", each.line)
                self.assign(state, each.to, each.line)
                _, done = self.if_true(self.compare(f"passes{each.number}", ">=", each.passes), each.line)
                self.sheet.depth += 1
                self.assign(f"passes{each.number}", 0, each.line)
                self.assign(state, each.below, each.line)
                self.sheet.depth -= 1
                if done:
                    self.sheet.add(done, each.line)
            else:
                self.assign(state, each.to, each.line)
            if each.inputs or each.passes or each.to >= 0:
                self.sheet.same(each.line)
            self.sheet.depth -= 1
            if end:
                self.sheet.add(end, each.line)
        self.sheet.depth -= 1
        if close:
            self.sheet.add(close, node.states[-1].line)

    def _either(self, condition: str, state: str, to: int, below: int, source: int) -> None:
        otherwise, close = self.if_true(condition, source)
        self.sheet.depth += 1
        self.assign(state, to, source)
        self.sheet.depth -= 1
        self.sheet.add(otherwise, source)
        self.sheet.depth += 1
        self.assign(state, below, source)
        self.sheet.depth -= 1
        if close:
            self.sheet.add(close, source)
