"""The panel as a process of its own, beside a server: it never delays a chip, and it ends with the command."""

from __future__ import annotations

import os
import secrets
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from types import TracebackType
from typing import TYPE_CHECKING

from ...errors import UsageError
from ...extras import lacking, needs
from ...links.sockets.address import parse_address

if TYPE_CHECKING:
    from ...links.server import Server

CONTROL = "127.0.0.1:0"  # of the control port that only the panel knows
END_S = 3.0


class PanelProcess:
    """A panel that starts at once, while the bench is being built, and opens when it knows the control port.

    Args:
        listen: where the page is to be found, HOST:PORT.
        token: of the control port.
        read_only: the page may look and not touch.
        allow_remote: browsers on other machines may connect.

    Raises:
        UsageError: something that the panel needs is not installed, or the address is not allowed.
    """

    def __init__(
        self, listen: str, token: str | None = None, read_only: bool = False, allow_remote: bool = False
    ) -> None:
        if "panel" in lacking():
            raise UsageError(needs("the panel needs", "panel"))
        parse_address(listen, allow_remote)
        self.token, self.url = token, ""
        command = [sys.executable, "-P", "-m", "slewline.panel", "--attach", "-", "--listen", listen, "--with-parent"]
        command += [*["--read-only"] * read_only, *["--allow-remote"] * allow_remote]
        environment = {name: value for name, value in os.environ.items() if name != "SLEWLINE_TOKEN"}
        if token is not None:
            environment["SLEWLINE_TOKEN"] = token
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment, text=True
        )

    @classmethod
    def beside(cls, listen: str, read_only: bool = False, allow_remote: bool = False) -> PanelProcess:
        """Return a panel of a server of this process; `open` makes it a control port that nobody else knows."""
        return cls(listen, secrets.token_urlsafe(24), read_only, allow_remote)

    def open(self, server: Server) -> None:
        """Open the page of a server of this process."""
        self.attach(server.control(CONTROL, self.token).where)

    def attach(self, control: str) -> None:
        """Open the page of the server with this control port, HOST:PORT.

        Raises:
            UsageError: it does not open.
        """
        if self.process.stdin is None or self.process.stdout is None:
            return
        with suppress(OSError):
            self.process.stdin.write(f"{control}\n")
            self.process.stdin.flush()
        self.url = self.process.stdout.readline().partition(": ")[2].strip()
        if not self.url:
            raise UsageError("the panel has not opened; the reason is above")

    def wait(self) -> None:
        """Wait until the panel has ended."""
        self.process.wait()

    def stop(self) -> None:
        """Let the panel end: it does so when its standard input is closed; may be called in a signal handler."""
        if self.process.stdin is not None:
            with suppress(OSError):
                self.process.stdin.close()

    def close(self) -> None:
        """End the panel, and wait until it has ended."""
        self.stop()
        try:
            self.process.wait(END_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        if self.process.stdout is not None:
            self.process.stdout.close()

    def __enter__(self) -> PanelProcess:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()


@contextmanager
def kept_journal(path: str | None) -> Iterator[str]:
    """Yield a journal, without which there is no way back in time: the one that is named, or one for this run alone."""
    if path is not None:
        yield path
        return
    with TemporaryDirectory(prefix="slewline-", ignore_cleanup_errors=True) as folder:
        yield str(Path(folder) / "journal")
