"""What only the CY545's linter knows: motions, the mode register, and commands to a program that runs."""

from __future__ import annotations

from itertools import zip_longest

from ...core.channel import FlowBus
from ...core.table import Sheet
from ...language.lint import Check, section
from ...language.statements import Directive, Source, Statement
from ..cy5xx.sisters import written_for
from .interpreter import REFUSED
from .ramp_checks import motions
from .sheet import MB_3, MB_6, MB_ASCII

PASSES_TIME = ("wait", "until", "bytes", "to", "power", "reset")  # behind these a program may have ended


def modes(source: Source) -> None:
    """Bits of the mode that nobody knows, and text behind an O that makes all that follows binary."""
    said = source.statements
    for statement, behind in zip_longest(said, said[1:]):
        if statement.row.name != "MODE" or statement.operands[0].label:
            continue
        mode, about = statement.values[0], section(statement.row)
        if mode & (MB_6 | MB_3):
            found = f"O {mode} sets bits of the mode register that nobody knows: they are kept, without effect"
            source.report(statement, "mode-bits", "warning", found, section=about)
        if not mode & MB_ASCII and behind is not None and (behind.block < 0) == (statement.block < 0):
            found = f"O {mode} makes all that follows binary, and this is text"
            remedy = f"O {mode | MB_ASCII} stays with text; @bytes sends binary"
            source.report(behind, "binary-mode", "warning", found, section=about, remedy=remedy)


def running(sheet: Sheet) -> Check:
    """Return the rule about commands of a host that come while a program may run."""
    channel = sheet.channel(FlowBus)
    live = channel is not None and channel.live

    def judge(source: Source) -> None:
        started: Statement | None = None
        for item in source.items:
            if isinstance(item, Directive):
                started = None if item.verb in PASSES_TIME else started
            elif item.block < 0:
                if started is not None:
                    meets(source, item, started, live)
                starts = item.row.role == "run" or item.row.name == "JUMP"
                started = item if starts else None if item.row.role == "stop" else started

    return judge


def meets(source: Source, item: Statement, started: Statement, live: bool) -> None:
    """Report a command that may meet the program that another one has started."""
    begun = f"the program that {started.text} of line {started.line} started may still run"
    if live and item.row.form in REFUSED:
        found = f"{item.text}: {begun}, and would ignore it"
        source.report(item, "not-immediate", "warning", found, section="ch.16", remedy="stop it with 0 first")
    elif not live and item.row.role == "stop":
        found = f"{item.text}: {begun}, and takes no command before it has stopped by itself"
        source.report(
            item, "not-heard", "warning", found, section="ch.16", remedy="end the program with a 0 of its own"
        )


def checks(sheet: Sheet) -> tuple[Check, ...]:
    """Return the rules of this part, for `language.lint.lint`."""
    return (motions(sheet), modes, running(sheet), written_for)
