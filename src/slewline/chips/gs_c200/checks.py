"""Lint rules for the GS-C modules only: ramps that miss their speed, loops, and the position counter.

The program text is followed as a module would run it, with both outcomes of every branch, and with
registers whose values are known or unknown (None).  Each motion is then checked with the registers at
its start.  Ramps are computed by profile.py.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

from ...core.datasheet.table import Sheet
from ...core.time.timebase import PS_PER_S
from ...language.lint import Check, explored
from ...language.problems import Severity
from ...language.statements import Source, Statement
from .dialogue.program_memory import set_first
from .profile import ramp
from .sheet import POSITIONS, RATE_UNIT

SPEEDS = {"S": "start", "T": "top", "R": "ramp"}
COMMANDS = "command descriptions"


class KnownRegisters(NamedTuple):
    """The values of the registers, as far as the program text determines them; None for unknown values."""

    start: int | None = None
    top: int | None = None
    ramp: int | None = None
    position: int | None = None


class MotionCommand(NamedTuple):
    """An instruction that moves the motor, with the registers at its start."""

    statement: Statement
    state: KnownRegisters

    @property
    def steps(self) -> int | None:
        """The signed number of steps; None if it is unknown, or if the motion is endless."""
        name, values, position = self.statement.row.name, self.statement.values, self.state.position
        if name == "MOVE":
            return values[0]
        return values[0] - position if name == "GOTO" and position is not None else None


def after(statement: Statement, state: KnownRegisters) -> KnownRegisters:
    """Return the registers after a command, given those before it."""
    row, values = statement.row, statement.values
    if row.form in SPEEDS:
        return state._replace(**{SPEEDS[row.form]: values[0]})
    if row.name in ("GOTO", "FORCE"):
        return state._replace(position=values[0])
    if row.name == "MOVE" and state.position is not None:
        return state._replace(position=state.position + values[0])
    if row.name == "HOME" or (row.name == "INITIALIZE" and values[0] & 1):
        return state._replace(position=0)
    if row.motion or (row.stored and row.flow != "n"):  # a velocity move; a repetition moves again
        return state._replace(position=None)
    return state


# ------------------------------------------------------------------------------------------------------------- motions


def motions(source: Source) -> None:
    """Walk through the text, and check every motion."""
    found: dict[MotionCommand, None] = {}  # in order of discovery

    def step(statement: Statement, state: KnownRegisters) -> KnownRegisters:
        if statement.row.motion:
            found[MotionCommand(statement, state)] = None
        return after(statement, state)

    states, blocks, block = [KnownRegisters()], iter(source.blocks), None
    for statement in source.statements:
        if statement.block >= 0:
            continue
        if statement.row.role == "enter":
            if block is not None and block.quit is None:
                explored(block, 0, states, step)  # another program may run it
            block = next(blocks)
        elif statement.row.name == "EXECUTE" and block is not None:
            states = explored(block, 0, states, step)
        else:
            states = [after(statement, state) for state in states]
    if block is not None and (block.quit is None or block.quit.row.name != "EXECUTE"):
        explored(block, 0, states, step)
    for motion in found:
        judge(source, motion)


def judge(source: Source, motion: MotionCommand) -> None:
    """Check one motion with the registers at its start, as far as they are known."""
    statement, (start, top, length, position) = motion
    if start is not None and top is not None:
        if top <= start:
            found = f"T{top} is not above S{start}: the whole move is made at T, without ramps"
            source.report(statement, "no-ramp", "warning", found, section=COMMANDS)
        elif length is not None:
            reach(source, motion, start, top, length)
    if position is not None:
        counter(source, motion, position)


def reach(source: Source, motion: MotionCommand, start: int, top: int, length: int) -> None:
    """Report a move that is too short to reach its top speed T, or a ramp without any rate between S and T."""
    steps = abs(motion.steps or 0)
    if 0 < steps < 2 * length + 2:
        up = ramp(start, top, length)
        fastest = round(PS_PER_S / up[max(steps - 2, 0) // 2][0])
        found = f"T{top} is not reached: each ramp takes {length} steps, but the move has {steps}"
        remedy = f"the move reaches {fastest} steps/s; T is reached in moves of {2 * length + 2} steps or more"
        source.report(motion.statement, "rate-unreached", "note", found, section=COMMANDS, remedy=remedy)
    elif length == 1:
        speeds = f"{RATE_UNIT * start} steps/s, then {RATE_UNIT * top}"
        found = f"R1 has no rate between S and T: {speeds}, and back as abruptly"
        source.report(motion.statement, "sudden-ramp", "note", found, section=COMMANDS, remedy="use a longer R")


def counter(source: Source, motion: MotionCommand, position: int) -> None:
    """Report a motion that leaves the range of the GS-C200's position counter, which ends the program (E5)."""
    if source.sheet.part != "gs-c200":
        return
    positions, statement = POSITIONS[source.sheet.part], motion.statement
    if motion.steps is not None and position + motion.steps not in positions:
        found = f"{statement.text} from {position} exceeds the position counter: the program ends with E5"
        allowed = f"positions {positions[0]}..{positions[-1]}"
        source.report(statement, "overflow-counter", "error", found, allowed=allowed, section=COMMANDS)
    elif motion.statement.row.name == "VELOCITY":
        left = positions[-1] - position if statement.values[0] > 0 else position
        found = f"{statement.text} from {position} ends with E5 after {left} steps unless K or Z comes first"
        source.report(statement, "counter-end", "warning" if left == 0 else "note", found, section=COMMANDS)


def unset(source: Source) -> None:
    """Report a motion for which the text has not yet set all of S, T and R: command E would be refused."""
    known: set[str] = set()
    for block in source.blocks:
        for statement in block.statements:
            missing = [letter for letter in SPEEDS if letter not in known]
            if statement.row.motion and missing:
                found = f"{statement.text} comes before {', '.join(missing)}: command E is refused with error E4"
                remedy = set_first(", ".join(missing))
                source.report(statement, "unset-speed", "warning", found, section=COMMANDS, remedy=remedy)
                known |= set(missing)  # reported once
            known |= {statement.row.form} & set(SPEEDS)


# ------------------------------------------------------------------------------------------------- single instructions


def loops(source: Source) -> None:
    """Report nested loops (the module stores one start and count), one-pass loops, and missing starts or ends."""
    for block in source.blocks:
        inside: Statement | None = None
        marks = 0
        for statement in block.statements:
            if statement.row.name == "LOOP_START":
                if inside is not None:
                    found = f"a loop start inside the loop of line {inside.line} replaces the start of that loop"
                    source.report(statement, "nested-loop", "warning", found, section=COMMANDS)
                inside, marks = statement, marks + 1
            elif statement.row.name == "LOOP":
                if inside is None:
                    severity: Severity = "warning" if marks else "note"
                    found = f"{statement.text} has no L0 of its own: it repeats from location 0"
                    source.report(statement, "loop-without-start", severity, found, section=COMMANDS)
                if statement.values[0] == 1:
                    source.report(statement, "loop-once", "warning", "this loop runs only once", section=COMMANDS)
                inside = None
        if inside is not None:
            source.report(inside, "loop-unused", "warning", "no Ln closes this loop", section=COMMANDS)


def heads(source: Source) -> None:
    """Report an empty program, and the special effect of certain instructions at the start of a program."""
    saved = next((s for s in source.statements if s.row.name == "MEMORIZE"), None)
    for block in source.blocks:
        first = block.statements[0] if block.statements else None
        if first is None:
            if block.quit is not None and block.quit.row.name == "EXECUTE":
                found = "command E with an empty program is refused with error E4"
                source.report(block.quit, "empty-program", "warning", found, section=COMMANDS)
            continue
        if first.row.name == "UNTIL":
            found = f"{first.text} at location 0: the whole program is repeated until the input is low at its end"
            source.report(first, "until-first", "note", found, section=COMMANDS)
        ahead = next((s for s in block.statements if s.row.form not in SPEEDS), first)
        if ahead.row.name == "UNTIL" and ahead is not first:
            repeated = "here repeats only the speed settings above it while the input is high"
            found = f"{ahead.text} {repeated}; the rest then runs once"
            remedy = f"{ahead.text} as the last line repeats the whole program"
            source.report(ahead, "until-early", "note", found, section=COMMANDS, remedy=remedy)
        if saved is not None and first.row.form != "S":
            found = f"a program that begins with {first.text} is not run at power-up (REC low): S must be the first"
            source.report(first, "no-autorun", "note", found, section="stand-alone operation")


def pulses(source: Source) -> None:
    """Report an output that is on for the duration of one instruction only."""
    for block in source.blocks:
        for one, two in pairwise(block.statements):
            if (one.row.name, two.row.name) == ("ACTIVATE", "CLEAR") and one.values == two.values:
                found = f"user output {one.values[0]} is high for one instruction only"
                remedy = f"a delay D between {one.text} and {two.text} lengthens the pulse"
                source.report(two, "short-pulse", "note", found, section=COMMANDS, remedy=remedy)


def checks(sheet: Sheet) -> tuple[Check, ...]:
    """Return the lint rules of the GS-C modules for `language.lint.lint`; `sheet` names the part."""
    return (motions, unset, loops, heads, pulses)
