"""Items of an object by name: a dict that explains a missing name, and that is read-only for users.

    x.registers["speed"]        UnknownName: x (its part) has no register 'speed'; its registers: rate, slope ...
    x.registers["rate"] = 5     NoSuchAttribute: ...

Access to an existing name costs no more than in any dict; the help for a message is computed only when it is needed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple, NoReturn, TypeVar

from ...errors import NoSuchAttribute, UnknownName
from .near import hint

T = TypeVar("T")


class NameHelp(NamedTuple):
    """The facts for a message about names: the items' owner, the noun for an item, a remedy, and the names.

    `to_set` is the remedy for an attempt to set an item.  `others` are names of other things that are used
    by mistake, each with the name that is probably meant.
    """

    owner: str
    kind: str
    to_set: str
    names: Sequence[str]
    others: Mapping[str, str] = MappingProxyType({})


class Known(dict[str, T]):
    """Values by name; set `name_help` to a function that returns the facts for messages."""

    __slots__ = ("name_help",)
    name_help: Callable[[Known[T]], NameHelp]

    def __missing__(self, name: object) -> NoReturn:
        owner, kind, _, names, others = self.name_help(self)
        meant = f"; did you mean {others[str(name)]}?" if str(name) in others else hint(name, names)
        raise UnknownName(f"{owner} has no {kind} {name!r}; its {kind}s: {', '.join(names) or 'none'}{meant}")

    def __getattr__(self, name: str) -> NoReturn:
        if name in Known.__slots__:  # in a copy that is being made
            raise AttributeError(name)
        owner, kind, *_ = self.name_help(self)
        remedy = f"write [{name!r}]" if name in self else f"a {kind} goes by its name in brackets"
        raise NoSuchAttribute(f"{owner}: {kind}s have no attribute {name!r}; {remedy}")

    def _refuse(self, *_given: object, **_named: object) -> NoReturn:
        owner, kind, to_set, *_ = self.name_help(self)
        raise NoSuchAttribute(f"{owner}: {kind}s cannot be set here; {to_set}")

    __setitem__ = __delitem__ = __ior__ = update = setdefault = pop = popitem = clear = _refuse

    def __reduce__(self) -> tuple[Any, ...]:  # a copy is a plain dict
        return dict, (dict(self),)
