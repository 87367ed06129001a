"""Common base of the writers for all languages: facts about a program, and the dispatch of actions to methods."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from ...chips import sheet_of
from ...errors import UsageError
from ..meaning import (
    OF_AN_AXIS,
    Action,
    Delay,
    EndProgram,
    EnterProgram,
    Home,
    LeaveProgram,
    MoveBy,
    MoveTo,
    Program,
    RunEndless,
    RunProgram,
    SetDirection,
    SetDistance,
    SetOutput,
    SetPosition,
    SetProfile,
    WaitInput,
)
from ..program_facts import counter_of, counts_positions, one_acceleration, outputs, runs, stored, variables
from ..target_writer import Target, WriterOptions, Written
from ..translation_report import OutLine
from .source_sheet import Draft, RegisterCache, heading, lines_of, unspoken, wired, with_comments


class LanguageWriter(ABC):
    """A writer for one program in a language.

    A subclass has a method for each kind of action, and defines the needs and limits of its language:

        needs: why a value must be known, such as "a call needs a number".
        entry: why a program cannot be run from a label; empty if it can.
        called: the report text for a line that runs a program.
        moves: the report text for a setting that appears only as a part of the moves.
        keeps: the report text for a command that saves a program.
        most_axes: the maximum number of axes.
        more_axes: the report texts for an axis beyond that maximum: the limit, and a remedy.
        stem: the name of the first stored program; the others have their number appended to it.
    """

    needs = "a call needs a number"
    entry = ""
    entry_remedy = "split the program there"
    called = ""
    moves = ""
    keeps = "the result is a file, which is kept"
    most_axes = 1
    more_axes = ("", "")
    stem = "program"

    def __init__(self, target: Target, program: Program, options: WriterOptions, indent: str = "  ") -> None:
        self.target, self.program, self.options = target, program, options
        self.sheet = Draft(target.comment, program, indent)
        self.registers = RegisterCache()
        self.known: dict[Any, float] = {}  # the rates and ramps last written, if known
        self.ran_with: dict[int, dict[Any, float]] = {}  # the same, at the time when the host runs a stored program
        self.runs = runs(program)
        self.names = {each: self.stem if each == 0 else f"{self.stem}{each + 1}" for each in stored(program)}
        self.outputs = {output for output, _ in outputs(program)}
        self.variable_distance, self.variable_sign = variables(program.actions)
        self.acceleration = one_acceleration(program.actions)

    @abstractmethod
    def written(self) -> Written:
        """Return the translation of the program."""

    @abstractmethod
    def wires(self) -> Iterable[tuple[str, str]]:
        """Return pairs of a wire's purpose and its pin on the target."""

    def finished(self, lines: Iterable[OutLine], assumed: Iterable[tuple[str, str]]) -> Written:
        """Return the translation: the given lines, preceded by the comments at the beginning of the source program."""
        out = (*heading(self.program), *lines)
        assumed = [*assumed, *self._counted()]
        return Written(out, tuple(self.sheet.verdicts), wired(self.program, self.wires()), tuple(assumed))

    def _counted(self) -> list[tuple[str, str]]:
        """Return the assumption that positions stay within the source counter's limits; empty if not needed."""
        ends = counter_of(sheet_of(self.program.part)) if counts_positions(self.program) else None
        if ends is None:
            return []
        return [("positions", f"never beyond a limit of the counter of the {self.program.part} ({ends[0]}..{ends[1]})")]

    def commented(self, block: int) -> list[OutLine]:
        """Return the lines written for a block (-1: the host's commands), with the comments of its source lines."""
        return with_comments(lines_of(self.program, block), self.sheet.lines, self.target.comment)

    def inner(self, block: int) -> list[Action]:
        """Return the actions of a stored program, without the commands that begin and end program entry."""
        return [each for each in self.program.block(block) if not isinstance(each, EnterProgram | LeaveProgram)]

    def first_axis(self, letters: str) -> int:
        """Return the index of the axis that the user has selected, among the axis letters of the language.

        Raises:
            UsageError: the axis is not one of these letters.
        """
        axis = self.options.axis.upper()
        if len(axis) != 1 or axis not in letters:
            raise UsageError(f"axis {self.options.axis}: allowed {', '.join(letters)} ({self.target.language})")
        return letters.index(axis)

    # -------------------------------------------------------------------------------------------------------- actions
    def action(self, action: Action) -> None:
        """Write an action, by the method for its kind."""
        sheet, line = self.sheet, action.line
        if action.axis > self.most_axes and isinstance(action, OF_AN_AXIS):
            sheet.impossible(line, f"axis {action.axis}", *self.more_axes)
            return
        match action:
            case SetProfile():
                self.profile(action)
            case SetDistance():
                if self.variable_distance:
                    self.register("distance", action.steps, line)
                sheet.same(line, self.moves)
            case SetDirection():
                if self.variable_sign:
                    self.register("direction", action.sign, line)
                sheet.same(line, self.moves)
            case SetPosition():
                self.preset(action)
                sheet.same(line)
            case MoveTo() if action.position is None:
                self.unknown(line, "the position")
            case MoveBy() | MoveTo():
                self.move(action)
            case RunEndless() | Home():
                sign = self.sign_of(action)
                if sign is None:
                    self.unknown(line, "the direction", "set the direction in the text")
                else:
                    self.search(replace(action, sign=sign), sign)
            case SetOutput():
                if action.number in self.outputs or not action.implied:
                    self.output(action)
            case WaitInput():
                self.wait(action)
            case Delay():
                self.delay(action)
            case LeaveProgram() | RunProgram():
                self._run(action)
            case EndProgram():
                self.leave(action)
            case EnterProgram():
                pass
            case _:
                unspoken(sheet, action, self.keeps, self.target.language)

    def unknown(self, line: int, what: str, remedy: str = "write the command with a number") -> None:
        """Record that a line cannot be translated, because the program text does not determine a value.

        `what` names the value, and `remedy` is advice to the user.
        """
        self.sheet.impossible(line, f"{what} is not known from the text", self.needs, remedy)

    def sign_of(self, action: RunEndless | Home) -> int | None:
        """Return the direction (1 or -1) of an endless run or a search for home, or None if it is not known."""
        return action.sign

    def _run(self, action: LeaveProgram | RunProgram) -> None:
        if isinstance(action, LeaveProgram) and not action.runs:
            return
        at = action.at if isinstance(action, RunProgram) else ""
        if at and self.entry:
            description = f"the program runs from {at} on"
            self.sheet.impossible(action.line, description, self.entry, self.entry_remedy)
            return
        self.call(self.runs[action.line], at, action.line)
        self.sheet.same(action.line, self.called)

    def call(self, block: int, at: str, line: int) -> None:
        """Write the command that runs a stored program, from its start or from a label."""
        self.sheet.add(self.calls(self.names.get(block, self.stem)), line)
        self.handed_over(block)

    def handed_over(self, block: int) -> None:
        """Record the rates and ramps that are known when a stored program is run; after the run, none are known.

        If several commands run the program with different values, none are known at its start.
        """
        self.ran_with[block] = dict(self.known) if self.ran_with.get(block, self.known) == self.known else {}
        self.known = {}

    def calls(self, name: str) -> str:
        """Return the command that runs a stored program."""
        raise NotImplementedError

    def leave(self, action: EndProgram) -> None:
        """Write the end of a program."""
        self.sheet.same(action.line)

    def register(self, name: str, value: int, line: int) -> None:
        """Write the command that sets the distance or the direction of the relative moves that follow."""
        raise NotImplementedError

    @abstractmethod
    def profile(self, action: SetProfile) -> None:
        """Write the command that sets a rate or a ramp value."""

    @abstractmethod
    def preset(self, action: SetPosition) -> None:
        """Write the command that sets the position counter."""

    @abstractmethod
    def move(self, action: MoveBy | MoveTo) -> None:
        """Write a move; for a move to a position, this is called only if the position is known."""

    @abstractmethod
    def search(self, action: RunEndless | Home, sign: int) -> None:
        """Write a motion that is ended by an input."""

    @abstractmethod
    def output(self, action: SetOutput) -> None:
        """Write the command that sets an output."""

    def wait(self, action: WaitInput) -> None:
        """Write a wait for an input."""
        raise NotImplementedError

    @abstractmethod
    def delay(self, action: Delay) -> None:
        """Write a delay."""
