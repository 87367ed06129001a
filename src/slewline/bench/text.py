"""Text files that a user named: programs and bench files."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

from ..errors import BenchFileError

MOST_BYTES = 10_000_000


def read_text(path: str | PathLike[str], data: bytes | None = None) -> str:
    """The text of a file that a user named.

    Raises:
        BenchFileError: there is no such file, or it is no text.
    """
    try:
        data = Path(path).read_bytes() if data is None else data
    except (OSError, ValueError) as error:
        raise BenchFileError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if len(data) > MOST_BYTES:
        raise BenchFileError(f"{path}: {len(data)} bytes; allowed {MOST_BYTES}")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        found = f"byte {data[error.start]:02X} in line {line} is not UTF-8 text"
        raise BenchFileError(f"{path}: {found}; is it the right file?") from None
    if "\0" in text:
        raise BenchFileError(f"{path}: holds zero bytes, so it is no text; is it the right file?")
    return text
