"""The converter of motions, and of the settings of motions, to the target's instructions."""

from __future__ import annotations

from ...core.datasheet.table import Sheet
from ..meaning import (
    Action,
    Home,
    MoveBy,
    MoveTo,
    RunEndless,
    SetDirection,
    SetDistance,
    SetEndless,
    SetPosition,
    SetProfile,
    SetTarget,
    Stop,
)
from ..rows_of_roles import rows_by_role, stopping_row
from ..translation_report import LineKind, LineVerdict
from .base import ActionWriter, Impossible
from .layout import ResultPiece
from .limits import no_command


class MotionWriter(ActionWriter):
    """A converter of motions and their settings to the target's instructions."""

    # ---------------------------------------------------------------------------------------------- settings of motions
    def on_setprofile(self, action: SetProfile) -> list[ResultPiece]:
        """Return the instructions that set a rate or a ramp."""
        commands, verdicts = self.rates.setting(action)
        self.verdicts += verdicts
        return [ResultPiece(row, (value,)) for row, value in commands]

    def on_setdistance(self, action: SetDistance) -> list[ResultPiece]:
        """Return the instructions that set the steps of relative moves; none if the target's moves contain them."""
        row = self.rows.get("distance")
        if row is None:
            return []
        self.known_values["distance"] = self.fitting(row, row.args[0], action.steps, "split it into several moves")
        self.replaced = False
        return [ResultPiece(row, (action.steps,))]

    def on_setdirection(self, action: SetDirection) -> list[ResultPiece]:
        """Return the instructions that set the direction of relative moves; none if the target's moves contain it."""
        row = self.rows.get("plus" if action.sign > 0 else "minus")
        if row is None:
            return []
        self.known_values["sign"] = action.sign
        return [ResultPiece(row)]

    def on_settarget(self, action: SetTarget) -> list[ResultPiece]:
        """Return the instructions that set the position for the next motion; none if the motion contains it."""
        row = self.rows.get("target")
        return [] if row is None else [ResultPiece(row, (self.fitting(row, row.args[0], action.position),))]

    def on_setendless(self, action: SetEndless) -> list[ResultPiece]:
        """Return the instructions that make the next motion endless; none if the target's run command does so."""
        if "endless" in self.rows:
            return []
        return [ResultPiece(self.row("endless_next"))]

    def on_setposition(self, action: SetPosition) -> list[ResultPiece]:
        """Return the instructions that set the position counter."""
        row, clear = self.rows.get("preset"), self.rows.get("clear")
        if row is not None and (action.block < 0 or row.stored):
            if row.args:
                return [ResultPiece(row, (self.fitting(row, row.args[0], action.position),))]
            if not action.position:
                return [ResultPiece(row)]
            raise Impossible(f"position {action.position}", f"{row.form} sets the position to zero ({row.where})")
        if clear is not None and not action.position and (clear.stored or action.block < 0):
            return [ResultPiece(clear, (1,))]
        limit = (
            no_command(self.sheet, "preset") if action.block < 0 else f"{no_command(self.sheet, 'preset')} in a program"
        )
        raise Impossible(f"position {action.position}", limit, "count positions from the home position")

    # --------------------------------------------------------------------------------------------------------- motions
    def on_moveby(self, action: MoveBy) -> list[ResultPiece]:
        """Return the instructions for a relative move."""
        row = self.rows.get("move") or self.row("update")
        if row.role == "update":
            description = "the position before it is unknown: a motion may have ended early"
            raise Impossible(description, no_command(self.sheet, "move"), "let the host read the position")
        if row.args:
            if action.steps is None:
                raise Impossible(
                    "steps and direction depend on the path",
                    f"{row.form} has both in one command ({row.where})",
                    "write a move for each path",
                )
            found = [ResultPiece(row, (self.fitting(row, row.args[0], action.steps, "split it into several moves"),))]
        else:
            found = [*self.set_move(action), ResultPiece(row)]
        self.note(self.rates.motion(action))
        return found

    def set_move(self, action: MoveBy) -> list[ResultPiece]:
        """Return the instructions that set distance and direction before a move, unless they are already set."""
        found: list[ResultPiece] = []
        if action.sign is not None and self.known_values.get("sign") != action.sign and not self.sets(SetDirection):
            found.append(ResultPiece(self.row("plus" if action.sign > 0 else "minus")))
            self.known_values["sign"] = action.sign
        row = self.row("distance")
        single = self.is_single(action)
        left = self.replaced or single or not self.sets(SetDistance)
        if action.distance is not None and self.known_values.get("distance") != action.distance and left:
            self.fitting(row, row.args[0], action.distance, "split it into several moves")
            found.append(ResultPiece(row, (action.distance,)))
            self.known_values["distance"] = action.distance
            self.replaced = single
        return found

    def sets(self, kind: type[Action]) -> bool:
        """Return whether the source sets the distance or the direction with a separate command.

        `kind` is SetDistance for the distance, or SetDirection for the direction.
        """
        return ("distance" if kind is SetDistance else "plus") in rows_by_role(self.source)

    def on_moveto(self, action: MoveTo) -> list[ResultPiece]:
        """Return the instructions for a move to a position."""
        row = self.rows.get("absolute") or self.rows.get("goto")
        self.known_values.pop("sign", None)
        if action.position is None:
            raise Impossible("the position depends on the path", no_command(self.sheet, "goto"))
        if row is None:
            return self.targeted(action)
        self.fitting(row, row.args[0], action.position, "count positions from another reference")
        self.note(self.rates.motion(action))
        return [ResultPiece(row, (action.position,))]

    def targeted(self, action: MoveTo) -> list[ResultPiece]:
        """Return the instructions for a move to a position: one command sets the position, then another moves."""
        assert action.position is not None  # noqa: S101
        row, go, found = self.row("target"), self.rows.get("update") or self.row("move"), []
        if action.steps == 0 and go.role == "update":  # a motion that would never be complete
            return []
        if not isinstance_target(action, self.source):
            found.append(ResultPiece(row, (self.fitting(row, row.args[0], action.position),)))
        if "plus" in self.rows:
            if action.steps is None:
                raise Impossible(
                    "the direction depends on the path",
                    f"{row.form} does not find the direction by itself ({row.where})",
                )
            if action.steps and self.known_values.get("sign") != (sign := 1 if action.steps > 0 else -1):
                found.append(ResultPiece(self.row("plus" if sign > 0 else "minus")))
                self.known_values["sign"] = sign
        self.note(self.rates.motion(action))
        if go.role != "update":
            self.known_values.pop("distance", None)
            self.replaced = True
            return [*found, ResultPiece(go)]
        found += [*(ResultPiece(row) for row in self.sheet.acting("clear_events")), ResultPiece(go)]
        wait = ResultPiece(text="wait motion_complete", source=action.line)
        if id(action) in self.left_running:
            self.unended = wait
            return found
        return [*found, wait]

    def on_runendless(self, action: RunEndless) -> list[ResultPiece]:
        """Return the instructions for an endless run or, if `until` is set, for a run until an input is low."""
        if action.until is not None:
            row = self.row("until_input")
            self.conditions.check(action.until.number)
            if action.sign is None or action.until.level:
                raise Impossible("", f"{row.form} runs until the input is low ({row.where})")
            return [ResultPiece(row, (action.sign, action.until.number))]
        if "endless" in self.rows:
            if action.sign is None:
                raise Impossible("the direction depends on the path", no_command(self.sheet, "plus"))
            return [ResultPiece(self.rows["endless"], (action.sign,))]
        row, found = self.row("endless_next"), []
        if not self.sets(SetDirection) and action.sign is not None:
            found.append(ResultPiece(self.row("plus" if action.sign > 0 else "minus")))
        number = self.row("distance")
        if not self.sets(SetDistance):
            found.append(ResultPiece(number, (number.args[0].high,)))
        self.known_values.clear()
        stated = [] if "endless_next" in rows_by_role(self.source) else [ResultPiece(row)]
        return [*found, *stated, ResultPiece(self.row("move"))]

    def on_home(self, action: Home) -> list[ResultPiece]:
        """Return the instructions for a homing run."""
        row = self.row("home")
        if row.args[0].sign == "alone" and action.block < 0:
            return [ResultPiece(row, (action.sign,))]
        raise Impossible("homing", f"{row.form} finds the direction itself ({row.where})", "write the homing by hand")

    def on_stop(self, action: Stop) -> list[ResultPiece]:
        """Return the instructions that end a motion."""
        row = stopping_row(self.sheet, "brake" if action.ramped else "stop")
        if row is not None:
            return self.directives.stopping(row)
        directive = self.directives.stop()
        if directive is None:
            raise Impossible(
                "stops a motion", f"no command of the {self.sheet.part.upper()} stops a motion ({self.sheet.manual})"
            )
        if action.ramped:
            self.note(LineVerdict(action.line, LineKind.SAME, "by the pin, along the ramp"))
        else:
            limit = (
                f"no command of the {self.sheet.part.upper()} stops a motion at the current step ({self.sheet.manual})"
            )
            remedy = "switch the driver off where a motion must stop immediately"
            self.note(LineVerdict(action.line, LineKind.IMPOSSIBLE, "stops along the ramp", limit, remedy))
        return [ResultPiece(text=text) for text in directive]


def isinstance_target(action: MoveTo, source: Sheet) -> bool:
    """Return whether the source sets the target of a move by a separate command, which is translated earlier."""
    return "target" in rows_by_role(source) and action.command != "" and not action.values
