"""What something has, by name: a dict that explains a missing name, and that users only read.

    x.registers["speed"]        UnknownName: x (its part) has no register 'speed'; its registers: rate, slope ...
    x.registers["rate"] = 5     NoSuchAttribute: ...

A name that there is costs what it costs in any dict, and what a message needs is asked for when there is one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple, NoReturn, TypeVar

from ...errors import NoSuchAttribute, UnknownName
from .near import hint

T = TypeVar("T")


class NameHelp(NamedTuple):
    """What a message says of names: what has them, what each is called, what to do instead of setting one, which.

    `others` are names that are not theirs, and which is meant by each.
    """

    owner: str
    kind: str
    to_set: str
    names: Sequence[str]
    others: Mapping[str, str] = MappingProxyType({})


class Known(dict[str, T]):
    """Values by name; `name_help` is to be set: it returns what a message says of them."""

    __slots__ = ("name_help",)
    name_help: Callable[[Known[T]], NameHelp]

    def __missing__(self, name: object) -> NoReturn:
        owner, kind, _, names, others = self.name_help(self)
        meant = f"; did you mean {others[str(name)]}?" if str(name) in others else hint(name, names)
        raise UnknownName(f"{owner} has no {kind} {name!r}; its {kind}s: {', '.join(names) or 'none'}{meant}")

    def __getattr__(self, name: str) -> NoReturn:
        if name in Known.__slots__:  # of a copy that is being made
            raise AttributeError(name)
        owner, kind, *_ = self.name_help(self)
        remedy = f"write [{name!r}]" if name in self else f"a {kind} goes by its name in brackets"
        raise NoSuchAttribute(f"{owner}: {kind}s have no attribute {name!r}; {remedy}")

    def _refuse(self, *_given: object, **_named: object) -> NoReturn:
        owner, kind, to_set, *_ = self.name_help(self)
        raise NoSuchAttribute(f"{owner}: {kind}s cannot be set here; {to_set}")

    __setitem__ = __delitem__ = __ior__ = update = setdefault = pop = popitem = clear = _refuse

    def __reduce__(self) -> tuple[Any, ...]:  # a copy is a dict like any other, to do with as one likes
        return dict, (dict(self),)
