"""Directives of a script that drive a pin."""

from __future__ import annotations

import re

from ..core.datasheet.table import Pin, Sheet

DRIVES = re.compile(r"@(drive|release|until|pulse)\s+(\w+\.)?(\w+)(?:\s*=\s*([01]))?\s*(.*)")
ENDING = ("abort", "end", "end_plus", "end_minus")  # roles of inputs that end a motion


def ends_motion(text: str, sheet: Sheet) -> bool:
    """Return whether a directive may end a motion before its last step."""
    if text.startswith(("@reset", "@power")):
        return True
    match = DRIVES.fullmatch(text)
    if match is None or match[1] not in ("drive", "pulse"):
        return False
    pin = pin_of(sheet, match[3])
    return pin is not None and pin.role in ENDING and (match[1] == "pulse" or match[4] == str(pin.active))


def pin_of(sheet: Sheet, name: str) -> Pin | None:
    """Return a pin by its name; None: there is none."""
    return next((pin for pin in sheet.pins if pin.name == name), None)
