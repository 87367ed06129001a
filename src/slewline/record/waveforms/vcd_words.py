"""The words of a VCD file block, found and parsed together as byte arrays."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

from ...errors import WaveformError
from ..recording.recorder import FLOATING
from .vcd_header import FilePlace

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

UNKNOWN = -2  # the level of a signal whose state is unknown in the file: x
NO_CODE = -3
MAX_BITS = 63  # of a value that is kept
MAX_DIGITS = 18  # of a time
SHORT = 8  # bytes of an identifier that fits a number
TIME, LEVEL, VALUE, KEYWORD, IDENTIFIER = 1, 2, 3, 4, 5  # kinds of words; 0: none of them


class WordBounds:
    """The words of a block: their starts and ends."""

    def __init__(
        self,
        place: FilePlace,
        text: bytes,
        letters: NDArray[np.uint8],
        begins: NDArray[np.intp],
        ends: NDArray[np.intp],
    ) -> None:
        self.place, self.text, self.letters, self.begins, self.ends = place, text, letters, begins, ends

    def __getitem__(self, number: Any) -> bytes:
        return self.text[self.begins[number] : self.ends[number]]

    def error(self, number: Any, what: str) -> WaveformError:
        """Return the error `what`, with the line in which word `number` begins."""
        return self.place.error(int(self.begins[number]), what)

    def numbers(self, where: NDArray[np.intp]) -> NDArray[np.int64]:
        """Return the decimal numbers in words such as #1200, in which the number begins with the second character."""
        import numpy as np

        lengths, ends = self.ends[where] - self.begins[where] - 1, self.ends[where]
        out = np.zeros(len(where), np.int64)
        wrong = (lengths == 0) | (lengths > MAX_DIGITS)
        shortest, longest = (int(lengths.min()), min(int(lengths.max()), MAX_DIGITS)) if len(where) else (0, 0)
        for place in range(longest):
            digits = self.letters[np.maximum(ends - 1 - place, 0)] - np.uint8(48)
            if place >= shortest:
                digits = np.where(place < lengths, digits, np.uint8(0))
            wrong |= digits > 9
            out += digits.astype(np.int64) * 10**place
        if wrong.any():
            number = where[np.argmax(wrong)]
            raise self.error(number, f"{quoted(self[number])}; a time is # and 1 to {MAX_DIGITS} digits")
        return out

    def keys(self, where: NDArray[np.intp], prefixed: NDArray[np.bool_], long: dict[bytes, int]) -> NDArray[np.uint64]:
        """Return, as a number, the identifier in each of the words with indices `where`.

        An identifier of up to 8 bytes is converted to a number; for a longer one, the number is looked up in
        `long`.  If a word is `prefixed`, its identifier begins with the second character.
        """
        import numpy as np

        begins, ends = self.begins[where] + prefixed, self.ends[where]
        lengths = ends - begins
        longest = int(lengths.max())
        last = len(self.letters) - 1
        out = np.zeros(len(where), np.uint64)
        for place in range(min(longest, SHORT)):
            letters = self.letters[np.minimum(begins + place, last)].astype(np.uint64) << np.uint64(8 * place)
            out |= np.where(place < lengths, letters, np.uint64(0))
        if longest > SHORT:
            for number in np.flatnonzero(lengths > SHORT):
                out[number] = long.get(self.text[begins[number] : ends[number]], 0)
        return out

    def vectors(self, where: NDArray[np.intp], widths: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.intp]]:
        """Return the values of words such as b10z1, and the positions in `where` of the words with too many bits.

        A floating bit reads 1 unless all bits float.  The value of a variable wider than MAX_BITS is UNKNOWN.

        Args:
            where: the indices of the words.
            widths: the number of bits of the variable to which each word belongs.
        """
        import numpy as np

        begins, ends = self.begins[where] + 1, self.ends[where]
        lengths = ends - begins
        out = np.zeros(len(where), np.int64)
        unknown, driven, wrong = np.zeros((3, len(where)), np.bool_)
        codes = codes_of_letters()
        kept = int(min(lengths.max(), widths.max(), MAX_BITS))
        for place in range(kept):
            there = place < lengths
            code = np.where(there, codes[self.letters[np.maximum(ends - 1 - place, 0)]], np.int8(0))
            out |= (code & 1).astype(np.int64) << place  # an index of a table, where FLOATING counts as 1
            unknown |= code == UNKNOWN
            driven |= there & (code >= 0)
            wrong |= code == NO_CODE
        first = codes[self.letters[np.minimum(begins, ends - 1)]]
        wide = widths > MAX_BITS
        room = np.minimum(widths, MAX_BITS)
        spread = (first == FLOATING) & (lengths < widths)  # omitted bits are like the first bit if that floats
        whole = (np.int64(1) << room) - 1
        out = np.where(spread, out | whole & ~((np.int64(1) << np.minimum(lengths, room)) - 1), out)
        out[~driven & ~unknown] = FLOATING
        out[unknown | wide] = UNKNOWN
        for number in np.flatnonzero(wrong | (lengths == 0) | (lengths > kept)):
            letters = self[where[number]][1:].lower()
            if not letters or letters.strip(b"01xzuwlh-"):
                raise self.error(where[number], f"{quoted(self[where[number]])}; a value is b and bits, 0 1 x z")
        long = np.flatnonzero(lengths > widths)
        over = [n for n in long if self[where[n]][1 : 1 + lengths[n] - widths[n]].strip(b"0")]
        return out, np.array(over, np.intp)

    def reals(self, where: NDArray[np.intp]) -> NDArray[np.float64]:
        """Return the numbers in words such as r1.5."""
        import numpy as np

        out = np.empty(len(where), np.float64)
        for index, number in enumerate(where.tolist()):
            try:
                out[index] = float(self[number][1:])
            except ValueError:
                raise self.error(number, f"{quoted(self[number])}; a real is r and a number, as in r1.5") from None
        return out


# ----------------------------------------------------------------------------------------------------------- tables
@cache
def kinds_of_letters() -> NDArray[np.int8]:
    """Return the kind of word that each first character indicates: (256,) int8, indexed by character."""
    import numpy as np

    kinds = np.zeros(256, np.int8)
    for kind, letters in ((TIME, b"#"), (LEVEL, b"01xXzZuUwWlLhH-"), (VALUE, b"bBrRsS"), (KEYWORD, b"$")):
        kinds[list(letters)] = kind
    return kinds


@cache
def codes_of_letters() -> NDArray[np.int8]:
    """Return the level for each character, including those of nine-valued logic (VHDL): (256,) int8."""
    import numpy as np

    codes = np.full(256, NO_CODE, np.int8)
    for code, letters in ((0, b"0lL"), (1, b"1hH"), (FLOATING, b"zZ"), (UNKNOWN, b"xXuUwW-")):
        codes[list(letters)] = code
    return codes


def mark_identifiers(kinds: NDArray[np.int8]) -> bool:
    """Mark each word that follows a value as IDENTIFIER; return whether the last word is itself a value.

    In this case its identifier is the first word of the next block.
    """
    import numpy as np

    like_values = kinds == VALUE
    if not like_values.any():
        return False
    before = np.append(False, like_values[:-1])
    place = np.arange(len(kinds))
    since = np.maximum.accumulate(np.where(like_values & ~before, place, 0))
    values = np.flatnonzero(like_values & ((place - since) % 2 == 0))
    pending = bool(values[-1] == len(kinds) - 1)
    kinds[values[: len(values) - pending] + 1] = IDENTIFIER
    return pending


def quoted(word: bytes) -> str:
    """Return up to 20 characters of the beginning of a word, in quotes, for a message."""
    shown = word[:20].decode("latin-1")
    return repr(shown) + ("..." if len(word) > 20 else "")
