"""Replacement of the served bench, while all connections stay open.

Hosts stay connected and notice no change.  The new bench has replayed the journal, which also contains the bytes
that are still on their way from a host to a chip.  The output of the new bench during the replay is recorded
(`LineTap`), and the part of it that a host has not received is sent (`lines/outlet.py`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from ..lines.outlet import SentBytes
from ..lines.served_line import Act, ConnectorLine, HostLine

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.wires.receiver import Character

KEPT_STRETCHES = 10_000  # history of each axis; a server runs for months
KEEP = "1 h"  # history of recorded pins


class LineTap:
    """A recorder of the output that a replaying bench would send on one line.

    On the served bench, the line has already performed actions on the part at its end; the recorder
    repeats each of them on the part of the same name on the replaying bench.
    """

    def __init__(self, line: HostLine, bench: Bench) -> None:
        self.line, self.kernel, self.part = line, bench.kernel, bench.parts[line.part.name]
        self.sent: list[SentBytes] = []  # or it is still in transit: its instant is in the future
        self.inputs = self.acted = 0  # inputs of the part, and actions after them
        self.result: Any = None  # of the last one
        self.live = False  # the line ends in this part
        if isinstance(line, ConnectorLine):
            self.part.on_character.add(self._character)  # type: ignore[attr-defined]

    def _character(self, character: Character) -> None:
        if not self.live:
            self.part.uart.discard()  # type: ignore[attr-defined]
            self.sent.append(SentBytes(character.end_ps, bytes([character.byte])))

    def done(self, entry: Mapping[str, Any], result: Any) -> None:
        """Record a journal entry that has been executed, and its result, if the entry is an input to the part."""
        if self.live or entry["do"] != "input" or entry["part"] != self.part.name:
            return
        self.inputs += 1
        self.result = result

    @property
    def next(self) -> Act | None:
        """Next action of the line to repeat on the part.

        None if there is no such action, or if it must follow an input that has not been replayed yet.
        """
        acts = self.line.acts
        if self.live or acts is None or self.acted >= acts.number:
            return None
        self.acted = max(self.acted, acts.number - len(acts.done))  # discarded actions are not performed any more
        if self.acted == acts.number:
            return None
        found = acts.done[self.acted - acts.number]
        return found if found.inputs <= self.inputs else None

    def act(self) -> None:
        """Perform the next action, if there is one."""
        found = self.next
        if found is not None:
            self.acted += 1
            found.do(self.part, self.result, self.say)

    def say(self, data: bytes, to: object) -> None:
        """Record an answer to the host `to`, or send it to that host if the line is already connected to this part."""
        if self.live:
            self.line.give(data, to)
        else:
            self.sent.append(SentBytes(self.kernel.now, data, to))


class LineTaps:
    """The output recorders (`LineTap`) of all lines, for a bench that replays the past."""

    def __init__(self, taps: Mapping[str, LineTap]) -> None:
        self.taps = taps

    def done(self, entry: Mapping[str, Any], result: Any) -> None:
        """Record a journal entry that has been executed, and its result."""
        for ear in self.taps.values():
            ear.done(entry, result)

    def due(self, to_ps: int) -> tuple[int, Callable[[], object]] | None:
        """Return the instant (ps) and the function of the earliest action of any line up to `to_ps`, or None."""
        found = [(act.ps, ear) for ear in self.taps.values() if (act := ear.next) is not None and act.ps <= to_ps]
        if not found:
            return None
        at, ear = min(found, key=lambda each: each[0])
        return at, ear.act


def limit_kept(bench: Bench) -> None:
    """Limit the history that a bench keeps of its axes, so that a server can run for months."""
    for chip in bench.chips.values():
        for number, motor in enumerate(chip.axes, 1):
            motor.kept.limit(chip.axis(number).name, stretches=KEPT_STRETCHES)


def record_same(bench: Bench, other: Bench) -> None:
    """Start to record, on `bench`, all pins that are recorded on `other`."""
    if missing := [name for name in other.recorded if name not in bench.recorded]:
        bench.record(*missing, keep=KEEP)
