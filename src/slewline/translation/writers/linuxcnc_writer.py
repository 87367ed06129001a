"""G-code for LinuxCNC: loops and branches are O-words, outputs M64 and M65, inputs M66.

Each move is `G91 G1` or `G90 G1` with the feed set by `F`, in exact stop mode (G61.1): a move ends
before the next line begins, as in the source.  Jumps that form neither a loop nor a branch become a
loop over `#<_state>`.  Ramps are those of the machine: from standstill, with MAX_ACCELERATION of the
INI file.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..meaning import (
    Delay,
    EndProgram,
    EnterProgram,
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
from ..program_facts import outputs, top_rate
from ..target_writer import Target, WriterOptions, Written
from ..translation_report import OutLine
from .flow import AsLongAs
from .grbl_writer import rate_of
from .source_sheet import FAR, PS, compare_times, digits_for, grouped, number
from .structured import Structured

LETTERS = "XYZABCUVW"
INPUTS = OUTPUTS = 4  # pins of each kind, unless motmod is loaded with another num_dio
HOMED = f"searches {grouped(FAR)} steps at most, for the switch on motion.probe-input"
PROBED = f"ends after {grouped(FAR)} steps at the latest; the input that ends it goes to motion.probe-input"
FROM_REST = "LinuxCNC starts from standstill, with MAX_ACCELERATION"


class LinuxCncWriter(Structured):
    """A writer of LinuxCNC G-code for one program."""

    needs = "a word needs a number"
    entry = "a subroutine begins at its first line (O-codes, sub)"
    more_axes = ("9 axes: X to W", "a machine of its own for the others")
    true = "1"

    def __init__(self, target: Target, program: Program, options: WriterOptions) -> None:
        super().__init__(target, program, options)
        self.first = self.first_axis(LETTERS)
        self.most_axes = len(LETTERS) - self.first
        self.digits = digits_for(options.steps_per_mm)

    def written(self) -> Written:
        host = self._host()
        begins = "G21 G90 G94 G61.1"
        spm = number(self.options.steps_per_mm)
        speed = number(top_rate(self.program.actions) / self.options.steps_per_mm, 3)
        acceleration = number(self.acceleration / self.options.steps_per_mm, 3)
        ini = f"SCALE = {spm}, MAX_VELOCITY = {speed} or more, MAX_ACCELERATION = {acceleration}"
        out = [OutLine("", f"INI file, settings of the joint: {ini}")]
        out.append(OutLine(begins, "mm, absolute, mm/min, exact stop: each move ends before the next begins"))
        for output, level in outputs(self.program):
            if output <= OUTPUTS:
                description = f"level of output {output} at the start"
                out.append(OutLine(f"M{64 if level else 65} P{output - 1}", description))
        for block in self.names:
            out += self._block(block)
        if self.variable_distance:
            out.append(OutLine("#<_steps> = 0"))
        if self.variable_sign:
            out.append(OutLine("#<_direction> = 1"))
        out += host
        out.append(OutLine("M2"))
        assumed = (
            ("steps per millimetre (SCALE)", spm),
            ("MAX_ACCELERATION, mm/s^2", acceleration),
            ("MAX_VELOCITY, mm/s", f"{speed} or more"),
        )
        return self.finished(out, assumed)

    def _block(self, block: int) -> list[OutLine]:
        """Return a stored program as a subroutine."""
        self.sheet.lines = []
        self.known = dict(self.ran_with.get(block, {}))
        name = self.names[block]
        actions = self.inner(block)
        first = next(
            (each.line for each in self.program.actions if isinstance(each, EnterProgram) and each.number == block), 0
        )
        self.sheet.add(f"o<{name}> sub", first)
        self.sheet.depth += 1
        self.program_tree(actions)
        self.sheet.depth -= 1
        self.sheet.add(f"o<{name}> endsub", actions[-1].line if actions else first)
        return self.commented(block)

    def _host(self) -> list[OutLine]:
        self.sheet.lines, self.known = [], {}
        self.tree(self.program.block(-1))
        return self.commented(-1)

    def wires(self) -> list[tuple[str, str]]:
        names = [("step", "joint 0, step"), ("direction", "joint 0, direction"), ("abort", "motion.probe-input")]
        names += [(f"output{at + 1}", f"motion.digital-out-{at:02}") for at in range(OUTPUTS)]
        return names + [(f"input{at + 1}", f"motion.digital-in-{at:02}") for at in range(INPUTS)]

    # -------------------------------------------------------------------------------------------------------- actions
    def register(self, name: str, value: int, line: int) -> None:
        self.assign({"distance": "steps"}.get(name, name), value, line)

    def preset(self, action: SetPosition) -> None:
        """Write G92, which assigns a value to the current position."""
        self.sheet.add(f"G92 {self._word(action.axis, action.position)}", action.line)

    def delay(self, action: Delay) -> None:
        """Write a dwell."""
        self.sheet.add(f"G4 P{number(action.time_ps / PS)}", action.line)
        self.sheet.same(action.line)

    def calls(self, name: str) -> str:
        """Return a call to a subroutine."""
        return f"o<{name}> call"

    def leave(self, action: EndProgram) -> None:
        """Write the return from a subroutine, except at its last line, where the subroutine ends anyway."""
        name = self.names.get(action.block)
        if name and action is not self.final:
            self.sheet.add(f"o<{name}> return", action.line)
        super().leave(action)

    def _letter(self, axis: int) -> str:
        return LETTERS[self.first + axis - 1]

    def _word(self, axis: int, steps: int) -> str:
        return f"{self._letter(axis)}{number(steps / self.options.steps_per_mm, self.digits)}"

    def _f(self, rate: float) -> str:
        return f"F{number(rate * 60 / self.options.steps_per_mm, 3)}"

    def profile(self, action: SetProfile) -> None:
        """Write the F word for the rate of a profile."""
        rate = rate_of(action)
        if rate is not None and rate != self.known.get("feed") and action.sets != "ramp":
            self.sheet.add(self._f(rate), action.line)
            self.known["feed"] = rate
        if action.sets == "top rate":
            self.sheet.same(action.line)
        elif action.sets == "start rate":
            self.sheet.nearly(action.line, "no start rate: " + FROM_REST)
        else:
            mm = number(self.acceleration / self.options.steps_per_mm, 1)
            self.sheet.nearly(action.line, f"the ramp is that of the machine: MAX_ACCELERATION = {mm} mm/s^2")

    def _feed(self, profile: Profile | None) -> str:
        """Return the F word for a move, preceded by a space; empty if F already has this value."""
        if profile is None or profile.top == self.known.get("feed"):
            return ""
        self.known["feed"] = profile.top
        return f" {self._f(profile.top)}"

    def move(self, action: MoveBy | MoveTo) -> None:
        feed = self._feed(action.profile)
        if isinstance(action, MoveTo):
            position = action.position or 0
            if self.variable_sign:  # a comparison is 1 or 0
                ahead = f"[#5420 GT {number(position / self.options.steps_per_mm, self.digits)}]"
                self.sheet.add(f"#<_direction> = [1 - 2 * {ahead}]", action.line)
            self.sheet.add(f"G90 G1 {self._word(action.axis, position)}{feed}", action.line)
        elif action.steps is not None:
            self.sheet.add(f"G91 G1 {self._word(action.axis, action.steps)}{feed}", action.line)
        else:
            self.sheet.add(f"G91 G1 {self._letter(action.axis)}[{self._product(action)}]{feed}", action.line)
        compare_times(self.sheet, action, self.acceleration, FROM_REST)

    def _product(self, action: MoveBy) -> str:
        """Return an expression for the distance of a move, mm; factors not known here are read from parameters."""
        factors = []
        factors.append("#<_direction>" if action.sign is None else number(action.sign))
        factors.append("#<_steps>" if action.distance is None else number(action.distance))
        spm = self.options.steps_per_mm
        return " * ".join(factors) + (f" / {number(spm)}" if spm != 1 else "")

    def search(self, action: RunEndless | Home, sign: int) -> None:
        """Write a probing move."""
        until = action.until if isinstance(action, RunEndless) else None
        code = "G38.5" if until and until.level == 0 else "G38.3"
        steps = self._word(action.axis, sign * FAR)
        self.sheet.add(f"G91 {code} {steps}{self._feed(action.profile)}", action.line)
        if isinstance(action, Home):
            self.sheet.add(f"G92 {self._letter(action.axis)}0", action.line)
            self.sheet.nearly(action.line, HOMED)
        else:
            self.sheet.nearly(action.line, PROBED)

    def output(self, action: SetOutput) -> None:
        """Write M64 or M65, which switches an output on or off."""
        if action.number > OUTPUTS:
            limit = f"{OUTPUTS} digital outputs (M62 to M65)"
            self.sheet.impossible(action.line, f"output {action.number}", limit, "load motmod with a larger num_dio")
            return
        self.sheet.add(f"M{64 if action.level else 65} P{action.number - 1}", action.line)
        self.sheet.same(action.line)

    def wait(self, action: WaitInput) -> None:
        """Write a wait for an input: M66 in a loop."""
        pin, level = action.input.number, action.input.level
        if not self._is_input(pin, action.line):
            return
        loop = self._o()
        self.sheet.add(f"o{loop} do", action.line)
        self.sheet.depth += 1
        self.sheet.add(f"M66 P{pin - 1} L{3 if level else 4} Q60", action.line)
        self.sheet.depth -= 1
        self.sheet.add(f"o{loop} while [#5399 EQ -1]", action.line)
        self.sheet.same(action.line, "waits without end: after each minute it waits again")

    def _is_input(self, pin: int, line: int) -> bool:
        if pin <= INPUTS:
            return True
        limit = f"{INPUTS} digital inputs (M66)"
        self.sheet.impossible(line, f"input {pin}", limit, "load motmod with a larger num_dio")
        return False

    # -------------------------------------------------------------------------------------------------- the language
    def _o(self) -> int:
        return 100 + next(self.numbers)

    def assign(self, name: str, value: int, source: int) -> None:
        self.sheet.add(f"#<_{name}> = {value}", source)

    def count(self, name: str, source: int) -> None:
        self.sheet.add(f"#<_{name}> = [#<_{name}> + 1]", source)

    def compare(self, name: str, sign: str, value: int) -> str:
        return f"#<_{name}> {({'==': 'EQ', '>=': 'GE', '<': 'LT'})[sign]} {value}"

    def condition(self, inputs: Sequence[Input], source: int) -> str:
        """Write an M66 to read each input; return the condition that all inputs have their given levels."""
        if len(inputs) == 1:
            self._is_input(inputs[0].number, source)
            self.sheet.add(f"M66 P{inputs[0].number - 1} L0", source)
            return f"#5399 EQ {inputs[0].level}"
        for each in inputs:
            self._is_input(each.number, source)
            self.sheet.add(f"M66 P{each.number - 1} L0", source)
            self.sheet.add(f"#<_input{each.number}> = #5399", source)
        return " AND ".join(f"[#<_input{each.number}> EQ {each.level}]" for each in inputs)

    def negated(self, condition: str) -> str:
        if condition.startswith("#5399 EQ"):
            return condition.replace("EQ", "NE")
        return f"[{condition}] EQ 0"

    def repeat(self, passes: int, source: int) -> str:
        """Write the O-word that begins a repeat loop; return the O-word that ends it."""
        loop = self._o()
        self.sheet.add(f"o{loop} repeat [{passes}]", source)
        return f"o{loop} endrepeat"

    def while_true(self, condition: str, source: int) -> str:
        """Write the O-word that begins a while loop; return the O-word that ends it."""
        loop = self._o()
        self.sheet.add(f"o{loop} while [{condition}]", source)
        return f"o{loop} endwhile"

    def as_long_as(self, node: AsLongAs) -> None:
        """Write the O-words of a do ... while loop."""
        loop = self._o()
        self.sheet.add(f"o{loop} do", node.head)
        self.sheet.depth += 1
        self.forget(node.body)
        self.tree(node.body)
        condition = self.condition(node.inputs, node.line)
        self.sheet.depth -= 1
        self.sheet.add(f"o{loop} while [{condition}]", node.line)
        self.forget(node.body)

    def if_true(self, condition: str, source: int) -> tuple[str, str]:
        """Write the O-word that begins an if branch; return the O-words for "else" and for the end of the branch."""
        branch = self._o()
        self.sheet.add(f"o{branch} if [{condition}]", source)
        return f"o{branch} else", f"o{branch} endif"
