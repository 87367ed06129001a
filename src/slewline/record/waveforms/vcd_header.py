"""The declarations in a VCD file header: variables by name and by identifier, and the time unit.

    $timescale 10 us $end
    $scope module board $end
    $var wire 1 ! clock $end         type, bits, identifier, name
    $var wire 8 " db [7:0] $end
    $upscope $end
    $enddefinitions $end

Declarations also end at the first time, value or $dumpvars, since some files have no $enddefinitions.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import chain, count

from ...core.time.timebase import UNITS
from ...errors import WaveformError
from .sampling import rate_in

UNITS_OF_FILES = {"fs": Fraction(1, 1000), **{unit: Fraction(UNITS[unit]) for unit in ("ps", "ns", "us", "ms", "s")}}
DECLARATIONS = frozenset(
    b"$comment $date $enddefinitions $scope $timescale $upscope $var $version $attrbegin $attrend".split()
)
REALS = frozenset(("real", "realtime", "real_parameter", "shortreal"))
WIDEST = 1 << 20  # bits
SHOWN = 60  # characters of a line in a message

_WORD = re.compile(rb"\S+")
_FOREWORD = re.compile(rb"META [^$\n]*\n")  # sigrok-cli puts one before its output
_END = re.compile(rb"(?<!\S)\$end(?!\S)")
_TIMESCALE = re.compile(r"(\d{1,6})\s*([a-z]{1,2})", re.IGNORECASE)
_RANGE = re.compile(r"(.*?)\s*(\[-?\d+(?::-?\d+)?\])")


@dataclass(frozen=True, slots=True)
class DeclaredVariable:
    """The variable that an identifier denotes: its `kind` ("bits", "real" or "string") and its `width` in bits."""

    kind: str
    width: int


@dataclass(slots=True)
class Header:
    """Declarations: variables by identifier, identifiers by variable name, and the time unit in picoseconds."""

    unit: Fraction | None = None
    variables: dict[bytes, DeclaredVariable] = field(default_factory=dict)
    names: dict[str, bytes] = field(default_factory=dict)
    scopes: list[str] = field(default_factory=list)
    rate: Fraction | None = None  # the sampling rate, Hz, if the file states it
    exact: bool = False  # our own: not sampled
    whole: bool = False  # something follows the declarations, or $enddefinitions ends them


class FilePlace:
    """A place in a file, for messages: a block of the file, and the number of lines before the block."""

    def __init__(self, path: object, block: bytes = b"", lines: int = 0) -> None:
        self.path, self.block, self.lines = path, block, lines

    def error(self, at: int, what: str) -> WaveformError:
        """Return the error `what`, with the number and the text of the line that contains byte `at` of the block."""
        number = self.lines + self.block.count(b"\n", 0, at) + 1
        begin = self.block.rfind(b"\n", 0, at) + 1
        end = self.block.find(b"\n", at)
        line = self.block[begin : end if end >= 0 else len(self.block)].rstrip(b"\r")
        from_here = max(0, min(at - begin - SHOWN // 2, len(line) - SHOWN))
        shown = line[from_here : from_here + SHOWN].decode("latin-1")
        return WaveformError(f"{self.path}, line {number}: {shown!r}: {what}")


def read_header(place: FilePlace) -> tuple[Header, int]:
    """Read the declarations at the beginning of a block.

    Returns:
        The declarations, and the index in the block of the first byte after them.

    Raises:
        WaveformError: the block does not begin with a declaration, or a declaration is invalid.
    """
    header, block = Header(), place.block
    foreword = _FOREWORD.match(block)
    at = foreword.end() if foreword else 0
    while (word := _WORD.search(block, at)) is not None:
        if word[0] not in DECLARATIONS:
            if not word[0].startswith((b"#", b"$dump")) and not header.variables:
                raise place.error(
                    word.start(), "a VCD file does not begin like this; expected a declaration such as $timescale"
                )
            header.whole = True
            return header, word.start()
        end = _END.search(block, word.end())
        if end is None:
            raise place.error(word.start(), f"{word[0].decode()} has no $end: the file is cut off here, or damaged")
        try:
            _declare(header, word[0], block[word.end() : end.start()].decode("utf-8", "replace").split())
        except ValueError as error:
            raise place.error(word.start(), str(error)) from None
        at = end.end()
        if word[0] == b"$enddefinitions":
            header.whole = True
            break
    return header, at


def _declare(header: Header, keyword: bytes, words: list[str]) -> None:
    if keyword in (b"$enddefinitions", b"$upscope") and words:
        raise ValueError(f"expected {keyword.decode()} $end")
    if keyword == b"$scope":
        header.scopes.append(words[-1] if len(words) > 1 else "")
    elif keyword == b"$upscope":
        if not header.scopes:
            raise ValueError("$upscope without an open $scope")
        header.scopes.pop()
    elif keyword == b"$timescale":
        unit = _unit(" ".join(words))
        if header.unit is not None and header.unit != unit:
            raise ValueError("a second $timescale that differs from the first")
        header.unit = unit
    elif keyword == b"$comment":
        header.rate = header.rate or rate_in(" ".join(words))
    elif keyword == b"$version":
        header.exact = words == ["slewline"]
    elif keyword == b"$var":
        _add(header, words)


def _unit(text: str) -> Fraction:
    """Return the length in picoseconds of a timescale such as "10 us"."""
    match = _TIMESCALE.fullmatch(text)
    unit = UNITS_OF_FILES.get(match[2].lower()) if match else None
    if match is None or unit is None or not int(match[1]):
        raise ValueError(f"timescale {text!r}; expected a number and one of {', '.join(UNITS_OF_FILES)}")
    return int(match[1]) * unit


def _add(header: Header, words: list[str]) -> None:
    if len(words) < 4 or not words[1].isdecimal() or not words[1].isascii() or len(words[1]) > 7:
        raise ValueError("expected $var TYPE BITS IDENTIFIER NAME $end")
    kind, width = words[0].lower(), int(words[1])
    kind = "real" if kind in REALS else "string" if kind == "string" else "bits"
    if kind == "bits" and not 1 <= width <= WIDEST:
        raise ValueError(f"{width} bits; allowed 1 to {WIDEST}")
    variable, identifier = DeclaredVariable(kind, width), words[2].encode()
    if header.variables.setdefault(identifier, variable) != variable:
        raise ValueError(f"identifier {words[2]!r} is declared again, with another type or width")
    name, bits = " ".join(words[3:]), ""
    match = _RANGE.fullmatch(name)
    if match is not None and ":" in match[2]:  # a range does not change the width
        name, bits = match[1], match[2]
    elif match is not None:  # the number of the bit
        name = match[1] + match[2]
    name = ".".join([*filter(None, header.scopes), name])
    for unused in chain((name, name + bits), (f"{name}#{number}" for number in count(2))):
        if header.names.setdefault(unused, identifier) == identifier:  # otherwise it is the name of another variable
            break
