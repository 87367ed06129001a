"""A hook: an event with any number of listeners."""

from __future__ import annotations

from collections.abc import Callable
from types import BuiltinFunctionType, FunctionType, MethodType
from typing import Generic, NoReturn, ParamSpec

from ...errors import UsageError
from ..messages.calls import misfit
from ..messages.instead import missing

P = ParamSpec("P")
FUNCTIONS = (FunctionType, MethodType, BuiltinFunctionType)


class Hook(Generic[P]):
    """A list of listeners, functions that are called in the order in which they were added.

    A listener may add and remove listeners, itself included, while it is called: a removed listener is no longer
    called, and an added one is called starting with the next event.  A hook is true if it has listeners:
    `if hook: hook(...)`.
    """

    __slots__ = ("listeners",)

    def __init__(self) -> None:
        self.listeners: tuple[Callable[P, object], ...] = ()

    def add(self, listener: Callable[P, object]) -> Callable[P, object]:
        """Add a listener, and return it, so that it can later be passed to `remove`.

        Raises:
            UsageError: `listener` is not a function.
        """
        if not callable(listener):
            raise UsageError(f"a listener {listener!r}; expected a function, which is called at each event")
        self.listeners = (*self.listeners, listener)
        return listener

    def remove(self, listener: Callable[P, object]) -> None:
        """Remove a listener; a listener that was added twice remains registered once.

        Raises:
            UsageError: `listener` was not added, or has been removed.
        """
        listeners = list(self.listeners)
        if listener not in listeners:
            raise UsageError(f"remove({listener!r}): it is not a listener; pass the function that was passed to add()")
        listeners.remove(listener)
        self.listeners = tuple(listeners)

    def __repr__(self) -> str:
        count = len(self.listeners)
        return f"<{type(self).__name__}: {count} listener{'s' * (count != 1)}>"

    def __iadd__(self, listener: object) -> NoReturn:
        raise UsageError(f"hook += {listener!r}; write .add(...)")

    def __bool__(self) -> bool:
        return bool(self.listeners)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> None:
        """Call every listener."""
        listeners = self.listeners
        if not listeners and args and type(args[0]) in FUNCTIONS:  # the arguments of listeners are not functions
            raise UsageError(f"the hook is called with a listener, {args[0]!r}; write .add(...)")
        for listener in listeners:
            if self.listeners is listeners or listener in self.listeners:
                try:
                    listener(*args, **kwargs)
                except TypeError:
                    if wrong := misfit(listener, *args, **kwargs):
                        name = getattr(listener, "__name__", "of this kind")
                        raise UsageError(
                            f"a listener {name}: {wrong}; it is called with {_arguments_text(args)}"
                        ) from None
                    raise


def _arguments_text(args: tuple[object, ...]) -> str:
    return f"{len(args)} argument{'s' * (len(args) != 1)}: {', '.join(type(each).__name__ for each in args)}"


missing(Hook, **dict.fromkeys(("append", "connect", "subscribe", "register", "listen"), "{it}.add(function)"))


class CommandHook(Hook[[str]]):
    """The hook for a chip's current command, called with its text, or with "" when no command is in progress.

    If "" is reported several times in succession, only the first report reaches the listeners.
    """

    __slots__ = ("text",)

    def __init__(self) -> None:
        super().__init__()
        self.text = ""

    def __call__(self, text: str) -> None:
        if text or self.text:
            self.text = text
            if self.listeners or text.__class__ is not str:
                super().__call__(text)
