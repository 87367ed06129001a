"""Sphinx: the search finds the pages for users first, by the words of the trade in docs/search.toml."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from sphinx.addnodes import index
from sphinx.transforms import SphinxTransform

WORDS = tomllib.loads(Path(__file__).parents[1].joinpath("search.toml").read_text("utf-8"))
INSIDE = ("decisions/", "reference/conformance")  # for contributors: who looks for a ramp does not want a decision


class SearchWords(SphinxTransform):
    """Puts the words of a page into the index: the search shows the page of such an entry before all others."""

    default_priority = 100  # before the index is made

    def apply(self, **_options: Any) -> None:
        """Add the entries of the page that is read."""
        words = self.config.search_words.get(self.env.docname, ())
        if words:
            self.document.insert(0, index(entries=[("single", word, "", "main", None) for word in words]))


def leave_out(_app: Any, env: Any) -> None:
    """Leave pages out of the full text search."""
    for page in env.found_docs:
        if page.startswith(INSIDE):
            env.metadata[page]["no-search"] = True


def setup(app: Any) -> dict[str, bool]:
    """Register both; a change of the words makes the pages anew."""
    app.add_config_value("search_words", WORDS, "env", dict)
    app.add_transform(SearchWords)
    app.connect("env-updated", leave_out)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
