"""A sketch for an Arduino Uno, with the library AccelStepper or FastAccelStepper.

Stored programs become functions; the host's commands are in `setup()`.  Each move blocks until it has
ended, as in the source.  AccelStepper starts from standstill with a constant acceleration; a move
without a ramp runs at a constant rate.  `values["library"] = "fastaccelstepper"` selects
FastAccelStepper, which is faster but always uses ramps.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..meaning import (
    Action,
    Delay,
    EndProgram,
    Home,
    Input,
    MoveBy,
    MoveTo,
    Profile,
    Program,
    RunEndless,
    SetOutput,
    SetPosition,
    SetProfile,
    WaitInput,
)
from ..target_writer import Target, WriterOptions, Written
from ..translation_report import OutLine
from .flow import AsLongAs
from .libraries import ACCEL, FAST, chosen
from .sketch_pins import ABORT, HOME, INPUTS, SketchPins, level_name
from .source_sheet import PS, compare_times, number
from .structured import Structured


class SketchWriter(Structured):
    """A writer that writes one program as a sketch."""

    entry = "a function begins at its first line (C++)"
    keeps = "a sketch survives power-off"

    def __init__(self, target: Target, program: Program, options: WriterOptions) -> None:
        super().__init__(target, program, options)
        self.library = chosen(program, options)
        self.most_axes = len(self.library.step_pins)
        self.more_axes = (f"pins for {self.most_axes} motors ({self.library.title})", "a board with more pins")
        self.declared: set[str] = set()
        self.helpers: dict[str, None] = {}  # in the order of their use
        self.pins = SketchPins(program, self.library)
        self.axes = self.pins.axes

    def written(self) -> Written:
        setup = self._function("setup", list(self.program.block(-1)), -1)
        functions: list[OutLine] = []
        for block, name in self.names.items():
            functions += [*self._function(name, self.inner(block), block), OutLine("")]
        top = [*(OutLine(each) for each in self.library.includes), OutLine("")]
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
        return self.finished(out, (("library", self.library.title),))

    def wires(self) -> list[tuple[str, str]]:
        return self.pins.wires()

    def _function(self, name: str, actions: list[Action], block: int) -> list[OutLine]:
        """Return a function of the sketch for a stored program, or for the host's commands if `block` is negative.

        Args:
            name: the name of the function.
            actions: the actions of the stored program, or of the host.
            block: the number of the stored program, or -1.
        """
        self.sheet.lines = []
        self.known, self.declared = dict(self.ran_with.get(block, {})), set()
        self.sheet.depth = 1
        if block >= 0:
            self.program_tree(actions)
        else:
            self.tree(actions)
        self.sheet.depth = 0
        return [OutLine(f"void {name}() {{"), *self.commented(block), OutLine("}")]

    # -------------------------------------------------------------------------------------------------------- actions
    def register(self, name: str, value: int, line: int) -> None:
        """Write the assignment of a value to a global variable of the sketch, such as "distance"."""
        self.sheet.add(f"{name} = {value};", line)

    def preset(self, action: SetPosition) -> None:
        stepper = self.library.of(self.pins.stepper(action.axis))
        self.sheet.add(f"{stepper}setCurrentPosition({action.position});", action.line)

    def wait(self, action: WaitInput) -> None:
        if name := self._input(action.input.number, action.line):
            self.helpers["waitFor"] = None
            self.sheet.add(f"waitFor({name}, {level_name(action.input.level)});", action.line)
            self.sheet.same(action.line)

    def leave(self, action: EndProgram) -> None:
        if action is not self.final:
            self.sheet.add("return;", action.line)
        super().leave(action)

    def calls(self, name: str) -> str:
        """Return a call to the function of the sketch with the given name."""
        return f"{name}();"

    def profile(self, action: SetProfile) -> None:
        """Write the speed and the acceleration that a command sets, and the verdicts on its line."""
        sheet, profile, line = self.sheet, action.profile, action.line
        if profile is not None:
            self._prepare(action.axis, profile, line)
        elif action.sets == "top rate" and action.value is not None:
            sheet.add(self.library.speed(self.pins.stepper(action.axis), action.value), line)
            self.known.pop((action.axis, "speed"), None)
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
        """Write the speed and the acceleration of a profile, except values that the motor is known to have already."""
        stepper = self.pins.stepper(axis)
        if profile.top != self.known.get((axis, "speed")):
            self.sheet.add(self.library.speed(stepper, profile.top), line)
            self.known[axis, "speed"] = profile.top
        wanted = profile.acceleration if profile.ramped else self.library.without_ramp(profile)
        if wanted and wanted != self.known.get((axis, "acceleration")):
            self.sheet.add(self.library.acceleration(stepper, wanted), line)
            self.known[axis, "acceleration"] = wanted

    def move(self, action: MoveBy | MoveTo) -> None:
        sheet, line, profile = self.sheet, action.line, action.profile
        absolute = isinstance(action, MoveTo)
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
            sheet.nearly(line, "at a constant rate; a step may be a few microseconds late", off_ps=gap)
        elif evenly:
            sheet.nearly(line, "at a constant rate; a step may be a few microseconds late")
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

    def search(self, action: RunEndless | Home, sign: int) -> None:
        """Write a motion, in direction `sign`, that is ended by an input."""
        line = action.line
        if action.profile is not None:
            self._prepare(action.axis, action.profile, line)
        if isinstance(action, Home):
            name, level, description = (
                self.pins.pin("HOME_PIN", HOME),
                0,
                "until HOME_PIN is low, then the position is 0",
            )
        elif action.until is not None:
            name, level = self._input(action.until.number, line), action.until.level
            description = "decelerates when the input has its level"
        else:
            name, level, description = self.pins.pin("ABORT_PIN", ABORT), 0, "until ABORT_PIN is low; it decelerates"
        stepper = f"{self.pins.stepper(action.axis)}, " if len(self.axes) > 1 else ""
        helper = "runUntilOfAxis" if stepper else "runUntil"
        self.helpers[helper] = None
        self.sheet.add(f"{helper}({stepper}{sign}, {name}, {level_name(level)});", line)
        if isinstance(action, Home):
            self.sheet.add(f"{self.library.of(self.pins.stepper(action.axis))}setCurrentPosition(0);", line)
        self.sheet.nearly(line, description)

    def output(self, action: SetOutput) -> None:
        if action.number > len(self.library.outputs):
            limit = f"{len(self.library.outputs)} pins are free for outputs"
            self.sheet.impossible(action.line, f"output {action.number}", limit, "use a board with more pins")
            return
        name = self.pins.pin(f"OUTPUT{action.number}_PIN", self.library.outputs[action.number - 1])
        self.sheet.add(f"digitalWrite({name}, {level_name(action.level)});", action.line)
        self.sheet.same(action.line)

    def _input(self, pin: int, line: int) -> str:
        if pin > len(INPUTS):
            limit = f"{len(INPUTS)} pins are free for inputs"
            self.sheet.impossible(line, f"input {pin}", limit, "use a board with more pins")
            return f"INPUT{len(INPUTS)}_PIN"
        return self.pins.pin(f"INPUT{pin}_PIN", INPUTS[pin - 1])

    def delay(self, action: Delay) -> None:
        ms, us = divmod(round(action.time_ps / 1e6), 1000)
        if ms:
            self.sheet.add(f"delay({ms});", action.line)
        if us or not ms:
            self.sheet.add(f"delayMicroseconds({us});", action.line)
        self.sheet.same(action.line)

    # -------------------------------------------------------------------------------------------------- the language
    def assign(self, name: str, value: int, source: int) -> None:
        """Write the assignment of a value to a local variable; its first assignment in a function also declares it."""
        self.sheet.add(f"{'' if name in self.declared else 'int '}{name} = {value};", source)
        self.declared.add(name)

    def count(self, name: str, source: int) -> None:
        self.sheet.add(f"{name}++;", source)

    def compare(self, name: str, sign: str, value: int) -> str:
        return f"{name} {sign} {value}"

    def condition(self, inputs: Sequence[Input], source: int) -> str:
        return " && ".join(
            f"digitalRead({self._input(each.number, source)}) == {level_name(each.level)}" for each in inputs
        )

    def repeat(self, passes: int, source: int) -> str:
        """Write the head of a for loop with a number of passes; return the text that closes the loop."""
        name = f"pass{next(self.numbers)}"
        self.sheet.add(f"for (long {name} = 0; {name} < {passes}; {name}++) {{", source)
        return "}"

    def while_true(self, condition: str, source: int) -> str:
        """Write the head of a while loop with a condition; return the text that closes the loop."""
        self.sheet.add(f"while ({condition}) {{", source)
        return "}"

    def as_long_as(self, node: AsLongAs) -> None:
        """Write a do ... while loop that repeats as long as the inputs of `node` have their given levels."""
        self.sheet.add("do {", node.head)
        self.inside(node.body, "", node.line)
        self.sheet.add(f"}} while ({self.condition(node.inputs, node.line)});", node.line)

    def if_true(self, condition: str, source: int) -> tuple[str, str]:
        """Write the head of an if statement; return the text between its branches, and the text that closes it."""
        self.sheet.add(f"if ({condition}) {{", source)
        return "} else {", "}"
