"""The changes in a VCD file, block by block: all words of a block are processed together as byte arrays.

    #1200            time
    0!               level and identifier
    b1010 "          value and identifier, as two words; r and s likewise

A file is a sequence of words; lines are only a convention.  So the words of a block are found first, and are then
classified by their first character.  The word after a b, an r or an s is an identifier, regardless of its first
character; so, of several successive words that begin like values, every second word is an identifier.
"""

from __future__ import annotations

import re
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from ...errors import WaveformError
from .vcd_header import DeclaredVariable, FilePlace, Header
from .vcd_words import (
    KEYWORD,
    LEVEL,
    SHORT,
    TIME,
    VALUE,
    WordBounds,
    codes_of_letters,
    kinds_of_letters,
    mark_identifiers,
    quoted,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

BEFORE = -1  # the time of values before the first time
KEYWORDS = frozenset((b"$dumpvars", b"$dumpall", b"$dumpon", b"$dumpoff", b"$end", b"$vcdclose"))
CONTROLS = bytes({*range(32), 127} - set(b"\t\n\v\f\r"))
ESCAPES = {"t": "\t", "n": "\n", "r": "\r", "\\": "\\"}

_COMMENT = re.compile(rb"(?<!\S)\$comment(?!\S)")
_COMMENT_END = re.compile(rb"(?<!\S)\$end(?!\S)")
_ESCAPE = re.compile(r"\\(x[0-9a-fA-F]{2}|[0-7]{3}|[tnr\\])")
_NOT_BLANK = re.compile(rb"[^\t\n\v\f\r ]")


class Changes:
    """A collector of the changes of the variables in a header; `feed` it with blocks, then call `series`.

    `unit` is the time unit of the file, in picoseconds.
    """

    def __init__(self, path: str, header: Header, unit: Fraction) -> None:
        import numpy as np

        self.path, self.unit = path, unit
        self.order = list(header.variables)
        self._variables = list(header.variables.values())
        self._kinds = np.array([("bits", "real", "string").index(v.kind) for v in self._variables], np.int8)
        self._widths = np.array([v.width for v in self._variables], np.int64)
        self._long = {name: (1 << 63) + n for n, name in enumerate(self.order) if len(name) > SHORT}
        keys = [self._long.get(name, int.from_bytes(name, "little")) for name in self.order]
        self._by_key = np.argsort(np.array(keys, np.uint64))
        self._keys = np.array(keys, np.uint64)[self._by_key]
        widest = max((v.width for v in self._variables if v.kind == "bits"), default=1)
        self._dtype: Any = np.int8 if widest < 8 else np.int16 if widest < 16 else np.int64
        self._index: Any = np.uint16 if len(self.order) < 1 << 16 else np.int64  # of two bytes: sorted by radix
        self._parts: list[list[tuple[Any, Any, Any]]] = [[], [], []]  # of each kind: times, variables, values
        self.begin: int | None = None  # the first time in the file, 0 if there are values before it
        self.end = BEFORE  # the last one so far

    # --------------------------------------------------------------------------------------------------- one block
    def feed(self, place: FilePlace) -> int:
        """Process the changes in a block, which must end with a whole word; return the number of bytes processed.

        Any remaining bytes are a value without its identifier, or an unfinished comment.  They must be put in
        front of the next block.

        Raises:
            WaveformError: an item is not a valid change.
        """
        import numpy as np

        text, taken = _without_comments(place)
        if len(text.translate(None, CONTROLS)) < len(text):
            at = next(n for n, byte in enumerate(text) if byte in CONTROLS)
            raise place.error(at, f"byte {text[at]:#04x}; a VCD file is text: this one is damaged, or another format")
        letters = np.frombuffer(text, np.uint8)
        solid = np.zeros(len(letters) + 2, np.int8)
        np.greater(letters, 32, out=solid[1:-1].view(np.bool_))
        bounds = np.flatnonzero(solid[1:] != solid[:-1])
        begins, ends = bounds[::2], bounds[1::2]
        kinds = kinds_of_letters()[letters[begins]]
        if mark_identifiers(kinds):  # a value whose identifier follows
            taken = int(begins[-1])
            begins, ends, kinds = begins[:-1], ends[:-1], kinds[:-1]
        words = WordBounds(place, text, letters, begins, ends)
        self._refuse_strangers(words, kinds)
        times, index = self._times(words, kinds)
        self._take(words, kinds, times, index)
        if len(times) > 1:
            self.end = int(times[-1])
        return taken

    def _refuse_strangers(self, words: WordBounds, kinds: NDArray[np.int8]) -> None:
        import numpy as np

        for number in np.flatnonzero((kinds == 0) | (kinds == KEYWORD)):
            word = words[number]
            if kinds[number] == 0:
                raise words.error(number, f"{quoted(word)} is neither a time (#) nor a value (0 1 x z b r s)")
            if word not in KEYWORDS:
                known = ", ".join(sorted(keyword.decode() for keyword in KEYWORDS))
                raise words.error(number, f"{quoted(word)} among the changes; allowed {known}")

    def _times(self, words: WordBounds, kinds: NDArray[np.int8]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return two arrays: the times, and for each word the index of its time.

        The first time is the last one before the block; the others are those in the block.
        """
        import numpy as np

        named = kinds == TIME
        where = np.flatnonzero(named)
        times = np.concatenate([[self.end], words.numbers(where)])
        back = np.flatnonzero(times[1:] < times[:-1])
        if len(back):
            first = back[0]
            raise words.error(where[first], f"time runs backwards, from #{times[first]} to #{times[first + 1]}")
        if self.begin is None and len(kinds):
            changed = (kinds == LEVEL) | (kinds == VALUE)
            if len(where) and not changed[: where[0]].any():
                self.begin = int(times[1])
            elif changed.any():
                self.begin = 0
        return times, np.cumsum(named)

    def _take(
        self, words: WordBounds, kinds: NDArray[np.int8], times: NDArray[np.int64], index: NDArray[np.int64]
    ) -> None:
        import numpy as np

        where = np.flatnonzero((kinds == LEVEL) | (kinds == VALUE))
        if not len(where):
            return
        scalar = kinds[where] == LEVEL
        variables = self._named(words, np.where(scalar, where, where + 1), scalar)
        first = words.letters[words.begins[where]] | 32  # in lower case
        declared, string = self._kinds[variables], first == ord("s")
        real = (first == ord("r")) | (string & (declared == 1))  # MyHDL declares real, but writes s0.5
        string &= ~real
        wrong = np.flatnonzero(declared != np.where(real, 1, np.where(string, 2, 0)))
        if len(wrong):
            variable = self._variables[variables[wrong[0]]]
            raise words.error(where[wrong[0]], f"a value of another kind; this variable is of {_kind_of(variable)}")
        at = times[index[where]]
        bits = ~(real | string)
        if bits.any():
            values = self._bits(words, where[bits], variables[bits], scalar[bits])
            self._parts[0].append((at[bits], variables[bits], values))
        if real.any():
            self._parts[1].append((at[real], variables[real], words.reals(where[real])))
        if string.any():
            texts = np.array([_unescaped(words[number][1:]) for number in where[string]] + [None], object)[:-1]
            self._parts[2].append((at[string], variables[string], texts))

    def _named(self, words: WordBounds, where: NDArray[np.intp], scalar: NDArray[np.bool_]) -> NDArray[Any]:
        """Return the numbers of the variables, read from the words that contain their identifiers.

        If a word is `scalar`, such as "0!", its identifier begins with the second character.  Any other word is
        an identifier as a whole.
        """
        import numpy as np

        keys = words.keys(where, scalar, self._long)
        found = np.minimum(np.searchsorted(self._keys, keys), max(len(self._keys) - 1, 0))
        wrong = np.flatnonzero(self._keys[found] != keys) if len(self._keys) else np.arange(1)
        if len(wrong):
            number = where[wrong[0]]
            name = words[number][int(scalar[wrong[0]]) :]
            what = f"identifier {quoted(name)} is not declared" if name else "a level has no identifier"
            raise words.error(number, f"{what}; a $var has it after BITS")
        return self._by_key[found].astype(self._index)

    def _bits(
        self, words: WordBounds, where: NDArray[np.intp], variables: NDArray[Any], scalar: NDArray[np.bool_]
    ) -> NDArray[Any]:
        """Return the values of wires and buses, read from the given words: numbers, FLOATING or UNKNOWN."""
        import numpy as np

        values = codes_of_letters()[words.letters[words.begins[where]]].astype(self._dtype)
        vectors = np.flatnonzero(~scalar)
        if len(vectors):
            widths = self._widths[variables[vectors]]
            values[vectors], over = words.vectors(where[vectors], widths)
            if len(over):
                width = widths[over[0]]
                raise words.error(where[vectors[over[0]]], f"a value of more bits than its variable has: {width}")
        return values

    # ---------------------------------------------------------------------------------------------------- the whole
    def series(self) -> dict[bytes, tuple[DeclaredVariable, NDArray[np.int64], NDArray[Any]]]:
        """Return the changes, keyed by identifier.

        Returns:
            For each identifier: the variable; the times of its changes, (n,) int64 ps, ascending, equal times in
            file order; and its values from these times on, (n,).

        Raises:
            WaveformError: a time is 2^63 ps or later.
        """
        import numpy as np

        if self.end * self.unit >= 1 << 63:
            raise WaveformError(f"{self.path}: a time is too large; allowed less than 2^63 ps (106 days)")
        empty: Any = (np.empty(0, np.int64), np.empty(0, self._index))
        nothing: Any = [np.empty(0, self._dtype), np.empty(0, np.float64), np.empty(0, object)]
        out: dict[bytes, tuple[DeclaredVariable, NDArray[np.int64], NDArray[Any]]] = {}
        columns = []
        for kind, parts in enumerate(self._parts):
            times, variables, values = (
                np.concatenate(column) for column in zip((*empty, nothing[kind]), *parts, strict=True)
            )
            order = np.argsort(variables, kind="stable")
            limits = np.searchsorted(variables[order], np.arange(len(self.order) + 1))
            columns.append((self.picoseconds(times[order]), values[order], limits))
        for number, (name, variable) in enumerate(zip(self.order, self._variables, strict=True)):
            times, values, limits = columns[self._kinds[number]]
            window = slice(limits[number], limits[number + 1])
            out[name] = variable, times[window], values[window]
        return out

    def picoseconds(self, times: Any) -> Any:
        """Return times in the file's unit as picoseconds, rounded down; BEFORE (no time yet) is unchanged."""
        import numpy as np

        return np.where(times == BEFORE, BEFORE, times * self.unit.numerator // self.unit.denominator)


def _without_comments(place: FilePlace) -> tuple[bytes, int]:
    """Return a block with its comments replaced by spaces, and the number of bytes that this text covers.

    If the last comment has no end, the text stops before that comment.
    """
    block = place.block
    if b"$comment" not in block:
        return block, len(block)
    parts, at = [], 0
    while (begin := _COMMENT.search(block, at)) is not None:
        parts.append(block[at : begin.start()])
        end = _COMMENT_END.search(block, begin.end())
        if end is None:
            return b"".join(parts), begin.start()
        parts.append(_NOT_BLANK.sub(b" ", block[begin.start() : end.end()]))
        at = end.end()
    return b"".join(parts) + block[at:], len(block)


def _unescaped(text: bytes) -> str:
    r"""Return a string value with its escapes (\x20, \040, \t, \n, \r, \\) replaced by their characters."""

    def plain(match: re.Match[str]) -> str:
        code = match[1]
        return chr(int(code[1:], 16)) if code[0] == "x" else chr(int(code, 8)) if code.isdigit() else ESCAPES[code]

    return _ESCAPE.sub(plain, text.decode("utf-8", "replace"))


def _kind_of(variable: DeclaredVariable) -> str:
    return f"{variable.width} bits" if variable.kind == "bits" else f"kind {variable.kind}"
