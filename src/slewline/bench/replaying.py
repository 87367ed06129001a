"""Playing a journal again: its entries are read, checked against the laws of today, and done at their instants.

`journal.py` says what stands in it.  A journal may come from anybody: it calls methods that are declared as inputs, and
names no module, whose import would run its code, unless that is allowed (`allow_code`).
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Iterable
from os import PathLike
from typing import TYPE_CHECKING, Any, NamedTuple

from ..chips import chip_class
from ..core.inputs import input_of
from ..core.store import Memory
from ..core.timebase import Time, moment
from ..errors import BenchFileError, OtherLaws, TornJournal, UsageError
from ..parts import part_class
from ..parts.computer import Computer
from ..parts.host import Host
from ..version import __version__
from .bench import Bench
from .journal import VERSION
from .text import read_file

if TYPE_CHECKING:
    from ..core.chip import Chip
    from ..parts.part import Part

STRANGE = (ArithmeticError, AttributeError, LookupError, TypeError, ValueError)  # what comes of entries of no sense
CALLS = ("change_rate", "live", "read_position", "run_program", "verify")  # of a host on a bus, in journals of 0.1.0


def entries(path: str | PathLike[str]) -> list[dict[str, Any]]:
    """Return the entries of a journal file; a last line that was cut off is left out, with the warning TornJournal.

    Raises:
        BenchFileError: not readable, or not a journal.
    """
    try:
        lines = read_file(path, None).decode("ascii").split("\n")
    except (BenchFileError, UnicodeDecodeError) as error:
        raise BenchFileError(f"journal {error if isinstance(error, BenchFileError) else f'{path}: no text'}") from None
    found = []
    for number, line in enumerate(lines, 1):
        if not line:
            continue
        try:
            entry = json.loads(line)
            entry["do"], entry["t"]
        except (ValueError, KeyError, TypeError):
            if number == len(lines):
                torn = f"journal {path}, line {number}: cut off; the replay ends before it"
                warnings.warn(torn, TornJournal, stacklevel=3)
                break
            raise BenchFileError(f"journal {path}, line {number}: not a journal entry: {line[:60]}") from None
        found.append(entry)
    if not found or found[0]["do"] != "journal" or found[0].get("version") != VERSION:
        raise BenchFileError(f"journal {path}: does not begin as a journal of version {VERSION}")
    return found


class Named(NamedTuple):
    """The classes that a journal names."""

    chips: dict[str, type[Chip]]
    parts: dict[str, type[Part]]


def named(path: str | PathLike[str], found: Iterable[dict[str, Any]], allow_code: bool) -> Named:
    """Return the classes of all chips and parts in a journal, before anything is done.

    Raises:
        BenchFileError: one is not there, or is named as module:Class and that is not allowed; with its line.
    """
    classes = Named({}, {})
    for number, entry in enumerate(found, 1):
        try:
            if entry["do"] == "add":
                classes.chips[entry["part"]] = chip_class(entry["part"], allow_code=allow_code)
            elif entry["do"] == "part":
                classes.parts[entry["kind"]] = part_class(entry["kind"], allow_code=allow_code)
        except (KeyError, TypeError, UsageError) as error:
            raise BenchFileError(f"journal {path}, line {number}: {error}") from error
    return classes


def differing(found: Iterable[dict[str, Any]], classes: Named) -> str:
    """Return in words which parts of a journal behaved by other laws than here; "": none."""
    added = {entry["part"]: entry.get("behaviour", 1) for entry in found if entry["do"] == "add"}
    here = {part: cls.sheet.behaviour for part, cls in classes.chips.items()}
    different = [part for part in here if here[part] != added[part]]
    return ", ".join(f"{part} had behaviour {added[part]} and has {here[part]}" for part in different)


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
            those of its first round and those behind it.  To leave them out, stop a picosecond earlier.  Behind the end
            of the journal time passes without inputs.  The bench runs on by hand from there.
        prepare: called with the furnished bench, before time passes: to record pins, for example.
        other_laws: replay it also if its parts have another behaviour now; the run may then be another one, which the
            warning OtherLaws says.
        allow_code: it may name chips and parts as module:Class, whose import runs the code of the module.

    Raises:
        BenchFileError: not a journal, or one whose parts behaved by other laws, are not there or not allowed.
        TimeError: `until` is no instant.
    """
    found = entries(path)
    stop = found[-1]["t"] if until is None else moment(until)
    classes = named(path, found, allow_code)
    _check_laws(path, found, classes, other_laws)
    bench = Bench(seed=found[0]["seed"], shuffle=shuffle)
    early: dict[int, list[dict[str, Any]]] = {}  # what is done in the first round of an instant, in its order
    for number, entry in enumerate(found[1:], 2):
        try:
            if entry["t"] > stop:
                break
            if prepare is not None and (entry["do"] == "run" or entry["t"] > 0):
                prepare(bench)
                prepare = None
            if entry.get("round") == 1:
                at = entry["t"]
                if at not in early:
                    early[at] = []
                    bench.at(f"{at} ps", lambda at=at: apply_all(bench, early[at], classes))  # type: ignore[misc]
                early[at].append(entry)
            else:
                if entry["t"] > bench.now_ps:
                    bench.run_to(f"{entry['t']} ps")
                apply(bench, entry, classes)
        except STRANGE as error:
            raise BenchFileError(f"journal {path}, line {number}: {error}") from error
    if prepare is not None:
        prepare(bench)
    bench.run_to(f"{stop} ps")  # an input that stands last takes effect
    bench.catch_up()
    return bench


def _check_laws(path: str | PathLike[str], found: list[dict[str, Any]], classes: Named, allowed: bool) -> None:
    """Refuse a journal that was made by other laws, or warn of it."""
    different = differing(found, classes)
    if not different:
        return
    maker = found[0].get("slewline", "up to 0.1.0")
    made = f"journal {path}: made by slewline {maker}, this is {__version__}: {different}"
    if not allowed:
        raise BenchFileError(
            f"{made}; the run would be another one: replay it with that version, "
            "or all the same (other_laws=True, --other-laws)"
        )
    warnings.warn(f"{made}; the run may be another one", OtherLaws, stacklevel=3)


def apply_all(bench: Bench, found: Iterable[dict[str, Any]], classes: Named) -> None:
    """Do again what entries say, one after the other."""
    for entry in found:
        apply(bench, entry, classes)


def apply(bench: Bench, entry: dict[str, Any], classes: Named) -> None:
    """Do again what an entry says."""
    do = entry["do"]
    if do == "add":
        options = recalled(entry["options"])
        cls = classes.chips[entry["part"]]
        bench.add(cls, entry["name"], entry["crystal_hz"], entry["straps"], entry["bare"], **options)
    elif do == "host":
        chips = [bench.chips[name] for name in entry["chips"]]
        line = bench.parts[entry["line"]] if entry.get("line") else None
        bench.host(
            *chips,
            name=entry["name"],
            delay=f"{entry['delay_ps']} ps",
            baud=entry.get("baud"),
            line=line,
            over=entry.get("over"),
        )
    elif do == "connect":
        bench.connect(bench.parts[entry["part"]], [bench.chips[name] for name in entry["chips"]])
    elif do == "part":
        options = recalled(entry["options"])
        bench.part(classes.parts[entry["kind"]], entry["name"], entry.get("to"), entry.get("on"), **options)
    elif do == "input":
        input_of(bench[entry["part"]], entry["verb"])(*entry["args"])
    elif do == "wire":
        bench.wire(entry["a"], entry["b"], entry["invert"])
    elif do == "drive":
        terminal = bench.pin(entry["pin"])
        terminal.release() if entry["level"] is None else terminal.drive(entry["level"])
    elif do == "power":
        bench.chips[entry["chip"]].power(entry["on"])
    elif do == "run":
        if entry["to"] >= bench.now_ps:
            bench.run_to(f"{entry['to']} ps")
    elif do == "conclude":
        bench.conclude()
    elif "host" in entry:
        tell(bench, entry["host"], do, entry["args"])
    else:
        raise BenchFileError(f"unknown entry {do!r}")


def recalled(options: dict[str, Any]) -> dict[str, Any]:
    """Return options as they were given: of a store, its content at that time in the memory of this run."""
    store = options.get("store")
    return options if store is None else options | {"store": Memory(bytes(store))}


def tell(bench: Bench, name: str, do: str, args: list[Any]) -> None:
    """Tell a host again what it was told: a script, or, as up to 0.1.0, everything else."""
    host: Any = bench[name]
    if not isinstance(host, Computer):
        raise BenchFileError(f"{name} is no host")
    if do == "send":
        chip, data = args
        host.to(chip).send(bytes.fromhex(data))
    elif do in ("clear", "drop", "give_up"):
        getattr(host, do)()
    elif do == "call":
        verb, chip, *more = args
        if not isinstance(host, Host) or verb not in CALLS:
            raise BenchFileError(f"{name}: {verb!r} is no call; allowed {', '.join(CALLS)}")
        with bench.outside.queued():  # the journal itself says how time passed
            getattr(host.to(chip), verb)(*more)
    elif do == "script":
        from .script import run_script  # a bench without scripts does not load their language

        chip, text, where = args
        run_script(bench, host.to(chip), text, where)
    else:
        raise BenchFileError(f"unknown entry {do!r}")
