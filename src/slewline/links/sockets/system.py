"""Features of the operating system, and replacements for missing ones.

All differences between Linux, macOS and Windows are here, except file locks (`locks.py`).  The code
checks for the presence of a module, a call or a signal, and only when it is needed.

                        Linux                   macOS                   Windows
    sleep               select over epoll       kqueue                  select, the timer set to 1 ms
    wake-up             a pair of sockets; signals also write into it
    ports               sockets and descriptors                         sockets; a COM port by two threads
    pty                 with packet mode        without it: 8N1 only    none
    symlinks refused    O_NOFOLLOW              O_NOFOLLOW              checked before opening
    durable file names  fsync of the directory  fsync of the directory  when NTFS writes them
    a copy of a process fork                    fork                    none
    promptness          SCHED_FIFO, or nice     nice                    none
"""

from __future__ import annotations

import gc
import os
import re
import select
import selectors
import signal
import socket
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from importlib import import_module
from typing import Any

BINARY = getattr(os, "O_BINARY", 0)  # otherwise Windows writes CR LF for LF
NO_LINK = getattr(os, "O_NOFOLLOW", 0)  # refuse to open a symbolic link
FOLDER = getattr(os, "O_DIRECTORY", 0)  # refuse to open anything but a directory
EXTPROC: int | None = 0o200000 if sys.platform == "linux" else None  # of a pty; the module termios has no name for it
UNIX = getattr(socket, "AF_UNIX", -1)  # sockets in a folder
FORK: Callable[[], int] | None = getattr(os, "fork", None)
FINE_MS = 1
LONG_S = 1.0  # a longer sleep may end early, and continue
WINDOWS_PORT = re.compile(r"(?:\\\\\.\\)?com[0-9]+:?", re.IGNORECASE)  # COM3, \\.\COM12

Ready = tuple[selectors.SelectorKey, int]


# ------------------------------------------------------------------------------------------------- sleep and wake-up
class FineSelector(getattr(selectors, "EpollSelector", selectors.DefaultSelector)):  # type: ignore[misc]
    """The system's selector, with sleeps of any length.

    epoll rounds its sleep up to whole milliseconds; `select` does not.  So for a sleep of up to a second,
    `select` first waits for the descriptor of epoll itself, which is ready when any descriptor watched by
    epoll is ready.  This takes a second system call.  A longer sleep uses only epoll, and ends early.
    """

    rounds = hasattr(selectors, "EpollSelector")

    def __init__(self) -> None:
        super().__init__()
        self.urgent: set[int] = set()  # descriptors with urgent data wake it, too

    def register(self, fileobj: Any, events: int, data: Any = None) -> selectors.SelectorKey:
        """Start to watch a descriptor for the given events."""
        return self._urged(super().register(fileobj, events, data))

    def modify(self, fileobj: Any, events: int, data: Any = None) -> selectors.SelectorKey:
        """Change the events for which a descriptor is watched."""
        return self._urged(super().modify(fileobj, events, data))

    def _urged(self, key: selectors.SelectorKey) -> selectors.SelectorKey:
        if self.rounds and key.fd in self.urgent and key.events & selectors.EVENT_READ:
            writes = select.EPOLLOUT if key.events & selectors.EVENT_WRITE else 0
            self._selector.modify(key.fd, select.EPOLLIN | select.EPOLLPRI | writes)
        return key

    def select(self, timeout: float | None = None) -> list[Ready]:
        """Wait for ready descriptors, for about `timeout` seconds at most (None: no limit); return the ready ones."""
        if timeout and self.rounds and timeout > LONG_S:
            timeout -= LONG_S / 2
        elif timeout and self.rounds:
            select.select([self.fileno()], [], [], timeout)
            timeout = 0
        return super().select(timeout)  # type: ignore[no-any-return]


def pair() -> tuple[socket.socket, socket.socket]:
    """Return two connected sockets that send every byte immediately.

    On Windows they are TCP sockets, whose buffering is switched off.
    """
    ends = socket.socketpair()
    for end in ends:
        if end.family in (socket.AF_INET, socket.AF_INET6):
            end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return ends


def wakeup_pair() -> tuple[socket.socket, socket.socket]:
    """Return two sockets to wake a selector, which watches the first: a byte sent into the second wakes it."""
    ends = pair()
    for end in ends:
        end.setblocking(False)
    return ends


@contextmanager
def fine_timer() -> Iterator[None]:
    """Make sleeps in a `with` block accurate to a millisecond; the default tick of Windows is 15.6 ms."""
    timer = multimedia()
    if timer is not None:
        timer.timeBeginPeriod(FINE_MS)
    try:
        yield
    finally:
        if timer is not None:
            timer.timeEndPeriod(FINE_MS)


def multimedia() -> Any:
    """Return the Windows library with the functions that set the timer tick; None on other systems."""
    return import_module("ctypes").windll.winmm if sys.platform == "win32" else None


# ------------------------------------------------------------------------------------------------------- serial ports
@cache
def bauds() -> dict[int, int]:
    """Return the baud rates of terminals, keyed by their codes in the module `termios`; empty on Windows."""
    try:
        import termios
    except ImportError:
        return {}
    return {getattr(termios, name): int(name[1:]) for name in dir(termios) if re.fullmatch("B[1-9][0-9]*", name)}


# --------------------------------------------------------------------------------------------------------- promptness
def be_prompt() -> str:
    """Make all threads of this process wake as promptly as the system allows; return a name for the priority obtained.

    Existing objects are excluded from garbage collection: with three million objects a full collection takes
    450 ms.  Real-time priority needs permission: CAP_SYS_NICE, or `ulimit -r 1`.
    """
    gc.collect()
    gc.freeze()
    others = [thread.native_id for thread in threading.enumerate() if thread is not threading.current_thread()]
    tasks = [0, *filter(None, others)]  # 0: this one
    with suppress(AttributeError, OSError):
        for task in tasks:
            os.sched_setscheduler(task, os.SCHED_FIFO, os.sched_param(1))
        return "real-time priority (SCHED_FIFO)"
    with suppress(AttributeError, OSError):
        os.nice(-10)
        if sys.platform == "linux":  # elsewhere it applies to all threads
            for task in tasks[1:]:
                os.setpriority(os.PRIO_PROCESS, task, os.getpriority(os.PRIO_PROCESS, 0))
        return "priority -10"
    return "normal priority"


# ------------------------------------------------------------------------------------------------------------ signals
def numbers(*names: str) -> list[int]:
    """Return the numbers of the signals with these names, without any that the system lacks."""
    return [int(getattr(signal, name)) for name in names if hasattr(signal, name)]


def ends() -> list[int]:
    """Return the numbers of the signals that end a process and that this system has.

    A signal that is ignored is left out, and so stays ignored, as with `nohup` or in background jobs.
    """
    found = numbers("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGBREAK")
    return [number for number in found if signal.getsignal(number) is not signal.SIG_IGN]


def forget_children() -> None:
    """Let child processes end without leaving zombies."""
    ignore(numbers("SIGCHLD"))


def watch_children(call: Callable[[int], object]) -> None:
    """Call a function with the process number of each child process that has ended."""
    wait, at_once = getattr(os, "waitpid", None), getattr(os, "WNOHANG", 0)

    def ended(*_: object) -> None:
        with suppress(OSError):  # no children are left
            while wait is not None and (process := wait(-1, at_once)[0]):
                call(process)

    for number in numbers("SIGCHLD"):
        signal.signal(number, ended)


def ended(process: int) -> None:
    """Wait for a child process that has ended or is about to end, so that it leaves no zombie."""
    wait = getattr(os, "waitpid", None)
    with suppress(ChildProcessError):
        if wait is not None:
            wait(process, 0)


def ignore(which: Iterable[int]) -> None:
    """Ignore signals.

    They are blocked during the change.  Otherwise, if one arrived just then, Python would report a signal
    that has no handler.
    """
    which = list(which)
    mask: Callable[..., Any] | None = getattr(signal, "pthread_sigmask", None)
    kept = mask(signal.SIG_BLOCK, which) if mask is not None else None
    for number in which:
        signal.signal(number, signal.SIG_IGN)
    if mask is not None:
        mask(signal.SIG_SETMASK, kept)


# -------------------------------------------------------------------------------------------------------------- files
@contextmanager
def directory(path: os.PathLike[str], system: Any = os) -> Iterator[Callable[[], object]]:
    """Yield a function that makes the names in a directory survive a power cut.

    The function calls fsync on the directory, or does nothing on a system that cannot open directories.

    Args:
        system: a replacement for the module `os`.
    """
    try:
        file = system.open(path, os.O_RDONLY, 0o666)
    except PermissionError:
        if hasattr(os, "O_DIRECTORY"):
            raise  # not possible on this system
        yield lambda: None
        return
    try:
        yield lambda: system.fsync(file)
    finally:
        with suppress(OSError):  # fsync has reported all relevant errors
            system.close(file)


# -------------------------------------------------------------------------------------------------------------- ports
class Descriptor:
    """A file descriptor with the methods of a socket, as a `SocketStream` needs them; the caller closes it."""

    def __init__(self, fd: int) -> None:
        self.fd = fd
        os.set_blocking(fd, False)

    def fileno(self) -> int:
        """Return the descriptor."""
        return self.fd

    def recv(self, room: int) -> bytes:
        """Read available bytes, at most `room`; empty at the end."""
        return os.read(self.fd, room)

    def send(self, data: bytes | bytearray) -> int:
        """Write as many bytes as possible; return the number written."""
        return os.write(self.fd, data)
