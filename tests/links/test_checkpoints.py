"""Which checkpoint takes an order: the last one before the instant that is wanted, of those whose processes live."""

from __future__ import annotations

import json
import os
import socket
from types import SimpleNamespace
from typing import Any

import pytest

from slewline.links.time.checkpoints import Checkpoint, Checkpoints

pytestmark = pytest.mark.posix


@pytest.fixture
def kept():
    """Checkpoints at 0, 10 and 20 ps, and the other ends of their sockets; their process is this one, no child."""
    server: Any = SimpleNamespace(loop=SimpleNamespace(watch=lambda _number: None))
    found, ends = Checkpoints(server), []
    for ps in (0, 10, 20):
        ours, theirs = socket.socketpair()
        found.marks.append(Checkpoint(ps, 100 * ps, 0.0, os.getpid(), ours))
        ends.append(theirs)
    yield found, ends
    found.close()
    for each in ends:
        each.close()


def begins(end: socket.socket) -> int:
    """Return the byte of the journal at which the world begins that was ordered."""
    end.settimeout(5)
    return int(json.loads(end.recv(1 << 12))["begin"])


@pytest.mark.parametrize(
    ("at", "shared_ps", "shared", "number"), [(15, 99, 9999, 1), (20, 99, 9999, 2), (25, 9, 9999, 0), (25, 99, 1500, 1)]
)
def test_the_last_checkpoint_before_the_instant_takes_the_order(kept, at, shared_ps, shared, number):
    checkpoints, ends = kept
    assert checkpoints.world(at, {"branch": 1}, shared_ps, shared, lambda _found: None)
    assert begins(ends[number]) == 1000 * number


def test_where_a_checkpoint_has_gone_the_one_before_it_takes_the_order(kept):
    checkpoints, ends = kept
    answers: list[dict[str, Any]] = []
    assert checkpoints.world(25, {"branch": 1}, 99, 9999, answers.append)
    ends[2].close()  # before the world has arrived
    assert checkpoints.world(25, {"branch": 2}, 99, 9999, answers.append)
    assert begins(ends[1]) == 1000
    assert ["process for this instant has ended" in each["error"] for each in answers] == [True]
    assert [mark.time_ps for mark in checkpoints.marks] == [0, 10]


def test_without_a_checkpoint_nothing_is_ordered(kept):
    checkpoints, ends = kept
    for end in ends:
        end.close()
    assert not checkpoints.world(25, {"branch": 1}, 99, 9999, lambda _found: None)
    assert not checkpoints.marks
