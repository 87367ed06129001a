"""Playing a journal again: its entries are read, checked against the laws of today, and done at their instants.

`journal.py` describes its lines.  A journal may come from anybody: it calls methods that are declared as inputs, and
names no module, whose import would run its code, unless that is allowed (`allow_code`).
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from functools import partial
from os import PathLike
from typing import TYPE_CHECKING, Any, NamedTuple

from ..chips import chip_class
from ..core.component import input_of
from ..core.memory.store import JournaledStore, ReplayedStore
from ..core.time.timebase import Time, moment
from ..errors import BenchFileError, OtherLaws, SlewlineError, UnknownName, UsageError
from ..parts import part_class
from ..parts.hosts.bus_host import BusHost
from ..parts.hosts.host import Host
from ..version import __version__
from .bench import Bench
from .files.entries import Entries
from .files.journal import Journal

if TYPE_CHECKING:
    from ..core.chip import Chip

STRANGE = (ArithmeticError, AttributeError, LookupError, TypeError, ValueError)  # what comes of entries of no sense
CALLS = ("change_rate", "live", "read_position", "run_program", "verify")  # of a host on a bus, in journals of 0.1.0


class Survey(NamedTuple):
    """What must be known of a journal before anything is done."""

    seed: int
    maker: str
    end: int  # the instant of the last entry, ps
    chips: dict[str, type[Chip]]  # the classes that it names
    behaviours: dict[str, int]  # of its chips, by part
    faults: dict[str, dict[int, dict[str, Any]]]  # of its stores, by owner and call


def survey(found: Entries, allow_code: bool) -> Survey:
    """Read a journal once; nothing is done.

    Raises:
        BenchFileError: a chip or part is not there, or is named as module:Class and that is not allowed; with its line.
    """
    known = Survey(0, "", 0, {}, {}, {})
    entry: dict[str, Any] = {"t": 0}
    for number, entry in found:
        do = entry["do"]
        try:
            if do == "journal":
                known = known._replace(seed=entry["seed"], maker=entry.get("slewline", "up to 0.1.0"))
            elif do == "add":
                known.chips[entry["part"]] = chip_class(entry["part"], allow_code=allow_code)
                known.behaviours[entry["part"]] = entry.get("behaviour", 1)
            elif do == "part":
                part_class(entry["kind"], allow_code=allow_code)
            elif do == "store":
                known.faults.setdefault(entry["of"], {})[entry["call"]] = entry
        except (UnknownName, UsageError) as error:
            raise found.error(number, str(error)) from error
    return known._replace(end=entry["t"])


def differing(known: Survey) -> str:
    """Return in words which parts of a journal behaved by other laws than here; "": none."""
    here = {part: cls.sheet.behaviour for part, cls in known.chips.items()}
    different = [(part, known.behaviours[part]) for part in here if here[part] != known.behaviours[part]]
    return ", ".join(f"{part} had behaviour {had} and has {here[part]}" for part, had in different)


def replay(
    path: str | PathLike[str],
    *,
    until: Time | None = None,
    shuffle: int | None = None,
    prepare: Callable[[Bench], object] | None = None,
    other_laws: bool = False,
    allow_code: bool = False,
) -> Bench:
    """Run a journal again; return the bench as the recorded run left it, or as it was at an instant.

    Args:
        until: the instant at which to stop: everything that the run did at it is done, and all inputs at it are put in,
            those of its first round and those after it.  To leave them out, stop a picosecond earlier.  After the end
            of the journal time passes without inputs.  The bench runs on by hand from there.
        prepare: called with the bench, before time passes: to record pins, for example.
        other_laws: replay it also if its parts have another behaviour now; the run may then differ,
            as the warning OtherLaws reports.
        allow_code: it may name chips and parts as module:Class, whose import runs the code of the module.

    Raises:
        BenchFileError: not a journal, or one whose parts behaved by other laws, are not there or not allowed.
        TimeError: `until` is no instant.
    """
    found = Entries(path)
    with closing(found.file):
        known = survey(found, allow_code)
        stop = known.end if until is None else moment(until)
        _check_laws(path, known, other_laws)
        return _played(found, known, Bench(seed=known.seed, shuffle=shuffle), stop, prepare)


def go_on(bench: Bench, path: str | PathLike[str], begin: int, stop: int, copy: str | PathLike[str]) -> None:
    """Let a bench that stands where a journal was so many bytes long go on to an instant (ps), with what comes in it.

    From there on it has a journal of its own, `copy`, which begins like that one.  The memories of its chips and parts
    are no longer those outside; they fail as the journal says.

    Raises:
        BenchFileError: an entry that makes no sense.
    """
    outside = bench.kernel.outside
    outside.write = None
    found = Entries(path, begin)
    with closing(found.file):
        known = survey(found, True)
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
    """How many bytes of a journal are about instants up to one (ps); `begin`: where a line begins."""
    with open(path, "rb") as file:
        file.seek(begin)
        while line := file.readline():
            if not line.endswith(b"\n") or json.loads(line)["t"] > stop:
                return file.tell() - len(line)
        return file.tell()


def _played(found: Entries, known: Survey, bench: Bench, stop: int, prepare: Callable[[Bench], object] | None) -> Bench:
    """Let a bench repeat a journal, up to an instant."""
    early: dict[int, list[tuple[int, dict[str, Any]]]] = {}  # what is done in the first round of an instant, in order

    def do(number: int, entry: dict[str, Any]) -> None:
        with _located(found, number, entry["do"]):
            apply(bench, entry, known)

    def begin(instant: int) -> None:
        for number, entry in early.pop(instant):
            do(number, entry)

    number = 0
    for number, entry in found:
        at = entry["t"]
        if at > stop:
            break
        if prepare is not None and (entry["do"] == "run" or at > 0):
            prepare(bench)
            prepare = None
        if entry.get("round") == 1 and entry["do"] != "store":
            if at not in early:
                early[at] = []
                bench.at(f"{at} ps", partial(begin, at))
            early[at].append((number, entry))
        else:
            if at > bench.now_ps:
                with _located(found, number, "the run before it"):
                    bench.run_to(f"{at} ps")
            do(number, entry)
    if prepare is not None:
        prepare(bench)
    with _located(found, number, "the run after it"):
        bench.run_to(f"{stop} ps")  # the last input takes effect
        bench.catch_up()
    return bench


@contextmanager
def _located(found: Entries, number: int, what: str) -> Iterator[None]:
    """Tell with file and line what comes of an entry that makes no sense."""
    try:
        yield
    except BenchFileError:
        raise  # with its line
    except STRANGE as error:
        says = str(error) if isinstance(error, SlewlineError) else f"{what}: cannot be done: {error!r}"
        raise found.error(number, says) from error


def _check_laws(path: str | PathLike[str], known: Survey, allowed: bool) -> None:
    """Refuse a journal that was made by other laws, or warn of it."""
    different = differing(known)
    if not different:
        return
    made = f"journal {path}: made by slewline {known.maker}, this is {__version__}: {different}"
    if not allowed:
        raise BenchFileError(
            f"{made}; the run would differ: replay it with that version, or pass other_laws=True (--other-laws)"
        )
    warnings.warn(f"{made}; the run may differ", OtherLaws, stacklevel=3)


def apply(bench: Bench, entry: dict[str, Any], known: Survey) -> None:
    """Repeat an entry."""
    do = entry["do"]
    named: Callable[[str], Any] = bench.__getitem__
    if do in ("add", "part"):
        name, options = entry["name"], dict(entry["options"])
        memory = options.get("store")
        if memory is not None:
            options["store"] = memory = ReplayedStore(bytes(memory), known.faults.get(name, {}))
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
        input_of(named(entry["part"]), entry["verb"])(*entry["args"])
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
        tell(bench, entry["host"], do, entry["args"])


def tell(bench: Bench, name: str, do: str, args: list[Any]) -> None:
    """Repeat a call of a host: a script, or, as up to 0.1.0, everything else."""
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
        with bench.kernel.outside.queued():  # the journal itself has how time passed
            getattr(host.to(chip), verb)(*more)
    elif do == "script":
        from .scripts.script import run_script  # a bench without scripts does not load their language

        chip, text, where = args
        run_script(bench, host.to(chip), text, where)
