"""Numbers with a decimal comma or thousands separators, and their correct spelling."""

from __future__ import annotations

import re

THOUSANDS = re.compile(r"\s*([+-]?\d{1,3}(?:[,' _]\d{3})+)(?![\d,'_.])(.*)", re.DOTALL)
DECIMALS = re.compile(r"\s*([+-]?\d*),(\d+)(?![\d,.])(.*)", re.DOTALL)


def without_comma(text: object) -> str:
    """Return the correct spelling of a number with commas, as the end of a message; "" for anything else.

    For "0,5 s" it is "; write 0.5 s, with a decimal point", and for "6,000 steps/s" it is
    "; write 6000 steps/s, with no sign between the digits".
    """
    if not isinstance(text, str):
        return ""
    if found := THOUSANDS.fullmatch(text):
        return f"; write {re.sub(r'[^-+0-9]', '', found[1])}{found[2].rstrip()}, with no sign between the digits"
    if found := DECIMALS.fullmatch(text):
        return f"; write {found[1] or '0'}.{found[2]}{found[3].rstrip()}, with a decimal point"
    return ""
