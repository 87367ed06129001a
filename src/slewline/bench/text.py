"""Files that a user named: programs, images of memories, bench files, journals."""

from __future__ import annotations

import stat
from os import PathLike
from pathlib import Path

from ..errors import BenchFileError

MOST_BYTES = 10_000_000


KINDS = {  # what stands in the place of a file
    stat.S_IFDIR: "a directory",
    stat.S_IFIFO: "a FIFO",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


def read_file(path: str | PathLike[str], most: int | None = MOST_BYTES) -> bytes:
    """Return the bytes of a regular file that a user named.

    Args:
        most: bytes that it may have; None: any number.

    Raises:
        BenchFileError: there is no such file, it is no regular file, or it is too long.
    """
    try:
        kind = stat.S_IFMT(Path(path).stat().st_mode)
        if kind != stat.S_IFREG:
            raise BenchFileError(f"{path}: is {KINDS.get(kind, 'no file')}; give a regular file")
        with open(path, "rb") as file:
            data = file.read(-1 if most is None else most + 1)
        if most is not None and len(data) > most:
            raise BenchFileError(f"{path}: more than {most} bytes; is it the right file?")
    except (OSError, ValueError) as error:
        if isinstance(error, BenchFileError):
            raise
        raise BenchFileError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    return data


def read_text(path: str | PathLike[str], data: bytes | None = None) -> str:
    """Return the text of a file that a user named.

    Raises:
        BenchFileError: there is no such file, or it is no text.
    """
    if data is None:
        data = read_file(path)
    elif len(data) > MOST_BYTES:
        raise BenchFileError(f"{path}: more than {MOST_BYTES} bytes; is it the right file?")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        found = f"byte {data[error.start]:02X} in line {line} is not UTF-8 text"
        raise BenchFileError(f"{path}: {found}; is it the right file?") from None
    if "\0" in text:
        raise BenchFileError(f"{path}: holds zero bytes, so it is no text; is it the right file?")
    return text
