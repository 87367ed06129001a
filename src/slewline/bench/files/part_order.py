"""The order in which the parts of a bench file are created: each part after the parts that it names."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

from ...core.messages.near import hint
from ...errors import SlewlineError

NAMING = ("to", "on")  # keys that name another part, or a chip


def ordered(
    parts: Sequence[Mapping[str, Any]],
    names: Sequence[str],
    chips: Collection[str],
    error: Callable[[int, str, str], SlewlineError],
) -> list[int]:
    """Return the table indexes in file order, except that each part comes after the parts that it names.

    Args:
        parts: the [[part]] tables.
        names: the names of the parts.
        chips: the names of the chips, which are on the bench already.
        error: a function that returns an error, given a table index, a key, and the cause.

    Raises:
        SlewlineError: a part names a chip or part that does not exist, or parts name each other in a circle.
    """
    numbers: dict[str, int] = {}
    for number, name in enumerate(names):
        numbers.setdefault(name, number)  # a second part with the same name is refused when it is made
    placed: dict[int, None] = {}

    def missing(number: int) -> tuple[str, int] | None:
        """Return the first key that names a part not yet placed, and the index of that part; None if there is none."""
        for key in NAMING:
            wanted = parts[number].get(key)
            if wanted is None or wanted in chips:
                continue
            if wanted not in numbers:
                known = [*chips, *names]
                message = f"the bench has no {wanted!r}; available: {', '.join(known)}{hint(wanted, known)}"
                raise error(number, key, message)
            if numbers[wanted] not in placed:
                return key, numbers[wanted]
        return None

    for first in range(len(parts)):
        path = {} if first in placed else {first: None}  # each names the next one
        while path:
            number = next(reversed(path))
            found = missing(number)
            if found is None:
                placed[number] = path.pop(number)
                continue
            key, other = found
            if other in path:
                circle = [*path][[*path].index(other) :]
                shown = " -> ".join(names[each] for each in [*circle, other])
                raise error(number, key, f"parts that name each other in a cycle: {shown}; wire one with [[wire]]")
            path[other] = None
    return [*placed]
