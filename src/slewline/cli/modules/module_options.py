"""Options of the commands for a real module: its port, its part, and its settings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

import click

from ...core.time.timebase import hertz
from ..options.command_kinds import ChipOption
from ..options.shared import path
from ..options.values import FREQUENCY, PartName, WholeNumber

if TYPE_CHECKING:
    from ...core.datasheet.table import Sheet
    from ...modules.module import Module
    from ...modules.raw import RawRecord

Function = TypeVar("Function", bound=Callable[..., Any])


def chip_option(description: str, *, required: bool = True) -> Callable[[Function], Function]:
    """Return a decorator that adds the option --chip, whose value is the part number of a module."""
    return click.option(
        "--chip", "part", cls=ChipOption, type=PartName(), metavar="CHIP", required=required, help=description
    )


MARKINGS = click.option("--markings", metavar="TEXT", help="The text printed on the module, for the record.")
CLOCK = click.option("--crystal", type=FREQUENCY, help="Clock of the module, such as '11 MHz', if known.")
PORT = click.argument("port")
PART = chip_option(
    "The part number of the module; by default the extension of FILE, such as .gs-c200s.", required=False
)
ECHO = click.option(
    "--echo", is_flag=True, help="The line echoes sent characters, as an RS-485 adapter does: drop the echo."
)
SETTING = (
    click.option(
        "--baud",
        type=WholeNumber(9600),
        metavar="RATE",
        help="Rate of the module; by default it is searched for, or 9600.",
    ),
    click.option(
        "--checksum/--no-checksum", default=None, help="Lines have checksums, or not; by default this is detected."
    ),
    click.option("--address", type=WholeNumber(2), metavar="N", help="Address of the module, on a shared line."),
    ECHO,
)
DIALOGUE = path("--dialogue", help="Record the dialogue in this new file; by default one next to FILE.")


@dataclass
class SettingOptions:
    """The options for the settings of a module: rate, checksums, address, echo and clock."""

    baud: int | None
    checksum: bool | None
    address: int | None
    echo: bool
    crystal: str | None

    @property
    def crystal_hz(self) -> int | None:
        """The clock frequency of the module, Hz; None if unknown."""
        return None if self.crystal is None else int(hertz(self.crystal))

    def found(self, port: str, sheet: Sheet, raw: RawRecord | None = None, *, may_move: bool) -> Module:
        """Find the module at a port, and return it once it has answered; raise the same errors as `find`."""
        from ...modules.finding import find
        from ..live.serve import remark

        return find(
            port,
            sheet,
            baud=self.baud,
            checked=self.checksum,
            address=self.address,
            may_move=may_move,
            echo=self.echo,
            raw=raw,
            report=remark,
        )


def setting_options(function: Function) -> Function:
    """Add the options for the settings of a module to a command."""
    for option in reversed(SETTING):
        function = option(function)
    return function


def module_options(function: Function) -> Function:
    """Add PORT, --chip, the options for settings, --dialogue, --markings and --crystal to a command."""
    return PORT(PART(setting_options(DIALOGUE(MARKINGS(CLOCK(function))))))
