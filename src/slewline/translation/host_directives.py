"""The effect of a script's directives on a motion: what ends it early, and what waits for its end."""

from __future__ import annotations

import re

from ..core.datasheet.table import Pin, Sheet

DRIVES = re.compile(r"@(drive|release|until|pulse)\s+(\w+\.)?(\w+)(?:\s*=\s*([01]))?\s*(.*)")
OVER = ("running", "moving", "motion_complete", "ready")  # roles of outputs that show the end of a motion or program
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


def waits_for_end(text: str, sheet: Sheet) -> bool:
    """Return whether a directive waits until no motion is in progress."""
    if text in ("wait motion_complete", "@until ready"):
        return True
    match = DRIVES.fullmatch(text)
    pin = pin_of(sheet, match[3]) if match is not None and match[1] == "until" else None
    return pin is not None and pin.role in OVER


def pin_of(sheet: Sheet, name: str) -> Pin | None:
    """Return a pin by its name; None: there is none."""
    return next((pin for pin in sheet.pins if pin.name == name), None)
