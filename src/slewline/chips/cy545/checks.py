"""Lint rules that apply to the CY545 only: motions, the mode register, and commands sent while a program runs."""

from __future__ import annotations

from ...core.datasheet.channel import FlowBus
from ...core.datasheet.table import Sheet
from ...errors import UsageError
from ...language.dialect import spoken_as
from ...language.lint import Check, section
from ...language.statements import Directive, Source, Statement
from ...language.text import Verbatim
from ..cy5xx.checks import written_for
from .interpreter import REFUSED
from .ramp_checks import motions
from .sheet import MB_3, MB_6, MB_ASCII

FORMS = ("binary", "text")
RESETS = ("power", "reset")  # after these the mode is text
PASSES_TIME = ("wait", "until", "bytes", "to", "power", "reset")  # after these a program may have ended


def modes(source: Source) -> None:
    """Report commands that set mode bits of unknown effect."""
    for statement in source.statements:
        mode = mode_of(statement)
        if mode is not None and mode & (MB_6 | MB_3):
            found = f"O {mode}: the effect of MB6 and MB3 is not documented; they are stored and have no effect"
            source.report(statement, "mode-bits", "warning", found, section=section(statement.row))


def mode_of(statement: Statement) -> int | None:
    """Return the mode that a command loads; None if it loads none, or if the mode is read from switches."""
    written = statement.row.name == "MODE" and not statement.operands[0].label
    return statement.values[0] if written else None


def forms(source: Source) -> None:
    """Check that commands have the right form, text or binary.

    The form of host commands depends on the current mode; the form of program commands depends on the mode
    in which the program was entered.
    """
    text: bool | None = True  # form of the host's commands; None: unknown
    for item in source.items:
        if isinstance(item, Directive):
            text = True if item.verb in RESETS else None if item.verb == "bytes" else text
        elif item.block < 0:
            if text is False:
                spelled(source, item)
            mode = mode_of(item)
            text = item.row.name == "INITIALIZE" or (text if mode is None else bool(mode & MB_ASCII))
        else:
            misread(source, item, text)


def misread(source: Source, statement: Statement, text: bool | None) -> None:
    """Report a mode command in a program if it makes the chip misread the commands that follow it there."""
    mode, following = mode_of(statement), source.blocks[statement.block].statements
    if text is None or mode is None or bool(mode & MB_ASCII) is text or statement is following[-1]:
        return
    found = (
        f"{statement.text} makes the chip read {FORMS[not text]}, but the commands after it are stored in {FORMS[text]}"
    )
    remedy = f"O {mode ^ MB_ASCII} keeps {FORMS[text]}; a program is stored in the mode at its E"
    source.report(statement, "binary-mode", "warning", found, section=section(statement.row), remedy=remedy)


def spelled(source: Source, statement: Statement) -> None:
    """Report a command if it has no binary form that a host could send."""
    try:
        spoken_as(source.sheet, Verbatim).sent_binary(source.sheet, statement.text)
    except UsageError as error:
        remedy = f"O {MB_ASCII} above it returns to text"
        source.report(statement, "binary-mode", "error", str(error), section=section(statement.row), remedy=remedy)


def running(sheet: Sheet) -> Check:
    """Return the rule about commands that the host sends while a program may run."""
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
    """Report a host command that the chip ignores or cannot accept while the program begun by `started` runs."""
    begun = f"the program that {started.text} of line {started.line} started may still run"
    if live and item.row.form in REFUSED:
        found = f"{item.text}: {begun}, and would ignore it"
        source.report(item, "not-immediate", "warning", found, section="ch.16", remedy="stop the program with 0 first")
    elif not live and item.row.role == "stop":
        found = f"{item.text}: {begun}, and the chip accepts no command until it has ended"
        source.report(item, "not-heard", "warning", found, section="ch.16", remedy="put a 0 into the program to end it")


def checks(sheet: Sheet) -> tuple[Check, ...]:
    """Return this part's rules for `language.lint.lint`."""
    return (motions(sheet), modes, forms, running(sheet), written_for)
