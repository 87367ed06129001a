"""Remedies for names that a class does not have, and the names that `dir` lists for users.

    missing(Chip, send="bench.host({it}).send(...)")

    x.send          NoSuchAttribute: x has no 'send'; write bench.host(x).send(...)

Each missing name is a descriptor of the class; a `__getattr__` would slow down access to existing names.
For a missing name, `hasattr` returns False, and `dir` omits it; if an instance has an attribute of that
name, the attribute takes precedence.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import partial
from inspect import getattr_static
from typing import Any, NoReturn, TypeVar

from ...errors import NoSuchAttribute

C = TypeVar("C")
OURS = "slewline."
CALL = re.compile(r"[\w.{}\[\]]+(\([^()]*\))?")  # a remedy that is only code


def has_none(one: object, name: str, remedy: str) -> NoSuchAttribute:
    """Return the error for an attribute that an object does not have.

    Args:
        remedy: the code to write instead; "{it}" is replaced by the name of the object, or by that of its
            class if the object has no name.
    """
    it = called(one)
    return NoSuchAttribute(f"{it} has no {name!r}; {remedy.format(it=it)}")


def called(one: object) -> str:
    """Return the name of an object for a message: its own name, or that of its class if it has none."""
    if isinstance(one, type):
        return one.__name__
    own = getattr(one, "__dict__", {})
    return str(own.get("name") or getattr(one, "called", "") or type(one).__name__.lower())


class Instead:
    """A descriptor for a name that a class does not have: reading that name raises an error with a remedy."""

    def __init__(self, name: str, remedy: str) -> None:
        self.name, self.remedy = name, remedy

    def __get__(self, one: object, cls: type | None = None) -> NoReturn:
        raise has_none(cls if one is None else one, self.name, self.remedy)


NOTHING = Instead("", "")


class Never(Instead):
    """A descriptor for a name that a class does not have: reading or setting that name raises an error."""

    def __init__(self, name: str, remedy: str, to_set: str) -> None:
        super().__init__(name, remedy)
        self.to_set = to_set

    def __set__(self, one: object, value: object) -> NoReturn:
        raise has_none(one, self.name, self.to_set)


def _has(cls: type, name: str) -> bool:
    return any(
        name in getattr(base, "__annotations__", ()) or not isinstance(vars(base).get(name, NOTHING), Instead)
        for base in cls.__mro__
    )


def missing(cls: type, to_set: str | None = None, /, **instead: str) -> None:
    """Set the remedies for names that users expect in a class, but that the class does not have.

    Names that the class has, or that its annotations list, are skipped.

    Args:
        to_set: the remedy for an attempt to set one of these names; "" for the same remedy as for reading
            the name; None if objects of the class may have an attribute of that name.
        instead: the remedy for each name: the code to write instead, or a clause that contains this code.
    """
    if not any("__dir__" in vars(base) for base in cls.__mro__[:-1]):
        setattr(cls, "__dir__", _names_there_are)  # noqa: B010 (mypy knows no assignment to a method)
    for name, remedy in instead.items():
        if not _has(cls, name):
            alone = CALL.fullmatch(remedy) is not None
            remedies = f"write {remedy}" if alone else remedy
            setattr(cls, name, Instead(name, remedies) if to_set is None else Never(name, remedies, to_set or remedies))


def _names_there_are(one: object) -> list[str]:
    """Return the names that `dir` lists for an object, without those for which the class has only a remedy."""
    return [name for name in object.__dir__(one) if not isinstance(getattr_static(one, name, None), Instead)]


def seal(cls: type) -> None:
    """Make every attempt to set a public read-only property of a class raise an error with a remedy.

    The remedies are in the class's `_to_set`, keyed by property.  The setter added to a
    property does not slow down the reading of that property.
    """
    for name, own in [*vars(cls).items()]:
        if type(own) is property and own.fset is None and not name.startswith("_"):
            setattr(cls, name, own.setter(partial(_not_set, name)))


def names_for_users(one: object) -> list[str]:
    """Return the names that `dir` lists for an object: private names, and the names meant for users.

    For a class in this package, `_for_users` lists the names meant for users; for a class in another
    package, all names are meant for users.
    """
    found = {name for name in object.__dir__(one) if name.startswith("_")}
    for base in type(one).__mro__:
        own: dict[str, Any] = dict(vars(base))
        found.update(own.get("_for_users", ()))
        if not base.__module__.startswith((OURS, "builtins")):
            found.update(name for name in own if not isinstance(own[name], Instead))
    return sorted(found)


def face(cls: type[C]) -> type[C]:
    """Make `dir` list only the user-facing names of a class; seal its read-only properties; return the class.

    For details, see `names_for_users` and `seal`.
    """
    seal(cls)
    setattr(cls, "__dir__", names_for_users)  # noqa: B010 (mypy knows no assignment to a method)
    return cls


def _not_set(name: str, one: object, _value: object) -> NoReturn:
    it = called(one)
    to_set: Mapping[str, str] = getattr(one, "_to_set", {})
    remedy = to_set.get(name, f"{it}.{name} is read-only")
    raise NoSuchAttribute(f"{it}: {name} cannot be set; {remedy.format(it=it)}")


CALLS_OF_HOSTS = (
    *("verify", "live", "run_program", "change_rate", "read_position", "change_line", "received", "got", "drop"),
    *("packet", "results", "write_command", "write_word", "write_byte", "read_word", "read_byte"),
)
OF_CHIPS = {
    **{name: f"a host has it: bench.host({{it}}).{name}" for name in CALLS_OF_HOSTS},
    **dict.fromkeys(("send", "write"), "bench.host({it}).send(...)"),
    **dict.fromkeys(("move", "go", "load"), "a host sends the command: bench.host({it}).send(...)"),
    **dict.fromkeys(("ask", "query"), "bench.host({it}).ask(...)"),
    "command": "bench.host({it}) makes the host that sends commands",
    "velocity": '{it}.velocity_at("3 ms"), or {it}.velocity_at(bench.now)',
    "speed": '{it}.velocity_at("3 ms"), or {it}.velocity_at(bench.now)',
    "edges": 'bench.record() before time passes, then bench.edges("{it}.PIN")',
    "record": "bench.record() records the pins of all chips",
    **dict.fromkeys(("plot", "figure", "show"), "bench.plot(...) draws its signals"),
    **dict.fromkeys(
        ("on_step", "on_move", "on_motion"),
        "{it}.on_motion_begin.add(...) reports motions, {it}.steps() has every step",
    ),
    "crystal": "{it}.crystal_hz",
    "part": "{it}.sheet.part",
    "straps": "{it}.pin(...).level is the level of an input",
    "errors": "{it}.findings",
    "status": "{it}.waiting",
    **dict.fromkeys(
        ("wait", "run_until_idle", "run_until", "sleep", "now"), "time passes on the bench: bench.run_until_idle()"
    ),
}
