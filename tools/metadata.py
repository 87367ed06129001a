"""The metadata hook of the package: its page on an index is the README, with links that lead into the repository.

The address of the repository is the setting `source` in pyproject.toml.  As long as it is empty, the README is taken as
it is, and the package names no address.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

LINK = re.compile(r"(!?)(\[(?:[^\[\]]|\[[^\]]*\])*\])\((?!https?:|#)([^)\s]+)\)")


def absolute(text: str, source: str, version: str) -> str:
    """Return a page whose links and pictures are those of a version in the repository."""
    kinds = {"": "blob", "!": "raw"}
    return LINK.sub(lambda found: f"{found[1]}{found[2]}({source}/{kinds[found[1]]}/v{version}/{found[3]})", text)


def addresses(source: str, version: str) -> dict[str, str]:
    """Return where a version is at home, by the names that an index knows."""
    return {
        "Source": source,
        "Documentation": f"{source}/blob/v{version}/docs/index.md",
        "Changelog": f"{source}/blob/v{version}/CHANGELOG.md",
        "Issues": f"{source}/issues",
    }


class ProjectMetadata(MetadataHookInterface):
    """Readme and addresses of the package."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Fill in what pyproject.toml lists as dynamic; the version is known by then."""
        source, version = self.config["source"].rstrip("/"), metadata["version"]
        text = Path(self.root, "README.md").read_text("utf-8")
        metadata["readme"] = {
            "content-type": "text/markdown",
            "text": absolute(text, source, version) if source else text,
        }
        metadata["urls"] = addresses(source, version) if source else {}
