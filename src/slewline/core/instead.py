"""Names that a class has not, and what it has instead; and the names of those that users are meant to use.

    missing(Chip, send="bench.host({it}).send(...)")

    x.send          NoSuchAttribute: x has no 'send'; write bench.host(x).send(...)

A missing name is a descriptor of the class and not the work of a `__getattr__`, which would make every look-up of a
name that is there slower.  `hasattr` says no, `dir` leaves it out, and an attribute of the instance goes before it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any, ClassVar, NoReturn

from ..errors import NoSuchAttribute

OURS = "slewline."
CALL = re.compile(r"[\w.{}\[\]]+(\([^()]*\))?")  # a remedy that is no more than that


def has_none(one: object, name: str, remedy: str) -> NoSuchAttribute:
    """Return the error that something has no such attribute.

    Args:
        remedy: what to write instead; "{it}" stands for the name of what is asked, or of its class.
    """
    it = one.__name__ if isinstance(one, type) else vars(one).get("name") or type(one).__name__.lower()
    return NoSuchAttribute(f"{it} has no {name!r}; {remedy.format(it=it)}")


class Instead:
    """A name that a class has not."""

    def __init__(self, name: str, remedy: str) -> None:
        self.name, self.remedy = name, remedy

    def __get__(self, one: object, cls: type | None = None) -> NoReturn:
        raise has_none(cls if one is None else one, self.name, self.remedy)


def missing(cls: type, **instead: str) -> None:
    """Say what a class has instead of some names: what to write, or a clause that ends in it.

    A name that the class has is left alone.
    """
    for name, remedy in instead.items():
        if all(isinstance(vars(base)[name], Instead) for base in cls.__mro__ if name in vars(base)):
            alone = CALL.fullmatch(remedy) is not None
            setattr(cls, name, Instead(name, f"write {remedy}" if alone else remedy))


class Face:
    """Something that users hold in their hands: `dir` lists what is meant for them.

    That are the names in `for_users` of its classes, and all public ones of classes from outside slewline.
    """

    for_users: ClassVar[tuple[str, ...]] = ()

    def __dir__(self) -> Iterable[str]:
        found = {name for name in super().__dir__() if name.startswith("_")}
        for base in type(self).__mro__:
            own: dict[str, Any] = dict(vars(base))
            found.update(own.get("for_users", ()))
            if not base.__module__.startswith((OURS, "builtins")):
                found.update(name for name in own if not isinstance(own[name], Instead))
        return sorted(found)


OF_CHIPS = {
    **dict.fromkeys(("send", "write"), "bench.host({it}).send(...)"),
    **dict.fromkeys(("move", "go", "load"), "a host sends the command: bench.host({it}).send(...)"),
    **dict.fromkeys(("ask", "query"), "bench.host({it}).ask(...)"),
    "command": "bench.host({it}) makes the host that sends commands",
    "velocity": '{it}.velocity_at("3 ms"), or {it}.velocity_at(bench.now)',
    "speed": '{it}.velocity_at("3 ms"), or {it}.velocity_at(bench.now)',
    "edges": 'bench.record() before time passes, then bench.edges("{it}.PIN")',
    "record": "bench.record() records the pins of all chips",
    **dict.fromkeys(("plot", "figure", "show"), "bench.plot(...) draws what is on it"),
    "crystal": "{it}.crystal_hz",
    "part": "{it}.sheet.part",
    "straps": "{it}.pin(...).level tells the level of an input",
    "errors": "{it}.findings",
    "status": "{it}.waiting",
    **dict.fromkeys(
        ("wait", "run_until_idle", "run_until", "sleep", "now"), "time is the bench's: bench.run_until_idle()"
    ),
}
