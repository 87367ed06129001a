"""Files that a user named: programs, images of memories, bench files, journals."""

from __future__ import annotations

import stat
from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import BinaryIO

from ...errors import BenchFileError

MAX_BYTES = 10_000_000


KINDS = {  # what may be in the place of a file
    stat.S_IFDIR: "a directory",
    stat.S_IFIFO: "a FIFO",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


def read_file(path: str | PathLike[str]) -> bytes:
    """Return the bytes of a regular file that a user named.

    Raises:
        BenchFileError: there is no such file, it is no regular file, or it is too long.
    """
    with refusals(path), opened(path) as file:
        data = file.read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise BenchFileError(f"{path}: more than {MAX_BYTES} bytes; is it the right file?")
    return data


def opened(path: str | PathLike[str]) -> BinaryIO:
    """Open a regular file that a user named, to read its bytes.

    Raises:
        BenchFileError: there is no such file, or it is no regular file.
    """
    with refusals(path):
        kind = stat.S_IFMT(Path(path).stat().st_mode)
        if kind != stat.S_IFREG:
            raise BenchFileError(f"{path}: is {KINDS.get(kind, 'no file')}; give a regular file")
        return open(path, "rb")


@contextmanager
def refusals(path: str | PathLike[str]) -> Iterator[None]:
    """Raise what the system refuses as an error of ours."""
    try:
        yield
    except BenchFileError:
        raise
    except (OSError, ValueError) as error:
        raise BenchFileError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None


def read_text(path: str | PathLike[str], data: bytes | None = None) -> str:
    """Return the text of a file that a user named.

    Raises:
        BenchFileError: there is no such file, or it is no text.
    """
    if data is None:
        data = read_file(path)
    elif len(data) > MAX_BYTES:
        raise BenchFileError(f"{path}: more than {MAX_BYTES} bytes; is it the right file?")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        found = f"byte {data[error.start]:02X} in line {line} is not UTF-8 text"
        raise BenchFileError(f"{path}: {found}; is it the right file?") from None
    if "\0" in text:
        raise BenchFileError(f"{path}: contains NUL bytes, so it is not text; is it the right file?")
    return text
