"""The questions of `slewline tune` in a terminal: one per missing argument, with choices and a default.

An answer is a number from the list, a name, part of a name (which shortens the list), or any other text;
the Enter key alone selects the default.  Answers are checked like values on the command line, so any
valid value may be typed.  At the end the complete command line is printed, for use next time.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import redirect_stdout
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import click

from ...errors import SlewlineError
from ..options.command_kinds import HintingCommand

if TYPE_CHECKING:
    from ...parts.motors.motor_data import MotorData

MOST_SHOWN = 9  # rows of a list
STEPS = 500
SUPPLY = "24 V"
VALUE = re.compile(r"[A-Z_]+=.+")
NO_LOAD = "none"
LOADS = (
    (NO_LOAD, "the rotor alone"),
    ("inertia 68 g cm2", "a wheel or a disc"),
    ("inertia 68 g cm2, friction 5 mNm", "a slide on a belt"),
    ("inertia 68 g cm2, friction 5 mNm, torque 30 mNm", "a slide that lifts"),
)


@dataclass
class Question:
    """A question with a list of answers (each with a short description), a default, and a check."""

    title: str
    choices: list[tuple[str, str]]
    default: str
    check: Callable[[str], object]

    def ask(self) -> str:
        """Prompt until the answer is valid, and return it.

        Raises:
            click.Abort: the user ends the input.
        """
        shown, default = self.choices, self.default
        while True:
            self.show(shown)
            try:
                answer = str(click.prompt(self.title, default=default, err=True)).strip()
            except click.Abort:
                click.echo(err=True)  # the next message starts on a new line
                raise
            taken = self.taken(answer, shown)
            try:
                self.check(taken)
            except (SlewlineError, click.UsageError) as error:
                found = [row for row in self.choices if answer and answer.lower() in " ".join(row).lower()]
                if found:
                    shown, default = found, found[0][0]
                else:
                    shown, default = self.choices, self.default
                    click.echo(f"  {error.message if isinstance(error, click.UsageError) else error}", err=True)
            else:
                if taken != answer:
                    click.echo(f"  {taken}", err=True)
                return taken

    def taken(self, answer: str, shown: list[tuple[str, str]]) -> str:
        """Return the choice with the name (ignoring case) or number in `answer`; return any other answer unchanged."""
        names = {name.lower(): name for name, _ in self.choices}
        if answer.lower() in names:
            return names[answer.lower()]
        number = int(answer) if answer.isascii() and answer.isdigit() and len(answer) < len("1000") else 0
        return shown[number - 1][0] if 1 <= number <= min(len(shown), MOST_SHOWN) else answer

    def show(self, rows: list[tuple[str, str]]) -> None:
        """Print a numbered list of at most 9 choices, then the names of any others."""
        width = max((len(name) for name, _ in rows), default=0)
        for number, (name, description) in enumerate(rows[:MOST_SHOWN], 1):
            click.echo(f"  {number:2}  {name:<{width}}  {description}".rstrip(), err=True)
        if len(rows) > MOST_SHOWN:
            others = ", ".join(name for name, _ in rows[MOST_SHOWN:])
            click.echo(f"      and {others}\n      type a part of a name to shorten the list", err=True)


class AskingCommand(HintingCommand):
    """The command `tune`, which prompts for missing arguments in a terminal."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the arguments; refuse ramp parameters (NAME=VALUE) that are not part of the value of --grid."""
        values = [
            word for before, word in pairwise(["", *args]) if VALUE.fullmatch(word) and not before.startswith("--")
        ]
        if values:
            raise click.UsageError(f"{' '.join(values)}: write --grid {' '.join(values)!r}", ctx)
        return super().parse_args(ctx, args)

    def completed(self, ctx: click.Context, args: list[str]) -> list[str]:
        """In a terminal, prompt for missing arguments, and print the complete command line; return its arguments."""
        if not (sys.stdin.isatty() and sys.stderr.isatty()) or not self.missing(ctx, args):
            return args
        click.echo("Enter the missing arguments; the enter key takes the default, Ctrl-C ends.", err=True)
        with redirect_stdout(sys.stderr):  # where `input` writes
            added = list(self.answers(ctx, self.given(ctx, args)))
        line = [word for name, word in added if not name]
        line += [*args, *(word for pair in added if pair[0] for word in pair)]
        click.echo(f"\nThe same without questions:\n  {written(['slewline', str(ctx.info_name), *line])}\n", err=True)
        return line

    def answers(self, ctx: click.Context, given: dict[str, Any]) -> Iterator[tuple[str, str]]:
        """Prompt for each missing value; yield its option ("" for an argument) and the answer."""
        for name, question in self.questions():
            param = next(each for each in self.get_params(ctx) if each.name == name)
            if name in given:
                continue
            made = question(given)
            check = made.check

            def checked(text: str, param: click.Parameter = param, check: Callable[[str], object] = check) -> object:
                return check(param.type.convert(text, param, ctx))

            made.check = checked
            given[name] = made.ask()
            if given[name] != NO_LOAD:
                yield ("" if isinstance(param, click.Argument) else param.opts[0]), given[name]

    def questions(self) -> list[tuple[str, Callable[[dict[str, str]], Question]]]:
        """Return, in order, the name of each value and a function that makes its question from earlier answers."""
        return [
            ("chip", chip_question), ("motor", motor_question), ("driver", driver_question), ("load", load_question),
            ("steps", steps_question),
        ]  # fmt: skip


def chip_question(_given: dict[str, str]) -> Question:
    """Return the question for the chip."""
    from ...chips import PARTS, ramps_of

    rows = [(part, row.description) for part, row in PARTS.items()]
    return Question("Chip", rows, rows[0][0], ramps_of)


def motor_question(_given: dict[str, str]) -> Question:
    """Return the question for the motor."""
    from ...parts.motors.motors import MOTORS, read_motor

    rows = [(row.name, f"{row.current:g} A, {row.torque:g} N m") for row in MOTORS.values()]
    return Question("Motor", rows, "QSH4218-51-10-049", lambda motor: read_motor(motor, "--motor"))


def motor_of(given: dict[str, str]) -> MotorData:
    """Return the data of the motor named in the answers so far."""
    from ...parts.motors.motors import read_motor

    return read_motor(given["motor"], "--motor")


def driver_question(given: dict[str, str]) -> Question:
    """Return the question about the driver; its choices suit the motor named in the answers so far."""
    from ...parts.motors.drivers import read_driver

    motor = motor_of(given)
    rows = [
        (f"{SUPPLY}, {motor.current:g} A averaged", "a chopper, calculated fast"),
        (f"{SUPPLY}, {motor.current:g} A chopper", "a chopper, with its switching"),
        (f"L/4R {4 * motor.current * motor.resistance:g} V", "resistors in series"),
        (f"L/R {motor.current * motor.resistance:g} V", "none: only the winding"),
    ]
    return Question("Driver", rows, rows[0][0], lambda text: read_driver(text, "--driver", motor))


def load_question(given: dict[str, str]) -> Question:
    """Return the question for the load."""
    from ...parts.motors.drivers import read_driver
    from ...parts.motors.loads import check_holds, read_load

    motor = motor_of(given)
    driver = read_driver(given["driver"], "--driver", motor)

    def check(text: str) -> None:
        check_holds(motor, driver, read_load("" if text == NO_LOAD else text, "--load", motor), "--load")

    return Question("Load", [*LOADS], NO_LOAD, check)


def steps_question(_given: dict[str, str]) -> Question:
    """Return the question for the number of steps."""

    def check(steps: Any) -> None:
        if steps < 1:
            raise click.UsageError("expected a whole number of steps, 1 or more")

    return Question("Steps of the move, from rest to rest", [], str(STEPS), check)


def written(words: list[str]) -> str:
    """Return a command line, quoted for the shell of this system."""
    return subprocess.list2cmdline(words) if os.name == "nt" else shlex.join(words)
