"""slewline debug: a bench in a separate server process, paused at first, and a screen in the terminal.

The screen uses only the control port of the bench.  The server is this command again, with `--control`, so a front end
of your own can do everything that the debugger does.
"""

from __future__ import annotations

import os
import secrets
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from shutil import get_terminal_size
from tempfile import TemporaryFile
from typing import IO, TYPE_CHECKING, Any, TextIO, cast

import click

from ...chips import CATALOGUE
from ...errors import UsageError
from ...extras import needs
from ...lifeline import end_of_input, follow, start
from ...temporary import TemporaryFolder
from ..files import chip_of, is_bench, read_options, read_program
from ..single import BenchOptions, single

if TYPE_CHECKING:
    from ...bench import Bench
    from ...links.server import Server
    from ...panel.terminal.debugger import Debugger

TOKEN = "SLEWLINE_TOKEN"  # in the environment
LOOPBACK = "127.0.0.1:0"
ENDS_S = 5.0
SLOWEST, FASTEST = 0.001, 1000
LEAST = 80, 24  # columns and lines of a terminal


@dataclass
class DebugCommand(BenchOptions):
    """The target and the options of a debug session."""

    target: str | None
    crystal: str | None
    options: str | None
    memory: str | None
    rate: float
    attach: str | None
    control: str | None
    token: str | None
    while_input: bool

    def perform(self) -> int:
        """Run the debugger; return the exit status."""
        self.check_options()
        if self.control is not None:
            return self.serve()
        app = app_class()
        from ...panel.terminal.session import DebugSession

        if self.attach is not None:
            return run(app(DebugSession(self.attach, self.token, self.rate), self.attach))
        with server_process(self.arguments()) as (address, token):
            return run(app(DebugSession(address, token, self.rate), Path(str(self.target)).name))

    def check_options(self) -> None:
        """Refuse options that exclude each other."""
        if (self.target is None) == (self.attach is None):
            raise click.UsageError("give exactly one of these: a program, a chip, a bench file, --attach HOST:PORT")
        own = (self.chip, self.crystal, self.options, self.memory, self.control)
        if self.attach is not None and (any(own) or self.strap or self.anywhere or self.allow_code):
            raise click.UsageError("--attach debugs a running server; combine it only with --rate and --token")
        if not SLOWEST <= self.rate <= FASTEST:
            raise click.UsageError(f"--rate {self.rate:g}: allowed {SLOWEST} to {FASTEST}")
        if self.target is not None and is_bench(self.target) and (any(own[:-1]) or self.strap):
            raise click.UsageError(
                "a bench file names its chips; leave out --chip, --crystal, --strap, --options, --memory"
            )

    def arguments(self) -> list[str]:
        """Return the command-line arguments for the server process."""
        found = [str(self.target)]
        for name in ("chip", "crystal", "options", "memory"):
            if (value := getattr(self, name)) is not None:
                found += [f"--{name}", str(value)]
        for pin, level in self.strap:
            found += ["--strap", f"{pin}={level}"]
        found += ["--anywhere"] * self.anywhere + ["--allow-code"] * self.allow_code
        return [*found, "--rate", f"{self.rate:g}"]

    # ----------------------------------------------------------------------------------------------------- the server
    def serve(self) -> int:
        """Run the server of the paused bench, with a control port, until a signal ends it; return the exit status."""
        from ...links.lines.pace import Paced
        from ...links.server import Server
        from .serve import signals

        with TemporaryFolder() as folder:
            bench = self.new_bench(os.path.join(folder, "journal"))
            pace = Paced(bench, f"{self.rate:g}")
            pace.pause_time()
            server = Server(bench, pace)
            with signals(server):
                try:
                    click.echo(f"control: {server.control(str(self.control), self.token).where}")
                    sys.stdout.flush()
                except BaseException:
                    server.close()
                    raise
                if self.while_input:
                    end_with_input(server)
                server.run()
        return 0

    def new_bench(self, journal: str) -> Bench:
        """Return a new bench: from a bench file, or with a chip and its program, or with a chip and an idle host.

        Its journal makes every past instant reachable.
        """
        target = str(self.target)
        if is_bench(target):
            return self.bench_file(target).load(journal=journal)
        bare = self.chip is None and not Path(target).suffix
        alone = not Path(target).exists() and (target in CATALOGUE.names() or ":" in target or bare)
        part = target if alone else chip_of(target, self.chip)
        return single(
            part,
            None if alone else (read_program(target), target),
            crystal=self.crystal,
            strap=dict(self.strap),
            options=read_options(self.options, part),
            memory=self.memory,
            journal=journal,
        )


def is_terminal(file: TextIO | None) -> bool:
    """Return whether a file is a terminal."""
    return file is not None and file.isatty()


def end_with_input(server: Server) -> None:
    """Stop a server when this process's standard input ends, as it does when the parent process ends."""

    def read() -> None:
        if not os.read(0, 1024):
            server.stop()

    if os.name == "posix":
        server.loop.watch(0, read)  # a process with threads cannot be forked, and going back needs forks
        return

    follow(end_of_input, server.stop)


def app_class() -> Any:
    """Return the class of the debugger's screen.

    Raises:
        UsageError: the optional package that it needs is not installed.
    """
    try:
        from ...panel.terminal.debugger import Debugger
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != "textual":
            raise
        raise UsageError(needs("the debugger needs", "panel")) from None
    return Debugger


def run(app: Debugger) -> int:
    """Show the debugger's screen until the user leaves it; return the exit status.

    Raises:
        SlewlineError: there is no terminal, the screen could not connect, or the server has ended.
    """
    if not (is_terminal(sys.stdin) and is_terminal(sys.__stderr__)):  # the screen is drawn there
        raise UsageError(
            "debug needs a terminal for its screen, but standard input or error is not one; `slewline run` runs a "
            "program without a terminal"
        )
    columns, lines = get_terminal_size()
    if columns < LEAST[0] or lines < LEAST[1]:
        raise UsageError(f"debug needs a terminal of {LEAST[0]}x{LEAST[1]}; this one has {columns}x{lines}: enlarge it")
    app.run()
    if app.failure is not None:
        raise app.failure
    return app.return_code or 0


@contextmanager
def server_process(arguments: list[str]) -> Iterator[tuple[str, str]]:
    """Start `slewline debug --control` in a separate process; yield its control port's address, and the token.

    The process ends when ours does, however ours ends, because its standard input closes.

    Raises:
        UsageError: the server has not started; the message is the server's own error message, if any.
    """
    token = secrets.token_urlsafe(16)
    call = [sys.executable, "-m", "slewline", "debug", *arguments, "--control", LOOPBACK, "--while-input"]
    environment = os.environ | {TOKEN: token, "PYTHONUNBUFFERED": "1"}
    with (
        TemporaryFile() as server_output,  # by the server, next to the screen
        start(call, environment, server_output) as process,
    ):
        given, printed = cast("IO[bytes]", process.stdin), cast("IO[bytes]", process.stdout)
        try:
            first = printed.readline().decode()
            if not first.startswith("control: "):
                process.wait()
                server_output.seek(0)
                why = server_output.read().decode("utf-8", "replace").strip()
                raise UsageError(why.removeprefix("slewline: ") or "the server of the debugger has not started")
            yield first.removeprefix("control: ").strip(), token
        finally:
            given.close()
            with suppress(subprocess.TimeoutExpired):
                process.wait(ENDS_S)
            process.kill()
