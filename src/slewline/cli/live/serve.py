"""slewline serve: chips on ports, for unmodified host software."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import click
from click.core import ParameterSource

from ...bench import Bench
from ...bench.memories import is_outside, put_memory
from ...chips import CATALOGUE, sheet_of
from ...core.datasheet.channel import AdaptiveLine, FlowBus
from ...core.datasheet.option import checked, read
from ...errors import StoreError, UsageError
from ..files import read_options, report_replaced
from ..single import BenchOptions
from .process import PanelProcess, kept_journal

if TYPE_CHECKING:
    from ...bench.file import BenchFile
    from ...core.datasheet.table import Sheet
    from ...links.lines.background import BackgroundStore
    from ...links.lines.pace import Pace
    from ...links.lines.served_line import HostLine
    from ...links.server import Server
    from ...links.sockets.loop import Loop

    Stores = Callable[[str], BackgroundStore]
    Call = Callable[..., object]

PORTS = ("tcp", "pty", "rfc2217", "serial")
BAUD_RATES = ("300", "600", "1200", "2400", "4800", "9600", "19200", "38400", "57600", "115200")
REGISTERS = "registers"  # of the bus of a chip that has a serial line too
STATUS_S = 1.0


@dataclass
class ServeCommand(BenchOptions):
    """The chips, ports and options of a server."""

    bench: str | None
    tcp: str | None
    pty: str | None
    rfc2217: str | None
    serial: str | None
    registers: str | None
    card: str | None
    framing: bool
    prologix: bool
    rate: str | None
    lockstep: bool
    control: str | None
    token: str | None
    state: str | None
    memory: str | None
    log: str | None
    journal: str | None
    baud: str | None  # set by straps
    option: tuple[tuple[str, str], ...]
    options: str | None
    allow_remote: bool
    status: bool
    panel: str | None = None

    def perform(self) -> int:
        """Serve until a signal ends it; return the exit status."""
        ports = self.check_options()
        report_replaced(self.journal)
        with ExitStack() as stack, state_directory(self.state, self.lockstep) as stores:
            panel = None
            if self.panel is not None:
                panel = stack.enter_context(PanelProcess.beside(self.panel, allow_remote=self.allow_remote))
                self.journal = stack.enter_context(kept_journal(self.journal))
            bench = self.new_bench(stores)
            server = self.server(bench)
            with signals(server):
                self.open_ports(server, ports, panel)
                if self.status:
                    server.loop.ask(lambda: show_again(server))
                server.run()
        return 0

    def open_ports(self, server: Server, ports: list[tuple[str, str]], panel: PanelProcess | None) -> None:
        """Open the requested ports, and print their addresses."""
        try:
            found = open_bench_file(server, self.file) if self.bench else self.open_chip(server, ports)
            if self.control:
                found.append(("control", server.control(self.control, self.token).where))
            if panel is not None:
                panel.open(server)
                found.append(("panel", panel.url))
            show_ports(found)
        except BaseException:
            server.close()
            raise

    def check_options(self) -> list[tuple[str, str]]:
        """Refuse options that exclude each other; return the requested ports."""
        ports = [(kind, where) for kind in PORTS if (where := getattr(self, kind)) is not None]
        if (self.chip is None) == (self.bench is None):
            raise click.UsageError("give either a chip, such as gs-c200s, or --bench FILE")
        if self.baud is not None:
            message = sheet_of(self.chip).elsewhere("baud", self.baud) if self.chip is not None else ""
            raise click.UsageError(f"--baud {self.baud}: {message or 'this part has no baud rate; leave out --baud'}")
        if self.rate in BAUD_RATES and self.chip is not None:
            message = sheet_of(self.chip).elsewhere("baud", self.rate) or "this part has none of its own"
            remark(f"--rate {self.rate}: time passes {self.rate} times as fast; if a baud rate was meant: {message}")
        own = (*ports, self.registers, self.strap, self.option, self.options, self.framing, self.prologix, self.memory)
        if self.bench is not None and any((*own, self.card)):
            raise click.UsageError(
                "a bench file sets its own ports and options; leave out ports, --strap, --option, --options, --memory, "
                "--framing, --prologix, --card"
            )
        if self.registers is not None and (self.chip is None or bus_of(self.chip) is None):
            raise click.UsageError(
                f"--registers is for a chip with a bus and a serial line; a {self.chip} is served with "
                f"--{', --'.join(PORTS)}"
            )
        if self.chip is not None and not ports and self.registers is None:
            bus = f", or --{REGISTERS} for its bus" if bus_of(self.chip) else ""
            raise click.UsageError(f"no port given; give one of --{', --'.join(PORTS)}{bus}")
        if len(ports) > 1:
            given = " and ".join(f"--{kind}" for kind, _ in ports)
            raise click.UsageError(f"{given}: a chip has one port; leave out all but one")
        if self.registers is not None:
            ports.append((REGISTERS, self.registers))
        if self.framing and self.prologix:
            raise click.UsageError("--framing and --prologix: a port can have only one of the two; leave one out")
        if self.lockstep and self.rate is not None:
            raise click.UsageError("--lockstep: time does not follow a clock; leave out --rate")
        if self.anywhere and self.bench is None:
            raise click.UsageError("--anywhere needs --bench")
        if self.allow_code and self.bench is None:
            raise click.UsageError("--allow-code needs --bench; a chip given as module:Class needs no --allow-code")
        ctx = click.get_current_context(silent=True)
        if ctx and ctx.get_parameter_source("token") is ParameterSource.COMMANDLINE and not self.control:
            raise click.UsageError("--token: belongs to a control port; add --control HOST:PORT, or leave out --token")
        if self.log and Path(self.log).suffix[1:].lower() in CATALOGUE.names():
            raise click.UsageError(
                f"--log {self.log} is a program, judging by its extension; give the transcript another name"
            )
        if self.log and self.journal and os.path.realpath(self.log) == os.path.realpath(self.journal):
            raise click.UsageError("--log and --journal: the same file; give each a file of its own")
        if self.state is not None and self.chip is not None and not keeps(self.chip):
            raise click.UsageError(f"--state stores EEPROMs, but a {self.chip} has none; leave out --state")
        return ports

    # ---------------------------------------------------------------------------------------------------- the bench
    def new_bench(self, stores: Stores | None) -> Bench:
        """Return the bench: with the one chip given, or as described by the bench file."""
        if self.bench is not None:
            self.file = self.bench_file(self.bench)
            if not self.file.tables.serve:
                raise UsageError(f"{self.bench}: no [[serve]] table, so there is nothing to serve")
            return self.file.load(journal=self.journal, stores=stores)
        part = cast("str", self.chip)  # given if there is no bench file
        bench = Bench(journal=self.journal, stores=stores)
        sheet = sheet_of(part)
        # the slowest without straps
        options = joined(read_options(self.options, part), read(sheet.options, self.option))
        checked(sheet.part, sheet.options, options, elsewhere=sheet.elsewhere)
        chip = bench.add(part, straps=sheet.fastest | dict(self.strap), **options)
        put_memory(bench, chip, self.memory)
        return bench

    def server(self, bench: Bench) -> Server:
        """Return the server, without ports."""
        from ...links.lines.pace import Lockstep, Paced
        from ...links.server import Server

        pace: Pace = Lockstep(bench) if self.lockstep else Paced(bench, self.rate or "1")
        return Server(bench, pace, self.log, self.allow_remote, remark)

    def open_chip(self, server: Server, ports: list[tuple[str, str]]) -> list[tuple[str, str]]:
        """Open the given ports for the only chip; return the name and address of each."""
        (chip,), found = server.bench.chips.values(), []
        for kind, where in ports:
            over = over_which(chip.sheet, kind)
            line = server.line(chip, framing=self.framing, over=over, prologix=self.prologix, card=self.card)
            found.append((titled(line), getattr(server, "tcp" if kind == REGISTERS else kind)(line, where).where))
        return found


def open_bench_file(server: Server, file: BenchFile) -> list[tuple[str, str]]:
    """Open the ports of a bench file; return the name and address of each."""
    found = []
    served = file.served(server.bench)
    lines = []
    for port in served:
        with file.at("serve", port.number):
            lines.append(
                server.line(*port.chips, framing=port.framing, over=port.over, prologix=port.prologix, card=port.card)
            )
    for port, line in zip(served, lines, strict=True):
        with file.at("serve", port.number, port.kind):
            if port.kind == "serial":
                remark(f"{file.path}: opens the serial port {port.where} of this machine for {line.name}")
            found.append((titled(line), getattr(server, port.kind)(line, port.where).where))
    return found


def show_ports(found: Iterable[tuple[str, str]]) -> None:
    """Print the name and address of each port, and flush, because a program may be waiting for them."""
    for name, where in found:
        click.echo(f"{name}: {where}")
    sys.stdout.flush()


def bus_of(part: str) -> str | None:
    """Return the name of the bus of a part with several channels.

    None if the part has only one channel, or if none of its channels is a bus.
    """
    return over_which(sheet_of(part), REGISTERS)


def over_which(sheet: Sheet, kind: str) -> str | None:
    """Return the name of the channel that a port of a given kind serves.

    The result is None if the part has only one channel, or no channel of the kind that the port needs.
    """
    if len(sheet.channels) == 1:
        return None
    wanted = FlowBus if kind == REGISTERS else AdaptiveLine
    return next((channel.name for channel in sheet.channels if isinstance(channel, wanted)), None)


def joined(one: Mapping[str, Any], two: Mapping[str, Any]) -> dict[str, Any]:
    """Return options merged from two sources: `two` overrides `one`, and tables in both are merged key by key."""
    both = {name for name in one if isinstance(one[name], dict) and isinstance(two.get(name), dict)}
    return {**one, **two, **{name: one[name] | two[name] for name in both}}


def keeps(part: str) -> bool:
    """Return whether a part has a non-volatile memory."""
    sheet = sheet_of(part)
    return sheet.keeps or is_outside(sheet)


def titled(line: HostLine) -> str:
    """Return the name of a served line; if several chips share the line or bus, include their addresses."""
    from ...links.ports.prologix import PrologixLine

    if isinstance(line, PrologixLine):
        addresses = [str(address) for address in line.devices]
    elif len(line.chips) == 1:
        return line.name
    else:
        addresses = [str(chip.strapped_address()) for chip in line.chips]  # type: ignore[attr-defined]
    return f"{line.name} ({'address' if len(addresses) == 1 else 'addresses'} {', '.join(addresses)})"


@contextmanager
def state_directory(path: str | None, lockstep: bool = False) -> Iterator[Stores | None]:
    """Yield a function that returns the memory of the chip with a given name; yield None if `path` is None.

    The memories are files in the directory, which is locked by one server at a time.

    Args:
        path: the path of the directory.
        lockstep: virtual time does not follow a clock, so it can wait for the disk.

    Raises:
        UsageError: the directory cannot be written, or another server is using it.
    """
    if path is None:
        yield None
        return
    from ...links.sockets.system import NO_LINK
    from ...locks import lock

    directory = Path(path)
    try:
        directory.mkdir(parents=True, exist_ok=True)
        lock_file = os.open(directory / ".lock", os.O_RDWR | os.O_CREAT | NO_LINK, 0o666)
    except OSError as error:
        raise UsageError(f"--state {path}: {error.strerror}; give a writable directory") from None
    if not lock(lock_file):
        os.close(lock_file)
        raise UsageError(f"--state {path}: used by another server; stop that server, or give another directory")
    stores: list[BackgroundStore] = []

    def stored(name: str) -> BackgroundStore:
        stores.append(background_store(directory / f"{name}.eeprom", lockstep))
        return stores[-1]

    try:
        yield stored
    finally:
        for store in stores:
            finish(store)
        os.close(lock_file)


def background_store(path: Path, lockstep: bool) -> BackgroundStore:
    """Return a memory that is kept in a file.

    A damaged file is reported now; otherwise the user would notice only later, when a program is missing.
    """
    from ...links.lines.background import WRITE_TIMEOUT_S, BackgroundStore
    from ...links.lines.memory_file import FileStore

    return BackgroundStore(FileStore(path), None if lockstep else WRITE_TIMEOUT_S)


def finish(store: BackgroundStore) -> None:
    """Wait until a memory has been written to its file; report a long wait, and any failure."""
    if not store.wait(STATUS_S):
        remark(f"{store.path} is still being written: the disk is slow; the command ends when it is written")
    try:
        store.close()
    except StoreError as error:
        remark(str(error))


def say(text: str, end: str = "\n") -> None:
    """Print to standard error, which may be closed."""
    with suppress(OSError):
        click.echo(f"{text}{end}", err=True, nl=False)


def remark(text: str) -> None:
    """Print a message from slewline itself to standard error."""
    say(f"slewline: {text}")


def show(server: Server, end: str = "\n") -> None:
    """Print a server's status line to standard error."""
    from ...links.views.server_status import as_line

    say(as_line(server), end)


def show_again(server: Server) -> None:
    """Print a server's status line every second; on a terminal, each line overwrites the previous one."""
    show(server, "\033[K\r" if sys.stderr.isatty() else "\n")
    server.loop.after(STATUS_S, lambda: show_again(server))


def signals(server: Server) -> AbstractContextManager[None]:
    """Return a context in which a signal ends the server cleanly, and SIGUSR1 prints a status line."""
    return ended_by_signals(server.loop, server.stop, lambda: show(server))


@contextmanager
def ended_by_signals(loop: Loop, stop: Callable[[], object], status: Callable[[], object]) -> Iterator[None]:
    """Call `stop` on SIGINT, SIGTERM, SIGHUP, SIGQUIT and SIGBREAK; call `status` from the loop on SIGUSR1.

    After the first of the ending signals the others are ignored, because the process is ending.  A signal
    that was already ignored on entry stays ignored.
    """
    from ...links.sockets import system

    ends = system.ends()

    def end(*_: object) -> None:
        system.ignore(ends)
        stop()

    calls: dict[int, Call] = dict.fromkeys(ends, end)
    for number in system.numbers("SIGUSR1"):
        calls[number] = lambda *_: loop.ask(status)
    kept = {number: signal.signal(number, call) for number, call in calls.items()}
    loop.watch_signals()
    try:
        yield
    except BaseException:
        for number, handler in kept.items():
            signal.signal(number, handler)
        raise
    system.ignore(kept)
