"""The command line as data, from which its page and its man page are written."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from inspect import cleandoc

import click

from slewline.cli.commands import cli

OPTION = re.compile(r"(?<![\w`-])--[a-z][a-z0-9-]*")  # within a text


@dataclass(frozen=True)
class CommandHelp:
    """Help of a command, as printed by `--help`."""

    name: str
    usage: str
    text: str  # paragraphs, with an empty line between two
    options: tuple[tuple[str, str], ...]  # the form of each, and its effect


def paragraphs(text: str | None) -> str:
    """Return a help text as paragraphs of one line each."""
    return re.sub(r"(?<!\n)\n(?!\n)", " ", cleandoc(text or ""))


def commands() -> Iterator[CommandHelp]:
    """Yield every command, in the order of the help."""
    context = click.Context(cli, info_name="slewline")
    for name, command in cli.commands.items():
        own = click.Context(command, info_name=name, parent=context)
        records = (parameter.get_help_record(own) for parameter in command.params)
        yield CommandHelp(
            name,
            " ".join([own.command_path, *command.collect_usage_pieces(own)]),
            paragraphs(command.help),
            tuple(record for record in records if record and record[1]),
        )


def about() -> tuple[str, str]:
    """Return the description of the whole program, and its exit statuses."""
    return paragraphs(cli.help), paragraphs(cli.epilog)


def script_guide() -> list[str]:
    """Return the guide to run scripts, the end of `slewline run --help`."""
    from slewline.bench.scripts import script

    return (script.__doc__ or "").splitlines()
