"""Lint rules for commands sent while a program runs, and for commands sent too early."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace

from ...core.datasheet.table import Pin, Row, Sheet
from ..host_rules import directives
from ..source import read
from ..statements import Directive, Source, Statement

PASSES_TIME = ("wait", "until", "bytes", "to")  # after these it is unknown whether a program still runs


def listed(rows: Iterable[Row]) -> str:
    """Return commands as a list for a remedy, such as "T, J or X"."""
    forms = [row.form for row in rows]
    return " or ".join([", ".join(forms[:-1]), forms[-1]]) if len(forms) > 1 else "".join(forms)


def resets(sheet: Sheet) -> re.Pattern[str]:
    """Return a regular expression for a directive that sets the reset pin active.

    It never matches if the part has no reset pin.
    """
    pin = sheet.role("reset")
    return re.compile(rf"@(?:drive|pulse)\s+{pin.name}\s*=\s*{level_of(pin, 1)}") if pin is not None else _NEVER


def rests(sheet: Sheet) -> re.Pattern[str]:
    """Return a regular expression for a directive that waits until the motor is at rest.

    It never matches if no pin of the part shows this.
    """
    wanted = (("motion_complete", 1), ("ready", 1), ("running", 0))
    conditions = "|".join(_waits(pin, holds) for role, holds in wanted if (pin := sheet.role(role)) is not None)
    return re.compile(rf"@until\s+(?:{conditions})$") if conditions else _NEVER


def _waits(pin: Pin, holds: int) -> str:
    return rf"{pin.name}\s*=\s*{level_of(pin, holds)}"


def level_of(pin: Pin, holds: int) -> int:
    """Return the level at which the role of a pin is active or, if `holds` is 0, not active."""
    return holds if pin.sense != 0 else 1 - holds


_NEVER = re.compile(r"(?!)")


def live(source: Source) -> None:
    """Report the problems of the commands in @live directives."""
    for item in directives(source):
        for column, command in live_commands(item):
            for problem in read(command, source.sheet).problems:
                source.problems.append(replace(problem, line=item.line, column=column + problem.column - 1))


def live_commands(item: Directive) -> list[tuple[int, str]]:
    """Return (column, text) of each command in an @live directive; empty for other directives."""
    if item.verb != "live":
        return []
    begin = len("@live")
    found = re.finditer(r"[^|]+", item.text[begin:])
    return [
        (item.column + begin + at.start() + len(at[0]) - len(at[0].lstrip()), at[0].strip())
        for at in found
        if at[0].strip()
    ]


@dataclass
class DialogueState:
    """The state that the chip may be in after a host has sent the lines of a text up to a certain line.

    It comprises whether a program is stored, which program may still run, and whether the motor may be
    moving.
    """

    source: Source
    stored: bool = False
    started: Statement | None = None  # the command that has started the program that may still run
    moving: bool = False

    def __post_init__(self) -> None:
        self.sheet = self.source.sheet
        self.resets, self.rests = resets(self.sheet), rests(self.sheet)

    def directive(self, item: Directive) -> None:
        """Update the state for a directive, and report the directive's problems."""
        if item.verb == "read" and not self.moving:
            found = "@read position waits for a motion, but no line above starts one"
            remedy = "at rest, @verify 0 reads the position"
            section = self.sheet.sections.get("reading", "")
            self.source.report(item, "read-at-rest", "warning", found, section=section, remedy=remedy)
        if item.verb == "verify":
            reading = listed(self.sheet.acting("read"))
            instead = item.text.replace("verify", f"live {reading}", 1) + " reads through PROG/LIVE"
            self.check_still_running(item, instead)
        sent = [command for _, text in live_commands(item) for command in read(text, self.sheet).statements]
        reset = item.verb in ("power", "reset") or self.resets.match(item.text) is not None
        if reset or item.verb in PASSES_TIME or any(command.row.role in ("stop", "erase") for command in sent):
            self.started = None
        if reset:
            self.stored = self.moving = False
        elif self.rests.match(item.text):
            self.moving = False

    def command(self, item: Statement) -> None:
        """Update the state for a command outside a program, and report the command's problems."""
        row = item.row
        self.check_still_running(item, "a running program takes live commands only (@live)")
        starts = row.role == "run" or item.target is not None
        if (row.role == "run" or row.flow == "t") and not self.stored:
            stop, enter, leave = (listed(self.sheet.acting(role)) for role in ("stop", "enter", "leave"))
            found = f"{item.text} without a program: run mode, with nothing to execute, until RESET or a live {stop}"
            remedy = f"enter a program first, between {enter} and {leave}"
            self.source.report(item, "no-program", "warning", found, section=row.where, remedy=remedy)
        self.started = item if starts else None
        self.moving = starts or row.motion
        if row.role in ("enter", "erase"):
            self.stored = False

    def check_still_running(self, item: Statement | Directive, instead: str) -> None:
        """Report a command or read-out that fails while a program still runs; `instead` is part of the remedy."""
        if self.started is None:
            return
        begun = f"{self.started.text} of line {self.started.line}"
        found = f"{item.text}: the program that {begun} started may still run"
        running = self.sheet.role("running")
        ends = f"@until {running.name}={level_of(running, 0)} waits for its end" if running is not None else ""
        remedy = "; ".join(filter(None, (ends, instead)))
        section = self.sheet.sections.get("running", "")
        self.source.report(item, "still-running", "warning", found, section=section, remedy=remedy)


def course(source: Source) -> None:
    """Report commands that are sent too early, and @read without a motion.

    A command is too early while a program may still run; a command that runs a program is also too early
    if no program is stored.
    """
    chip = DialogueState(source)
    for item in source.items:
        if isinstance(item, Directive):
            chip.directive(item)
        elif item.block >= 0:
            chip.stored = True
        else:
            chip.command(item)
