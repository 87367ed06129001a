"""What the linter says of programs that are kept as they were written: how they begin and end, loops, pages."""

from __future__ import annotations

from ..dialect import Check, spoken_as
from ..letters.rules import ends, entries, misplaced
from ..lint import section
from ..statements import Source
from .forms import Forms


def loops(source: Source) -> None:
    """There is one count for each kind of loop, so a loop within one of its own kind takes over its count."""
    for block in source.blocks:
        counted = [statement for statement in block.statements if statement.row.role == "loop"]
        for outer in counted:
            begin = block.address_of(outer.target) if outer.target else None
            for inner in counted:
                same = inner.row is outer.row
                if same and begin is not None and begin <= inner.address < outer.address:
                    found = f"the loop of line {inner.line} lies inside this one, and has the same count"
                    remedy = "repeat one of the two with the other kind of loop"
                    source.report(outer, "nested-loop", "warning", found, section=section(outer.row), remedy=remedy)


def pages(source: Source) -> None:
    """A branch with an address of one byte reaches the page of the byte after it: it may end in the next one."""
    page = spoken_as(source.sheet, Forms).page
    for block in source.blocks:
        for statement in block.statements:
            near = statement.target is not None and statement.row.args[-1].size == 1
            if near and statement.address // page != statement.end // page:
                found = f"{statement.text} ends at a page: it branches into page {statement.end // page}"
                remedy = "a branch with an address of two bytes goes anywhere"
                source.report(
                    statement, "page-crossed", "warning", found, section=section(statement.row), remedy=remedy
                )


RULES: tuple[Check, ...] = (ends, loops, pages, misplaced, entries)
