"""Run the panel as a separate process: python -m slewline.panel --attach HOST:PORT.

It prints one line, `panel: http://...`, and runs until SIGINT or SIGTERM.  A program that starts the panel before there
is a control port passes `--attach -`, and later writes HOST:PORT as a line to the panel's standard input.  The token of
the control port, if it has one, is passed in the environment variable SLEWLINE_TOKEN, because a command line is visible
to all users of the machine.
"""

from __future__ import annotations

import argparse
import os
import secrets
import socket
import sys
from collections.abc import Sequence

from ..errors import SlewlineError, UsageError
from ..lifeline import end_of_input, follow
from ..links.sockets.address import is_loopback, parse_address

LISTEN = "127.0.0.1:0"
WRONG_USE = 2
CONNECT_S = 5.0


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the panel with these command line arguments (None: those of the process); return the exit status."""
    parser = argparse.ArgumentParser("python -m slewline.panel", description="The panel of a slewline server.")
    parser.add_argument(
        "--attach", metavar="HOST:PORT", required=True, help="the control port of the server; -: read it"
    )
    parser.add_argument("--listen", metavar="HOST:PORT", default=LISTEN, help="the address of the page")
    parser.add_argument("--read-only", action="store_true", help="pages may view, but not operate")
    parser.add_argument("--allow-remote", action="store_true", help="browsers on other machines may connect")
    parser.add_argument("--with-parent", action="store_true", help="end when the standard input is closed")
    options = parser.parse_args(arguments)
    try:
        return run(options)
    except SlewlineError as error:
        sys.stderr.write(f"slewline: {error}\n")
        return WRONG_USE


def run(options: argparse.Namespace) -> int:
    """Open the panel with these options, run it until it is stopped, and return the exit status."""
    from .relay import Access
    from .web_server import PanelServer

    attach = options.attach if options.attach != "-" else sys.stdin.buffer.readline().decode().strip()
    if not attach:
        return 0  # the program that started it has ended
    host, port = parse_address(attach, True)
    if not port:
        raise UsageError(f"address {attach!r}: port 0 is not the number of a control port; allowed 1 to 65535")
    listen, at = parse_address(options.listen, options.allow_remote)
    try:
        socket.create_connection((host, port), CONNECT_S).close()
    except OSError as error:
        raise UsageError(
            f"--attach {attach}: {error.strerror or error}; give the control port of a running server, or start one: "
            f"slewline serve ... --control {attach}"
        ) from None
    access = Access(
        host,
        port,
        secrets.token_urlsafe(24),
        os.environ.pop("SLEWLINE_TOKEN", None) or None,
        options.read_only,
        token_needed=not is_loopback(listen),
    )
    panel = PanelServer(access, listen, at, options.allow_remote)
    sys.stdout.write(f"panel: {panel.url}\n")
    sys.stdout.flush()
    if options.with_parent:
        follow(end_of_input, panel.stop)
    panel.run()
    return 0


if __name__ == "__main__":
    sys.exit(main())
