r"""A series of accesses to a board, which a program makes without pauses; each is a step of two bytes.

A request to a served board can contain many steps:

    0r --    IN      read register r of the board
    1r bb    OUT     write bb to register r
    24 nn    READY   wait until bit 7 of the status is 1, at most nn ms; then read the status
    34 nn    ANSWER  like READY, but wait until bit 7 is 0; parallel card only
    44 nn    MESSAGE like READY, but wait until bit 6 is 0; parallel card only
    54 nn    POLL    read the status until bit 7 is 1, at most nn ms, like a loop of IN instructions

A failed wait ends the series, because a real program would not get beyond its polling loop either.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ...core.time.timebase import PS_PER_S

DATA, STATUS = 0, 4  # offsets from the base
READY_BIT, FREE_BIT = 0x80, 0x40  # bits of the status
IN, OUT, READY, ANSWER, MESSAGE, POLL = 0x00, 0x10, 0x20 + STATUS, 0x30 + STATUS, 0x40 + STATUS, 0x50 + STATUS
WAITS = {READY: "ready", ANSWER: "answer", MESSAGE: "message"}  # conditions of a board with these names
MET = {READY: (READY_BIT, READY_BIT), ANSWER: (READY_BIT, 0), MESSAGE: (FREE_BIT, 0), POLL: (READY_BIT, READY_BIT)}
MS = PS_PER_S // 1000
POLL_PS = MS // 10  # maximum time that passes after a poll; HostRdy is low for 82 µs


class Done(NamedTuple):
    """The result of a series: one byte per step, and the instants at which the completed steps ended (ps)."""

    answers: bytes
    ends: Sequence[int]


def is_step(request: int, waits: tuple[str, ...]) -> bool:
    """Return whether a byte can begin a step on a board that supports the wait conditions `waits`."""
    return request < 0x20 or request == POLL or WAITS.get(request) in waits


def spelled(steps: bytes) -> str:
    """Return steps as hexadecimal text, with a space between steps."""
    return steps.hex(" ", -2)


def met(request: int, status: int) -> bool:
    """Return whether a step succeeded: a wait if its status bit has the wanted level, other steps always."""
    bit, wanted = MET.get(request, (0, 0))
    return status & bit == wanted
