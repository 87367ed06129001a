"""The chips: the built-in ones, listed explicitly (no scanning), and plug-ins, found by module:Class or entry point.

A plug-in is a class that must define `sheet`.  It may define further attributes that the tools use:

    class Mx10(LineChip):
        sheet = MX10
        checks = (go_without_speed,)     # its lint rules (language/lint.py, Check)
        ramps = Mx10Ramps(MX10)          # its ramp calculator (language/ramp_answers.py, Calculator)
        quirks = (Quirk(...),)           # the gaps in its manual (core/datasheet/quirk.py)

A built-in chip is a folder with the following files; a file that the chip does not need is left out:

    sheet.py         pins, commands, registers, times, LIMITS between edges, OPTIONS, dialect, channels, each with its
                     section of the manual; the commands asm, dis, lint and describe read nothing else
    firmware.py      the class: its objects, and their public properties; other behaviour is an object in a file of
                     its own, and a diagram at the top of firmware.py shows which object knows which
    instructions.py  a method for each command, found by the name of its row (`do_divisor`); a command that only sets,
                     loads or shows a register has no method: a column of its row defines it
    motion.py        generates the steps of a motion
    profile.py       the law of motion: pure functions, parameters in, a plan out; a run is checked
                     before its steps are scheduled (core/motion/plan.py, mc1451a/axis/verified.py)
    twin.py          the same motion step by step, the reference with which tests/laws compares the fast path
    checks.py        lint rules that apply to this chip only
    ramps.py         its ramp calculator; `tried` states the values of a `RampParameter` that `slewline tune` tries,
                     evenly spaced in its `measure`; `script` returns the commands that a host sends for a move
    quirks.py        the model's choices where the manual is silent, each with the test that verifies it

Code that several parts of a family share is in the family's folder (cy5xx); cy5xx/letters.py
lists the letters whose meanings differ between sister parts.  A host's mistake is reported by
`self.finding(code, text)` where the chip detects it, and has a line on the findings page.  An axis sets
`axis.homing` while it homes; if the command selects the pin to seek, it sets `axis.sought` to that pin.

A new chip needs a folder, a line in PARTS below, and the facts of its manual in conformance/.  No other
file of the package names a chip.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

from ..core.chip import Chip
from ..core.datasheet.catalogue import Catalogue
from ..core.datasheet.option import checked
from ..core.datasheet.table import Sheet
from ..errors import UsageError

if TYPE_CHECKING:
    from ..core.datasheet.quirk import Quirk
    from ..language.lint import Check
    from ..language.ramp_answers import Calculator


@dataclass(frozen=True, slots=True, kw_only=True)
class ListedChip:
    """A built-in chip: its description, and where its objects are defined, as `module:name` within its folder.

    `checks` is a function that takes the sheet and returns this chip's lint rules; `ramps` is a function that takes the
    sheet and returns its ramp calculator; `quirks` are the gaps in its manual; `fitted` is a function that takes the
    sheet and all the part's options, and returns the sheet for the tools to use.
    """

    description: str
    folder: str
    chip: str
    sheet: str
    checks: str = "checks:checks"
    ramps: str = "ramps:ramps"
    quirks: str = "quirks:QUIRKS"
    fitted: str = ""


# fmt: off
PARTS = {
    "cy525": ListedChip(folder="cy525", chip="firmware:Cy525", sheet="sheet:SHEET", description="CY525 intelligent ramping stepper motor controller (Cybernetic, 1984)"),
    "cy500": ListedChip(folder="cy500", chip="firmware:Cy500", sheet="sheet:SHEET", description="CY500 stored program stepper motor controller (Cybernetic, 1979)"),
    "cy512": ListedChip(folder="cy512", chip="firmware:Cy512", sheet="sheet:SHEET", description="CY512 intelligent positioning stepper motor controller (Cybernetic, 1981)"),
    "cy545": ListedChip(folder="cy545", chip="firmware:Cy545", sheet="sheet:CY545", fitted="sheet:fitted", description="CY545 stepper system controller (Cybernetic, 1999)"),
    "cy545b": ListedChip(folder="cy545", chip="firmware:Cy545B", sheet="sheet:CY545B", fitted="sheet:fitted", description="CY545B stepper system controller (Cybernetic, 1999)"),
    "gs-c200": ListedChip(folder="gs_c200", chip="firmware:GsC200", sheet="sheet:GS_C200", description="GS-C200 stepper motor controller module (SGS-Thomson, 1994)"),
    "gs-c200s": ListedChip(folder="gs_c200", chip="firmware:GsC200S", sheet="sheet:GS_C200S", description="GS-C200S stepper motor controller module (SGS-Thomson, 1994)"),
    "mc1151a": ListedChip(folder="mc1451a", chip="firmware:Mc1151A", sheet="sheet:MC1151A", description="MC1151A step motor control chipset, 1 axis (PMD, 1997)"),
    "mc1251a": ListedChip(folder="mc1451a", chip="firmware:Mc1251A", sheet="sheet:MC1251A", description="MC1251A step motor control chipset, 2 axes (PMD, 1997)"),
    "mc1451a": ListedChip(folder="mc1451a", chip="firmware:Mc1451A", sheet="sheet:MC1451A", description="MC1451A step motor control chipset, 4 axes (PMD, 1997)"),
    "mc1151a-e": ListedChip(folder="mc1451a", chip="firmware:Mc1151AE", sheet="sheet:MC1151A_E", description="MC1151A-E: MC1151A with encoder input (PMD, 1997)"),
    "mc1251a-e": ListedChip(folder="mc1451a", chip="firmware:Mc1251AE", sheet="sheet:MC1251A_E", description="MC1251A-E: MC1251A with encoder inputs (PMD, 1997)"),
    "mc1451a-e": ListedChip(folder="mc1451a", chip="firmware:Mc1451AE", sheet="sheet:MC1451A_E", description="MC1451A-E: MC1451A with encoder inputs (PMD, 1997)"),
}
# fmt: on


CATALOGUE = Catalogue(
    "chip",
    Chip,
    "slewline.chips",
    {part: f"{__name__}.{row.folder}.{row.chip}" for part, row in PARTS.items()},
    lambda part: part.lower().replace("_", "-"),
)


def listed(part: str) -> ListedChip:
    """Return the row of a built-in part by its number, for example "cy525".

    Raises:
        UnknownName: there is no such part; the message lists the parts.
    """
    row = PARTS.get(CATALOGUE.canonical(part))
    if row is None:
        raise CATALOGUE.unknown(part)
    return row


def chip_class(part: str, *, allow_code: bool = True) -> type[Chip]:
    """Return the class of a chip.

    Args:
        part: the part number, such as "cy525", the name of an entry point, or module:Class.
        allow_code: allow module:Class, whose import runs the code of the module.

    Raises:
        UnknownName: there is no such part; the message lists the parts.
        UsageError: module:Class is not allowed, does not name the class of a chip with a sheet, or the module cannot be
            imported.
    """
    cls = CATALOGUE.load(part, allow_code=allow_code)
    _sheet(cls)
    return cls


def sheet_of(part: str | type[Chip], *, allow_code: bool = True, options: Mapping[str, Any] | None = None) -> Sheet:
    """Return the data sheet of a part, without creating a chip.

    Args:
        part, allow_code: as for `chip_class`; `part` may also be the class itself.
        options: options of the part; the sheet includes the changes that they make, for example to rates.

    Raises:
        UnknownName: as for `chip_class`.
        UsageError: as for `chip_class`; or an option does not exist, or its value is not allowed.
    """
    row = _ours(part)
    if row is not None:
        sheet = _of(row, row.sheet)
    else:
        sheet = _sheet(part if isinstance(part, type) else CATALOGUE.load(part, allow_code=allow_code))
    if options is None:
        return sheet  # type: ignore[no-any-return]
    checked_options = checked(sheet.part, sheet.options, options)
    return _of(row, row.fitted)(sheet, checked_options) if row is not None and row.fitted else sheet  # type: ignore[no-any-return]


def checks_of(part: str | type[Chip], sheet: Sheet | None = None) -> tuple[Check, ...]:
    """Return the part's own lint rules, for `sheet` (default: the part's sheet); raise as `chip_class` does."""
    row = _ours(part)
    if row is not None:
        return _of(row, row.checks)(sheet or sheet_of(part))  # type: ignore[no-any-return]
    found = _named(part, "checks", ())
    if not isinstance(found, tuple) or not all(callable(check) for check in found):
        raise UsageError(f"{_called(part)}.checks: found {found!r}; expected a tuple of functions that take a source")
    return found


def ramps_of(part: str | type[Chip], options: Mapping[str, Any] | None = None) -> Calculator:
    """Return the ramp calculator of a part, with the part's options applied.

    Raises:
        UnknownName, UsageError: as for `sheet_of`; also UsageError if the part has no ramp calculator.
    """
    row = _ours(part)
    if row is not None:
        return _of(row, row.ramps)(sheet_of(part, options=options))  # type: ignore[no-any-return]
    from ..language.ramp_answers import Calculator

    found = _named(part, "ramps", None)
    if not isinstance(found, Calculator):
        wrong = "no ramp calculator" if found is None else f"ramps: found {found!r}"
        raise UsageError(
            f"{_called(part)}: {wrong}; set `ramps` of the class to a Calculator of language/ramp_answers.py"
        )
    return found


def quirks_of(part: str | type[Chip]) -> tuple[Quirk, ...]:
    """Return the gaps in the manual of a part, with the model's choices; raise as `chip_class` does."""
    row = _ours(part)
    if row is not None:
        return _of(row, row.quirks)  # type: ignore[no-any-return]
    return tuple(_named(part, "quirks", ()))


def _ours(part: str | type[Chip]) -> ListedChip | None:
    """Return the row of a built-in part; None for a plug-in."""
    return PARTS.get(CATALOGUE.name_of(part) if isinstance(part, type) else CATALOGUE.canonical(part))


def _of(row: ListedChip, place: str) -> Any:
    module, _, name = place.partition(":")
    return getattr(import_module(f"{__name__}.{row.folder}.{module}"), name)


def _named(part: str | type[Chip], attribute: str, default: Any) -> Any:
    """Return an attribute of a plug-in's class, or the default if the class does not define it."""
    return getattr(part if isinstance(part, type) else chip_class(part), attribute, default)


def _called(part: str | type[Chip]) -> str:
    return part if isinstance(part, str) else CATALOGUE.name_of(part)


def _sheet(cls: type[Chip]) -> Sheet:
    found = getattr(cls, "sheet", None)
    if not isinstance(found, Sheet):
        wrong = "no sheet" if found is None else f"sheet: found {found!r}"
        raise UsageError(f"{CATALOGUE.name_of(cls)}: {wrong}; set it in the class: sheet = Sheet(...)")
    return found
