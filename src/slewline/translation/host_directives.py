"""The effect of a script's directives on a motion: which of them end a motion early, and which wait for its end."""

from __future__ import annotations

import re
from collections.abc import Collection

from ..core.datasheet.table import Pin, Sheet

DRIVES = re.compile(r"@(drive|release|until|pulse)\s+(\w+\.)?(\w+)(?:\s*=\s*([01]))?\s*(.*)")
PROGRAM_OVER = ("running",)  # roles of outputs that show the end of a program
OVER = (*PROGRAM_OVER, "moving", "motion_complete", "ready")  # or of a motion
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


def drives_input(text: str, sheet: Sheet) -> bool:
    """Return whether a directive drives a pin that a program may test: an input, or a pin without a role."""
    match = DRIVES.fullmatch(text)
    pin = pin_of(sheet, match[3]) if match is not None and match[1] != "until" else None
    return pin is not None and (pin.role.startswith("input") or not pin.role)


def waits_for_end(text: str, sheet: Sheet, roles: Collection[str] = OVER) -> bool:
    """Return whether a directive waits until the part is ready, or for a pin with one of the given roles."""
    if text == "@until ready" or (text == "wait motion_complete" and "motion_complete" in roles):
        return True
    match = DRIVES.fullmatch(text)
    pin = pin_of(sheet, match[3]) if match is not None and match[1] == "until" else None
    return pin is not None and pin.role in roles


def pin_of(sheet: Sheet, name: str) -> Pin | None:
    """Return the pin with a given name, or None if there is no such pin."""
    return next((pin for pin in sheet.pins if pin.name == name), None)
