"""A module on its own bench, with a serial line for a program, as provided by a URL or a fixture.

    program --- line ---> connector ---> module
            <----------- (SerialHost) <---

The connector is a host in virtual time.  The line carries the program's bytes to and from the
connector, and may add noise.

Virtual time passes only while the program waits for characters; if a rate is set, it follows the wall
clock instead.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from threading import Condition, RLock
from typing import Any, Protocol, TypeVar, cast
from urllib.parse import parse_qsl, urlsplit

from ..bench import Bench
from ..bench.memories import is_outside, put_memory
from ..bench.runner import Wait
from ..chips import CATALOGUE, sheet_of
from ..core.chip import Chip
from ..core.datasheet import channel
from ..core.datasheet.option import Option, checked, read
from ..core.datasheet.table import Sheet
from ..core.messages.calls import level_of_caller
from ..core.time.timebase import PS_PER_S
from ..core.wires.net import Net
from ..errors import UnknownName, UsageError
from ..links.lines.line_transcript import TranscriptFile
from ..links.lines.memory_file import FileStore
from ..links.lines.pace import Lockstep, Pace, Paced
from ..links.lines.served_line import ConnectorLine
from ..parts.hosts.adaptive_host import AdaptiveHost
from ..parts.hosts.serial_host import SerialHost

Result = TypeVar("Result")
SCHEME = "slewline"
SLEPT_NS = 1_000_000_000  # of the wall clock: a program with other work seldom takes as long
LIBRARIES = ("slewline", "serial", "serialx", "pyvisa")  # between a program and a module
SLICES = 50  # maximum number, to catch up with the wall clock
YIELD_S = 1e-4  # of the wall clock: pause between two slices, for other threads
STRAP = Option("strap", "int", None, "level of an input")
OWN = (  # keys of a URL besides the straps and options of the module
    Option("name", "text", None, "the module is the same one whenever it is opened under this name"),
    Option("store", "text", None, "a file that keeps the EEPROM"),
    Option("memory", "text", None, "an image of the external memory of the chip: a dump, or Intel HEX"),
    Option("seed", "int", 0, "seed for all random behaviour"),
    Option("rate", "text", None, "virtual seconds per second of the wall clock"),
    Option("log", "text", None, "a file for the transcript"),
)
NAMED: dict[str, Rig] = {}  # modules that are kept while they are not open, until the process ends
ENDED: set[str] = set()  # names of modules ended by a test: no other module is given one of them
CLOSED = "the module has been closed"
LOOK_PS = 10**11  # the time of a failed search for a port that has gone


class PortUser(Protocol):
    """The program's end of a port that it has open."""

    def lose(self, why: str) -> None:
        """Record that the port has been removed, for the reason `why`."""


class OnDemandTime(Lockstep):
    """Pacing in which virtual time passes only while the program waits: as far as needed, without a real delay."""

    lockstep = False  # the line does not let time pass itself when bytes have arrived


class WallClockTime(Paced):
    """Pacing in which virtual time follows the wall clock, and catches up whenever the program polls."""

    def pass_time(self) -> bool:
        """Advance virtual time towards the wall clock, by at most one slice; return whether it has caught up."""
        return Pace.pass_time(self)

    def present(self) -> None:
        """Let virtual time catch up with the wall clock, or only partly if the rate is too high for this machine."""
        goal = self.goal()
        for _ in range(SLICES):
            if self.kernel.now >= goal:
                break
            self.pass_time()


def serial_line(sheet: Sheet) -> channel.Channel | None:
    """Return the channel that is a part's serial line, or None if the part has no serial line."""
    return sheet.channel(channel.SerialLine) or sheet.channel(channel.AdaptiveLine)


class Rig:
    """A module with its bench and its line.

    Args:
        part: a name such as "gs-c200s", the name of an entry point, "my_lab.mx10:Mx10", or the class of a chip.
        straps: the straps of the module; if BR0 to BR2 are not given, the module has the highest
            rate in its data sheet.
        store: a file that holds the EEPROM, which may be the chip's external memory.
        memory: a file with an image of the external memory, as a dump or in Intel HEX.
        rate: virtual seconds per real second; None if virtual time does not wait for the wall clock.
        log: a file for the transcript.
        options: the options of the part.
    """

    def __init__(
        self,
        part: str | type[Chip],
        *,
        name: str | None = None,
        straps: Mapping[str, int] | None = None,
        store: str | PathLike[str] | None = None,
        memory: str | PathLike[str] | None = None,
        seed: int = 0,
        rate: str | float | None = None,
        log: str | PathLike[str] | None = None,
        **options: Any,
    ) -> None:
        self.part = CATALOGUE.name_of(part) if isinstance(part, type) else CATALOGUE.canonical(part)
        sheet = sheet_of(part)
        self.channel = self.channel_of(sheet)
        if not isinstance(seed, int):
            raise UsageError(f"seed {seed!r}; expected a whole number")
        self.bench = Bench(seed)
        kept = None if store is None else store_at(store)
        external = is_outside(sheet)
        if kept is not None and not external:
            options["store"] = kept
        self.chip = self.bench.add(part, name, straps={**self.channel.fastest, **(straps or {})}, **options)
        put_memory(self.bench, self.chip, memory, store=kept if external else None)
        self.pace = self.pace_of(rate)
        self.log = TranscriptFile(self.bench.kernel, log)
        self.left_ns = self.pace.clock()  # when the program was last here, by the wall clock
        self.lock = RLock()  # programs read in one thread and write in another; released while one waits
        self.change = Condition(self.lock)
        self.reach()

    warned = False  # about a program that sleeps in real time
    away = ""  # why a program does not find the port; "" if it does
    program: PortUser | None = None  # the program that has the port open

    def unplug(self, why: str) -> None:
        """Remove the port, even if open, as if its adapter were unplugged (reason: `why`); the module is unchanged."""
        self.away = why
        if self.program is not None:
            self.program.lose(why)

    def plug(self) -> None:
        """Make the port available again after `unplug`; a program that had it open must reopen it."""
        self.away = ""

    def look(self) -> str:
        """Return "" if the port is present; otherwise let 100 ms of virtual time pass, and return why it is absent."""
        if why := self.away:
            self.wait(never, LOOK_PS)
        return why

    def channel_of(self, sheet: Sheet) -> channel.Channel:
        """Return the channel over which a program reaches the module."""
        serial = serial_line(sheet)
        if serial is None:
            raise UsageError(f"{self.part} has no serial line; command it through bench.host(chip)")
        return serial

    def reach(self) -> None:
        """Put the connector for a program on the bench, and set the URL of the module."""
        host = self.bench.host(self.chip, name="line", over=self.channel.name)
        self.host = cast("SerialHost | AdaptiveHost", host)  # that of a serial line
        self.line = ConnectorLine(self.chip.name, [self.chip], self.pace, self.log, self.host)
        self.url = f"{SCHEME}://{self.part}?name={self.chip.name}"

    def begin(self) -> None:
        """Switch the module on; it then accepts commands."""
        self.bench.run(0)
        self.pace.start()

    def pace_of(self, rate: str | float | None) -> Pace:
        """Return the pacing of virtual time: on demand if `rate` is None, else by the wall clock."""
        return OnDemandTime(self.bench) if rate is None else WallClockTime(self.bench, rate)

    def quiet(self) -> bool:
        """Return whether everything sent to the module has been executed and answered."""
        return self.line.quiet()

    # ---------------------------------------------------------------------------------------------------------- time
    def wait(
        self,
        met: Callable[[], bool],
        ps: int,
        when: Callable[[], int | None] | None = None,
        nets: Iterable[Net] = (),
    ) -> bool:
        """Let virtual time pass until a condition is met, for at most `ps` picoseconds; return whether it was."""
        over: list[bool] = []
        self.check_slept()
        with self.lock:
            self.pace.present()
            self.change.notify_all()
            self.pace.wait(Wait(met, self.pace.kernel.now + ps, over.append, when, nets))
            while not over:
                done = self.pace.pass_time()
                if not over:
                    self.change.wait(max(self.pace.pause() or 0, YIELD_S) if done else YIELD_S)
        self.left_ns = self.pace.clock()
        return over[0]

    def check_slept(self) -> None:
        """Warn, once only, if the program pauses for 1 s while the module is busy, as no virtual time passes then."""
        gap = self.pace.clock() - self.left_ns
        if gap < SLEPT_NS or self.warned or not isinstance(self.pace, OnDemandTime):
            return
        if self.chip.idle or not self.bench.now_ps:
            return
        self.warned = True
        warnings.warn(
            f"{self.url}: {gap / 1e9:.1f} s of real time have passed, but no virtual time: the module is unchanged. "
            "Virtual time passes only during calls to the port: call port.sleep(...) instead of time.sleep(...), or "
            "give a rate in the URL, rate=1.",
            stacklevel=level_of_caller(LIBRARIES),
        )

    def present(self) -> int:
        """Return the current instant of virtual time (ps); with a rate, let it first catch up with the wall clock."""
        self.do(self.pace.present)
        return self.pace.kernel.now

    def poll(self) -> None:
        """Let one character time pass, so that polling makes progress; with a rate, catch up with the wall clock."""
        if isinstance(self.pace, WallClockTime):
            self.present()
        else:
            self.wait(never, self.host.uart.clock.ps(self.host.word.ticks))

    def do(self, action: Callable[[], Result]) -> Result:
        """Call a function while no time passes, let waiting threads check their conditions, and return the result."""
        with self.lock:
            result = action()
            self.change.notify_all()
        return result

    def resume(self) -> None:
        """Continue the transcript, because a program opens the port."""
        self.log.reopen()

    def leave(self) -> None:
        """Report incomplete commands and write unsaved data to disk, because the program closes the line."""
        self.bench.conclude()
        for part in self.bench.parts.values():
            part.leave()

    def close(self) -> None:
        """Report incomplete commands, write unsaved data to disk, and end the transcript."""
        self.leave()
        self.log.close()


def never() -> bool:
    """Return False: a condition that is never met, so that a wait for it ends only when it times out."""
    return False


def seconds(time: float) -> int:
    """Return a time in seconds, pySerial's unit, as picoseconds."""
    return round(time * PS_PER_S)


def store_at(path: str | PathLike[str]) -> FileStore:
    """Return the file store of an EEPROM; the file need not exist, but its directory must."""
    if Path(path).is_dir() or not Path(path).parent.is_dir():
        raise UsageError(f"store {path}: expected a file in a directory that exists, such as left.eeprom")
    return FileStore(path)


# ----------------------------------------------------------------------------------------------------------------- URLs
def from_url(url: str, allow_code: bool = False) -> Rig:
    """Return the module for a URL: a new one or, if its name has been used before, the module created under that name.

    A URL may come from anywhere, such as a settings file, so it must not name a Python module unless that is allowed.

    Args:
        allow_code: whether the part may be given as module:Class, the import of which runs code from the module.

    Raises:
        UsageError: there is no such part, strap or option; or another module already has the name.
        FileNotFoundError: the module with the name has been closed.
    """
    split = urlsplit(url)
    part, query = CATALOGUE.canonical(split.netloc), _query(url, split.query)
    junk = split.path.strip("/") or split.fragment
    if junk:
        raise UsageError(f"{url}: unexpected {junk!r}; expected {SCHEME}://{part}?name=value&...")
    name = query.get("name")
    if name not in NAMED or NAMED[name].part != part:
        with named_by(url):
            sheet_of(part, allow_code=allow_code)
    if name in ENDED:
        raise FileNotFoundError(f"{url}: {CLOSED}")
    if name not in NAMED:
        with named_by(url):
            rig = Rig(part, **settings(part, query))
        rig.begin()
        rig.url = url
        if name is None:
            return rig
        NAMED[name] = rig
    rig = NAMED[name]
    named = rig.part
    if part != named or (len(query) > 1 and url != rig.url):
        that = f"{name!r} is already the name of {rig.url}; give the new module another name"
        raise UsageError(f"{url}: {that}, or open the existing one: {SCHEME}://{named}?name={name}")
    return rig


@contextmanager
def named_by(url: str) -> Iterator[None]:
    """Put the module's URL at the start of errors raised in the block."""
    try:
        yield
    except (UnknownName, UsageError) as error:
        raise UsageError(f"{url}: {error}") from None  # a ValueError, as pySerial raises for a wrong URL


def _query(url: str, text: str) -> dict[str, str]:
    pairs = parse_qsl(text, keep_blank_values=True)
    keys = [key for key, _ in pairs]
    twice = next((key for key in keys if keys.count(key) > 1), None)
    if twice is not None:
        raise UsageError(f"{url}: {twice} is given twice; give it once")
    return dict(pairs)


def settings(part: str, query: Mapping[str, str]) -> dict[str, Any]:
    """Convert the query of a URL to arguments for a Rig, keyed by name."""
    sheet = sheet_of(part)
    inputs = {row.name for row in sheet.pins if row.in_out == "in"}
    straps = {key: STRAP.read(text) for key, text in query.items() if key in inputs}
    own = {row.name for row in OWN}
    rows = [*OWN, *(row for row in sheet.options if row.name not in own)]  # the URL's keys take precedence
    rest = {key: text for key, text in query.items() if key not in inputs}
    known = {row.name for row in rows}
    if unknown := {key: text for key, text in rest.items() if key.partition(".")[0] not in known}:
        # refused here, as it may be the name of an argument
        checked(part, sheet.options, unknown, elsewhere=sheet.elsewhere)
    return {"straps": straps, **read(rows, rest.items())}


class HasRig:
    """The attributes with which a port gives access to the module at its other end."""

    rig: Rig

    @property
    def bench(self) -> Bench:
        """The bench of the module, for tests that need its internals."""
        return self.rig.bench

    @property
    def chip(self) -> Chip:
        """The module itself."""
        return self.rig.chip
