"""Drivers, and the text or table with which users describe a driver, as on a circuit diagram.

driver = "24 V, 1 A"                                        a current source limited by the supply
driver = "24 V, 1.4 A chopper, 20 kHz, slow decay"
driver = "GS-D200, 24 V, 1 A, rest 0.25 A, ramp 1.5 A"
driver = "L/4R 20 V"                                        a series resistor of three times the winding's resistance
driver = "bilevel 24 V 2 ms, 5 V"
driver = "current 1 A, boost"                               an ideal current source
driver = { kind = "averaged", supply = 24, current = 1 }
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from math import sqrt
from types import MappingProxyType
from typing import Any, NamedTuple

from ...core.datasheet.option import Option, checked, defaulted
from ...core.datasheet.units import SPELLED, UNITS, expected, measured
from ...core.messages.near import hint, same_part
from ...errors import UnknownName, UsageError
from .motor_data import Decay, DriverData, DriverKind, MotorData
from .motor_figures import complaint, figure, positive, share
from .motors import MOTORS


class DriverRow(NamedTuple):
    """A driver on the market: its data, the range of its supply, V, and its maximum phase current, A."""

    data: DriverData
    supply: tuple[float, float]
    most: float


GSD = "SGS-Thomson, GS-D200 and GS-D200S data sheet, June 1994"
ST = "SGS-Thomson, L297 (December 2001) and L298 (January 2000) data sheets; oscillator with 22 kohm and 3.3 nF"
A4988 = "Allegro, A4988 data sheet: off-time ROSC / 825, with the 10 kohm of most modules; two phases on at 71 % of 2 A"
DRV = "Texas Instruments, DRV8825 data sheet: fixed PWM frequency, pin DECAY open; two phases on at 71 % of 2.5 A"
TMC = "data sheet: StealthChop as after a reset, 2/683 of the internal clock of 12 MHz; A as r.m.s. value"


def _chopper(
    name: str, frequency: float, low: float, high: float, most: float, source: str, kind: DriverKind = "chopper",
    decay: Decay = "slow", **more: float,
) -> DriverRow:  # fmt: skip
    data = DriverData(name=name, kind=kind, frequency=frequency, decay=decay, source=source, **more)  # type: ignore[arg-type]
    return DriverRow(data, (low, high), most)


DRIVERS: Mapping[str, DriverRow] = MappingProxyType(
    {
        row.data.name: row
        for row in (
            _chopper("GS-D200", 17e3, 10, 46, 2.0, GSD),
            _chopper("GS-D200S", 17e3, 12, 40, 2.5, GSD),
            _chopper("L297+L298", 20e3, 4.8, 46, 2.0, ST),
            _chopper("A4988", 0.0, 8, 35, 1.41, A4988, decay="auto", off_time=12e-6, fast_part=0.3125, least_on=1e-6),
            _chopper("DRV8825", 30e3, 8.2, 45, 1.76, DRV, decay="auto", fast_part=0.75, least_on=3.75e-6),
            _chopper("TMC2208", 35.14e3, 4.75, 36, 1.4, f"Trinamic, TMC220x {TMC}", "averaged"),
            _chopper("TMC2209", 35.14e3, 4.75, 28, 2.0, f"Trinamic, TMC2209 {TMC}", "averaged"),
        )
    }
)

FIGURES = (  # figures of a table, in the order of DriverData
    Option("name", "text", "own", "name of the driver", like="'my driver'"),
    Option("kind", "choice", ..., "circuit", choices=("current", "averaged", "chopper", "voltage", "bilevel")),
    positive("supply", "V", "supply", None),
    positive(
        "current", "A", "current of a phase while two phases are on; by default the rated current of the motor", None
    ),
    figure("series", "ohm", "resistance in series with each winding"),
    figure("lag", "s", "time constant of an ideal current source"),
    positive("high", "V", "high supply of a bilevel driver, used after each change of a phase", None),
    positive("high_time", "s", "duration of the high supply", None),
    positive("frequency", "Hz", "clock frequency of a chopper", 20e3),
    figure("off_time", "s", "pause of a chopper without a clock, instead of a frequency; 0: it has a clock"),
    Option(
        "decay",
        "choice",
        "slow",
        "decay of the current in the pause of a chopper",
        choices=("slow", "fast", "mixed", "auto"),
    ),
    Option("fast_part", "float", 0.3, "fraction of the period or the pause, in mixed and auto decay", check=share),
    figure("least_on", "s", "blanking: minimum on-time of a phase"),
    figure("diode", "V", "voltage drop of the diodes in the pause of a chopper"),
    figure("clamp", "V", "clamping voltage of a half winding that is switched off", 0.7),
    Option("boost", "bool", False, "a phase that is on alone has sqrt(2) times the current"),
    Option("rest", "float", 1.0, "current at rest, as a factor of `current`; or text such as '0.5 A'", low=0),
    Option("slew", "float", 1.0, "current at constant speed, likewise", low=0),
    Option("ramp", "float", 1.0, "current on ramps, likewise", low=0),
    Option("source", "text", "", "source of the figures", like="'data sheet, 2012'"),
)
LEVELS = ("rest", "slew", "ramp")
ALWAYS = ("name", "kind", "clamp", "source")
REGULATED = ("current", "boost", *LEVELS)
TAKES: Mapping[str, tuple[str, ...]] = MappingProxyType(  # figures of a driver in addition to ALWAYS, by kind
    {
        "current": ("lag", *REGULATED),
        "averaged": ("supply", *REGULATED),
        "chopper": ("supply", "frequency", "off_time", "decay", "fast_part", "least_on", "diode", *REGULATED),
        "voltage": ("supply", "series"),
        "bilevel": ("supply", "high", "high_time", "series"),
    }
)
NEEDED = ("supply", "high", "high_time")

SAYINGS: Mapping[str, Mapping[str, Any]] = MappingProxyType(  # parts of a text, and other figures they set
    {
        "{supply:V}": {},
        "{current:A}": {},
        "averaged": {"kind": "averaged"},
        "chopper": {"kind": "chopper"},
        "{frequency:Hz}": {},
        "slow decay": {"decay": "slow"},
        "fast decay": {"decay": "fast"},
        "mixed decay": {"decay": "mixed"},
        "auto decay": {"decay": "auto"},
        "off {off_time:s}": {},
        "current {current:A}": {"kind": "current"},
        "lag {lag:s}": {},
        "L/R {supply:V}": {"kind": "voltage"},
        "L/{times:R} {supply:V}": {"kind": "voltage"},
        "bilevel {high:V} {high_time:s}": {"kind": "bilevel"},
        "series {series:ohm}": {},
        "boost": {"boost": True},
        "rest {rest:A}": {},
        "slew {slew:A}": {},
        "ramp {ramp:A}": {},
        "least on {least_on:s}": {},
        "diode {diode:V}": {},
        "clamp {clamp:V}": {},
    }
)
EXAMPLES = (
    "24 V, 1 A",
    "24 V, 1.4 A chopper, 20 kHz, slow decay",
    "L/R 5 V",
    "L/4R 20 V",
    "bilevel 24 V 2 ms, 5 V",
    "current 1 A, boost",
    "24 V, 1 A, rest 0.5 A, ramp 1.5 A",
)
PART_NUMBER = re.compile(r"[A-Za-z]{1,9}[+-]?[0-9]{2,9}[\w+-]{0,20}")
NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"


def _pattern(form: str) -> re.Pattern[str]:
    """Return the pattern for the parts of a driver's text that have the given form, such as "rest {rest:A}"."""
    found = ""
    for words, name, unit in re.findall(r"([^{]*)(?:\{(\w+):(\w+)\})?", form):
        found += re.escape(words).replace(r"\ ", r"\s+")
        if name:
            units = "|".join(UNITS.get(unit, ("R",)))
            found += rf"(?P<{name}>{NUMBER}\s*(?:{units}))"
    return re.compile(found, re.IGNORECASE if "{" not in form else 0)


def _figures_in(text: str, name: str, motor: MotorData) -> Iterator[tuple[str, str, Any]]:
    """Yield each figure in a driver's text: the part of the text that sets it, its name, and its value."""
    for part in re.sub(r"(?<=[^\s,])\s+(averaged|chopper)\b", r", \1", text, flags=re.IGNORECASE).split(","):
        part = part.strip()
        if part in DRIVERS:
            yield part, "like", part
            continue
        for form, sets in SAYINGS.items():
            if found := _pattern(form).fullmatch(part.translate(SPELLED)):
                yield from ((part, each, value) for each, value in sets.items())
                for each, value in found.groupdict().items():
                    if each == "times":
                        yield part, "series", _in_series(float(value.rstrip(" R")), part, name, motor)
                    else:
                        yield part, each, value
                break
        else:
            forms, last = [form for form in SAYINGS if "{" not in form], part.rpartition(" ")[2]
            meant = (
                same_part(part, DRIVERS) or hint(part, forms) or (hint(last, forms) if len(last) > len("mA") else "")
            )
            if not meant and PART_NUMBER.fullmatch(part):
                meant = f"; drivers with a name: {', '.join(DRIVERS)}; for another driver, set frequency and decay"
            examples = ", ".join(map(repr, EXAMPLES))
            raise UsageError(f"{name} {text!r}: {part!r} is not recognised; examples: {examples}{meant}")


def _in_series(times: float, part: str, name: str, motor: MotorData) -> float:
    """Return the resistance (ohms) of the series resistor of an L/nR driver, where n is `times`."""
    if times < 1:
        raise UsageError(f"{name}: {part!r}; allowed L/1R or more (the winding itself is 1 R), such as L/4R 20 V")
    return (times - 1) * motor.resistance


def _of_text(text: str, name: str, motor: MotorData) -> dict[str, Any]:
    """Return the table of figures that is equivalent to a driver's text."""
    given: dict[str, Any] = {}
    by: dict[str, str] = {}
    for part, each, value in _figures_in(text, name, motor):
        if each in given and given[each] != value:
            raise UsageError(f"{name} {text!r}: {by[each]!r} and {part!r} both set {each}; leave one out")
        given[each], by[each] = value, part
    if "like" not in given:
        given.setdefault("kind", "chopper" if given.keys() & {"frequency", "off_time", "decay"} else "averaged")
    return {"name": text} | given


def read_driver(value: Any, name: str, motor: MotorData) -> DriverData:
    """Return a driver described by text or by a table of figures.

    The text may contain the name of a driver on the market, and the table may contain it under `like`; the
    figures in the text or table then replace those of the named driver.

    Args:
        name: the driver's name in messages.
        motor: the driven motor; its rated current is the default, and its resistance determines L/nR.

    Raises:
        UnknownName: `like` names an unknown driver.
        UsageError: a part of the text is not understood, or a figure does not exist, is missing, or is out
            of range.
    """
    if isinstance(value, DriverData):
        return value
    if not isinstance(value, (str, Mapping)):
        table = ", ".join(row.name for row in FIGURES)
        raise UsageError(f"{name} {value!r}; expected text such as {EXAMPLES[0]!r}, or a table (keys: 'like', {table})")
    given = _of_text(value, name, motor) if isinstance(value, str) else dict(value)
    given = {each: of for each, of in given.items() if of is not None}
    rows: Sequence[Option] = FIGURES
    row = None
    if "like" in given:
        row = _driver_named(given.pop("like"), name)
        rows = defaulted(rows, {each: mine for each, mine in asdict(row.data).items() if mine})
    if given.get("off_time") and "frequency" in given:
        raise UsageError(
            f"{name}: frequency and off_time; a chopper has either a clock (frequency) or a fixed pause (off_time): "
            "leave one out"
        )
    if "frequency" in given:
        given.setdefault("off_time", 0)
    _fitting(given, rows, name)
    current = _regulated(given, name, motor)
    for level in LEVELS:
        if level in given:
            given[level] = _factor(given[level], level, current, name)
    found = checked(name, rows, given, beside=", like")
    driver = DriverData(**{each: of for each, of in found.items() if of is not None} | {"current": current})
    driver = replace(driver, current=driver.phase_current(motor))
    if driver.kind == "bilevel" and not driver.high > driver.supply:
        raise UsageError(f"{name}: 'high' {driver.high:g} V; must be more than the supply ({driver.supply:g} V)")
    return driver if row is None else _within(driver, row, name)


def has_own_clock(value: Any, motor: MotorData) -> bool:
    """Return whether the user named a driver or set a chopper clock or off-time; if not, 20 kHz is assumed."""
    if isinstance(value, DriverData):
        return True
    given = _of_text(value, "driver", motor) if isinstance(value, str) else value or {}
    return any(given.get(each) for each in ("like", "frequency", "off_time"))


def _driver_named(like: object, name: str) -> DriverRow:
    if not isinstance(like, str) or like not in DRIVERS:
        raise UnknownName(f"{name}: 'like' is {like!r}; known: {', '.join(DRIVERS)}{same_part(like, DRIVERS)}")
    return DRIVERS[like]


def _fitting(given: Mapping[str, Any], rows: Sequence[Option], name: str) -> None:
    """Refuse figures that do not exist for the driver's kind, and a driver that lacks a required figure."""
    kind = given.get("kind", rows[1].default)
    if not isinstance(kind, str) or kind not in TAKES:
        return  # `checked` reports it
    for each in given:
        if each not in (*ALWAYS, *TAKES[kind]) and any(each == row.name for row in rows):
            of = ", ".join(other for other, takes in TAKES.items() if each in takes)
            raise UsageError(f"{name}: {each} {given[each]!r}; not for kind {kind!r}, only for: {of}")
    for each in NEEDED:
        if each in TAKES[kind] and each not in given:
            row = next(row for row in rows if row.name == each)
            raise UsageError(f"{name} needs {each}: {replace(row, none=False).allowed}")


def _regulated(given: Mapping[str, Any], name: str, motor: MotorData) -> float:
    """Return the current (A) set by the user, or the motor's rated current if none is set."""
    if "current" not in given:
        return motor.current
    row = next(row for row in FIGURES if row.name == "current")
    return float(row.checked(name, given["current"]))


def _factor(value: Any, level: str, current: float, name: str) -> Any:
    """Return a current level as a factor of `current`; `value` is such a factor, or text such as "0.25 A"."""
    value = float(value) if isinstance(value, str) and re.fullmatch(NUMBER, value) else value
    if not isinstance(value, str):
        return value
    try:
        return measured(value, "A") / current
    except ValueError:
        allowed = expected("A", "a factor of the current")
        raise UsageError(f"{name}: {level} {value!r}; allowed {allowed}") from None


def _within(driver: DriverData, row: DriverRow, name: str) -> DriverData:
    """Return a driver after checking that the data sheet in its row allows its supply voltage and current."""
    low, high = row.supply
    if not low <= driver.supply <= high:
        raise UsageError(f"{name}: supply {driver.supply:g} V; the {row.data.name} allows {low:g}..{high:g} V")
    current = driver.current * max(driver.rest, driver.slew, driver.ramp) * (sqrt(2) if driver.boost else 1)
    if current > row.most * (1 + 1e-9):
        raise UsageError(
            f"{name}: {current:.3g} A per phase; the {row.data.name} allows up to {row.most:g} A: use a smaller current"
        )
    return driver


driver_complaint = complaint(lambda value, name: read_driver(value, name, next(iter(MOTORS.values()))))
