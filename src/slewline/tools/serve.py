"""slewline serve: chips on ports, for host software that knows nothing of all this."""

from __future__ import annotations

import fcntl
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..bench import Bench
from ..chips import sheet_of
from ..errors import UsageError

if TYPE_CHECKING:
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
    state: str | None
    log: str | None
    journal: str | None
    strap: tuple[tuple[str, int], ...]
    option: tuple[tuple[str, Any], ...]
    allow_remote: bool
    status: bool

    def perform(self) -> int:
        """Do it, until a signal ends it; returns the exit status."""
        ports = self.check_options()
        with state_directory(self.state) as stores:
            bench = self.furnished(stores)
            server = self.server(bench)
            try:
                found = self.open_bench_file(server) if self.bench else self.open_chip(server, *ports[0])
                if self.control:
                    found.append(("control", server.control(self.control).where))
            except BaseException:
                server.close()
                raise
            with signals(server, self.status):
                for name, where in found:
                    click.echo(f"{name}: {where}")
                sys.stdout.flush()
                server.run()
        return 0

    def check_options(self) -> list[tuple[str, str]]:
        """Options that exclude each other; returns the ports that are asked for."""
        ports = [(kind, where) for kind in PORTS if (where := getattr(self, kind)) is not None]
        if (self.chip is None) == (self.bench is None):
            raise click.UsageError("give a chip, such as gs-c200s, or --bench FILE; and only one of them")
        if self.bench is not None and (ports or self.strap or self.option or self.framing):
            raise click.UsageError(
                "a bench file says all of this itself; leave out ports, --strap, --option, --framing"
            )
        if self.chip is not None and len(ports) != 1:
            raise click.UsageError(f"where? Give one of --{', --'.join(PORTS)}")
        if self.lockstep and self.rate is not None:
            raise click.UsageError("--lockstep has no clock; leave out --rate")
        return ports

    # ---------------------------------------------------------------------------------------------------- furnishing
    def furnished(self, stores: Stores | None) -> Bench:
        """The bench, of one chip or from a file."""
        if self.bench is not None:
            from ..bench.file import BenchFile

            self.file = BenchFile(self.bench)
            if not self.file.tables.serve:
                raise UsageError(f"{self.bench}: no [[serve]] table, so there is nothing to serve")
            return self.file.load(journal=self.journal, stores=stores)
        assert self.chip is not None
        bench = Bench(journal=self.journal, stores=stores)
        port = sheet_of(self.chip).port
        fastest = port.fastest if port is not None else {}  # nothing strapped is the slowest
        bench.add(self.chip, straps=fastest | dict(self.strap), **dict(self.option))
        return bench

    def server(self, bench: Bench) -> Server:
        """The server, without ports."""
        from ..links.pace import Lockstep, Paced
        from ..links.server import Server

        pace: Pace = Lockstep(bench) if self.lockstep else Paced(bench, self.rate or "1")
        return Server(bench, pace, self.log, self.allow_remote)

    def open_chip(self, server: Server, kind: str, where: str) -> list[tuple[str, str]]:
        """The port of the only chip: its name, and where it is found."""
        line = server.line(*server.bench.chips.values(), framing=self.framing)
        return [(line.name, getattr(server, kind)(line, where).where)]

    def open_bench_file(self, server: Server) -> list[tuple[str, str]]:
        """The ports of a bench file."""
        found = []
        served = self.file.served(server.bench)
        lines = []
        for port in served:
            with self.file.at("serve", port.number):
                lines.append(server.line(*port.chips, framing=port.framing))
        for port, line in zip(served, lines, strict=True):
            with self.file.at("serve", port.number, port.kind):
                found.append((line.name, getattr(server, port.kind)(line, port.where).where))
        return found


@contextmanager
def state_directory(path: str | None) -> Iterator[Stores | None]:
    """The memories of chips, by name, in a directory that one server at a time holds; None: no such directory.

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
    """A memory in a file; a damaged one is told now, not when a program is missing."""
    from ..links.store import FileStore

    store = FileStore(path)
    store.read()
    return store


@contextmanager
def signals(server: Server, shows_status: bool) -> Iterator[None]:
    """SIGINT and SIGTERM end the server in good order; SIGUSR1 asks for a status line."""

    def show(end: str = "\n") -> None:
        from ..links.status import as_line

        click.echo(f"{as_line(server)}{end}", err=True, nl=False)

    def show_again() -> None:
        show("\033[K\r")  # the next one is written over it
        server.loop.after(STATUS_S, show_again)

    calls: dict[int, Call] = {signal.SIGUSR1: lambda *_: server.loop.ask(show)}
    calls |= dict.fromkeys((signal.SIGINT, signal.SIGTERM), lambda *_: server.stop())
    kept = {number: signal.signal(number, call) for number, call in calls.items()}
    if shows_status and sys.stderr.isatty():
        server.loop.ask(show_again)
    try:
        yield
    finally:
        for number, handler in kept.items():
            signal.signal(number, handler)
