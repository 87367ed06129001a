"""What something has, by name: a dict that answers for a name that there is not, and that users only read.

    x.registers["speed"]        UnknownName: x (its part) has no register 'speed'; its registers: rate, slope ...
    x.registers["rate"] = 5     NoSuchAttribute: ...

A name that there is costs what it costs in any dict.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NoReturn, TypeVar

from ..errors import NoSuchAttribute, UnknownName
from .near import hint

T = TypeVar("T")


class Known(dict[str, T]):
    """Values by name.

    Args:
        values: what there is.
        owner: who has it, as a message begins.
        kind: what each is called: "register".
        to_set: what to do instead of setting one.
        listed: the names that a message lists; all by default.
    """

    __slots__ = ("_listed", "kind", "owner", "to_set")

    def __init__(
        self, values: Mapping[str, T], owner: str, kind: str, to_set: str, listed: Sequence[str] | None = None
    ) -> None:
        super().__init__(values)
        self.owner, self.kind, self.to_set, self._listed = owner, kind, to_set, listed

    def __missing__(self, name: object) -> NoReturn:
        names = list(self) if self._listed is None else self._listed
        says = f"{self.owner} has no {self.kind} {name!r}; its {self.kind}s: {', '.join(names) or 'none'}"
        begun = [each for each in names if isinstance(name, str) and name and each.startswith(name.lower())]
        meant = f"; did you mean {begun[0]}?" if len(begun) == 1 else hint(name, names)
        raise UnknownName(says + meant)

    def __getattr__(self, name: str) -> NoReturn:
        remedy = f"write [{name!r}]" if name in self else f"a {self.kind} goes by its name in brackets"
        raise NoSuchAttribute(f"{self.owner}: {self.kind}s have no attribute {name!r}; {remedy}")

    def _refuse(self, *_given: object, **_named: object) -> NoReturn:
        raise NoSuchAttribute(f"{self.owner}: {self.kind}s cannot be set here; {self.to_set}")

    __setitem__ = __delitem__ = __ior__ = update = setdefault = pop = popitem = clear = _refuse

    def __reduce__(self) -> tuple[Any, ...]:  # a copy is a dict like any other, to do with as one likes
        return dict, (dict(self),)
