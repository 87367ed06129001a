"""A command on a terminal of its own, which it controls: Ctrl-C is a signal, and nothing that it writes is lost."""

from __future__ import annotations

import os
import re
import select
import subprocess
import sys
from collections.abc import Sequence

# When the process that a terminal belongs to ends, Linux drops what was written to the terminal and not yet passed
# on.  So it belongs to this one, which writes the exit status of the command there, and stays.
OWNER = """
import fcntl, signal, subprocess, sys, termios, os
fcntl.ioctl(0, termios.TIOCSCTTY, 0)
for each in (signal.SIGINT, signal.SIGQUIT):
    signal.signal(each, lambda *_: None)  # the command has its own: a handler is not inherited, as SIG_IGN is
flags = termios.tcgetattr(0)
flags[3] |= termios.NOFLSH  # or Ctrl-C drops what was written before
termios.tcsetattr(0, termios.TCSANOW, flags)
status = subprocess.call(sys.argv[1:])
os.write(0, b"\\0%d\\0" % status)
signal.pause()
"""
ENDED = re.compile(rb"\0(-?[0-9]+)\0")


class Terminal:
    """A command on a terminal of its own.

    Args:
        call: the command and its arguments.
        output: a file for its standard output, or None for the terminal.
        environment: variables beside those of this process.
    """

    def __init__(self, call: Sequence[str], output: int | None = None, environment: dict[str, str] | None = None):
        self.fd, theirs = os.openpty()
        self._owner = subprocess.Popen(
            [sys.executable, "-c", OWNER, *call],
            stdin=theirs,
            stdout=theirs if output is None else output,
            stderr=theirs,
            env=os.environ | (environment or {}),
            start_new_session=True,
        )
        os.close(theirs)
        self.seen = b""
        self.status: int | None = None

    def looks(self, seconds: float) -> bytes:
        """Take what is shown within a time; once the command has ended, `status` is its exit status."""
        if self.status is not None or not select.select([self.fd], [], [], seconds)[0]:
            return b""
        shown = os.read(self.fd, 4096)
        self.seen += shown
        if found := ENDED.search(self.seen):
            self.seen, self.status = self.seen[: found.start()], int(found[1])
        return shown

    def types(self, text: str) -> None:
        """Press keys."""
        os.write(self.fd, text.encode())

    def close(self) -> None:
        """Take the terminal away; whatever still runs on it ends."""
        if self._owner.returncode is None:
            self._owner.kill()
            self._owner.wait()
            os.close(self.fd)
