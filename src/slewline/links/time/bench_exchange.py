"""Another bench in the place of the one that is served, with which everything goes on that is connected.

Hosts stay connected and notice nothing: bytes on their way in are inputs of the journal that the new bench has played;
what it has said meanwhile is known (`Ear`), and what a host lacks of that goes out (`lines/outlet.py`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from ..lines.outlet import Told
from ..lines.served_line import Act, ConnectorLine, HostLine

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.wires.characters import Character

KEPT_STRETCHES = 10_000  # of the past of each axis; a server runs for months
KEEP = "1 h"  # of pins that are recorded


class Ear:
    """What another bench says on a line.

    It does to its part what the line has done to that of the bench that is served, and what is said is kept.
    """

    def __init__(self, line: HostLine, bench: Bench) -> None:
        self.line, self.kernel, self.part = line, bench.kernel, bench.parts[line.part.name]
        self.said: list[Told] = []  # or is still on its way: its instant is then to come
        self.inputs = self.acted = 0  # inputs of the part, and acts behind them
        self.result: Any = None  # of the last one
        self.live = False  # the line ends in this part
        if isinstance(line, ConnectorLine):
            self.part.on_character.add(self._character)  # type: ignore[attr-defined]

    def _character(self, character: Character) -> None:
        if not self.live:
            self.part.received.clear()  # type: ignore[attr-defined]
            self.said.append(Told(character.end_ps, bytes([character.byte])))

    def done(self, entry: Mapping[str, Any], result: Any) -> None:
        """Take notice of an input, and of what it has returned; do what stood behind it."""
        if self.live or entry["do"] != "input" or entry["part"] != self.part.name:
            return
        self.inputs += 1
        self.result = result

    @property
    def next(self) -> Act | None:
        """What the line has done to its part next, if no other input stands before it."""
        acts = self.line.acts
        if self.live or acts is None or self.acted >= acts.number:
            return None
        self.acted = max(self.acted, acts.number - len(acts.done))  # what is forgotten is not done any more
        if self.acted == acts.number:
            return None
        found = acts.done[self.acted - acts.number]
        return found if found.inputs <= self.inputs else None

    def act(self) -> None:
        """Do that."""
        found = self.next
        if found is not None:
            self.acted += 1
            found.do(self.part, self.result, self.say)

    def say(self, data: bytes, to: object) -> None:
        """Take an answer."""
        if self.live:
            self.line.give(data, to)
        else:
            self.said.append(Told(self.kernel.now, data, to))


class Ears:
    """Those on all lines of a bench that plays the past."""

    def __init__(self, ears: Mapping[str, Ear]) -> None:
        self.ears = ears

    def done(self, entry: Mapping[str, Any], result: Any) -> None:
        """Take notice of an entry that has been done."""
        for ear in self.ears.values():
            ear.done(entry, result)

    def due(self, to_ps: int) -> tuple[int, Callable[[], object]] | None:
        """Return what a line has done next, and when, if that is up to an instant (ps)."""
        found = [(act.ps, ear) for ear in self.ears.values() if (act := ear.next) is not None and act.ps <= to_ps]
        if not found:
            return None
        at, ear = min(found, key=lambda each: each[0])
        return at, ear.act


def limit_kept(bench: Bench) -> None:
    """Let the axes of a bench keep no more of their past than a server that runs for months needs."""
    for chip in bench.chips.values():
        for number, motor in enumerate(chip.axes, 1):
            motor.kept.limit(chip.axis(number).name, stretches=KEPT_STRETCHES)


def record_same(bench: Bench, other: Bench) -> None:
    """Record the pins that are recorded on another bench."""
    if missing := [name for name in other.recorded if name not in bench.recorded]:
        bench.record(*missing, keep=KEEP)
