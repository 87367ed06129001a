"""Shell completion of arguments: parts, pins, options of a part, commands, parameters, examples.

Completion imports no code that needs permission: a part given as module:Class has no completion.  Errors are hidden
from the shell.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.shell_completion import CompletionItem

if TYPE_CHECKING:
    from ...core.datasheet.table import Sheet

Complete = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]


def fitting(words: Iterable[tuple[str, str]], begun: str) -> list[CompletionItem]:
    """Return completions for the words that start with `begun`, ignoring case, each with its description."""
    return [
        CompletionItem(word, help=description or None)
        for word, description in words
        if word.lower().startswith(begun.lower())
    ]


def quietly(complete: Complete) -> Complete:
    """Return a completer that calls `complete`, but returns no completions if that call fails."""

    def completed(ctx: click.Context, param: click.Parameter, begun: str) -> list[CompletionItem]:
        try:
            return complete(ctx, param, begun)
        except Exception:
            return []

    return completed


@quietly
def parts(_ctx: click.Context, _param: click.Parameter, begun: str) -> list[CompletionItem]:
    """Complete the name of a part."""
    from ...chips import CATALOGUE, sheet_of

    return fitting(((name, sheet_of(name).title) for name in CATALOGUE.names()), begun)


def sheet(ctx: click.Context) -> Sheet | None:
    """Return the data sheet of the part named by an argument or by a file's extension; None if none is named."""
    from ...chips import CATALOGUE, sheet_of

    known = CATALOGUE.names()
    # click leaves the arguments before an incomplete option in place.
    for given in (ctx.params.get("chip"), ctx.params.get("file"), *ctx.args):
        for name in (str(given).lower(), Path(str(given)).suffix[1:].lower()):
            if name in known:
                return sheet_of(name)
    return None


def of_sheet(words: Callable[[Sheet], Iterable[tuple[str, str]]]) -> Complete:
    """Return a completer for words from the data sheet of the part that the command line names."""

    def complete(ctx: click.Context, _param: click.Parameter, begun: str) -> list[CompletionItem]:
        found = sheet(ctx)
        return fitting(words(found), begun) if found is not None else []

    return quietly(complete)


def inputs(found: Sheet) -> Iterable[tuple[str, str]]:
    """Yield PIN=0 and PIN=1 for each input of a part, with the description of the pin."""
    for pin in found.pins:
        if pin.in_out in ("in", "both"):
            yield from ((f"{pin.name}={level}", pin.description) for level in (0, 1))


def options(found: Sheet) -> Iterable[tuple[str, str]]:
    """Yield NAME= for each option of a part, with the allowed values."""
    return ((f"{row.name}=", row.allowed) for row in found.options)


def commands(found: Sheet) -> Iterable[tuple[str, str]]:
    """Yield the form of each command of a part, with the name of the command."""
    return ((row.form, row.name) for row in found.commands)


def parameters(found: Sheet) -> Iterable[tuple[str, str]]:
    """Yield NAME= for each parameter of the ramp calculator of a part, with its description."""
    from ...chips import ramps_of

    return ((f"{quantity.name}=", quantity.description) for quantity in ramps_of(found.part).quantities)


strap = drive = of_sheet(inputs)
setting = of_sheet(options)
command = of_sheet(commands)
parameter = of_sheet(parameters)


@quietly
def pins(ctx: click.Context, _param: click.Parameter, begun: str) -> list[CompletionItem]:
    """Complete the last of several pin names, separated by commas."""
    found = sheet(ctx)
    before, comma, last = begun.rpartition(",")
    rows = [pin for pin in found.pins if pin.in_out not in ("power", "none")] if found is not None else []
    return [
        CompletionItem(before + comma + str(item.value), help=item.help)
        for item in fitting(((pin.name, pin.description) for pin in rows), last)
    ]


@quietly
def example(_ctx: click.Context, _param: click.Parameter, begun: str) -> list[CompletionItem]:
    """Complete the name of an example or of an example folder."""
    from ...bench.files.shipped_files import named, title

    found = {place: title(path) for place, path in named().items()}
    folders = {place.rpartition("/")[0]: "" for place in found if "/" in place}
    return fitting([*folders.items(), *found.items()], begun)


def file(_ctx: click.Context, _param: click.Parameter, begun: str) -> list[CompletionItem]:
    """Let the shell complete a file name."""
    return [CompletionItem(begun, type="file")]


def directory(_ctx: click.Context, _param: click.Parameter, begun: str) -> list[CompletionItem]:
    """Let the shell complete the name of a directory."""
    return [CompletionItem(begun, type="dir")]
