"""A file that is written completely or not at all.

Bytes are written to a hidden file next to the file (its neighbour), which takes the file's name when all
bytes are written.  A file that is not regular (a pipe, /dev/stdout) cannot be replaced and is written
directly.

If the user named a symbolic link, the link is kept, and its target is written.  If slewline chose the
name (`own`), a symbolic link with that name can only come from another program, so it is refused.  The
neighbour is always a newly created file, never an existing one.

The new file has the mode of the replaced one, and its owner and group if the system permits that.  The
neighbour is locked while it is being written, so a neighbour without a lock was left by a killed
process: it is removed by the next process that writes in that folder.
"""

from __future__ import annotations

import os
import re
import stat
import warnings
import weakref
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from io import BufferedWriter
from itertools import count
from pathlib import Path

from ..closing import WholeOrNothing
from ..core.messages.calls import level_of_caller
from ..errors import UsageError
from ..locks import lock

CONVERTED = {  # waveform files that other programs can make from a VCD file
    ".fst": "vcd2fst FILE.vcd FILE.fst converts it to FST",
    ".sr": "sigrok-cli -I vcd -i FILE.vcd -o FILE.sr converts it to a session of PulseView",
    ".lxt": "vcd2lxt FILE.vcd FILE.lxt converts it to LXT",
}
_NUMBERS = count()
_PART = re.compile(r"\.slewline-[0-9]+-[0-9]+\.part")
LOCK_TRIES = 100  # after this number, the file system is taken to have no locks
_SPECIAL = stat.S_ISUID | stat.S_ISGID  # bits that only the owner may set


def check_suffix(path: str | Path, allowed: Sequence[str], *, bare: bool = False) -> None:
    """Check that a file has an allowed extension.

    Args:
        bare: also allow a name without an extension, as for pipes.

    Raises:
        UsageError: the file has no allowed extension.
    """
    suffix = Path(path).suffix.lower()
    if suffix in allowed or (bare and not suffix):
        return
    *others, last = allowed
    endings = f"{', '.join(others)} or {last}" if others else last
    convert = next((f"; {how}" for ending, how in CONVERTED.items() if ending == suffix and last == ".vcd"), "")
    raise UsageError(f"{path}: give a name that ends in {endings}{convert}")


class WholeFile(WholeOrNothing):
    """A binary file to write: `close` puts it in place, `discard` leaves any file of that name unchanged.

    As a context manager, it closes the file, or discards it if the block raises an exception.

    Args:
        own: True if slewline, not the user, chose the name; a symbolic link with that name is refused.
        durable: write the bytes to disk before the file takes its name, so that the file survives a power
            failure.

    Attributes:
        part: the hidden file that later takes the name; None if the file is written directly.

    Raises:
        UsageError: the path is a directory, or cannot be written.
    """

    def __init__(self, path: str | Path, own: bool = False, *, durable: bool = False) -> None:
        self.path, self.durable = Path(path), durable
        self.part: Path | None = None
        self._mode: int | None = None  # of the file that it replaces
        with self.refusals():
            if own and self.path.is_symlink():
                raise UsageError(
                    f"{path} is a symbolic link, which is not followed here; move it away, or use another folder"
                )
            self._target = Path(os.path.realpath(path))  # of a symbolic link, which stays
            if self._target.is_dir():
                raise UsageError(f"{path} is a directory; give the name of a file in it")
            if not self._target.parent.is_dir():
                raise UsageError(f"{path}: there is no directory {str(self.path.parent)!r}; create it")
            self.handle: BufferedWriter
            if self._target.is_file() or not self._target.exists():
                _remove_dead(self._target.parent)
                self.part, self.handle = _neighbour(self._target)
            else:
                self.handle = open(self._target, "wb")  # noqa: SIM115
        self._end = weakref.finalize(self, _abandon, self.handle, self.part)
        if self.part is not None:
            try:
                self._kept_owner = self._take_over(self.part)
            except BaseException:
                self.discard()
                raise

    def _take_over(self, part: Path) -> bool:
        """Copy the mode, owner and group of any replaced file; return whether owner and group are right."""
        try:
            before, now = self._target.stat(), part.stat()
        except FileNotFoundError:
            return True  # a new file
        owners = before.st_uid, before.st_gid
        if owners != (now.st_uid, now.st_gid):
            with suppress(OSError):
                os.chown(part, *owners)  # before the mode: a change of owner clears special bits
            now = part.stat()
        kept = owners == (now.st_uid, now.st_gid)
        self._mode = stat.S_IMODE(before.st_mode) & ~(0 if kept else _SPECIAL)
        with self.refusals():
            os.chmod(part, self._mode)
        return kept

    def write(self, data: bytes | memoryview) -> None:
        """Append bytes."""
        with self.refusals():
            self.handle.write(data)

    def close(self) -> None:
        """Put the new file in place, replacing any file of that name; a second call does nothing."""
        if not self._end.alive:
            return
        with self.refusals():
            self.handle.flush()
            if self.part is not None:
                if self._mode is not None and self._mode & _SPECIAL:
                    os.chmod(self.part, self._mode)  # writing clears special bits, except for root
                if self.durable:
                    os.fsync(self.handle.fileno())
                try:
                    os.replace(self.part, self._target)  # while it is locked
                except PermissionError:  # an open file cannot be renamed on Windows
                    self.handle.close()
                    os.replace(self.part, self._target)
            self._end.detach()
            self.handle.close()
            if self.durable and self.part is not None:
                _sync_names(self._target.parent)
        if self.part is not None and not self._kept_owner:
            warnings.warn(
                f"{self.path}: could not keep its owner and group; it now has yours", stacklevel=level_of_caller()
            )

    def discard(self) -> None:
        """Discard the written bytes, unless the file is already in place."""
        self._end()

    @contextmanager
    def refusals(self) -> Iterator[None]:
        """Convert operating system errors in a `with` block into UsageErrors."""
        try:
            yield
        except OSError as error:
            raise UsageError(f"{self.path} cannot be written: {error.strerror or error}") from error


def _neighbour(target: Path) -> tuple[Path, BufferedWriter]:
    """Create a locked hidden file next to `target`, never using an existing one; return its path and the file."""
    for number in count():
        part = target.with_name(f".slewline-{os.getpid()}-{next(_NUMBERS)}.part")
        if os.path.lexists(part):  # of a process that was killed, or a link that another program put there
            continue
        handle: BufferedWriter | None = None
        try:
            handle = open(part, "xb")  # noqa: SIM115
            if (lock(handle.fileno()) or number >= LOCK_TRIES) and part.exists():
                return part, handle
        except FileExistsError:
            continue
        except BaseException:  # on an interrupt: creating a file may take long on some disks
            _abandon(handle, part)
            raise
        _abandon(handle, part)  # another process took it for an abandoned one, before it was locked
    raise AssertionError


def _remove_dead(folder: Path) -> None:
    """Remove the hidden files in a folder that killed processes have left: those without a lock."""
    for part in folder.glob(".slewline-*.part"):
        if _PART.fullmatch(part.name) and not part.is_symlink() and part.is_file():
            with suppress(OSError), open(part, "r+b") as file:
                if lock(file.fileno()):
                    part.unlink()


def _sync_names(folder: Path) -> None:
    """Write a folder's file names to disk, so that they survive a power failure, if the folder can be opened."""
    with suppress(PermissionError):  # Windows cannot open folders
        file = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(file)
        finally:
            os.close(file)


def _abandon(handle: BufferedWriter | None, part: Path | None) -> None:
    if part is not None:
        with suppress(OSError):  # Windows cannot remove open files
            part.unlink(missing_ok=True)
    if handle is not None:
        with suppress(OSError):  # it may try to write its buffer, to a full disk for example
            handle.close()
    if part is not None:
        part.unlink(missing_ok=True)
