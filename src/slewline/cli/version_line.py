"""The text of `slewline --version`: the version, and the build in use."""

from __future__ import annotations

from importlib.machinery import EXTENSION_SUFFIXES
from types import ModuleType

from ..version import __version__

PLAIN, COMPILED = "plain Python", "compiled core"


def is_compiled(module: ModuleType) -> bool:
    """Return whether a loaded module comes from a compiled extension file."""
    return str(module.__file__).endswith(tuple(EXTENSION_SUFFIXES))


def build() -> str:
    """Return the build in use, plain Python or compiled core, judging by the file of the kernel module."""
    from ..core.time import kernel

    return COMPILED if is_compiled(kernel) else PLAIN


def version_line() -> str:
    """Return the text printed by --version."""
    return f"slewline, version {__version__} ({build()})"
