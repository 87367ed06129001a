"""Letters whose meaning differs between parts of the family.

The meanings are from the CY525 manual (section 3, comparison) and the CY545 manual (chapters 4 to 10).
A letter that is not listed means the same in every part that has it.  Data only.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

_BEFORE, _SINCE, _LATE = ("cy500", "cy512"), ("cy512", "cy525", "cy545"), ("cy525", "cy545")
_WITH_WAIT = (*_BEFORE, "cy525")
MEANS: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {
        "A": {
            **dict.fromkeys(_BEFORE, "makes the position zero"),
            **dict.fromkeys(_LATE, "sets the position to its number"),
        },
        "B": {
            **dict.fromkeys(_WITH_WAIT, "makes the programmable output high"),
            "cy545": "sets, clears or writes the bits that its number names",
        },
        "C": {
            **dict.fromkeys(_WITH_WAIT, "makes the programmable output low"),
            "cy545": "lets the next motion run until aborted",
        },
        "D": {
            **dict.fromkeys(_BEFORE, "runs the program"),
            **dict.fromkeys(_LATE, "waits its number of milliseconds"),
        },
        "F": {
            **dict.fromkeys(_BEFORE, "divides the rate by its number"),
            **dict.fromkeys(_LATE, "sets the first rate"),
        },
        "H": {
            **dict.fromkeys(_BEFORE, "selects half steps"),
            "cy525": "lets the next motion run until aborted",
            "cy545": "seeks the home sensor",
        },
        "J": {
            "cy500": "lets XSS start and stop the motor",
            **dict.fromkeys(_SINCE, "continues at a byte of the program"),
        },
        "L": {"cy500": "lets XDIR set the direction", **dict.fromkeys(_SINCE, "repeats instructions of the program")},
        "O": {
            "cy500": "takes one step",
            "cy512": "sets one of 8 phase patterns",
            "cy525": "sets one of 4 phase patterns, or switches them off",
            "cy545": "writes the mode register",
        },
        "P": {"cy500": "names the target of the next G", **dict.fromkeys(_SINCE, "steps to its position immediately")},
        "R": {
            "cy500": "sets the rate, 1 to 253",
            "cy512": "sets the rate, 1 to 255",
            "cy525": "sets the maximum rate, 0 to 127",
            "cy545": "sets the maximum rate, 0 to 255",
        },
        "S": {
            **dict.fromkeys(_BEFORE, "sets the rise of the rate per step"),
            **dict.fromkeys(_LATE, "sets the acceleration, 255 the steepest"),
        },
        "T": {
            **dict.fromkeys(_BEFORE, "branches to the start of the program"),
            "cy525": "branches to its target",
            "cy545": "branches to its target until bits match",
        },
        "U": dict.fromkeys(_WITH_WAIT, "waits until WAIT is low"),
        "V": dict.fromkeys(("cy512", "cy525"), "selects a group for read-out"),
        "W": {
            **dict.fromkeys(("cy512", "cy525"), "waits until WAIT is high"),
            "cy545": "waits until bits match",
        },
        "X": {"cy512": "waits its number of milliseconds", **dict.fromkeys(_LATE, "runs the program")},
        "Y": {"cy545": "sets the memory pointer"},
        "Z": {"cy525": "divides the slope", "cy545": "repeats instructions, with a count up to 65535"},
        "$": {"cy525": "names an instruction"},
        "?": {"cy545": "queries a parameter"},
        "[": {"cy545": "writes to the HP display"},
        '"': {"cy545": "sends characters to the display device"},
    }
)

NUMBERS: Mapping[str, Mapping[str, int]] = (
    MappingProxyType(  # number of arguments of a letter, if it differs between parts
        {
            **{letter: {"cy525": 1, "cy545": 1} for letter in "AD"},
            **{letter: {"cy545": 1} for letter in "BHW"},
            **{letter: {"cy512": 1, "cy525": 1, "cy545": 1} for letter in "JO"},
            "L": {"cy512": 2, "cy525": 2, "cy545": 2},
            **{letter: {"cy525": 1, "cy545": 2} for letter in "TZ"},
            "X": {"cy512": 1},
        }
    )
)
ALIKE: Mapping[str, str] = MappingProxyType({"cy545b": "cy545"})  # parts that have all the letters of another part


def exchanged(part: str) -> Mapping[str, Mapping[str, str]]:
    """Return a text for each letter whose meaning in a sister part differs from its meaning in this part.

    The outer key is the sister part, the inner key is the letter; the text states both meanings.
    """
    part = ALIKE.get(part, part)
    sisters = sorted({other for means in MEANS.values() for other in means} - {part})
    return {
        sister: {
            letter: f"{letter} {means[sister]} in the {sister.upper()}; here it {means.get(part, 'is unknown')}"
            for letter, means in MEANS.items()
            if sister in means and means[sister] != means.get(part)
        }
        for sister in sisters
    }
