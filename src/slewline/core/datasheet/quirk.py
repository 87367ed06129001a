"""A place where a manual is silent or contradicts itself, and what the model does there.  Data only."""

from __future__ import annotations

from typing import NamedTuple


class Quirk(NamedTuple):
    """One decision.  In its id UND means that the manual leaves it open, CON that two places of it disagree."""

    id: str
    where: str  # sections and tables of the manual
    says: str  # what the chip does
    why: str
    test: str  # the test function that pins it
