"""What slewline remembers from one call to the next, and how a figure is kept from being that of a look-up."""

from __future__ import annotations

import gc
from functools import _lru_cache_wrapper
from typing import Any


def caches() -> list[_lru_cache_wrapper[Any]]:
    """Every cache of a function of slewline, in whatever module, class or function it stands."""
    found = (each for each in gc.get_objects() if type(each) is _lru_cache_wrapper)  # a proxy may be dead
    return [each for each in found if str(each.__module__).startswith("slewline")]


def forget() -> None:
    """Empty them all."""
    for cache in caches():
        cache.cache_clear()
