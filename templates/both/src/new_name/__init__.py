"""The NEW-NAME, a new-kind for slewline."""

from __future__ import annotations

from .new_kind import NewName

__all__ = ["NewName"]
