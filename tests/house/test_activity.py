"""Firmware reads and drives a pin by the name of its activity, `is_active` and `activate()`, where its row has one.

Which level that is stands in the sheet, once.  The attributes that hold such pins are found in the chips themselves, as
they are on a bench, and then looked for in the files of their firmware.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import slewline
from slewline.chips import PARTS
from slewline.core.datasheet.table import Pin
from slewline.core.wires.net import Driver, Net
from slewline.core.wires.pin import Terminal

CHIPS = Path(__file__).parents[2] / "src/slewline/chips"
INFORMATION = {  # roles, and names, of pins whose level itself is what they say, though a sheet names one of the two
    *("data", "direction", "xdir", "select", "text", "flow", "command", "serial_in", "serial_out"),
    *(f"output{n}" for n in (1, 2, 3)),
    *("input1", *(f"usrb{n}" for n in range(8))),  # programs wait for either level
}
READS, DRIVES, WAITS = ("level", "value"), ("drive", "put"), ("level", "polled")
pytestmark = pytest.mark.check


def named(row: Pin) -> bool:
    """Does a row name an activity?"""
    return row.active is not None and INFORMATION.isdisjoint((row.role, row.name))


def held(owner: object, pins: dict[int, Pin], seen: set[int]) -> Iterator[tuple[str, Pin]]:
    """The attributes of the objects of a firmware that hold a pin, or a collection of pins, each with the row."""
    seen.add(id(owner))
    for name, value in vars(owner).items():
        several = value.values() if isinstance(value, dict) else value if isinstance(value, list | tuple) else [value]
        for one in several:
            if isinstance(one, Net | Driver | Terminal):
                if (row := pins.get(id(one))) is not None:
                    yield name, row
            elif (
                type(one).__module__.startswith("slewline.chips.") and id(one) not in seen and hasattr(one, "__dict__")
            ):
                yield from held(one, pins, seen)


def active_names() -> set[str]:
    """The attributes that hold pins with an activity, in any chip; and the names of these pins."""
    names = set()
    for part in PARTS:
        chip = slewline.Bench().add(part)
        rows = {pin.row.name: pin.row for pin in chip.pins.values()}
        pins = {id(pin.net): pin.row for pin in chip.pins.values() if pin.row.role != "data"}
        pins |= {id(pin): pin.row for pin in chip.pins.values()}
        pins |= {id(driver): rows[name] for name, driver in chip.drivers.items()}
        found = [*held(chip, pins, set()), *rows.items()]
        names |= {name for name, row in found if named(row)} - {name for name, row in found if not named(row)}
    return names


def tail(node: ast.expr) -> str:
    """The name by which code reaches a pin: `request` of self.port.request.net, `rec` of pins["rec"]."""
    if isinstance(node, ast.Attribute):
        return tail(node.value) if node.attr == "net" else node.attr
    if isinstance(node, ast.Subscript):
        literal = isinstance(node.slice, ast.Constant) and isinstance(node.slice.value, str)
        return str(node.slice.value) if literal and isinstance(node.slice, ast.Constant) else tail(node.value)
    return node.id if isinstance(node, ast.Name) and node.id not in ("net", "pin") else ""  # those are one of several


def literal(node: ast.expr) -> bool:
    """Is it 0 or 1, or one of these by a condition?"""
    if isinstance(node, ast.IfExp):
        return literal(node.body) or literal(node.orelse)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
        return node.func.id == "int"
    return isinstance(node, ast.Constant) and type(node.value) is int and node.value in (0, 1)


def by_level(source: str, names: set[str]) -> Iterator[int]:
    """The lines of a source that read or drive one of these pins by 0 or 1, or wait for such a level."""
    for node in ast.walk(ast.parse(source)):
        match node:
            case ast.Compare(left=ast.Attribute(attr=read, value=pin), comparators=[right]) if read in READS:
                found = literal(right)
            case ast.Call(func=ast.Attribute(attr=how, value=pin), args=[level, *_]) if how in DRIVES:
                found = literal(level)
            case ast.Call(func=ast.Attribute(attr=how) | ast.Name(id=how), args=[pin, level, *_]) if how in WAITS:
                found = literal(level)
            case ast.Tuple(elts=[pin, level]):
                found = literal(level)
            case _:
                continue
        if found and tail(pin) in names:
            yield node.lineno


def firmware() -> list[Path]:
    """The files of firmware: all but the twins, which are written apart from it, by levels."""
    return sorted(path for path in CHIPS.rglob("*.py") if "twin" not in str(path.relative_to(CHIPS)))


def test_a_level_of_a_pin_with_an_activity_is_found_in_each_form() -> None:
    faults = """
if self.abort.level == 0: pass
if chip.pins["abort"].net.value != 1: pass
self.port.ready.drive(1 if on else None)
self.ready.put(0)
await chip.polled(self.abort, 1, poll)
await level(abort, 0)
pairs = [(self.abort, 0)]
self.ready.drive(int(rest))
"""
    fine = """
if self.wait.level == 0: pass
self.ready.drive(self.ready.active_level)
self.abort.is_active, self.ready.put(level), (self.abort, wanted)
"""
    assert sorted(by_level(faults, {"abort", "ready"})) == list(range(2, 10))
    assert not list(by_level(fine, {"abort", "ready"}))


def test_firmware_goes_by_the_activity_of_pins() -> None:
    names = active_names()
    assert names >= {"abort", "request", "inhibit_abort", "limits", "enable", "mov", "slct", "ready_driver", "rec"}
    assert not names & {"direction", "dir", "wait", "programmable_output", "select", "usrb0"}
    found = [
        f"{path.relative_to(CHIPS)}:{line}" for path in firmware() for line in by_level(path.read_text("utf-8"), names)
    ]
    assert not found, f"write is_active, when_active, activate(): the level is in the sheet: {', '.join(found)}"
