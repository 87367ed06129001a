"""The face of a target: what writes a program in its language, and what reads that back to prove it.

A writer goes through `program.lines` in order and returns lines of its own, each with the line of the source it comes
from; comments are kept, beside what they were beside.  What it cannot write is a `LineVerdict` with the limit of the
target and what a person can do, and a comment in the result at that place.  `translate` puts the warning at the head,
and makes the report.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any, Literal, Protocol

from .meaning import Program
from .translation_report import LineVerdict, OutLine

WARNING = (
    "WARNING: translated by a program. Run it first without load, with a hand on the power switch,",
    "and compare steps, directions and times with the report before anything is coupled to the motor.",
)


@dataclass(frozen=True, slots=True)
class WriterOptions:
    """What a user says about the target.

    Attributes:
        steps_per_mm: for targets that count millimetres.
        axis: the name of the axis for targets that have several: X.
        unroll: how many lines a loop may become where the target has none.
        crystal_hz: the crystal of the target; None: its usual one.
        values: what else a target takes, by name, as text.
    """

    steps_per_mm: float = 1.0
    axis: str = "X"
    unroll: int = 1000
    crystal_hz: int | None = None
    values: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Written:
    """What a writer returns: the lines of the result, the verdicts on the lines of the source, and which wire is which.

    `wiring` has triples: what a wire is for ("output1"), its name at the source, its name at the target; empty: the
    target has none.  `assumed` are pairs of what the writer took for granted of the target, and its value.
    """

    lines: tuple[OutLine, ...]
    verdicts: tuple[LineVerdict, ...]
    wiring: tuple[tuple[str, str, str], ...] = ()
    assumed: tuple[tuple[str, str], ...] = ()


# --------------------------------------------------------------------------------------------------------------- traces
@dataclass(frozen=True, slots=True)
class Happened:
    """Something that a run did, as a proof compares it.

    Attributes:
        kind: a "move" (from rest to rest), a "run" that was stopped (`value` is its sign), an "output" that changed, an
            "input" that was waited for, or a "delay" that was asked for.
        number: of the axis, of the output or of the input, from 1 on.
        value: steps with their sign, or a level; of a delay its ps.
        time_ps: when it began, ps from the start; None: what was read back does not say.
        first_ps: of a move, when its first step was; None: not known.
        lasts_ps: of a move, from its first step to its last one, ps; None: not known.
        rate: of a move, the greatest rate, steps/s; None: not known.
    """

    kind: Literal["move", "run", "output", "input", "delay"]
    number: int
    value: int
    time_ps: int | None = None
    lasts_ps: int | None = None
    rate: float | None = None
    first_ps: int | None = None


@dataclass(frozen=True, slots=True)
class PlayedTrace:
    """What a run did, in order; `ran` says what ran it, such as "rs274"; `stopped` that it was ended from outside."""

    ran: str
    happened: tuple[Happened, ...]
    stopped: bool = False


class ProgramWriter(Protocol):
    """A writer at work on one program."""

    def written(self) -> Written:
        """Return the result."""
        ...


@dataclass(frozen=True, slots=True)
class Target:
    """Something that a program can be translated to, other than our own parts.

    Writer, reader and interpreter are module:name, in the rooms `writers` and `reading_back`; they are imported when
    they are asked for.

    Attributes:
        name: the name that --to takes, "grbl".
        mark: what a comment begins with.
        ending: of its files, ".nc".
        language: what the limits refer to, "grbl 1.1 (documentation)".
        writer: the class that writes a program.
        reader: reads a text back, and shares no code with the writer.
        interpreter: runs a text in the real interpreter of the target; empty: none can be had.
        settings: what --set takes besides the levels of outputs: name and allowed values.
    """

    name: str
    mark: str
    ending: str
    language: str
    writer: str
    reader: str
    interpreter: str = ""
    settings: tuple[tuple[str, str], ...] = ()

    def comment(self, text: str) -> str:
        """Return a comment as a line of its own; empty text gives an empty line."""
        return f"{self.mark}{text}" if text else ""

    def joined(self, line: OutLine) -> str:
        """Return a line of the result with its comment beside it."""
        return "  ".join(filter(None, (line.text, self.comment(line.comment))))

    def write(self, program: Program, options: WriterOptions) -> Written:
        """Return a program in the language of the target."""
        make: Callable[[Target, Program, WriterOptions], ProgramWriter] = found("writers", self.writer)
        return make(self, program, options).written()

    def read_back(self, text: str, options: WriterOptions) -> PlayedTrace:
        """Return what a text does."""
        read: Callable[[str, WriterOptions], PlayedTrace] = found("reading_back", self.reader)
        return read(text, options)

    def ran(self, text: str, options: WriterOptions) -> PlayedTrace | None:
        """Return what a text does in the real interpreter of the target; None: it cannot be run here."""
        if not self.interpreter:
            return None
        run: Callable[[str, WriterOptions], PlayedTrace | None] = found("reading_back", self.interpreter)
        return run(text, options)


def found(room: str, where: str) -> Any:
    """Return what a module of a room has under a name."""
    module, _, name = where.partition(":")
    return getattr(import_module(f".{room}.{module}", __package__), name)
