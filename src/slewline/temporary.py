"""Folders for the files of one process, removed at its end or, if it is killed, by the next process."""

from __future__ import annotations

import os
import shutil
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory, gettempdir

from .locks import lock

PREFIX = "slewline-"
LOCK = ".lock"  # of a folder whose process is alive
LONGEST = 60  # maximum bytes in the path of the parent folder: a socket path has 103 at most


class TemporaryFolder(TemporaryDirectory[str]):
    """A new folder that only this user can access, with a path short enough for sockets.

    Forked copies of this process share the lock of the folder, and keep it locked while they are alive.
    If a copy adds files too late for `cleanup` to remove them, the next process removes them.
    """

    def __init__(self) -> None:
        place = "/tmp" if os.name == "posix" and len(os.fsencode(gettempdir())) > LONGEST else gettempdir()
        _remove_dead(Path(place))
        super().__init__(prefix=PREFIX, dir=place, ignore_cleanup_errors=True)
        name = os.path.join(self.name, LOCK)
        self._lock_file = os.open(f"{name}.new", os.O_RDWR | os.O_CREAT, 0o600)
        lock(self._lock_file)
        with suppress(PermissionError):  # on Windows an open file cannot be renamed, and the folder stays
            os.rename(f"{name}.new", name)  # not earlier: a lock without an owner belongs to a dead process

    def cleanup(self) -> None:
        """Delete the folder; a second call does nothing."""
        if self._lock_file >= 0:
            os.close(self._lock_file)
            self._lock_file = -1
        super().cleanup()


def _remove_dead(place: Path) -> None:
    """Remove the folders in `place` that killed processes of this user have left."""
    for folder in place.glob(f"{PREFIX}*"):
        with suppress(OSError):
            if os.name == "posix" and folder.lstat().st_uid != os.geteuid():
                continue
            lock_file = os.open(folder / LOCK, os.O_RDWR | getattr(os, "O_NOFOLLOW", 0))
            try:
                dead = lock(lock_file)
            finally:
                os.close(lock_file)
            if dead:
                shutil.rmtree(folder, ignore_errors=True)
