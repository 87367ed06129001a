"""The base of chips and parts on a bench: name, findings, and the inputs with which users operate them."""

from __future__ import annotations

from bisect import bisect_left, insort
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from operator import attrgetter
from types import MappingProxyType
from typing import Any, ClassVar

from ..errors import LONGEST_FINDING, UsageError, shortened
from .messages.instead import missing, names_for_users, seal
from .time.hook import Hook
from .time.inputs import is_from_outside
from .time.kernel import Kernel
from .time.timebase import readable
from .wires.net import Driver


@dataclass(frozen=True, slots=True)
class Finding:
    """A diagnostic: something that the manual forbids or leaves open, and the reaction of the chip.

    Attributes:
        time_ps: the instant of the event, ps.
        source: the name of the chip or part.
        code: the kind of finding: "range", "unfinished" ...
        text: a description of the event; text longer than 400 characters is shortened in the middle.
    """

    time_ps: int
    source: str
    code: str
    text: str  # at most LONGEST_FINDING characters; longer text is shortened in the middle

    def __post_init__(self) -> None:
        object.__setattr__(self, "text", shortened(self.text, LONGEST_FINDING))

    def __str__(self) -> str:
        return f"{readable(self.time_ps)}  {self.source}  {self.code}: {self.text}"


missing(
    Finding,
    **dict.fromkeys(("message", "msg", "description", "says"), "{it}.text"),
    **dict.fromkeys(("time", "at", "when"), "{it}.time_ps"),
    **dict.fromkeys(("name", "kind", "type", "level", "severity"), "{it}.code"),
    **dict.fromkeys(("chip", "part", "owner"), "{it}.source"),
)


class Component:
    """A chip or a part.

    `_for_users` lists the only names that `dir` shows; if it is empty, `dir` shows all.  `_to_set` holds,
    keyed by the name of a read-only property, advice on how to change its value.  A method that overrides
    one declared with `@from_outside` need not be declared again.
    """

    _for_users: ClassVar[tuple[str, ...]] = ()
    _to_set: ClassVar[Mapping[str, str]] = MappingProxyType({})
    _input_names: ClassVar[frozenset[str]] = frozenset()

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        seal(cls)
        cls._input_names = frozenset(
            name for base in cls.__mro__ for name in vars(base) if is_from_outside(vars(base)[name])
        )

    def __init__(self, kernel: Kernel, name: str) -> None:
        self.kernel, self.name = kernel, name
        self.drivers: dict[str, Driver] = {}
        self._findings: list[Finding] = []
        self._forgotten: Counter[str] = Counter()  # numbers of dropped findings, by code
        self.on_finding: Hook[[Finding]] = Hook()

    def __dir__(self) -> Iterable[str]:
        return names_for_users(self) if self._for_users else super().__dir__()

    @property
    def findings(self) -> list[Finding]:
        """All findings about the chip or part so far, in chronological order."""
        return self._findings

    def finding(self, code: str, text: str, at: int | None = None) -> None:
        """Add a finding (something that the manual forbids or leaves open), dated now or at a past instant (ps)."""
        found = Finding(self.kernel.now if at is None else at, self.name, code, text)
        insort(self._findings, found, key=attrgetter("time_ps"))
        self.on_finding(found)

    def input(self, verb: str, *args: Any) -> None:
        """Record, as an external input, that a user has called a method declared with `@from_outside`.

        Args:
            verb: the name of the method.
            args: its arguments, as plain data: they are recorded in a journal, and a replay calls the method with them
                again.

        Raises:
            UsageError: no method of this name is declared as an input.
        """
        if verb not in self._input_names:
            input_of(self, verb)  # raises the error
        outside = self.kernel.outside
        if outside.has_listeners:
            plain = [list(arg) if isinstance(arg, bytes) else arg for arg in args]
            outside.record("input", part=self.name, verb=verb, args=plain)


def input_of(owner: Component, verb: str) -> Callable[..., Any]:
    """Return the method called `verb` of a chip or part, which must be declared as an external input.

    Raises:
        UsageError: no declared input has this name; the message lists the inputs.
    """
    if verb not in owner._input_names:
        raise UsageError(
            f"{owner.name}: {verb!r} is not an input; allowed {', '.join(sorted(owner._input_names)) or 'none'}; "
            "declare a method of your own with @from_outside"
        )
    return getattr(owner, verb)  # type: ignore[no-any-return]


def forget_findings(owner: Component, before: int, remedy: str) -> None:
    """Replace the findings of a chip or part before an instant (ps) by a single one, which counts them by code.

    Args:
        remedy: text that explains how to keep more findings.
    """
    findings, forgotten = owner._findings, owner._forgotten
    old = bisect_left(findings, before, key=attrgetter("time_ps"))
    if old <= bool(forgotten):  # only the one with the counts
        return
    last = findings[old - 1].time_ps
    forgotten.update(found.code for found in findings[bool(forgotten) : old])
    codes = ", ".join(f"{code} {count}" for code, count in forgotten.items())
    text = f"{forgotten.total()} up to {readable(last)} are no longer kept: {codes}; {remedy}"
    findings[:old] = [Finding(last, owner.name, "forgotten", text)]
