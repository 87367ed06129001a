"""What `slewline --version` says: the version, and which build of it runs."""

from __future__ import annotations

from importlib.machinery import EXTENSION_SUFFIXES
from types import ModuleType

from ..version import __version__

PLAIN, COMPILED = "plain Python", "compiled core"


def is_compiled(module: ModuleType) -> bool:
    """Return whether a module that is loaded comes from an extension file."""
    return str(module.__file__).endswith(tuple(EXTENSION_SUFFIXES))


def build() -> str:
    """Return which build runs, by what the kernel is loaded from."""
    from ..core.time import kernel

    return COMPILED if is_compiled(kernel) else PLAIN


def version_line() -> str:
    """Return the answer to --version."""
    return f"slewline, version {__version__} ({build()})"
