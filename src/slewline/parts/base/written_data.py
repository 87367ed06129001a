"""Data as written by users: text, bytes, or numbers."""

from __future__ import annotations

from collections.abc import Iterable

from ...errors import UsageError

Data = str | bytes | Iterable[int]


def as_bytes(owner: str, data: Data) -> bytes:
    """Return data from a user (ASCII text, bytes, or numbers 0 to 255) as bytes.

    Raises:
        UsageError: the data are none of these.
    """
    try:
        if isinstance(data, int):
            raise TypeError
        return data.encode("ascii") if isinstance(data, str) else bytes(data)
    except UnicodeEncodeError as error:
        raise UsageError(
            f"{owner}: {data[error.start]!r} at character {error.start + 1} is not ASCII; give bytes for raw values"  # type: ignore[index]
        ) from None
    except (TypeError, ValueError):
        raise UsageError(f"{owner}: {data!r}; expected text, bytes, or a list of numbers 0 to 255") from None
