"""Real ports for the tests of tools for a module: ptys, and servers of the command in processes of their own."""

from __future__ import annotations

from tests.links.conftest import client, serve  # noqa: F401
