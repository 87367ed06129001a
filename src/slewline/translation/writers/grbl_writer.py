"""G-code for grbl 1.1, which has no loops, no conditions and no inputs: loops are unrolled.

Each move ends before the next line begins: `G4 P0` between two moves lets grbl stop; otherwise it would blend them.
A wait for an input becomes `M0`: a person must continue the program.  A host script waits by itself (host_script.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ...errors import UsageError
from ..meaning import (
    Delay,
    EndProgram,
    Home,
    Label,
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
from ..program_facts import outputs, stored, top_rate
from ..target_writer import Target, WriterOptions, Written
from ..translation_report import OutLine
from .flow import AsLongAs, Forever, Fork, Node, Repeat, Stages, structured
from .language_writer import LanguageWriter
from .source_sheet import FAR, PS, compare_times, digits_for, grouped, number, seconds

LETTERS = "XYZ"
FASTEST = 30_000  # steps/s, according to the grbl README
DWELL_PS = 50 * 10**9  # a dwell is a multiple of 50 ms: DWELL_TIME_STEP, grbl source
FROM_REST = "grbl starts from standstill, with $120"
HOST = "use --to python, which writes a host script that sends grbl each command"
PROBED = f"ends after {grouped(FAR)} steps at the latest; the switch goes to the probe, pin A5"
OUTPUTS = {1: ("M8", "M9", "flood coolant, pin A3"), 2: ("M3 S1000", "M5", "spindle, pin D11")}


class GrblWords:
    """G-code words: distances in millimetres, feeds in mm/min.

    Args:
        options: the user's options for the target.
        first: the index, in XYZ, of the letter for the first axis.
    """

    def __init__(self, options: WriterOptions, first: int) -> None:
        self.steps_per_mm, self.first = options.steps_per_mm, first
        self.digits = digits_for(options.steps_per_mm)

    def letter(self, axis: int) -> str:
        """Return the letter (X, Y or Z) of an axis; the first axis has the number 1."""
        return LETTERS[self.first + axis - 1]

    def distance(self, axis: int, steps: int) -> str:
        """Return the word for a distance or a position given in steps: the axis letter and the millimetres."""
        return f"{self.letter(axis)}{number(steps / self.steps_per_mm, self.digits)}"

    def feed(self, rate: float) -> str:
        """Return the F word for a rate in steps/s."""
        return f"F{number(rate * 60 / self.steps_per_mm, 3)}"


def grbl_pins(first: int) -> list[tuple[str, str]]:
    """Return pairs: a wire's purpose, and its pin on a grbl board; `XYZ[first]` is the letter of the axis."""
    letter = LETTERS[first]
    return [
        ("step", f"pin D{2 + first}, step {letter}"),
        ("direction", f"pin D{5 + first}, direction {letter}"),
        ("enable", "pin D8"),
        ("abort", "pin A5, probe"),
        ("home", "pin A5, probe"),
    ]


def rate_of(action: SetProfile) -> float | None:
    """Return the top rate (between the ramps) that applies after a setting, or None if it is not known."""
    if action.profile is not None:
        return action.profile.top
    return action.value if action.sets == "top rate" else None


def judged(writer: LanguageWriter, action: SetProfile, rate: float | None) -> None:
    """Record how closely a grbl board can reproduce the setting of a rate or a ramp."""
    sheet, line = writer.sheet, action.line
    if action.sets == "top rate" and rate is not None and rate > FASTEST:
        limit = f"{FASTEST:,} steps/s (README of grbl)"
        sheet.impossible(line, f"{number(rate, 0)} steps/s", limit, "coarser steps, or LinuxCNC")
    elif action.sets == "top rate":
        sheet.same(line)
    elif action.sets == "start rate":
        sheet.nearly(line, f"no start rate: {FROM_REST}")
    else:
        mm = number(writer.acceleration / writer.options.steps_per_mm, 1)
        sheet.nearly(line, f"the ramp is that of the settings: $120={mm} mm/s^2")


def probing(action: RunEndless | Home) -> str:
    """Return the G word for a move that ends when an input has a given level; the probe input is active low."""
    until = action.until if isinstance(action, RunEndless) else None
    return "G38.5" if until and until.level else "G38.3"


def has_output(writer: LanguageWriter, action: SetOutput) -> bool:
    """Return whether grbl has a counterpart of an output; if not, record the source line as not possible."""
    if action.number in OUTPUTS:
        return True
    limit = "two outputs: coolant (M8, M9) and spindle (M3, M5)"
    remedy = "LinuxCNC, or a sketch for an Arduino"
    writer.sheet.impossible(action.line, f"output {action.number}", limit, remedy)
    return False


class GrblWriter(LanguageWriter):
    """A writer of grbl G-code for one program."""

    needs = "a word needs a number"
    entry = "no jumps (grbl runs line by line)"
    entry_remedy = HOST
    called = "the called program is written here"
    moves = "included in the moves"
    more_axes = ("3 axes: X, Y, Z", "LinuxCNC")

    def __init__(self, target: Target, program: Program, options: WriterOptions) -> None:
        super().__init__(target, program, options)
        self.first = self.first_axis(LETTERS)
        self.most_axes = len(LETTERS) - self.first
        self.words = GrblWords(options, self.first)
        self.variable_distance = self.variable_sign = False  # loops are unrolled: both are known
        self.moved = False  # the preceding line is a move
        self.ended = False  # the stored program
        repeats = options.values.get("repeats", "1")
        if not repeats.isdecimal() or not int(repeats):
            raise UsageError(f"repeats {repeats}: allowed 1 or more")
        self.repeats = int(repeats)

    def written(self) -> Written:
        self.tree(self.program.block(-1))
        host = self.commented(-1)
        out = [*self._settings(), OutLine("G21 G90 G94", "mm, absolute, mm/min")]
        for output, level in outputs(self.program):
            if output in OUTPUTS:
                out.append(OutLine(OUTPUTS[output][1 - level], f"output {output} as after a reset"))
        out += [*host, OutLine("M2"), *self._not_run()]
        spm, mm = number(self.options.steps_per_mm), number(self.acceleration / self.options.steps_per_mm)
        assumed = (("$100, steps/mm", spm), ("$120, mm/s^2", mm), ("$1, step idle delay", "255: motors stay on"))
        return self.finished(out, assumed)

    def _not_run(self) -> list[OutLine]:
        """Return the code of the stored programs that the source enters but never runs; it follows the final M2."""
        out: list[OutLine] = []
        for block in stored(self.program):
            if block in self.runs.values():
                continue
            self.sheet.lines, self.moved, self.registers.profile = [], False, None
            self.inside(block)
            out += [OutLine("", "Entered, but not run by the text: to run it, remove the M2 above."), *self.sheet.lines]
        return out

    def _settings(self) -> list[OutLine]:
        """Return a comment with the grbl settings that the program requires, to be sent once, while grbl is idle."""
        top = top_rate(self.program.actions)
        at, spm = self.first, self.options.steps_per_mm
        rows = (
            (f"$1{at:02}={number(spm)}", "steps/mm"),
            (f"$1{10 + at}={number(math.ceil(top * 60 / spm))}", "greatest rate, mm/min"),
            (f"$1{20 + at}={number(self.acceleration / spm)}", "acceleration, mm/s^2"),
        )
        description = "Settings to send once, while grbl is idle: "
        return [OutLine("", description + ", ".join(f"{text} ({what})" for text, what in rows))]

    def wires(self) -> list[tuple[str, str]]:
        names = grbl_pins(self.first)
        return [*names, *((f"output{output}", pin) for output, (_, _, pin) in OUTPUTS.items())]

    # ------------------------------------------------------------------------------------------------------------ flow
    def tree(self, tree: Sequence[Node]) -> None:
        """Write the commands of a program tree, with its loops unrolled."""
        for node in tree:
            if self.ended:
                return
            match node:
                case Repeat():
                    self._repeat(node)
                case Forever():
                    self._again(node, "repeats forever")
                case AsLongAs():
                    self._again(node, "repeats as long as an input has its level")
                case Fork():
                    limit = "no conditions (grbl has no expressions and reads no inputs)"
                    self.sheet.impossible(node.line, "branches on an input: neither branch is written", limit, HOST)
                case Stages():
                    limit = "no jumps (grbl runs line by line)"
                    self.sheet.impossible(node.line, "jumps on inputs: the program is left out", limit, HOST)
                case Label():
                    pass
                case _:
                    self.action(node)
                    self.registers.note(node)

    def _repeat(self, node: Repeat) -> None:
        before = len(self.sheet.lines)
        for done in range(node.passes):
            self.tree(node.body)
            each = (len(self.sheet.lines) - before) // (done + 1)
            if each * node.passes > self.options.unroll:
                limit = f"no loops; {each * node.passes:,} lines for {self.options.unroll:,} allowed (--unroll)"
                description = f"{node.passes:,} passes: one of them is written"
                self.sheet.impossible(node.line, description, limit, f"use a larger --unroll, or {HOST}")
                return
        self.sheet.same(node.line, f"{node.passes} passes, written out")

    def _again(self, node: Forever | AsLongAs, description: str) -> None:
        for _ in range(self.repeats):
            self.tree(node.body)
        times = "once" if self.repeats == 1 else f"{self.repeats} times"
        self.sheet.impossible(node.line, f"{description}: written {times}", "no loops, no inputs", HOST)

    # -------------------------------------------------------------------------------------------------------- actions
    def preset(self, action: SetPosition) -> None:
        """Write G92, which assigns a value to the current position."""
        self._add(f"G92 {self.words.distance(action.axis, action.position)}", action.line)

    def leave(self, action: EndProgram) -> None:
        """Record the end of a stored program, after which none of its actions are written."""
        super().leave(action)
        self.ended = True

    def wait(self, action: WaitInput) -> None:
        """Write M0, with which grbl waits for the operator instead of the input."""
        self._add("M0", action.line)
        description = f"a wait for input {action.input.number}, so M0 waits for the operator instead"
        self.sheet.impossible(action.line, description, "a grbl program cannot read inputs", HOST)

    def _add(self, text: str, source: int, moves: bool = False) -> None:
        if moves and self.moved:
            self.sheet.add("G4 P0", source)
        self.sheet.add(text, source)
        self.moved = moves

    def call(self, block: int, at: str, line: int) -> None:
        """Write the commands of a stored program in place of the command that runs it."""
        self.inside(block)

    def inside(self, block: int) -> None:
        """Write the commands of a stored program, with the comments of its source lines."""
        before = self.sheet.lines
        self.sheet.lines = []
        self.tree(structured(self.inner(block)))
        self.ended = False
        self.sheet.lines = [*before, *self.commented(block)]

    def profile(self, action: SetProfile) -> None:
        """Write the F word for the rate that a setting selects, unless this feed is already in effect."""
        rate = rate_of(action)
        if rate is not None and rate != self.known.get("feed") and action.sets != "ramp":
            self.sheet.add(self.words.feed(rate), action.line)
            self.known["feed"] = rate
        judged(self, action, rate)

    def _feed(self, profile: Profile | None) -> str:
        if profile is None or profile.top == self.known.get("feed"):
            return ""
        self.known["feed"] = profile.top
        return f" {self.words.feed(profile.top)}"

    def move(self, action: MoveBy | MoveTo) -> None:
        line, axis = action.line, action.axis
        feed = self._feed(action.profile or self.registers.profile)
        if isinstance(action, MoveTo):
            self._add(f"G90 G1 {self.words.distance(axis, action.position or 0)}{feed}", line, moves=True)
        else:
            steps = self.registers.steps(action)
            if steps is None:
                self.unknown(line, "the number of steps")
                return
            self._add(f"G91 G1 {self.words.distance(axis, steps)}{feed}", line, moves=True)
        compare_times(self.sheet, action, self.acceleration, FROM_REST)

    def sign_of(self, action: RunEndless | Home) -> int | None:
        return self.registers.sign if action.sign is None else action.sign

    def search(self, action: RunEndless | Home, sign: int) -> None:
        """Write a probing move, which is ended by an input; for a search for home, also set the position to 0."""
        line = action.line
        steps = self.words.distance(action.axis, sign * FAR)
        self._add(f"G91 {probing(action)} {steps}{self._feed(action.profile)}", line, moves=True)
        if isinstance(action, Home):
            self._add(f"G92 {self.words.letter(action.axis)}0", line)
        self.sheet.nearly(line, PROBED)

    def output(self, action: SetOutput) -> None:
        """Write the coolant or spindle command that sets an output."""
        if has_output(self, action):
            self._add(OUTPUTS[action.number][1 - action.level], action.line)
            self.sheet.same(action.line)

    def delay(self, action: Delay) -> None:
        """Write a dwell."""
        self._add(f"G4 P{number(action.time_ps / PS)}", action.line)
        lasts = -(-action.time_ps // DWELL_PS) * DWELL_PS
        if lasts == action.time_ps:
            self.sheet.same(action.line)
            return
        description = f"{seconds(lasts)} instead of {seconds(action.time_ps)}: grbl waits in whole steps of 50 ms"
        off = (lasts - action.time_ps) / action.time_ps
        self.sheet.nearly(action.line, description, off, lasts - action.time_ps)
