"""Conversion of statements to actions: one method for each role of commands, used for all parts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from ...core.datasheet.table import Sheet
from ...core.time.timebase import PS_PER_S
from ...language.statements import Source, Statement
from ..meaning import (
    Action,
    Delay,
    EndProgram,
    EnterProgram,
    EraseProgram,
    Home,
    Input,
    Jump,
    Label,
    LeaveProgram,
    Loop,
    MoveBy,
    MoveTo,
    Part,
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
from ..profiles import Profiles
from ..rows_of_roles import takes_part, waits_for_update
from ..special_commands import AT_THE_START, AT_THE_UPDATE, NEEDLESS, NEEDLESS_FORMS, OVERFLOW, REMEDIES, SET_DIRECTION
from .bits import Numbers
from .program_labels import ProgramLabels
from .source_registers import STOPS, UNKNOWN, Key, KnownRegisterValues, overflows

SETS: Mapping[str, Part] = {"start_rate": "start rate", "top_rate": "top rate", "rate_divisor": "top rate"}
RegisterValues = Mapping[Key, int]
Common = dict[str, object]
UNIT_TIMES = ("millisecond", "delay_unit")


class RoleReader:
    """A converter of statements to actions, by the roles of their commands.

    Args:
        source: the text that has been read.
        hz: the crystal frequency, Hz.
        profiles: the profiles of the part; None: the part has no ramp calculator.
        registers: the known register values at every statement.
        bits: the outputs and inputs that commands select as bits.
    """

    def __init__(
        self, source: Source, hz: int, profiles: Profiles | None, registers: KnownRegisterValues, bits: Numbers
    ) -> None:
        self.source, self.sheet, self.hz = source, source.sheet, hz
        self.profiles, self.registers, self.bits = profiles, registers, bits
        names = ProgramLabels(source)
        self.labels, self.loops, self.goal = names.labels, names.loops, names.goal

    # ---------------------------------------------------------------------------------------------------- statements
    def statement(self, statement: Statement) -> list[Action]:
        """Return the actions of a statement, preceded by the label at its address if there is one."""
        row, block = statement.row, statement.block
        at = self.labels.get((block, statement.address)) if block >= 0 else None
        before = self.registers.before(statement)
        common = {
            "line": statement.line,
            "text": statement.text,
            "block": block,
            "axis": before.get((0, "axis"), UNKNOWN),
            "command": row.form,
            "values": statement.values,
        }
        found: list[Action] = [Label(name=at, line=statement.line, block=block)] if at is not None else []
        if self.profiles is not None and takes_part(row, self.profiles.names):
            return [*found, self.set_profile(statement, common)]
        method: Callable[..., Iterable[Action]] | None = getattr(self, f"on_{row.role}", None) if row.role else None
        if method is None:
            return [*found, *self.other(statement, common)]
        return [*found, *method(statement, before, common)]

    def set_profile(self, statement: Statement, common: Common) -> Action:
        """Return the action that sets a rate or a ramp value, with the profile that results from it."""
        axis = int(str(common["axis"]))
        profile = self.profile(self.registers.after(statement), axis)
        sets = SETS.get(statement.row.role, "ramp")
        value = None
        if profile is not None:
            value = {"start rate": profile.start, "top rate": profile.top, "ramp": profile.acceleration}[sets]
        return SetProfile(sets=sets, value=value, profile=profile, **common)  # type: ignore[arg-type]

    def profile(self, state: Mapping[Key, int], axis: int) -> Profile | None:
        """Return the profile of an axis for the register values in `state`, or None if it is not known."""
        if self.profiles is None:
            return None
        return self.profiles.read(
            {name: value for (of, name), value in state.items() if of == axis and name in self.profiles.values_of}
        )

    def motion(self, before: Mapping[Key, int], common: Mapping[str, object]) -> dict[str, object]:
        """Return the fields of a motion: those in `common`, its profile, and the position at which it begins.

        The last two follow from the register values before the motion; each is None if it is not known.
        """
        axis = int(str(common["axis"]))
        return {**common, "profile": self.profile(before, axis), "begins": before.get((axis, "position"))}

    def on_move(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield a motion.

        If the command states a number of steps, the motion is a relative move by that number.  Otherwise,
        earlier settings make it a relative move, an endless run, or a move to a target; if that move would make
        the position register overflow, the action is a `Special`.
        """
        axis = int(str(common["axis"]))
        its = self.motion(before, common)
        sign = before.get((axis, "sign"))
        if statement.values:
            steps = statement.values[0]
            yield MoveBy(distance=abs(steps), sign=1 if steps > 0 else -1, **its)  # type: ignore[arg-type]
        elif before.get((axis, "endless_next")):
            yield RunEndless(sign=sign, **its)  # type: ignore[arg-type]
        elif (axis, "target") in before:
            if overflows(before, axis):
                yield Special(description=OVERFLOW, remedy=SET_DIRECTION, **{**common, "command": ""})  # type: ignore[arg-type]
            else:
                yield MoveTo(position=before[axis, "target"], **its)  # type: ignore[arg-type]
        else:
            yield MoveBy(distance=before.get((axis, "distance")), sign=sign, **its)  # type: ignore[arg-type]

    def on_single(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield a single step."""
        yield MoveBy(distance=1, sign=before.get((1, "sign")), **self.motion(before, common))  # type: ignore[arg-type]

    def on_update(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield the action of an update: a stop, if one was set up before, or else a move to the target."""
        axis = int(str(common["axis"]))
        if (axis, "stop") in before:
            yield Stop(ramped=STOPS[before[axis, "stop"]] == "brake", **common)  # type: ignore[arg-type]
            return
        position = before.get((axis, "target"))
        yield MoveTo(position=position, **self.motion(before, common))  # type: ignore[arg-type]

    def on_goto(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield a move to a position."""
        yield MoveTo(position=statement.values[0], **self.motion(before, common))  # type: ignore[arg-type]

    on_absolute = on_goto

    def on_endless(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield an endless run."""
        yield RunEndless(sign=statement.values[0], **self.motion(before, common))  # type: ignore[arg-type]

    def on_until_input(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield a run that ends as soon as an input is low."""
        sign, number = statement.values
        yield RunEndless(sign=sign, until=Input(number, 0), **self.motion(before, common))  # type: ignore[arg-type]

    def on_home(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield a homing run."""
        alone = statement.row.args[0].sign == "alone"
        sign = statement.values[0] if alone else before.get((1, "sign"), 1)
        yield Home(sign=sign, **self.motion(before, common))  # type: ignore[arg-type]

    # ---------------------------------------------------------------------------------------------- settings of motions
    def on_distance(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield the action that sets the number of steps for relative moves."""
        yield SetDistance(steps=statement.values[0], **common)  # type: ignore[arg-type]

    def on_target(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield the action that sets the target of the next motion."""
        yield SetTarget(position=statement.values[0], **common)  # type: ignore[arg-type]

    def on_plus(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield the action that sets the direction for relative moves."""
        yield SetDirection(sign=1 if statement.row.role == "plus" else -1, **common)  # type: ignore[arg-type]

    on_minus = on_plus

    def on_endless_next(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield the action that makes the next motion endless."""
        yield SetEndless(**common)  # type: ignore[arg-type]

    def on_preset(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield the action that sets the position counter: to the command's value, or to 0 if it has none."""
        yield SetPosition(position=statement.values[0] if statement.values else 0, **common)  # type: ignore[arg-type]

    def on_clear(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield the actions that clear the position, the outputs, or both, as selected by the command."""
        if statement.values[0] & 1:
            yield SetPosition(position=0, **common)  # type: ignore[arg-type]
        if statement.values[0] & 2:
            outputs = [n for n in (1, 2, 3) if self.sheet.role(f"output{n}") is not None]
            yield from (SetOutput(number=n, level=0, implied=True, **common) for n in outputs)  # type: ignore[arg-type]

    # ------------------------------------------------------------------------------------------ outputs, inputs, times
    def on_output_high(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield the action that sets an output high or low: the output that the command names, or else output 1."""
        number = statement.values[0] if statement.values else 1
        yield SetOutput(number=number, level=int(statement.row.role == "output_high"), **common)  # type: ignore[arg-type]

    on_output_low = on_output_high

    def on_bits(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield the action that sets the output selected by the command's number; a `Special` for several bits."""
        outputs = self.bits.outputs(statement)
        if outputs is None:
            yield Special(description=f"{statement.text}: bits that are not single outputs", **common)  # type: ignore[arg-type]
        else:
            yield from (SetOutput(number=number, level=level, **common) for number, level in outputs)  # type: ignore[arg-type]

    def on_wait_high(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield a wait for a level of an input: the input that the command names, or else input 1."""
        number = statement.values[0] if statement.values else 1
        yield WaitInput(input=Input(number, int(statement.row.role == "wait_high")), **common)  # type: ignore[arg-type]

    on_wait_low = on_wait_high

    def on_wait_bits(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield a wait for the input selected by the command's number; a `Special` for several inputs."""
        one = self.bits.input(statement)
        if one is None:
            yield Special(description=f"{statement.text}: waits for several inputs", **common)  # type: ignore[arg-type]
        else:
            yield WaitInput(input=one, **common)  # type: ignore[arg-type]

    def on_delay(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield a delay whose length is the command's number, in the delay unit of the data sheet."""
        yield Delay(time_ps=statement.values[0] * delay_unit_ps(self.sheet, self.hz), **common)  # type: ignore[arg-type]

    # ------------------------------------------------------------------------------------------------------------ flow
    def on_jump(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield a jump or, if a host sends the command, a run of the program from the address in the command."""
        to = self.goal(statement)
        if statement.block < 0:
            yield RunProgram(at=to, **common)  # type: ignore[arg-type]
        else:
            yield Jump(to=to, **common)  # type: ignore[arg-type]

    def on_pointer(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield a jump for a command in a program, and a `Special` for a command from a host.

        From a host, the command sets the address at which the next program is entered or run.
        """
        if statement.block >= 0:
            yield from self.on_jump(statement, before, common)
            return
        bases = {block.base for block in self.source.blocks}
        needless = AT_THE_START if bases <= {statement.values[0]} else ""  # there is one program, and it begins there
        yield Special(description=statement.row.description, needless=needless, **common)  # type: ignore[arg-type]

    def on_loop(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield the end of a loop, with the label at its start and the number of passes."""
        passes = statement.values[0] or statement.row.args[0].modulus
        yield Loop(to=self.goal(statement), passes=passes, **common)  # type: ignore[arg-type]

    def on_mark(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield the start of a loop: a label, if any loop command leads back to it."""
        name = self.loops.get((statement.block, statement.end))
        if name is not None:
            yield Label(name=name, **common)  # type: ignore[arg-type]

    def on_branch_low(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield a branch on the level of an input: the input whose number the command states, or else input 2."""
        level = int(statement.row.role == "branch_high")
        number = statement.values[0] if statement.values and statement.target is None else 2
        yield Jump(to=self.goal(statement), inputs=(Input(number, level),), **common)  # type: ignore[arg-type]

    on_branch_high = on_branch_low

    def on_branch_inputs(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield a branch that is taken if inputs 1 to 3 all have the levels given by the command."""
        levels = tuple(Input(n + 1, statement.values[0] >> n & 1) for n in range(3))
        yield Jump(to=self.goal(statement), inputs=levels, **common)  # type: ignore[arg-type]

    def on_branch_bits(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield a branch that is taken unless the selected input has the selected level.

        If the command tests several inputs, the action is a `Special`.
        """
        one = self.bits.input(statement)
        if one is None:
            yield Special(description=f"{statement.text}: tests several inputs", **common)  # type: ignore[arg-type]
        else:
            yield Jump(to=self.goal(statement), inputs=(Input(one.number, 1 - one.level),), **common)  # type: ignore[arg-type]

    def on_stop(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield the end of a program."""
        yield EndProgram(**common)  # type: ignore[arg-type]

    # -------------------------------------------------------------------------------------------------- host, programs
    def on_enter(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield the action that begins the entry of a program."""
        number = next(n for n, block in enumerate(self.source.blocks) if block.entry is statement)
        yield EnterProgram(number=number, **common)  # type: ignore[arg-type]

    def on_leave(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield the action that ends the entry of a program.

        If no program is being entered, the command instead runs the entered program, provided that it is a
        command that starts programs; otherwise there is no action.
        """
        ends = any(block.quit is statement for block in self.source.blocks)
        if ends:
            yield LeaveProgram(runs=statement.row.starts, **common)  # type: ignore[arg-type]
        elif statement.row.starts:
            yield RunProgram(**common)  # type: ignore[arg-type]

    def on_run(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield the action that runs the program from its start; inside a program, it is a jump to the start."""
        if statement.block < 0:
            yield RunProgram(**common)  # type: ignore[arg-type]
        else:
            yield Jump(to=self.labels[statement.block, self.source.blocks[statement.block].base], **common)  # type: ignore[arg-type]

    def on_store(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield the action that saves the program."""
        yield SaveProgram(**common)  # type: ignore[arg-type]

    def on_erase(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield the action that erases the program."""
        yield EraseProgram(**common)  # type: ignore[arg-type]

    def on_question(self, statement: Statement, before: RegisterValues, common: Common) -> Iterable[Action]:
        """Yield a query by the host, which the part answers."""
        yield Query(**common)  # type: ignore[arg-type]

    on_state = on_read = on_list = on_question

    def other(self, statement: Statement, common: Common) -> Iterable[Action]:
        """Yield the actions of a command for whose role there is no method: a stop, a query, or a `Special`."""
        row = statement.row
        if row.at_once and not waits_for_update(row) and row.form not in REMEDIES:  # MTR_OFF does more than stop
            yield Stop(ramped=row.at_once == "brake", **common)  # type: ignore[arg-type]
        elif row.form.startswith("GET_"):
            yield Query(**common)  # type: ignore[arg-type]
        else:
            remedy = REMEDIES.get(row.form, "")
            unneeded = NEEDLESS.get(row.role, "") or NEEDLESS_FORMS.get(row.form, "")
            needless = AT_THE_UPDATE if waits_for_update(row) else unneeded
            yield Special(description=row.description, needless=needless, remedy=remedy, **common)  # type: ignore[arg-type]
            if row.form == "MULTI_UPDATE":
                yield from self._updates(statement, common)

    def _updates(self, statement: Statement, common: Common) -> Iterable[Action]:
        """Yield the motions that one command starts together: a `MoveTo` per selected axis whose target is known."""
        before = self.registers.before(statement)
        for axis in range(1, self.sheet.axes + 1):
            if statement.values[0] >> axis - 1 & 1 and (axis, "target") in before:
                its = self.motion(before, {**common, "axis": axis})
                yield MoveTo(position=before[axis, "target"], implied=True, **its)  # type: ignore[arg-type]


def delay_unit_ps(sheet: Sheet, hz: int) -> int:
    """Return the unit of a part's delays at the crystal frequency `hz`, ps."""
    time = next(sheet.times[name] for name in UNIT_TIMES if name in sheet.times)
    return time.ticks * PS_PER_S // hz
