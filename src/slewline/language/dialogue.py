"""Lint rules about a host: the pins that it drives, its live commands, and commands that come too early."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

from .source import read
from .statements import Directive, Source, Statement

PASSES_TIME = ("wait", "until", "bytes", "to")  # behind these it is unknown whether a program still runs
ENDS = ("INITIALIZE", "COMMAND")  # live commands that end a program
RESET = re.compile(r"@(?:drive|pulse)\s+reset\s*=\s*0")
REST = re.compile(r"@until\s+(?:motion_complete\s*=\s*0|ready\s*=\s*1|run\s*=\s*1)$")
DRIVEN = re.compile(r"@(?:drive|pulse)\s+(\w+)\s*=")


def directives(source: Source) -> list[Directive]:
    """Return the directives of a text, in their order."""
    return [item for item in source.items if isinstance(item, Directive)]


def driven(source: Source) -> None:
    """Report directives that drive an output: two outputs on one net are a conflict."""
    outputs = {pin.name: pin for pin in source.sheet.pins if pin.way == "out"}
    for item in directives(source):
        found = DRIVEN.match(item.text)
        if found and found[1] in outputs:
            says, where = f"{found[1]} is an output of the {source.sheet.part.upper()}", outputs[found[1]].where
            source.report(item, "driven-output", "warning", says, section=where, remedy="drive an input")


def live(source: Source) -> None:
    """Report what is wrong with the commands of @live."""
    for item in directives(source):
        for column, command in live_commands(item):
            for problem in read(command, source.sheet).problems:
                source.problems.append(replace(problem, line=item.line, column=column + problem.column - 1))


def live_commands(item: Directive) -> list[tuple[int, str]]:
    """Return the commands of @live, each with the column at which it begins."""
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
class Course:
    """What the chip may be doing while a text is sent: which program it has, which it runs, whether the motor moves."""

    source: Source
    stored: bool = False
    started: Statement | None = None  # what has started the program that may still run
    moving: bool = False

    def directive(self, item: Directive) -> None:
        """Follow a directive."""
        if item.verb == "read" and not self.moving:
            found = "@read position waits for a motion, and nothing above begins one"
            remedy = "at rest, @verify 0 reads the position"
            self.source.report(item, "read-at-rest", "warning", found, section="s.6", remedy=remedy)
        if item.verb == "verify":
            self.check_still_running(item, item.text.replace("verify", "live V", 1) + " reads through PROG/LIVE")
        sent = [command for _, text in live_commands(item) for command in read(text, self.source.sheet).statements]
        reset = item.verb in ("power", "reset") or RESET.match(item.text) is not None
        if reset or item.verb in PASSES_TIME or any(command.row.name in ENDS for command in sent):
            self.started = None
        if reset:
            self.stored = self.moving = False
        elif REST.match(item.text):
            self.moving = False

    def command(self, item: Statement) -> None:
        """Follow a command outside a program."""
        name = item.row.name
        self.check_still_running(item, "a running program takes live commands only (@live)")
        starts = name == "EXECUTE" or item.target is not None
        if name in ("EXECUTE", "JUMP") and not self.stored:
            found = f"{item.text} without a program: run mode, with nothing to execute, until RESET or a live 0"
            remedy = "enter a program first, between E and Q"
            self.source.report(item, "no-program", "warning", found, section=item.row.where, remedy=remedy)
        self.started = item if starts else None
        self.moving = starts or item.row.motion
        if name in ("ENTER", "INITIALIZE"):
            self.stored = False

    def check_still_running(self, item: Statement | Directive, instead: str) -> None:
        """A running program takes no commands, and a verify group is asked for by one."""
        if self.started is None:
            return
        begun = f"{self.started.text} of line {self.started.line}"
        found = f"{item.text}: the program that {begun} started may still run"
        remedy = f"@until run=1 waits for its end; {instead}"
        self.source.report(item, "still-running", "warning", found, section="s.7", remedy=remedy)


def course(source: Source) -> None:
    """Report commands to a running program, X and J without a program, and read-outs on the fly without a motion."""
    chip = Course(source)
    for item in source.items:
        if isinstance(item, Directive):
            chip.directive(item)
        elif item.block >= 0:
            chip.stored = True
        else:
            chip.command(item)
