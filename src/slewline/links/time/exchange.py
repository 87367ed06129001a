"""Another bench in the place of the one that is served, with which everything goes on that is connected.

    server.exchanges.listen(bench)       each bench that may be the next one, while it still plays the past
    server.exchanges.forget(instant)     no other bench begins before that
    server.exchange(bench)               at the present, which is the same in both

Hosts stay connected and notice nothing: bytes on their way in are inputs of the journal that the new bench has played;
what it has said meanwhile is known (`Ear`), and what a host lacks of that goes out (`lines/outlet.py`).  Pace, log,
views, breakpoints, waits of clients and the way back go on with chips and parts of the same names.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

from ...bench.rewinding import take_over
from ...core.time.timebase import readable
from ...errors import UsageError
from ..lines.line import Act, Acts, ConnectorLine, HostLine
from ..lines.outlet import Told

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.time.kernel import Kernel
    from ...core.wires.serial import Character
    from ..face import ServerFace

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


class Exchanges:
    """Puts other benches in the place of the one that is served."""

    def __init__(self, server: ServerFace) -> None:
        self.server = server
        self.ears: WeakKeyDictionary[Kernel, dict[str, Ear]] = WeakKeyDictionary()
        self.others: list[Bench] = []  # to which one listens

    def begin(self) -> None:
        """Remember from now on what has to be known of the past: before the first bench is listened to."""
        server = self.server
        for line in server.lines.values():
            line.outlet.remember(server.bench.now_ps)
            if line.acts is None and not isinstance(line, ConnectorLine):
                line.acts = Acts(line.part.name)
                server.bench.on_input.add(line.acts.heard)

    def listen(self, bench: Bench) -> Ears:
        """Listen to a bench that plays the journal of the one that is served: before time passes in it.

        Returns:
            what accompanies it.
        """
        self.begin()
        limit_kept(bench)
        ears = self.ears[bench.kernel] = {name: Ear(line, bench) for name, line in self.server.lines.items()}
        self.others.append(bench)
        return Ears(ears)

    def forget(self, before_ps: int) -> None:
        """Forget what was said up to an instant (ps), which all benches have reached to which one listens."""
        self.others = [bench for bench in self.others if bench.kernel in self.ears]
        for line in self.server.lines.values():
            line.outlet.forget(before_ps)
            if line.acts is not None:
                line.acts.forget(before_ps)
        for bench in self.others:
            record_same(bench, self.server.bench)
            for ear in self.ears[bench.kernel].values():
                ear.said = [told for told in ear.said if told.ps > before_ps]

    def drop(self, bench: Bench) -> None:
        """Listen to a bench no longer: it will not be served."""
        self.ears.pop(bench.kernel, None)
        self.others = [other for other in self.others if other is not bench]

    # ----------------------------------------------------------------------------------------------------- the exchange
    def exchange(self, bench: Bench, since_ps: int) -> None:
        """Serve another bench from now on: `Server.exchange`."""
        server, old = self.server, self.server.bench
        self._check(bench)
        before = [found for found in old.findings if found.time_ps >= since_ps]
        ears = self.ears.get(bench.kernel) or {name: Ear(line, bench) for name, line in server.lines.items()}
        take_over(bench, old)
        self.drop(bench)
        limit_kept(bench)
        record_same(bench, old)
        server.bench = bench
        server.pace.move(bench)
        server.log.move(bench.kernel)
        for name, line in server.lines.items():
            self._move(line, bench, ears[name])
        server.furnish(bench)
        server.views.move(bench)
        server.breakpoints.move(bench)
        server.travel.move(bench, since_ps)
        for wait in server.pace.waits:
            if wait.renew is not None:
                wait.end()
                wait.renew()
                wait.begin()
        told = Counter((found.source, found.code, found.text) for found in before)
        for found in [each for each in bench.findings if each.time_ps >= since_ps]:
            key = found.source, found.code, found.text
            told[key] -= 1
            if told[key] < 0:
                server.finding(found)

    def _check(self, bench: Bench) -> None:
        """Check that a bench can take the place.

        Raises:
            UsageError: it is at another instant, or lacks a chip or part; or another branch is shown.
        """
        old = self.server.bench
        if bench.now_ps != old.now_ps:
            raise UsageError(
                f"exchange: the other bench is at {readable(bench.now_ps)}; allowed the present, {readable(old.now_ps)}"
            )
        missing = [name for name in (*old.chips, *old.parts) if name not in bench]
        if missing:
            raise UsageError(
                f"exchange: the other bench lacks {', '.join(missing)}; it must have the same chips and parts"
            )
        if self.server.travel.current:
            raise UsageError(
                f"exchange: branch {self.server.travel.current} is shown, where this bench stands; show branch 0 first"
            )

    def _move(self, line: HostLine, bench: Bench, ear: Ear) -> None:
        """Let a line end on another bench; what its host lacks of what was said there goes out."""
        now = bench.now_ps
        if line.acts is not None:
            with suppress(UsageError):
                self.server.bench.on_input.remove(line.acts.heard)
            bench.on_input.add(line.acts.heard)
            line.acts.inputs = max(line.acts.inputs, ear.inputs)
        ear.live = True
        line.move(bench, [told for told in ear.said if told.ps > now])
        unsaid = line.outlet.say_again([told for told in ear.said if told.ps <= now])
        if unsaid:
            self.server.log.event(line.name, f"the host has had what was taken back: {unsaid!r}")


def limit_kept(bench: Bench) -> None:
    """Let the axes of a bench keep no more of their past than a server that runs for months needs."""
    for chip in bench.chips.values():
        for number, motor in enumerate(chip.axes, 1):
            motor.kept.limit(chip.axis(number).name, stretches=KEPT_STRETCHES)


def record_same(bench: Bench, other: Bench) -> None:
    """Record the pins that are recorded on another bench."""
    if missing := [name for name in other.recorded if name not in bench.recorded]:
        bench.record(*missing, keep=KEEP)
