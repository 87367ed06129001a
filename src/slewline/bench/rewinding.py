"""Going back in one process: a bench at the present in which inputs were put in at instants of the past.

    journal   ....G....................R..........m.............. now         as it was
    shadow    ....G....................R                                      plays the journal, a rest behind
    rewound                            R..........m..............now          the same bench, with the input at m

A running bench cannot be copied.  So another one plays its journal, far enough behind it that no input comes before it
any more (`ReachablePast.follow`); to go back is to let that one play on, with the new inputs among the old ones.  It
costs what the run has cost since then, however long it was before.  Who needs several goes has several shadows.

The journal of the new bench begins as the old one does, has the new inputs among the entries that follow, and is then
written on.  It is what the new bench has played: another replay gives the same run, to the bit.

Memories.  A shadow keeps the memory of a chip or part in the model, and never touches the file.  With `take_over` the
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
from typing import Any, NamedTuple, cast

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


class Cost(NamedTuple):
    """What going back would cost: entries of the journal, their bytes, about how many seconds of a usual machine."""

    entries: int
    size: int
    seconds: float


def driven(pin: str, level: int | None, at_ps: int) -> dict[str, Any]:
    """Return the entry of a pin that is driven from outside, or released (None), in the first round of an instant."""
    return {"do": "drive", "t": at_ps, "round": 1, "pin": pin, "level": level}


def given(part: str, verb: str, args: Sequence[Any], at_ps: int) -> dict[str, Any]:
    """Return the entry of an input of a chip or a part, in the first round of an instant."""
    plain = [list(arg) if isinstance(arg, bytes) else arg for arg in args]
    return {"do": "input", "t": at_ps, "round": 1, "part": part, "verb": verb, "args": plain}


class ShadowBench:
    """A bench that plays a journal while that is still being written."""

    def __init__(self, path: Path, prepare: Listener | None) -> None:
        self.path, self.prepare = path, prepare
        self.player: Player | None = None
        self.offset = self.lines = 0  # bytes and lines of the journal that it has played
        self.known = Survey(0, "", 0, {}, {}, {})

    @property
    def now_ps(self) -> int:
        """Where it stands (ps); -1: it has not begun."""
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


class ReachablePast:
    """The past of a bench that has a journal, from which others begin.

    Args:
        path: the journal, which is still written.
        prepare: called with each shadow, before time passes in it: to listen to it.
        shadows: how many times one can go back before a shadow has to begin again.
    """

    def __init__(self, path: str | PathLike[str], prepare: Listener | None = None, shadows: int = 2) -> None:
        self.path, self.prepare, self.most = Path(path), prepare, shadows
        self.shadows: list[ShadowBench] = []
        self.entry_s = ENTRY_S  # what an entry costs; who has a clock knows better

    def follow(self, to_ps: int, enough: Callable[[], bool] = lambda: False) -> bool:
        """Let the shadows play on up to an instant after which alone inputs may have to be put in, such as a rest.

        It must be over: the journal has all that it will ever have of it.

        Args:
            enough: asked after each entry whether the rest has to wait for another call.

        Returns:
            False: the rest waits.
        """
        while len(self.shadows) < self.most:
            self.shadows.append(ShadowBench(self.path, self.prepare))
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

    def cost(self, at_ps: int) -> Cost:
        """Return what it would cost to go back to an instant (ps)."""
        return self._cost(self._chosen(at_ps, False))

    def _cost(self, shadow: ShadowBench) -> Cost:
        with open(self.path, "rb") as file:
            file.seek(shadow.offset)
            rest = file.read()
        entries = rest.count(b"\n")
        return Cost(entries, len(rest), entries * self.entry_s)

    def _chosen(self, at_ps: int, take: bool) -> ShadowBench:
        """The shadow that stands next before an instant; a new one, if there is none."""
        fitting = [each for each in self.shadows if each.now_ps < at_ps]
        if not fitting:
            return ShadowBench(self.path, self.prepare)
        found = max(fitting, key=lambda each: each.now_ps)
        if take:
            self.shadows.remove(found)
        return found

    def rewound(
        self,
        inputs: Sequence[Entry],
        to_ps: int,
        copy: str | PathLike[str],
        *,
        without: Collection[int] = (),
        allowed_s: float | None = None,
    ) -> Bench:
        """Return another bench at an instant, the present one, as if there had been other inputs.

        Everything is as the journal says, with these inputs at their instants: those of the first round of an instant
        stand before what was put in after it.  The bench of the journal stays as it is, and so do memories in files.

        Args:
            inputs: entries of a journal, as `driven` and `given` make them.
            to_ps: the present.
            copy: the journal of the new bench.
            without: entries of the journal that are left out, each by the byte at which its line begins.
            allowed_s: seconds of a usual machine that it may cost.

        Raises:
            TooLong: it would cost more.
            UsageError: no input, or one that is not between the beginning and the present.
            BenchFileError: an entry cannot be done, an old one perhaps because of the new ones; or `copy` is a file
                that is not a journal, or cannot be written.
        """
        more = sorted(inputs, key=lambda entry: int(entry["t"]))
        marks = [int(entry["t"]) for entry in more] + [self._instant(offset) for offset in without]
        if not marks:
            raise UsageError("going back: no input; give at least one")
        for at in marks:
            if not 0 < at <= to_ps:
                raise UsageError(f"going back: an input at {readable(at)}; allowed: after 0, up to {readable(to_ps)}")
        shadow = self._chosen(min(marks), False)
        cost = self._cost(shadow)
        if allowed_s is not None and cost.seconds > allowed_s:
            raise TooLong(
                f"going back to {readable(min(marks))}: {cost.entries} inputs ({cost.size} bytes of journal) would "
                f"have to be done again, about {cost.seconds:.3f} s; allowed {allowed_s:.3f} s"
            )
        replaced(copy)
        shadow = self._chosen(min(marks), True)
        try:
            self._write(Path(copy), shadow.offset, more, without)
            shadow.path = Path(copy)
            shadow.follow(to_ps)
        except BaseException:
            with suppress(OSError):
                os.unlink(copy)
            raise
        bench = cast("Player", shadow.player).bench
        bench.catch_up()
        journal = Journal.continued(copy, bench.kernel)
        object.__setattr__(bench, "journal", journal)  # users may not
        bench.kernel.outside.write = journal.write
        return bench

    def _instant(self, offset: int) -> int:
        """The instant of an entry of the journal (ps)."""
        with open(self.path, "rb") as file:
            file.seek(offset)
            return int(json.loads(file.readline())["t"])

    def entries(self) -> Iterator[tuple[int, Entry]]:
        """Yield what is in the journal since the latest shadow, each entry with the byte at which its line begins."""
        at = max((each.offset for each in self.shadows), default=0)
        with open(self.path, "rb") as file:
            file.seek(at)
            for line in file:
                yield at, json.loads(line)
                at += len(line)

    def _write(self, copy: Path, shared: int, more: Sequence[Entry], without: Collection[int]) -> None:
        """Write a journal: what is shared as it is, then the entries of both, by time."""
        waiting = [*more]
        with open(self.path, "rb") as source, open(copy, "wb") as target:
            target.write(source.read(shared))
            at = shared
            for line in source:
                if line.endswith(b"\n") and at not in without:
                    entry = json.loads(line)
                    while waiting and place(waiting[0]) < place(entry):
                        target.write(spelled(waiting.pop(0)))
                    target.write(line)
                at += len(line)
            target.writelines(map(spelled, waiting))

    def moved(self, path: Path) -> None:
        """Follow another journal from now on, of a bench that has begun here and taken over from that before."""
        self.path = path
        for each in self.shadows:
            each.path = path


def place(entry: Entry) -> tuple[int, bool]:
    """Return what entries are sorted by: the instant, and whether it is not in its first round."""
    return int(entry.get("t", 0)), entry.get("round") != 1


def spelled(entry: Entry) -> bytes:
    """Return the line of an entry."""
    return json.dumps(dict(entry), separators=(",", ":")).encode("ascii") + b"\n"


def take_over(bench: Bench, old: Bench) -> None:
    """Let a bench that was gone back to have what the other one had outside: its memories, and the file of its journal.

    The journal in which inputs were put in has the name of the old one then, where the system can rename it.

    Raises:
        OSError: a memory has refused its content; nothing was taken over.
    """
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
