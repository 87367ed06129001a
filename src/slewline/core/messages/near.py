"""Which name may be meant by one that does not exist."""

from __future__ import annotations

from collections.abc import Iterable

ALIKE = 0.65  # of 1; below, "driver.speed" would stand for "driver.current"


def hint(name: object, names: Iterable[str]) -> str:
    """Return "; did you mean X?" for the nearest of some names, whatever its case, "" if none is near.

    Two letters that were swapped are nearer than any other slip.
    """
    from difflib import get_close_matches  # most runs have no use for it

    known, wanted = {each.lower(): each for each in names}, str(name).lower()
    swapped = [each for each in known if sorted(each) == sorted(wanted)]
    near = swapped[:1] or get_close_matches(wanted, known, 1, ALIKE)
    return f"; did you mean {known[near[0]]}?" if near else ""


def same_part(name: object, names: Iterable[str]) -> str:
    """Return "; did you mean X?" for the part number that a name spells otherwise, "" if there is none.

    Case, blanks and dashes do not count, nor does the order of the characters.  A part number that differs in a letter
    or a digit is another part, however near it is.
    """

    def bare(text: str) -> list[str]:
        return sorted(filter(str.isalnum, text.lower()))

    found = next((each for each in names if bare(each) == bare(str(name))), None)
    return f"; did you mean {found}?" if found else ""
