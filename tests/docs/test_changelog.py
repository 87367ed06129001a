"""Names stand where the changelog says that they have moved to."""

from __future__ import annotations

import re
from importlib import import_module
from inspect import ismodule

import pytest

from .blocks import ROOT

TABLE = re.findall(r"^  \| (.*?) \| (.*?) \| (.*?) \|$", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
MOVED = [row for row in TABLE if row[0].startswith("`")]


def found(place: str):
    """A module of slewline, or a name in one."""
    try:
        return import_module(f"slewline.{place}")
    except ModuleNotFoundError:
        module, _, name = place.rpartition(".")
        return getattr(import_module(f"slewline.{module}"), name)


def claims():
    """Each name that has moved, and where it is now."""
    for names, _, places in MOVED:
        homes = places.split("; ")
        for index, group in enumerate(names.split("; ")):
            place = homes[min(index, len(homes) - 1)]
            if not place.startswith("gone, use "):
                yield from ((name, re.findall(r"`([\w.]+)`", place)[-1]) for name in re.findall(r"`(\w+)`", group))


@pytest.mark.parametrize(("name", "place"), [*claims()])
def test_a_name_is_where_the_changelog_says(name, place):
    there = found(place)
    assert not ismodule(there) or hasattr(there, name)


def test_the_table_is_read():
    assert len(MOVED) > 20 and ("Course", "core.course") in claims()
