"""Replay of a journal: its entries are read, checked, and executed at their instants.

`journal.py` describes the lines of a journal.  The run is repeated exactly only if the parts still
behave as they did when it was recorded.  A journal may come from an untrusted source: it can only call
methods that are declared as inputs, and a gate (`gate.py`) checks all names in it.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from functools import partial
from os import PathLike
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, runtime_checkable

from ..chips import chip_class
from ..core.component import input_of
from ..core.memory.image import LARGEST
from ..core.memory.store import JournaledStore, ReplayedStore
from ..core.messages.calls import answering, level_of_caller
from ..core.time.timebase import Time, moment
from ..errors import BenchFileError, OtherLaws, SlewlineError, UnknownName, UsageError
from ..gate import FileGate
from ..parts import part_class
from ..parts.hosts.bus_host import BusHost
from ..parts.hosts.host import Host
from ..version import __version__
from .bench import Bench
from .files.entries import Entries
from .files.journal import Journal

if TYPE_CHECKING:
    from ..core.chip import Chip

STRANGE = (ArithmeticError, AttributeError, LookupError, TypeError, ValueError)  # errors of invalid entries
CALLS = ("change_rate", "live", "read_position", "run_program", "verify")  # of a bus host, in journals of 0.1.0


class Survey(NamedTuple):
    """Facts about a journal that are needed before any entry is executed."""

    seed: int
    maker: str
    end: int  # the instant of the last entry, ps
    chips: dict[str, type[Chip]]  # the classes that it names
    behaviours: dict[str, int]  # of its chips, by part
    faults: dict[str, dict[int, dict[str, Any]]]  # of its stores, by owner and call


def survey(found: Entries, gate: FileGate) -> Survey:
    """Read a journal once, without executing it; return the facts that its replay needs.

    Raises:
        BenchFileError: a chip or part does not exist, or is named as module:Class although this is not
            allowed; or the content of a memory is invalid.  The message states the line.
    """
    known = Survey(0, "", 0, {}, {}, {})
    entry: dict[str, Any] = {"t": 0}
    for number, entry in found:
        do = entry["do"]
        try:
            if do == "journal":
                known = known._replace(seed=entry["seed"], maker=entry.get("slewline", "up to 0.1.0"))
            elif do == "add":
                known.chips[entry["part"]] = gate.code(chip_class, entry["part"])
                known.behaviours[entry["part"]] = entry.get("behaviour", 1)
            elif do == "part":
                gate.code(part_class, entry["kind"])
            elif do == "store":
                known.faults.setdefault(entry["of"], {})[entry["call"]] = entry
                as_bytes(entry.get("content", []))
        except (UnknownName, UsageError) as error:
            raise found.error(number, str(error)) from error
    return known._replace(end=entry["t"])


def differing(known: Survey) -> str:
    """Return text that lists the parts whose behaviour has changed since the recording; "" if none has changed."""
    here = {part: cls.sheet.behaviour for part, cls in known.chips.items()}
    different = [(part, known.behaviours[part]) for part in here if here[part] != known.behaviours[part]]
    return ", ".join(f"{part} had behaviour {had} and now has {here[part]}" for part, had in different)


@answering("replay()")
def replay(
    path: str | PathLike[str],
    *,
    until: Time | None = None,
    shuffle: int | None = None,
    prepare: Callable[[Bench], object] | None = None,
    other_laws: bool = False,
    allow_code: bool = False,
) -> Bench:
    """Replay a journal; return the bench as it was at the end of the recorded run, or at the instant `until`.

    Args:
        path: the journal.
        until: the instant at which to stop, by default the end of the run.  All inputs at this instant are
            included; to leave them out, stop one picosecond earlier.  After the end of the journal, time
            passes without inputs.  The returned bench can be run further.
        shuffle: a seed, for tests: tasks that are due in the same round then run in a random order, which
            must not change the results; None keeps the usual order.
        prepare: a function that is called with the bench before time passes: to record pins, for example.
        other_laws: replay even if the behaviour of a part has changed since the journal was recorded; the
            run may then differ, and the warning OtherLaws is issued.
        allow_code: allow the journal to name chips and parts as module:Class, whose import runs code from
            the module.

    Raises:
        BenchFileError: not a journal, or the parts in it behave differently now, do not exist, or are not
            allowed.
        TimeError: `until` is not a time.
    """
    found = Entries(path)
    with closing(found.file):
        known = survey(found, FileGate(path, allow_code=allow_code))
        stop = known.end if until is None else moment(until)
        _check_laws(path, known, other_laws)
        return _played(found, known, Bench(seed=known.seed, shuffle=shuffle), stop, prepare)


def go_on(bench: Bench, path: str | PathLike[str], begin: int, stop: int, copy: str | PathLike[str]) -> None:
    """Let a bench play the entries of a journal from byte offset `begin` on, up to the instant `stop` (ps).

    The bench must be in the state reached at `begin`.  After `stop`, it writes a journal of its own, `copy`,
    which begins with the old one up to `stop`.  Memories of chips and parts are separated from their
    external stores; memory faults in the journal are repeated.

    Raises:
        BenchFileError: an entry is invalid.
    """
    outside = bench.kernel.outside
    outside.write = None
    found = Entries(path, begin)
    with closing(found.file):
        known = survey(found, FileGate(path, allow_code=True))
        for owner in (*bench.chips.values(), *bench.parts.values()):
            store = getattr(owner, "store", None)
            if isinstance(store, JournaledStore):
                store.detach(known.faults.get(owner.name, {}))
        _played(found, known, bench, stop, None)
    with open(path, "rb") as source, open(copy, "wb") as target:
        target.write(source.read(_length_at(path, begin, stop)))
    journal = Journal.continued(copy, bench.kernel)
    object.__setattr__(bench, "journal", journal)  # users may not
    outside.write = journal.write


def _length_at(path: str | PathLike[str], begin: int, stop: int) -> int:
    """Return the length of a journal, in bytes, up to the end of its last entry at or before the instant `stop` (ps).

    Reading starts at the byte offset `begin`, which must be the start of a line.
    """
    with open(path, "rb") as file:
        file.seek(begin)
        while line := file.readline():
            if not line.endswith(b"\n") or json.loads(line)["t"] > stop:
                return file.tell() - len(line)
        return file.tell()


@runtime_checkable
class Companion(Protocol):
    """An object that accompanies a bench while it plays a journal, and acts on the bench without journal entries."""

    def done(self, entry: Mapping[str, Any], result: Any) -> None:
        """Take note of an entry that has been executed, and of its result if it is an input."""

    def due(self, to_ps: int) -> tuple[int, Callable[[], object]] | None:
        """Return the instant (ps) of the companion's next action, and the action, if due by `to_ps`; else None."""


class Player:
    """A player of a journal, which executes each entry on a bench at its instant.

    An entry for the first round of an instant is held in the kernel until that round.

    Args:
        prepare: called with the bench before time passes; may return a `Companion`.
        kept: a function that takes the name of a chip or part, and the store that the journal provides for it;
            it returns the store to use instead.
    """

    def __init__(
        self,
        bench: Bench,
        prepare: Callable[[Bench], object] | None = None,
        kept: Callable[[str, ReplayedStore], Any] = lambda _name, memory: memory,
    ) -> None:
        self.bench, self.prepare, self.kept = bench, prepare, kept
        self.companion: Companion | None = None
        self.early: dict[
            int, list[tuple[Entries, Survey, int, dict[str, Any]]]
        ] = {}  # in the first round of an instant

    def take(self, found: Entries, known: Survey, number: int, entry: dict[str, Any]) -> None:
        """Let time pass up to the instant of an entry, and execute the entry."""
        bench, at = self.bench, entry["t"]
        if self.prepare is not None and (entry["do"] == "run" or at > 0):
            self.begin()
        if entry.get("round") == 1 and entry["do"] != "store":
            if at not in self.early:
                self.early[at] = []
                bench.at(f"{at} ps", partial(self._early, at))
            self.early[at].append((found, known, number, entry))
        else:
            if at > bench.now_ps or self.companion is not None:
                with _located(found, number, "the run before it"):
                    self._pass(at)
            self._do(found, known, number, entry)

    def begin(self) -> None:
        """Call `prepare` if it has not been called yet."""
        if self.prepare is not None:
            found = self.prepare(self.bench)
            self.prepare = None
            if isinstance(found, Companion):
                self.companion = found

    def end(self, found: Entries, number: int, stop: int) -> None:
        """Let time pass up to an instant (ps), so that the last input takes effect."""
        with _located(found, number, "the run after it"):
            self._pass(stop)
            self.bench.run_to(f"{stop} ps")

    def _pass(self, to_ps: int) -> None:
        """Let time pass, and perform the actions of the companion that become due."""
        while self.companion is not None and (due := self.companion.due(to_ps)) is not None:
            at, act = due
            if at > self.bench.now_ps:
                self.bench.run_to(f"{at} ps")
            act()
        if to_ps > self.bench.now_ps:
            self.bench.run_to(f"{to_ps} ps")

    def _early(self, instant: int) -> None:
        for each in self.early.pop(instant):
            self._do(*each)

    def _do(self, found: Entries, known: Survey, number: int, entry: dict[str, Any]) -> None:
        with _located(found, number, entry["do"]):
            result = apply(self.bench, entry, known, self.kept)
            if self.companion is not None:
                self.companion.done(entry, result)


def _played(found: Entries, known: Survey, bench: Bench, stop: int, prepare: Callable[[Bench], object] | None) -> Bench:
    """Let a bench repeat a journal, up to an instant; return the bench."""
    player, number = Player(bench, prepare), 0
    for number, entry in found:
        if entry["t"] > stop:
            break
        player.take(found, known, number, entry)
    player.begin()
    player.end(found, number, stop)
    bench.catch_up()
    return bench


def as_bytes(content: Any) -> bytes:
    """Convert the content of a memory, which an entry lists as one number per byte, to bytes.

    Raises:
        UsageError: the content is not such a list.  This includes a whole number, which `bytes` would take
            as a length.
    """
    if not (isinstance(content, list) and len(content) <= LARGEST and all(type(byte) is int for byte in content)):
        raise UsageError(
            f"store: found {json.dumps(content)[:80]}; expected a list of at most {LARGEST} bytes, 0 to 255"
        )
    try:
        return bytes(content)
    except ValueError:
        raise UsageError("store: found a number that is not a byte; allowed 0 to 255") from None


@contextmanager
def _located(found: Entries, number: int, what: str) -> Iterator[None]:
    """Convert any error in the `with` block to a BenchFileError that states the file and the line `number`."""
    try:
        yield
    except BenchFileError:
        raise  # with its line
    except STRANGE as error:
        message = str(error) if isinstance(error, SlewlineError) else f"{what} cannot be executed: {error!r}"
        raise found.error(number, message) from error


def _check_laws(path: str | PathLike[str], known: Survey, allowed: bool) -> None:
    """Refuse a journal whose parts behave differently now; if `allowed`, issue the warning OtherLaws instead.

    Raises:
        BenchFileError: parts behave differently, and that is not allowed.
    """
    different = differing(known)
    if not different:
        return
    made = f"journal {path}: made by slewline {known.maker}, this is {__version__}: {different}"
    if not allowed:
        raise BenchFileError(
            f"{made}; the run would differ: replay the journal with the version that made it, or pass "
            "other_laws=True (--other-laws)"
        )
    warnings.warn(f"{made}; the run may differ", OtherLaws, stacklevel=level_of_caller())


def apply(
    bench: Bench,
    entry: dict[str, Any],
    known: Survey,
    kept: Callable[[str, ReplayedStore], Any] = lambda _name, memory: memory,
) -> Any:
    """Execute an entry on a bench; return the result of an input to a chip or part, and None for other entries.

    `kept` takes the name of a chip or part, and the store that the journal provides for it; it returns the store
    to use instead.
    """
    do = entry["do"]
    named: Callable[[str], Any] = bench.__getitem__
    if do in ("add", "part"):
        name, options = entry["name"], dict(entry["options"])
        memory = options.get("store")
        if memory is not None:
            options["store"] = memory = kept(name, ReplayedStore(as_bytes(memory), known.faults.get(name, {})))
        if do == "add":
            cls = known.chips[entry["part"]]
            bench.add(cls, name, entry["crystal_hz"], entry["straps"], entry["bare"], **options)
        else:
            bench.part(entry["kind"], name, entry.get("to"), entry.get("on"), **options)
        if memory is not None:
            memory.begin()
    elif do == "host":
        bench.host(
            *map(named, entry["chips"]),
            name=entry["name"],
            delay=f"{entry['delay_ps']} ps",
            baud=entry.get("baud"),
            line=named(entry["line"]) if entry.get("line") else None,
            over=entry.get("over"),
        )
    elif do == "connect":
        bench.connect(named(entry["part"]), [*map(named, entry["chips"])])
    elif do == "input":
        return input_of(named(entry["part"]), entry["verb"])(*entry["args"])
    elif do == "wire":
        bench.wire(entry["a"], entry["b"], entry["invert"])
    elif do == "drive":
        terminal = bench.pin(entry["pin"])
        terminal.release() if entry["level"] is None else terminal.drive(entry["level"])
    elif do == "power":
        named(entry["chip"]).power(entry["on"])
    elif do == "run":
        if entry["to"] >= bench.now_ps:
            bench.run_to(f"{entry['to']} ps")
    elif do == "conclude":
        bench.conclude()
    elif "host" in entry:
        apply_input(bench, entry["host"], do, entry["args"])
    return None


def apply_input(bench: Bench, name: str, do: str, args: list[Any]) -> None:
    """Repeat a recorded input to a host: a script or, in journals of 0.1.0 and earlier, a call of a method."""
    host: Any = bench[name]
    if not isinstance(host, Host):
        raise UsageError(f"{name} is not a host")
    if do == "send":
        chip, data = args
        host.to(chip).send(bytes.fromhex(data))
    elif do in ("clear", "drop", "give_up"):
        getattr(host, do)()
    elif do == "call":
        verb, chip, *more = args
        if not isinstance(host, BusHost) or verb not in CALLS:
            raise UsageError(f"{name}: call {verb!r}; allowed {', '.join(CALLS)}")
        with bench.kernel.outside.queued():  # the journal itself records how time passed
            getattr(host.to(chip), verb)(*more)
    elif do == "script":
        from .scripts.script import run_script  # a bench without scripts does not load the script language

        chip, text, where = args
        run_script(bench, host.to(chip), text, where)
