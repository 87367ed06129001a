"""Lines of a value change dump, produced from a table of texts.

Every change is one number that combines its time and its code, so that one sort puts all changes in
order.  Digits come from a table, four at a time.  The lines of a chunk are one matrix of bytes, from
which a mask removes the unneeded bytes: times that are already written, and the padding of short texts.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

BLOCK_ROWS = 1 << 14  # rows that the processor's cache holds


class ChangeTexts:
    """A table of the texts of changes, such as "0!"; the index of a text in the table is its code.

    The texts that any chunk may contain come first, followed by any that occur in one chunk only.
    """

    def __init__(self, texts: Sequence[str]) -> None:
        import numpy as np

        self.texts: list[str] = list(texts)
        self.bits = len(self.texts).bit_length()
        self._lengths = np.array([len(text) for text in self.texts])
        width = int(self._lengths.max(initial=0))
        self._even = bool((self._lengths == width).all())
        # "\n" in front: a time ends with it, and so the commonest row is a whole number of 4-byte words
        padded = "".join("\n" + text.ljust(width) for text in self.texts)
        self._rows = np.frombuffer(padded.encode("ascii"), np.uint8).reshape(-1, width + 1)

    def with_more(self, texts: Sequence[str]) -> ChangeTexts:
        """Return a table of this table's texts followed by `texts`, or this table itself if `texts` is empty."""
        return ChangeTexts([*self.texts, *texts]) if texts else self

    def lines(self, units: NDArray[np.int64], codes: NDArray[np.int64]) -> bytes:
        """Return the lines of changes, with each instant written once.

        Args:
            units: (n,) int64, times in units of the file, ascending.
            codes: (n,) int64, the indices of the texts.
        """
        import numpy as np

        named = np.append(True, units[1:] != units[:-1])
        parts = []
        begin = 0
        while begin < len(units):  # rows of equal width: times of equally many digits
            digits = len(str(units[begin]))
            end = min(int(np.searchsorted(units, 10**digits)), begin + BLOCK_ROWS)
            parts.append(self._block(units[begin:end], codes[begin:end], named[begin:end], digits))
            begin = end
        return b"".join(parts)

    def _block(
        self, units: NDArray[np.int64], codes: NDArray[np.int64], named: NDArray[np.bool_], digits: int
    ) -> bytes:
        import numpy as np

        width = self._rows.shape[1]
        rows = np.empty((len(units), 1 + digits + width), np.uint8)
        _put_times(rows, units, digits)
        if width == 4:
            _words(rows, 1 + digits)[:] = self._rows.view(np.uint32)[:, 0][codes]
        else:
            rows[:, 1 + digits :] = self._rows[codes]
        repeated = np.flatnonzero(~named)
        if self._even and 16 * len(repeated) < len(rows):  # only a few times to remove
            return _without(rows, repeated, digits + 2)
        needed = _needed(digits, width - 1).take(named * width + self._lengths[codes], axis=0)
        return bytes(rows[needed].data)


@cache
def _needed(digits: int, longest: int) -> NDArray[np.bool_]:
    """Return masks that select the bytes of a row which are written to the file.

    There is a mask for each text length from 0 to `longest` bytes: first those for rows without a time, then
    those for rows with a time.
    """
    import numpy as np

    column = np.arange(digits + 2 + longest)
    lengths = np.arange(longest + 1)[:, None]
    change = (column >= digits + 2) & (column < digits + 2 + lengths)
    return np.concatenate([change, change | (column < digits + 2)])


def _without(rows: NDArray[np.uint8], shorter: NDArray[np.intp], head: int) -> bytes:
    """Return the bytes of all rows; the rows with indices in `shorter` lose their first `head` bytes."""
    flat = rows.ravel().data
    begins = (shorter * rows.shape[1]).tolist()
    return b"".join(flat[a:b] for a, b in zip([0, *(n + head for n in begins)], [*begins, len(flat)], strict=True))


def _words(rows: NDArray[np.uint8], column: int) -> NDArray[np.uint32]:
    """Return a view of four adjacent columns, from `column` on, as one 32-bit word per row: (n,) uint32."""
    import numpy as np

    words: NDArray[np.uint32] = rows[:, column : column + 4].view(np.uint32)[:, 0]
    return words


def _put_times(rows: NDArray[np.uint8], units: NDArray[np.int64], digits: int) -> None:
    """Write "#" and the digits of the times into the first columns of the rows."""
    fours, lead = divmod(digits, 4)
    words = []
    for _ in range(fours):
        upper = units // 10_000
        words.append(_digits(4)[units - upper * 10_000])
        units = upper
    # "#" and the odd digits fill a word, padded with bytes that are overwritten later
    words.append(_digits(lead, "#")[units])
    for number, word in enumerate(reversed(words)):
        _words(rows, max(lead + 4 * number - 3, 0))[:] = word


@cache
def _digits(count: int, sign: str = "") -> NDArray[np.uint32]:
    """Return the text of every number of `count` digits, with `sign` before it, as a 32-bit word: (10**count,).

    Texts of fewer than four characters are padded with spaces.
    """
    import numpy as np

    numbers = [f"{number:0{count}d}" if count else "" for number in range(10**count)]
    return np.frombuffer("".join((sign + number).ljust(4) for number in numbers).encode(), np.uint32)
