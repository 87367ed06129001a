"""The output of a line: data from modules to a host, which a gate may delay.

    module --- sent at 12.0 ms ---> | gate |  ... a cable's delay later ---> delivered: the host has it

Without a gate, data is delivered immediately.  A bench that has gone back to an earlier instant
produces all data after that instant again.  The part of this new data that the former run has already
delivered is not sent again.  The rest of the new data goes to the gate, and the former run's data that
is still delayed there is withdrawn.  So a host receives no byte twice, and no withdrawn byte.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from functools import partial
from typing import NamedTuple

Gate = Callable[[Callable[[], object], int], object]  # takes a call and its instant on the bench (ps)


class SentBytes(NamedTuple):
    """Bytes from a module, the instant at which the last one ended (ps), and the host that is to receive them.

    `to` is None if any host may receive them.
    """

    ps: int
    data: bytes
    to: object = None


class Leaving:
    """Bytes on their way to the host; `left` is True once they have been delivered, `void` once withdrawn."""

    __slots__ = ("data", "left", "ps", "to", "void")

    def __init__(self, ps: int, data: bytes, to: object, left: bool = False) -> None:
        self.ps, self.data, self.to, self.left, self.void = ps, data, to, left, False


class Outlet:
    """The delivery of data from modules to a host.

    Args:
        deliver: sends bytes to the host.  Its second argument is the only host that may receive them; if it
            is None, any host may.
    """

    def __init__(self, deliver: Callable[[bytes, object], object]) -> None:
        self.deliver = deliver
        self.gate: Gate | None = None
        self.waiting = 0  # number of calls that the gate has not made yet
        self.since_ps: int | None = None  # start of the record (ps); None: no record
        self.log: deque[Leaving] = deque()

    def send(self, data: bytes, at_ps: int, to: object = None) -> None:
        """Deliver bytes that ended at `at_ps`: immediately or, if there is a gate, when the gate lets them out."""
        leaving = Leaving(at_ps, data, to)
        if self.since_ps is not None:
            self.log.append(leaving)
        if self.gate is None:
            self._leave(leaving)
        else:
            self.waiting += 1
            self.gate(partial(self._let_out, leaving), at_ps)

    def _let_out(self, leaving: Leaving) -> None:
        if not leaving.left:
            self.waiting -= not leaving.void
            self._leave(leaving)

    def _leave(self, leaving: Leaving) -> None:
        if not leaving.void:
            leaving.left = True
            self.deliver(leaving.data, leaving.to)

    def remember(self, now_ps: int) -> None:
        """Start a record of all data sent after `now_ps`, unless there is a record already."""
        if self.since_ps is None:
            self.since_ps = now_ps

    def forget(self, before_ps: int) -> None:
        """Discard the record of data delivered up to an instant (ps): no run will go back to an earlier instant."""
        if self.since_ps is not None and before_ps > self.since_ps:
            self.since_ps = before_ps
            while self.log and self.log[0].left and self.log[0].ps <= before_ps:
                self.log.popleft()

    def resend(self, outputs: Iterable[SentBytes]) -> bytes:
        """Send the `outputs` of another run, instead of the data that the former run has sent since `remember`.

        Bytes that the former run has already delivered are not sent again.  Its data that is still delayed is
        withdrawn.

        Returns:
            The bytes already delivered that the new run does not send: they cannot be withdrawn.
        """
        since = -1 if self.since_ps is None else self.since_ps
        before = [each for each in self.log if each.ps > since]
        seen = b"".join(each.data for each in before if each.left)
        for each in before:
            if not each.left and not each.void:
                each.void = True
                self.waiting -= 1
        self.log = deque(each for each in self.log if each.ps <= since)
        same, agrees = 0, True
        for sent in outputs:
            if sent.ps <= since:
                continue
            common = 0
            while agrees and common < len(sent.data):
                agrees = same < len(seen) and seen[same] == sent.data[common]
                same, common = same + agrees, common + agrees
            if common:
                self.log.append(Leaving(sent.ps, sent.data[:common], sent.to, True))
            if sent.data[common:]:
                self.send(sent.data[common:], sent.ps, sent.to)
        return seen[same:]
