"""Common base of writers: collects lines and verdicts, places comments, formats numbers, compares move times."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from ..meaning import (
    Action,
    EraseProgram,
    HostDirective,
    Line,
    MoveBy,
    MoveTo,
    Profile,
    Program,
    Query,
    RunEndless,
    SaveProgram,
    SetDirection,
    SetDistance,
    SetEndless,
    SetPosition,
    SetProfile,
    SetTarget,
    Special,
    Stop,
)
from ..move_times import measured, standing_time
from ..special_commands import BY_HAND, WHILE_IT_RUNS
from ..translation_report import LineKind, LineVerdict, OutLine

PS = 10**12
MS = 10**9
FAR = 1_000_000  # steps of a motion that is ended by an input, if the target has no endless motion


class Draft:
    """The lines of a result under construction, and the verdicts on the source lines."""

    def __init__(self, comment: Callable[[str], str], program: Program, indent: str = "  ") -> None:
        self.lines: list[OutLine] = []
        self.comment = comment
        self.time_of = measured(program)
        self.verdicts: list[LineVerdict] = []
        self.depth = 0
        self._indent = indent

    def add(self, text: str, source: int = 0, comment: str = "") -> None:
        """Add a line to the result; `source` is the source line that it translates, or 0."""
        self.lines.append(OutLine(self._indent * self.depth + text, comment, source))

    def remark(self, text: str, source: int = 0) -> None:
        """Add a comment to the result, as a line of its own."""
        self.add(self.comment(text), source)

    def same(self, line: int, description: str = "") -> None:
        """Record that the translation of a source line has the same effect as that line."""
        self.verdicts.append(LineVerdict(line, LineKind.SAME, description))

    def nearly(self, line: int, description: str, off: float = 0.0, off_ps: int = 0) -> None:
        """Record that the translation of a source line has nearly the same effect as that line.

        The difference is given as a fraction (`off`) and as a time in ps.
        """
        verdict = LineVerdict(line, LineKind.NEARLY, description, off=off, off_ps=off_ps)
        if verdict not in self.verdicts:  # an unrolled loop repeats the remark in each pass
            self.verdicts.append(verdict)

    def impossible(self, line: int, description: str, limit: str, remedy: str) -> None:
        """Record that a source line cannot be translated, and add a comment to the result in place of the line."""
        verdict = LineVerdict(line, LineKind.IMPOSSIBLE, description, limit, remedy)
        if verdict not in self.verdicts:
            self.verdicts.append(verdict)
            self.remark(f"NOT POSSIBLE, line {line}: {description}.", line)


def with_comments(lines: Iterable[Line], out: Sequence[OutLine], comment: Callable[[str], str]) -> list[OutLine]:
    """Return the lines of a result, with the source's comments added.

    The comment of a source line is put on the result line written for that source line.  If there is none,
    it becomes a line of its own, before the code that follows.
    """
    found = list(out)
    for line in lines:
        if not line.comment:
            continue
        beside = next((at for at, each in enumerate(found) if line.code and each.source == line.number), None)
        while beside is not None and beside + 1 < len(found) and found[beside + 1].source == line.number:
            beside += 1  # the last of the lines first written for it, not the head of a loop that begins here
        if beside is not None and not found[beside].comment:
            found[beside] = replace(found[beside], comment=line.comment)
            continue
        before = next((at for at, each in enumerate(found) if each.source > line.number), len(found))
        like = found[min(before, len(found) - 1)].text if found else ""
        indent = like[: len(like) - len(like.lstrip())]
        found.insert(before, OutLine(indent + comment(line.comment), "", line.number))
    return found


def heading(program: Program) -> list[OutLine]:
    """Return the comments before the first command of a program, as lines of the result."""
    return [OutLine("", line.comment, line.number) for line in _heading(program) if line.comment]


def _heading(program: Program) -> list[Line]:
    first = next((at for at, line in enumerate(program.lines) if line.code), len(program.lines))
    return list(program.lines[:first])


def lines_of(program: Program, block: int) -> list[Line]:
    """Return the source lines of a block without the heading.

    A comment on a line of its own belongs to the code after it.
    """
    found: list[Line] = []
    waiting: list[Line] = []
    belongs = -1
    for line in program.lines[len(_heading(program)) :]:
        if not line.actions:
            waiting.append(line)
            continue
        belongs = line.actions[0].block
        if belongs == block:
            found += waiting
            found.append(line)
        waiting = []
    return found + (waiting if belongs == block else [])


# ------------------------------------------------------------------------------------------------------------- numbers
def number(value: float, digits: int = 6) -> str:
    """Return a number as text, with up to `digits` decimals, without an exponent and without trailing zeros."""
    text = f"{value:.{digits}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text in ("-0", "") else text


def grouped(value: int) -> str:
    """Return an integer as text with thousands separators: 1,000,000."""
    return f"{value:,}"


def seconds(ps: float) -> str:
    """Return a time in ps as text in a suitable unit: 1.25 s, 30 ms, 400 us."""
    for size, unit in ((1e12, "s"), (1e9, "ms"), (1e6, "us")):
        if abs(ps) >= size:
            return f"{ps / size:.4g} {unit}"
    return f"{ps / 1e6:.3g} us"


def digits_for(steps_per_mm: float) -> int:
    """Return the number of decimals of mm that resolve an eighth of a step; 0 if a step is exactly 1 mm."""
    return max(0, math.ceil(math.log10(steps_per_mm * 8))) if steps_per_mm != 1 else 0


# --------------------------------------------------------------------------------------------------------------- times
def compare_times(sheet: Draft, action: MoveBy | MoveTo, acceleration: float, why: str) -> None:
    """Record how the time of a move changes in a target that ramps up from standstill.

    Args:
        sheet: the record of the verdicts.
        action: the move; if its profile or its number of steps is not known, only `why` is recorded.
        acceleration: the acceleration of the target.
        why: the reason for the difference, for the report.
    """
    profile, steps = action.profile, action.steps
    if profile is None or not steps:
        sheet.nearly(action.line, f"the steps are the same; {why}")
        return
    was, becomes = sheet.time_of(profile, steps), standing_time(profile.top, acceleration, steps)
    description = f"{seconds(becomes * PS)} instead of {seconds(was * PS)}; {why}"
    sheet.nearly(action.line, description, abs(becomes - was) / was if was else 0.0, round(abs(becomes - was) * PS))


# ----------------------------------------------------------------------------------------------------------- registers
class RegisterCache:
    """The values of the source's registers at one point of the program; None for a value that is not known."""

    def __init__(self) -> None:
        self.distance: int | None = None
        self.sign: int | None = 1
        self.position: int | None = 0
        self.profile: Profile | None = None

    def note(self, action: Action) -> None:
        """Update the values according to the effect of an action."""
        match action:
            case SetDistance():
                self.distance = action.steps
            case SetDirection():
                self.sign = action.sign
            case SetPosition():
                self.position = action.position
            case SetProfile():
                self.profile = action.profile or self._changed(action)
            case MoveBy() | MoveTo():
                steps = self.steps(action)
                # P changes the direction permanently.
                if isinstance(action, MoveTo) and steps:
                    self.sign = 1 if steps > 0 else -1
                self.position = None if steps is None or self.position is None else self.position + steps
            case Special() if action.remedy in (BY_HAND, WHILE_IT_RUNS):
                self.position = None
            case Stop() | RunEndless():
                self.position = None
            case _:
                pass

    def _changed(self, action: SetProfile) -> Profile | None:
        old = self.profile
        if old is None or action.value is None:
            return None
        if action.sets == "top rate":
            return replace(old, top=action.value, start=min(old.start, action.value))
        if action.sets == "start rate":
            return replace(old, start=action.value, top=max(old.top, action.value))
        return old

    def steps(self, action: MoveBy | MoveTo) -> int | None:
        """Return the signed number of steps of a move, from the values known here; None if they do not suffice."""
        if action.steps is not None:
            return action.steps
        if isinstance(action, MoveTo):
            if action.position is None or self.position is None:
                return None
            return action.position - self.position
        distance = self.distance if action.distance is None else action.distance
        sign = self.sign if action.sign is None else action.sign
        return None if distance is None or sign is None else distance * sign


def unspoken(sheet: Draft, action: Action, keeps: str, language: str) -> bool:
    """Record the verdict on an action if no language has a command for it; return whether that is so.

    Such actions are host directives, queries, stops, commands that save or erase a program, special
    commands, and the settings of a target or of an endless run, which are written as part of the motion.

    Args:
        sheet: the record of the verdicts.
        keeps: the report text for a command that saves a program.
        language: the name of the target's language, for the texts about its limits.
    """
    match action:
        case HostDirective():
            sheet.same(action.line, "directed at the host, not at the part: left out")
        case Query():
            sheet.nearly(action.line, "the query is left out, since it moves nothing")
        case SaveProgram():
            sheet.same(action.line, keeps)
        case EraseProgram():
            sheet.nearly(action.line, "nothing is erased: the result is a program of its own")
        case Stop():
            sheet.nearly(action.line, "nothing is left to stop: each move ends before the next command")
        case Special() if action.remedy == BY_HAND:
            sheet.impossible(action.line, action.description, f"{language}: no host drives a pin", BY_HAND)
        case Special() if action.needless:
            sheet.same(action.line, action.needless)
        case Special():
            sheet.impossible(
                action.line,
                action.description,
                f"no such command in {language}",
                action.remedy or "see the manual of the source for its effect",
            )
        case SetTarget() | SetEndless():
            sheet.same(action.line, "included in the motion")
        case _:
            return False
    return True


def wired(program: Program, names: Iterable[tuple[str, str]]) -> tuple[tuple[str, str, str], ...]:
    """Return triples of a wire's purpose, its name in the source, and its name in the target (empty if none)."""
    known = dict(names)
    return tuple((role, name, known.get(role, "")) for role, name in program.wiring.items())
