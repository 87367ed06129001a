"""What is wrong with a call: arguments that a function does not take, reported in the words of all messages."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from ...errors import UsageError
from .near import hint

P = ParamSpec("P")
R = TypeVar("R")


def answering(name: str, also: str = "") -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Return a decorator: calls with arguments that do not fit are answered with those that do.

    Args:
        name: what the function is called in a message.
        also: what else to say.
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        @wraps(function)
        def called(*args: P.args, **kwargs: P.kwargs) -> R:
            try:
                return function(*args, **kwargs)
            except TypeError:
                if wrong := misfit(function, *args, **kwargs):
                    names = [each for each in parameters_of(function) if each not in ("self", "circuit")]
                    odd = next((each for each in kwargs if each not in names), "")
                    says = f"{name}: {wrong}; its arguments: {', '.join(names)}{also}{hint(odd, names) if odd else ''}"
                    raise UsageError(says) from None
                raise

        return called

    return decorate


def parameters_of(function: Callable[..., object]) -> list[str]:
    """Return the names of what a function takes."""
    from inspect import signature

    return [*signature(function).parameters]


def misfit(function: Callable[..., object], *args: object, **kwargs: object) -> str:
    """Return why a function cannot be called so; empty: it can, or that is not known."""
    from inspect import signature  # a correct call has no use for it

    try:
        signature(function).bind(*args, **kwargs)
    except TypeError as error:
        return str(error)
    except ValueError:  # one of C, which does not say
        pass
    return ""
