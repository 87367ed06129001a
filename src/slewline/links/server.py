"""The server: a bench, a pace, and the ports through which the outside world reaches the chips.

    server = Server(bench, Lockstep(bench))
    port = server.tcp(server.line(x), "127.0.0.1:0")
    print(port.where)                                   # socket://127.0.0.1:40001
    server.run()                                        # until server.stop()

Everything happens in the thread that calls `run`: `run` lets virtual time run as far as allowed, then
sleeps until the next event or the next byte.  `call` lets another thread call a function in this one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from functools import cached_property, partial
from ipaddress import ip_address
from os import PathLike
from time import perf_counter
from typing import TYPE_CHECKING, Any, cast

from ..closing import Closing
from ..core.chip import Chip
from ..core.component import Finding
from ..errors import UsageError
from .lines.line_transcript import TranscriptFile
from .lines.pace import Pace, Paced
from .lines.served_line import ConnectorLine, HostLine
from .ports.adapters import Adapters
from .ports.prologix import PrologixLine, PrologixPort
from .ports.register_port import RegisterLine, RegisterPort
from .ports.tcp import LOCAL, TcpPort
from .serving import line_to, prologix_line
from .sockets.address import is_loopback, parse_address
from .sockets.loop import Loop
from .sockets.system import fine_timer
from .time.branches import Branches
from .time.breakpoints import Breakpoints
from .time.server_past import ServedPast
from .views.panel_views import Views
from .views.reports import FindingReports, Lateness

if TYPE_CHECKING:
    from pathlib import Path

    from ..bench import Bench
    from ..gate import LinkPlace
    from .control.control import Control
    from .face import OpenPort
    from .views.dialogue_view import Dialogue
    from .views.scope import Scope

KEPT_FINDINGS = 1000  # findings of each chip and part; a server runs for months
LOOK_S = 5.0
PORTS: Mapping[type[HostLine], type[TcpPort]] = {RegisterLine: RegisterPort, PrologixLine: PrologixPort}


class Server(Closing):
    """A server for the chips of a bench.

    Args:
        bench: the bench, with all its chips and parts; no time may have passed on it.
        pace: Paced(bench) or Lockstep(bench).
        log: a file for the transcript; "-": standard error.
        allow_remote: whether other machines may connect.
        report: called with messages for the user: findings, limits of a port, an unplugged cable, a full
            disk; not called if the transcript is on the terminal and shows them.

    Attributes:
        bench: the bench that is served; another one after `past.go_on`, or when a client goes back in time.
        pace, allow_remote, report: the arguments.
        lines: the lines to chips, by name.
        ports: the open ports.
        log: the transcript.
        loop: waits for bytes and events; `loop.ask(f)` calls a function in the thread of the server.
        notes: functions that return text for the status line, for example the status of a drive.
        troubles: messages about failures outside the chips (file errors).
        found: the number of findings.
        branch: the number of the run that is shown; 0 is the run that began with the server.
        breakpoints: conditions that pause virtual time.
        past: the past of the server: `past.at(t)` recreates an instant, `past.go_on` replaces the served bench.
        branches: the runs that began in the past, and which of them is shown.
        views: data for the control port.
        adapters: the ports that were closed by `unplug`, and that can be opened again.
        reports: findings for the user, without repetitions.
        closed: whether the server is closed.
    """

    def __init__(
        self,
        bench: Bench,
        pace: Pace,
        log: str | PathLike[str] | None = None,
        allow_remote: bool = False,
        report: Callable[[str], object] = lambda _text: None,
    ) -> None:
        self.bench, self.pace, self.allow_remote, self.report = bench, pace, allow_remote, report
        self.troubles: list[str] = []
        self.log = TranscriptFile(bench.kernel, log, self._trouble)
        self.loop = Loop()
        self.reports = FindingReports(self.loop, self._report)
        rate = float(pace.rate) if isinstance(pace, Paced) else 1
        self._lateness = Lateness(pace.lag, rate, lambda text: self.say("server", text))
        self.notes: list[Callable[[], str]] = []
        self.lines: dict[str, HostLine] = {}
        self.ports: list[OpenPort] = []
        self.adapters = Adapters(self)
        self.found = self.branch = 0
        self._over = False
        self.breakpoints = Breakpoints(bench, pace, self._stopped)
        self.views = Views(self)
        self._dialogue: Dialogue | None = None
        self.past, self.branches = ServedPast(self), Branches(self)
        self.furnish(bench)
        for owner in (*bench.chips.values(), *bench.parts.values()):
            if (on_failure := getattr(getattr(owner, "store", None), "on_failure", None)) is not None:
                on_failure.add(self._trouble)

    def furnish(self, bench: Bench) -> None:
        """Start observing the findings, the journal, the dialogue and the signals of a bench."""
        bench.on_finding.add(self.finding)
        if bench.journal is not None:
            bench.journal.on_failure.add(self._trouble)
        if self._dialogue is not None and self._dialogue.bench is not bench:
            self._dialogue.move(bench)
        if "scope" in vars(self):
            self.scope.move(bench)

    # ---------------------------------------------------------------------------------------------------- furnishing
    def line(
        self,
        *chips: Chip,
        framing: bool = False,
        over: str | None = None,
        prologix: bool = False,
        card: str | None = None,
    ) -> HostLine:
        """Make a line to a chip, or to modules that share the line; for a chipset, a line to its registers.

        Args:
            framing: whether to use text lines with read-back, for a chip on a bus (see `links.lines.framing`).
            over: the name of the channel, for a chip that has several, as for `bench.host`.
            prologix: whether to use a GPIB controller, for chips on an IEEE-488 bus (`links.ports.prologix`).
            card: the interface board of a chipset, with its registers (`parts.boards.register_layouts`).

        Raises:
            UsageError: the chips cannot share a line.
        """
        name = "+".join(chip.name for chip in chips) + (f"_{over}" if over is not None else "")
        if prologix:
            return self._joined(prologix_line(self, name, chips), chips)
        return self._joined(line_to(self, name, chips, framing, over, card), chips)

    def _joined(self, line: HostLine, chips: Sequence[Chip]) -> HostLine:
        """Register a line with the server, and with the other lines to its chips; return the line."""
        for other in self.lines.values():
            if any(chip in other.chips for chip in chips):
                other.beside.append(line)
                line.beside.append(other)
        self.lines[line.name] = line
        return line

    def _check(self, line: HostLine, port: str) -> None:
        if port not in line.ports:
            raise UsageError(f"{line.name} has no serial line for --{port}; use --{' or --'.join(line.ports)}")

    def tcp(self, line: HostLine, address: str | Path) -> OpenPort:
        """Serve a line on a TCP socket, HOST:PORT, for unmodified bytes, register requests or GPIB commands.

        If `address` is a `Path`, serve on a Unix socket at this path, with the permissions of its folder.
        """
        kind = next((port for of, port in PORTS.items() if isinstance(line, of)), TcpPort)
        return self._on_tcp(kind, line, address)

    def rfc2217(self, line: HostLine, address: str) -> OpenPort:
        """Serve a line on a TCP port, HOST:PORT, through which hosts also set its rate and format (RFC 2217)."""
        from .ports.rfc2217 import NetPort

        self._check(line, "rfc2217")
        port = self._on_tcp(NetPort, line, address)
        self._say_format(line, port.where)
        return port

    def pty(self, line: HostLine, link: str | LinkPlace) -> OpenPort:
        """Serve a line on a pseudo-terminal; `link`, a path or a place from a bench file, is a symbolic link to it."""
        from .ports.pty import PtyPort

        self._check(line, "pty")
        port = PtyPort(self.loop, line, link)
        self._opened(port)
        if isinstance(line, ConnectorLine) and line.port.word.bits < 8:
            self.say(line.name, f"{link}: {port.hint}")
        return port

    def serial(self, line: HostLine, device: str) -> OpenPort:
        """Serve a line on a serial port of this machine."""
        from .ports.device import DevicePort

        self._check(line, "serial")
        port = self._opened(
            DevicePort(self.loop, cast("ConnectorLine", line), device, lambda text: self.say(line.name, text))
        )
        self._say_format(line, device)
        return port

    def control(self, address: str | Path, token: str | None = None) -> OpenPort:
        """Open a control port, HOST:PORT; a `token`, which clients must know, lets other machines connect, too."""
        from .control.control import Control

        port = self._opened(Control(self, address, token))
        self._warn_remote("control", port.where, "any client with the token can drive every pin")
        return port

    def _on_tcp(self, kind: type[TcpPort], line: HostLine, address: str | Path) -> OpenPort:
        """Open a port of a given kind for a line, and return it."""
        port = self._opened(kind(self.loop, line, address, self.allow_remote, partial(self.say, line.name)))
        self._warn_remote(line.name, port.where, "any client that connects can command the module, without a password")
        return port

    def _warn_remote(self, name: str, where: str, may: str) -> None:
        """Warn about a port if other machines can reach it; the message ends with `may`, the consequences."""
        if where.endswith(LOCAL):
            return
        host, _ = parse_address(where.rpartition("//")[2], True)
        if not is_loopback(host):
            reach = "every network of this machine" if ip_address(host).is_unspecified else f"the network of {host}"
            self.say(name, f"{where}: open to {reach}; {may}")

    def _say_format(self, line: HostLine, where: str) -> None:
        """Report the format of a line if it has fewer than 8 data bits, because most hosts assume 8N1."""
        port = cast("ConnectorLine", line).port
        word = port.word
        if word.bits < 8:
            form = f"{port.baud} baud, {word.bits} data bits, {word.parity} parity, {word.stop} stop bits"
            self.say(
                line.name,
                f"{where}: the line has {form}; a host that sets another format, such as 8N1, gets E1 or no answer",
            )

    def _opened(self, port: OpenPort) -> OpenPort:
        self.ports.append(port)
        return port

    # ------------------------------------------------------------------------------------------------------- running
    def run(self) -> None:
        """Serve until `stop` is called, then close all ports."""
        if self.controls():
            _ = self.dialogue  # from the first round on
        self.bench.run(0)
        if self.controls():
            self.branches.begin()
        self.pace.start()
        self.loop.after(LOOK_S, self._look_around)
        self.serve(lambda: False)

    def serve(self, done: Callable[[], bool]) -> None:
        """Let time run and answer clients until `stop` is called, or `done` returns True; then close all ports."""
        worked_s = 0.0
        try:
            with fine_timer():
                while not (self._over or done()):
                    self.past.look(worked_s)
                    began_s = perf_counter()
                    finished = self.pace.pass_time()
                    worked_s = perf_counter() - began_s
                    ready = self.loop.sleep(self.pace.pause() if finished else 0)
                    self.pace.present()
                    self.loop.serve(ready)
        finally:
            self.close()

    def stop(self) -> None:
        """End `run`; may be called in a signal handler and in other threads."""
        self.loop.ask(self._end)

    def _end(self) -> None:
        self._over = True

    def _shut(self) -> None:
        """Close every branch, every port and the log; no virtual time passes."""
        self.branches.close()
        self.past.close()
        for port in self.ports:
            port.close()
        self.ports.clear()
        self.bench.conclude()
        self.reports.close()
        self._lateness.close()
        self.bench.run(0)  # the journal records the present instant
        for part in self.bench.parts.values():
            part.leave()
        self.log.close()
        self.loop.close()

    def catch_up(self) -> None:
        """Execute all register requests that hosts have already sent, before a later request is handled.

        This is needed only in lockstep; when paced, all bytes are handled at the instant of their arrival.
        """
        if self.pace.lockstep:
            for port in self.ports:
                if isinstance(port, RegisterPort):
                    port.catch_up()

    @cached_property
    def scope(self) -> Scope:
        """History of the signals on the bench."""
        from .views.scope import Scope

        return Scope(self.bench)

    @property
    def dialogue(self) -> Dialogue:
        """Data sent by hosts and chips.

        It is recorded from the beginning if there is a control port, otherwise from the first access to this
        property.
        """
        if self._dialogue is None:
            from .views.dialogue_view import Dialogue

            names = {
                line.port.name: line.chips[0].name if len(line.chips) == 1 else line.name
                for line in self.lines.values()
                if isinstance(line, ConnectorLine)
            }
            self._dialogue = Dialogue(self.bench, names)
        return self._dialogue

    def controls(self) -> list[Control]:
        """Return the control ports."""
        from .control.control import Control

        return [port for port in self.ports if isinstance(port, Control)]

    def event(self, what: dict[str, Any]) -> None:
        """Send an event to all subscribed clients of control ports."""
        for control in self.controls():
            for client in control.clients:
                client.event(what)

    def _stopped(self, why: str) -> None:
        self.event({"event": "stopped", "why": why})

    def call(self, function: Callable[[], Any], timeout: float | None = None) -> Any:
        """Call a function in the thread that runs the server, from another thread; return its result.

        Exceptions of the function are raised here, too; `timeout` is in seconds.
        """
        future: Future[Any] = Future()

        def answer() -> None:
            try:
                self.catch_up()
                future.set_result(function())
            except BaseException as error:
                future.set_exception(error)

        self.loop.ask(answer)
        return future.result(timeout)

    # -------------------------------------------------------------------------------------------------- housekeeping
    def say(self, line: str, text: str) -> None:
        """Record an event in the transcript; report it to the user, unless the transcript is on the terminal."""
        self.log.event(line, text)
        if not self.log.on_terminal:
            self.report(text)

    def _report(self, text: str) -> None:
        self.report(text)

    def _trouble(self, text: str) -> None:
        if text not in self.troubles:  # a host's retry is not reported again
            self.troubles.append(text)
            self.say("server", text)

    def finding(self, found: Finding) -> None:
        """Record and report a finding; if its source has too many findings, discard the oldest ones."""
        self.found += 1
        self.log.event(found.source, f"{found.code}: {found.text}")
        if not self.log.on_terminal:
            self.reports.found(found)
        findings = self.bench[found.source].findings
        if len(findings) > 2 * KEPT_FINDINGS:
            del findings[:-KEPT_FINDINGS]

    def steps_of(self, chip: Chip) -> int:
        """Return the number of steps that a chip has made since the beginning, on all axes."""
        return sum(axis.made for axis in chip.axes)

    def _look_around(self) -> None:
        """Check periodically whether the bench lags, and whether hosts have left requests incomplete."""
        self._lateness.check()
        for line in self.lines.values():
            line.look_for_ends()
        self.loop.after(LOOK_S, self._look_around)
