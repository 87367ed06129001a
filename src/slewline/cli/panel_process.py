"""The panel as a process of its own, beside a server: it never delays a chip, and it ends with the command."""

from __future__ import annotations

import os
import secrets
import subprocess
import sys
from contextlib import suppress
from types import TracebackType
from typing import TYPE_CHECKING

from ..errors import UsageError
from ..extras import lacking, needs
from ..links.sockets.address import parse_address

if TYPE_CHECKING:
    from ..links.server import Server

CONTROL = "127.0.0.1:0"  # of the control port that only the panel knows
END_S = 3.0


class PanelProcess:
    """A panel that runs.

    Args:
        control: where the control port is, HOST:PORT.
        listen: where the page is to be found, HOST:PORT.
        token: of the control port.
        read_only: the page may look and not touch.
        allow_remote: browsers on other machines may connect.

    Raises:
        UsageError: something that the panel needs is not installed, or it does not start.
    """

    def __init__(
        self,
        control: str,
        listen: str,
        token: str | None = None,
        read_only: bool = False,
        allow_remote: bool = False,
    ) -> None:
        if "panel" in lacking():
            raise UsageError(needs("the panel needs", "panel"))
        parse_address(listen, allow_remote)
        command = [sys.executable, "-P", "-m", "slewline.panel", "--with-parent", "--attach", control]
        command += ["--listen", listen, *["--read-only"] * read_only, *["--allow-remote"] * allow_remote]
        environment = {name: value for name, value in os.environ.items() if name != "SLEWLINE_TOKEN"}
        if token is not None:
            environment["SLEWLINE_TOKEN"] = token
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment, text=True
        )
        line = self.process.stdout.readline() if self.process.stdout else ""
        self.url = line.partition(": ")[2].strip()
        if not self.url:
            self.close()
            raise UsageError("the panel has not started; the reason is above")

    @classmethod
    def of(cls, server: Server, listen: str, read_only: bool = False, allow_remote: bool = False) -> PanelProcess:
        """Return a panel of a server, on a control port of its own."""
        token = secrets.token_urlsafe(24)
        return cls(server.control(CONTROL, token).where, listen, token, read_only, allow_remote)

    def wait(self) -> None:
        """Wait until the panel has ended."""
        self.process.wait()

    def close(self) -> None:
        """End the panel: it does so when its standard input is closed."""
        if self.process.stdin is not None:
            with suppress(OSError):
                self.process.stdin.close()
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
