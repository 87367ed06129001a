r"""What a program does without a pause, as steps of two bytes: the requests of a served board, many in one.

    0r --    IN      read register r of the board
    1r bb    OUT     write bb to register r
    24 nn    READY   wait until bit 7 of the status is 1, for nn ms; then read the status
    34 nn    ANSWER  ... is 0; of a parallel card
    44 nn    MESSAGE wait until bit 6 is 0; of a parallel card
    54 nn    POLL    read the status until bit 7 is 1, for nn ms, as a loop of IN does

A wait in vain ends a series, for a program does nothing either while its loop goes on.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ...core.time.timebase import PS_PER_S

DATA, STATUS = 0, 4  # offsets from the base
READY_BIT, FREE_BIT = 0x80, 0x40  # of the status
IN, OUT, READY, ANSWER, MESSAGE, POLL = 0x00, 0x10, 0x20 + STATUS, 0x30 + STATUS, 0x40 + STATUS, 0x50 + STATUS
WAITS = {READY: "ready", ANSWER: "answer", MESSAGE: "message"}  # what a board knows by these names
MET = {READY: (READY_BIT, READY_BIT), ANSWER: (READY_BIT, 0), MESSAGE: (FREE_BIT, 0), POLL: (READY_BIT, READY_BIT)}
MS = PS_PER_S // 1000
POLL_PS = MS // 10  # what passes after a poll at most, where a poll lets time pass; HostRdy is low for 82 µs


class Done(NamedTuple):
    """What a series has brought: a byte for each step, and when each of those that were done was over (ps)."""

    answers: bytes
    ends: Sequence[int]


def is_step(request: int, waits: tuple[str, ...]) -> bool:
    """Return whether this is the first byte of a step, on a board that has these waits."""
    return request < 0x20 or request == POLL or WAITS.get(request) in waits


def spelled(steps: bytes) -> str:
    """Return steps in hexadecimal, a group each."""
    return steps.hex(" ", -2)


def met(request: int, status: int) -> bool:
    """Return whether a step has done what it should; a wait has, if the status is what was waited for."""
    bit, wanted = MET.get(request, (0, 0))
    return status & bit == wanted
