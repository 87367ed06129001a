"""Options that no chip and no part takes."""

from __future__ import annotations

import re

WRONG = {  # values that are never of the kind
    "bool": ("no", 1),
    "int": ("many", 1.5, True),
    "float": ("much", True, float("nan")),
    "number": ("fast", True, 1.5),
    "time": ("long", 1.5, -1, True),
    "frequency": ("high", 1.5, True),
    "quantity": ("much", "5 parsecs", True, float("nan")),
    "text": (5,),
    "choice": ("none of them", 1.25, True),
    "ints": ("1", 5, [True]),
    "bytes": (5, [256]),
    "table": (5, {"foo": 1}),
}


def wrong_options(rows):
    """Yield options that are refused, each with what is said of it: one that there is not, and ill-typed ones."""
    yield {"foo": 1}, re.escape("no option 'foo'; its options: " + (", ".join(row.name for row in rows) or "none"))
    for row in rows:
        for value in WRONG.get(row.kind, ()):
            yield {row.name: value}, re.escape(row.name)
