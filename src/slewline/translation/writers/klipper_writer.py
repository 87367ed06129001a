"""A configuration for Klipper: a manual_stepper, and the program as macros.

Klipper evaluates the whole text of a macro before its first command runs, so a macro can repeat commands, but it
cannot wait.  A program is cut where it waits or branches: each piece is a macro that ends with M400, which waits for
all motion to end.  Then a delayed_gcode is evaluated, which reads the inputs (gcode_button) and continues with the
next piece.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..meaning import (
    Action,
    Delay,
    EndProgram,
    Home,
    Input,
    Jump,
    LeaveProgram,
    Motion,
    MoveBy,
    MoveTo,
    Profile,
    Program,
    RunEndless,
    RunProgram,
    SetOutput,
    SetPosition,
    SetProfile,
)
from ..program_facts import inputs, outputs, stored, top_rate
from ..target_writer import Target, WriterOptions, Written
from ..translation_report import OutLine
from .flow import Node, Repeat, structured
from .language_writer import LanguageWriter
from .pieces import Decision, Pieces, Portion
from .source_sheet import FAR, PS, compare_times, grouped, lines_of, number, with_comments

MAIN = "PROGRAM"
LATER = "decided when all motion has ended: about 20 ms later"
FROM_REST = "Klipper starts from standstill"
PINS = ("PA4", "PA5", "PA6", "PA7", "PB0", "PB1", "PB2", "PB3")


class KlipperWriter(LanguageWriter):
    """A writer of a Klipper configuration for one program."""

    needs = "MOVE needs a number"
    entry = "a macro begins at its first line"
    moves = "included in the moves"
    more_axes = ("one manual_stepper is written", "add another one by hand")

    def __init__(self, target: Target, program: Program, options: WriterOptions) -> None:
        super().__init__(target, program, options)
        self.inputs = inputs(program)
        self.variable_rates = any(isinstance(each, Motion) and each.profile is None for each in program.actions)
        self.kept = {"at": "0"} | ({"distance": "0"} if self.variable_distance else {})
        self.kept |= {"direction": "1"} if self.variable_sign else {}
        self.kept |= {"speed": "1", "accel": "0"} if self.variable_rates else {}
        self.searches = any(isinstance(each, RunEndless | Home) for each in program.actions)
        self.main = MAIN  # prefix of the name of a macro
        self._cut(program.block(-1))

    def _cut(self, tree: Sequence[Node]) -> None:
        """Cut a program into pieces, and give each piece the name of a macro."""
        self.pieces = Pieces(tree, self._inside, "" if self.main == MAIN else f"{self.main.lower()}_")
        self.macros = {name: f"{self.main}_{at}" if at else self.main for at, name in enumerate(self.pieces.pieces)}

    def _inside(self, action: RunProgram | LeaveProgram) -> Sequence[Node]:
        """Return the tree of the stored program that a command runs; empty if the command runs it from a label."""
        if isinstance(action, RunProgram) and action.at:
            description = f"the program runs from {action.at} on"
            self.sheet.impossible(action.line, description, self.entry, self.entry_remedy)
            return ()
        self.sheet.same(action.line, "the called program is written here")
        return structured(self.inner(self.runs[action.line]))

    def written(self) -> Written:
        out = self._written()
        for block in stored(self.program):
            if block not in self.runs.values():  # entered, but not run by the text
                self.main = f"STORED{block + 1}"
                self._cut(structured(self.inner(block)))
                out += self._written()
        for action in self.program.actions:
            if isinstance(action, EndProgram):
                self.sheet.same(action.line)
            elif isinstance(action, Jump) and not action.inputs:
                self.sheet.nearly(action.line, LATER)
        judged = {each.line for each in self.sheet.verdicts}
        for action in self.program.block(-1):
            if action.line not in judged:
                self.sheet.same(action.line, "never reached: the program before it has no end")
        out = [*self._configuration(), *out]
        for block in (-1, *stored(self.program)):
            out = with_comments(lines_of(self.program, block), out, self.target.comment)
        spm = number(self.options.steps_per_mm)
        assumed = (("steps per millimetre", spm), ("pins", "PA0 ...: replace with those of your board"))
        return self.finished(out, assumed)

    def _written(self) -> list[OutLine]:
        """Return the lines for all pieces and decisions of a program."""
        out: list[OutLine] = []
        for piece in self.pieces.pieces.values():
            out += [OutLine(""), *self._macro(piece)]
        for decision in self.pieces.decisions.values():
            out += [OutLine(""), *self._decided(decision)]
            if decision.line:
                self.sheet.nearly(decision.line, LATER)
        return out

    # ---------------------------------------------------------------------------------------------------- sections
    def _configuration(self) -> list[OutLine]:
        top = top_rate(self.program.actions) or 100.0
        spm = self.options.steps_per_mm
        rows = ["[manual_stepper axis]", "step_pin: PA0", "dir_pin: PA1", "enable_pin: !PA2", "microsteps: 1"]
        rows += [f"rotation_distance: {number(200 / spm)}", f"velocity: {number(top / spm)}", "accel: 0"]
        rows += ["endstop_pin: ^!PA3"] * self.searches
        pins = iter(PINS)
        for output, level in outputs(self.program):
            rows += ["", f"[output_pin output{output}]", f"pin: {next(pins)}", f"value: {level}"]
        for pin in self.inputs:
            rows += ["", f"[gcode_button input{pin}]", f"pin: ^{next(pins)}", "press_gcode:"]
        return [OutLine(row) for row in rows]

    def _macro(self, piece: Portion) -> list[OutLine]:
        """Return the lines of the macro for a piece."""
        name = self.macros[piece.name]
        self.sheet.lines, self.sheet.depth = [], 1
        state = ", ".join(f'{each}=printer["gcode_macro {self.main}"].{each}' for each in self.kept)
        self.sheet.add(f"{{% set ns = namespace({state}) %}}")
        if name == self.main:
            self.sheet.add(f"MANUAL_STEPPER STEPPER=axis ENABLE=1 SET_POSITION={{ns.at{self._per_mm()}}}")
        for node in piece.body:
            self._write(node)
        for each in self.kept:
            self.sheet.add(f"SET_GCODE_VARIABLE MACRO={self.main} VARIABLE={each} VALUE={{ns.{each}}}")
        after = piece.then
        if after in self.pieces.pieces and not self.pieces.returns(piece.name):
            self.sheet.add(self.macros[after])
        elif after:
            self.sheet.add("M400")
            self.sheet.add(f"UPDATE_DELAYED_GCODE ID={self._delayed(after)} DURATION=0.01")
        head = [OutLine(f"[gcode_macro {name}]")]
        if name == self.main:
            counters = {each.counter: "1" for each in self.pieces.decisions.values() if each.counter}
            head += [OutLine(f"variable_{each}: {value}") for each, value in (self.kept | counters).items()]
        found = [*head, OutLine("gcode:"), *self.sheet.lines]
        if after in self.pieces.pieces and self.pieces.returns(piece.name):
            again = [OutLine(""), OutLine(f"[delayed_gcode {self._delayed(after)}]"), OutLine("gcode:")]
            found += [*again, OutLine(f"  {self.macros[after]}")]
        return found

    def _delayed(self, name: str) -> str:
        return name if name in self.pieces.decisions else f"again_{self.macros[name].lower()}"

    def _to(self, name: str) -> str:
        """Return the command that continues with a given piece or decision."""
        if name in self.pieces.decisions:
            return f"UPDATE_DELAYED_GCODE ID={name} DURATION=0.01"
        return self.macros[name] if name else "M400"

    def _decided(self, decision: Decision) -> list[OutLine]:
        """Return the lines of the delayed_gcode that makes a decision."""
        variable = f"SET_GCODE_VARIABLE MACRO={self.main} VARIABLE={decision.counter} VALUE="
        counted = f'printer["gcode_macro {self.main}"].{decision.counter}'
        condition = self._condition(decision.inputs) if decision.inputs else f"{counted} < {decision.passes}"
        rows = [f"[delayed_gcode {decision.name}]", "gcode:", f"  {{% if {condition} %}}"]
        if decision.counter:
            rows.append(f"    {variable}{{{counted} + 1}}")
        rows += [f"    {self._to(decision.to)}", "  {% else %}"]
        if decision.counter:
            rows.append(f"    {variable}1")
        again = f"UPDATE_DELAYED_GCODE ID={decision.name} DURATION=0.02"
        rows += [f"    {again if decision.waits else self._to(decision.other)}", "  {% endif %}"]
        return [OutLine(row) for row in rows]

    def _condition(self, wanted: Sequence[Input]) -> str:
        names = {1: "PRESSED", 0: "RELEASED"}
        rows = [f'printer["gcode_button input{each.number}"].state == "{names[each.level]}"' for each in wanted]
        return " and ".join(rows)

    def wires(self) -> list[tuple[str, str]]:
        names = [("step", "step_pin"), ("direction", "dir_pin"), ("enable", "enable_pin")]
        names += [("abort", "endstop_pin"), ("home", "endstop_pin")]
        names += [(f"output{n}", f"[output_pin output{n}]") for n in self.outputs]
        return names + [(f"input{n}", f"[gcode_button input{n}]") for n in self.inputs]

    # -------------------------------------------------------------------------------------------------------- actions
    def _write(self, node: Node) -> None:
        """Write a node of a program tree; the node contains neither a wait nor a decision."""
        if isinstance(node, Repeat):
            self.sheet.add(f"{{% for _ in range({node.passes}) %}}", node.head)
            self.sheet.depth += 1
            self.registers.position = None
            for each in node.body:
                self._write(each)
            self.sheet.depth -= 1
            self.sheet.add("{% endfor %}", node.line)
            self.sheet.same(node.line)
            return
        assert isinstance(node, Action)  # noqa: S101
        self.action(node)
        self.registers.note(node)

    def register(self, name: str, value: int, line: int) -> None:
        """Write the assignment of a number to a variable."""
        self.sheet.add(f"{{% set ns.{name} = {value} %}}", line)

    def preset(self, action: SetPosition) -> None:
        self.register("at", action.position, action.line)
        self.sheet.add(f"MANUAL_STEPPER STEPPER=axis SET_POSITION={{ns.at{self._per_mm()}}}", action.line)

    def output(self, action: SetOutput) -> None:
        """Write SET_PIN for an output."""
        self.sheet.add(f"SET_PIN PIN=output{action.number} VALUE={action.level}", action.line)
        self.sheet.same(action.line)

    def delay(self, action: Delay) -> None:
        """Write a dwell."""
        self.sheet.add(f"G4 P{number(action.time_ps * 1000 / PS, 3)}", action.line)
        self.sheet.same(action.line)

    def _per_mm(self) -> str:
        return "" if self.options.steps_per_mm == 1 else f" / {number(self.options.steps_per_mm)}"

    def _mm(self, value: float) -> str:
        return number(value / self.options.steps_per_mm, 4)

    def profile(self, action: SetProfile) -> None:
        """Write the assignments of rate and acceleration to variables, if any move reads them from variables."""
        if self.variable_rates and action.profile is not None:
            ramp = action.profile.acceleration if action.profile.ramped else 0.0
            self.sheet.add(f"{{% set ns.speed = {self._mm(action.profile.top)} %}}", action.line)
            self.sheet.add(f"{{% set ns.accel = {self._mm(ramp)} %}}", action.line)
        if action.sets == "start rate" and action.profile is not None and action.profile.ramped:
            self.sheet.nearly(action.line, f"no start rate: {FROM_REST}")
        elif action.sets == "ramp" and action.profile is not None and action.profile.ramped:
            mm = self._mm(action.profile.acceleration)
            self.sheet.nearly(action.line, f"a constant acceleration, {mm} mm/s^2: the mean of the ramp")
        else:
            self.sheet.same(action.line, "included in the moves")

    def _rates(self, profile: Profile | None) -> str:
        """Return the SPEED and ACCEL words of a move; without a ramp, ACCEL=0, which turns acceleration off.

        If the profile is None, the words read the rate and the acceleration from variables.
        """
        if profile is None:
            return " SPEED={ns.speed} ACCEL={ns.accel}"
        acceleration = profile.acceleration if profile.ramped else 0.0
        return f" SPEED={self._mm(profile.top)} ACCEL={self._mm(acceleration)}"

    def move(self, action: MoveBy | MoveTo) -> None:
        line, profile = action.line, action.profile
        if isinstance(action, MoveTo):
            if self.variable_sign:
                self.sheet.add(f"{{% set ns.direction = -1 if {action.position} < ns.at else 1 %}}", line)
            self.sheet.add(f"{{% set ns.at = {action.position} %}}", line)
        elif action.steps is not None:
            sign = "+" if action.steps >= 0 else "-"
            self.sheet.add(f"{{% set ns.at = ns.at {sign} {abs(action.steps)} %}}", line)
        else:
            direction = "ns.direction" if action.sign is None else str(action.sign)
            distance = "ns.distance" if action.distance is None else str(action.distance)
            self.sheet.add(f"{{% set ns.at = ns.at + {direction} * {distance} %}}", line)
        self.sheet.add(f"MANUAL_STEPPER STEPPER=axis MOVE={{ns.at{self._per_mm()}}}{self._rates(profile)}", line)
        acceleration = 0.0 if profile is None or not profile.ramped else profile.acceleration
        compare_times(self.sheet, action, acceleration, FROM_REST)

    def sign_of(self, action: RunEndless | Home) -> int | None:
        return self.registers.sign if action.sign is None else action.sign

    def search(self, action: RunEndless | Home, sign: int) -> None:
        """Write a move that is ended by an endstop."""
        line = action.line
        until = action.until if isinstance(action, RunEndless) else None
        kind = "try_inverted_probe" if until and until.level else "try_probe"
        words = f"MOVE={self._mm(sign * FAR)} STOP_ON_ENDSTOP={kind}{self._rates(action.profile)}"
        self.sheet.add(f"MANUAL_STEPPER STEPPER=axis {words}", line)
        if isinstance(action, Home):
            self.sheet.add("{% set ns.at = 0 %}", line)
            self.sheet.add("MANUAL_STEPPER STEPPER=axis SET_POSITION=0", line)
            self.sheet.nearly(line, f"ends after {grouped(FAR)} steps at the latest; the switch is the endstop_pin")
            return
        description = (
            f"ends at position {grouped(FAR)} at the latest; a relative move after it is counted from the start of "
            "this one"
        )
        self.sheet.nearly(line, description)
