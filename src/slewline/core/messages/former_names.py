"""Former names of fields and arguments, which still work.

With `@formerly(description="says")`, the former name `says` still works for `description`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from functools import wraps
from operator import attrgetter
from typing import Any, TypeVar

T = TypeVar("T", bound=Callable[..., Any])


def formerly(**names: str) -> Callable[[T], T]:
    """Return a decorator that allows former names of the fields of a class or the arguments of a function.

    Args:
        names: the former name of each field or argument, keyed by its present name.
    """
    present = {former: name for name, former in names.items()}

    def translated(function: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(function)
        def call(*args: Any, **kwargs: Any) -> Any:
            for former in present.keys() & kwargs.keys():
                kwargs[present[former]] = kwargs.pop(former)
            return function(*args, **kwargs)

        return call

    def decorated(of: T) -> T:
        if not isinstance(of, type):
            return translated(of)  # type: ignore[return-value]
        maker = "__new__" if issubclass(of, tuple) else "__init__"
        setattr(of, maker, translated(getattr(of, maker)))
        for former, name in present.items():
            setattr(of, former, property(attrgetter(name)))
        setattr(of, "_former", names)  # noqa: B010 (mypy knows no such attribute)
        return of

    return decorated


def published(row: Any) -> dict[str, Any]:
    """Return the fields of a dataclass object as a dict for JSON.

    A field that has a former name is listed under that name, on which programs that read the JSON rely.
    """
    former: dict[str, str] = getattr(row, "_former", {})
    return {former.get(name, name): value for name, value in asdict(row).items()}
