"""A host script in Python, for what G-code cannot do: it loops, waits and decides, and sends grbl what comes next.

Inputs are those that grbl reports: the probe and the limit switches, with hard limits ($21) and homing ($22) off.
"""

from __future__ import annotations

from collections.abc import Sequence

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
from .flow import AsLongAs
from .grbl_writer import FASTEST, FROM_REST, LETTERS, OUTPUTS, GrblWords
from .host_frame import FRAME
from .source_sheet import (
    FAR,
    PS,
    compare_times,
    grouped,
    heading,
    number,
    one_acceleration,
    outputs,
    runs,
    stored,
    unspoken,
    variables,
    wired,
)
from .structured import Structured

PINS = {1: ("P", "pin A5, probe"), 2: ("X", "pin D9, limit X"), 3: ("Y", "pin D10, limit Y")}
PINS |= {4: ("Z", "pin D12, limit Z")}


class HostScript(Target):
    """A script in Python for a board with grbl."""

    name = "python"
    title = "Script in Python for a board with grbl"
    suffix = ".py"
    language = "Python 3 with pySerial, grbl 1.1h"

    def comment(self, text: str) -> str:
        """Return a comment as a line of its own."""
        return f"# {text}" if text else ""

    def write(self, program: Program, options: WriterOptions) -> Written:
        """Return the script."""
        return _ScriptWriter(self, program, options).written()

    def read_back(self, text: str, options: WriterOptions) -> PlayedTrace | None:
        """Return what the script does, by its syntax tree."""
        from ..reading_back.script_reader import read

        return read(text, options)


class _ScriptWriter(Structured):
    """A writer at work on one program."""

    nothing = "pass"

    def __init__(self, target: Target, program: Program, options: WriterOptions) -> None:
        super().__init__(target, program, options, "    ")
        self.words = GrblWords(options)
        self.variable_distance, self.variable_sign = variables(program.actions)
        self.acceleration = one_acceleration(program.actions)
        self.names = {each: "program" if each == 0 else f"program{each + 1}" for each in stored(program)}
        self.runs = runs(program)
        self.outputs = {output for output, _ in outputs(program)}
        self.rate: float | None = None
        self.ran_with: dict[int, float | None] = {}

    def written(self) -> Written:
        """Return the result."""
        spm, mm = number(self.options.steps_per_mm), number(self.acceleration / self.options.steps_per_mm)
        port = self.options.values.get("port", "/dev/ttyUSB0")
        frame = FRAME.format(letter=self.words.letter(1), spm=spm, digits=self.words.digits, port=port)
        host = self._function("main", -1)
        blocks = [line for block, name in self.names.items() for line in self._function(name, block)]
        out = [*heading(self.program), *(OutLine(line) for line in frame.splitlines()), *blocks, *host]
        out += [OutLine(""), OutLine(""), OutLine('if __name__ == "__main__":'), OutLine("    main(Grbl(PORT))")]
        assumed = (("$100, steps/mm", spm), ("$120, mm/s^2", mm), ("$21 and $22", "0: limit switches are inputs"))
        return Written(tuple(out), tuple(self.sheet.verdicts), self._wiring(), assumed)

    def _function(self, name: str, block: int) -> list[OutLine]:
        """Return a function with what the part or its host does."""
        self.sheet.lines = []
        self.sheet.depth = 1
        self.rate = self.ran_with.get(block)
        actions = [each for each in self.program.block(block) if not isinstance(each, EnterProgram)]
        if block >= 0:
            self.program_tree([each for each in actions if not isinstance(each, LeaveProgram)])
        else:
            self.sheet.add('grbl.send("G21 G90 G94")', 0, "mm, absolute, mm/min")
            for output, level in outputs(self.program):
                if output in OUTPUTS:
                    self.sheet.add(f'grbl.send("{OUTPUTS[output][1 - level]}")', 0, f"output {output} as after a reset")
            self.tree(actions)
        self.sheet.depth = 0
        used = ["distance"] * self.variable_distance + ["direction"] * self.variable_sign
        inside = self.commented(block) or [OutLine("    pass")]
        if used and block >= 0:
            inside.insert(0, OutLine(f"    global {', '.join(used)}"))
        elif used:
            inside[:0] = [OutLine(f"    global {', '.join(used)}")]
        out = [OutLine(""), OutLine(""), OutLine(f"def {name}(grbl):"), *inside]
        return out if block >= 0 else [*self._variables(), *out]

    def _variables(self) -> list[OutLine]:
        found = []
        if self.variable_distance:
            found.append(OutLine("distance = 0", "of relative moves, steps"))
        if self.variable_sign:
            found.append(OutLine("direction = 1", "of relative moves"))
        return [OutLine(""), *found] if found else []

    def _wiring(self) -> tuple[tuple[str, str, str], ...]:
        letter = self.words.letter(1)
        at = LETTERS.index(letter)
        names = [("step", f"pin D{2 + at}, step {letter}"), ("direction", f"pin D{5 + at}, direction {letter}")]
        names += [("enable", "pin D8"), ("abort", "pin A5, probe"), ("home", "pin A5, probe")]
        names += [(f"output{output}", pin) for output, (_, _, pin) in OUTPUTS.items()]
        names += [(f"input{pin}", where) for pin, (_, where) in PINS.items()]
        return wired(self.program, names)

    # -------------------------------------------------------------------------------------------------------- actions
    def action(self, action: Action) -> None:
        sheet, line = self.sheet, action.line
        match action:
            case SetProfile():
                self._profile(action)
            case SetDistance():
                if self.variable_distance:
                    sheet.add(f"distance = {action.steps}", line)
                sheet.same(line)
            case SetDirection():
                if self.variable_sign:
                    sheet.add(f"direction = {action.sign}", line)
                sheet.same(line)
            case SetPosition():
                sheet.add(f"grbl.set_position({action.position}{self._axis(action)})", line)
                sheet.same(line)
            case MoveBy() | MoveTo():
                self._move(action)
            case RunEndless() | Home():
                self._search(action)
            case SetOutput():
                self._output(action)
            case WaitInput():
                if self._is_input(action.input.number, line):
                    sheet.add(f"grbl.wait({action.input.number}, {action.input.level})", line)
                    sheet.nearly(line, "the host asks grbl for its inputs: some 10 ms later")
            case Delay():
                sheet.add(f"time.sleep({number(action.time_ps / PS)})", line)
                sheet.nearly(line, "the host's clock: some milliseconds longer")
            case EndProgram():
                if action is not self.final:
                    sheet.add("return", line)
                sheet.same(line)
            case LeaveProgram() | RunProgram():
                self._run(action)
            case _:
                unspoken(sheet, action, "the result is a file, which is kept")

    def _axis(self, action: Action) -> str:
        return "" if action.axis == 1 else f', axis="{self.words.letter(action.axis)}"'

    def _run(self, action: LeaveProgram | RunProgram) -> None:
        if isinstance(action, LeaveProgram) and not action.runs:
            return
        if isinstance(action, RunProgram) and action.at:
            limit = "a function begins at its first line (Python)"
            self.sheet.impossible(
                action.line, f"the program runs from {action.at} on", limit, "split the program there"
            )
            return
        block = self.runs[action.line]
        self.sheet.add(f"{self.names.get(block, 'program')}(grbl)", action.line)
        self.sheet.same(action.line)
        self.ran_with[block] = self.rate if self.ran_with.get(block, self.rate) == self.rate else None
        self.rate = None

    def forget(self, tree: Sequence[object]) -> None:
        """Forget the rate as well, where more than one path may lead."""
        before = self.registers.profile
        super().forget(tree)  # type: ignore[arg-type]
        if before is not None and self.registers.profile is None:
            self.rate = None

    def _set_rate(self, rate: float | None, line: int) -> None:
        if rate is not None and rate != self.rate:
            self.sheet.add(f"grbl.feed({number(rate, 3)})", line)
            self.rate = rate

    def _profile(self, action: SetProfile) -> None:
        profile = action.profile
        rate = profile.top if profile else action.value if action.sets == "top rate" else None
        if action.sets != "ramp":
            self._set_rate(rate, action.line)
        if action.sets == "top rate" and rate is not None and rate > FASTEST:
            limit = f"{FASTEST:,} steps/s (README of grbl)"
            self.sheet.impossible(action.line, f"{number(rate, 0)} steps/s", limit, "coarser steps, or LinuxCNC")
        elif action.sets == "top rate":
            self.sheet.same(action.line)
        elif action.sets == "start rate":
            self.sheet.nearly(action.line, f"no start rate: {FROM_REST}")
        else:
            mm = number(self.acceleration / self.options.steps_per_mm, 1)
            self.sheet.nearly(action.line, f"the ramp is that of the settings: $120={mm} mm/s^2")

    def _move(self, action: MoveBy | MoveTo) -> None:
        line = action.line
        if not self.words.letter(action.axis):
            self.sheet.impossible(line, f"axis {action.axis}", "3 axes: X, Y, Z", "LinuxCNC")
            return
        self._set_rate(action.profile.top if action.profile else None, line)
        if isinstance(action, MoveTo):
            if action.position is None:
                remedy = "write the command with a number"
                self.sheet.impossible(line, "the position is not known from the text", "a call needs a number", remedy)
                return
            if self.variable_sign:
                self.sheet.add(f"direction = -1 if {action.position} < grbl.position else 1", line)
            self.sheet.add(f"grbl.move_to({action.position}{self._axis(action)})", line)
        else:
            steps = str(action.steps) if action.steps is not None else self._product(action)
            self.sheet.add(f"grbl.move_by({steps}{self._axis(action)})", line)
        compare_times(self.sheet, action, self.acceleration, FROM_REST)

    def _product(self, action: MoveBy) -> str:
        distance = "distance" if action.distance is None else str(action.distance)
        if action.sign is None:
            return f"direction * {distance}"
        return distance if action.sign > 0 else f"-{distance}"

    def _search(self, action: RunEndless | Home) -> None:
        line = action.line
        if action.sign is None:
            remedy = "set the direction in the text"
            self.sheet.impossible(line, "the direction is not known from the text", "a call needs it", remedy)
            return
        self._set_rate(action.profile.top if action.profile else None, line)
        until = action.until if isinstance(action, RunEndless) else None
        code = ', code="G38.5"' if until and until.level else ""  # a probe is active low
        self.sheet.add(f"grbl.search({action.sign * FAR}{code}{self._axis(action)})", line)
        if isinstance(action, Home):
            self.sheet.add(f"grbl.set_position(0{self._axis(action)})", line)
        self.sheet.nearly(line, f"ends after {grouped(FAR)} steps at the latest; the switch goes to the probe, pin A5")

    def _output(self, action: SetOutput) -> None:
        if action.implied and action.number not in self.outputs:
            return
        if action.number not in OUTPUTS:
            limit = "two outputs: coolant (M8, M9) and spindle (M3, M5)"
            self.sheet.impossible(action.line, f"output {action.number}", limit, "LinuxCNC, or a sketch for an Arduino")
            return
        self.sheet.add(f'grbl.send("{OUTPUTS[action.number][1 - action.level]}")', action.line)
        self.sheet.same(action.line)

    def _is_input(self, pin: int, line: int) -> bool:
        if pin in PINS:
            return True
        limit = f"{len(PINS)} inputs: probe and limit switches"
        self.sheet.impossible(line, f"input {pin}", limit, "LinuxCNC, or a sketch for an Arduino")
        return False

    # -------------------------------------------------------------------------------------------------- the language
    def assign(self, name: str, value: int, source: int) -> None:
        self.sheet.add(f"{name} = {value}", source)

    def count(self, name: str, source: int) -> None:
        self.sheet.add(f"{name} += 1", source)

    def compare(self, name: str, sign: str, value: int) -> str:
        """Return a comparison."""
        return f"{name} {sign} {value}"

    def condition(self, inputs: Sequence[Input], source: int) -> str:
        """Return a condition."""
        known = [each for each in inputs if self._is_input(each.number, source)]
        return " and ".join(f"grbl.level({each.number}) == {each.level}" for each in known) or "False"

    def negated(self, condition: str) -> str:
        return f"not ({condition})" if " and " in condition else condition.replace("==", "!=")

    def repeat(self, passes: int, source: int) -> str:
        """Write a for loop."""
        self.sheet.add(f"for _ in range({passes}):", source)
        return ""

    def forever(self, source: int) -> str:
        """Write a loop without end."""
        return self.while_true("True", source)

    def while_true(self, condition: str, source: int) -> str:
        """Write a while loop."""
        self.sheet.add(f"while {condition}:", source)
        return ""

    def as_long_as(self, node: AsLongAs) -> None:
        """Write a loop that ends with a break."""
        self.sheet.add("while True:", node.head)
        self.inside(node.body, "", node.line)
        self.sheet.depth += 1
        self.sheet.add(f"if {self.negated(self.condition(node.inputs, node.line))}:", node.line)
        self.sheet.depth += 1
        self.sheet.add("break", node.line)
        self.sheet.depth -= 2

    def if_true(self, condition: str, source: int) -> tuple[str, str]:
        """Write if."""
        self.sheet.add(f"if {condition}:", source)
        return "else:", ""
