"""The journal: every input from outside, one JSON object a line; replaying it gives the same run, to the bit.

    {"do": "journal", "version": 1, "seed": 0, "slewline": "0.1.0"}
    {"do": "add", "t": 0, "part": "cy525", "behaviour": 2, "name": "x", ...}
    {"do": "drive", "t": 12000000000, "round": 1, "pin": "x.abort", "level": 0}

`t` is the instant in picoseconds; `round` 1 marks what was done while that instant was running its first round, which
is before its changes commit; the rest is done after the instant.  Lines are written as they happen, so a journal of a
run that was killed is good up to its last whole line.

A run is repeated to the bit only by the laws that made it: `behaviour` is the column of that name in the sheet of the
part.  A journal without it was made before the column was there, and counts as 1.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Iterable
from contextlib import suppress
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO
from weakref import finalize

from .. import __version__
from ..chips import PARTS, sheet_of
from ..core.kernel import Kernel
from ..core.store import Memory
from ..errors import BenchFileError, OtherLaws, TornJournal
from .text import read_file

if TYPE_CHECKING:
    from .bench import Bench

VERSION = 1
FIRST = b'{"do":"journal",'  # as it begins


class Journal:
    """A journal that is being written; one that stands there already is replaced.

    Raises:
        BenchFileError: it cannot be written, now or later, unless `on_failure` is told instead; or something else than
            a journal stands there.
    """

    def __init__(self, path: str | PathLike[str], kernel: Kernel, seed: int) -> None:
        self.path, self.kernel = Path(path), kernel
        self.failure = ""  # why nothing can be written any more
        self.on_failure: Callable[[str], object] | None = None  # who goes on without a journal, and is told once
        replaced(path)
        try:
            self.file: TextIO = open(path, "w", encoding="ascii", buffering=1)  # noqa: SIM115
        except OSError as error:
            raise BenchFileError(self._refusal(error)) from None
        finalize(self, closed, self.file)  # a bench has no end that anybody would have to announce
        self.write("journal", version=VERSION, seed=seed, slewline=__version__)

    def write(self, do: str, **what: Any) -> None:
        """One input, at this instant.

        Raises:
            BenchFileError: an argument that cannot be written down, such as a function; or the file takes no more.
        """
        if self.failure:
            if self.on_failure is None:
                raise BenchFileError(self.failure)
            return
        kernel = self.kernel
        entry: dict[str, Any] = {"do": do, "t": kernel.now}
        if kernel.running and kernel.seen < kernel.now:
            entry["round"] = 1
        try:
            self.file.write(json.dumps(entry | what, separators=(",", ":")) + "\n")
        except TypeError as error:
            raise BenchFileError(f"journal {self.path}: {do}: {error}; a journal keeps numbers and text") from None
        except OSError as error:
            self.failure = self._refusal(error)
            closed(self.file)
            if self.on_failure is None:
                raise BenchFileError(self.failure) from None
            self.on_failure(f"journal {self.path}: {error.strerror or error}; the journal ends here")

    def _refusal(self, error: OSError) -> str:
        return f"journal {self.path}: {error.strerror or error}; give a file that can be written"

    def close(self) -> None:
        """No more entries."""
        closed(self.file)


def closed(file: TextIO) -> None:
    """Close a file of which every line has been written, or refused, already."""
    with suppress(OSError):
        file.close()


def replaced(path: str | PathLike[str]) -> bool:
    """Will a journal that is written here replace another one?

    Raises:
        BenchFileError: a file with something else stands there, which is not to be lost; or a FIFO.
    """
    place = Path(path)
    try:
        if place.is_fifo():  # opening it would wait for a reader
            raise BenchFileError(f"journal {path}: is a FIFO; give a regular file")
        if not place.is_file() or not place.stat().st_size:
            return False
        with place.open("rb") as file:
            if file.read(len(FIRST)) == FIRST:
                return True
    except OSError as error:
        raise BenchFileError(f"journal {path}: {error.strerror or error}; give a file that can be written") from None
    raise BenchFileError(f"journal {path}: stands there already and is no journal; give a file that is to be new")


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


def differing(found: Iterable[dict[str, Any]]) -> str:
    """Which parts of a journal behaved by other laws than here; empty: none."""
    added = {entry["part"]: entry.get("behaviour", 1) for entry in found if entry["do"] == "add"}
    here = {part: sheet_of(part).behaviour for part in added if part in PARTS}
    different = [part for part in here if here[part] != added[part]]
    return ", ".join(f"{part} had behaviour {added[part]} and has {here[part]}" for part in different)


def replay(
    path: str | PathLike[str],
    *,
    shuffle: int | None = None,
    prepare: Callable[[Bench], object] | None = None,
    other_laws: bool = False,
) -> Bench:
    """Run a journal again; return the bench as the recorded run left it.

    Args:
        prepare: called with the furnished bench, before time passes: to record pins, for example.
        other_laws: replay it also if its parts have another behaviour now; the run may then be another one, which the
            warning OtherLaws says.

    Raises:
        BenchFileError: not a journal, or one whose parts behaved by other laws.
    """
    from .bench import Bench

    found = entries(path)
    _check_laws(path, found, other_laws)
    bench = Bench(seed=found[0]["seed"], shuffle=shuffle)
    for number, entry in enumerate(found[1:], 2):
        try:
            if prepare is not None and (entry["do"] == "run" or entry["t"] > 0):
                prepare(bench)
                prepare = None
            if entry.get("round") == 1:
                bench.at(f"{entry['t']} ps", lambda entry=entry: apply(bench, entry))  # type: ignore[misc]
            else:
                if entry["t"] > bench.now_ps:
                    bench.run_to(f"{entry['t']} ps")
                apply(bench, entry)
        except (KeyError, TypeError, ValueError) as error:
            raise BenchFileError(f"journal {path}, line {number}: {error}") from error
    bench.run(0)  # a journal that was cut off may end with an input: it takes effect
    bench.catch_up()
    return bench


def _check_laws(path: str | PathLike[str], found: list[dict[str, Any]], allowed: bool) -> None:
    """Refuse a journal that was made by other laws, or warn of it."""
    different = differing(found)
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


def apply(bench: Bench, entry: dict[str, Any]) -> None:
    """Do again what an entry says."""
    do = entry["do"]
    if do == "add":
        options = entry["options"]
        if options.get("store") is not None:
            options["store"] = Memory(bytes(options["store"]))
        bench.add(entry["part"], entry["name"], entry["crystal_hz"], entry["straps"], entry["bare"], **options)
    elif do == "host":
        chips = [bench.chips[name] for name in entry["chips"]]
        line = bench[entry["line"]] if entry.get("line") else None
        bench.host(*chips, name=entry["name"], delay=f"{entry['delay_ps']} ps", baud=entry.get("baud"), line=line)
    elif do == "connect":
        bench.connect(bench[entry["part"]], [bench.chips[name] for name in entry["chips"]])
    elif do == "part":
        bench.part(entry["kind"], entry["name"], **entry["options"])
    elif do == "input":
        getattr(bench[entry["part"]], entry["verb"])(*entry["args"])
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
    elif "host" in entry:
        tell(bench, bench[entry["host"]], do, entry["args"])
    else:
        raise BenchFileError(f"unknown entry {do!r}")


def tell(bench: Bench, host: Any, do: str, args: list[Any]) -> None:
    """Tell a host again what it was told."""
    if do == "send":
        chip, data = args
        host.to(chip).send(bytes.fromhex(data))
    elif do in ("clear", "drop", "give_up"):
        getattr(host, do)()
    elif do == "call":
        verb, chip, *more = args
        host.to(chip).wait_for = None  # the journal itself says how time passed
        getattr(host, verb)(*more)
    elif do == "script":
        from .script import run_script

        chip, text, where = args
        run_script(bench, host.to(chip), text, where)
    else:
        raise BenchFileError(f"unknown entry {do!r}")
