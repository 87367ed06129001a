"""A host script in Python, which sends each command to grbl, and performs loops, waits and branches itself.

G-code for grbl has none of these three.  Inputs are read from the pins whose levels grbl reports: the
probe and the limit switches, with hard limits ($21) and homing ($22) off.
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
    Program,
    RunEndless,
    SetOutput,
    SetPosition,
    SetProfile,
    WaitInput,
)
from ..program_facts import outputs
from ..target_writer import Target, WriterOptions, Written
from ..translation_report import OutLine
from .flow import AsLongAs
from .grbl_writer import (
    FROM_REST,
    LETTERS,
    OUTPUTS,
    PROBED,
    GrblWords,
    grbl_pins,
    has_output,
    judged,
    probing,
    rate_of,
)
from .host_frame import FRAME
from .source_sheet import FAR, PS, compare_times, number
from .structured import Structured

PINS = {1: ("P", "pin A5, probe"), 2: ("X", "pin D9, limit X"), 3: ("Y", "pin D10, limit Y")}
PINS |= {4: ("Z", "pin D12, limit Z")}


class ScriptWriter(Structured):
    """A writer of a host script for one program."""

    nothing = "pass"
    entry = "a function begins at its first line (Python)"
    more_axes = ("3 axes: X, Y, Z", "LinuxCNC")
    true = "True"

    def __init__(self, target: Target, program: Program, options: WriterOptions) -> None:
        super().__init__(target, program, options, "    ")
        self.first = self.first_axis(LETTERS)
        self.most_axes = len(LETTERS) - self.first
        self.words = GrblWords(options, self.first)

    def written(self) -> Written:
        spm, mm = number(self.options.steps_per_mm), number(self.acceleration / self.options.steps_per_mm)
        port = self.options.values.get("port", "/dev/ttyUSB0")
        frame = FRAME.format(letter=self.words.letter(1), spm=spm, digits=self.words.digits, port=port)
        host = self._function("main", -1)
        blocks = [line for block, name in self.names.items() for line in self._function(name, block)]
        out = [*(OutLine(line) for line in frame.splitlines()), *blocks, *host]
        out += [OutLine(""), OutLine(""), OutLine('if __name__ == "__main__":'), OutLine("    main(Grbl(PORT))")]
        assumed = (("$100, steps/mm", spm), ("$120, mm/s^2", mm), ("$21 and $22", "0: limit switches are inputs"))
        return self.finished(out, assumed)

    def _function(self, name: str, block: int) -> list[OutLine]:
        """Return a function of the script for a stored program, or for the host's commands if `block` is negative."""
        self.sheet.lines = []
        self.sheet.depth = 1
        self.known = dict(self.ran_with.get(block, {}))
        if block >= 0:
            self.program_tree(self.inner(block))
        else:
            self.sheet.add('grbl.send("G21 G90 G94")', 0, "mm, absolute, mm/min")
            for output, level in outputs(self.program):
                if output in OUTPUTS:
                    self.sheet.add(f'grbl.send("{OUTPUTS[output][1 - level]}")', 0, f"output {output} as after a reset")
            self.tree(self.program.block(block))
        self.sheet.depth = 0
        used = ["distance"] * self.variable_distance + ["direction"] * self.variable_sign
        inside = self.commented(block) or [OutLine("    pass")]
        if used:
            inside.insert(0, OutLine(f"    global {', '.join(used)}"))
        out = [OutLine(""), OutLine(""), OutLine(f"def {name}(grbl):"), *inside]
        return out if block >= 0 else [*self._variables(), *out]

    def _variables(self) -> list[OutLine]:
        found = []
        if self.variable_distance:
            found.append(OutLine("distance = 0", "of relative moves, steps"))
        if self.variable_sign:
            found.append(OutLine("direction = 1", "of relative moves"))
        return [OutLine(""), *found] if found else []

    def wires(self) -> list[tuple[str, str]]:
        names = grbl_pins(self.first)
        names += [(f"output{output}", pin) for output, (_, _, pin) in OUTPUTS.items()]
        return names + [(f"input{pin}", where) for pin, (_, where) in PINS.items()]

    # -------------------------------------------------------------------------------------------------------- actions
    def register(self, name: str, value: int, line: int) -> None:
        """Write the assignment of a number to a variable."""
        self.assign(name, value, line)

    def preset(self, action: SetPosition) -> None:
        self.sheet.add(f"grbl.set_position({action.position}{self._axis(action)})", action.line)

    def wait(self, action: WaitInput) -> None:
        if self._is_input(action.input.number, action.line):
            self.sheet.add(f"grbl.wait({action.input.number}, {action.input.level})", action.line)
            self.sheet.nearly(action.line, "the host polls grbl's inputs: about 10 ms later")

    def delay(self, action: Delay) -> None:
        self.sheet.add(f"time.sleep({number(action.time_ps / PS)})", action.line)
        self.sheet.nearly(action.line, "timed by the host: a few milliseconds longer")

    def leave(self, action: EndProgram) -> None:
        if action is not self.final:
            self.sheet.add("return", action.line)
        super().leave(action)

    def calls(self, name: str) -> str:
        """Return a call to a function of the script."""
        return f"{name}(grbl)"

    def _axis(self, action: Action) -> str:
        return "" if action.axis == 1 else f', axis="{self.words.letter(action.axis)}"'

    def _set_rate(self, rate: float | None, line: int) -> None:
        if rate is not None and rate != self.known.get("rate"):
            self.sheet.add(f"grbl.feed({number(rate, 3)})", line)
            self.known["rate"] = rate

    def profile(self, action: SetProfile) -> None:
        """Write the call that sets the rate of a profile, unless this rate is already set."""
        rate = rate_of(action)
        if action.sets != "ramp":
            self._set_rate(rate, action.line)
        judged(self, action, rate)

    def move(self, action: MoveBy | MoveTo) -> None:
        line = action.line
        self._set_rate(action.profile.top if action.profile else None, line)
        if isinstance(action, MoveTo):
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

    def search(self, action: RunEndless | Home, sign: int) -> None:
        """Write a call that makes the board perform a probing move."""
        line, code = action.line, probing(action)
        self._set_rate(action.profile.top if action.profile else None, line)
        word = "" if code == "G38.3" else f', code="{code}"'
        self.sheet.add(f"grbl.search({sign * FAR}{word}{self._axis(action)})", line)
        if isinstance(action, Home):
            self.sheet.add(f"grbl.set_position(0{self._axis(action)})", line)
        self.sheet.nearly(line, PROBED)

    def output(self, action: SetOutput) -> None:
        """Write the coolant or spindle command that sets an output."""
        if has_output(self, action):
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
        return f"{name} {sign} {value}"

    def condition(self, inputs: Sequence[Input], source: int) -> str:
        known = [each for each in inputs if self._is_input(each.number, source)]
        return " and ".join(f"grbl.level({each.number}) == {each.level}" for each in known) or "False"

    def negated(self, condition: str) -> str:
        return f"not ({condition})" if " and " in condition else condition.replace("==", "!=")

    def repeat(self, passes: int, source: int) -> str:
        """Write the head of a for loop; return its closing text, which is empty in Python."""
        self.sheet.add(f"for _ in range({passes}):", source)
        return ""

    def while_true(self, condition: str, source: int) -> str:
        """Write the head of a while loop; return its closing text, which is empty in Python."""
        self.sheet.add(f"while {condition}:", source)
        return ""

    def as_long_as(self, node: AsLongAs) -> None:
        """Write a loop that repeats its body as long as all inputs have their given levels.

        The loop is endless, and its body ends with a conditional break, so the body is executed at least once.
        """
        self.sheet.add("while True:", node.head)
        self.inside(node.body, "", node.line)
        self.sheet.depth += 1
        self.sheet.add(f"if {self.negated(self.condition(node.inputs, node.line))}:", node.line)
        self.sheet.depth += 1
        self.sheet.add("break", node.line)
        self.sheet.depth -= 2

    def if_true(self, condition: str, source: int) -> tuple[str, str]:
        """Write the head of an if statement; return the text for "else", and the closing text."""
        self.sheet.add(f"if {condition}:", source)
        return "else:", ""
