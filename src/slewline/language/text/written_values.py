"""The notation of numbers and arguments: 135, 87H, 0ABH, # for switches; separated by a comma or a space."""

from __future__ import annotations

import re
from collections.abc import Iterable

from ..dialect import IN_DIGITS, LIKE_DIGITS

BETWEEN = re.compile(r" *, *| +")
_HEX = re.compile(r"[0-9][0-9A-F]*H")


def number(word: str) -> int | None:
    """Return the number in a word: decimal, or hexadecimal with a leading digit and a trailing H; otherwise None."""
    if word.isascii() and word.isdigit():
        return int(word)
    return int(word[:-1], 16) if _HEX.fullmatch(word) else None


def query_meant(letter: str, letters: Iterable[str]) -> str:
    """Return the remedy for a query letter in lower case; empty if its capital is not a query letter either."""
    return f"write ? {letter.upper()}: letters are upper case" if letter.upper() in {*letters} - {letter} else ""


def hint(word: str) -> str:
    """Return the remedy for a word that may be meant as a hexadecimal number; empty if none is known."""
    digits = word.translate(LIKE_DIGITS)
    if digits != word and number(digits) is not None:
        return f"write {digits}, {IN_DIGITS}"
    bare = re.sub(r"^(?:0X|\$|#)", "", word.upper()).removesuffix("H")
    if not bare or not re.fullmatch(r"[0-9A-F]+", bare):
        return ""
    return f"a hexadecimal number begins with a digit and ends with H: {'' if bare[0].isdigit() else '0'}{bare}H"
