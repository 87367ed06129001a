"""What a run of the tests inherits from its surroundings: as little as can be; and what it leaves there: nothing.

A run must come out the same in a terminal, in the background, under nohup, in a cron job, whatever variables its user
has set.  So `clear` removes what is inherited, in this one place; a test that needs a variable sets it.  All temporary
files of a run, and of the processes that it starts, are in one folder, `Place`, which is deleted at the end.  A process
or a folder that a test has left is reported, and the run fails.

`make test` starts no processes and no terminals, except in one test of each kind: `alone` refuses them.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

# What is kept: where programs, users, packages and processors are found; how tests are run, and where they keep files.
KEPT = re.compile(
    r"PATH|HOME|USER|LOGNAME|SHELL|TMPDIR|CI|VIRTUAL_ENV|SSL_\w+|\w+_proxy|LD_LIBRARY_PATH"
    r"|(PIP|NPM|UV|OPENBLAS|OMP|NUMBA|PYTEST|COVERAGE|COV|HYPOTHESIS|XDG)_\w+"
    r"|SLEWLINE_(CACHE|BOARDS|CLIENTS|FIGURES|INTERPRETERS|TESTS)"
    r"|PYTHON(PATH|PYCACHEPREFIX|DONTWRITEBYTECODE|HASHSEED|UNBUFFERED|FAULTHANDLER|MALLOC|DEVMODE|TRACEMALLOC)"
    r"|SYSTEM(ROOT|DRIVE)|WINDIR|COMSPEC|PATHEXT|TEMP|TMP|APPDATA|LOCALAPPDATA|PROGRAM(DATA|FILES.*)|USERPROFILE",
    re.IGNORECASE,
)
RUN = "SLEWLINE_TESTS"  # in the environment of every process that a run of the tests has started: which run


def clear() -> None:
    """Remove what this process has inherited and tests would notice: variables, signals, the mask of permissions."""
    for name in [name for name in os.environ if not KEPT.fullmatch(name)]:
        del os.environ[name]
    if not hasattr(os, "openpty"):
        return
    time.tzset()
    os.umask(0o022)
    signal.pthread_sigmask(signal.SIG_SETMASK, ())
    for number in signal.valid_signals():
        if signal.getsignal(number) is signal.SIG_IGN and number not in (signal.SIGPIPE, signal.SIGXFSZ):
            # A handler that does nothing ignores it as well, but is not inherited by the programs that tests start.
            signal.signal(number, lambda *_: None)


class Place:
    """The folder for all temporary files of a run, and the mark of the run's processes."""

    def __init__(self) -> None:
        self.folder = Path(tempfile.mkdtemp(prefix="slewline-tests-"))
        os.environ["TMPDIR"] = tempfile.tempdir = str(self.folder)
        os.environ[RUN] = self.folder.name

    def leave(self, failed: bool) -> list[str]:
        """Delete the folder, unless a failure may be looked into; return what tests have left, a line each."""
        names = sorted(path.name for path in self.folder.iterdir() if not path.name.startswith("pytest-of-"))
        left = [*end_processes(), *(f"in the folder for temporary files: {name}" for name in names)]
        if failed or left:
            return [*left, f"files are kept in {self.folder}"]
        shutil.rmtree(self.folder, ignore_errors=True)
        return []


def end_processes(child_of: int | None = None) -> list[str]:
    """Kill what this run has started and not ended, or only the children of a process; return a line about each."""
    left = []
    for pid, parent, line in started():
        # pytest itself; and Python's own helper, which ends by itself
        if pid in (os.getpid(), os.getppid()) or "multiprocessing.resource_tracker" in line:
            continue
        if child_of in (None, parent):
            os.kill(pid, signal.SIGKILL)
            left.append(f"a process: {pid} {line}")
    return left


def started() -> Iterator[tuple[int, int, str]]:
    """Yield number, parent and command line of each process with the mark of this run; on Linux only."""
    mark = f"{RUN}={os.environ.get(RUN)}".encode()
    for place in Path("/proc").glob("[0-9]*"):
        try:
            environment = (place / "environ").read_bytes().split(b"\0")
            line = (place / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace").strip()
            parent = int((place / "stat").read_text().rpartition(")")[2].split()[1])
        except OSError:  # it has gone, or is somebody else's
            continue
        if mark in environment and line:
            yield int(place.name), parent, line


# ------------------------------------------------------------------------------------------- processes in `make test`
MAY = ("system", "real", "long", "check")  # marks of tests that may start processes and terminals
STARTS: tuple[tuple[Any, str], ...] = (
    (subprocess.Popen, "__init__"),
    *((os, name) for name in ("fork", "forkpty", "openpty") if hasattr(os, name)),
)


@contextmanager
def alone(item: pytest.Item) -> Iterator[None]:
    """Refuse to start processes and terminals while a test runs that is not marked as one that does."""
    if any(item.get_closest_marker(name) for name in MAY):
        yield
        return
    kept = [(owner, name, getattr(owner, name)) for owner, name in STARTS]
    for owner, name, _ in kept:
        setattr(owner, name, refused(name.strip("_")))
    try:
        yield
    finally:
        for owner, name, call in kept:
            setattr(owner, name, call)


def refused(name: str) -> Callable[..., Any]:
    """Return what takes the place of a call that starts a process or a terminal."""

    def call(*_: Any, **__: Any) -> Any:
        pytest.fail(f"{name}: `make test` starts no process and no terminal; do without, or mark the test `system`")

    return call
