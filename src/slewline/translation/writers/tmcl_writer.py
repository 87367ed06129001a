"""TMCL, for a module that runs a program by itself: the language of Trinamic's controllers.

It has labels, jumps and subroutines, as the parts themselves have, so the flow is kept.  Rates and accelerations are in
pulses/s and pulses/s^2 of the resolution in parameter 140; parameters 19 and 20 are the start rate.  Numbers of
parameters, their ranges and the commands are those of the TMCM-1290 TMCL firmware manual, V1.01.
"""

from __future__ import annotations

from ..meaning import (
    Action,
    Delay,
    EndProgram,
    EnterProgram,
    Home,
    Input,
    Jump,
    Label,
    LeaveProgram,
    Loop,
    MoveBy,
    MoveTo,
    Profile,
    Program,
    RunEndless,
    RunProgram,
    SetDirection,
    SetDistance,
    SetOutput,
    SetPosition,
    SetProfile,
    WaitInput,
)
from ..target_writer import PlayedTrace, Target, WriterOptions, Written
from ..translation_report import OutLine
from .source_sheet import (
    PS,
    Draft,
    heading,
    inputs,
    lines_of,
    number,
    outputs,
    runs,
    seconds,
    started_time,
    stored,
    unspoken,
    variables,
    wired,
    with_comments,
)
from .tmcl_module import ACCELERATION, DECELERATION, LEAST_ACCELERATION, MANUAL, MOST, NAMES, label, parameters

TICK_PS = 10 * 10**9  # of WAIT TICKS
LINES = 3  # GPIO0 to GPIO2, each an input or an output
DISTANCE, DIRECTION, FIRST_LOOP = 0, 1, 2  # user variables


class Tmcl(Target):
    """A program in TMCL."""

    name = "tmcl"
    title = "TMCL for a module of Trinamic"
    suffix = ".tmc"
    language = MANUAL

    def comment(self, text: str) -> str:
        """Return a comment as a line of its own."""
        return f"// {text}" if text else ""

    def write(self, program: Program, options: WriterOptions) -> Written:
        """Return the program with labels and jumps."""
        return _TmclWriter(self, program).written()

    def read_back(self, text: str, options: WriterOptions) -> PlayedTrace | None:
        """Return what the program does, assembled and run."""
        from ..reading_back.tmcl_reader import read

        return read(text, options)


class _TmclWriter:
    """A writer at work on one program."""

    def __init__(self, target: Target, program: Program) -> None:
        self.target, self.program = target, program
        self.sheet = Draft(target.comment, program)
        self.variable_distance, self.variable_sign = variables(program.actions)
        self.names = {each: "Program" if each == 0 else f"Program{each + 1}" for each in stored(program)}
        self.runs = runs(program)
        self.outputs = {output: at for at, (output, _) in enumerate(outputs(program))}
        self.inputs = {pin: len(self.outputs) + at for at, pin in enumerate(inputs(program))}
        self.set: dict[int, int] = {}  # axis parameters that are known here
        self.ran_with: dict[int, dict[int, int]] = {}
        self.variable = FIRST_LOOP
        self.loops: dict[int, int] = {}  # the variable of each
        self.loops_again = False  # a loop may be entered more than once
        self.fresh = 0
        self.block = -1
        self._prefix = ""

    def written(self) -> Written:
        """Return the result."""
        host = self._host()
        out = [*heading(self.program)]
        half = self.program.half_steps
        out.append(OutLine(f"SAP 140, 0, {int(half)}", "half steps" if half else "full steps"))
        out.append(OutLine("SAP 16, 0, 0", "one ramp from the start rate to the top rate"))
        out.append(OutLine("SAP 35, 0, 0"))
        for output, level in outputs(self.program):
            if self.outputs[output] < LINES:
                out.append(OutLine(f"SIO {self.outputs[output]}, 2, {level}", f"output {output} as after a reset"))
        out += [*host, OutLine("STOP")]
        for block, name in self.names.items():
            out += [OutLine(""), *self._block(block, name)]
        assumed = (
            ("module", "TMCM-1290, or another with TMC5xxx"),
            ("current", "parameters 6 and 7, as your motor needs"),
        )
        return Written(tuple(out), tuple(self.sheet.verdicts), self._wiring(), assumed)

    def _host(self) -> list[OutLine]:
        self.sheet.lines, self.set = [], {}
        for action in self.program.block(-1):
            self.action(action)
        return with_comments(lines_of(self.program, -1), self.sheet.lines, self.target.comment)

    def _block(self, block: int, name: str) -> list[OutLine]:
        """Return a stored program as a subroutine."""
        self.sheet.lines, self.set = [], dict(self.ran_with.get(block, {}))
        actions = [each for each in self.program.block(block) if not isinstance(each, EnterProgram | LeaveProgram)]
        self.block = block
        self.loops = {}
        prefix = "" if block == 0 else f"P{block + 1}"
        jumps = [each for each in actions if isinstance(each, Loop | Jump)]
        self.loops_again = len(jumps) > 1
        self._prefix = prefix
        entry = actions[0].line if actions else 0
        self.sheet.add(f"{name}:", entry)
        for loop in jumps:
            if isinstance(loop, Loop):
                self.loops[id(loop)] = self.variable
                self.sheet.add(f"SGP {self.variable}, 2, {loop.passes}", entry)
                self.variable += 1
        for place, each in enumerate(actions):
            self._flow(each, actions[place + 1 :])
        if not actions or not isinstance(actions[-1], EndProgram):
            self.sheet.add("RSUB", actions[-1].line if actions else 0)
        found = with_comments(lines_of(self.program, block), self.sheet.lines, self.target.comment)
        return [
            OutLine(each.text if each.text.endswith(":") else f"  {each.text}", each.comment, each.source)
            for each in found
        ]

    def _wiring(self) -> tuple[tuple[str, str, str], ...]:
        names = [("step", "the motor itself"), ("direction", "the motor itself"), ("home", "home switch")]
        names += [(f"output{n}", f"GPIO{at}") for n, at in self.outputs.items() if at < LINES]
        names += [(f"input{n}", f"GPIO{at}") for n, at in self.inputs.items() if at < LINES]
        return wired(self.program, names)

    # ------------------------------------------------------------------------------------------------------------ flow
    def _flow(self, action: Action, after: list[Action]) -> None:
        """Write an action of a stored program."""
        sheet, line = self.sheet, action.line
        match action:
            case Label():
                self._label(action.name, line, after)
            case Loop():
                variable = self.loops[id(action)]
                sheet.add(f"DJNZ {variable}, {self._at(action.to)}", line)
                if self.loops_again:
                    sheet.add(f"SGP {variable}, 2, {action.passes}", line)
                sheet.same(line)
            case Jump():
                self._jump(action)
                sheet.same(line)
            case RunProgram():
                sheet.add(f"JA {self.names[action.block]}", line)
                sheet.same(line)
            case EndProgram():
                sheet.add("RSUB", line)
                sheet.same(line)
            case _:
                self.action(action)

    def _label(self, name: str, line: int, after: list[Action]) -> None:
        """Write a label to which something leads."""
        block = [each for each in self.program.actions if each.block == self.block]
        jumps = [each for each in block if isinstance(each, Jump | Loop) and each.to == name]
        entered = any(isinstance(each, RunProgram) and each.at == name for each in self.program.actions)
        if jumps or entered:
            self.sheet.add(f"{self._at(name)}:", line)
        forward = any(each not in after for each in jumps) or entered
        if forward or any(isinstance(each, SetProfile) for each in after):
            self.set = {}  # more than one path leads here, with different parameters

    def _at(self, name: str) -> str:
        return f"{self._prefix}{label(name)}"

    def _new(self, what: str) -> str:
        self.fresh += 1
        return f"{what}{self.fresh}"

    def _jump(self, action: Jump) -> None:
        to, line = self._at(action.to), action.line
        if not action.inputs:
            self.sheet.add(f"JA {to}", line)
            return
        *others, last = action.inputs
        past = self._new("Past") if others else ""
        for each in others:
            self._compare(each, line)
            self.sheet.add(f"JC NE, {past}", line)
        self._compare(last, line)
        self.sheet.add(f"JC EQ, {to}", line)
        if past:
            self.sheet.add(f"{past}:", line)

    def _compare(self, each: Input, line: int) -> None:
        self.sheet.add(f"GIO {self._port(each.number, line)}, 0", line)
        self.sheet.add(f"COMP {each.level}", line)

    def _port(self, pin: int, line: int) -> int:
        at = self.inputs[pin]
        if at >= LINES:
            self._no_line(f"input {pin}", line)
        return min(at, LINES - 1)

    def _no_line(self, what: str, line: int) -> None:
        limit = f"{LINES} lines for inputs and outputs together ({MANUAL}, 3.6.12 and 3.6.13)"
        self.sheet.impossible(line, what, limit, "a module with more lines; change the numbers of GIO and SIO")

    # -------------------------------------------------------------------------------------------------------- actions
    def action(self, action: Action) -> None:
        """Write an action."""
        sheet, line = self.sheet, action.line
        match action:
            case SetProfile():
                if action.profile is not None:
                    self._prepare(action.profile, line)
                sheet.same(line)
            case SetDistance():
                if self.variable_distance:
                    sheet.add(f"SGP {DISTANCE}, 2, {action.steps}", line)
                sheet.same(line)
            case SetDirection():
                if self.variable_sign:
                    sheet.add(f"SGP {DIRECTION}, 2, {action.sign}", line)
                sheet.same(line)
            case SetPosition():
                self._all(line, "MST 0", f"SAP 1, 0, {action.position}", f"SAP 0, 0, {action.position}")
                sheet.same(line)
            case MoveBy() | MoveTo():
                self._move(action)
            case RunEndless():
                self._endless(action)
            case Home():
                mode = 7 if action.sign > 0 else 8
                self._all(line, f"SAP 193, 0, {mode}", "RFS START, 0", "WAIT RFS, 0, 0")
                sheet.nearly(line, "the module's own search for the home switch (parameters 193 to 195)")
            case SetOutput():
                self._output(action)
            case WaitInput():
                wait = self._new("Wait")
                sheet.add(f"{wait}:", line)
                self._compare(action.input, line)
                sheet.add(f"JC NE, {wait}", line)
                sheet.same(line)
            case Delay():
                self._delay(action)
            case LeaveProgram() | RunProgram():
                self._run(action)
            case _:
                unspoken(sheet, action, "the module keeps its program in EEPROM")

    def _run(self, action: LeaveProgram | RunProgram) -> None:
        if isinstance(action, LeaveProgram) and not action.runs:
            return
        block = self.runs[action.line]
        name = self.names.get(block, "Program")
        if isinstance(action, RunProgram) and action.at:
            name = label(action.at) if block == 0 else f"P{block + 1}{label(action.at)}"
        self.sheet.add(f"CSUB {name}", action.line)
        self.sheet.same(action.line)
        self.ran_with[block] = dict(self.set) if self.ran_with.get(block, self.set) == self.set else {}
        self.set = {}

    def _prepare(self, profile: Profile, line: int) -> None:
        """Write the axis parameters of a profile, unless they are set."""
        for parameter, value in parameters(profile).items():
            rounded = round(value)
            if parameter in (ACCELERATION, DECELERATION):
                rounded = max(rounded, LEAST_ACCELERATION)
            if rounded > MOST[parameter]:
                limit = f"parameter {parameter}: {MOST[parameter]:,} at most ({MANUAL}, chapter 4)"
                self.sheet.impossible(line, f"{number(value, 0)}", limit, "coarser steps")
                continue
            if self.set.get(parameter) != rounded:
                self.sheet.add(f"SAP {parameter}, 0, {rounded}", line, NAMES[parameter])
                self.set[parameter] = rounded

    def _move(self, action: MoveBy | MoveTo) -> None:
        sheet, line = self.sheet, action.line
        if action.axis != 1:
            sheet.impossible(line, f"axis {action.axis}", "one motor (TMCM-1290)", "a module for several motors")
            return
        if action.profile is not None:
            self._prepare(action.profile, line)
        if isinstance(action, MoveTo):
            if action.position is None:
                remedy = "write the command with a number"
                sheet.impossible(line, "the position is not known from the text", "MVP needs a number", remedy)
                return
            if self.variable_sign:
                self._turn(action.position, line)
            sheet.add(f"MVP ABS, 0, {action.position}", line)
        elif action.steps is not None:
            sheet.add(f"MVP REL, 0, {action.steps}", line)
        else:
            self._product(action)
        sheet.add("WAIT POS, 0, 0", line)
        profile, steps = action.profile, action.steps
        if profile is None or not steps:
            sheet.nearly(line, "the steps are the same; the ramp has one acceleration")
            return
        was = sheet.time_of(profile, steps)
        becomes = started_time(profile, steps)
        says = f"{seconds(becomes * PS)} for {seconds(was * PS)}: the ramp has one acceleration"
        sheet.nearly(line, says, abs(becomes - was) / was if was else 0.0, round(abs(becomes - was) * PS))

    def _turn(self, position: int, line: int) -> None:
        """Write that the direction is from now on the one in which the motor moves to a position."""
        ahead = self._new("Ahead")
        self._all(line, f"SGP {DIRECTION}, 2, 1", "GAP 1, 0", f"COMP {position}", f"JC LE, {ahead}")
        self._all(line, f"SGP {DIRECTION}, 2, -1", f"{ahead}:")

    def _all(self, line: int, *texts: str) -> None:
        for text in texts:
            self.sheet.add(text, line)

    def _product(self, action: MoveBy) -> None:
        line = action.line
        if action.distance is None:
            self.sheet.add(f"GGP {DISTANCE}, 2", line)
        else:
            self.sheet.add(f"CALC LOAD, {action.distance}", line)
        if action.sign is None:
            self.sheet.add(f"CALCAV MUL, {DIRECTION}", line)
        elif action.sign < 0:
            self.sheet.add("CALC MUL, -1", line)
        self.sheet.add("MVPA REL, 0", line)

    def _endless(self, action: RunEndless) -> None:
        sheet, line, until = self.sheet, action.line, action.until
        if action.sign is None:
            remedy = "set the direction in the text"
            sheet.impossible(line, "the direction is not known from the text", "ROR or ROL", remedy)
            return
        if action.profile is not None:
            self._prepare(action.profile, line)
        rate = round(action.profile.top) if action.profile else 0
        if not rate:
            sheet.impossible(line, "the rate is not known from the text", "ROR needs a number", "set it before")
            return
        sheet.add(f"{'ROR' if action.sign > 0 else 'ROL'} 0, {rate}", line)
        turning = self._new("Turning")
        sheet.add(f"{turning}:", line)
        if until is None:  # what the source calls abort is wired to the home switch
            sheet.add("GAP 9, 0", line)
            sheet.add("COMP 1", line)
        else:
            self._compare(until, line)
        sheet.add(f"JC NE, {turning}", line)
        sheet.add("MST 0", line)
        slowing = self._new("Slowing")
        self._all(line, f"{slowing}:", "GAP 3, 0", "COMP 0", f"JC NE, {slowing}")
        sheet.nearly(line, "MST decelerates" if until else "what ends it goes to the home switch; MST decelerates")

    def _output(self, action: SetOutput) -> None:
        if action.implied and action.number not in self.outputs:
            return
        at = self.outputs[action.number]
        if at >= LINES:
            self._no_line(f"output {action.number}", action.line)
            return
        self.sheet.add(f"SIO {at}, 2, {action.level}", action.line)
        self.sheet.same(action.line)

    def _delay(self, action: Delay) -> None:
        ticks = max(1, (action.time_ps + TICK_PS // 2) // TICK_PS)
        self.sheet.add(f"WAIT TICKS, 0, {ticks}", action.line)
        off = abs(ticks * TICK_PS - action.time_ps)
        if off:
            says = f"{seconds(ticks * TICK_PS)} for {seconds(action.time_ps)}: a tick is 10 ms"
            self.sheet.nearly(action.line, says, off / action.time_ps, off)
        else:
            self.sheet.same(action.line)
