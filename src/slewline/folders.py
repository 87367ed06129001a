"""The user's folders, as the system defines them: for the state of programs, and for files that can be recreated."""

from __future__ import annotations

import os
import stat
import sys
from contextlib import suppress
from hashlib import sha256
from pathlib import Path

from .errors import UsageError


def state_folder() -> Path:
    """Return slewline's folder in the place where this system stores program state.

    Raises:
        UsageError: the user has no home directory.
    """
    return _folder("", "Library/Application Support", "XDG_STATE_HOME", ".local/state")


def cache_folder() -> Path | None:
    """Return the folder for recreatable files: SLEWLINE_CACHE, or else slewline's folder in the system's cache.

    Return None if SLEWLINE_CACHE is set, but empty: then no such files are kept.

    Raises:
        UsageError: the user has no home directory.
    """
    named = os.environ.get("SLEWLINE_CACHE")
    if named is not None:
        return Path(named).absolute() if named else None
    return _folder("Cache", "Library/Caches", "XDG_CACHE_HOME", ".cache")


def _folder(windows: str, mac: str, variable: str, usual: str) -> Path:
    if os.name == "nt":
        return Path(os.environ.get("LOCALAPPDATA") or _home("LOCALAPPDATA") / "AppData/Local") / "slewline" / windows
    if sys.platform == "darwin":
        return _home("HOME") / mac / "slewline"
    return Path(os.environ.get(variable) or _home(f"HOME or {variable}") / usual) / "slewline"


def _home(variables: str) -> Path:
    """Return the user's home directory.

    Raises:
        UsageError: the user has none, like a container user with only a numeric ID; the message names
            `variables`, the environment variables to set.
    """
    try:
        return Path.home()
    except RuntimeError:
        raise UsageError(
            f"this user has no home folder: HOME is not set, and the system does not know the user; set {variables}"
        ) from None


def keep_source(text: str) -> Path | None:
    """Cache a text in a file named after its SHA-256, and return the file's path; None if it cannot be cached.

    Files in the same folder may be executed, so nothing is cached if other users can write to the folder.
    """
    with suppress(OSError, UsageError):  # UsageError: the user has no home
        folder = cache_folder()
        if folder is None:
            return None
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        if not (_is_private(folder) and os.access(folder, os.R_OK | os.W_OK | os.X_OK)):
            return None
        data = text.encode()
        path = folder / f"{sha256(data).hexdigest()}.py"
        if not path.is_file() or path.read_bytes() != data:
            part = path.with_suffix(f".{os.getpid()}.part")
            part.write_bytes(data)
            os.replace(part, path)  # complete, even if another process writes it now
        return path
    return None


def drop_source(path: Path) -> None:
    """Remove a file that `keep_source` has created, and the files compiled from it."""
    with suppress(OSError):
        for each in (*path.parent.glob(f"{path.stem}.*"), *path.parent.glob(f"__pycache__/{path.stem}.*")):
            each.unlink(missing_ok=True)


def _is_private(folder: Path) -> bool:
    """Return whether a folder belongs to the user, and nobody else can write to it.

    On Windows, user profiles ensure this.
    """
    if not hasattr(os, "geteuid"):
        return True
    found = folder.stat()
    return found.st_uid == os.geteuid() and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
