"""A configuration for Klipper: a manual_stepper, and the program as macros.

Klipper works out the whole text of a macro before its first command runs, so a macro can repeat, but it cannot wait.  A
program is cut where it waits or decides: each piece is a macro that ends with M400, when all motion has ended, and a
delayed_gcode, which is worked out then, reads the inputs (gcode_button) and goes on with the next piece.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from ..meaning import (
    Action,
    Delay,
    EndProgram,
    EnterProgram,
    Home,
    Input,
    LeaveProgram,
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
from ..report import OutLine
from ..writer import Target, Trace, WriterOptions, Written
from .flow import AsLongAs, Branch, Forever, Node, Repeat, State, States, structured
from .sheet import (
    FAR,
    PS,
    Registers,
    Sheet,
    compare_times,
    grouped,
    heading,
    inputs,
    lines_of,
    number,
    outputs,
    runs,
    unspoken,
    variables,
    wired,
    with_comments,
)

MAIN = "PROGRAM"
LATER = "decided when all motion has ended: some 20 ms later"
FROM_REST = "Klipper starts from standstill"
PINS = ("PA0", "PA1", "PA2", "PA3", "PA4", "PA5", "PA6", "PA7", "PB0", "PB1", "PB2", "PB3")


class Klipper(Target):
    """Macros for Klipper."""

    name = "klipper"
    title = "Configuration with macros for Klipper"
    suffix = ".cfg"
    language = "Klipper, G-Codes and Config reference"

    def comment(self, text: str) -> str:
        """Return a comment as a line of its own."""
        return f"# {text}" if text else ""

    def write(self, program: Program, options: WriterOptions) -> Written:
        """Return the configuration."""
        return _Writer(self, program, options).written()

    def read_back(self, text: str, options: WriterOptions) -> Trace | None:
        """Return what the macros do."""
        from ..reading_back.klipper import read

        return read(text, options)


@dataclass
class _Macro:
    """A piece of a program."""

    name: str
    lines: list[OutLine] = field(default_factory=list)


@dataclass
class _Decision:
    """What is decided when a piece has ended: go on with `to` if the condition holds, else with `other`; "": it ends."""

    name: str
    condition: str
    to: str
    other: str
    counts: str = ""  # a variable that is increased before


class _Writer:
    """A writer at work on one program."""

    def __init__(self, target: Target, program: Program, options: WriterOptions) -> None:
        self.target, self.program, self.options = target, program, options
        self.sheet = Sheet(target.comment)
        self.runs = runs(program)
        self.outputs = {output for output, _ in outputs(program)}
        self.inputs = inputs(program)
        self.registers = Registers()
        self.variable_distance, self.variable_sign = variables(program.actions)
        self.pieces: list[_Macro | _Decision] = []
        self.variables = ["at"] + ["distance"] * self.variable_distance + ["direction"] * self.variable_sign
        self.set: tuple[float, float] | None = None
        self.searches = any(isinstance(each, RunEndless | Home) for each in program.actions)

    def written(self) -> Written:
        """Return the result."""
        first = self._macro()
        self._flow(self.program.block(-1), first, "")
        out = [*heading(self.program), *self._configuration()]
        for piece in self.pieces:
            out += [OutLine(""), *(self._section(piece) if isinstance(piece, _Macro) else self._decided(piece))]
        out = comments_of(self.program, out, self.target)
        spm = number(self.options.steps_per_mm)
        assumed = (("steps per millimetre", spm), ("pins", "PA0 ...: put in those of your board"))
        return Written(tuple(out), tuple(self.sheet.verdicts), self._wiring(), assumed)

    # ---------------------------------------------------------------------------------------------------- sections
    def _configuration(self) -> list[OutLine]:
        moves = (each for each in self.program.actions if isinstance(each, MoveBy | MoveTo | RunEndless | Home))
        top = max((each.profile.top for each in moves if each.profile), default=100.0)
        spm = self.options.steps_per_mm
        rows = ["[manual_stepper axis]", "step_pin: PA0", "dir_pin: PA1", "enable_pin: !PA2", "microsteps: 1"]
        rows += [f"rotation_distance: {number(200 / spm)}", f"velocity: {number(top / spm)}", "accel: 0"]
        rows += ["endstop_pin: ^!PA3"] * self.searches
        pins = iter(PINS[4:])
        for output, level in outputs(self.program):
            rows += ["", f"[output_pin output{output}]", f"pin: {next(pins)}", f"value: {level}"]
        for pin in self.inputs:
            rows += ["", f"[gcode_button input{pin}]", f"pin: ^{next(pins)}"]
            rows += ["press_gcode:", "release_gcode:"]
        return [OutLine(row) for row in rows]

    def _section(self, macro: _Macro) -> list[OutLine]:
        head = [OutLine(f"[gcode_macro {macro.name}]")]
        if macro.name == MAIN:
            head += [OutLine(f"variable_{name}: {int(name == 'direction')}") for name in self.variables]
        state = ", ".join(f'{name}=printer["gcode_macro {MAIN}"].{name}' for name in self.variables[:1])
        inside = [OutLine(f"  {{% set ns = namespace({state}) %}}"), *macro.lines]
        if macro.name == MAIN:
            start = "MANUAL_STEPPER STEPPER=axis ENABLE=1 SET_POSITION={ns.at"
            inside.insert(1, OutLine(f"  {start}{self._per_mm()}}}"))
        if not any(line.text.strip() and "set ns =" not in line.text for line in inside):
            inside.append(OutLine("  G4 P0"))
        return [*head, OutLine("gcode:"), *inside]

    def _decided(self, decision: _Decision) -> list[OutLine]:
        rows = [f"[delayed_gcode {decision.name}]", "gcode:"]
        if not decision.condition:
            return [OutLine(row) for row in [*rows, f"  {decision.to}"]]
        rows.append(f"  {{% if {decision.condition} %}}")
        if decision.counts:
            value = f'{{printer["gcode_macro {MAIN}"].{decision.counts} + 1}}'
            rows.append(f"    SET_GCODE_VARIABLE MACRO={MAIN} VARIABLE={decision.counts} VALUE={value}")
        rows.append(f"    {decision.to}")
        again = f"UPDATE_DELAYED_GCODE ID={decision.name} DURATION=0.02"
        if decision.other or decision.counts:
            rows.append("  {% else %}")
        if decision.counts:
            rows.append(f"    SET_GCODE_VARIABLE MACRO={MAIN} VARIABLE={decision.counts} VALUE=1")
        if decision.other:
            rows.append(f"    {again if decision.other == 'again' else decision.other}")
        return [OutLine(row) for row in [*rows, "  {% endif %}"]]

    def _wiring(self) -> tuple[tuple[str, str, str], ...]:
        names = [("step", "step_pin"), ("direction", "dir_pin"), ("enable", "enable_pin")]
        names += [("abort", "endstop_pin"), ("home", "endstop_pin")]
        names += [(f"output{n}", f"[output_pin output{n}]") for n in self.outputs]
        names += [(f"input{n}", f"[gcode_button input{n}]") for n in self.inputs]
        return wired(self.program, names)

    # ------------------------------------------------------------------------------------------------------------ flow
    def _macro(self) -> str:
        made = sum(isinstance(each, _Macro) for each in self.pieces)
        macro = _Macro(MAIN if not made else f"{MAIN}_{made}")
        self.pieces.append(macro)
        return macro.name

    def _named(self, name: str) -> _Macro:
        return next(each for each in self.pieces if isinstance(each, _Macro) and each.name == name)

    def _decide(self, condition: str, to: str, other: str, counts: str = "") -> str:
        name = f"decision_{1 + sum(isinstance(each, _Decision) for each in self.pieces)}"
        self.pieces.append(_Decision(name, condition, to, other, counts))
        return name

    def _then(self, decision: str) -> None:
        """Write the end of a piece: what is decided when all motion has ended."""
        self.sheet.add(f"SET_GCODE_VARIABLE MACRO={MAIN} VARIABLE=at VALUE={{ns.at}}")
        self.sheet.add("M400")
        self.sheet.add(f"UPDATE_DELAYED_GCODE ID={decision} DURATION=0.01")

    def _flow(self, tree: Sequence[Node], name: str, cont: str, leave: str = "") -> None:
        """Write nodes into a macro and those after it; then goes on with the macro `cont`, or ends; `leave`: at an end."""
        self.sheet.lines, self.sheet.depth = [], 1
        before = len(self.sheet.lines)
        for place, node in enumerate(tree):
            if self._simple(node):
                self._write(node)
                continue
            self._split(node, tree[place + 1 :], name, cont, leave, before)
            return
        if cont:
            self._then(self._decide("", cont, ""))
        self._close(name)

    def _close(self, name: str) -> None:
        """Put what has been written into a macro."""
        self._named(name).lines += self.sheet.lines
        self.sheet.lines = []

    def _simple(self, node: Node) -> bool:
        """Return whether a node neither waits nor decides."""
        if isinstance(node, Repeat):
            return all(self._simple(each) for each in node.body)
        runs_one = isinstance(node, RunProgram) or (isinstance(node, LeaveProgram) and node.runs)
        return not isinstance(node, Forever | AsLongAs | Branch | States | WaitInput | EndProgram) and not runs_one

    def _split(self, node: Node, rest: Sequence[Node], name: str, cont: str, leave: str, before: int) -> None:
        """Write a node at which the program is cut, and what follows it."""
        del before
        match node:
            case WaitInput():
                after = self._macro()
                self._then(self._decide(self._condition([node.input]), after, "again"))
                self._close(name)
                self.sheet.nearly(node.line, LATER)
                self._flow(rest, after, cont, leave)
            case Forever():
                loop = self._macro()
                self._then(self._decide("", loop, ""))
                self._close(name)
                self.set = None
                self._flow(node.body, loop, loop, leave)
                self.sheet.nearly(node.line, LATER)
            case AsLongAs() | Repeat():
                loop, after = self._macro(), self._macro()
                self._then(self._decide("", loop, ""))
                self._close(name)
                self.set = None
                if isinstance(node, Repeat):
                    counter = f"passes{len(self.variables)}"
                    self.variables.append(counter)
                    condition = f'printer["gcode_macro {MAIN}"].{counter} < {node.passes}'
                    again = self._joint(self._decide(condition, loop, after, counter))
                else:
                    again = self._joint(self._decide(self._condition(node.inputs), loop, after))
                self._flow(node.body, loop, again, leave)
                self.sheet.nearly(node.line, LATER)
                self.set = None
                self._flow(rest, after, cont, leave)
            case Branch():
                then, otherwise, after = self._macro(), self._macro(), self._macro()
                self._then(self._decide(self._condition(node.inputs), then, otherwise))
                self._close(name)
                self.sheet.nearly(node.line, LATER)
                for macro, inside in ((then, node.then), (otherwise, node.otherwise)):
                    self.set = None
                    self._flow(inside, macro, after, leave)
                self.set = None
                self._flow(rest, after, cont, leave)
            case States():
                self._states(node, name, leave or cont)
            case EndProgram():
                self.sheet.same(node.line)
                if leave:
                    self._then(self._decide("", leave, ""))
                self._close(name)
            case RunProgram() | LeaveProgram():
                self._run(node, rest, name, cont)
            case _:
                raise AssertionError(node)

    def _joint(self, decision: str) -> str:
        """Return a macro that goes on with a decision."""
        name = self._macro()
        lines, self.sheet.lines = self.sheet.lines, []
        self._then(decision)
        self._close(name)
        self.sheet.lines = lines
        return name

    def _run(self, action: RunProgram | LeaveProgram, rest: Sequence[Node], name: str, cont: str) -> None:
        if isinstance(action, RunProgram) and action.at:
            limit = "a macro begins at its first line"
            says = f"the program runs from {action.at} on"
            self.sheet.impossible(action.line, says, limit, "split the program there")
            self._flow_on(rest, name, cont)
            return
        block = self.runs[action.line]
        actions = [each for each in self.program.block(block) if not isinstance(each, EnterProgram | LeaveProgram)]
        self.sheet.same(action.line, "what runs is written here")
        tree = structured(actions)
        if all(self._simple(each) or isinstance(each, EndProgram) for each in tree):
            for each in tree:
                if self._simple(each):
                    self._write(each)
                else:
                    self.sheet.same(each.line)
            self._flow_on(rest, name, cont)
            return
        after = self._macro() if rest or cont else ""
        inside = self._macro()
        self._then(self._decide("", inside, ""))
        self._close(name)
        self._flow(tree, inside, after, after)
        if after:
            self.set = None
            self._flow(rest, after, cont)

    def _flow_on(self, rest: Sequence[Node], name: str, cont: str) -> None:
        """Go on in the same macro."""
        self._close(name)
        self._flow(rest, name, cont)

    def _states(self, node: States, name: str, leave: str) -> None:
        macros = {each.number: self._macro() for each in node.states}
        self._then(self._decide("", macros[node.states[0].number], ""))
        self._close(name)
        for each in node.states:
            self.set = None
            self._flow(each.body, macros[each.number], self._next(each, macros, leave))
            if each.inputs or each.passes or each.to >= 0:
                self.sheet.nearly(each.line, LATER)

    def _next(self, state: State, macros: dict[int, str], leave: str) -> str:
        """Return the macro with which a piece goes on; one that decides, if that is not settled."""
        to, below = macros.get(state.to, leave), macros.get(state.below, leave)
        if state.inputs:
            return self._joint(self._decide(self._condition(state.inputs), to, below))
        if state.passes:
            counter = f"passes{len(self.variables)}"
            self.variables.append(counter)
            condition = f'printer["gcode_macro {MAIN}"].{counter} < {state.passes}'
            return self._joint(self._decide(condition, to, below, counter))
        return to

    def _condition(self, wanted: Sequence[Input]) -> str:
        names = {1: "PRESSED", 0: "RELEASED"}
        return " and ".join(
            f'printer["gcode_button input{each.number}"].state == "{names[each.level]}"' for each in wanted
        )

    # -------------------------------------------------------------------------------------------------------- actions
    def _write(self, node: Node) -> None:
        """Write a node that neither waits nor decides, with the comments of its lines."""
        if isinstance(node, Repeat):
            self.sheet.add(f"{{% for _ in range({node.passes}) %}}", node.head)
            self.sheet.depth += 1
            self.set = None
            self.registers.position = None
            for each in node.body:
                self._write(each)
            self.sheet.depth -= 1
            self.sheet.add("{% endfor %}", node.line)
            self.sheet.same(node.line)
            return
        assert isinstance(node, Action)  # noqa: S101
        self._action(node)
        self.registers.note(node)

    def _action(self, action: Action) -> None:
        sheet, line = self.sheet, action.line
        match action:
            case SetProfile():
                self._profile(action)
            case SetDistance():
                if self.variable_distance:
                    self._variable("distance", action.steps, line)
                sheet.same(line, "it is in the moves")
            case SetDirection():
                if self.variable_sign:
                    self._variable("direction", action.sign, line)
                sheet.same(line, "it is in the moves")
            case SetPosition():
                sheet.add(f"{{% set ns.at = {action.position} %}}", line)
                sheet.add(f"MANUAL_STEPPER STEPPER=axis SET_POSITION={{ns.at{self._per_mm()}}}", line)
                sheet.same(line)
            case MoveBy() | MoveTo():
                self._move(action)
            case RunEndless() | Home():
                self._search(action)
            case SetOutput():
                if not (action.implied and action.number not in self.outputs):
                    sheet.add(f"SET_PIN PIN=output{action.number} VALUE={action.level}", line)
                    sheet.same(line)
            case Delay():
                sheet.add(f"G4 P{number(action.time_ps * 1000 / PS, 3)}", line)
                sheet.same(line)
            case EnterProgram() | LeaveProgram():
                pass
            case _:
                unspoken(sheet, action, "the result is a file, which is kept")

    def _variable(self, name: str, value: int, line: int) -> None:
        limit = "a macro is worked out before it runs (Command templates)"
        self.sheet.impossible(line, f"the {name} depends on the path through the program", limit, "take --to linuxcnc")
        del value

    def _per_mm(self) -> str:
        return "" if self.options.steps_per_mm == 1 else f" / {number(self.options.steps_per_mm)}"

    def _mm(self, value: float) -> str:
        return number(value / self.options.steps_per_mm, 4)

    def _profile(self, action: SetProfile) -> None:
        if action.sets == "start rate" and action.profile is not None and action.profile.ramped:
            self.sheet.nearly(action.line, f"no start rate: {FROM_REST}")
        elif action.sets == "ramp" and action.profile is not None and action.profile.ramped:
            mm = self._mm(action.profile.acceleration)
            self.sheet.nearly(action.line, f"a constant acceleration, {mm} mm/s^2: the mean of the ramp")
        else:
            self.sheet.same(action.line, "it is in the moves")

    def _rates(self, profile: Profile | None) -> str:
        """Return the words for rate and acceleration; without a ramp the acceleration is 0, which is none."""
        if profile is None:
            return ""
        acceleration = profile.acceleration if profile.ramped else 0.0
        return f" SPEED={self._mm(profile.top)} ACCEL={self._mm(acceleration)}"

    def _move(self, action: MoveBy | MoveTo) -> None:
        line = action.line
        if action.axis != 1:
            self.sheet.impossible(
                line, f"axis {action.axis}", "one manual_stepper is written", "add another one by hand"
            )
            return
        profile = action.profile or self.registers.profile
        if isinstance(action, MoveTo):
            if action.position is None:
                remedy = "write the command with a number"
                self.sheet.impossible(line, "the position is not known from the text", "MOVE needs a number", remedy)
                return
            self.sheet.add(f"{{% set ns.at = {action.position} %}}", line)
        else:
            steps = self.registers.steps(action)
            if steps is None:
                remedy = "write the command with a number"
                self.sheet.impossible(line, "the number of steps is not known from the text", "MOVE needs it", remedy)
                return
            self.sheet.add(f"{{% set ns.at = ns.at {'+' if steps >= 0 else '-'} {abs(steps)} %}}", line)
        self.sheet.add(f"MANUAL_STEPPER STEPPER=axis MOVE={{ns.at{self._per_mm()}}}{self._rates(profile)}", line)
        acceleration = 0.0 if profile is None or not profile.ramped else profile.acceleration
        compare_times(self.sheet, action, acceleration, FROM_REST)

    def _search(self, action: RunEndless | Home) -> None:
        line, sign = action.line, action.sign
        if sign is None:
            sign = self.registers.sign
        if sign is None:
            remedy = "set the direction in the text"
            self.sheet.impossible(line, "the direction is not known from the text", "MOVE needs a number", remedy)
            return
        until = action.until if isinstance(action, RunEndless) else None
        kind = "try_inverted_probe" if until and until.level else "try_probe"
        words = f"MOVE={self._mm(sign * FAR)} STOP_ON_ENDSTOP={kind}{self._rates(action.profile)}"
        self.sheet.add(f"MANUAL_STEPPER STEPPER=axis {words}", line)
        if isinstance(action, Home):
            self.sheet.add("{% set ns.at = 0 %}", line)
            self.sheet.add("MANUAL_STEPPER STEPPER=axis SET_POSITION=0", line)
            self.sheet.nearly(line, f"ends after {grouped(FAR)} steps at the latest; the switch is the endstop_pin")
            return
        says = f"ends at the position {grouped(FAR)} at the latest; a relative move after it is counted from where it began"
        self.sheet.nearly(line, says)


def comments_of(program: Program, out: list[OutLine], target: Target) -> list[OutLine]:
    """Return a result with the comments of all blocks."""
    for block in (-1, *sorted({each.block for each in program.actions if each.block >= 0})):
        out = with_comments(lines_of(program, block), out, target.comment)
    return out
