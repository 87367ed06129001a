"""Processes that are started here, and end with the one that started them, whatever ends that one.

The parent keeps one end of a pipe and does nothing with it.  The system closes it when the parent ends, on every
system and by SIGKILL as well; the child waits for that at the other end.  Signals that a terminal or a supervisor sends
to all processes of a command mean nothing to a child: the parent obeys them.
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

SENT_TO_ALL = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT")  # as far as the system has them


def start(
    command: Sequence[str], environment: Mapping[str, str], errors: IO[bytes] | None = None
) -> subprocess.Popen[bytes]:
    """Start a program whose standard input is the pipe that ends it, and whose standard output is read.

    Args:
        environment: of the program.
        errors: where its standard error goes; None: to ours.
    """
    import subprocess

    pipe, group = subprocess.PIPE, getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)  # which Ctrl-C does not reach
    with held_back():
        return subprocess.Popen(
            command, stdin=pipe, stdout=pipe, stderr=errors, env=dict(environment), creationflags=group
        )


@contextmanager
def held_back() -> Iterator[None]:
    """Start processes inside: these signals mean nothing to them, ever; here they are obeyed a moment later."""
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
    """Let SIGTERM end this process although it was held back when it was started."""
    mask: Any = getattr(signal, "pthread_sigmask", None)
    if mask is not None:
        mask(signal.SIG_UNBLOCK, [signal.SIGTERM])


def follow(wait: Callable[[], object], end: Callable[[], object] = lambda: os._exit(0)) -> None:
    """End this process when the one that started it has ended.

    Args:
        wait: returns when that has happened; it is called in a thread.
        end: is called then.
    """

    def run() -> None:
        wait()
        end()

    threading.Thread(target=run, name="lifeline", daemon=True).start()


def end_of_input() -> None:
    """Wait until the standard input ends; what comes before is not looked at."""
    with suppress(OSError):
        while os.read(0, 4096):
            pass


def end_of_parent() -> None:
    """Wait until the process has ended that started this one by `multiprocessing`."""
    from multiprocessing import parent_process
    from multiprocessing.connection import wait

    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel])


def how(status: int) -> str:
    """Return in words how a process has ended."""
    return f"signal {-status}" if status < 0 else f"exit status {status}"
