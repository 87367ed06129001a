"""slewline new-chip and new-part: their options."""

from __future__ import annotations

from typing import Any

import click

from ..options.command_kinds import HintingCommand
from ..options.shared import EXIT
from ..options.values import DIRECTORY

INTO = click.option(
    "--output", "-o", metavar="DIR", default=".", show_default=True, help="Folder for the files.", type=DIRECTORY
)


@click.command("new-chip", cls=HintingCommand, short_help="Write a package with a chip of your own.", epilog=EXIT)
@click.argument("name")
@INTO
def new_chip_command(**options: Any) -> int:
    """Write a package with a chip of your own: sheet, class, tests, conformance table, and a program for it.

    NAME is the name of the chip: lower-case letters, digits, single hyphens.  The package works unchanged;
    the chip in it is fictitious, and you replace the rows of its sheet.
    """
    from .new_package import new

    return new("chip", **options)


@click.command("new-part", cls=HintingCommand, short_help="Write a package with a part of your own.", epilog=EXIT)
@click.argument("name")
@INTO
def new_part_command(**options: Any) -> int:
    """Write a package with a part of your own, to connect to a chip: class, tests, conformance table, bench files.

    NAME is the name of the part: lower-case letters, digits, single hyphens.  The package works unchanged;
    the part in it is a relay, and you replace its behaviour.
    """
    from .new_package import new

    return new("part", **options)
