"""The base of all action converters: copied commands, limits, and settings needed by the first motion."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence

from ...core.datasheet.table import Arg, Row, Sheet
from ...language.dialect import dialect_of
from ..host_directives import waits_for_end
from ..meaning import (
    Action,
    EndProgram,
    EnterProgram,
    HostDirective,
    Jump,
    Label,
    LeaveProgram,
    Loop,
    Motion,
    MoveBy,
    MoveTo,
    Profile,
    RunEndless,
    RunProgram,
    SetDirection,
    SetDistance,
    SetPosition,
    SetProfile,
    acts_during_motion,
)
from ..rows_of_roles import after_reset, rows_by_role, takes_part
from ..translation_report import LineKind, LineVerdict
from .conditions import CannotTest, Conditions
from .layout import ResultPiece, has_tokens
from .limits import no_command, out_of
from .nearest_rates import Rates
from .target_directives import Directives

FULL_STEPS = 4  # patterns of the phases; above these the parts differ


class Impossible(Exception):
    """An error: the target cannot perform an action; `limit` prevents it, and `remedy` is advice to the user."""

    def __init__(self, description: str, limit: str, remedy: str = "") -> None:
        super().__init__(description)
        self.description, self.limit, self.remedy = description, limit, remedy


class ActionWriter:
    """The base class of converters of actions to the target's instructions."""

    def __init__(self, source: Sheet, sheet: Sheet, hz: int, rates: Rates, used: Mapping[str, Collection[int]]) -> None:
        self.source, self.sheet, self.hz, self.rates = source, sheet, hz, rates
        self.rows = rows_by_role(sheet)
        self.verbatim = not any(has_tokens(dialect_of(each)) for each in (source, sheet))
        self.conditions = Conditions(sheet, used["inputs"])
        self.directives = Directives(source, sheet)
        self.verdicts: list[LineVerdict] = []
        self.starts: dict[int, set[str]] = {}  # labels at the start of a block
        self.last: set[int] = set()  # the last action of each block
        self.loops: set[tuple[int, str]] = set()  # labels that loops jump to
        self.pointed = False  # whether the memory pointer is at the start of the program
        self.fixed: dict[str, int] = {}  # distance and sign, if they are the same for all relative moves
        self.known_values: dict[str, int] = {}
        self.replaced = False  # whether a motion has replaced the distance, which the next relative move must restore
        self.may_replace = False  # whether some motion does
        self.end_output = 0  # the output that is high at the end of a program
        self.program = 0
        self.cleared: set[int] = set()  # lines whose command was copied for its first action
        self.nothing = ResultPiece()
        self.before: list[ResultPiece] = []  # settings needed by the first motion
        self.left_running: set[int] = set()  # motions during which the host acts
        self.unended: ResultPiece | None = None  # the wait for the end of such a motion, until the host has acted
        self.in_motion = False  # whether a motion, or a program, may run
        self.reset: Profile | None = None  # settings of the first motion, if nothing is set before it

    # ------------------------------------------------------------------------------------------------------ every kind
    def pieces(self, action: Action) -> list[ResultPiece]:
        """Return the instructions for an action, and record any verdict on it."""
        if action.axis > self.sheet.axes:
            has = "1 axis" if self.sheet.axes == 1 else f"{self.sheet.axes} axes"
            limit = f"the {self.sheet.part.upper()} has {has} ({self.sheet.manual})"
            return self.placed(
                action, self.impossible(action, f"axis {action.axis}", limit, "use a part for each axis")
            )
        theirs = self.source.commands.by_form.get(action.command)
        if self.source.encoder and not self.sheet.encoder and getattr(theirs, "encoder", False):
            limit = f"the {self.sheet.part.upper()} reads no encoder ({self.sheet.manual})"
            return self.placed(action, self.impossible(action, "", limit, "use a part with an encoder"))
        first = [*self.ended(action), *self.unset_before(action)]
        if isinstance(action, HostDirective):
            self.in_motion = self.in_motion and not waits_for_end(action.text, self.source)
        else:
            self.in_motion = isinstance(action, Motion | RunProgram) or getattr(action, "runs", False)
        copied = self.copied(action)
        if copied is not None:
            self.values_after(action)
            return self.placed(action, [*first, copied])
        method: Callable[[Action], list[ResultPiece]] = getattr(self, f"on_{type(action).__name__.lower()}")
        try:
            found = method(action)
        except CannotTest as cannot:
            found = self.impossible(action, "", cannot.limit, cannot.remedy)
        except Impossible as no:
            found = self.impossible(action, no.description, no.limit, no.remedy)
        return self.placed(action, self.in_order(action, first, found))

    def ended(self, action: Action) -> list[ResultPiece]:
        """Return the pending wait for the end of a motion, if it must come before the code of `action`.

        The list is empty if no wait is pending, or if `action` takes effect while the motor still moves; then
        the wait remains pending.
        """
        if self.unended is None or acts_during_motion(action):
            return []
        found, self.unended = [self.unended], None
        return found

    def unset_before(self, action: Action) -> list[ResultPiece]:
        """Return the settings required before the first motion or program entry, such as the source's reset rates.

        For any other action, the list is empty.
        """
        if not isinstance(action, EnterProgram | Motion):
            return []
        commands = self.rates.first(self.reset) if self.reset is not None else []
        found = [*self.before, *(ResultPiece(row, (value,)) for row, value in commands)]
        self.reset, self.before = None, []
        return found

    def start(self, actions: Sequence[Action]) -> None:
        """Record the commands that set the initial state of the source on the target.

        This state consists of position 0 and of the direction that the source has after a reset.
        """
        relative = placed = False
        skipped = skips(actions)
        for action in actions:
            if isinstance(action, SetPosition):
                placed = True
            elif isinstance(action, SetDirection | MoveTo) and action.block not in skipped:
                relative = True
            self.may_replace = self.may_replace or isinstance(action, MoveTo) or self.is_single(action)
            if isinstance(action, MoveTo) and not placed:
                placed = True
                row = self.rows.get("preset")
                theirs, mine = (
                    next((each.default for each in sheet.registers if each.name in ("position", "trgt_pos")), 0)
                    for sheet in (self.source, self.sheet)
                )
                if row is not None and mine and not theirs:
                    self.before.append(ResultPiece(row, (0,) if row.args else ()))
            if isinstance(action, MoveBy | RunEndless) and not relative and action.sign is not None:
                relative = True
                row = self.rows.get("plus" if action.sign > 0 else "minus")
                if row is not None and after_reset(self.sheet) != action.sign:
                    self.before.append(ResultPiece(row))
                    self.known_values["sign"] = action.sign

    def in_order(self, action: Action, first: list[ResultPiece], found: list[ResultPiece]) -> list[ResultPiece]:
        """Return the initial settings `first`, followed by the instructions `found`.

        If `action` begins the entry of a program, and the settings can be made only inside a program, they
        follow `found` instead.
        """
        if first and isinstance(action, EnterProgram) and first[0].row is not None and "i" not in first[0].row.when:
            for piece in first:
                piece.block = action.number
            return [*found, *first]
        return [*first, *found]

    def placed(self, action: Action, pieces: list[ResultPiece]) -> list[ResultPiece]:
        """Return the pieces; in each piece without a source line or a block, set that of the action."""
        for piece in pieces:
            piece.source = piece.source or action.line
            if piece.block < 0:
                piece.block = action.block
        return pieces

    def impossible(self, action: Action, description: str, limit: str, remedy: str) -> list[ResultPiece]:
        """Record that an action is not possible, and return the comment that takes its place."""
        self.note(LineVerdict(action.line, LineKind.IMPOSSIBLE, description or action.text, limit, remedy))
        return [ResultPiece(comment=f"NOT POSSIBLE: {action.text}: {limit}")]

    def note(self, verdict: LineVerdict) -> None:
        """Record a verdict on a line."""
        self.verdicts.append(verdict)

    def copied(self, action: Action) -> ResultPiece | None:
        """Return the source's command for an action if the target has the same one and can use it here, else None."""
        if not action.command or isinstance(action, SetProfile | Label | Jump | Loop | EnterProgram | LeaveProgram):
            return None
        if isinstance(action, RunProgram) and "pointer" in self.rows:
            return None
        if isinstance(action, EndProgram) and self.directives.end_pin:
            return None
        theirs, mine = self.source.commands.by_form.get(action.command), self.sheet.commands.by_form.get(action.command)
        if theirs is None or mine is None or not alike(theirs, mine) or (action.block >= 0) > mine.stored:
            return None
        if getattr(action, "implied", False):  # the command has been copied for its first action
            return self.nothing if action.line in self.cleared else None
        if not all(arg.allows(value) for arg, value in zip(mine.args, action.values, strict=True)):
            return None
        if mine.role == "phases" and action.values[0] >= FULL_STEPS:
            return None
        if isinstance(action, MoveBy) and self.replaced:
            return None
        if isinstance(action, RunEndless) and mine.role == "move" and "endless_next" not in self.rows:
            return None
        if isinstance(action, MoveBy | MoveTo | RunEndless):
            self.note(self.rates.motion(action))
        if mine.role == "run" and action.block >= 0:
            return None
        if mine.role == "clear" or mine.form == "MULTI_UPDATE":
            self.cleared.add(action.line)
        return ResultPiece(mine, action.values, action.text if self.verbatim else "")

    def values_after(self, action: Action) -> None:
        """Update the known distance and direction after a copied command."""
        if isinstance(action, SetDistance):
            self.known_values["distance"] = action.steps
            self.replaced = False
        elif isinstance(action, SetDirection):
            self.known_values["sign"] = action.sign
        elif isinstance(action, MoveTo):
            self.known_values.pop("sign", None)

    def is_single(self, action: Action) -> bool:
        """Return whether an action was written with the source's separate command for a single step."""
        row = self.source.commands.by_form.get(action.command)
        return row is not None and row.role == "single"

    def row(self, role: str) -> Row:
        """Return the target's command with a role; raise Impossible if the target has no such command."""
        row = self.rows.get(role)
        if row is None:
            raise Impossible("", no_command(self.sheet, role))
        return row

    def fitting(self, row: Row, arg: Arg, value: int, remedy: str = "") -> int:
        """Return `value` if the argument allows it; raise Impossible, with `remedy` as advice, if it does not."""
        if not arg.allows(value):
            raise Impossible(f"{value}", out_of(self.sheet, row, arg), remedy)
        return value


def skips(actions: Sequence[Action]) -> set[int]:
    """Return the numbers of the programs that may run without executing all of their commands.

    Commands are skipped by a forward jump, or if the program is started at a label.
    """
    found, passed, entered = set(), set(), {action.at for action in actions if isinstance(action, RunProgram)}
    for action in actions:
        if isinstance(action, Label):
            passed.add(action.name)
        if (isinstance(action, Label) and action.name in entered) or (
            isinstance(action, Jump) and action.to not in passed
        ):
            found.add(action.block)
    return found


def alike(theirs: Row, mine: Row) -> bool:
    """Return whether commands of two parts mean the same: equal role, flow and units; ranges may differ."""
    if takes_part(theirs, ()) or any(arg.name == "target" for arg in theirs.args):
        return False
    same = (theirs.role, theirs.flow, theirs.at_once, theirs.motion) == (
        mine.role,
        mine.flow,
        mine.at_once,
        mine.motion,
    )
    purpose = bool(theirs.role) or bool(theirs.at_once) or theirs.description == mine.description
    shapes = [(arg.name, arg.unit, arg.size) for arg in theirs.args] == [
        (arg.name, arg.unit, arg.size) for arg in mine.args
    ]
    return same and purpose and shapes
