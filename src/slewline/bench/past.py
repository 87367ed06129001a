"""The past of a bench that writes a journal: `Past.at(t)` brings it back, in one process.

    past.at(t).rerun(inputs, now)   another bench at the present, the same before t, with other inputs from t on
    past.go_on(bench, t)            take it in place of the present one

    journal   ....G....................R..........m.............. now         as it was written
    shadow    ....G....................R                                      plays the journal, a rest later
    rerun                              R..........m..............now          the same bench, with the input at m

A running bench cannot be copied.  So another one plays its journal, far enough after it that no input comes before it
any more (`Past.follow`); to go back is to let that one play on, with the new inputs among the old ones.  It
costs what the run has cost since then, however long it was before.  Each new run needs a shadow of its own.

A server has a second way back, into a process of its own: `links/time/server_past.py`.

The journal of the new bench begins as the old one does, has the new inputs among the entries that follow, and is then
written on.  It is what the new bench has played: another replay gives the same run, to the bit.

Memories.  A shadow keeps the memory of a chip or part in the model, and never touches the file.  After `go_on` the
file is its own; it is written only if it holds something else: what was stored in the past that is undone, and is
stored again in the same way, is not written twice, what the new run did not store is no longer there, and what only it
has stored is there then.  What a disk has refused is refused again, at the same call of the owner.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any, cast

from ..core.memory.store import JournaledStore, ReplayedStore
from ..core.time.timebase import readable
from ..errors import SlewlineError, UsageError
from ..gate import FileGate
from .bench import Bench
from .files.entries import Entries
from .files.journal import Journal, replaced
from .replaying import Player, Survey, survey

Entry = Mapping[str, Any]
ENTRY_S = 0.001  # of a usual machine, for an entry: half a CY525 move, two commands of a module
Listener = Callable[[Bench], object]


class TooLong(UsageError):
    """Going back would cost more time than is allowed; nothing was done."""


def driven(pin: str, level: int | None, at_ps: int) -> dict[str, Any]:
    """Return the entry of a pin that is driven from outside, or released (None), in the first round of an instant."""
    return {"do": "drive", "t": at_ps, "round": 1, "pin": pin, "level": level}


def given(part: str, verb: str, args: Sequence[Any], at_ps: int) -> dict[str, Any]:
    """Return the entry of an input of a chip or a part, in the first round of an instant."""
    plain = [list(arg) if isinstance(arg, bytes) else arg for arg in args]
    return {"do": "input", "t": at_ps, "round": 1, "part": part, "verb": verb, "args": plain}


class ShadowBench:
    """A bench that plays a journal while that is still being written."""

    def __init__(self, path: Path, prepare: Listener) -> None:
        self.path, self.prepare = path, prepare
        self.player: Player | None = None
        self.offset = self.lines = 0  # bytes and lines of the journal that it has played
        self.known = Survey(0, "", 0, {}, {}, {})

    @property
    def now_ps(self) -> int:
        """The instant that it has reached (ps); -1: it has not begun."""
        return -1 if self.player is None else self.player.bench.now_ps

    def follow(self, to_ps: int, enough: Callable[[], bool] = lambda: False) -> bool:
        """Play on up to an instant; return False, before that, when `enough` does not return false after an entry.

        Raises:
            BenchFileError: an entry that cannot be done.
        """
        found = Entries(self.path, self.offset, self.lines)
        with closing(found.file):
            self._learn(survey(found, FileGate(self.path, allow_code=True)))
            player = self.player
            if player is None:
                player = self.player = Player(Bench(seed=self.known.seed), self.prepare)
                player.kept = partial(self._kept, player.bench)
            number = self.lines
            for number, entry in found:
                if entry["t"] > to_ps:
                    break
                player.take(found, self.known, number, dict(entry))
                self.offset, self.lines = found.file.tell(), number
                if enough():
                    return False
            player.begin()
            player.end(found, number, max(to_ps, player.bench.now_ps))
        return True

    def _learn(self, more: Survey) -> None:
        known = self.known
        for owner, faults in more.faults.items():
            known.faults.setdefault(owner, {}).update(faults)  # a memory that is there already gets them, too
        known.chips.update(more.chips)
        known.behaviours.update(more.behaviours)
        if not self.offset:
            self.known = known._replace(seed=more.seed, maker=more.maker)

    def _kept(self, bench: Bench, name: str, memory: ReplayedStore) -> JournaledStore:
        faults = self.known.faults.setdefault(name, {})
        return JournaledStore(ReplayedStore(memory.data, faults), partial(bench._circuit._tell_journal, name))


class Past:
    """The past of a bench that has a journal, from which others begin.

    Args:
        bench: the present one; that of `go_on` later.
        shadows: how many times one can go back before a shadow has to begin again.
    """

    def __init__(self, bench: Bench, shadows: int = 3) -> None:
        self.bench, self.most = bench, shadows
        self.shadows: list[ShadowBench] = []
        self.entry_s = ENTRY_S  # what an entry costs; who has a clock knows better

    @property
    def path(self) -> Path:
        """The journal, which is still written.

        Raises:
            UsageError: there is none.
        """
        if self.bench.journal is None:
            raise UsageError('going back needs a journal: Bench(journal="FILE")')
        return self.bench.journal.path

    def at(self, ps: int) -> Instant:
        """Return an instant of the past (ps)."""
        return Instant(self, ps)

    def listen(self, bench: Bench) -> object:
        """Follow what a bench does that plays the past, before it does anything; return what accompanies it."""

    def follow(self, to_ps: int, enough: Callable[[], bool] = lambda: False) -> bool:
        """Let the shadows play on up to an instant after which alone inputs may have to be put in, such as a rest.

        It must be over: the journal has all that it will ever have of it.

        Args:
            enough: asked after each entry whether the rest has to wait for another call.

        Returns:
            False: the rest waits.
        """
        while len(self.shadows) < self.most:
            self.shadows.append(ShadowBench(self.path, self.listen))
        try:
            return all([each.follow(to_ps, enough) for each in self.shadows if each.now_ps < to_ps])
        except SlewlineError:
            self.shadows.clear()
            raise

    @property
    def since_ps(self) -> int:
        """The instant at which a shadow is ready, the latest one (ps); -1: there is none."""
        return max((each.now_ps for each in self.shadows), default=-1)

    @property
    def played(self) -> int:
        """How many entries the shadows have played, all together."""
        return sum(each.lines for each in self.shadows)

    def entries(self) -> Iterator[tuple[int, Entry]]:
        """Yield what is in the journal since the latest shadow, each entry with the byte at which its line begins."""
        at = max((each.offset for each in self.shadows), default=0)
        with open(self.path, "rb") as file:
            file.seek(at)
            for line in file:
                yield at, json.loads(line)
                at += len(line)

    def go_on(self, bench: Bench, since_ps: int = 0) -> None:
        """Go on with another bench, which did the same as the present one before an instant (ps).

        It gets what that one has outside: its memories, and the name of its journal, where the system can rename it.

        Raises:
            OSError: a memory has refused its content; nothing has changed.
        """
        _take_over(bench, self.bench)
        self.bench = bench
        if bench.journal is not None:
            for each in self.shadows:
                each.path = bench.journal.path


class Instant:
    """An instant of the past of a bench (ps), from which on another run goes on."""

    def __init__(self, past: Past, ps: int) -> None:
        self.past, self.ps = past, ps

    def rerun(
        self,
        inputs: Sequence[Entry],
        to_ps: int,
        copy: str | PathLike[str] | None = None,
        *,
        without: Collection[int] = (),
        allowed_s: float | None = None,
    ) -> Bench:
        """Return another bench at the present, as if there had been other inputs from this instant on.

        Everything is as the journal says, with these inputs at their instants: those of the first round of an instant
        come before what was put in after it.  The present bench is unchanged, and so are memories in files.

        Args:
            inputs: entries of a journal, as `driven` and `given` make them.
            to_ps: the present.
            copy: the journal of the new bench, by default beside the present one.
            without: entries of the journal that are left out, each by the byte at which its line begins.
            allowed_s: seconds of a usual machine that it may cost.

        Raises:
            TooLong: it would cost more.
            UsageError: no input, or one that is not between the beginning and the present.
            BenchFileError: an entry cannot be done, an old one perhaps because of the new ones; or `copy` is a file
                that is not a journal, or cannot be written.
        """
        more = sorted(inputs, key=lambda entry: int(entry["t"]))
        if not (more or without):
            raise UsageError("going back: no input; give at least one")
        marks = [self.ps, *(int(entry["t"]) for entry in more), *map(self._instant, without)]
        for at in marks:
            if not 0 < at <= to_ps:
                raise UsageError(f"going back: an input at {readable(at)}; allowed: after 0, up to {readable(to_ps)}")
        past, first, other = self.past, min(marks), Path(f"{self.past.path}.other" if copy is None else copy)
        fitting = [each for each in past.shadows if each.now_ps < first]
        shadow = max(fitting, key=lambda each: each.now_ps, default=None) or ShadowBench(past.path, past.listen)
        with open(past.path, "rb") as file:
            shared, rest = file.read(shadow.offset), file.read()
        entries = rest.count(b"\n")
        seconds = entries * past.entry_s
        if allowed_s is not None and seconds > allowed_s:
            raise TooLong(
                f"going back to {readable(first)}: {entries} inputs ({len(rest)} bytes of journal) would "
                f"have to be done again, about {seconds:.3f} s; allowed {allowed_s:.3f} s"
            )
        replaced(other)
        past.shadows = [each for each in past.shadows if each is not shadow]
        try:
            with open(other, "wb") as target:
                target.write(shared)
                target.writelines(merged(rest, len(shared), more, without))
            shadow.path = other
            shadow.follow(to_ps)
        except BaseException:
            with suppress(OSError):
                os.unlink(other)
            raise
        bench = cast("Player", shadow.player).bench
        bench.catch_up()
        journal = Journal.continued(other, bench.kernel)
        object.__setattr__(bench, "journal", journal)  # users may not
        bench.kernel.outside.write = journal.write
        return bench

    def _instant(self, offset: int) -> int:
        """The instant of an entry of the journal (ps)."""
        with open(self.past.path, "rb") as file:
            file.seek(offset)
            return int(json.loads(file.readline())["t"])


def merged(rest: bytes, at: int, more: list[Entry], without: Collection[int]) -> Iterator[bytes]:
    """Yield the lines of a journal from a byte on, with more entries among them, by time."""
    for line in rest.splitlines(keepends=True):
        if line.endswith(b"\n") and at not in without:
            entry = json.loads(line)
            while more and place(more[0]) < place(entry):
                yield spelled(more.pop(0))
            yield line
        at += len(line)
    yield from map(spelled, more)


def place(entry: Entry) -> tuple[int, bool]:
    """Return what entries are sorted by: the instant, and whether it is not in its first round."""
    return int(entry.get("t", 0)), entry.get("round") != 1


def spelled(entry: Entry) -> bytes:
    """Return the line of an entry."""
    return json.dumps(dict(entry), separators=(",", ":")).encode("ascii") + b"\n"


def _take_over(bench: Bench, old: Bench) -> None:
    """Let a bench have what another one has outside, as `Past.go_on` describes."""
    attached: list[tuple[JournaledStore, Any, Any, bytes]] = []
    try:
        for name in (*bench.chips, *bench.parts):
            store, theirs = getattr(bench[name], "store", None), getattr(old[name], "store", None)
            if isinstance(store, JournaledStore) and isinstance(theirs, JournaledStore):
                real, before = theirs.store, theirs.store.read()
                attached.append((store, store.store, real, before))
                store.attach(real)
    except OSError:
        for store, inner, real, before in attached:
            store.store = inner
            with suppress(OSError):
                if real.read() != before:
                    real.write(before)
        raise
    for name in (*old.chips, *old.parts):
        theirs = getattr(old[name], "store", None)
        if isinstance(theirs, JournaledStore):
            theirs.detach({})
    old.kernel.outside.write = None
    if old.journal is None or bench.journal is None:
        return
    old.journal.close()
    with suppress(OSError):
        os.replace(bench.journal.path, old.journal.path)
        bench.journal.path = old.journal.path
