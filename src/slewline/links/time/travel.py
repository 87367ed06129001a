"""The past of a server: checkpoints that make every instant of it quick to reach, and the branches that begin there.

While another branch than the first one is shown, the server stands, and everything that comes from outside goes to the
world of that branch (`worlds.py`), and what comes from there goes out: requests of clients and their replies, bytes of
hosts and the answers.  Requests about branches are answered here.
"""

from __future__ import annotations

import json
import os
import signal
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import cast

from ...core.time.timebase import readable
from ...errors import UsageError
from ..sockets import system
from .branches import Answer, Branch, Checkpoint, Data, Travels
from .roads import Road, connection, greeting
from .worlds import fork_checkpoint

DUE_S = 0.02  # of work, after which the next checkpoint is due
CALM_S = 0.002  # before the next event, in which there is time to fork
LATE_S = 0.4  # of work, after which it is made even so
MOST = 48  # checkpoints
MOST_BRANCHES = 16  # besides the first one
HARMLESS = frozenset(
    (
        *("read", "status", "findings", "steps", "schema", "describe", "parts", "listing", "view", "subscribe", "said"),
        *("signals", "record", "window", "find", "export", "assemble", "examples", "pause", "breakpoints"),
    )
)  # requests that leave a branch as it is


class TimeTravel:
    """Checkpoints and branches of a server; without a journal there is no way back."""

    def __init__(self, server: Travels) -> None:
        self.server, self.bench = server, server.bench
        self.checkpoints: list[Checkpoint] = []
        self.known: dict[int, Branch] = {}
        self.current = self.count = 0
        self.work_s = 0.0  # of the server since the beginning
        self.folder: TemporaryDirectory[str] | None = None
        self.asked: list[Callable[[], object]] = []  # what goes on when the time of a branch is known
        self.roads: list[Road] = []  # on which bytes of hosts go to the branch that is shown

    @property
    def there(self) -> bool:
        """Is there a way back?"""
        return self.folder is not None

    def begin(self) -> None:
        """Keep the past from now on: no time has passed."""
        journal = self.bench.journal
        if journal is None or system.FORK is None or threading.active_count() > 1:
            return
        self.folder = TemporaryDirectory(prefix="slewline-")
        self.known[0] = Branch(0, None, 0, 0, journal.path, 0)
        self.keep()

    def look(self) -> None:
        """Make a checkpoint if it is due: called once in every turn of the server."""
        if self.folder is None:
            return
        last = self.checkpoints[-1]
        since_s = self.work_s - last.work_s
        if since_s > DUE_S and not self.current and self.bench.now_ps > last.time_ps:
            pause = self.server.pace.pause()
            if pause is None or pause > CALM_S or since_s > LATE_S:
                self.keep()

    def keep(self) -> None:
        """Make a checkpoint of this instant."""
        journal = self.bench.journal
        if journal is None or journal.failure:
            return
        process, orders = fork_checkpoint(self.server)
        length = os.path.getsize(journal.path)
        made = Checkpoint(self.bench.now_ps, length, self.work_s, process, orders)
        self.checkpoints.append(made)
        orders.setblocking(False)
        self.server.loop.watch(orders.fileno(), lambda: self._answered(made))
        if len(self.checkpoints) > MOST:
            self._thin_out()

    def _thin_out(self) -> None:
        """Give up the checkpoint that costs least: whose neighbours have the least work between them."""
        marks = self.checkpoints
        gap = min(range(1, len(marks) - 1), key=lambda n: (marks[n + 1].work_s - marks[n - 1].work_s, n))
        self._end(marks.pop(gap))

    def _end(self, checkpoint: Checkpoint) -> None:
        if checkpoint.orders.fileno() >= 0:
            self.server.loop.watch(checkpoint.orders.fileno())
            checkpoint.orders.close()
        system.ended(checkpoint.process)

    # ------------------------------------------------------------------------------------------------------- the way
    def back(self, at: int, branch: int | None, answer: Answer) -> None:
        """Go to an instant of a branch (ps), by default of the one that is shown; answer when it is there.

        Raises:
            UsageError: no past is kept, no such branch, or an instant that has not come.
        """
        number = self.current if branch is None else branch
        parent = self._branch(number)
        self.server.pace.pause_time()
        self._ask_time(lambda: self._go_back(at, parent, answer))

    def _go_back(self, at: int, parent: Branch, answer: Answer) -> None:
        if at > parent.now_ps:
            answer({"error": f"back: {readable(at)} has not come; the time is {readable(parent.now_ps)}"})
            return
        fitting = [
            mark
            for mark in self.checkpoints
            if mark.time_ps <= at and (not parent.number or mark.length <= parent.shared)
        ]
        mark = (fitting or self.checkpoints[:1])[-1]
        self.count += 1
        number = self.count
        copy = Path(cast("TemporaryDirectory[str]", self.folder).name) / f"branch{number}"
        order = {
            "journal": str(parent.journal),
            "begin": mark.length,
            "to": max(at, mark.time_ps),
            "copy": str(copy),
            "branch": number,
            "token": self._token(),
            "breakpoints": self.server.breakpoints.rows,
        }

        def arrived(found: Data) -> None:
            if "error" in found:
                answer({"error": f"back: {found['error']}"})
                return
            length = copy.stat().st_size
            shared = length if not parent.number else min(length, parent.shared)
            made = Branch(number, parent.number, at, at, copy, shared)
            made.control, made.lines, made.process = found["control"], found["lines"], found["process"]
            try:
                made.leash = connection(made.control)
                made.leash.sendall(greeting(self._token()))
                made.leash.recv(1 << 16)  # its reply
                self.known[number] = made
                self._switch(made)
            except OSError as error:
                self._lose(made, str(error))
                answer({"error": f"back: {error}"})
                return
            answer({"branch": number, "time_ps": at})

        mark.waiting.append(arrived)
        mark.orders.setblocking(True)
        mark.orders.sendall(json.dumps(order).encode() + b"\n")
        mark.orders.setblocking(False)

    def _answered(self, mark: Checkpoint) -> None:
        """A world has said where it is, or a checkpoint has gone."""
        try:
            data = mark.orders.recv(1 << 16)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self.server.loop.watch(mark.orders.fileno())
            self.checkpoints = [other for other in self.checkpoints if other is not mark]
            for answer in mark.waiting:
                answer({"error": "the checkpoint has gone"})
            return
        *lines, mark.rest = (mark.rest + data).split(b"\n")
        for line in lines:
            mark.waiting.pop(0)(json.loads(line))

    def show(self, number: int, answer: Answer) -> None:
        """Go to a branch as it was left; answer when it is there.

        Raises:
            UsageError: no past is kept, or no such branch.
        """
        branch = self._branch(number)

        def go() -> None:
            self._switch(branch)
            answer({"branch": number, "time_ps": branch.now_ps})

        self._ask_time(go)

    def branches(self, answer: Answer) -> None:
        """Answer with all branches.

        Raises:
            UsageError: no past is kept.
        """
        self._branch(self.current)

        def reply() -> None:
            rows = [
                {"number": one.number, "parent": one.parent, "from_ps": one.from_ps, "now_ps": one.now_ps}
                for one in self.known.values()
            ]
            answer({"branches": rows, "current": self.current})

        self._ask_time(reply)

    def _branch(self, number: int) -> Branch:
        if self.folder is None:
            raise UsageError("nothing of the past is kept here; start the server with --journal FILE, or --panel")
        if number not in self.known:
            raise UsageError(f"no branch {number!r}; there are: {', '.join(map(str, self.known))}")
        return self.known[number]

    def _ask_time(self, then: Callable[[], object]) -> None:
        """Ask the branch that is shown to pause, and what its time is; then go on, one after the other."""
        self.asked.append(then)
        if len(self.asked) == 1:
            self._ask_next()

    def _ask_next(self) -> None:
        """Ask for the first of those that wait."""
        branch = self.known[self.current]

        def then() -> None:
            self.asked[0]()
            self.asked.pop(0)
            if self.asked:
                self._ask_next()

        if branch.leash is None:
            branch.now_ps = self.bench.now_ps
            then()
            return
        leash = branch.leash
        rest = bytearray()

        def read() -> None:
            try:
                data = leash.recv(1 << 16)
            except OSError:
                data = b""
            rest.extend(data)
            if not data:
                self._lose(branch, "its process has ended")
            if rest.endswith(b"\n") or not data:
                if leash.fileno() >= 0:
                    self.server.loop.watch(leash.fileno())
                branch.now_ps = json.loads(rest or b"{}").get("time_ps", branch.now_ps)
                then()

        self.server.loop.watch(leash.fileno(), read)
        with suppress(OSError):  # `read` sees it
            leash.sendall(b'{"do":"pause"}\n')

    # -------------------------------------------------------------------------------------------------------- a switch
    def _switch(self, branch: Branch) -> None:
        """Show another branch: what comes from outside goes there from now on."""
        before = self.known[self.current]
        self.current = branch.number
        for road in self.roads:
            road.close()
        self.roads.clear()
        if branch.number:
            for line in self.server.lines.values():
                self.roads.append(Road(self.server.loop, line, branch.lines[line.name], branch))
        else:
            for line in self.server.lines.values():
                line.detour = None
        event = {"event": "branch", "branch": branch.number}
        for control in self.server.controls():
            for client in [*control.clients]:
                client.divert(branch.control, event | {"time_ps": branch.now_ps})
        if before.number and not before.touched and before is not branch:
            self._drop(before)
        for old in [one for one in self.known.values() if one.number][:-MOST_BRANCHES]:
            if old is not branch:
                self._drop(old)

    def _lose(self, branch: Branch, why: str) -> None:
        """A branch has ended by itself: the first one is shown again."""
        self.server.log.event("server", f"branch {branch.number}: {why}")
        if self.current == branch.number:
            self._switch(self.known[0])
        if branch.number in self.known:
            self._drop(branch)

    def _drop(self, branch: Branch) -> None:
        """Forget a branch."""
        del self.known[branch.number]
        if branch.leash is not None:
            branch.leash.close()
        with suppress(OSError):
            os.kill(branch.process, signal.SIGTERM)
            branch.journal.unlink()

    def forwarded(self, do: object) -> None:
        """Take notice of a request to the branch that is shown."""
        if do not in HARMLESS:
            self.known[self.current].touched = True

    def _token(self) -> str | None:
        return next((control.token for control in self.server.controls()), None)

    def close(self) -> None:
        """End all worlds and checkpoints."""
        for branch in [one for one in self.known.values() if one.number]:
            self._drop(branch)
        for checkpoint in self.checkpoints:
            self._end(checkpoint)
        self.checkpoints.clear()
        if self.folder is not None:
            self.folder.cleanup()
            self.folder = None
