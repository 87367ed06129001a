"""The interface of a target: a writer for programs in its language, and a reader for proving the result.

A writer goes through `program.lines` in order and returns the lines of the result, each with its source
line; a comment stays next to the code that it was next to in the source.  An action that cannot be
written is reported as a `LineVerdict` with the target's limit and advice to the user, and as a comment
at that line of the result.  `translate` adds the warning at the head of the result, and the report.
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
    """A user's options for the target.

    Attributes:
        steps_per_mm: the number of steps per millimetre, for targets that count millimetres.
        axis: the name of the axis, such as X, for targets that have several axes.
        unroll: the maximum number of lines that a loop may become, if the target has no loops.
        crystal_hz: the crystal of the target, Hz; None: its usual crystal.
        values: other settings of the target, by name, as text.
    """

    steps_per_mm: float = 1.0
    axis: str = "X"
    unroll: int = 1000
    crystal_hz: int | None = None
    values: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Written:
    """The result of a writer: the lines, the verdicts on the source lines, and the wiring.

    `wiring` holds triples: the purpose of a wire ("output1"), its pin in the source, and its pin in the
    target, which is empty if the target has no such pin.  `assumed` holds pairs of a fact about the target
    and its assumed value.
    """

    lines: tuple[OutLine, ...]
    verdicts: tuple[LineVerdict, ...]
    wiring: tuple[tuple[str, str, str], ...] = ()
    assumed: tuple[tuple[str, str], ...] = ()


# --------------------------------------------------------------------------------------------------------------- traces
@dataclass(frozen=True, slots=True)
class Happened:
    """An event of a run, as compared by a proof.

    Attributes:
        kind: a "move" (from standstill to standstill), a "run" that was stopped, an "output" that changed,
            an "input" that the program waited for or that changed, or a "delay" in the program.
        number: the number of the axis, output or input, counted from 1.
        value: for a move, its steps with their sign; for a run, its sign; for an output or input, its
            level; for a delay, its duration, ps.
        time_ps: the time at which the event began, ps from the start; None: not known from the text.
        first_ps: for a move, the time of its first step, ps; None: not known.
        lasts_ps: for a move, the time from its first step to its last, ps; None: not known.
        rate: for a move or a run, the maximum rate, steps/s; None: not known.
        net: for a run, its steps with their sign; None: not known.
    """

    kind: Literal["move", "run", "output", "input", "delay"]
    number: int
    value: int
    time_ps: int | None = None
    lasts_ps: int | None = None
    rate: float | None = None
    first_ps: int | None = None
    net: int | None = None


@dataclass(frozen=True, slots=True)
class PlayedTrace:
    """The events of a run, in order.

    `ran` is the interpreter, such as "rs274"; `stopped` is True if the run was cut off.
    """

    ran: str
    happened: tuple[Happened, ...]
    stopped: bool = False


class ProgramWriter(Protocol):
    """A writer that writes one program in the language of a target."""

    def written(self) -> Written:
        """Return the program in the target's language, with the verdicts and the wiring."""
        ...


@dataclass(frozen=True, slots=True)
class Target:
    """A target of translation other than our own parts.

    Writer, reader and interpreter are given as "module:name", in the packages `writers` and `reading_back`;
    they are imported when they are first needed.

    Attributes:
        name: the argument of --to, such as "grbl".
        mark: the text with which a comment starts.
        ending: the file extension, such as ".nc".
        language: the source of the limits, such as "grbl 1.1 (documentation)".
        writer: the class that writes a program.
        reader: the function that reads a text back; it shares no code with the writer.
        interpreter: the function that runs a text in the target's real interpreter; empty: there is none.
        settings: the arguments of --set other than output levels: pairs of a name and its allowed values.
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
        """Return a text as a comment in the target's language, or an empty line if the text is empty."""
        return f"{self.mark}{text}" if text else ""

    def joined(self, line: OutLine) -> str:
        """Return a line of the result, with its comment at the end."""
        return "  ".join(filter(None, (line.text, self.comment(line.comment))))

    def write(self, program: Program, options: WriterOptions) -> Written:
        """Return a program in the language of the target."""
        make: Callable[[Target, Program, WriterOptions], ProgramWriter] = found("writers", self.writer)
        return make(self, program, options).written()

    def read_back(self, text: str, options: WriterOptions) -> PlayedTrace:
        """Return the events of a text in the target's language, found by the target's reader."""
        read: Callable[[str, WriterOptions], PlayedTrace] = found("reading_back", self.reader)
        return read(text, options)

    def ran(self, text: str, options: WriterOptions) -> PlayedTrace | None:
        """Return the events when the target's real interpreter runs a text; None if it cannot be run here."""
        if not self.interpreter:
            return None
        run: Callable[[str, WriterOptions], PlayedTrace | None] = found("reading_back", self.interpreter)
        return run(text, options)


def found(room: str, where: str) -> Any:
    """Return the object with the name and in the module given by `where`, in the form "module:name".

    The module is in the package `room`.
    """
    module, _, name = where.partition(":")
    return getattr(import_module(f".{room}.{module}", __package__), name)
