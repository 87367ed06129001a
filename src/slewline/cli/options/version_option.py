"""The option --version."""

from __future__ import annotations

import click


def _tell(context: click.Context, _option: click.Parameter, asked: bool) -> None:
    if asked and not context.resilient_parsing:
        from ..version import version_line

        click.echo(version_line())
        context.exit()


version_option = click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_tell,
    help="Show the version and which build of it runs, and exit.",
)
