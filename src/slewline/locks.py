"""The lock of an open file, by which one process at a time writes to it: flock, on Windows msvcrt.locking."""

from __future__ import annotations

import os
from importlib import import_module
from typing import Any

BEHIND = 1 << 40  # a byte that no file of ours has: on Windows nobody else may read what is locked


def lock(file: int) -> bool:
    """Lock an open file until it is closed; return False if it has been locked by whoever opened it before."""
    try:
        import fcntl
    except ImportError:
        windows: Any = import_module("msvcrt")
        os.lseek(file, BEHIND, os.SEEK_SET)
        call, how = windows.locking, [windows.LK_NBLCK, 1]
    else:
        call, how = fcntl.flock, [fcntl.LOCK_EX | fcntl.LOCK_NB]
    try:
        call(file, *how)
    except OSError:  # BlockingIOError from flock, PermissionError from locking
        return False
    return True
