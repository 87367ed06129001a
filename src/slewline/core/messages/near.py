"""Which name may be meant by one that does not exist: one measure for options, commands, chips, keys and all others.

Near is what a slip of the fingers or the memory makes: a letter too many, too few, wrong, or swapped with its
neighbour, of few letters one, of many up to three; a sign between words; a name that was begun and not finished.
Anything further away is not suggested: a wrong suggestion costs more than none.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

SLIPS = ((3, 0), (6, 1), (10, 2))  # names shorter than so many letters: slips
MOST_SLIPS = 3


def hint(name: object, names: Iterable[str]) -> str:
    """Return "; did you mean X?" for the nearest of some names, whatever its case, "" if none is near."""
    found = near(name, names)
    return f"; did you mean {found[0]}?" if found else ""


def near(name: object, names: Iterable[str]) -> list[str]:
    """Return the nearest of some names, whatever their case: those with the fewest slips; none if none is near.

    A name that was only begun leads to the one that goes on so, if no other one does.
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
    """Return the letters and digits of a name, without case and the signs between words."""
    return re.sub(r"[-_. ]", "", name.lower()) or name


def slips_between(one: str, other: str) -> float | None:
    """Return how many slips make one name of another; None: more than are near, for names of this length.

    A letter that was typed twice is half a slip.
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
    """Return the number of letters to insert, to leave out, to replace, or to swap with the next one."""
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
    """Return "; did you mean X?" for the part number that a name spells otherwise, "" if there is none.

    Case, blanks and dashes do not count, nor does the order of the characters.  A part number that differs in a letter
    or a digit is another part, however near it is.
    """

    def letters(text: str) -> list[str]:
        return sorted(filter(str.isalnum, text.lower()))

    found = next((each for each in names if letters(each) == letters(str(name))), None)
    return f"; did you mean {found}?" if found else ""
