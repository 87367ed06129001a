"""Surroundings of a program that is read back: its inputs, and the record of its events."""

from __future__ import annotations

from ..target_writer import Happened, PlayedTrace, WriterOptions

MOST_EVENTS = 5_000
MOST_STATEMENTS = 100_000
MOST_CHANGES = 16  # maximum number of input changes
IDLE_STATEMENTS = 250  # statements without an event after which the program is waiting


class RefusedLine(Exception):
    """A line that the target would not accept: its number, its text, and the reason."""

    def __init__(self, line: int, text: str, reason: str) -> None:
        super().__init__(f"line {line}: {text.strip()}: {reason}")


class Enough(Exception):
    """An exception that interrupts an endless program; the events recorded so far are the program's trace."""


class Surroundings:
    """The inputs, the position of each axis, and the events of a program that is read back.

    `options.values["inputs"]` lists the levels at the start: "1=0 3=1"; all other inputs are high, like
    open inputs.  `options.values["waits"]` lists the inputs that change, one after another, whenever the
    program only waits: "1 2"; if empty, a wait ends immediately.  `options.values["events"]` is the number
    of events after which a program without end is cut off.
    """

    def __init__(self, options: WriterOptions) -> None:
        self.steps_per_mm = options.steps_per_mm
        self.levels: dict[int, int] = {}
        for pair in options.values.get("inputs", "").split():
            number, _, level = pair.partition("=")
            self.levels[int(number)] = int(level)
        self.waits = [int(each) for each in options.values.get("waits", "").split()]
        self.position: dict[int, int] = {}  # in steps since the start, regardless of presets
        self.outputs: dict[int, int] = {}
        self.happened: list[Happened] = []
        self._most = int(options.values.get("events", MOST_EVENTS))
        self._statements = self._changes = 0
        self._active = (0, 0)  # numbers of statements and events at the last event

    def statement(self) -> None:
        """Count a statement; after many statements without an event, let an input change.

        Raises:
            Enough: the number of statements, events or input changes shows that the program has no end.
        """
        self._statements += 1
        if self._statements > MOST_STATEMENTS or len(self.happened) >= self._most:
            raise Enough
        if self._active[1] != len(self.happened):
            self._active = (self._statements, len(self.happened))
        if self.waits and self._statements - self._active[0] > IDLE_STATEMENTS:
            self._change()

    def level(self, number: int) -> int:
        """Return the level of an input."""
        return self.levels.get(number, 1)

    def wait(self, number: int, level: int) -> None:
        """Invert the inputs in the list `waits`, one after another, until an input is at `level`.

        If the list is empty, record that the input has this level, and end the wait immediately.

        Raises:
            Enough: the input never has this level.
        """
        if not self.waits:
            self.happened.append(Happened("input", number, level))
            return
        while self.level(number) != level:
            self._change()

    def _change(self) -> None:
        """Invert the level of the next input in the list of inputs that change."""
        if self._changes >= MOST_CHANGES:
            raise Enough
        number = self.waits[self._changes % len(self.waits)]
        self._changes += 1
        self.levels[number] = 1 - self.level(number)
        self.happened.append(Happened("input", number, self.levels[number]))

    def run(self, axis: int, sign: int) -> None:
        """Record a motion in direction `sign`; an input, rather than the program, determines its end."""
        self.happened.append(Happened("run", axis, sign))

    def move(self, axis: int, steps: int, rate: float | None = None) -> None:
        """Record a move from standstill to standstill; `steps` has a sign; `rate` is the maximum rate, steps/s."""
        if steps:
            self.position[axis] = self.position.get(axis, 0) + steps
            self.happened.append(Happened("move", axis, steps, rate=rate))

    def output(self, number: int, level: int) -> None:
        """Record a change of an output; the first setting of an output is its initial state, and is not recorded."""
        if self.outputs.setdefault(number, level) != level:
            self.outputs[number] = level
            self.happened.append(Happened("output", number, level))

    def delay(self, ps: int) -> None:
        """Record a delay of `ps`, unless it is 0."""
        if ps:
            self.happened.append(Happened("delay", 1, ps))

    def trace(self, ran: str, stopped: bool = False) -> PlayedTrace:
        """Return the recorded events as a trace.

        Args:
            ran: the name of the interpreter.
            stopped: whether the run was cut off.
        """
        return PlayedTrace(ran, tuple(self.happened), stopped)
