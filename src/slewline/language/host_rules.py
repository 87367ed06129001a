"""Lint rules about the pins that a host drives between its commands."""

from __future__ import annotations

import re

from .statements import Directive, Source

DRIVEN = re.compile(r"@(?:drive|pulse)\s+(\w+)\s*=")


def directives(source: Source) -> list[Directive]:
    """Return the directives of a text (the lines for the host), in the order of the text."""
    return [item for item in source.items if isinstance(item, Directive)]


def driven(source: Source) -> None:
    """Report directives that drive an output pin of the part, because two outputs on one net conflict."""
    outputs = {pin.name: pin for pin in source.sheet.pins if pin.in_out == "out"}
    for item in directives(source):
        found = DRIVEN.match(item.text)
        if found and found[1] in outputs:
            message, where = f"{found[1]} is an output of the {source.sheet.part.upper()}", outputs[found[1]].where
            source.report(item, "driven-output", "warning", message, section=where, remedy="drive an input")
