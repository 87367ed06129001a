"""The chips of the house: an explicit list, no scanning."""

from __future__ import annotations

from difflib import get_close_matches
from importlib import import_module
from typing import TYPE_CHECKING

from ..errors import UnknownName

if TYPE_CHECKING:
    from ..core.chip import Chip
    from ..core.table import Sheet
    from ..language.lint import Check
    from ..language.ramps import Calculator

PARTS = {  # part: (package, class, name of its sheet, what it is)
    "cy525": ("cy525", "Cy525", "SHEET", "CY525 intelligent ramping stepper motor controller (Cybernetic, 1984)"),
    "gs-c200": ("gs_c200", "GsC200", "GS_C200", "GS-C200 stepper motor controller module (SGS-Thomson, 1994)"),
    "gs-c200s": ("gs_c200", "GsC200S", "GS_C200S", "GS-C200S stepper motor controller module (SGS-Thomson, 1994)"),
    "mc1151a": ("mc1451a", "Mc1151A", "MC1151A", "MC1151A step motor control chipset, 1 axis (PMD, 1997)"),
    "mc1251a": ("mc1451a", "Mc1251A", "MC1251A", "MC1251A step motor control chipset, 2 axes (PMD, 1997)"),
    "mc1451a": ("mc1451a", "Mc1451A", "MC1451A", "MC1451A step motor control chipset, 4 axes (PMD, 1997)"),
    "mc1151a-e": ("mc1451a", "Mc1151AE", "MC1151A_E", "MC1151A-E: MC1151A with encoder input (PMD, 1997)"),
    "mc1251a-e": ("mc1451a", "Mc1251AE", "MC1251A_E", "MC1251A-E: MC1251A with encoder inputs (PMD, 1997)"),
    "mc1451a-e": ("mc1451a", "Mc1451AE", "MC1451A_E", "MC1451A-E: MC1451A with encoder inputs (PMD, 1997)"),
}


def _entry(part: str) -> tuple[str, str, str]:
    try:
        package, cls, sheet, _ = PARTS[part.lower().replace("_", "-")]
        return f"{__name__}.{package}", cls, sheet
    except KeyError:
        near = get_close_matches(part.lower().replace("_", "-"), PARTS, 1)
        remedy = f"; did you mean {near[0]}?" if near else ""
        raise UnknownName(f"no chip {part!r}; there are: {', '.join(PARTS)}{remedy}") from None


def chip_class(part: str) -> type[Chip]:
    """The class of a part by its number, for example "cy525"."""
    package, name, _ = _entry(part)
    return getattr(import_module(package + ".firmware"), name)  # type: ignore[no-any-return]


def checks_of(part: str) -> tuple[Check, ...]:
    """What only the linter of this part knows."""
    package = _entry(part)[0]
    return import_module(package + ".checks").checks(sheet_of(part))  # type: ignore[no-any-return]


def ramps_of(part: str) -> Calculator:
    """Return the ramp calculator of a part.

    Raises:
        UnknownName: no such part; the message says which there are.
    """
    package = _entry(part)[0]
    return import_module(package + ".ramps").ramps(sheet_of(part))  # type: ignore[no-any-return]


def sheet_of(part: str) -> Sheet:
    """The data sheet of a part, without starting anything."""
    package, _, name = _entry(part)
    return getattr(import_module(package + ".sheet"), name)  # type: ignore[no-any-return]
