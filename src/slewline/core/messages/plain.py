"""Plain ASCII text, for files and for terminals that cannot show all characters, such as µ."""

from __future__ import annotations

INSTEAD = str.maketrans({"µ": "u", "²": "^2", "³": "^3"})


def ascii_of(text: str) -> str:
    """Return a text in printable ASCII: "25 us" for "25 µs", with "?" for characters that have no equivalent."""
    return "".join(letter if " " <= letter <= "~" else "?" for letter in text.translate(INSTEAD))
