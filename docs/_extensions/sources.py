"""Sphinx: links to files of the repository, such as a test that proves a fact.

Where pyproject.toml has the address of the repository (`[project.urls] Source`) they lead there, to the line on which
what they name is defined; without it the file comes along with the pages.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.addnodes import download_reference

ROOT = Path(__file__).resolve().parents[2]


def address(version: str) -> str:
    """Return the address of the files of a version; "": no code host is known."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    source = project.get("urls", {}).get("Source", "").rstrip("/")
    return source and f"{source}/blob/v{version}"


def line_of(path: Path, name: str) -> int:
    """Return the line of a file on which a function or class is defined; 0: there is none of this name."""
    text = path.read_text("utf-8")
    found = re.search(rf"^ *(?:async )?(?:def|class) {re.escape(name)}\b", text, re.MULTILINE)
    return text.count("\n", 0, found.start()) + 1 if found else 0


def lead_to_host(app: Any, tree: Any) -> None:
    """Let links to files of the repository outside the documentation lead to the code host."""
    if not app.config.source_url:
        return
    for node in list(tree.findall(download_reference)):
        path = (Path(app.env.doc2path(app.env.docname)).parent / node["reftarget"]).resolve()
        if path.is_relative_to(ROOT) and not path.is_relative_to(app.srcdir):
            line = line_of(path, node.astext())
            url = f"{app.config.source_url}/{path.relative_to(ROOT).as_posix()}" + f"#L{line}" * bool(line)
            node.replace_self(nodes.reference("", "", *node.children, refuri=url, internal=False))


def setup(app: Any) -> dict[str, bool]:
    """Register it, before Sphinx collects the files that come along."""
    app.add_config_value("source_url", lambda config: address(config.version), "env")
    app.connect("doctree-read", lead_to_host, priority=100)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
