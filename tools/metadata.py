"""The metadata hook of the package: its page on an index is the README, with links that lead into the repository.

If [project.urls] in pyproject.toml has no Source, the README is used unchanged.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

LINK = re.compile(r"(!?)(\[(?:[^\[\]]|\[[^\]]*\])*\])\((?!https?:|#)([^)\s]+)\)")
KINDS = {"": "blob", "!": "raw"}  # where a code host has a page, and where a picture


def absolute(text: str, source: str, version: str) -> str:
    """Return a page whose links and pictures are those of a version in the repository."""
    return LINK.sub(lambda found: f"{found[1]}{found[2]}({source}/{KINDS[found[1]]}/v{version}/{found[3]})", text)


class ReadmeHook(MetadataHookInterface):
    """The readme of the package."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Fill in what pyproject.toml lists as dynamic; the version is known by then."""
        text = Path(self.root, "README.md").read_text("utf-8")
        if source := metadata.get("urls", {}).get("Source"):
            text = absolute(text, source.rstrip("/"), metadata["version"])
        metadata["readme"] = {"content-type": "text/markdown", "text": text}
