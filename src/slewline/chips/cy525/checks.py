"""Lint rules for the CY525 only: whether each move reaches its rate, and whether H has an effect.

The rules follow the text as a chip would run it, through both outcomes of every branch; the value of a
register is None where it is unknown.  Each motion is then checked with the register values at its start.
Step counts are exact: the ramp is the chip's own (profile.py); times apply at the reference crystal.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

from ...core.datasheet.table import Sheet
from ...language.lint import Check
from ...language.problems import Severity
from ...language.statements import Directive, Source, Statement
from ..cy5xx.checks import walk, written_for
from .profile import head, ramp, steps
from .sheet import RATE_TOP, SHORT_SLEW_STEPS, SLIPS, STEP_TICKS, STEPS_PER_SECOND, VERIFY_BYTES

NUMBER_TOP = 65535
RAMP_TOP = (NUMBER_TOP - SHORT_SLEW_STEPS) // 2  # the longest ramp that leaves room to slew ("32K or so", s.7)
FIRST_STATED = 3  # the rate table has no values for lower rates (T.VII)
BRISK = 1000  # steps per second above which many motors need a ramp; a hint, not a limit of the chip
SHORT_CRAWL = 0.1  # seconds at the first rate, too few for a warning


class State(NamedTuple):
    """The registers, as far as the text determines them; `halt` is the line of an H that no motion has used up yet."""

    first: int | None = None
    rate: int | None = None
    slope: int | None = None
    divisor: int | None = None
    number: int | None = None
    position: int | None = None
    halt: int | None = None


class KnownMotion(NamedTuple):
    """A G or P, with the registers at its start."""

    statement: Statement
    state: State

    @property
    def distance(self) -> int | None:
        """The number of steps of the motion; None if it is not known."""
        if self.statement.row.name == "GO":
            return self.state.number
        position = self.state.position
        return None if position is None else abs(self.statement.values[0] - position)


class Unreached(NamedTuple):
    """A motion that decelerates before reaching its rate, and its finding; `remedy` states the rate reached."""

    statement: Statement
    found: str
    remedy: str


SETS = {
    "FIRSTRATE": "first",
    "RATE": "rate",
    "SLOPE": "slope",
    "DIVISOR": "divisor",
    "NUMBER": "number",
    "ABSOLUTE": "position",
}


def after(statement: Statement, state: State) -> State:
    """Return the registers after a command."""
    name = statement.row.name
    if name in SETS:
        return state._replace(**{SETS[name]: statement.values[0]})
    if name == "HALTMODE":
        return state._replace(halt=statement.line)
    if name == "INITIALIZE":
        return state._replace(halt=None)
    if name == "GO" or (name == "POSITION" and state.halt is not None):
        return state._replace(halt=None, position=None)
    if name == "POSITION":
        return state._replace(position=statement.values[0])
    return state


class Walk:
    """All motions in the text of a program, each with every set of register values that it can start with."""

    def __init__(self, source: Source) -> None:
        self.motions: dict[KnownMotion, None] = {}  # in order of discovery
        self.halts: dict[int, Statement] = {}
        self.flight = Flight(source)
        walk(source, [State()], self._step, self.flight.directive)

    def _step(self, statement: Statement, state: State) -> State:
        if statement.row.name == "HALTMODE":
            self.halts.setdefault(statement.line, statement)
        if statement.row.motion:
            motion = KnownMotion(statement, state)
            self.motions[motion] = None
            self.flight.motion(motion)
        return after(statement, state)


# ------------------------------------------------------------------------------------------------------------- motions


def motions(source: Source) -> None:
    """Check every motion, and report every H that no motion follows."""
    walk = Walk(source)
    unset(source, walk.motions)
    short: list[Unreached] = []
    for motion in walk.motions:
        endless = judge(source, motion, short)
        if endless and not walk.flight.stopped:
            found = f"{motion.statement.text} runs until ABORT is low, but no line of this text lowers it"
            remedy = "add @drive abort=0 after it, or run it with --drive abort=0@2s or --until 2s"
            source.report(motion.statement, "no-abort", "note", found, section="s.3 H; s.7", remedy=remedy)
            walk.flight.stopped = True  # reported once
    unreached(source, short)
    used = {motion.state.halt for motion in walk.motions}
    for line, statement in walk.halts.items():
        if line not in used:
            found = "no G or P follows this H"
            remedy = f"H applies to one motion; {SLIPS['H']}"
            source.report(statement, "halt-unused", "warning", found, section="s.7", remedy=remedy)


def unset(source: Source, found: Iterable[KnownMotion]) -> None:
    """Report the first motion that uses an unset register, whose value is undefined after power-up (s.4)."""
    for statement, state in sorted(found, key=lambda motion: motion.statement.line):
        names = {"F": state.first, "R": state.rate, "S": state.slope, "Z": state.divisor}
        if statement.row.name == "GO":
            names["N"] = state.number
        if state.first is not None and state.rate is not None and state.rate <= state.first:
            del names["S"], names["Z"]  # no ramp, no slope
        letters = [letter for letter, value in names.items() if value is None]
        if letters:
            message = f"{statement.row.form} uses {', '.join(letters)}, which no command above has set"
            remedy = "register contents are undefined after power-up: set them once"
            source.report(statement, "unset-register", "note", message, section="s.4", remedy=remedy)
            return


def judge(source: Source, motion: KnownMotion, short: list[Unreached]) -> bool:
    """Check one motion with one set of registers; return whether the motion is endless."""
    first, rate, slope, divisor = motion.state[:4]
    if first is None or rate is None:
        return False
    first, rate = min(first, RATE_TOP), min(rate, RATE_TOP)
    if rate < first:
        found = f"R {rate} is below F {first}: the whole move is made at F"
        source.report(motion.statement, "rate-below-first", "warning", found, section="s.8")
    if rate > first and (slope is None or divisor is None):
        return False
    up = ramp(first, rate, slope, divisor) if rate > first and slope is not None and divisor is not None else ()
    if motion.state.halt is not None:
        return continuous(source, motion, f"from F {first} to R {rate}", steps(up))
    if motion.distance and up:  # a move to the present position has no steps
        normal(source, motion, up, first, rate, short)
    return False


def continuous(source: Source, motion: KnownMotion, span: str, full: int) -> bool:
    """Report an H that has no effect, because two ramps and 256 steps do not fit into the motion (s.7, s.8).

    Return whether H makes the motion endless.
    """
    distance, needed = motion.distance, 2 * full + SHORT_SLEW_STEPS
    if full > RAMP_TOP:
        found = f"H has no effect: the ramp {span} takes {full} steps, too many to slew in any distance"
        allowed, remedy = f"up to {RAMP_TOP} steps", "raise S or lower Z"
        source.report(
            motion.statement, "ramp-too-long", "warning", found, allowed=allowed, section="s.7", remedy=remedy
        )
    elif distance is not None and distance < needed:
        found = f"H has no effect: {distance} steps are too few to slew; the ramp {span} takes {full} steps"
        allowed, remedy = f"at least {needed} steps", "use a large N, such as N 65000"
        source.report(
            motion.statement, "halt-too-short", "warning", found, allowed=allowed, section="s.7", remedy=remedy
        )
    else:
        return distance is not None
    return False


def normal(
    source: Source, motion: KnownMotion, up: tuple[tuple[int, int], ...], first: int, rate: int, short: list[Unreached]
) -> None:
    """Report a normal move that does not reach its rate, or that ends with steps at the first rate (s.8)."""
    distance, full = motion.distance or 0, steps(up)
    rest = distance - 2 * full
    if rest < 0:
        cut = head(up, distance // 2)
        top = STEP_TICKS.index(cut[-1][0]) if cut else first
        found = f"R {rate} is not reached: each ramp takes {full} steps, but the move has {distance}"
        short.append(
            Unreached(motion.statement, found, f"the move reaches rate {top}, {STEPS_PER_SECOND[top]} steps/s")
        )
    elif 0 < rest < SHORT_SLEW_STEPS:
        seconds = rest * STEP_TICKS[first] / source.sheet.crystal_hz
        severity: Severity = "note" if seconds < SHORT_CRAWL else "warning"
        crawl = f"the remaining {rest} are output at F {first}, which takes {seconds * 1000:.0f} ms"
        found = f"the move does not slew: its two ramps take {2 * full} of its {distance} steps; {crawl}"
        remedy = f"use a move of {2 * full} steps, or of at least {2 * full + SHORT_SLEW_STEPS}"
        source.report(motion.statement, "short-slew", severity, found, section="s.8, short slew", remedy=remedy)


def unreached(source: Source, short: list[Unreached]) -> None:
    """Report the first motion that does not reach its rate, with the lines of all other such motions.

    The report is only a note, because such motions are seldom mistakes.
    """
    if not short:
        return
    statement, found, remedy = min(short, key=lambda each: each.statement.line)
    others = sorted({each.statement.line for each in short} - {statement.line})
    if others:
        lines = f"line{'s' * (len(others) > 1)} {', '.join(map(str, others))}"
        remedy += f"; it is not reached in {lines} either"
    source.report(statement, "rate-unreached", "note", found, section="s.8", remedy=remedy)


# ---------------------------------------------------------------------------------------------------- on the fly (s.7)


class Flight:
    """A check of the host directives during a continuous motion: changes of rate on the fly, then an abort."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.current: int | None = None  # rate of the continuous motion; None for none
        self.first = 0
        self.stopped = False  # ABORT is lowered, or everything is reset
        self.lowest = 0  # rate at which an abort would stop: F, or the last lower rate on the fly

    def motion(self, motion: KnownMotion) -> None:
        """Follow a motion: if it is continuous (after H), its rate may be changed on the fly."""
        if motion.state.halt is not None:
            self.current = motion.state.rate if motion.state.rate is not None else RATE_TOP
            self.first = self.lowest = motion.state.first or 0

    def directive(self, item: Directive) -> None:
        """Follow a directive: a change of rate on the fly, or an input that stops the motion."""
        change = re.match(r"@rate\s+(\d+)\s*$", item.text)
        self.stopped |= item.verb in ("reset", "power", "tell", "bytes") or "reset" in item.text
        if change:
            self.change(item, int(change[1]))
        elif re.search(r"\babort\s*=\s*0", item.text):
            self.stopped = True
            self.stop(item)

    def change(self, item: Directive, rate: int) -> None:
        """Follow a change on the fly to a rate of 0 to 127.

        Report the new rate if it is out of range or causes a dead stop, or if there is no continuous motion.
        """
        if self.current is None:
            found, remedy = "a rate on the fly needs a continuous motion", "send H before the G or P"
            self.source.report(item, "rate-without-halt", "warning", found, section="s.7", remedy=remedy)
        elif rate > RATE_TOP:
            self.source.report(item, "range", "error", item.text, allowed=f"0..{RATE_TOP}", section="s.7")
        elif rate == 0:
            found = f"rate 0 stops the motor from rate {self.current} without a ramp"
            if self.current > self.first:
                self.source.report(item, "zero-rate", "warning", found, section="s.7", remedy="lower the rate first")
        else:
            self.lowest = rate if rate < self.current else self.lowest
            self.current = rate

    def stop(self, item: Directive) -> None:
        """Report an abort that does not decelerate to the first rate: its ramp ends at a higher rate."""
        if self.current is not None and self.lowest > self.first:
            found = f"the abort decelerates only to rate {self.lowest}, the last lower rate, and then stops dead"
            remedy = f"lower the rate to {self.first} before the abort"
            self.source.report(item, "crash-stop", "warning", found, section="s.7", remedy=remedy)
        self.current = None


# ------------------------------------------------------------------------------------------------- single instructions


def rates(source: Source) -> None:
    """Report rates that the manual does not list, and values of F, the first rate, at which a motor may stall."""
    for statement in source.statements:
        name = statement.row.name
        if name not in ("RATE", "FIRSTRATE"):
            continue
        value = min(statement.values[0], RATE_TOP)
        if value < FIRST_STATED:
            exact = f"the manual states exact rates only for {FIRST_STATED}..{RATE_TOP}"
            found = f"{statement.text} is a little less than 300 steps/s; {exact}"
            source.report(statement, "rate-uncertain", "note", found, section="T.VII")
        if name == "FIRSTRATE" and STEPS_PER_SECOND[value] > BRISK:
            found = f"every move starts and stops at {STEPS_PER_SECOND[value]} steps/s without a ramp"
            source.report(statement, "brisk-start", "note", found, section="s.8")


def size(source: Source) -> None:
    """Report a program of more than 48 bytes, because only 48 bytes can be read out (s.6)."""
    shown = VERIFY_BYTES[1]
    for block in source.blocks:
        beyond = next((statement for statement in block.statements if statement.end > shown), None)
        if beyond is not None and block.size <= source.sheet.buffer_bytes:
            found = f"from here on, V 1 is not guaranteed to show the program: it has {block.size} bytes"
            source.report(beyond, "not-verifiable", "note", found, allowed=f"{shown}", section="s.6")


def checks(sheet: Sheet) -> tuple[Check, ...]:
    """Return this part's rules for `language.lint.lint`; each rule reads the data sheet of the text it checks."""
    return (motions, rates, size, written_for)
