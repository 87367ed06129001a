"""Suggestions for a name that does not exist, by the same rules for options, commands, chips, keys etc.

A known name is near if typing slips turn it into the name that was written: an extra, missing, wrong or
swapped letter (one in short names, up to three in long ones), a different separator between words, or an
unfinished name.  Names further away are not suggested: a wrong suggestion is worse than none.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

SLIPS = ((3, 0), (6, 1), (10, 2))  # names shorter than this number of letters: slips
MOST_SLIPS = 3


def hint(name: object, names: Iterable[str]) -> str:
    """Return "; did you mean X?", where X is the nearest of `names`, ignoring case; "" if none is near."""
    found = near(name, names)
    return f"; did you mean {found[0]}?" if found else ""


def near(name: object, names: Iterable[str]) -> list[str]:
    """Return the nearest of `names`, with the fewest slips from `name`, ignoring case; empty if none is near.

    If no name is within the allowed number of slips, but exactly one of `names` begins with `name`, that one
    is returned.
    """
    wanted, known = bare(str(name)), {each: bare(each) for each in names}
    if not wanted:
        return []
    found = [(slips, each) for each, letters in known.items() if (slips := slips_between(wanted, letters)) is not None]
    if found:
        fewest = min(slips for slips, _ in found)
        return [each for slips, each in found if slips == fewest]
    begun = [each for each, letters in known.items() if letters.startswith(wanted)]
    return begun if len(begun) == 1 else []


def bare(name: str) -> str:
    """Return a name in lower case, without dashes, underscores, dots and spaces; as given if nothing is left."""
    return re.sub(r"[-_. ]", "", name.lower()) or name


def slips_between(one: str, other: str) -> float | None:
    """Return the number of typing slips between two names; None if it is too large for their length.

    Names that differ only in doubled letters, such as "halt" and "hallt", are half a slip apart.
    """
    if one == other:
        return 0
    if re.sub(r"(.)\1+", r"\1", one) == re.sub(r"(.)\1+", r"\1", other):
        return 0.5
    length = max(len(one), len(other))
    most = next((slips for shorter, slips in SLIPS if length < shorter), MOST_SLIPS)
    if abs(len(one) - len(other)) > most:
        return None
    slips = distance(one, other)
    return slips if slips <= most else None


def distance(one: str, other: str) -> int:
    """Return the least number of changes that turn one name into the other.

    A change inserts, omits or replaces a letter, or swaps two adjacent ones.
    """
    before: list[int] = []
    row: list[int] = [*range(len(other) + 1)]
    for here, letter in enumerate(one, 1):
        last, before, row = before, row, [here]
        for there, also in enumerate(other, 1):
            cost = min(before[there] + 1, row[-1] + 1, before[there - 1] + (letter != also))
            if here > 1 < there and letter == other[there - 2] and one[here - 2] == also:
                cost = min(cost, last[there - 2] + 1)
            row.append(cost)
    return row[-1]


def same_part(name: object, names: Iterable[str]) -> str:
    """Return "; did you mean X?" if `name` is another spelling of the known part number X; "" if it is not.

    Case, spaces, dashes and the order of the characters are ignored.  A part number that differs in a letter
    or a digit denotes another part, however similar.
    """

    def letters(text: str) -> list[str]:
        return sorted(filter(str.isalnum, text.lower()))

    found = next((each for each in names if letters(each) == letters(str(name))), None)
    return f"; did you mean {found}?" if found else ""
