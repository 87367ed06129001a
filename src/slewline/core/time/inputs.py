"""The methods by which a user tells a chip or a part something.

    @from_outside
    def press(self, key: str) -> None:
        self.input("press", key)        told to the outside of the run: a journal writes it down, and calls it again

A journal may come from anybody: it calls no methods but those that are declared so.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, TypeVar

from ...errors import UsageError
from .kernel import Kernel

F = TypeVar("F", bound=Callable[..., Any])


def from_outside(method: F) -> F:
    """Declare that a user tells a chip or a part something by this method, which reports that (`input`)."""
    vars(method)["from_outside"] = True
    return method


def is_from_outside(value: object) -> bool:
    """Return whether this is a method that is declared so."""
    return getattr(value, "__dict__", {}).get("from_outside") is True


class HasInputs:
    """A chip or a part, with the names of its inputs; who overrides a method that is declared need not say so again."""

    input_names: ClassVar[frozenset[str]] = frozenset()
    kernel: Kernel
    name: str

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        cls.input_names = frozenset(
            name for base in cls.__mro__ for name in vars(base) if is_from_outside(vars(base)[name])
        )

    def input(self, verb: str, *args: Any) -> None:
        """Report to the outside that a user has called one of these methods, as plain data.

        Raises:
            UsageError: the method is not declared by @from_outside.
        """
        input_of(self, verb)
        outside = self.kernel.outside
        if outside.heard:
            plain = [list(arg) if isinstance(arg, bytes) else arg for arg in args]
            outside.tell("input", part=self.name, verb=verb, args=plain)


def input_of(owner: HasInputs, verb: str) -> Callable[..., Any]:
    """Return the method by which a user tells a chip or a part something.

    Raises:
        UsageError: none that is declared has this name; the message lists those there are.
    """
    if verb not in owner.input_names:
        raise UsageError(
            f"{owner.name}: {verb!r} is no input; allowed {', '.join(sorted(owner.input_names)) or 'none'}; "
            "a method of your own is declared by @from_outside"
        )
    return getattr(owner, verb)  # type: ignore[no-any-return]
