"""The output of a line: data from modules to a host, which a gate may delay.

    module --- sent at 12.0 ms ---> | gate |  ... a cable's delay later ---> delivered: the host has it

Without a gate, data is delivered immediately.  A bench that has gone back in time repeats all data since then.
Delivered data is not sent again; delayed data is never delivered, and the new run's data goes to the gate instead.
So a host receives no byte twice, and none that was withdrawn before delivery.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from functools import partial
from typing import NamedTuple

Gate = Callable[[Callable[[], object], int], object]  # takes a call and its instant on the bench (ps)


class Told(NamedTuple):
    """Bytes of a module: the instant at which they ended (ps), and the host that they are for; None: any."""

    ps: int
    data: bytes
    to: object = None


class Leaving:
    """Such bytes before delivery."""

    __slots__ = ("left", "told", "void")

    def __init__(self, told: Told, left: bool = False) -> None:
        self.told, self.left, self.void = told, left, False


class Outlet:
    """Delivery of data from modules to a host.

    Args:
        deliver: sends bytes to the host.
    """

    def __init__(self, deliver: Callable[[bytes, object], object]) -> None:
        self.deliver = deliver
        self.gate: Gate | None = None
        self.held = 0  # number of calls that the gate has not made yet
        self.since_ps: int | None = None  # start of the record (ps); None: no record
        self.said: deque[Leaving] = deque()

    def say(self, data: bytes, at_ps: int, to: object = None) -> None:
        """Deliver bytes that ended at an instant (ps), or pass them to the gate."""
        leaving = Leaving(Told(at_ps, data, to))
        if self.since_ps is not None:
            self.said.append(leaving)
        if self.gate is None:
            self._leave(leaving)
        else:
            self.held += 1
            self.gate(partial(self._let_out, leaving), at_ps)

    def _let_out(self, leaving: Leaving) -> None:
        if not leaving.left:
            self.held -= not leaving.void
            self._leave(leaving)

    def _leave(self, leaving: Leaving) -> None:
        if not leaving.void:
            leaving.left = True
            self.deliver(leaving.told.data, leaving.told.to)

    def remember(self, now_ps: int) -> None:
        """Record all data from now on."""
        if self.since_ps is None:
            self.since_ps = now_ps

    def forget(self, before_ps: int) -> None:
        """Discard the record up to an instant (ps): no run goes back before it any more."""
        if self.since_ps is not None and before_ps > self.since_ps:
            self.since_ps = before_ps
            while self.said and self.said[0].left and self.said[0].told.ps <= before_ps:
                self.said.popleft()

    def say_again(self, anew: Iterable[Told]) -> bytes:
        """Output the data of another run since the start of the record; the new run begins as the old one did.

        Returns:
            bytes that were delivered but do not occur in the new run: they cannot be withdrawn.
        """
        since = -1 if self.since_ps is None else self.since_ps
        before = [each for each in self.said if each.told.ps > since]
        seen = b"".join(each.told.data for each in before if each.left)
        for each in before:
            if not each.left and not each.void:
                each.void = True
                self.held -= 1
        self.said = deque(each for each in self.said if each.told.ps <= since)
        same, agrees = 0, True
        for told in anew:
            if told.ps <= since:
                continue
            common = 0
            while agrees and common < len(told.data):
                agrees = same < len(seen) and seen[same] == told.data[common]
                same, common = same + agrees, common + agrees
            if common:
                self.said.append(Leaving(told._replace(data=told.data[:common]), True))
            if told.data[common:]:
                self.say(told.data[common:], told.ps, told.to)
        return seen[same:]
