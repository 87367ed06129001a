"""The chips of the house: an explicit list, no scanning."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from importlib import import_module
from typing import TYPE_CHECKING, Any

from ..errors import UnknownName

if TYPE_CHECKING:
    from ..core.chip import Chip
    from ..core.quirk import Quirk
    from ..core.table import Sheet
    from ..language.lint import Check
    from ..language.ramps import Calculator


@dataclass(frozen=True, slots=True, kw_only=True)
class Listed:
    """A chip of the house: what it is, and where its things are, as `module:name` within its folder.

    `checks` is a function of the sheet: what only the linter of this chip knows; `ramps` one that returns its ramp
    calculator; `quirks` are what its manual leaves open.
    """

    says: str
    folder: str
    chip: str
    sheet: str
    checks: str = "checks:checks"
    ramps: str = "ramps:ramps"
    quirks: str = "quirks:QUIRKS"


# fmt: off
PARTS = {
    "cy525": Listed(folder="cy525", chip="firmware:Cy525", sheet="sheet:SHEET", says="CY525 intelligent ramping stepper motor controller (Cybernetic, 1984)"),
    "cy500": Listed(folder="cy500", chip="firmware:Cy500", sheet="sheet:SHEET", says="CY500 stored program stepper motor controller (Cybernetic, 1979)"),
    "cy512": Listed(folder="cy512", chip="firmware:Cy512", sheet="sheet:SHEET", says="CY512 intelligent positioning stepper motor controller (Cybernetic, 1981)"),
    "gs-c200": Listed(folder="gs_c200", chip="firmware:GsC200", sheet="sheet:GS_C200", says="GS-C200 stepper motor controller module (SGS-Thomson, 1994)"),
    "gs-c200s": Listed(folder="gs_c200", chip="firmware:GsC200S", sheet="sheet:GS_C200S", says="GS-C200S stepper motor controller module (SGS-Thomson, 1994)"),
    "mc1151a": Listed(folder="mc1451a", chip="firmware:Mc1151A", sheet="sheet:MC1151A", says="MC1151A step motor control chipset, 1 axis (PMD, 1997)"),
    "mc1251a": Listed(folder="mc1451a", chip="firmware:Mc1251A", sheet="sheet:MC1251A", says="MC1251A step motor control chipset, 2 axes (PMD, 1997)"),
    "mc1451a": Listed(folder="mc1451a", chip="firmware:Mc1451A", sheet="sheet:MC1451A", says="MC1451A step motor control chipset, 4 axes (PMD, 1997)"),
    "mc1151a-e": Listed(folder="mc1451a", chip="firmware:Mc1151AE", sheet="sheet:MC1151A_E", says="MC1151A-E: MC1151A with encoder input (PMD, 1997)"),
    "mc1251a-e": Listed(folder="mc1451a", chip="firmware:Mc1251AE", sheet="sheet:MC1251A_E", says="MC1251A-E: MC1251A with encoder inputs (PMD, 1997)"),
    "mc1451a-e": Listed(folder="mc1451a", chip="firmware:Mc1451AE", sheet="sheet:MC1451A_E", says="MC1451A-E: MC1451A with encoder inputs (PMD, 1997)"),
}
# fmt: on


def listed(part: str) -> Listed:
    """Return the row of a part by its number, for example "cy525".

    Raises:
        UnknownName: no such part; the message says which there are.
    """
    number = part.lower().replace("_", "-")
    if number in PARTS:
        return PARTS[number]
    near = get_close_matches(number, PARTS, 1)
    remedy = f"; did you mean {near[0]}?" if near else ""
    raise UnknownName(f"no chip {part!r}; there are: {', '.join(PARTS)}{remedy}")


def _of(row: Listed, place: str) -> Any:
    module, _, name = place.partition(":")
    return getattr(import_module(f"{__name__}.{row.folder}.{module}"), name)


def chip_class(part: str) -> type[Chip]:
    """Return the class of a part, for example of "cy525"; raises UnknownName as `listed`."""
    row = listed(part)
    return _of(row, row.chip)  # type: ignore[no-any-return]


def sheet_of(part: str) -> Sheet:
    """Return the data sheet of a part, without starting anything; raises UnknownName as `listed`."""
    row = listed(part)
    return _of(row, row.sheet)  # type: ignore[no-any-return]


def checks_of(part: str) -> tuple[Check, ...]:
    """Return what only the linter of this part knows; raises UnknownName as `listed`."""
    row = listed(part)
    return _of(row, row.checks)(sheet_of(part))  # type: ignore[no-any-return]


def ramps_of(part: str) -> Calculator:
    """Return the ramp calculator of a part; raises UnknownName as `listed`."""
    row = listed(part)
    return _of(row, row.ramps)(sheet_of(part))  # type: ignore[no-any-return]


def quirks_of(part: str) -> tuple[Quirk, ...]:
    """Return what the manual of a part leaves open, and what the model does; raises UnknownName as `listed`."""
    row = listed(part)
    return _of(row, row.quirks)  # type: ignore[no-any-return]
