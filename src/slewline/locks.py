"""The lock on an open file, which lets only one process at a time write to the file.

The lock is flock, or msvcrt.locking on Windows.
"""

from __future__ import annotations

import os
from importlib import import_module
from typing import Any

BEYOND = 1 << 40  # a byte beyond the end of our files: on Windows nobody else may read locked bytes


def lock(file: int) -> bool:
    """Lock an open file until it is closed; return False if another process has locked it."""
    try:
        import fcntl
    except ImportError:
        windows: Any = import_module("msvcrt")
        call, how = windows.locking, [windows.LK_NBLCK, 1]
        at: int | None = os.lseek(file, 0, os.SEEK_CUR)
        os.lseek(file, BEYOND, os.SEEK_SET)
    else:
        call, how, at = fcntl.flock, [fcntl.LOCK_EX | fcntl.LOCK_NB], None
    try:
        call(file, *how)
    except OSError:  # BlockingIOError from flock, PermissionError from locking
        return False
    finally:
        if at is not None:
            os.lseek(file, at, os.SEEK_SET)
    return True
