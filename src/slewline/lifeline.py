"""Child processes that end when their parent process ends, however the parent ends.

The parent keeps one end of a pipe open and does nothing with it.  The operating system closes that end
when the parent ends, on every platform and even after SIGKILL; the child detects this at the other
end.  A child ignores signals that a terminal or a supervisor sends to all processes of a command; only
the parent obeys them.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from typing import IO, TYPE_CHECKING, Any

if TYPE_CHECKING:
    import subprocess

SENT_TO_ALL = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT")  # if the system has them


def start(
    command: Sequence[str], environment: Mapping[str, str], errors: IO[bytes] | None = None
) -> subprocess.Popen[bytes]:
    """Start a program with pipes as its standard input and output; slewline programs end when their input ends.

    Args:
        environment: the environment of the program.
        errors: the file for its standard error; None: the standard error of this process.
    """
    import subprocess

    pipe, group = subprocess.PIPE, getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)  # Ctrl-C does not reach it
    with termination_deferred():
        return subprocess.Popen(
            command, stdin=pipe, stdout=pipe, stderr=errors, env=dict(environment), creationflags=group
        )


@contextmanager
def termination_deferred() -> Iterator[None]:
    """Block the signals that are sent to all processes of a command, while a `with` block starts processes.

    The started processes inherit the blocked signals, so only this process obeys them.
    """
    mask: Any = getattr(signal, "pthread_sigmask", None)
    if mask is None:  # on Windows
        yield
        return
    kept = mask(signal.SIG_BLOCK, [getattr(signal, name) for name in SENT_TO_ALL])
    try:
        yield
    finally:
        mask(signal.SIG_SETMASK, kept)


def obey_termination() -> None:
    """Let SIGTERM end this process, although the signal was blocked when the process was started."""
    mask: Any = getattr(signal, "pthread_sigmask", None)
    if mask is not None:
        mask(signal.SIG_UNBLOCK, [signal.SIGTERM])


def follow(wait: Callable[[], object], end: Callable[[], object] = lambda: os._exit(0)) -> None:
    """Start a thread that ends this process when the process that started it has ended.

    Args:
        wait: a function that returns when the starting process has ended; it is called in the thread.
        end: a function that is called when `wait` has returned; by default it ends this process.
    """

    def run() -> None:
        wait()
        end()

    threading.Thread(target=run, name="lifeline", daemon=True).start()


def end_of_input() -> None:
    """Wait until standard input ends, ignoring its content."""
    with suppress(OSError):
        while os.read(0, 4096):
            pass


def end_of_parent() -> None:
    """Wait until the process that started this one with `multiprocessing` has ended."""
    from multiprocessing import parent_process
    from multiprocessing.connection import wait

    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel])


def how(status: int) -> str:
    """Return how a process has ended, given its return code: "signal 9", "exit status 1"."""
    return f"signal {-status}" if status < 0 else f"exit status {status}"
