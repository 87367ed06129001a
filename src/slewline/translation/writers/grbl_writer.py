"""G-code for grbl 1.1, which has no loops, no conditions and no inputs: what repeats is written out.

Each move ends before the next line begins: `G4 P0` between two moves lets grbl come to rest; it joins them otherwise.
Where the source waits for an input there is `M0`: a person continues.  A host script waits by itself (host_script.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..meaning import (
    Action,
    Delay,
    EndProgram,
    EnterProgram,
    Home,
    Label,
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
from .flow import AsLongAs, Forever, Fork, Node, Repeat, Stages, structured
from .source_sheet import (
    FAR,
    PS,
    Draft,
    Held,
    compare_times,
    digits_for,
    grouped,
    heading,
    lines_of,
    number,
    one_acceleration,
    outputs,
    runs,
    seconds,
    stored,
    top_rate,
    unspoken,
    wired,
    with_comments,
)

LETTERS = "XYZ"
FASTEST = 30_000  # steps/s: README of grbl
DWELL_PS = 50 * 10**9  # a dwell is whole steps of 50 ms: DWELL_TIME_STEP, source of grbl
FROM_REST = "grbl starts from standstill, with $120"
HOST = "take --to python: a host script that sends grbl what comes next"
OUTPUTS = {1: ("M8", "M9", "flood coolant, pin A3"), 2: ("M3 S1000", "M5", "spindle, pin D11")}


class Grbl(Target):
    """G-code for grbl."""

    name = "grbl"
    title = "G-code for grbl"
    suffix = ".nc"
    language = "grbl 1.1h (wiki and documentation)"

    def comment(self, text: str) -> str:
        """Return a comment as a line of its own."""
        return f"; {text}" if text else ""

    def write(self, program: Program, options: WriterOptions) -> Written:
        """Return the program, written out."""
        return _GrblWriter(self, program, options).written()

    def read_back(self, text: str, options: WriterOptions) -> PlayedTrace | None:
        """Return what grbl does with the text."""
        from ..reading_back.grbl_reader import read

        return read(text, options)


class GrblWords:
    """The words of G-code: distances in millimetres, feeds in mm/min."""

    def __init__(self, options: WriterOptions) -> None:
        self.steps_per_mm = options.steps_per_mm
        self.first = LETTERS.index(options.axis.upper()) if options.axis.upper() in LETTERS else 0
        self.digits = digits_for(options.steps_per_mm)

    def letter(self, axis: int) -> str:
        """Return the letter of an axis; empty: grbl has no such axis."""
        return LETTERS[self.first + axis - 1 : self.first + axis]

    def distance(self, axis: int, steps: int) -> str:
        """Return a distance, or a position."""
        return f"{self.letter(axis)}{number(steps / self.steps_per_mm, self.digits)}"

    def feed(self, rate: float) -> str:
        """Return the word of a rate."""
        return f"F{number(rate * 60 / self.steps_per_mm, 3)}"


class _GrblWriter:
    """A writer at work on one program."""

    def __init__(self, target: Target, program: Program, options: WriterOptions) -> None:
        self.target, self.program, self.options = target, program, options
        self.sheet = Draft(target.comment, program)
        self.words = GrblWords(options)
        self.registers = Held()
        self.runs = runs(program)
        self.outputs = {output for output, _ in outputs(program)}
        self.acceleration = one_acceleration(program.actions)
        self.feed = 0.0
        self.moved = False  # the line before this one is a move
        self.ended = False  # the stored program
        self.repeats = max(1, int(options.values.get("repeats", "1")))

    def written(self) -> Written:
        """Return the result."""
        self.tree(self.program.block(-1))
        host = with_comments(lines_of(self.program, -1), self.sheet.lines, self.target.comment)
        out = [*heading(self.program), *self._settings()]
        out.append(OutLine("G21 G90 G94", "mm, absolute, mm/min"))
        for output, level in outputs(self.program):
            if output in OUTPUTS:
                out.append(OutLine(OUTPUTS[output][1 - level], f"output {output} as after a reset"))
        out += [*host, OutLine("M2"), *self._not_run()]
        spm, mm = number(self.options.steps_per_mm), number(self.acceleration / self.options.steps_per_mm)
        assumed = (("$100, steps/mm", spm), ("$120, mm/s^2", mm), ("$1, step idle delay", "255: motors stay on"))
        return Written(tuple(out), tuple(self.sheet.verdicts), self._wiring(), assumed)

    def _not_run(self) -> list[OutLine]:
        """Return the programs that the text enters and does not run: after M2, where grbl does not go."""
        out: list[OutLine] = []
        for block in stored(self.program):
            if block in self.runs.values():
                continue
            self.sheet.lines, self.moved, self.registers.profile = [], False, None
            self._inside(block)
            out += [OutLine("", "Entered, but not run by the text: to run it, remove the M2 above."), *self.sheet.lines]
        return out

    def _settings(self) -> list[OutLine]:
        """Return the settings that the program takes for granted: to be sent once, while grbl is idle."""
        top = top_rate(self.program.actions)
        at = LETTERS.index(self.words.letter(1) or "X")
        spm = self.options.steps_per_mm
        rows = (
            (f"$1{at:02}={number(spm)}", "steps/mm"),
            (f"$1{10 + at}={number(math.ceil(top * 60 / spm))}", "greatest rate, mm/min"),
            (f"$1{20 + at}={number(self.acceleration / spm)}", "acceleration, mm/s^2"),
        )
        says = "Settings to send once, while grbl is idle: "
        return [OutLine("", says + ", ".join(f"{text} ({what})" for text, what in rows))]

    def _wiring(self) -> tuple[tuple[str, str, str], ...]:
        letter = self.words.letter(1)
        at = LETTERS.index(letter)
        names = [("step", f"pin D{2 + at}, step {letter}"), ("direction", f"pin D{5 + at}, direction {letter}")]
        names += [("enable", "pin D8"), ("abort", "pin A5, probe"), ("home", "pin A5, probe")]
        names += [(f"output{output}", pin) for output, (_, _, pin) in OUTPUTS.items()]
        return wired(self.program, names)

    # ------------------------------------------------------------------------------------------------------------ flow
    def tree(self, tree: Sequence[Node]) -> None:
        """Write a tree, with its loops written out."""
        for node in tree:
            if self.ended:
                return
            match node:
                case Repeat():
                    self._repeat(node)
                case Forever():
                    self._again(node, "repeats for ever")
                case AsLongAs():
                    self._again(node, "repeats as long as an input has its level")
                case Fork():
                    limit = "no conditions (grbl has no expressions and reads no inputs)"
                    self.sheet.impossible(node.line, "decides by an input: neither branch is written", limit, HOST)
                case Stages():
                    limit = "no jumps (grbl runs line by line)"
                    self.sheet.impossible(node.line, "jumps by inputs: the program is left out", limit, HOST)
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
                says = f"{node.passes:,} passes: one of them is written"
                self.sheet.impossible(node.line, says, limit, f"a greater --unroll, or {HOST}")
                return
        self.sheet.same(node.line, f"{node.passes} passes, written out")

    def _again(self, node: Forever | AsLongAs, says: str) -> None:
        for _ in range(self.repeats):
            self.tree(node.body)
        times = "once" if self.repeats == 1 else f"{self.repeats} times"
        self.sheet.impossible(node.line, f"{says}: written {times}", "no loops, no inputs", HOST)

    # -------------------------------------------------------------------------------------------------------- actions
    def action(self, action: Action) -> None:
        """Write an action."""
        sheet, line = self.sheet, action.line
        match action:
            case SetProfile():
                self._profile(action)
            case SetDistance() | SetDirection():
                sheet.same(line, "it is in the moves")
            case SetPosition():
                self._add(f"G92 {self.words.distance(action.axis, action.position)}", line)
                sheet.same(line)
            case MoveBy() | MoveTo():
                self._move(action)
            case RunEndless() | Home():
                self._search(action)
            case SetOutput():
                self._output(action)
            case WaitInput():
                self._add("M0", line)
                says = f"a wait for input {action.input.number}: M0 waits for a person"
                sheet.impossible(line, says, "no inputs in a program", HOST)
            case Delay():
                self._delay(action)
            case EndProgram():
                sheet.same(line)
                self.ended = True
            case LeaveProgram() | RunProgram():
                self._run(action)
            case EnterProgram():
                pass
            case _:
                unspoken(sheet, action, "the result is a file, which is kept")

    def _add(self, text: str, source: int, moves: bool = False) -> None:
        if moves and self.moved:
            self.sheet.add("G4 P0", source)
        self.sheet.add(text, source)
        self.moved = moves

    def _run(self, action: LeaveProgram | RunProgram) -> None:
        if isinstance(action, LeaveProgram) and not action.runs:
            return
        if isinstance(action, RunProgram) and action.at:
            limit = "no jumps (grbl runs line by line)"
            self.sheet.impossible(action.line, f"the program runs from {action.at} on", limit, HOST)
            return
        self._inside(self.runs[action.line])
        self.sheet.same(action.line, "what runs is written here")

    def _inside(self, block: int) -> None:
        """Write a stored program."""
        inside = [each for each in self.program.block(block) if not isinstance(each, EnterProgram | LeaveProgram)]
        before = len(self.sheet.lines)
        self.tree(structured(inside))
        self.ended = False
        written = self.sheet.lines[before:]
        self.sheet.lines[before:] = with_comments(lines_of(self.program, block), written, self.target.comment)

    def _profile(self, action: SetProfile) -> None:
        profile = action.profile
        rate = profile.top if profile else action.value if action.sets == "top rate" else None
        if rate is not None and rate != self.feed and action.sets != "ramp":
            self.sheet.add(self.words.feed(rate), action.line)
            self.feed = rate
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

    def _feed(self, profile: Profile | None) -> str:
        if profile is None or profile.top == self.feed:
            return ""
        self.feed = profile.top
        return f" {self.words.feed(profile.top)}"

    def _move(self, action: MoveBy | MoveTo) -> None:
        line, axis = action.line, action.axis
        if not self.words.letter(axis):
            self.sheet.impossible(line, f"axis {axis}", "3 axes: X, Y, Z", "LinuxCNC")
            return
        feed = self._feed(action.profile or self.registers.profile)
        if isinstance(action, MoveTo):
            if action.position is None:
                self._unknown(line, "the position")
                return
            self._add(f"G90 G1 {self.words.distance(axis, action.position)}{feed}", line, moves=True)
        else:
            steps = self.registers.steps(action)
            if steps is None:
                self._unknown(line, "the number of steps")
                return
            self._add(f"G91 G1 {self.words.distance(axis, steps)}{feed}", line, moves=True)
        compare_times(self.sheet, action, self.acceleration, FROM_REST)

    def _unknown(self, line: int, what: str) -> None:
        remedy = "write the command with a number"
        self.sheet.impossible(line, f"{what} is not known from the text", "a word needs a number", remedy)

    def _search(self, action: RunEndless | Home) -> None:
        sign, line = action.sign, action.line
        if sign is None:
            sign = self.registers.sign
        if sign is None:
            self._unknown(line, "the direction")
            return
        until = action.until if isinstance(action, RunEndless) else None
        code = "G38.5" if until and until.level else "G38.3"  # a probe is active low
        steps = self.words.distance(action.axis, sign * FAR)
        self._add(f"G91 {code} {steps}{self._feed(action.profile)}", line, moves=True)
        if isinstance(action, Home):
            self._add(f"G92 {self.words.letter(action.axis)}0", line)
        self.sheet.nearly(line, f"ends after {grouped(FAR)} steps at the latest; the switch goes to the probe, pin A5")

    def _output(self, action: SetOutput) -> None:
        if action.implied and action.number not in self.outputs:
            return
        if action.number not in OUTPUTS:
            limit = "two outputs: coolant (M8, M9) and spindle (M3, M5)"
            self.sheet.impossible(action.line, f"output {action.number}", limit, "LinuxCNC, or a sketch for an Arduino")
            return
        self._add(OUTPUTS[action.number][1 - action.level], action.line)
        self.sheet.same(action.line)

    def _delay(self, action: Delay) -> None:
        self._add(f"G4 P{number(action.time_ps / PS)}", action.line)
        lasts = -(-action.time_ps // DWELL_PS) * DWELL_PS
        if lasts == action.time_ps:
            self.sheet.same(action.line)
            return
        says = f"{seconds(lasts)} for {seconds(action.time_ps)}: grbl waits for whole steps of 50 ms"
        off = (lasts - action.time_ps) / action.time_ps
        self.sheet.nearly(action.line, says, off, lasts - action.time_ps)
