"""The converter of actions to the target's instructions, with a method for each kind of action."""

from __future__ import annotations

from ...core.datasheet.roles import ROW_ROLES
from ...core.time.timebase import readable
from ..host_directives import DRIVES, ends_motion, pin_of
from ..meaning import (
    Delay,
    EndProgram,
    EnterProgram,
    EraseProgram,
    HostDirective,
    Jump,
    Label,
    LeaveProgram,
    Loop,
    Query,
    RunProgram,
    SaveProgram,
    SetOutput,
    Special,
    WaitInput,
)
from ..rows_of_roles import leads
from ..source_text.role_reader import delay_unit_ps
from ..special_commands import ELSEWHERE, NO_AXIS, SWITCHED
from ..translation_report import LineKind, LineVerdict
from .base import Impossible
from .conditions import LOW_BIT
from .layout import Goto, ResultPiece
from .limits import no_command, no_pin, out_of
from .target_directives import at_rest
from .target_motions import MotionWriter

MOST_DELAYS = 20  # maximum number of commands for one delay


class Actions(MotionWriter):
    """A converter of actions of every kind to the target's instructions."""

    # ------------------------------------------------------------------------------------------ outputs, inputs, times
    def on_setoutput(self, action: SetOutput) -> list[ResultPiece]:
        """Return the instructions that set an output."""
        if "bits" in self.rows:
            return [ResultPiece(self.rows["bits"], (action.number - 1 + (0 if action.level else LOW_BIT),))]
        row = self.row("output_high" if action.level else "output_low")
        if self.sheet.role(f"output{action.number}") is None:
            if action.implied:
                return []
            remedy = "use a part with more outputs, or let the host switch it"
            raise Impossible(f"output {action.number}", no_pin(self.sheet, "output", action.number), remedy)
        return [ResultPiece(row, (action.number,) if row.args else ())]

    def on_waitinput(self, action: WaitInput) -> list[ResultPiece]:
        """Return the instructions that wait for an input."""
        return self.conditions.wait(action.input)

    def on_delay(self, action: Delay) -> list[ResultPiece]:
        """Return one delay instruction, or several whose delays add up to the nearest possible total."""
        if self.sheet.enter is None and "delay" not in self.rows:
            return [ResultPiece(text=f"@wait {readable(action.time_ps)}")]
        row = self.row("delay")
        arg, unit = row.args[0], delay_unit_ps(self.sheet, self.hz)
        count = max(1, (2 * action.time_ps + unit) // (2 * unit))
        off = count * unit - action.time_ps
        whole, rest = divmod(count, arg.high)
        if whole + bool(rest) > MOST_DELAYS:
            raise Impossible(readable(action.time_ps), out_of(self.sheet, row, arg), "let the host wait")
        if off:
            share = abs(off) / action.time_ps
            description = f"{readable(count * unit)} instead of {readable(action.time_ps)}, {100 * share:.2g} %"
            self.note(LineVerdict(action.line, LineKind.NEARLY, description, off=share, off_ps=off))
        values = [arg.high] * whole + ([rest] if rest else [])
        return [ResultPiece(row, (value,)) for value in values]

    # ------------------------------------------------------------------------------------------------------------ flow
    def on_label(self, action: Label) -> list[ResultPiece]:
        """Return the label, followed by a mark command if the target's loops need one.

        Several paths of the program meet at a label.  A parameter whose value may differ between these paths is
        treated as unknown after the label.
        """
        self.rates.joined()
        self.replaced = self.replaced or self.may_replace
        self.known_values = {name: value for name, value in self.known_values.items() if self.fixed.get(name) == value}
        mark = self.rows.get("mark")
        if mark is not None and (action.block, action.name) in self.loops:
            return [ResultPiece(labels=[action.name]), ResultPiece(mark)]
        return [ResultPiece(labels=[action.name])]

    def on_jump(self, action: Jump) -> list[ResultPiece]:
        """Return the instructions for a jump or a branch."""
        start = action.to in self.starts.get(action.block, ())
        if action.inputs:
            return self.conditions.branch(action.inputs, action.to, start)
        again = self.sheet.commands.by_form.get(action.command)
        if start and again is not None and again.role == "run" and again.flow == "0" and again.stored:
            return [ResultPiece(again)]  # the source runs its program again with the same command
        return self.conditions.jump(action.to, start)

    def on_loop(self, action: Loop) -> list[ResultPiece]:
        """Return the end of a loop: the loop command with the smallest range that allows the number of passes."""
        rows = sorted(self.sheet.acting("loop"), key=lambda row: row.args[0].high)
        if not rows:
            raise Impossible(
                f"{action.passes} passes", no_command(self.sheet, "loop"), "let the host repeat the program"
            )
        row = next((row for row in rows if row.args[0].allows(action.passes)), None)
        if row is None:
            raise Impossible(
                f"{action.passes} passes", out_of(self.sheet, rows[-1], rows[-1].args[0]), "write the loop twice"
            )
        goal = (Goto(action.to),) if len(row.args) > 1 else ()
        return [ResultPiece(row, (action.passes, *goal))]

    def on_endprogram(self, action: EndProgram) -> list[ResultPiece]:
        """Return the instruction that ends the program, or, if the part has none, a jump to the program's end.

        A part without such an instruction needs no jump after the last command of a program.
        """
        stop = self.rows.get("stop")
        if stop is not None:
            return [*self.end_shown(1), ResultPiece(stop)]
        if id(action) in self.last or action.block < 0:
            return []
        return self.conditions.jump("the end", at_start=False)

    # -------------------------------------------------------------------------------------------------- host, programs
    def on_enterprogram(self, action: EnterProgram) -> list[ResultPiece]:
        """Return the commands that begin program entry."""
        self.program = action.number
        self.rates.joined()
        self.known_values = {}
        if self.sheet.enter is None:
            raise Impossible("a stored program", no_command(self.sheet, "enter"))
        return [*self.pointer(), ResultPiece(self.sheet.enter)]

    def on_leaveprogram(self, action: LeaveProgram) -> list[ResultPiece]:
        """Return the commands that end program entry, and also run the program if the source does."""
        rows = self.sheet.leave
        row = next((row for row in rows if row.starts == action.runs), None)
        if row is not None:
            return [ResultPiece(row)]
        row = rows[-1]
        if not action.runs:
            limit = f"{row.form} runs the program as well ({row.where})"
            raise Impossible("the program is only stored", limit, "enter it when it may run")
        return [ResultPiece(row), *self.on_runprogram(RunProgram(line=action.line, text=action.text))]

    def on_runprogram(self, action: RunProgram) -> list[ResultPiece]:
        """Return the commands that run the program."""
        row = self.rows.get("run")
        if row is None:
            row = next((row for row in self.sheet.leave if row.starts), None)
        if row is None:
            raise Impossible("runs the program", no_command(self.sheet, "run"))
        if action.at and "jump" in self.rows and action.at not in self.starts.get(self.program, ()):
            return [ResultPiece(self.rows["jump"], (Goto(action.at),))]
        return [*self.end_shown(0), *self.pointer(), ResultPiece(row)]

    def end_shown(self, level: int) -> list[ResultPiece]:
        """Return the instruction for the output that shows a program's end; none if there is no such output."""
        if not self.directives.end_pin:
            return []
        return [ResultPiece(self.rows["bits"], (self.end_output - 1 + (0 if level else LOW_BIT),))]

    def pointer(self) -> list[ResultPiece]:
        """Return the command that sets the memory pointer to the start of the program, if needed."""
        row, pointed = self.rows.get("pointer"), self.pointed
        self.pointed = False
        return [] if row is None or pointed else [ResultPiece(row, (0,))]

    def on_saveprogram(self, action: SaveProgram) -> list[ResultPiece]:
        """Return the command that saves the program."""
        return [ResultPiece(self.row("store"))]

    def on_eraseprogram(self, action: EraseProgram) -> list[ResultPiece]:
        """Return the command that erases the program, and note that the registers then have their reset values."""
        self.rates.restarted()
        return [ResultPiece(self.row("erase"))]

    def on_hostdirective(self, action: HostDirective) -> list[ResultPiece]:
        """Return the directives for the target's host that replace a directive for the source's host."""
        found = self.directives.translated(action.text)
        if isinstance(found, str):
            raise Impossible(action.text, found, "write it by hand for this host")
        if not self.in_motion and ends_motion(action.text, self.source):
            self.check_hold(action.text)
        if self.unended is not None and found == [at_rest(self.sheet)]:
            wait, self.unended = self.unended.text, None
            return [ResultPiece(text=wait)]
        return [ResultPiece(text=text) for text in found]

    def check_hold(self, text: str) -> None:
        """Raise Impossible if `text` drives the abort pin before a motion, and the target has no equivalent pin."""
        match = DRIVES.fullmatch(text)
        theirs = None if match is None else pin_of(self.source, match[3])
        mine = self.sheet.role("abort")
        if theirs is None or theirs.role != "abort" or (mine is not None and mine.reflex == theirs.reflex):
            return
        if mine is None:
            limit = f"the {self.sheet.part.upper()} has no abort input ({self.sheet.manual})"
        else:
            limit = f"{mine.name} of the {self.sheet.part.upper()}: {mine.description} ({self.sheet.manual})"
        raise Impossible("acts on the start of the next motion", limit, "start the motion later")

    def on_query(self, action: Query) -> list[ResultPiece]:
        """Raise Impossible, since each part is queried differently; a comment replaces the query."""
        raise Impossible(
            action.text,
            f"the {self.sheet.part.upper()} is queried differently",
            f"slewline describe {self.sheet.part} lists its queries",
        )

    def on_special(self, action: Special) -> list[ResultPiece]:
        """Return the target's equivalent of a special command, if needed; raise Impossible if it has none."""
        theirs = self.source.commands.by_form.get(action.command)
        role = theirs.role if theirs is not None else ""
        if role == "pointer" and role in self.rows and action.needless:
            self.pointed = True
            return [ResultPiece(self.rows[role], (0,))]
        if action.needless and (role != "axis" or int(action.command[-1]) == 1):
            return []
        mine = self.sheet.commands.by_form.get(action.command)
        if action.description == SWITCHED and self.verbatim and mine is not None and not leads(mine):
            return [ResultPiece(mine, text=action.text)]
        form = action.command
        if action.description == NO_AXIS and mine is not None and mine == self.source.commands.by_form[form]:
            return [ResultPiece(mine, action.values)]
        if action.description == ELSEWHERE:
            has = f"the {self.sheet.part.upper()} has no program before one is entered ({self.sheet.manual})"
            raise Impossible(ELSEWHERE, has, action.remedy)
        description = action.description if role in self.rows else ROW_ROLES.get(role, action.description)
        raise Impossible(
            action.text,
            f"no command of the {self.sheet.part.upper()} does this: {description} ({self.sheet.manual})",
            action.remedy or "leave it out, or let the host do it",
        )
