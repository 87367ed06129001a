"""Messages about calls with arguments that a function does not take."""

from __future__ import annotations

import sys
from collections.abc import Callable, Collection, Mapping
from functools import wraps
from inspect import Parameter, signature
from typing import ParamSpec, TypeVar

from ...errors import UsageError
from .near import hint

P = ParamSpec("P")
R = TypeVar("R")


def answering(
    name: str, also: str = "", options: type | None = None, defaults: Mapping[str, object] = {}
) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Return a decorator that makes calls with wrong arguments raise an error that lists the right ones.

    Args:
        name: the name of the function in a message.
        also: further text for the message.
        options: the `TypedDict` of the function's `**options`; the function's signature then lists each of
            these options.
        defaults: the defaults of these options; the function always receives a value for each option.
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        types = {} if options is None else options.__annotations__
        rest = {key: defaults[key] for key in types}
        if rest:
            _name_each(function, types, rest)

        @wraps(function)
        def called(*args: P.args, **kwargs: P.kwargs) -> R:
            try:
                if rest:
                    signature(function).bind(*args, **kwargs)
                    kwargs.update({**rest, **kwargs})
                return function(*args, **kwargs)
            except TypeError:
                if wrong := misfit(function, *args, **kwargs):
                    names = [each for each in parameters_of(function) if each not in ("self", "circuit")]
                    odd = next((each for each in kwargs if each not in names), "")
                    message = (
                        f"{name}: {wrong}; its arguments: {', '.join(names)}{also}{hint(odd, names) if odd else ''}"
                    )
                    raise UsageError(message) from None
                raise

        return called

    return decorate


def _name_each(function: Callable[..., object], types: Mapping[str, object], defaults: Mapping[str, object]) -> None:
    """Replace `**options` in the signature of a function by the individual options."""
    own = signature(function)
    named = [
        Parameter(key, Parameter.KEYWORD_ONLY, default=defaults[key], annotation=getattr(kind, "__forward_arg__", kind))
        for key, kind in types.items()
    ]
    rest = [each for each in own.parameters.values() if each.kind is not Parameter.VAR_KEYWORD]
    both = sorted([*named, *rest], key=lambda each: each.kind)
    vars(function)["__signature__"] = own.replace(parameters=both)


def parameters_of(function: Callable[..., object]) -> list[str]:
    """Return the names of the parameters of a function."""
    return [*signature(function).parameters]


def misfit(function: Callable[..., object], *args: object, **kwargs: object) -> str:
    """Return the reason why a function cannot be called with these arguments.

    It is "" if the function can be called with them, or if its signature is unknown.
    """
    try:
        signature(function).bind(*args, **kwargs)
    except TypeError as error:
        return str(error)
    except ValueError:  # written in C, without a signature
        pass
    return ""


def level_of_caller(libraries: Collection[str] = ("slewline",)) -> int:
    """Return the `stacklevel` with which a warning from the calling function refers to the user's code.

    This is the number of frames from the calling function up to the user's code.

    Args:
        libraries: packages that are not user code.
    """
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] in libraries:
        frame, level = frame.f_back, level + 1
    return level
