"""Items of an object by name: a dict that is read-only for users, and that explains a missing name.

    x.registers["speed"]        UnknownName: x (its part) has no register 'speed'; its registers: rate, slope ...
    x.registers["rate"] = 5     NoSuchAttribute: ...

Access to an existing name costs no more than in any dict; the facts for a message are computed only when
a message is needed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple, NoReturn, TypeVar

from ...errors import NoSuchAttribute, UnknownName
from .near import hint

T = TypeVar("T")


class NameHelp(NamedTuple):
    """The facts for a message about the named items of an object.

    Attributes:
        owner: the object that has the items, as the message calls it.
        kind: the noun for an item, such as "register".
        to_set: the remedy for an attempt to set an item.
        names: the names of the items.
        others: names of other things that users write by mistake, each with the name of the item that is
            probably meant.
    """

    owner: str
    kind: str
    to_set: str
    names: Sequence[str]
    others: Mapping[str, str] = MappingProxyType({})


class Known(dict[str, T]):
    """A read-only dict of values by name, with helpful error messages.

    Its `name_help` must be set to a function that takes this dict and returns the facts for the messages.
    """

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
