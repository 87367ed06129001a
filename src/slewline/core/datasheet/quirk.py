"""Choices of the model where a manual is silent or contradicts itself.  Data only."""

from __future__ import annotations

from typing import NamedTuple

from ..messages.former_names import formerly


@formerly(description="says")
class Quirk(NamedTuple):
    """A choice of the model where the manual is silent or contradicts itself.

    Attributes:
        id: its name, which contains UND if the manual leaves the matter undefined, or CON if it contradicts
            itself.
        where: the sections and tables of the manual.
        description: the behaviour of the model.
        why: the reason for the choice.
        test: the name of the test function that checks this behaviour.
    """

    id: str
    where: str
    description: str
    why: str
    test: str
