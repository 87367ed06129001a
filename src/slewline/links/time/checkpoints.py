"""Checkpoints of a server: idle copies of its process, from which every past instant is reached quickly."""

from __future__ import annotations

import json
import os
import socket
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from ..sockets import system
from .worlds import fork_checkpoint

if TYPE_CHECKING:
    from ..face import ServerFace

DUE_S = 0.02  # work after which the next checkpoint is due
CALM_S = 0.002  # idle time before the next event that is long enough for a fork
LATE_S = 0.4  # work after which it is made even without idle time
MOST = 48  # checkpoints
Data = dict[str, Any]
Arrived = Callable[[Data], object]


@dataclass
class Checkpoint:
    """An idle copy of the server's process, in its state at an instant of the past."""

    time_ps: int
    length: int  # length of the journal, bytes
    work_s: float  # work of the server so far
    process: int
    orders: socket.socket
    waiting: dict[int, Arrived] = field(default_factory=dict)  # for its worlds, by the number of the branch
    rest: bytes = b""


class Checkpoints:
    """The checkpoints of a server; without a journal there are none."""

    def __init__(self, server: ServerFace) -> None:
        self.server = server
        self.marks: list[Checkpoint] = []
        self.work_s = 0.0  # work of the server since the beginning
        self.begun = False

    def begin(self) -> bool:
        """Start to record the past, before any time has passed; return whether this is possible."""
        self.begun = not (self.server.bench.journal is None or system.FORK is None or threading.active_count() > 1)
        self.move(0)
        return self.begun

    def move(self, since_ps: int) -> None:
        """Start to record the past of another bench, which equals that of the former bench up to an instant (ps)."""
        while self.marks and self.marks[-1].time_ps >= since_ps:
            self._end(self.marks.pop())
        if self.begun:
            self._keep()

    def look(self, worked_s: float) -> None:
        """Make a checkpoint if one is due.

        It is called in every turn of the server, with the seconds of work since the last call.
        """
        self.work_s += worked_s
        if not self.begun:
            return
        server = self.server
        last = self.marks[-1] if self.marks else None  # all of them may have been killed
        since_s = self.work_s - (last.work_s if last is not None else 0)
        if since_s > DUE_S and not server.branches.current and (last is None or server.bench.now_ps > last.time_ps):
            pause = server.pace.pause()
            if pause is None or pause > CALM_S or since_s > LATE_S:
                self._keep()

    def _keep(self) -> None:
        """Make a checkpoint of this instant."""
        server, journal = self.server, self.server.bench.journal
        if journal is None or journal.failure:
            return
        process, orders = fork_checkpoint(server)
        made = Checkpoint(server.bench.now_ps, os.path.getsize(journal.path), self.work_s, process, orders)
        self.marks.append(made)
        orders.setblocking(False)
        server.loop.watch(orders.fileno(), lambda: self._answered(made))
        if len(self.marks) > MOST:
            self._thin_out()

    def _thin_out(self) -> None:
        """Remove the checkpoint that saves the least computing time, to make room for another.

        This is the checkpoint with the least computing time from the checkpoint before it to the one after it.
        A checkpoint with pending orders is kept.
        """
        marks = self.marks
        idle = [n for n in range(1, len(marks) - 1) if not marks[n].waiting]
        if idle:
            self._end(marks.pop(min(idle, key=lambda n: (marks[n + 1].work_s - marks[n - 1].work_s, n))))

    def _end(self, checkpoint: Checkpoint) -> None:
        if checkpoint.orders.fileno() >= 0:
            self.server.loop.watch(checkpoint.orders.fileno())
            checkpoint.orders.close()
        system.ended(checkpoint.process)

    def world(self, at_ps: int, order: Data, shared_ps: int, shared: int, arrived: Arrived) -> bool:
        """Start a paused server at an instant (ps), from the last suitable checkpoint; return whether one exists.

        The arguments are described in `ServedInstant.world`.
        """
        for mark in self.marks[::-1]:
            if mark.time_ps > min(at_ps, shared_ps) or mark.length > shared:
                continue
            try:
                mark.orders.setblocking(True)
                mark.orders.sendall(json.dumps(order | {"begin": mark.length}).encode() + b"\n")
                mark.orders.setblocking(False)
            except OSError:  # its process has ended: use the previous checkpoint
                self._miss(mark)
                continue
            mark.waiting[order["branch"]] = arrived
            return True
        return False

    def _answered(self, mark: Checkpoint) -> None:
        """Handle a message from a checkpoint: the address of a server that it has started, or its own end."""
        try:
            data = mark.orders.recv(1 << 16)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self._miss(mark)
        *lines, mark.rest = (mark.rest + data).split(b"\n")
        for line in lines:  # worlds for different instants may arrive in any order
            found = json.loads(line)
            arrived = mark.waiting.pop(found["branch"], None)
            if arrived is not None:
                arrived(found)

    def _miss(self, mark: Checkpoint) -> None:
        """Remove a checkpoint that has ended by itself."""
        if mark in self.marks:
            self.marks.remove(mark)
            self._end(mark)
            for arrived in mark.waiting.values():
                arrived({"error": "the process for this instant has ended; try again"})

    def close(self) -> None:
        """End all checkpoints."""
        self.begun = False
        for mark in self.marks:
            self._end(mark)
        self.marks.clear()
