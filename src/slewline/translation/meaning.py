"""The effect of a program in motion-control terms: the intermediate form between the dialects of source and target.

    program   lines    each line of the text, with its comment and its actions
              actions  set a rate, move, wait for an input, loop ..., in the order of the text
              block    a program that the part stores and runs; -1: the host sends the command, which acts immediately

A command that sets a register is an action of its own (`SetProfile`, `SetDistance`, `SetDirection`), since it has a
line of its own; each motion also contains the register values that it uses, so that a target without registers needs
only the motions.  A value that depends on the path through the program, or on the state before the program, is None.

Times are in whole picoseconds, rates in steps/s, accelerations in steps/s^2, positions and distances in steps;
positive is clockwise.  Outputs and inputs count from 1, in the order of the part's roles `output1`, `input1` ...; the
names of the source's pins are in `Program.wiring`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

Part = Literal["start rate", "top rate", "ramp"]


# ------------------------------------------------------------------------------------------------------------- motions
@dataclass(frozen=True, slots=True)
class Profile:
    """The rates and the ramp of a motion.

    Attributes:
        start: the rate of the first and last steps, steps/s.
        top: the rate between the ramps, steps/s; equal to `start` if there is no ramp.
        time_ps: the time from the first step of the motion to the first step at `top`, ps; 0 if there is no ramp.
        steps: the number of steps in that time.
        values: the parameter values of the source, keyed by the name of the command that sets them.
    """

    start: float
    top: float
    time_ps: int = 0
    steps: float = 0
    values: Mapping[str, int | str] = field(default_factory=dict, compare=False, hash=False)

    @property
    def ramped(self) -> bool:
        """True if the rate rises from `start` to `top`, and falls again at the end."""
        return self.time_ps > 0 and self.top > self.start

    @property
    def acceleration(self) -> float:
        """The mean acceleration, steps/s^2: the increase in rate divided by the ramp time; 0 without a ramp."""
        return (self.top - self.start) * 1e12 / self.time_ps if self.ramped else 0.0


@dataclass(frozen=True, slots=True)
class Input:
    """An input level, as the condition for a wait, for a branch, or for the end of a motion."""

    number: int
    level: int


# ------------------------------------------------------------------------------------------------------------- actions
@dataclass(frozen=True, slots=True, kw_only=True)
class Action:
    """The effect of a command.

    Attributes:
        line: the line of the source, counted from 1; 0 for an action without a line.
        text: the command in the source.
        block: the stored program that the command belongs to, counted from 0; -1: a host sends the command.
        axis: the axis concerned, counted from 1.
        command: the form of the command in the source's data sheet; set only for our own parts.
        values: the argument values of the command.
    """

    line: int = 0
    text: str = ""
    block: int = -1
    axis: int = 1
    command: str = ""
    values: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class SetProfile(Action):
    """An action that sets a start rate, a top rate or a ramp.

    Attributes:
        sets: the quantity that it sets: "start rate", "top rate" or "ramp".
        value: the new rate, steps/s; for "ramp", the resulting acceleration, steps/s^2; None if not known.
        profile: the profile after the action; None if not known.
    """

    sets: Part
    value: float | None = None
    profile: Profile | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class SetDistance(Action):
    """An action that sets the number of steps of the relative moves after it."""

    steps: int


@dataclass(frozen=True, slots=True, kw_only=True)
class SetTarget(Action):
    """An action that sets the target position of the next motion; the motion itself is a separate `MoveTo`."""

    position: int


@dataclass(frozen=True, slots=True, kw_only=True)
class SetDirection(Action):
    """An action that sets the direction of the relative moves after it: 1 clockwise, -1 counterclockwise."""

    sign: int


@dataclass(frozen=True, slots=True, kw_only=True)
class SetEndless(Action):
    """An action that makes the next motion endless; the motion itself is a separate `RunEndless`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SetPosition(Action):
    """An action that sets the position counter without moving the motor."""

    position: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion(Action):
    """An action that moves the motor: its profile, and the position at its start, each None if not known."""

    profile: Profile | None = None
    begins: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class MoveBy(Motion):
    """A move by a number of steps.

    `steps` has the sign of the direction; None if the number or the direction is not known.  `distance` is the
    number, and `sign` the direction, each None if not known.
    """

    distance: int | None
    sign: int | None

    @property
    def steps(self) -> int | None:
        """The number of steps, with the sign of the direction; None if the number or the direction is not known."""
        return None if self.distance is None or self.sign is None else self.distance * self.sign


@dataclass(frozen=True, slots=True, kw_only=True)
class MoveTo(Motion):
    """A move to a position; the position is None if not known.

    `implied` is True if the command starts several axes together.  Each of these axes then has its own
    `MoveTo`, and this is one of them.
    """

    position: int | None
    implied: bool = False

    @property
    def steps(self) -> int | None:
        """The number of steps, with the sign of the direction; None if the start or the target is not known."""
        return None if self.position is None or self.begins is None else self.position - self.begins


@dataclass(frozen=True, slots=True, kw_only=True)
class RunEndless(Motion):
    """A run in a direction, ended by the input condition `until`, a `Stop`, an abort input or the host."""

    sign: int | None
    until: Input | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Home(Motion):
    """A search for the home position in a given direction; the position counter is set to 0 there."""

    sign: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Stop(Action):
    """A stop of the motion and of any running program: along the ramp if `ramped`, else after the current step."""

    ramped: bool


# ---------------------------------------------------------------------------------------------- outputs, inputs, times
@dataclass(frozen=True, slots=True, kw_only=True)
class SetOutput(Action):
    """An action that sets an output to a level.

    `implied` is True if the command sets all outputs of the part together.  Each output then has its own
    `SetOutput`, and this is one of them.
    """

    number: int
    level: int
    implied: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class WaitInput(Action):
    """A wait until an input has a given level."""

    input: Input


@dataclass(frozen=True, slots=True, kw_only=True)
class Delay(Action):
    """A wait for a given time."""

    time_ps: int


# ---------------------------------------------------------------------------------------------------------------- flow
@dataclass(frozen=True, slots=True, kw_only=True)
class Label(Action):
    """A named place in a block, to which a jump or a loop of the same block can go."""

    name: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Jump(Action):
    """A jump to a label; if there are `inputs`, it is made only if each of them has its given level."""

    to: str
    inputs: tuple[Input, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Loop(Action):
    """A jump back to a label until the loop has run `passes` times; then the next action follows."""

    to: str
    passes: int


@dataclass(frozen=True, slots=True, kw_only=True)
class EndProgram(Action):
    """The end of the running program."""


# --------------------------------------------------------------------------------------------------- host and programs
@dataclass(frozen=True, slots=True, kw_only=True)
class EnterProgram(Action):
    """The start of program entry: block `number`, whose actions follow, replaces any stored program."""

    number: int


@dataclass(frozen=True, slots=True, kw_only=True)
class LeaveProgram(Action):
    """The end of the entry of a stored program; if `runs`, the part then also runs the program."""

    runs: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class RunProgram(Action):
    """A run of the stored program, from the label `at`, or from its start if `at` is empty."""

    at: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class SaveProgram(Action):
    """An action that saves the stored program so that it survives power-off."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EraseProgram(Action):
    """An action that erases the stored program and sets the registers to their reset values."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HostDirective(Action):
    """A line addressed to the host, such as @wait 20 ms or @until ready."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Query(Action):
    """A query for a value from the part, without motion."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Special(Action):
    """A command of the source's part that other parts may lack.

    Attributes:
        description: the effect of the command, in words.
        needless: why a target without such a command needs no replacement; empty: it needs one.
        remedy: advice to the user; empty: the advice of the source's manual.
    """

    description: str
    needless: str = ""
    remedy: str = ""

    @classmethod
    def of(cls, action: Action, description: str, remedy: str) -> Special:
        """Return a `Special` in place of an action, with the same line, text, block, axis, command and values."""
        its = {name: getattr(action, name) for name in ("line", "text", "block", "axis", "command", "values")}
        return cls(description=description, remedy=remedy, **its)


OF_AN_AXIS = (SetProfile, SetDistance, SetDirection, SetPosition, SetTarget, SetEndless, Motion)


def acts_during_motion(action: Action) -> bool:
    """Return whether a host's action takes effect during the preceding motion, without waiting for its end."""
    return isinstance(action, HostDirective | Stop) or (isinstance(action, Special) and bool(action.needless))


# ------------------------------------------------------------------------------------------------------------- program
@dataclass(frozen=True, slots=True)
class Line:
    """A source line: its number, the code before any comment, the comment without its mark, and the actions.

    A line whose `code` is empty contains only a comment, or nothing.
    """

    number: int
    code: str = ""
    comment: str = ""
    actions: tuple[Action, ...] = ()


@dataclass(frozen=True, slots=True)
class Assumed:
    """A fact missing from the text, such as the crystal or the state at the start, and its assumed value."""

    about: str
    value: str
    remedy: str = ""


@dataclass(frozen=True, slots=True)
class Program:
    """The effect of a program.

    Attributes:
        part: the part that the program is for, such as "cy525".
        where: the name of the program's file.
        lines: all lines of the text, in order.
        assumed: the assumptions about facts missing from the text.
        wiring: the pins of the source, keyed by their purpose: "step", "direction", "output1", "input1" ...
        half_steps: whether a step of the source is a half step of the motor, either because of an option or
            once some command has selected half steps.
        interrupted: whether something outside the program may end a motion early.
    """

    part: str
    where: str
    lines: tuple[Line, ...]
    assumed: tuple[Assumed, ...] = ()
    wiring: Mapping[str, str] = field(default_factory=dict)
    half_steps: bool = False
    interrupted: bool = False

    @property
    def actions(self) -> Iterator[Action]:
        """The actions of all lines, in the order of the text."""
        return (action for line in self.lines for action in line.actions)

    def block(self, number: int) -> list[Action]:
        """Return the actions of a stored program in the order of the text; for -1, the actions that the host sends."""
        return [action for action in self.actions if action.block == number]
