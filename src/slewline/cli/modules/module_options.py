"""Options of the commands that speak to a real module: where it is, what it is, and how it is set."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import click

from ...core.time.timebase import hertz
from ..options.command_kinds import ChipOption
from ..options.shared import path
from ..options.values import FREQUENCY, PartName, WholeNumber

Function = TypeVar("Function", bound=Callable[..., Any])


def chip_option(says: str, *, required: bool = True) -> Callable[[Function], Function]:
    """Return the option that names the part of a module."""
    return click.option("--chip", "part", cls=ChipOption, type=PartName(), metavar="CHIP", required=required, help=says)


MARKINGS = click.option("--markings", metavar="TEXT", help="What is printed on the module, for the record.")
CLOCK = click.option("--crystal", type=FREQUENCY, help="Its clock, such as '11 MHz', where that is known.")
PORT = click.argument("port")
PART = chip_option("What it is; by default as FILE ends, such as .gs-c200s.", required=False)
ECHO = click.option("--echo", is_flag=True, help="The line echoes what is sent, as an RS-485 adapter does: drop that.")
SETTING = (
    click.option(
        "--baud", type=WholeNumber(9600), metavar="RATE", help="Its rate; by default it is looked for, or 9600."
    ),
    click.option(
        "--checksum/--no-checksum", default=None, help="Its lines have checksums, or not; by default it is asked."
    ),
    click.option("--address", type=WholeNumber(2), metavar="N", help="Of the module, on a line that several share."),
    ECHO,
)
DIALOGUE = path("--dialogue", help="Write what is said into this new file; by default one beside FILE.")


@dataclass
class SettingOptions:
    """How a module is set, as the command line asks for it."""

    baud: int | None
    checksum: bool | None
    address: int | None
    echo: bool
    crystal: str | None

    @property
    def crystal_hz(self) -> int | None:
        """Its clock, where that is known."""
        return None if self.crystal is None else int(hertz(self.crystal))


def setting_options(function: Function) -> Function:
    """Give a command how a module is set."""
    for option in reversed(SETTING):
        function = option(function)
    return function


def module_options(function: Function) -> Function:
    """Give a command the port of a module, and what it takes to speak to it."""
    return PORT(PART(setting_options(DIALOGUE(MARKINGS(CLOCK(function))))))
