"""Letters that mean something else in one part of the family than in another (CY525 manual, section 3, comparison).

A letter that is not listed means the same in every part that has it.  Data only.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

MEANS: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {
        "A": {"cy512": "makes the position zero", "cy525": "sets the position to its number"},
        "D": {"cy512": "runs the program", "cy525": "waits its number of milliseconds"},
        "F": {"cy512": "divides the rate by its number", "cy525": "sets the first rate"},
        "H": {"cy512": "selects half steps", "cy525": "lets the next motion run until aborted"},
        "O": {"cy512": "sets one of 8 phase patterns", "cy525": "sets one of 4 phase patterns, or switches them off"},
        "R": {"cy512": "sets the rate, 1 to 255", "cy525": "sets the maximum rate, 0 to 127"},
        "S": {"cy512": "sets the rise of the rate per step", "cy525": "sets the acceleration, 255 the steepest"},
        "T": {"cy512": "branches to the start of the program", "cy525": "branches to its target"},
        "X": {"cy512": "waits its number of milliseconds", "cy525": "runs the program"},
        "Z": {"cy525": "divides the slope"},
        "$": {"cy525": "names an instruction"},
    }
)

NUMBERED: Mapping[str, tuple[str, ...]] = MappingProxyType(  # letters with which only these parts take a number
    {"A": ("cy525",), "D": ("cy525",), "T": ("cy525",), "X": ("cy512",)}
)


def exchanged(part: str) -> Mapping[str, Mapping[str, str]]:
    """Return what letters mean in the sister parts and not in this one: by sister, then by letter, in words."""
    sisters = sorted({other for means in MEANS.values() for other in means} - {part})
    return {
        sister: {
            letter: f"{letter} {means[sister]} in the {sister.upper()}; here it {means.get(part, 'is unknown')}"
            for letter, means in MEANS.items()
            if sister in means and means[sister] != means.get(part)
        }
        for sister in sisters
    }
