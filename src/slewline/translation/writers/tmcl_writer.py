"""TMCL, the language of Trinamic's controllers, for a module that runs its program without a host.

TMCL has labels, jumps and subroutines, as the source languages do, so the program flow is unchanged.
Rates and accelerations are in pulses/s and pulses/s^2, at the resolution set by parameter 140;
parameters 19 and 20 (TMCL's start and stop rate) are both set to the start rate of the profile.  The
parameter numbers, their ranges and the commands follow the TMCM-1290 TMCL firmware manual, V1.01.
"""

from __future__ import annotations

import re

from ..meaning import (
    Action,
    Delay,
    EndProgram,
    Home,
    Input,
    Jump,
    Label,
    Loop,
    MoveBy,
    MoveTo,
    Profile,
    Program,
    RunEndless,
    RunProgram,
    SetOutput,
    SetPosition,
    SetProfile,
    WaitInput,
)
from ..move_times import started_time
from ..program_facts import inputs, outputs
from ..target_writer import Target, WriterOptions, Written
from ..translation_report import OutLine
from .language_writer import LanguageWriter
from .source_sheet import PS, number, seconds

MANUAL = "TMCM-1290 TMCL firmware manual V1.01"
TOP, ACCELERATION, DECELERATION, START, STOP = 4, 5, 17, 19, 20  # axis parameters
SLOWEST_STOP = 10
MOST = {TOP: 7_999_774, ACCELERATION: 7_629_278, DECELERATION: 7_629_278, START: 249_999, STOP: 249_999}
LEAST_ACCELERATION = 117
NAMES = {TOP: "top rate", ACCELERATION: "acceleration", DECELERATION: "", START: "start rate", STOP: ""}
TICK_PS = 10 * 10**9  # unit of WAIT TICKS
LINES = 3  # GPIO0 to GPIO2, each an input or an output
DISTANCE, DIRECTION, FIRST_LOOP = 0, 1, 2  # user variables


def parameters(profile: Profile) -> dict[int, float]:
    """Return the values of the axis parameters for a profile, keyed by parameter number."""
    start = profile.start if profile.ramped else profile.top
    wanted = {TOP: profile.top, START: start, STOP: max(start, SLOWEST_STOP)}
    if profile.ramped:
        wanted |= {ACCELERATION: profile.acceleration, DECELERATION: profile.acceleration}
    return wanted


def label(name: str) -> str:
    """Return the name of a source label in the form that TMCL requires: a letter, then letters and digits."""
    plain = re.sub(r"\W", "", name)
    return plain[0].upper() + plain[1:] if plain.startswith(("line", "start", "end")) else f"Label{plain}"


class TmclWriter(LanguageWriter):
    """A writer of TMCL for one program."""

    needs = "MVP and ROR need a number"
    keeps = "the module keeps its program in EEPROM"
    more_axes = ("one motor (TMCM-1290)", "a module for several motors")
    stem = "Program"

    def __init__(self, target: Target, program: Program, options: WriterOptions) -> None:
        super().__init__(target, program, options)
        used = [output for output, _ in outputs(program)]
        own = {output: output - 1 for output in used if output <= LINES}
        free = [at for at in range(LINES + len(used) + len(inputs(program))) if at not in own.values()]
        self.lines = own | dict(zip([each for each in used if each not in own], free, strict=False))
        free = [at for at in free if at not in self.lines.values()]
        self.inputs = dict(zip(inputs(program), free, strict=False))
        self.variable = FIRST_LOOP
        self.loops: dict[int, int] = {}  # the variable of each register
        self.loops_again = False  # a loop may be entered more than once
        self.fresh = 0
        self.block = -1

    def written(self) -> Written:
        host = self._host()
        half = self.program.half_steps
        out = [OutLine(f"SAP 140, 0, {int(half)}", "half steps" if half else "full steps")]
        out.append(OutLine("SAP 16, 0, 0", "one ramp from the start rate to the top rate"))
        out.append(OutLine("SAP 35, 0, 0"))
        for output, level in outputs(self.program):
            if self.lines[output] < LINES:
                out.append(OutLine(f"SIO {self.lines[output]}, 2, {level}", f"output {output} as after a reset"))
        out += [*host, OutLine("STOP")]
        for block, name in self.names.items():
            out += [OutLine(""), *self._block(block, name)]
        assumed = (
            ("module", "TMCM-1290, or another with TMC5xxx"),
            ("current", "parameters 6 and 7, as your motor needs"),
        )
        return self.finished(out, assumed)

    def _host(self) -> list[OutLine]:
        self.sheet.lines, self.known = [], {}
        for action in self.program.block(-1):
            self.action(action)
        return self.commented(-1)

    def _block(self, block: int, name: str) -> list[OutLine]:
        """Return a stored program as a subroutine."""
        self.sheet.lines, self.known = [], dict(self.ran_with.get(block, {}))
        actions = self.inner(block)
        self.block = block
        self.loops = {}
        jumps = [each for each in actions if isinstance(each, Loop | Jump)]
        self.loops_again = len(jumps) > 1
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
        return [
            OutLine(each.text if each.text.endswith(":") else f"  {each.text}", each.comment, each.source)
            for each in self.commented(block)
        ]

    def wires(self) -> list[tuple[str, str]]:
        names = [("step", "the motor itself"), ("direction", "the motor itself"), ("home", "home switch")]
        names += [(f"output{n}", f"GPIO{at}") for n, at in self.lines.items() if at < LINES]
        return names + [(f"input{n}", f"GPIO{at}") for n, at in self.inputs.items() if at < LINES]

    # ------------------------------------------------------------------------------------------------------------ flow
    def _flow(self, action: Action, after: list[Action]) -> None:
        """Write an action of a stored program; `after` holds the program's later actions."""
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
            case _:
                self.action(action)

    def _label(self, name: str, line: int, after: list[Action]) -> None:
        """Write a label if a jump leads to it, or if a command runs the program from it."""
        block = [each for each in self.program.actions if each.block == self.block]
        jumps = [each for each in block if isinstance(each, Jump | Loop) and each.to == name]
        entered = any(isinstance(each, RunProgram) and each.at == name for each in self.program.actions)
        if jumps or entered:
            self.sheet.add(f"{self._at(name)}:", line)
        forward = any(each not in after for each in jumps) or entered
        if forward or any(isinstance(each, SetProfile) for each in after):
            self.known = {}  # several paths meet here, with different parameters

    def _at(self, name: str) -> str:
        return f"{'' if self.block < 1 else f'P{self.block + 1}'}{label(name)}"

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
    def register(self, name: str, value: int, line: int) -> None:
        """Write the assignment of a number to a user variable."""
        self.sheet.add(f"SGP {DISTANCE if name == 'distance' else DIRECTION}, 2, {value}", line)

    def profile(self, action: SetProfile) -> None:
        """Write the axis parameters of a profile."""
        if action.profile is not None:
            self._prepare(action.profile, action.line)
        self.sheet.same(action.line)

    def preset(self, action: SetPosition) -> None:
        """Write the commands that set the actual position and the target position."""
        self._all(action.line, "MST 0", f"SAP 1, 0, {action.position}", f"SAP 0, 0, {action.position}")

    def wait(self, action: WaitInput) -> None:
        """Write a wait for an input: a loop around a comparison."""
        wait, line = self._new("Wait"), action.line
        self.sheet.add(f"{wait}:", line)
        self._compare(action.input, line)
        self.sheet.add(f"JC NE, {wait}", line)
        self.sheet.same(line)

    def leave(self, action: EndProgram) -> None:
        """Write the return from a subroutine."""
        self.sheet.add("RSUB", action.line)
        super().leave(action)

    def call(self, block: int, at: str, line: int) -> None:
        """Write a call to a subroutine, or to a label in it."""
        name = self.names.get(block, self.stem)
        if at:
            name = label(at) if block == 0 else f"P{block + 1}{label(at)}"
        self.sheet.add(f"CSUB {name}", line)
        self.handed_over(block)

    def _prepare(self, profile: Profile, line: int) -> None:
        """Write the axis parameters of a profile, unless they are already set."""
        for parameter, value in parameters(profile).items():
            rounded = round(value)
            if parameter in (ACCELERATION, DECELERATION):
                rounded = max(rounded, LEAST_ACCELERATION)
            if rounded > MOST[parameter]:
                limit = f"parameter {parameter}: {MOST[parameter]:,} at most ({MANUAL}, chapter 4)"
                self.sheet.impossible(line, f"{number(value, 0)}", limit, "coarser steps")
                continue
            if self.known.get(parameter) != rounded:
                self.sheet.add(f"SAP {parameter}, 0, {rounded}", line, NAMES[parameter])
                self.known[parameter] = rounded

    def move(self, action: MoveBy | MoveTo) -> None:
        """Write a move, and a wait for its end."""
        sheet, line = self.sheet, action.line
        if action.profile is not None:
            self._prepare(action.profile, line)
        if isinstance(action, MoveTo):
            position = action.position or 0
            if self.variable_sign:
                self._turn(position, line)
            sheet.add(f"MVP ABS, 0, {position}", line)
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
        description = f"{seconds(becomes * PS)} instead of {seconds(was * PS)}: the ramp has one acceleration"
        sheet.nearly(line, description, abs(becomes - was) / was if was else 0.0, round(abs(becomes - was) * PS))

    def _turn(self, position: int, line: int) -> None:
        """Write the commands that set the direction variable to the direction of a move to a given position."""
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

    def search(self, action: RunEndless | Home, sign: int) -> None:
        """Write a run that is ended by an input, or the search for the home switch."""
        if isinstance(action, Home):
            mode = 7 if sign > 0 else 8
            self._all(action.line, f"SAP 193, 0, {mode}", "RFS START, 0", "WAIT RFS, 0, 0")
            self.sheet.nearly(action.line, "the module's own search for the home switch (parameters 193 to 195)")
            return
        sheet, line, until = self.sheet, action.line, action.until
        if action.profile is not None:
            self._prepare(action.profile, line)
        rate = round(action.profile.top) if action.profile else 0
        if not rate:
            self.unknown(line, "the rate", "set it before")
            return
        sheet.add(f"{'ROR' if sign > 0 else 'ROL'} 0, {rate}", line)
        turning = self._new("Turning")
        sheet.add(f"{turning}:", line)
        if until is None:  # the abort input of the source is wired to the home switch
            sheet.add("GAP 9, 0", line)
            sheet.add("COMP 1", line)
        else:
            self._compare(until, line)
        sheet.add(f"JC NE, {turning}", line)
        sheet.add("MST 0", line)
        slowing = self._new("Slowing")
        self._all(line, f"{slowing}:", "GAP 3, 0", "COMP 0", f"JC NE, {slowing}")
        sheet.nearly(line, "MST decelerates" if until else "the input that ends it is the home switch; MST decelerates")

    def output(self, action: SetOutput) -> None:
        at = self.lines[action.number]
        if at >= LINES:
            self._no_line(f"output {action.number}", action.line)
            return
        self.sheet.add(f"SIO {at}, 2, {action.level}", action.line)
        self.sheet.same(action.line)

    def delay(self, action: Delay) -> None:
        """Write a wait for a given time."""
        ticks = max(1, (action.time_ps + TICK_PS // 2) // TICK_PS)
        self.sheet.add(f"WAIT TICKS, 0, {ticks}", action.line)
        off = abs(ticks * TICK_PS - action.time_ps)
        if off:
            description = f"{seconds(ticks * TICK_PS)} instead of {seconds(action.time_ps)}: a tick is 10 ms"
            self.sheet.nearly(action.line, description, off / action.time_ps, off)
        else:
            self.sheet.same(action.line)
