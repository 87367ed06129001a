"""slewline panel: a web page that shows a chip, a bench file, a program, or a running server."""

from __future__ import annotations

import signal
import webbrowser
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ...chips import sheet_of
from ...errors import ProgramError, UsageError
from ..dialects import foreign
from ..files import Refused, chip_of, is_bench, read_program, report_replaced
from ..single import BenchOptions, single
from .process import PanelProcess, kept_journal
from .serve import open_bench_file, remark, show_ports, signals

if TYPE_CHECKING:
    from ...bench import Bench
    from ...bench.file import BenchFile
    from ...links.server import Server


@dataclass
class PanelCommand(BenchOptions):
    """The subject and the options of a panel."""

    what: str | None
    attach: str | None
    token: str | None
    listen: str
    read_only: bool
    rate: str | None
    no_browser: bool
    journal: str | None
    run: bool
    allow_remote: bool
    file: BenchFile | None = None
    has_program: bool = False

    def perform(self) -> int:
        """Run the panel until a signal ends it; return the exit status."""
        self.check_options()
        return self.serve() if self.attach is None else self.show_server(self.attach)

    def check_options(self) -> None:
        """Refuse options that exclude each other."""
        if (self.what is None) == (self.attach is None):
            raise click.UsageError("give exactly one of these: a chip, a bench file, a program, --attach HOST:PORT")
        own = {"chip": self.chip, "rate": self.rate, "strap": self.strap, "journal": self.journal, "run": self.run}
        given = [name for name, value in own.items() if value]
        if self.attach is not None and given:
            raise click.UsageError(f"--attach shows a running server; leave out --{' --'.join(given)}")
        if self.is_bench and (self.chip or self.strap):
            raise click.UsageError("a bench file names its chips and their straps; leave out --chip, --strap")
        if self.anywhere and not self.is_bench:
            raise click.UsageError("--anywhere needs a bench file")
        if self.allow_code and not self.is_bench:
            raise click.UsageError(
                "--allow-code needs a bench file; a chip given as module:Class needs no --allow-code"
            )

    @property
    def is_bench(self) -> bool:
        """True if the subject is a bench file."""
        return self.what is not None and is_bench(self.what)

    # ------------------------------------------------------------------------------------------ a server that runs
    def show_server(self, address: str) -> int:
        """Open a panel for a running server, until the server or this command ends; return the exit status."""
        from ...links.clients.control_client import reach
        from ...links.sockets import system

        reach(address, self.token)
        with PanelProcess(self.listen, self.token, self.read_only, self.allow_remote) as panel:
            for number in system.ends():
                signal.signal(number, lambda *_: panel.stop())
            panel.attach(address)
            self.report(panel)
            while panel.wait() and not panel.stopped and panel.replace(remark):
                panel.attach(address)
                show_ports([("panel", panel.url)])
        return 0

    # -------------------------------------------------------------------------------------------- a server of our own
    def serve(self) -> int:
        """Serve the bench and its panel until a signal ends the server; return the exit status."""
        report_replaced(self.journal)
        with (
            PanelProcess.beside(self.listen, self.read_only, self.allow_remote) as panel,
            kept_journal(self.journal) as self.journal,
        ):
            try:
                bench = self.new_bench()
            except ProgramError as error:  # a line of a script that cannot be played
                raise Refused(str(error)) from error
            server = self.server(bench)
            if self.begins_paused:
                server.pace.pause_time()
            with signals(server):
                try:
                    if self.file is not None:
                        show_ports(open_bench_file(server, self.file))
                    panel.open(server)
                    self.report(panel)
                except BaseException:
                    server.close()
                    raise
                server.run()
        return 0

    @property
    def begins_paused(self) -> bool:
        """True if time is paused until the user starts it on the page.

        This is so for a program without --run; a bench with served ports is never paused, because its hosts run
        in real time.
        """
        if self.run:
            return False
        if self.file is not None:
            return not self.file.tables.serve and any(text.strip() for text, _ in self.file.programs())
        return self.has_program

    def server(self, bench: Bench) -> Server:
        """Return the server, without ports."""
        from ...links.lines.pace import Paced
        from ...links.server import Server

        pace = Paced(bench, self.rate or "1")
        return Server(bench, pace, None, self.allow_remote, remark)

    def new_bench(self) -> Bench:
        """Return the bench, with its hosts."""
        what = self.what or ""
        if self.is_bench:
            self.file = self.bench_file(what)
            bench = self.file.load(journal=self.journal)
            if not bench.chips:
                raise UsageError(f"{what}: no chip on the bench, so there is nothing to show")
            return bench
        if self.chip is None and not Path(what).suffix and not Path(what).is_file():
            return single(what, strap=dict(self.strap), journal=self.journal)
        text, part, self.has_program = read_program(what), chip_of(what, self.chip), True
        if message := foreign(text, what, part, sheet_of(part)):
            remark(message)
        return single(part, (text, what), strap=dict(self.strap), journal=self.journal)

    def report(self, panel: PanelProcess) -> None:
        """Print the address of the panel, and open it in a web browser unless --no-browser is given."""
        show_ports([("panel", panel.url)])
        if not self.no_browser:
            webbrowser.open(panel.url)
