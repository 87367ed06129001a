"""The writer of programs for our own parts."""

from __future__ import annotations

from itertools import pairwise

from ...chips import checks_of, sheet_of
from ...language.lint import lint
from ..host_directives import PROGRAM_OVER, waits_for_end
from ..meaning import (
    Action,
    EndProgram,
    EnterProgram,
    HostDirective,
    Jump,
    Label,
    LeaveProgram,
    Loop,
    Motion,
    MoveBy,
    MoveTo,
    Program,
    RunProgram,
    SetOutput,
    SetProfile,
    WaitInput,
    acts_during_motion,
)
from ..profiles import profiles_of
from ..program_facts import counter_of, counts_positions
from ..target_writer import WriterOptions, Written
from ..translation_report import LineKind, LineVerdict, OutLine
from .actions import Actions
from .layout import ResultLayout, ResultPiece
from .limits import memory
from .line_stream import StreamStep, arranged, steps_of
from .nearest_rates import Rates
from .target_directives import hides_the_end
from .unroll import unrolled

WIRED = (
    "step",
    "direction",
    "output1",
    "output2",
    "output3",
    "input1",
    "input2",
    "input3",
    "enable",
    "abort",
    "home",
    "end",
)
MOST_ROUNDS = 5


class OwnWriter:
    """A writer of a program in the dialect of one of our parts.

    Args:
        program: the effect of the program.
        part: the target.
        options: the user's options, including the crystal of the target.
        source_hz: the crystal frequency of the source, Hz; None: that of its usual crystal.
    """

    def __init__(self, program: Program, part: str, options: WriterOptions, source_hz: int | None = None) -> None:
        self.program, self.sheet, self.options = program, sheet_of(part), options
        self.source = sheet_of(program.part)
        self.hz = options.crystal_hz or self.sheet.crystal_hz
        if self.sheet.enter is not None:
            self.steps = arranged(program, self.source, self.sheet)
        elif self.source.enter is not None:
            self.steps = unrolled(steps_of(program), options.unroll, self.source, program.interrupted)
        else:
            self.steps = steps_of(program)
        self.rates = Rates(
            self.steps,
            profiles_of(program.part, source_hz or self.source.crystal_hz),
            profiles_of(part, self.hz),
        )
        self.actions = Actions(self.source, self.sheet, self.hz, self.rates, self._used())
        self._learn()

    def write(self) -> Written:
        """Return the program in the dialect of the target, with its verdicts, wiring and assumptions."""
        pieces = self._pieces()
        layout = ResultLayout(self.sheet, pieces)
        verdicts = [*self.actions.verdicts, *self._too_large(layout), *self._refused(pieces), *self._moved()]
        layout = ResultLayout(self.sheet, pieces)
        lines = [
            OutLine(layout.text(piece), piece.comment, piece.source)
            for piece in pieces
            if piece.row is not None or piece.text or piece.comment or not piece.labels
        ]
        assumed = []
        if self.sheet.crystal_high_hz:
            assumed.append(("crystal of the target", f"{self.hz / 1e6:g} MHz"))
        assumed += self._counted()
        if pin := self.actions.directives.end_pin:
            assumed.append(("end of a program", f"{pin} goes high; nothing else uses {pin}"))
        free = [
            n for n in (1, 2, 3) if n not in self.actions.conditions.used and self.sheet.role(f"input{n}") is not None
        ]
        if "branch_inputs" in self.actions.rows and free and self.actions.conditions.used:
            names = ", ".join(self.sheet.in_role(f"input{n}").name for n in free)
            assumed.append(("inputs that the program does not test", f"{names} open (reads as high)"))
        return Written(tuple(lines), tuple(verdicts), tuple(self._wiring()), tuple(assumed))

    def _refused(self, pieces: list[ResultPiece]) -> list[LineVerdict]:
        """Turn lines with linter errors, such as an exceeded counter limit, into comments; return verdicts on them."""
        found: list[LineVerdict] = []
        for _ in range(MOST_ROUNDS):
            layout = ResultLayout(self.sheet, pieces)
            texts = [layout.text(piece) for piece in pieces]
            problems = lint("\n".join(texts), self.sheet, checks_of(self.sheet.part, self.sheet))
            wrong = {problem.line - 1: problem for problem in problems if problem.severity == "error"}
            wrong = {at: problem for at, problem in wrong.items() if pieces[at].row is not None}
            for at, problem in wrong.items():
                piece = pieces[at]
                limit = f"{problem.allowed or problem.found} ({problem.where or self.sheet.manual})"
                found.append(
                    LineVerdict(
                        piece.source, LineKind.IMPOSSIBLE, problem.found, limit, problem.remedy or "write it by hand"
                    )
                )
                piece.row, piece.text, piece.comment = None, "", f"NOT POSSIBLE: {texts[at]}: {problem.found}"
            if not wrong:
                break
        return found

    def _counted(self) -> list[tuple[str, str]]:
        """Return the assumption that positions stay within the counters of both parts, or an empty list.

        The list is empty if the counters' limits are equal or not known, or do not matter to the program.
        """
        if not counts_positions(self.program):
            return []
        theirs, mine = counter_of(self.source), counter_of(self.sheet)
        if theirs is None or mine is None or theirs == mine:
            return []
        ends = [f"{sheet.part} {low}..{high}" for sheet, (low, high) in ((self.source, theirs), (self.sheet, mine))]
        return [("positions", f"never beyond a limit of a counter ({'; '.join(ends)})")]

    # ----------------------------------------------------------------------------------------- facts about the program
    def _used(self) -> dict[str, set[int]]:
        """Return the numbers of the inputs and outputs that the program uses, keyed by "inputs" and "outputs"."""
        inputs, outputs = set(), set()
        for action in self.program.actions:
            if isinstance(action, WaitInput):
                inputs.add(action.input.number)
            elif isinstance(action, Jump):
                inputs |= {one.number for one in action.inputs}
            elif isinstance(action, SetOutput) and not action.implied:
                outputs.add(action.number)
        return {"inputs": inputs, "outputs": outputs}

    def _learn(self) -> None:
        """Collect the facts about the whole program that are needed to convert the individual actions."""
        actions = [step.action for step in self.steps if step.action is not None]
        blocks = {action.block for action in actions if action.block >= 0}
        for block in blocks:
            inside = [action for action in actions if action.block == block]
            starts = set()
            for action in inside:
                if not isinstance(action, Label):
                    break
                starts.add(action.name)
            body = self.program.block(block)
            own = {action.name for action in body[:1] if isinstance(action, Label)}
            again = any(isinstance(action, SetProfile) for action in body)  # would repeat the settings at the head
            self.actions.starts[block] = starts | (set() if again and not starts else own)
            self.actions.last.add(id(inside[-1]))
            self.actions.loops |= {(block, action.to) for action in inside if isinstance(action, Loop)}
        self.actions.directives.stored = any(isinstance(action, EnterProgram | RunProgram) for action in actions)
        self._show_ends(actions)
        for action in actions:
            if isinstance(action, SetProfile):
                break
            if isinstance(action, Motion) and action.profile is not None:
                self.actions.reset = action.profile
                break
        self.actions.start(actions)
        for action, after in pairwise(actions):
            if isinstance(action, Motion) and action.block < 0 and acts_during_motion(after):
                self.actions.left_running.add(id(action))
        moves = [action for action in actions if isinstance(action, MoveBy)]
        for name, values in (("distance", {move.distance for move in moves}), ("sign", {move.sign for move in moves})):
            if name == "sign" and any(isinstance(action, MoveTo) for action in actions):
                continue  # a move to a position changes the direction permanently
            if len(values) == 1 and None not in values:
                self.actions.fixed[name] = next(iter(values))  # type: ignore[assignment]

    def _show_ends(self, actions: list[Action]) -> None:
        """Choose an unused output to show the end of a program, if one is needed.

        It is needed if the host waits for a program to end, and the target shows the end in no other way.
        """
        free = [number for number in (3, 2, 1) if number not in self._used()["outputs"]]
        waits = any(
            isinstance(action, HostDirective) and waits_for_end(action.text, self.source, PROGRAM_OVER)
            for action in actions
        )
        hidden = self.actions.directives.stored and "bits" in self.actions.rows and hides_the_end(self.sheet)
        if waits and free and hidden:
            self.actions.end_output = free[0]
            self.actions.directives.end_pin = self._bit("output", str(free[0]))

    # --------------------------------------------------------------------------------------------------------- writing
    def _pieces(self) -> list[ResultPiece]:
        """Return the pieces of the result, line by line, with their comments."""
        found: list[ResultPiece] = []
        labels: list[str] = []
        for step in self.steps:
            made = self._made(step)
            comment = step.line.comment if step.first else ""
            plain: list[ResultPiece] = []
            for piece in made:
                bare = piece.row is None and not piece.text and not piece.comment
                if bare:
                    labels += piece.labels
                    continue
                if piece.row is not None and labels and piece.block >= 0:
                    piece.labels = [*labels, *piece.labels]
                    labels = []
                plain.append(piece)
            if comment and plain and plain[0].row is not None and not plain[0].comment:
                plain[0].comment = comment
            elif comment or (step.action is None and step.first and not step.line.code):
                plain.insert(0, ResultPiece(comment=comment, source=step.line.number))
            if isinstance(step.action, LeaveProgram) and labels:
                at = len(found)
                found.insert(at, ResultPiece(labels=labels, block=self.actions.program))
                labels = []
            for piece in plain:
                self._append(found, piece)
        if self.actions.unended is not None:
            found.append(self.actions.unended)
        return found

    @staticmethod
    def _append(found: list[ResultPiece], piece: ResultPiece) -> None:
        """Append a piece; of two equal waits in a row, keep only one, preferably one that has a source line."""
        if found and piece.text.startswith("@until") and found[-1].text == piece.text and not found[-1].comment:
            if found[-1].source:
                return
            found.pop()
        found.append(piece)

    def _made(self, step: StreamStep) -> list[ResultPiece]:
        """Return the instructions for a step of the source program.

        If the step ends program entry, a command that ends the program is added before it, if one is needed.
        """
        action = step.action
        if action is None:
            return []
        made = self.actions.pieces(action)
        if isinstance(action, EnterProgram | LeaveProgram | RunProgram):
            for piece in made:
                piece.program = self.actions.program
        if isinstance(action, LeaveProgram) and self._runs_out():
            end = [*self.actions.end_shown(1), ResultPiece(self.actions.rows["stop"])]
            for piece in end:
                piece.block = self.actions.program
            return [*end, *made]
        if isinstance(action, LeaveProgram):
            return [ResultPiece(labels=["the end"], block=self.actions.program), *made]
        return made

    def _runs_out(self) -> bool:
        """Return whether the target needs a command to end the program where the source program has none."""
        if "stop" not in self.actions.rows:
            return False
        inside = [action for action in self.program.block(self.actions.program) if not isinstance(action, Label)]
        last = inside[-1] if inside else None
        labelled = bool(self.program.block(self.actions.program)) and isinstance(
            self.program.block(self.actions.program)[-1], Label
        )
        return labelled or not (isinstance(last, EndProgram) or (isinstance(last, Jump) and not last.inputs))

    def _too_large(self, layout: ResultLayout) -> list[LineVerdict]:
        """Comment out programs that are too large, as half a program is worse than none; return verdicts on them."""
        found = []
        for block, size in layout.sizes.items():
            if size <= self.sheet.buffer_bytes:
                continue
            limit, lines = memory(self.sheet), set()
            for piece in layout.pieces:
                if block in (piece.block, piece.program) and piece.row is not None:
                    lines.add(piece.source)
                    piece.row, piece.comment = None, f"DOES NOT FIT: {layout.text(piece)}"
            description = f"{size} {self.sheet.memory_unit}s"
            remedy = "split the program, and let the host run its parts one after the other"
            found += [
                LineVerdict(line, LineKind.IMPOSSIBLE, description, limit, remedy) for line in sorted(lines) if line
            ]
        return found

    def _moved(self) -> list[LineVerdict]:
        """Return a verdict on each line with an action that has been moved to another place."""
        lines: dict[int, str] = {}
        for step in self.steps:
            if step.moved and step.action is not None:
                lines[step.line.number] = step.moved
        return [LineVerdict(number, LineKind.SAME, f"moved {where}") for number, where in lines.items()]

    def _wiring(self) -> list[tuple[str, str, str]]:
        """Return the wires that the program uses: purpose, source pin, and target pin (empty if there is none)."""
        used = self._used()
        found = []
        for role in WIRED:
            theirs, pin = self.program.wiring.get(role), self.sheet.role(role)
            kind, number = role[:-1], role[-1:]
            if kind in ("output", "input") and int(number) not in used[f"{kind}s"]:
                continue
            if theirs is not None:
                mine = pin.name if pin is not None else self._bit(kind, number)
                found.append((role, theirs, mine))
        return found

    def _bit(self, kind: str, number: str) -> str:
        """Return the target's bit name for an output or input; empty if the target does not select them by bits."""
        if kind not in ("output", "input") or "bits" not in self.actions.rows:
            return ""
        return f"usrb{int(number) - 1 + (3 if kind == 'input' else 0)}"


def linted(text: str, part: str) -> list[str]:
    """Return the messages of the errors that the linter finds in the program `text`."""
    sheet = sheet_of(part)
    return [problem.message for problem in lint(text, sheet, checks_of(part, sheet)) if problem.severity == "error"]
