"""An action -> the instructions of the target, a method for each kind of action."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence

from ...core.datasheet.roles import ROW_ROLES
from ...core.datasheet.table import Arg, Row, Sheet
from ...core.time.timebase import readable
from ..meaning import (
    Action,
    Delay,
    EndProgram,
    EnterProgram,
    EraseProgram,
    Home,
    HostDirective,
    Jump,
    Label,
    LeaveProgram,
    Loop,
    Motion,
    MoveBy,
    MoveTo,
    Profile,
    Query,
    RunEndless,
    RunProgram,
    SaveProgram,
    SetDirection,
    SetDistance,
    SetEndless,
    SetOutput,
    SetPosition,
    SetProfile,
    SetTarget,
    Special,
    Stop,
    WaitInput,
)
from ..reading import delay_unit_ps
from ..registers import rows_by_role, takes_part
from ..report import Kind, Verdict
from .conditions import LOW_BIT, CannotTest, Conditions
from .directives import Directives
from .layout import Goto, Piece
from .limits import no_command, no_pin, out_of
from .rates import Rates

MOST_DELAYS = 20  # commands that one delay becomes


class Impossible(Exception):
    """The target cannot do this: its limit, and what a person can do."""

    def __init__(self, says: str, limit: str, remedy: str = "") -> None:
        super().__init__(says)
        self.says, self.limit, self.remedy = says, limit, remedy


class Actions:
    """Makes instructions of actions."""

    def __init__(self, source: Sheet, sheet: Sheet, hz: int, rates: Rates, used: Mapping[str, Collection[int]]) -> None:
        self.source, self.sheet, self.hz, self.rates = source, sheet, hz, rates
        self.rows = rows_by_role(sheet)
        self.conditions = Conditions(sheet, used["inputs"])
        self.directives = Directives(source, sheet)
        self.verdicts: list[Verdict] = []
        self.starts: dict[int, set[str]] = {}  # labels at the start of a block
        self.last: set[int] = set()  # actions that are the last one of their block
        self.loops: set[tuple[int, str]] = set()  # labels to which loops lead
        self.fixed: dict[str, int] = {}  # distance and sign, where all relative moves have the same
        self.held: dict[str, int] = {}
        self.program = 0
        self.before: list[Piece] = []  # what the first motion needs
        self.reset: Profile | None = None  # of the first motion, where nothing is set before it

    # ------------------------------------------------------------------------------------------------------ every kind
    def pieces(self, action: Action) -> list[Piece]:
        """Return the instructions for an action, and note what became of it."""
        if action.axis > self.sheet.axes:
            limit = f"the {self.sheet.part.upper()} has {self.sheet.axes} axis{'es'[: 2 * (self.sheet.axes > 1)]} ({self.sheet.manual})"
            return self.placed(
                action, self.impossible(action, f"axis {action.axis}", limit, "use a part for each axis")
            )
        first = self.unset_before(action)
        copied = self.copied(action)
        if copied is not None:
            self.held_after(action)
            return self.placed(action, [*first, copied])
        method: Callable[[Action], list[Piece]] = getattr(self, f"on_{type(action).__name__.lower()}")
        try:
            found = method(action)
        except CannotTest as cannot:
            found = self.impossible(action, "", cannot.limit, cannot.remedy)
        except Impossible as no:
            found = self.impossible(action, no.says, no.limit, no.remedy)
        return self.placed(action, self.in_order(action, first, found))

    def unset_before(self, action: Action) -> list[Piece]:
        """Return the rates of the first motion, where the source moves with those of a reset."""
        if not isinstance(action, EnterProgram | Motion):
            return []
        commands = self.rates.first(self.reset) if self.reset is not None else []
        found = [*self.before, *(Piece(row, (value,)) for row, value in commands)]
        self.reset, self.before = None, []
        return found

    def start(self, actions: Sequence[Action]) -> None:
        """Note what the target needs to begin as the source does: position 0, and the direction after a reset."""
        relative = placed = False
        for action in actions:
            if isinstance(action, SetPosition):
                placed = True
            elif isinstance(action, SetDirection | MoveTo):
                relative = True
            if isinstance(action, MoveTo) and not placed:
                placed = True
                row = self.rows.get("preset")
                theirs, mine = (
                    next((each.default for each in sheet.registers if each.name in ("position", "trgt_pos")), 0)
                    for sheet in (self.source, self.sheet)
                )
                if row is not None and mine and not theirs:
                    self.before.append(Piece(row, (0,) if row.args else ()))
            if isinstance(action, MoveBy | RunEndless) and not relative and action.sign is not None:
                relative = True
                row = self.rows.get("plus" if action.sign > 0 else "minus")
                if row is not None and after_reset(self.sheet) != action.sign:
                    self.before.append(Piece(row))
                    self.held["sign"] = action.sign

    def in_order(self, action: Action, first: list[Piece], found: list[Piece]) -> list[Piece]:
        """Return pieces with those that set rates in front, or where the part takes them in a program alone, within."""
        if first and isinstance(action, EnterProgram) and first[0].row is not None and "i" not in first[0].row.when:
            for piece in first:
                piece.block = action.number
            return [*found, *first]
        return [*first, *found]

    def placed(self, action: Action, pieces: list[Piece]) -> list[Piece]:
        """Return pieces with their place."""
        for piece in pieces:
            piece.source = action.line
            if piece.block < 0:
                piece.block = action.block
        return pieces

    def impossible(self, action: Action, says: str, limit: str, remedy: str) -> list[Piece]:
        """Note that an action is not possible; return the comment in its place."""
        self.note(Verdict(action.line, Kind.IMPOSSIBLE, says or action.text, limit, remedy))
        return [Piece(comment=f"NOT POSSIBLE: {action.text}: {limit}")]

    def note(self, verdict: Verdict) -> None:
        """Keep a verdict."""
        self.verdicts.append(verdict)

    def copied(self, action: Action) -> Piece | None:
        """Return the command of the source, where the target has the same one; None: it has not."""
        if not action.command or isinstance(action, SetProfile | Label | Jump | Loop | EnterProgram | LeaveProgram):
            return None
        theirs, mine = self.source.commands.by_form.get(action.command), self.sheet.commands.by_form.get(action.command)
        if theirs is None or mine is None or not alike(theirs, mine) or (action.block >= 0) > mine.stored:
            return None
        if not all(arg.allows(value) for arg, value in zip(mine.args, action.values, strict=True)):
            return None
        if isinstance(action, RunEndless) and mine.role == "move" and "endless_next" not in self.rows:
            return None
        if isinstance(action, MoveBy | MoveTo | RunEndless):
            self.note(self.rates.motion(action))
        if mine.role == "run" and action.block >= 0:
            return None
        return Piece(mine, action.values)

    def held_after(self, action: Action) -> None:
        """Follow distance and direction through a command that was copied."""
        if isinstance(action, SetDistance):
            self.held["distance"] = action.steps
        elif isinstance(action, SetDirection):
            self.held["sign"] = action.sign
        elif isinstance(action, MoveTo):
            self.held.pop("sign", None)

    def row(self, role: str) -> Row:
        """Return the command of a role; raise Impossible if the target has none."""
        row = self.rows.get(role)
        if row is None:
            raise Impossible("", no_command(self.sheet, role))
        return row

    def fitting(self, row: Row, arg: Arg, value: int, remedy: str = "") -> int:
        """Return a value that an argument may have; raise Impossible if it may not."""
        if not arg.allows(value):
            raise Impossible(f"{value}", out_of(self.sheet, row, arg), remedy)
        return value

    # ---------------------------------------------------------------------------------------------- settings of motions
    def on_setprofile(self, action: SetProfile) -> list[Piece]:
        """A rate, or a value of the ramp."""
        commands, verdicts = self.rates.setting(action)
        self.verdicts += verdicts
        return [Piece(row, (value,)) for row, value in commands]

    def on_setdistance(self, action: SetDistance) -> list[Piece]:
        """The steps of relative moves: of a part whose moves have them, with the move."""
        row = self.rows.get("distance")
        if row is None:
            return []
        self.held["distance"] = self.fitting(row, row.args[0], action.steps, "make several moves of it")
        return [Piece(row, (action.steps,))]

    def on_setdirection(self, action: SetDirection) -> list[Piece]:
        """The direction of relative moves."""
        row = self.rows.get("plus" if action.sign > 0 else "minus")
        if row is None:
            return []
        self.held["sign"] = action.sign
        return [Piece(row)]

    def on_settarget(self, action: SetTarget) -> list[Piece]:
        """The target of the next motion: of a part that moves there immediately, with the motion."""
        row = self.rows.get("target")
        return [] if row is None else [Piece(row, (self.fitting(row, row.args[0], action.position),))]

    def on_setendless(self, action: SetEndless) -> list[Piece]:
        """The next motion has no end: of a part whose runs say so themselves, with the run."""
        row = self.rows.get("endless_next")
        return [] if row is None else [Piece(row)]

    def on_setposition(self, action: SetPosition) -> list[Piece]:
        """The position counter."""
        row, clear = self.rows.get("preset"), self.rows.get("clear")
        if row is not None and (action.block < 0 or row.stored):
            if row.args:
                return [Piece(row, (self.fitting(row, row.args[0], action.position),))]
            if not action.position:
                return [Piece(row)]
            raise Impossible(f"position {action.position}", f"{row.form} makes the position zero ({row.where})")
        if clear is not None and not action.position and (clear.stored or action.block < 0):
            return [Piece(clear, (1,))]
        limit = (
            no_command(self.sheet, "preset") if action.block < 0 else f"{no_command(self.sheet, 'preset')} in a program"
        )
        raise Impossible(f"position {action.position}", limit, "count positions from the home position")

    # --------------------------------------------------------------------------------------------------------- motions
    def on_moveby(self, action: MoveBy) -> list[Piece]:
        """A relative move."""
        row = self.rows.get("move") or self.row("update")
        if row.role == "update":
            raise Impossible("", no_command(self.sheet, "move"))
        if row.args:
            if action.steps is None:
                raise Impossible(
                    "steps and direction depend on the path",
                    f"{row.form} has both in one command ({row.where})",
                    "write a move for each path",
                )
            found = [Piece(row, (self.fitting(row, row.args[0], action.steps, "make several moves of it"),))]
        else:
            found = [*self.set_move(action), Piece(row)]
        self.note(self.rates.motion(action))
        return found

    def set_move(self, action: MoveBy) -> list[Piece]:
        """Set distance and direction before a move, where they are not what they shall be."""
        found: list[Piece] = []
        if action.sign is not None and self.held.get("sign") != action.sign and not self.sets(SetDirection):
            found.append(Piece(self.row("plus" if action.sign > 0 else "minus")))
            self.held["sign"] = action.sign
        row = self.row("distance")
        if action.distance is not None and self.held.get("distance") != action.distance and not self.sets(SetDistance):
            self.fitting(row, row.args[0], action.distance, "make several moves of it")
            found.append(Piece(row, (action.distance,)))
            self.held["distance"] = action.distance
        return found

    def sets(self, kind: type[Action]) -> bool:
        """Return whether the source sets distance and direction by commands of their own."""
        return ("distance" if kind is SetDistance else "plus") in rows_by_role(self.source)

    def on_moveto(self, action: MoveTo) -> list[Piece]:
        """A move to a position."""
        row = self.rows.get("absolute") or self.rows.get("goto")
        self.held.pop("sign", None)
        if action.position is None:
            raise Impossible("the position depends on the path", no_command(self.sheet, "goto"))
        if row is None:
            return self.targeted(action)
        self.fitting(row, row.args[0], action.position, "count positions from another place")
        self.note(self.rates.motion(action))
        return [Piece(row, (action.position,))]

    def targeted(self, action: MoveTo) -> list[Piece]:
        """A move to a position by two commands, target and motion."""
        assert action.position is not None  # noqa: S101
        row, go, found = self.row("target"), self.rows.get("update") or self.row("move"), []
        if action.steps == 0 and go.role == "update":  # a motion that would never be complete
            return []
        if not isinstance_target(action, self.source):
            found.append(Piece(row, (self.fitting(row, row.args[0], action.position),)))
        if "plus" in self.rows:
            if action.steps is None:
                raise Impossible(
                    "the direction depends on the path",
                    f"{row.form} does not find the direction by itself ({row.where})",
                )
            if action.steps and self.held.get("sign") != (sign := 1 if action.steps > 0 else -1):
                found.append(Piece(self.row("plus" if sign > 0 else "minus")))
                self.held["sign"] = sign
        self.note(self.rates.motion(action))
        if go.role != "update":
            return [*found, Piece(go)]
        return [
            *found,
            *(Piece(row) for row in self.sheet.acting("clear_events")),
            Piece(go),
            Piece(text="wait motion_complete"),
        ]

    def on_runendless(self, action: RunEndless) -> list[Piece]:
        """A run without end, or until an input is low."""
        if action.until is not None:
            row = self.row("until_input")
            self.conditions.check(action.until.number)
            if action.sign is None or action.until.level:
                raise Impossible("", f"{row.form} runs until the input is low ({row.where})")
            return [Piece(row, (action.sign, action.until.number))]
        if "endless" in self.rows:
            if action.sign is None:
                raise Impossible("the direction depends on the path", no_command(self.sheet, "plus"))
            return [Piece(self.rows["endless"], (action.sign,))]
        row, found = self.row("endless_next"), []
        if not self.sets(SetDirection) and action.sign is not None:
            found.append(Piece(self.row("plus" if action.sign > 0 else "minus")))
        number = self.row("distance")
        if not self.sets(SetDistance):
            found.append(Piece(number, (number.args[0].high,)))
        self.held.clear()
        stated = [] if "endless_next" in rows_by_role(self.source) else [Piece(row)]
        return [*found, *stated, Piece(self.row("move"))]

    def on_home(self, action: Home) -> list[Piece]:
        """A homing."""
        row = self.row("home")
        if row.args[0].sign == "alone" and action.block < 0:
            return [Piece(row, (action.sign,))]
        raise Impossible("homing", f"{row.form} finds it by itself ({row.where})", "write the homing by hand")

    def on_stop(self, action: Stop) -> list[Piece]:
        """The end of a motion."""
        wanted = "brake" if action.ramped else "stop"
        row = next((row for row in self.sheet.commands if row.at_once == wanted), None)
        if row is not None:
            return [Piece(row, ())]
        directive = self.directives.stop()
        if directive is None:
            raise Impossible(
                "stops a motion", f"no command of the {self.sheet.part.upper()} stops a motion ({self.sheet.manual})"
            )
        self.note(Verdict(action.line, Kind.NEARLY, f"by the pin, along its ramp: {', '.join(directive)}"))
        return [Piece(text=text) for text in directive]

    # ------------------------------------------------------------------------------------------ outputs, inputs, times
    def on_setoutput(self, action: SetOutput) -> list[Piece]:
        """An output."""
        if "bits" in self.rows:
            return [Piece(self.rows["bits"], (action.number - 1 + (0 if action.level else LOW_BIT),))]
        row = self.row("output_high" if action.level else "output_low")
        if self.sheet.role(f"output{action.number}") is None:
            if action.implied:
                return []
            remedy = "use a part with more outputs, or let the host switch it"
            raise Impossible(f"output {action.number}", no_pin(self.sheet, "output", action.number), remedy)
        return [Piece(row, (action.number,) if row.args else ())]

    def on_waitinput(self, action: WaitInput) -> list[Piece]:
        """A wait for an input."""
        return self.conditions.wait(action.input)

    def on_delay(self, action: Delay) -> list[Piece]:
        """A delay: the nearest, or several one after the other."""
        if self.sheet.enter is None and "delay" not in self.rows:
            return [Piece(text=f"@wait {readable(action.time_ps)}")]
        row = self.row("delay")
        arg, unit = row.args[0], delay_unit_ps(self.sheet, self.hz)
        count = max(1, (2 * action.time_ps + unit) // (2 * unit))
        off = count * unit - action.time_ps
        whole, rest = divmod(count, arg.high)
        if whole + bool(rest) > MOST_DELAYS:
            raise Impossible(readable(action.time_ps), out_of(self.sheet, row, arg), "let the host wait")
        if off:
            share = abs(off) / action.time_ps
            says = f"{readable(count * unit)} for {readable(action.time_ps)}, {100 * share:.2g} %"
            self.note(Verdict(action.line, Kind.NEARLY, says, off=share, off_ps=off))
        values = [arg.high] * whole + ([rest] if rest else [])
        return [Piece(row, (value,)) for value in values]

    # ------------------------------------------------------------------------------------------------------------ flow
    def on_label(self, action: Label) -> list[Piece]:
        """A place: paths meet, so that registers are no longer known; a mark, if loops of the target need one."""
        self.rates.joined()
        self.held = {name: value for name, value in self.held.items() if self.fixed.get(name) == value}
        mark = self.rows.get("mark")
        if mark is not None and (action.block, action.name) in self.loops:
            return [Piece(labels=[action.name]), Piece(mark)]
        return [Piece(labels=[action.name])]

    def on_jump(self, action: Jump) -> list[Piece]:
        """A jump, or a branch."""
        start = action.to in self.starts.get(action.block, ())
        if action.inputs:
            return self.conditions.branch(action.inputs, action.to, start)
        return self.conditions.jump(action.to, start)

    def on_loop(self, action: Loop) -> list[Piece]:
        """The end of a loop: by the command with the smallest count that is enough."""
        rows = sorted(self.sheet.acting("loop"), key=lambda row: row.args[0].high)
        if not rows:
            raise Impossible(
                f"{action.passes} passes", no_command(self.sheet, "loop"), "let the host run the program so often"
            )
        row = next((row for row in rows if row.args[0].allows(action.passes)), None)
        if row is None:
            raise Impossible(
                f"{action.passes} passes", out_of(self.sheet, rows[-1], rows[-1].args[0]), "write the loop twice"
            )
        goal = (Goto(action.to),) if len(row.args) > 1 else ()
        return [Piece(row, (action.passes, *goal))]

    def on_endprogram(self, action: EndProgram) -> list[Piece]:
        """The end of the program: the last instruction of a part that ends without one."""
        stop = self.rows.get("stop")
        if stop is not None:
            return [Piece(stop)]
        if id(action) in self.last or action.block < 0:
            return []
        return self.conditions.jump("the end", at_start=False)

    # -------------------------------------------------------------------------------------------------- host, programs
    def on_enterprogram(self, action: EnterProgram) -> list[Piece]:
        """Program entry begins."""
        self.program = action.number
        self.rates.joined()
        self.held = {}
        if self.sheet.enter is None:
            raise Impossible("a stored program", no_command(self.sheet, "enter"))
        pointer = self.rows.get("pointer")
        return [*([Piece(pointer, (0,))] if pointer is not None else []), Piece(self.sheet.enter)]

    def on_leaveprogram(self, action: LeaveProgram) -> list[Piece]:
        """Program entry ends; with a run, if the target's command does both."""
        rows = self.sheet.leave
        row = next((row for row in rows if row.starts == action.runs), None)
        if row is not None:
            return [Piece(row)]
        row = rows[-1]
        if not action.runs:
            self.note(
                Verdict(action.line, Kind.NEARLY, f"{row.form} runs the program as well: enter it when it may run")
            )
            return [Piece(row)]
        return [Piece(row), *self.on_runprogram(RunProgram(line=action.line, text=action.text))]

    def on_runprogram(self, action: RunProgram) -> list[Piece]:
        """The program runs."""
        row = self.rows.get("run")
        if row is None:
            row = next((row for row in self.sheet.leave if row.starts), None)
        if row is None:
            raise Impossible("runs the program", no_command(self.sheet, "run"))
        if action.at and "jump" in self.rows and action.at not in self.starts.get(self.program, ()):
            return [Piece(self.rows["jump"], (Goto(action.at),))]
        pointer = self.rows.get("pointer")
        return [*([Piece(pointer, (0,))] if pointer is not None else []), Piece(row)]

    def on_saveprogram(self, action: SaveProgram) -> list[Piece]:
        """The program is kept without power."""
        return [Piece(self.row("store"))]

    def on_eraseprogram(self, action: EraseProgram) -> list[Piece]:
        """The program is erased, and registers are those of a reset."""
        self.rates.restarted()
        return [Piece(self.row("erase"))]

    def on_hostdirective(self, action: HostDirective) -> list[Piece]:
        """What a host does itself."""
        found = self.directives.translated(action.text)
        if isinstance(found, str):
            raise Impossible(action.text, found, "write it by hand for this host")
        return [Piece(text=text) for text in found]

    def on_query(self, action: Query) -> list[Piece]:
        """A question: each part answers its own."""
        raise Impossible(
            action.text,
            f"the {self.sheet.part.upper()} is read in another way",
            f"slewline describe {self.sheet.part} lists what it answers",
        )

    def on_special(self, action: Special) -> list[Piece]:
        """A command that no other part need have."""
        theirs = self.source.commands.by_form.get(action.command)
        role = theirs.role if theirs is not None else ""
        if role == "clear_events" or (role == "axis" and int(action.command[-1]) == 1):
            return []
        says = ROW_ROLES[role] if role in ROW_ROLES else action.says
        raise Impossible(
            action.text,
            f"no command of the {self.sheet.part.upper()} does it: {says} ({self.sheet.manual})",
            "leave it out, or let the host do it",
        )


def alike(theirs: Row, mine: Row) -> bool:
    """Return whether a command means the same in two parts: role, flow and units, not the ranges."""
    if takes_part(theirs, ()) or any(arg.name == "target" for arg in theirs.args):
        return False
    same = (theirs.role, theirs.flow, theirs.at_once, theirs.motion) == (
        mine.role,
        mine.flow,
        mine.at_once,
        mine.motion,
    )
    purpose = bool(theirs.role) or bool(theirs.at_once) or theirs.says == mine.says
    shapes = [(arg.name, arg.unit, arg.size) for arg in theirs.args] == [
        (arg.name, arg.unit, arg.size) for arg in mine.args
    ]
    return same and purpose and shapes


def after_reset(sheet: Sheet) -> int:
    """Return the direction after a reset: 1 clockwise, -1 counter-clockwise."""
    pin = sheet.role("direction")
    return 1 if pin is None or pin.reset == pin.sense else -1


def isinstance_target(action: MoveTo, source: Sheet) -> bool:
    """Return whether the source sets the target by a command of its own, so that it has been set."""
    return "target" in rows_by_role(source) and action.command != "" and not action.values
