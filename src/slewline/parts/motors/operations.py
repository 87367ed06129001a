"""Functions that the equations call, and ways to make functions from source text, in Python and Numba."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from functools import cache
from math import floor, sqrt
from types import ModuleType
from typing import Any

from ...folders import drop_source, keep_source

OPERATIONS = (
    "def where(condition, yes, no):\n    return yes if condition else no\n",
    "def clip(value, low, high):\n    return low if value < low else high if value > high else value\n",
    "def sign(value):\n    return 1.0 if value > 0.0 else -1.0 if value < 0.0 else 0.0\n",
    "def minimum(one, two):\n    return one if one < two else two\n",
    "def maximum(one, two):\n    return one if one > two else two\n",
)
NUMBA = """\
from math import floor, sqrt

from numba import njit
from numpy import rint as nearest

absolute = abs
"""


def compiled(text: str, names: dict[str, Any], place: str = "<equations of a motor>") -> dict[str, Any]:
    """Execute a Python source text; return a dictionary of `names` and of all names that the text defines."""
    space = dict(names)
    exec(compile(text, place, "exec"), space)
    return space


PYTHON = compiled("\n".join(OPERATIONS), {"floor": floor, "nearest": round, "sqrt": sqrt, "absolute": abs})


# -------------------------------------------------------------------------------------------------------- machine code
def module_text(functions: Sequence[str]) -> str:
    """Return the source text of a module of functions for Numba.

    The hash of the text is the cache key, so the text includes everything that affects the machine code.

    Raises:
        ImportError: Numba is not installed.
    """
    import numba

    return "\n\n".join(
        (
            f'"""The motion of a motor, for Numba {numba.__version__}."""\n\n{NUMBA}',
            *(f"@njit\n{function}" for function in OPERATIONS),
            *(f"@njit(nogil=True, cache=KEPT)\n{function}\n" for function in functions),
        )
    )


def machine_code(functions: Sequence[str]) -> dict[str, Callable[..., Any]]:
    """Return functions by name; Numba compiles each for new argument types, or loads it from its cache.

    Args:
        functions: the source texts of the functions; each function may call those before it.

    Raises:
        ImportError: Numba is not installed.
    """
    text = module_text(functions)
    names = [function.partition("(")[0].split()[-1] for function in functions]

    @cache
    def rebuilt() -> dict[str, Any]:
        return compiled(text, {"KEPT": False})

    path = keep_source(text)
    if path is None:
        return {name: rebuilt()[name] for name in names}
    # Numba names its machine code after the module, which it must be able to import; so there is one per text.
    module = sys.modules.setdefault(f"slewline_motor_{path.stem}", ModuleType(f"slewline_motor_{path.stem}"))
    try:
        kept = compiled(text, {"KEPT": True, "__name__": module.__name__}, str(path))
    except Exception:  # Numba raises RuntimeError, or a system error
        return {name: rebuilt()[name] for name in names}

    def safe(name: str) -> Callable[..., Any]:
        """Return the named function in a form that still works if the cache fails (damaged file, full disk)."""
        function = kept[name]

        def call(*given: Any) -> Any:
            nonlocal function
            try:
                return function(*given)
            except Exception:  # errors of any kind: the cache is unpickled at the first call
                drop_source(path)
                function = rebuilt()[name]
                return function(*given)

        return call

    return {name: safe(name) for name in names}
