"""A system without what only POSIX has, as far as one can be made here.

    python -m pytest -p tests.elsewhere          all tests, as on Windows; those marked `posix` are skipped
    import tests.elsewhere                       at the beginning of a process: the same for a program

Modules, signals and calls that Windows lacks are gone; sockets are no file descriptors, no directory can be opened, two
connected sockets are TCP, and a serial port has no descriptor.  What this cannot show is Windows itself.
"""

from __future__ import annotations

import errno
import io
import os
import select
import selectors
import shutil
import signal
import socket
import stat
import subprocess
import sys
import tempfile  # noqa: F401  # looks at the system once
import types

import serial
import serial.rfc2217
import serial.tools.miniterm
import serialx  # noqa: F401

MODULES = ("fcntl", "termios", "tty", "pty", "resource", "pwd", "grp", "syslog", "readline", "curses")
SIGNALS = {"SIGABRT", "SIGFPE", "SIGILL", "SIGINT", "SIGSEGV", "SIGTERM", "SIG_DFL", "SIG_IGN"}
CALLS = (
    *("O_DIRECTORY", "fork", "forkpty", "openpty", "ttyname", "mkfifo", "mknod", "killpg"),
    *("set_blocking", "get_blocking", "setsid", "nice", "chown", "fchown", "getpgid", "posix_spawn", "pwrite"),
    *("wait", "wait3", "wait4", "statvfs", "sched_getaffinity", "fdatasync", "sync", "getloadavg"),
)
OF_SIGNAL = ("pthread_sigmask", "pthread_kill", "alarm", "setitimer", "sigwait", "pause", "siginterrupt", "sigpending")
TESTS: dict[str, int] = {}


def is_a(kind, file):
    return kind(os.fstat(file).st_mode)


def of_files_only(call):
    """A call that knows no sockets."""

    def checked(file, *arguments):
        if is_a(stat.S_ISSOCK, file):
            raise OSError(errno.EBADF, "Bad file descriptor")
        return call(file, *arguments)

    return checked


def no_directories(call):
    def checked(path, *arguments, **more):
        if os.path.isdir(path):
            raise PermissionError(errno.EACCES, "Permission denied", str(path))
        return call(path, *arguments, **more)

    return checked


def connected(*_):
    """Two sockets, as Windows makes them."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        one = socket.socket()
        one.connect(server.getsockname())
        return one, server.accept()[0]


def no_descriptor(_port):
    raise io.UnsupportedOperation("fileno")


def locking(flock, how):
    """The lock of the C library of Windows."""

    def call(file, mode, _length):
        try:
            flock(file, how if mode else 0)
        except BlockingIOError:
            raise PermissionError(errno.EACCES, "Permission denied") from None

    return call


def without(module, names):
    for name in names:
        if hasattr(module, name):
            delattr(module, name)


def hide():
    import fcntl

    sys.modules["msvcrt"] = windows = types.ModuleType("msvcrt")
    windows.LK_LOCK, windows.LK_NBLCK = 1, 2
    windows.locking = locking(fcntl.flock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    for name in MODULES:
        sys.modules[name] = None
    subprocess.Popen.kill = lambda self, nine=signal.SIGKILL: self.send_signal(nine)
    without(signal, [name for name in dir(signal) if name.startswith("SIG") and name not in SIGNALS])
    without(signal, OF_SIGNAL)
    without(os, CALLS)
    without(select, [name for name in dir(select) if "poll" in name.lower()])
    without(selectors, ["EpollSelector", "PollSelector"])
    without(socket, ["AF_UNIX", "TCP_USER_TIMEOUT"])
    selectors.DefaultSelector = subprocess._PopenSelector = selectors.SelectSelector
    os.read, os.write = of_files_only(os.read), of_files_only(os.write)
    os.open = no_directories(os.open)
    socket.socketpair = connected
    shutil._use_fd_functions = False
    serial.Serial.fileno = no_descriptor


hide()


# ------------------------------------------------------------------------------------------------------ as a plugin
def pytest_collection_finish(session):
    TESTS["all"] = len(session.items)


def pytest_terminal_summary(terminalreporter):
    ran = len(terminalreporter.stats.get("passed", ()))
    alone = len([test for test in terminalreporter.stats.get("skipped", ()) if "needs POSIX" in str(test.longrepr)])
    terminalreporter.write_line(f"elsewhere: {ran} tests passed, {alone} need POSIX")
