"""A file that appears whole or not at all.

Bytes go to a hidden neighbour of the file, which takes its name when all is written.  What is no regular file (a
pipe, /dev/stdout) cannot be replaced and is written as it is.

A symbolic link that the user named stays, and its target is written.  Where the name is slewline's own, a link
was put there by another program: the neighbour is a new file or none, and any other is refused (`own`).
"""

from __future__ import annotations

import os
import weakref
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from io import BufferedWriter
from itertools import count
from pathlib import Path
from types import TracebackType

from ..errors import UsageError

CONVERTED = {  # files of waveforms that other programs make of a VCD file
    ".fst": "vcd2fst FILE.vcd FILE.fst makes an FST file of it",
    ".sr": "sigrok-cli -I vcd -i FILE.vcd -o FILE.sr makes a session of PulseView of it",
    ".lxt": "vcd2lxt FILE.vcd FILE.lxt makes an LXT file of it",
}
_NUMBERS = count()


def check_suffix(path: str | Path, allowed: Sequence[str], *, bare: bool = False) -> None:
    """Check that the name of a file fits what will be in it.

    Args:
        bare: a name without a suffix will do, as those of pipes.

    Raises:
        UsageError: its suffix is another one.
    """
    suffix = Path(path).suffix.lower()
    if suffix in allowed or (bare and not suffix):
        return
    *others, last = allowed
    endings = f"{', '.join(others)} or {last}" if others else last
    convert = next((f"; {how}" for ending, how in CONVERTED.items() if ending == suffix and last == ".vcd"), "")
    raise UsageError(f"{path}: give a name that ends in {endings}{convert}")


class WholeFile:
    """A binary file to write: `commit` puts it in place, `discard` leaves everything as it was.

    As a context manager it commits, or discards when the block raises.

    Args:
        own: the name was made here, not by the user: a symbolic link of that name is refused.

    Raises:
        UsageError: the path is a directory, or cannot be written.
    """

    def __init__(self, path: str | Path, own: bool = False) -> None:
        self.path = Path(path)
        self._part: Path | None = None
        with self.refusals():
            if own and self.path.is_symlink():
                raise UsageError(f"{path}: is a symbolic link, which is not followed here; remove it")
            self._target = Path(os.path.realpath(path))  # of a symbolic link, which stays
            if self._target.is_dir():
                raise UsageError(f"{path}: is a directory; give the name of a file in it")
            if not self._target.parent.is_dir():
                raise UsageError(f"{path}: there is no directory {str(self.path.parent)!r}")
            self.handle: BufferedWriter
            if self._target.is_file() or not self._target.exists():
                self._part, self.handle = neighbour(self._target)
            else:
                self.handle = open(self._target, "wb")  # noqa: SIM115
        self._end = weakref.finalize(self, _abandon, self.handle, self._part)

    def write(self, data: bytes | memoryview) -> None:
        """Append bytes."""
        with self.refusals():
            self.handle.write(data)

    def commit(self) -> None:
        """Put the file in place of what had its name; a second call does nothing."""
        if not self._end.alive:
            return
        with self.refusals():
            self.handle.close()
            if self._part is not None:
                os.replace(self._part, self._target)
        self._end.detach()

    def discard(self) -> None:
        """Discard what was written, unless it is in place already."""
        self._end()

    @contextmanager
    def refusals(self) -> Iterator[None]:
        """Raise what the system refuses as an error of ours."""
        try:
            yield
        except OSError as error:
            raise UsageError(f"{self.path}: cannot be written: {error.strerror or error}") from error

    def __enter__(self) -> WholeFile:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                self.commit()
        finally:
            self.discard()


def neighbour(target: Path) -> tuple[Path, BufferedWriter]:
    """Return a new hidden file next to another one, and its name; nothing that is there already is opened."""
    while True:
        part = target.with_name(f".slewline-{os.getpid()}-{next(_NUMBERS)}.part")
        with suppress(FileExistsError):  # of a process that was killed, or a link that another program put there
            return part, open(part, "xb")


def _abandon(handle: BufferedWriter, part: Path | None) -> None:
    with suppress(OSError):  # it may try to write what it still holds, to a full disk for example
        handle.close()
    if part is not None:
        part.unlink(missing_ok=True)
