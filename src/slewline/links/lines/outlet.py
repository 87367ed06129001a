"""The way out of a line: what modules say to a host, which a gate may hold back.

    module --- said at 12.0 ms ---> | gate |  ... a cable's length later ---> left: the host has it

Without a gate everything leaves at once.  A bench that has gone back in time says again what was said since then.  What
had left is not sent again; what was held back never leaves, and what the new run says instead of it goes to the gate.
So a host gets no byte twice, and none that was taken back before it had left.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from functools import partial
from typing import NamedTuple

Gate = Callable[[Callable[[], object], int], object]  # takes a call and the instant of the bench that it is about (ps)


class Told(NamedTuple):
    """Bytes of a module: the instant at which they were over (ps), and the host that they are for; None: any."""

    ps: int
    data: bytes
    to: object = None


class Leaving:
    """Such bytes on their way."""

    __slots__ = ("left", "told", "void")

    def __init__(self, told: Told, left: bool = False) -> None:
        self.told, self.left, self.void = told, left, False


class Outlet:
    """Brings what modules say to a host.

    Args:
        deliver: gives bytes to the host.
    """

    def __init__(self, deliver: Callable[[bytes, object], object]) -> None:
        self.deliver = deliver
        self.gate: Gate | None = None
        self.held = 0  # how many calls the gate has not made yet
        self.since_ps: int | None = None  # what is said after it is remembered; None: nothing is
        self.said: deque[Leaving] = deque()

    def say(self, data: bytes, at_ps: int, to: object = None) -> None:
        """Let bytes go out that were over at an instant (ps)."""
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
        """Remember from now on what is said."""
        if self.since_ps is None:
            self.since_ps = now_ps

    def forget(self, before_ps: int) -> None:
        """Forget what was said up to an instant (ps): no run goes back before it any more."""
        if self.since_ps is not None and before_ps > self.since_ps:
            self.since_ps = before_ps
            while self.said and self.said[0].left and self.said[0].told.ps <= before_ps:
                self.said.popleft()

    def say_again(self, anew: Iterable[Told]) -> bytes:
        """Let out what another run says since the instant from which on is remembered; it begins as that before did.

        Returns:
            bytes that have left and are not said in the new run: they cannot be taken back.
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
