"""The past of a bench with a journal: `Past.at(t)` goes back to an earlier instant, in the same process.

    past.at(t).rerun(inputs, now)   another bench, run up to now, with other inputs from t on
    past.go_on(bench, t)            use that bench instead of the present one

    journal   ....G....................R..........m.............. now         as recorded
    shadow    ....G....................R                                      plays the journal, with a delay
    rerun                              R..........m..............now          the same bench, with the input at m
    (G, R: recorded inputs; m: the instant of a new one)

A running bench cannot be copied.  Therefore a second bench, the shadow, plays the journal of the
first with a delay, so that it never passes an instant at which an input may still be inserted
(`Past.follow`).  To change the past, the shadow plays on (from R above), with the new inputs
inserted among the old ones.  The cost is that of the run from that point on, regardless of how long
the bench ran before.  Each new run uses up one shadow.

A server can also go back in another process: `links/time/server_past.py`.

The journal of the new bench begins like the old one, contains the new inputs among the entries that
follow, and is then continued.  It records exactly the inputs that the new bench has played:
replaying it repeats the same run bit for bit.

Memories.  A shadow keeps the memory of a chip or part in the model, and never touches its
file.  With `go_on` the new bench takes over that file.  The content that the new run has stored is
then written to the file, unless the file has this content already.  If a disk refused a write in
the old run, the write is refused again when the owner of the memory makes the same call in the new
run.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
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
ENTRY_S = 0.001  # on a typical machine, per entry: half a CY525 move, two commands of a module
Listener = Callable[[Bench], object]


class TooLong(UsageError):
    """A refusal to go back, because it would take longer than allowed; nothing was changed."""


def driven(pin: str, level: int | None, at_ps: int) -> dict[str, Any]:
    """Return the journal entry that drives a pin, or releases it (`level` None), in an instant's first round."""
    return {"do": "drive", "t": at_ps, "round": 1, "pin": pin, "level": level}


def given(part: str, verb: str, args: Sequence[Any], at_ps: int) -> dict[str, Any]:
    """Return the journal entry for an input to a chip or part, in the first round of an instant."""
    plain = [list(arg) if isinstance(arg, bytes) else arg for arg in args]
    return {"do": "input", "t": at_ps, "round": 1, "part": part, "verb": verb, "args": plain}


class ShadowBench:
    """A bench that plays a journal while the journal is still being written."""

    def __init__(self, path: Path, prepare: Listener) -> None:
        self.path, self.prepare = path, prepare
        self.player: Player | None = None
        self.offset = self.lines = 0  # bytes and lines of the journal that it has played
        self.known = Survey(0, "", 0, {}, {}, {})

    @property
    def now_ps(self) -> int:
        """The instant that the shadow has reached (ps); -1 if it has not started."""
        return -1 if self.player is None else self.player.bench.now_ps

    def follow(self, to_ps: int, enough: Callable[[], bool] = lambda: False) -> bool:
        """Play on up to an instant; return False if `enough` returned true, which ends the call early.

        Raises:
            BenchFileError: an entry cannot be executed.
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
            known.faults.setdefault(owner, {}).update(faults)  # an existing memory gets them, too
        known.chips.update(more.chips)
        known.behaviours.update(more.behaviours)
        if not self.offset:
            self.known = known._replace(seed=more.seed, maker=more.maker)

    def _kept(self, bench: Bench, name: str, memory: ReplayedStore) -> JournaledStore:
        faults = self.known.faults.setdefault(name, {})
        return JournaledStore(ReplayedStore(memory.data, faults), partial(bench._circuit._record_journal, name))


class Past:
    """The past of a bench with a journal, from which other runs can start.

    Args:
        bench: the bench in use, until `go_on` replaces it.
        shadows: the number of shadows (see the docstring of the module).  Each serves one rerun; a rerun without
            a suitable shadow starts again at time 0.
    """

    def __init__(self, bench: Bench, shadows: int = 3) -> None:
        self.bench, self.most = bench, shadows
        self.shadows: list[ShadowBench] = []
        self.entry_s = ENTRY_S  # the time per entry; a caller with a clock may correct it

    @property
    def path(self) -> Path:
        """The path of the journal, which is still being written.

        Raises:
            UsageError: there is no journal.
        """
        if self.bench.journal is None:
            raise UsageError('going back needs a journal: Bench(journal="FILE")')
        return self.bench.journal.path

    def at(self, ps: int) -> Instant:
        """Return the instant `ps` (ps since time 0) of the past."""
        return Instant(self, ps)

    def listen(self, bench: Bench) -> object:
        """Prepare a bench that is about to play the past; a subclass may return a `Companion` (`replaying.py`)."""

    def follow(self, to_ps: int, enough: Callable[[], bool] = lambda: False) -> bool:
        """Let the shadows play on up to an instant before which no more inputs will be inserted.

        The instant must be over: all its entries are in the journal.

        Args:
            enough: called after each entry; if it returns true, the remaining entries are left for the next call.

        Returns:
            False if entries up to the instant remain, else True.
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
        """The instant (ps) that the most advanced shadow has reached; -1 if no shadow has started."""
        return max((each.now_ps for each in self.shadows), default=-1)

    @property
    def played(self) -> int:
        """The total number of entries that the shadows have played."""
        return sum(each.lines for each in self.shadows)

    def entries(self) -> Iterator[tuple[int, Entry]]:
        """Yield the journal entries that no shadow has played yet, each with the byte offset of its line."""
        at = max((each.offset for each in self.shadows), default=0)
        with open(self.path, "rb") as file:
            file.seek(at)
            for line in file:
                yield at, json.loads(line)
                at += len(line)

    def go_on(self, bench: Bench, since_ps: int = 0) -> None:
        """Continue with another bench, identical to the present one before the instant `since_ps` (ps).

        The other bench takes over the external memories.  Its journal takes the name of the present journal, if
        the operating system can rename the file.

        Raises:
            OSError: a memory could not be written; nothing has changed.
        """
        _take_over(bench, self.bench)
        self.bench = bench
        if bench.journal is not None:
            for each in self.shadows:
                each.path = bench.journal.path


class Instant:
    """An instant of the past of a bench (ps), from which another run can continue."""

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
        """Return another bench, run up to `to_ps`, as if the inputs after this instant had been different.

        The new bench repeats the journal, with `inputs` inserted at their instants: inputs in the first round of
        an instant come before inputs recorded after that round.  The bench in use is unchanged, and so are
        memories in files.

        Args:
            inputs: entries of a journal, such as `driven` and `given` return.
            to_ps: the present instant, ps.
            copy: the path for the journal of the new bench; by default next to the present journal.
            without: entries of the journal that are left out, each given by the byte offset of its line.
            allowed_s: the time that the rerun may take on a typical machine, in seconds; None for any time.

        Raises:
            TooLong: the rerun would take longer than `allowed_s`.
            UsageError: no input is added or left out; or this instant, or the instant of an input that is added
                or left out, is 0 or earlier, or later than `to_ps`.
            BenchFileError: an entry cannot be executed (inserted entries may make a recorded one fail); or
                `copy` is a file that is not a journal, or cannot be written.
        """
        more = sorted(inputs, key=lambda entry: int(entry["t"]))
        if not (more or without):
            raise UsageError("going back: no input given; give at least one")
        past, first = self.past, self._first(more, without, to_ps)
        other = Path(f"{past.path}.other" if copy is None else copy)
        fitting = [each for each in past.shadows if each.now_ps < first]
        shadow = max(fitting, key=lambda each: each.now_ps, default=None) or ShadowBench(past.path, past.listen)
        with open(past.path, "rb") as file:
            shared, rest = file.read(shadow.offset), file.read()
        entries = rest.count(b"\n")
        seconds = entries * past.entry_s
        if allowed_s is not None and seconds > allowed_s:
            raise TooLong(
                f"going back to {readable(first)}: {entries} inputs ({len(rest)} bytes of journal) would "
                f"have to be repeated, about {seconds:.3f} s; allowed {allowed_s:.3f} s"
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
        object.__setattr__(bench, "journal", journal)  # not possible for users
        bench.kernel.outside.write = journal.write
        return bench

    def _first(self, inputs: Iterable[Entry], without: Iterable[int], to_ps: int) -> int:
        """Return the earliest of this instant and the instants (ps) of the inputs that are added or left out."""
        marks = [self.ps, *(int(entry["t"]) for entry in inputs), *map(self._instant, without)]
        for at in marks:
            if not 0 < at <= to_ps:
                raise UsageError(
                    f"going back: an input at {readable(at)}; allowed: later than 0, up to {readable(to_ps)}"
                )
        return min(marks)

    def _instant(self, offset: int) -> int:
        """Return the instant (ps) of the journal entry at a byte offset."""
        with open(self.past.path, "rb") as file:
            file.seek(offset)
            return int(json.loads(file.readline())["t"])


def merged(rest: bytes, at: int, more: list[Entry], without: Collection[int]) -> Iterator[bytes]:
    """Yield the lines of `rest`, a journal from byte offset `at` on; insert the entries `more` in order of time.

    Lines at the byte offsets `without`, and an incomplete last line, are left out.
    """
    for line in rest.splitlines(keepends=True):
        if line.endswith(b"\n") and at not in without:
            entry = json.loads(line)
            while more and place(more[0]) < place(entry):
                yield spelled(more.pop(0))
            yield line
        at += len(line)
    yield from map(spelled, more)


def place(entry: Entry) -> tuple[int, bool]:
    """Return the sort key of an entry: its instant, and whether it comes after the first round of that instant."""
    return int(entry.get("t", 0)), entry.get("round") != 1


def spelled(entry: Entry) -> bytes:
    """Return an entry as a line of a journal."""
    return json.dumps(dict(entry), separators=(",", ":")).encode("ascii") + b"\n"


def _take_over(bench: Bench, old: Bench) -> None:
    """Pass the memories and the journal of the bench `old` to `bench`, as described in `Past.go_on`."""
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
