"""slewline serve: chips on ports, for host software that knows nothing of all this."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..bench import Bench
from ..chips import sheet_of
from ..core.option import read
from ..errors import SlewlineError, UsageError
from .files import say_replaced

try:
    import fcntl
    import termios  # noqa: F401  # for a pty; where one of them is missing, signals and pipes differ as well
except ImportError:
    raise SlewlineError(
        "serve needs Linux, or another POSIX system (WSL has one); here everything else works: run, lint, plots, the "
        "pytest plugin, and slewline:// URLs, with which a program in Python finds a module without a server"
    ) from None

if TYPE_CHECKING:
    from ..links.line import Line
    from ..links.pace import Pace
    from ..links.server import Server
    from ..links.store import FileStore

    Stores = Callable[[str], FileStore]
    Call = Callable[..., object]

PORTS = ("tcp", "pty", "rfc2217", "serial")
STATUS_S = 1.0


@dataclass
class Serve:
    """What is to be served, as the command line asks for it."""

    chip: str | None
    bench: str | None
    tcp: str | None
    pty: str | None
    rfc2217: str | None
    serial: str | None
    framing: bool
    rate: str | None
    lockstep: bool
    control: str | None
    token: str | None
    state: str | None
    log: str | None
    journal: str | None
    anywhere: bool
    allow_code: bool
    strap: tuple[tuple[str, int], ...]
    option: tuple[tuple[str, str], ...]
    allow_remote: bool
    status: bool

    def perform(self) -> int:
        """Do it, until a signal ends it; returns the exit status."""
        ports = self.check_options()
        say_replaced(self.journal)
        with state_directory(self.state) as stores:
            bench = self.furnished(stores)
            server = self.server(bench)
            with signals(server):
                self.open_ports(server, ports)
                if self.status:
                    server.loop.ask(lambda: show_again(server))
                server.run()
        return 0

    def open_ports(self, server: Server, ports: list[tuple[str, str]]) -> None:
        """Open what is asked for, and tell where it is found."""
        try:
            found = self.open_bench_file(server) if self.bench else self.open_chip(server, *ports[0])
            if self.control:
                found.append(("control", server.control(self.control, self.token).where))
            for name, where in found:
                click.echo(f"{name}: {where}")
            sys.stdout.flush()
        except BaseException:
            server.close()
            raise

    def check_options(self) -> list[tuple[str, str]]:
        """Refuse options that exclude each other; return the ports that are asked for."""
        ports = [(kind, where) for kind in PORTS if (where := getattr(self, kind)) is not None]
        if (self.chip is None) == (self.bench is None):
            raise click.UsageError("give a chip, such as gs-c200s, or --bench FILE; and only one of them")
        if self.bench is not None and (ports or self.strap or self.option or self.framing):
            raise click.UsageError(
                "a bench file says all of this itself; leave out ports, --strap, --option, --framing"
            )
        if self.chip is not None and not ports:
            raise click.UsageError(f"where? Give one of --{', --'.join(PORTS)}")
        if len(ports) > 1:
            given = " and ".join(f"--{kind}" for kind, _ in ports)
            raise click.UsageError(f"a chip has one port, and {given} are {len(ports)}; leave out all but one")
        if self.lockstep and self.rate is not None:
            raise click.UsageError("--lockstep has no clock; leave out --rate")
        if self.anywhere and self.bench is None:
            raise click.UsageError("--anywhere goes with --bench")
        if self.allow_code and self.bench is None:
            raise click.UsageError("--allow-code goes with --bench; CHIP is allowed to name a module anyway")
        if self.log and self.journal and os.path.realpath(self.log) == os.path.realpath(self.journal):
            raise click.UsageError("--log and --journal: the same file; give each a file of its own")
        if self.state is not None and self.chip is not None and not keeps(self.chip):
            raise click.UsageError(f"--state keeps EEPROMs, and a {self.chip} has none; leave it out")
        return ports

    # ---------------------------------------------------------------------------------------------------- furnishing
    def furnished(self, stores: Stores | None) -> Bench:
        """Return the bench, of one chip or from a file."""
        if self.bench is not None:
            from ..bench.file import BenchFile

            self.file = BenchFile(self.bench, self.anywhere, self.allow_code)
            if not self.file.tables.serve:
                raise UsageError(f"{self.bench}: no [[serve]] table, so there is nothing to serve")
            return self.file.load(journal=self.journal, stores=stores)
        assert self.chip is not None
        bench = Bench(journal=self.journal, stores=stores)
        sheet = sheet_of(self.chip)
        # nothing strapped is the slowest
        bench.add(self.chip, straps=sheet.fastest | dict(self.strap), **read(sheet.options, self.option))
        return bench

    def server(self, bench: Bench) -> Server:
        """Return the server, without ports."""
        from ..links.pace import Lockstep, Paced
        from ..links.server import Server

        pace: Pace = Lockstep(bench) if self.lockstep else Paced(bench, self.rate or "1")
        return Server(bench, pace, self.log, self.allow_remote, lambda text: say(f"slewline: {text}"))

    def open_chip(self, server: Server, kind: str, where: str) -> list[tuple[str, str]]:
        """Open the port of the only chip; return its name, and where it is found."""
        line = server.line(*server.bench.chips.values(), framing=self.framing)
        return [(titled(line), getattr(server, kind)(line, where).where)]

    def open_bench_file(self, server: Server) -> list[tuple[str, str]]:
        """Open the ports of a bench file; return the name of each, and where it is found."""
        found = []
        served = self.file.served(server.bench)
        lines = []
        for port in served:
            with self.file.at("serve", port.number):
                lines.append(server.line(*port.chips, framing=port.framing, over=port.over))
        for port, line in zip(served, lines, strict=True):
            with self.file.at("serve", port.number, port.kind):
                found.append((titled(line), getattr(server, port.kind)(line, port.where).where))
        return found


def keeps(part: str) -> bool:
    """Return whether a part keeps anything without power."""
    return sheet_of(part).keeps


def titled(line: Line) -> str:
    """Return a line by its name; modules that share it, with their addresses."""
    if len(line.chips) == 1:
        return line.name
    addresses = ", ".join(str(chip.strapped_address()) for chip in line.chips)  # type: ignore[attr-defined]
    return f"{line.name} (addresses {addresses})"


@contextmanager
def state_directory(path: str | None) -> Iterator[Stores | None]:
    """Yield the memories of chips, by name, in a directory that one server at a time holds; None: no such directory.

    Raises:
        UsageError: it cannot be written, or another server has it.
    """
    if path is None:
        yield None
        return
    directory = Path(path)
    try:
        directory.mkdir(parents=True, exist_ok=True)
        lock = os.open(directory / ".lock", os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise UsageError(f"--state {path}: {error.strerror}; give a directory that can be written") from None
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(lock)
        raise UsageError(f"--state {path}: another server has it; end that one, or give another directory") from None
    try:
        yield lambda name: stored(directory / f"{name}.eeprom")
    finally:
        os.close(lock)


def stored(path: Path) -> FileStore:
    """Return a memory in a file; a damaged one is reported now, not when a program is missing."""
    from ..links.store import FileStore

    store = FileStore(path)
    store.read()
    return store


def say(text: str, end: str = "\n") -> None:
    """Tell something on the standard error, which may have nobody who reads."""
    with suppress(OSError):
        click.echo(f"{text}{end}", err=True, nl=False)


def show(server: Server, end: str = "\n") -> None:
    """Print a status line."""
    from ..links.status import as_line

    say(as_line(server), end)


def show_again(server: Server) -> None:
    """Print a status line every second; on a terminal, the next one is written over it."""
    show(server, "\033[K\r" if sys.stderr.isatty() else "\n")
    server.loop.after(STATUS_S, lambda: show_again(server))


@contextmanager
def signals(server: Server) -> Iterator[None]:
    """End the server in good order on SIGINT, SIGTERM and SIGHUP; print a status line on SIGUSR1.

    From the first one on they mean nothing any more: the process ends anyway.  A SIGHUP that is ignored, as `nohup` has
    it, stays so.
    """
    ends = [signal.SIGINT, signal.SIGTERM]
    if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        ends.append(signal.SIGHUP)

    def end(*_: object) -> None:
        ignore(ends)
        server.stop()

    calls: dict[int, Call] = dict.fromkeys(ends, end)
    calls[signal.SIGUSR1] = lambda *_: server.loop.ask(lambda: show(server))
    kept = {number: signal.signal(number, call) for number, call in calls.items()}
    try:
        yield
    except BaseException:
        for number, handler in kept.items():
            signal.signal(number, handler)
        raise
    ignore(kept)


def ignore(numbers: Iterable[int]) -> None:
    """Let signals mean nothing, held back meanwhile: one that finds its handler gone would be complained of."""
    kept = signal.pthread_sigmask(signal.SIG_BLOCK, numbers)
    for number in numbers:
        signal.signal(number, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_SETMASK, kept)
