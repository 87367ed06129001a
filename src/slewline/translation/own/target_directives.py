"""A host's directives between commands: pins, translated by their roles, and waits until the part is ready."""

from __future__ import annotations

import re

from ...core.datasheet.table import Pin, Row, Sheet
from ..host_directives import DRIVES, pin_of
from ..rows_of_roles import stopping_row, waits_for_update
from .layout import ResultPiece

NEUTRAL = ("wait", "note", "to", "tell", "power", "reset")
IDLE = ("running", "moving", "motion_complete")
ALIKE = {"motion_complete": "moving", "moving": "motion_complete"}


class Directives:
    """A translator of a script's directives from one part to another.

    Attributes:
        stored: whether the script enters or runs a stored program.
        end_pin: an output that programs set high at their end; empty: there is none.
    """

    def __init__(self, source: Sheet, sheet: Sheet) -> None:
        self.source, self.sheet, self.stored, self.end_pin = source, sheet, False, ""

    def idle(self) -> list[str] | str:
        """Return the directive that waits until no program runs, or a text stating why the target has none."""
        sheet = self.sheet
        if sheet.enter is None:
            return [waiting(sheet, ("moving",))]
        if self.end_pin:
            return [f"@until {self.end_pin}=1"]
        if self.stored and hides_the_end(sheet):
            return f"no pin of the {sheet.part.upper()} shows the end of a program ({sheet.manual})"
        return [waiting(sheet, ("running", "ready"))]

    def stop(self) -> list[str] | None:
        """Return the directives that stop a motion by the abort pin, or None if the target has no such pin."""
        pin = self.sheet.role("abort")
        if pin is None or pin.active is None:
            return None
        return [f"@drive {pin.name}={pin.active}", at_rest(self.sheet), f"@drive {pin.name}={1 - pin.active}"]

    def stopping(self, row: Row) -> list[ResultPiece]:
        """Return the stop command `row`, followed by an update command if the stop takes effect only at an update."""
        update = next(iter(self.sheet.acting("update")), None)
        return [ResultPiece(row), *([ResultPiece(update)] if waits_for_update(row) and update is not None else [])]

    def translated(self, text: str) -> list[str] | str:
        """Return the target's directives that replace a directive, or a text stating why it cannot be translated."""
        if self.source is self.sheet or (self.source.enter is None and self.sheet.enter is None and "=" not in text):
            return [text]  # the same host
        verb, _, rest = text.removeprefix("@").partition(" ")
        rest = rest.strip()
        if verb == "wait" and re.fullmatch(r"!?[A-Za-z_]+", rest):
            return (
                [at_rest(self.sheet)]
                if rest == "motion_complete"
                else f"the {self.sheet.part.upper()} has no status {rest}"
            )
        if verb in NEUTRAL and not (verb == "reset" and self.sheet.role("reset") is None):
            return [text]
        if verb == "until" and rest == "ready":
            return self.idle()
        if verb == "until" and rest.startswith("position"):
            return [text]
        match = DRIVES.fullmatch(text)
        if match is None:
            return f"@{verb} is for the host of a {self.source.part.upper()}"
        return self._pin(*match.groups())

    def _pin(self, verb: str, chip: str | None, name: str, level: str | None, rest: str) -> list[str] | str:
        """Translate a directive about a pin of the source's part.

        Returns:
            The directives for the target; or, if there are none, a text stating why.
        """
        chip = chip or ""
        theirs = pin_of(self.source, name)
        if theirs is None:
            return [f"@{verb} {chip}{name}{f'={level}' if level else ''} {rest}".strip()]
        if verb == "until" and theirs.role in IDLE and level is not None and int(level) == over(theirs):
            return self.idle() if theirs.role == "running" else [at_rest(self.sheet)]
        mine = self.sheet.role(theirs.role, theirs.axis) if theirs.role else None
        if mine is None and theirs.role in ALIKE:
            mine = self.sheet.role(ALIKE[theirs.role], theirs.axis)
        if theirs.role == "abort" and mine is None:
            return self._braked(theirs, verb, level)
        if mine is None:
            return f"the {self.sheet.part.upper()} has no pin for {theirs.role or name} ({self.sheet.manual})"
        if mine.output_only and verb != "until":
            return f"{mine.name} of the {self.sheet.part.upper()} is an output ({self.sheet.manual})"
        shown = "" if level is None else f"={self._level(theirs, mine, int(level))}"
        return [f"@{verb} {chip}{mine.name}{shown}{f' {rest}' if rest and not rest.startswith('@') else rest}".rstrip()]

    def _braked(self, theirs: Pin, verb: str, level: str | None) -> list[str] | str:
        """Return the target's stop command for a directive that activates an abort pin.

        If the target has no such command, return a text that states this.
        """
        row = stopping_row(self.sheet, "brake")
        if row is None:
            return f"the {self.sheet.part.upper()} has no abort input ({self.sheet.manual})"
        return (
            [str(piece.row.form) for piece in self.stopping(row) if piece.row is not None]
            if verb == "drive" and level is not None and int(level) == theirs.active
            else []
        )

    @staticmethod
    def _level(theirs: Pin, mine: Pin, level: int) -> int:
        """Return the level that means the same at the target's pin as `level` does at the source's pin."""
        if theirs.role in ALIKE and mine.role != theirs.role:
            return over(mine) if level == over(theirs) else 1 - over(mine)
        if theirs.sense is None or mine.sense is None or theirs.role.startswith(("input", "output")):
            return level
        return mine.sense if level == theirs.sense else 1 - mine.sense


def hides_the_end(sheet: Sheet) -> bool:
    """Return whether a part hides the end of a program: neither a pin nor the answer to a query shows it."""
    return sheet.role("running") is None and not sheet.acting("state")


def over(pin: Pin) -> int:
    """Return the level at which a pin shows that a program, a command or a motion has ended."""
    sense = pin.sense if pin.sense is not None else 1
    return sense if pin.role in ("motion_complete", "ready") else 1 - sense


def at_rest(sheet: Sheet) -> str:
    """Return the directive that waits until a motion has ended."""
    return waiting(sheet, ("motion_complete", "ready") if sheet.enter is not None else ("moving",))


def waiting(sheet: Sheet, roles: tuple[str, ...]) -> str:
    """Return the directive that waits until a part is ready.

    For a module, this is "@until ready".  For any other part, it waits for a pin: `roles` are tried in order,
    and the first role that a pin of the part has determines the pin.
    """
    if sheet.acting("state"):
        return "@until ready"
    pin = next(pin for role in roles if (pin := sheet.role(role)) is not None)
    return f"@until {pin.name}={over(pin)}"
