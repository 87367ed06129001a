"""The panel of a server, in a separate process: it never delays a chip, and ends when the command does."""

from __future__ import annotations

import os
import secrets
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import IO, TYPE_CHECKING, cast

from ...closing import Closing
from ...errors import UsageError
from ...extras import lacking, needs
from ...lifeline import follow, how, start
from ...links.sockets.address import parse_address
from ...temporary import TemporaryFolder

if TYPE_CHECKING:
    from ...links.server import Server

CONTROL = "127.0.0.1:0"  # of the panel's private control port
END_S = 3.0


class PanelProcess(Closing):
    """A panel that starts while the bench is being built, and opens when it receives the address of the control port.

    Args:
        listen: the address of the page, HOST:PORT.
        token: the token of the control port.
        read_only: the page shows the chips, but cannot operate them.
        allow_remote: browsers on other machines may connect.

    Raises:
        UsageError: a package that the panel needs is not installed, or the address is not allowed.
    """

    def __init__(
        self, listen: str, token: str | None = None, read_only: bool = False, allow_remote: bool = False
    ) -> None:
        if "panel" in lacking():
            raise UsageError(needs("the panel needs", "panel"))
        parse_address(listen, allow_remote)
        self.token, self.url = token, ""
        self.command = [sys.executable, "-P", "-m", "slewline.panel", "--attach", "-", "--listen", listen]
        self.command += ["--with-parent", *["--read-only"] * read_only, *["--allow-remote"] * allow_remote]
        self.environment = {name: value for name, value in os.environ.items() if name != "SLEWLINE_TOKEN"}
        if token is not None:
            self.environment["SLEWLINE_TOKEN"] = token
        self.stopped = self.was_replaced = False
        self.process = start(self.command, self.environment)

    @classmethod
    def beside(cls, listen: str, read_only: bool = False, allow_remote: bool = False) -> PanelProcess:
        """Return a panel for a server in this process; `open` opens the server's control port, with a secret token."""
        return cls(listen, secrets.token_urlsafe(24), read_only, allow_remote)

    def open(self, server: Server) -> None:
        """Open the page for a server in this process; if the panel ends by itself, the server reports it."""
        control = server.control(CONTROL, self.token).where
        self.attach(control)
        self._watch(server, control)

    def attach(self, control: str) -> None:
        """Open the page for the server with this control port, HOST:PORT.

        Raises:
            UsageError: the page does not open.
        """
        self._send(control)
        if self.process.stdout is not None and not self._opened(self.process.stdout.readline()):
            raise UsageError("the panel has not opened; the reason is above")

    def _send(self, control: str) -> None:
        """Send the address of the control port to the waiting panel."""
        with suppress(OSError):
            if self.process.stdin is not None:
                self.process.stdin.write(f"{control}\n".encode())
                self.process.stdin.flush()

    def _opened(self, line: bytes) -> bool:
        """Set `url` to the page address that a line contains ("" if none); return whether there is one."""
        self.url = line.decode().partition(": ")[2].strip()
        return bool(self.url)

    def replace(self, report: Callable[[str], object]) -> bool:
        """Restart a panel that has ended by itself, but only once; return whether it was restarted.

        Args:
            report: called with a message that describes the event and its remedy.
        """
        status, out = self.process.wait(), self.process.stdout
        ended = f"the panel has ended ({how(status)})"
        for pipe in (self.process.stdin, out):
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()
        if self.was_replaced:
            report(f"{ended} again, and is not restarted; to get the page back, restart this command")
            return False
        report(f"{ended}, and is being restarted")
        self.was_replaced = True
        self.process = start(self.command, self.environment)
        if self.stopped:  # meanwhile
            self.stop()
        return True

    def _watch(self, server: Server, control: str) -> None:
        """Make a server's loop notice the end of the panel, and the opening of a restarted panel."""
        out, loop = cast("IO[bytes]", self.process.stdout), server.loop

        def read(data: bytes) -> None:
            if data and self._opened(data):
                server.report(f"panel: {self.url}")
            elif not data:
                if os.name == "posix":
                    loop.watch(out.fileno())
                if not self.stopped and self.replace(server.report):
                    self._send(control)
                    self._watch(server, control)

        def wait() -> None:
            while data := out.readline():
                loop.ask(partial(read, data))

        if os.name == "posix":
            loop.watch(out.fileno(), lambda: read(os.read(out.fileno(), 4096)))
        else:  # a loop waits only for sockets
            follow(wait, lambda: loop.ask(partial(read, b"")))

    def wait(self) -> int:
        """Wait until the panel has ended; return its exit status."""
        return self.process.wait()

    def stop(self) -> None:
        """Close the standard input of the panel, which ends the panel; may be called in a signal handler."""
        self.stopped = True
        if self.process.stdin is not None:
            with suppress(OSError):
                self.process.stdin.close()

    def _shut(self) -> None:
        """End the panel, and wait until it has ended."""
        self.stop()
        try:
            self.process.wait(END_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        if self.process.stdout is not None:
            self.process.stdout.close()


@contextmanager
def kept_journal(path: str | None) -> Iterator[str]:
    """Yield the path of the journal needed for going back in time: the given path, or one for this run only."""
    if path is not None:
        yield path
        return
    with TemporaryFolder() as folder:
        yield str(Path(folder) / "journal")
