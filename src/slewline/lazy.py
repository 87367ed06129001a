"""Names that a module exports, but loads from other modules only on first use (PEP 562)."""

from __future__ import annotations

TYPE_CHECKING = False  # without loading `typing`
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from typing import Any


def lazily(
    module: dict[str, Any], places: Mapping[str, Sequence[str]], instead: Callable[[str], str] = lambda _: ""
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return `__getattr__` and `__dir__` for a module that exports names from other modules.

    Args:
        module: the `globals()` of the exporting module; each name is added to it on its first use.
        places: the names, by the slewline module that defines them: {"core.chip": ("Chip", "Finding")}.
        instead: a function that returns the remedy for an unknown name: "; ...", or "" if it has none.
    """
    where = {name: place for place, names in places.items() for name in names}

    def __getattr__(name: str) -> Any:
        if name not in where:
            remedy = "" if name.startswith("_") else instead(name)
            raise AttributeError(f"module {module['__name__']!r} has no attribute {name!r}{remedy}")
        from importlib import import_module

        module[name] = value = getattr(import_module(f"slewline.{where[name]}"), name)
        return value

    def __dir__() -> list[str]:
        return sorted({*module, *where})

    return __getattr__, __dir__
