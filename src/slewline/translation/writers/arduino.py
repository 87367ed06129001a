"""A sketch for an Arduino Uno, with the library AccelStepper or FastAccelStepper.

Stored programs become functions, what the host sends is in `setup()`.  Each move blocks until it has ended, as at the
source.  AccelStepper begins at standstill and has a constant acceleration; a move without a ramp runs at an even rate.
`values["library"] = "fastaccelstepper"` takes the other library: faster, and with ramps alone.
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
from .flow import AsLongAs, Node
from .libraries import ACCEL, FAST, chosen
from .sketch_pins import ABORT, HOME, INPUTS, SketchPins, level_name
from .source_sheet import (
    PS,
    compare_times,
    heading,
    number,
    outputs,
    runs,
    stored,
    unspoken,
    variables,
)
from .structured import Structured

_Set = dict[int, tuple[float | None, float | None]]


class Arduino(Target):
    """A sketch for an Arduino."""

    name = "arduino"
    title = "Sketch for an Arduino Uno"
    suffix = ".ino"
    language = "Arduino Uno with AccelStepper 1.64 or FastAccelStepper"

    def comment(self, text: str) -> str:
        """Return a comment as a line of its own."""
        return f"// {text}" if text else ""

    def write(self, program: Program, options: WriterOptions) -> Written:
        """Return the sketch."""
        return _SketchWriter(self, program, options).written()

    def read_back(self, text: str, options: WriterOptions) -> PlayedTrace | None:
        """Return what the sketch does, by a small interpreter of its C++."""
        from ..reading_back.sketch import read

        return read(text, options)


class _SketchWriter(Structured):
    """A writer at work on one program."""

    def __init__(self, target: Target, program: Program, options: WriterOptions) -> None:
        super().__init__(target, program, options)
        self.library = chosen(program, options)
        self.ran_with: dict[int, _Set] = {}  # speeds where the host runs a stored program
        self.variable_distance, self.variable_sign = variables(program.actions)
        self.names = {each: "program" if each == 0 else f"program{each + 1}" for each in stored(program)}
        self.runs = runs(program)
        self.outputs = {output for output, _ in outputs(program)}
        self.set: _Set = {}  # of an axis: speed and acceleration, if known
        self.declared: set[str] = set()
        self.helpers: dict[str, None] = {}  # in the order of their use
        self.pins = SketchPins(program, self.library)
        self.axes = self.pins.axes

    def written(self) -> Written:
        """Return the result."""
        setup = self._function("setup", list(self.program.block(-1)), -1)
        functions: list[OutLine] = []
        for block, name in self.names.items():
            functions += [*self._function(name, self._block(block), block), OutLine("")]
        top = [*heading(self.program), *(OutLine(each) for each in self.library.includes), OutLine("")]
        top += [*self.pins.declarations(), OutLine(""), *self.pins.steppers(), OutLine("")]
        if self.variable_distance:
            top.append(OutLine("long distance = 0;", "of relative moves"))
        if self.variable_sign:
            top.append(OutLine("int direction = 1;", "of relative moves"))
        for helper in self.helpers:
            top += [OutLine(line) for line in self.library.helper(helper).splitlines()] + [OutLine("")]
        out = [
            *top,
            *functions,
            OutLine("void setup() {"),
            *self.pins.prepared(),
            *setup[1:],
            OutLine(""),
            OutLine("void loop() {"),
            OutLine("}"),
        ]
        return Written(tuple(out), tuple(self.sheet.verdicts), self.pins.wiring(), (("library", self.library.title),))

    def _block(self, block: int) -> list[Action]:
        return [each for each in self.program.block(block) if not isinstance(each, EnterProgram | LeaveProgram)]

    def _function(self, name: str, actions: list[Action], block: int) -> list[OutLine]:
        """Return a function with what the part or its host does."""
        self.sheet.lines = []
        self.set, self.declared = dict(self.ran_with.get(block, {})), set()
        self.sheet.depth = 1
        if block >= 0:
            self.program_tree(actions)
        else:
            self.tree(actions)
        self.sheet.depth = 0
        return [OutLine(f"void {name}() {{"), *self.commented(block), OutLine("}")]

    # -------------------------------------------------------------------------------------------------------- actions
    def action(self, action: Action) -> None:
        sheet, line = self.sheet, action.line
        match action:
            case SetProfile():
                self._profile(action)
            case SetDistance():
                if self.variable_distance:
                    sheet.add(f"distance = {action.steps};", line)
                sheet.same(line)
            case SetDirection():
                if self.variable_sign:
                    sheet.add(f"direction = {action.sign};", line)
                sheet.same(line)
            case SetPosition():
                sheet.add(
                    f"{self.library.of(self.pins.stepper(action.axis))}setCurrentPosition({action.position});", line
                )
                sheet.same(line)
            case MoveBy() | MoveTo():
                self._move(action)
            case RunEndless() | Home():
                self._search(action)
            case SetOutput():
                self._output(action)
            case WaitInput():
                if name := self._input(action.input.number, line):
                    self.helpers["waitFor"] = None
                    sheet.add(f"waitFor({name}, {level_name(action.input.level)});", line)
                    sheet.same(line)
            case Delay():
                self._delay(action)
            case EndProgram():
                if action is not self.final:
                    sheet.add("return;", line)
                sheet.same(line)
            case LeaveProgram() | RunProgram():
                self._run(action)
            case _:
                unspoken(sheet, action, "a sketch is kept without power")

    def _run(self, action: LeaveProgram | RunProgram) -> None:
        if isinstance(action, LeaveProgram) and not action.runs:
            return
        if isinstance(action, RunProgram) and action.at:
            limit = "a function begins at its first line (C++)"
            self.sheet.impossible(
                action.line, f"the program runs from {action.at} on", limit, "split the program there"
            )
            return
        block = self.runs[action.line]
        self.sheet.add(f"{self.names.get(block, 'program')}();", action.line)
        self.sheet.same(action.line)
        self.ran_with[block] = dict(self.set) if self.ran_with.get(block, self.set) == self.set else {}
        self.set = {}

    def forget(self, tree: Sequence[Node]) -> None:
        """Forget speeds as well, where more than one path may lead."""
        before = self.registers.profile
        super().forget(tree)
        if before is not None and self.registers.profile is None:
            self.set = {}

    def _profile(self, action: SetProfile) -> None:
        sheet, profile, line = self.sheet, action.profile, action.line
        if profile is not None:
            self._prepare(action.axis, profile, line)
        elif action.sets == "top rate" and action.value is not None:
            sheet.add(self.library.speed(self.pins.stepper(action.axis), action.value), line)
            self.set.pop(action.axis, None)
        if action.sets == "start rate" and profile is not None and profile.ramped:
            sheet.nearly(line, f"no start rate: {self.library.rest}")
        elif action.sets == "ramp" and profile is not None and profile.ramped:
            sheet.nearly(
                line, f"a constant acceleration of {number(profile.acceleration, 0)} steps/s^2: the mean of the ramp"
            )
        else:
            sheet.same(line)
        top = profile.top if profile else action.value if action.sets == "top rate" else None
        if top is not None and top > self.library.fastest and action.sets == "top rate":
            limit = f"about {self.library.fastest:,} steps/s on an Uno ({self.library.source})"
            sheet.impossible(line, f"{number(top, 0)} steps/s", limit, self.library.faster)

    def _prepare(self, axis: int, profile: Profile, line: int) -> None:
        """Write the speed and the acceleration of a profile, unless they were written last."""
        speed, acceleration = self.set.get(axis, (None, None))
        stepper = self.pins.stepper(axis)
        if profile.top != speed:
            self.sheet.add(self.library.speed(stepper, profile.top), line)
        wanted = profile.acceleration if profile.ramped else self.library.without_ramp(profile)
        if wanted and wanted != acceleration:
            self.sheet.add(self.library.acceleration(stepper, wanted), line)
        self.set[axis] = (profile.top, wanted or acceleration)

    def _move(self, action: MoveBy | MoveTo) -> None:
        sheet, line, profile = self.sheet, action.line, action.profile
        absolute = isinstance(action, MoveTo)
        if isinstance(action, MoveTo) and action.position is None:
            remedy = "write the command with a number"
            sheet.impossible(line, "the position is not known from the text", "a call needs a number", remedy)
            return
        if profile is not None:
            self._prepare(action.axis, profile, line)
        value = str(action.position) if isinstance(action, MoveTo) else self._steps(action)
        stepper = "" if len(self.axes) == 1 else f"{self.pins.stepper(action.axis)}, "
        if absolute and self.variable_sign:
            here = f"{self.library.of(self.pins.stepper(action.axis))}getCurrentPosition()"
            here = here if self.library is FAST else here.replace("getCurrent", "current")
            sheet.add(f"direction = {value} < {here} ? -1 : 1;", line)
        evenly = profile is not None and not profile.ramped and self.library is ACCEL
        helper = ("moveTo" if absolute else "moveBy") + ("Evenly" if evenly else "")
        if stepper:
            helper += "OfAxis"
        self.helpers[helper] = None
        rate = f", {number(profile.top, 3)}" if evenly and profile else ""
        sheet.add(f"{helper}({stepper}{value}{rate});", line)
        if evenly and profile and action.steps:
            gap = round(PS / profile.top)
            sheet.nearly(line, "at an even rate; a step may be some microseconds late", off_ps=gap)
        elif evenly:
            sheet.nearly(line, "at an even rate; a step may be some microseconds late")
        else:
            acceleration = profile.acceleration if profile and profile.ramped else profile.top**2 if profile else 0.0
            compare_times(sheet, action, acceleration, self.library.rest)

    def _steps(self, action: MoveBy) -> str:
        if action.steps is not None:
            return str(action.steps)
        distance = "distance" if action.distance is None else str(action.distance)
        if action.sign is None:
            return f"direction * {distance}"
        return distance if action.sign > 0 else f"-{distance}"

    def _search(self, action: RunEndless | Home) -> None:
        sign, line = action.sign, action.line
        if sign is None:
            remedy = "set the direction in the text"
            self.sheet.impossible(line, "the direction is not known from the text", "a call needs it", remedy)
            return
        if action.profile is not None:
            self._prepare(action.axis, action.profile, line)
        if isinstance(action, Home):
            name, level, says = self.pins.pin("HOME_PIN", HOME), 0, "until HOME_PIN is low, then the position is 0"
        elif action.until is not None:
            name, level = self._input(action.until.number, line), action.until.level
            says = "decelerates when the input has its level"
        else:
            name, level, says = self.pins.pin("ABORT_PIN", ABORT), 0, "until ABORT_PIN is low; it decelerates"
        stepper = f"{self.pins.stepper(action.axis)}, " if len(self.axes) > 1 else ""
        helper = "runUntilOfAxis" if stepper else "runUntil"
        self.helpers[helper] = None
        self.sheet.add(f"{helper}({stepper}{sign}, {name}, {level_name(level)});", line)
        if isinstance(action, Home):
            self.sheet.add(f"{self.library.of(self.pins.stepper(action.axis))}setCurrentPosition(0);", line)
        self.sheet.nearly(line, says)

    def _output(self, action: SetOutput) -> None:
        if action.implied and action.number not in self.outputs:
            return
        if action.number > len(self.library.outputs):
            limit = f"{len(self.library.outputs)} pins are free for outputs"
            self.sheet.impossible(action.line, f"output {action.number}", limit, "a board with more pins: add a pin")
            return
        name = self.pins.pin(f"OUTPUT{action.number}_PIN", self.library.outputs[action.number - 1])
        self.sheet.add(f"digitalWrite({name}, {level_name(action.level)});", action.line)
        self.sheet.same(action.line)

    def _input(self, pin: int, line: int) -> str:
        if pin > len(INPUTS):
            limit = f"{len(INPUTS)} pins are free for inputs"
            self.sheet.impossible(line, f"input {pin}", limit, "a board with more pins: add a pin")
            return f"INPUT{len(INPUTS)}_PIN"
        return self.pins.pin(f"INPUT{pin}_PIN", INPUTS[pin - 1])

    def _delay(self, action: Delay) -> None:
        ms, us = divmod(round(action.time_ps / 1e6), 1000)
        if ms:
            self.sheet.add(f"delay({ms});", action.line)
        if us or not ms:
            self.sheet.add(f"delayMicroseconds({us});", action.line)
        self.sheet.same(action.line)

    # -------------------------------------------------------------------------------------------------- the language
    def assign(self, name: str, value: int, source: int) -> None:
        """Write that a variable becomes a number; the first time, declare it."""
        self.sheet.add(f"{'' if name in self.declared else 'int '}{name} = {value};", source)
        self.declared.add(name)

    def count(self, name: str, source: int) -> None:
        self.sheet.add(f"{name}++;", source)

    def compare(self, name: str, sign: str, value: int) -> str:
        """Return a comparison."""
        return f"{name} {sign} {value}"

    def condition(self, inputs: Sequence[Input], source: int) -> str:
        """Return a condition."""
        return " && ".join(
            f"digitalRead({self._input(each.number, source)}) == {level_name(each.level)}" for each in inputs
        )

    def repeat(self, passes: int, source: int) -> str:
        """Write a for loop."""
        name = f"pass{next(self.numbers)}"
        self.sheet.add(f"for (long {name} = 0; {name} < {passes}; {name}++) {{", source)
        return "}"

    def forever(self, source: int) -> str:
        """Write a loop without end."""
        return self.while_true("true", source)

    def while_true(self, condition: str, source: int) -> str:
        """Write a while loop."""
        self.sheet.add(f"while ({condition}) {{", source)
        return "}"

    def as_long_as(self, node: AsLongAs) -> None:
        """Write do ... while."""
        self.sheet.add("do {", node.head)
        self.inside(node.body, "", node.line)
        self.sheet.add(f"}} while ({self.condition(node.inputs, node.line)});", node.line)

    def if_true(self, condition: str, source: int) -> tuple[str, str]:
        """Write if."""
        self.sheet.add(f"if ({condition}) {{", source)
        return "} else {", "}"
