"""Letters that mean something else in one part of the family than in another (CY525 manual, section 3, comparison).

A letter that is not listed means the same in every part that has it.  Data only.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

_BEFORE, _SINCE = ("cy500", "cy512"), ("cy512", "cy525")
MEANS: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {
        "A": {**dict.fromkeys(_BEFORE, "makes the position zero"), "cy525": "sets the position to its number"},
        "D": {**dict.fromkeys(_BEFORE, "runs the program"), "cy525": "waits its number of milliseconds"},
        "F": {**dict.fromkeys(_BEFORE, "divides the rate by its number"), "cy525": "sets the first rate"},
        "H": {**dict.fromkeys(_BEFORE, "selects half steps"), "cy525": "lets the next motion run until aborted"},
        "J": {
            "cy500": "lets XSS start and stop the motor",
            **dict.fromkeys(_SINCE, "goes on at a byte of the program"),
        },
        "L": {"cy500": "lets XDIR give the direction", **dict.fromkeys(_SINCE, "repeats instructions of the program")},
        "O": {
            "cy500": "takes one step",
            "cy512": "sets one of 8 phase patterns",
            "cy525": "sets one of 4 phase patterns, or switches them off",
        },
        "P": {"cy500": "names the target of the next G", **dict.fromkeys(_SINCE, "steps to its position at once")},
        "R": {
            "cy500": "sets the rate, 1 to 253",
            "cy512": "sets the rate, 1 to 255",
            "cy525": "sets the maximum rate, 0 to 127",
        },
        "S": {
            **dict.fromkeys(_BEFORE, "sets the rise of the rate per step"),
            "cy525": "sets the acceleration, 255 the steepest",
        },
        "T": {**dict.fromkeys(_BEFORE, "branches to the start of the program"), "cy525": "branches to its target"},
        "V": dict.fromkeys(_SINCE, "points at a group for read-out"),
        "W": dict.fromkeys(_SINCE, "waits until WAIT is high"),
        "X": {"cy512": "waits its number of milliseconds", "cy525": "runs the program"},
        "Z": {"cy525": "divides the slope"},
        "$": {"cy525": "names an instruction"},
    }
)

NUMBERED: Mapping[str, tuple[str, ...]] = MappingProxyType(  # letters with which only these parts take a number
    {**dict.fromkeys("ADT", ("cy525",)), **dict.fromkeys("JLO", _SINCE), "X": ("cy512",)}
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
