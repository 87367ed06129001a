"""The past of a server: checkpoints that make every instant of it quick to reach, and the branches that begin there.

While another branch than the first one is shown, the server stands, and everything that comes from outside goes to the
world of that branch (`worlds.py`), and what comes from there goes out: requests of clients and their replies, bytes of
hosts and the answers.  Requests about branches are answered here.
"""

from __future__ import annotations

import json
import os
import socket
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, cast

from ...core.messages.whole import whole
from ...core.time.timebase import readable
from ...errors import UsageError
from ...temporary import TemporaryFolder
from ..sockets import system
from .branches import Answer, Branch, Checkpoint, Data
from .roads import Road, connection, greeting, rebuilt
from .worlds import fork_checkpoint

if TYPE_CHECKING:
    from ...bench import Bench
    from ..face import ServerFace

DUE_S = 0.02  # of work, after which the next checkpoint is due
CALM_S = 0.002  # before the next event, in which there is time to fork
LATE_S = 0.4  # of work, after which it is made even so
MOST = 48  # checkpoints
WATCH_S, LOOKS = 0.25, 6  # between two looks at the branch that is shown; in how many of them it has to answer
MOST_BRANCHES = 16  # besides the first one
ASK = b'{"do":"read","pins":[]}\n'  # of a branch, for its time
STAND = b'{"do":"pause"}\n'


class TimeTravel:
    """Checkpoints and branches of a server; without a journal there is no way back."""

    def __init__(self, server: ServerFace) -> None:
        self.server, self.bench = server, server.bench
        self.checkpoints: list[Checkpoint] = []
        self.known: dict[int, Branch] = {}
        self.current = self.count = 0
        self.work_s = 0.0  # of the server since the beginning
        self.folder: TemporaryFolder | None = None
        self.asked: list[tuple[Callable[[], object], bool]] = []  # what goes on when the time of a branch is known
        self.roads: list[Road] = []  # on which bytes of hosts go to the branch that is shown

    @property
    def elsewhere(self) -> str:
        """The control port of the branch that is shown; "": it is the first one."""
        return self.known[self.current].control if self.current else ""

    @property
    def now_ps(self) -> int:
        """The time of the branch that is shown, as far as it is known."""
        return self.known[self.current].now_ps if self.current else self.bench.now_ps

    def begin(self) -> None:
        """Keep the past from now on: no time has passed."""
        journal = self.bench.journal
        if journal is None or system.FORK is None or threading.active_count() > 1:
            return
        self.folder = TemporaryFolder()
        self.known[0] = Branch(0, None, 0, 0, journal.path, 0, 0)
        self.keep()

    def move(self, bench: Bench, since_ps: int) -> None:
        """Go back in the past of another bench from now on, which before an instant (ps) was the same."""
        self.bench = bench
        while self.checkpoints and self.checkpoints[-1].time_ps >= since_ps:
            self._end(self.checkpoints.pop())
        if self.folder is not None and bench.journal is not None:
            self.known[0].journal = bench.journal.path
            self.keep()

    def look(self) -> None:
        """Make a checkpoint if it is due: called once in every turn of the server."""
        if self.folder is None:
            return
        last = self.checkpoints[-1] if self.checkpoints else None  # somebody may have ended them all
        since_s = self.work_s - (last.work_s if last is not None else 0)
        if since_s > DUE_S and not self.current and (last is None or self.bench.now_ps > last.time_ps):
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
        idle = [n for n in range(1, len(marks) - 1) if not marks[n].waiting]
        if idle:
            self._end(marks.pop(min(idle, key=lambda n: (marks[n + 1].work_s - marks[n - 1].work_s, n))))

    def _end(self, checkpoint: Checkpoint) -> None:
        if checkpoint.orders.fileno() >= 0:
            self.server.loop.watch(checkpoint.orders.fileno())
            checkpoint.orders.close()
        system.ended(checkpoint.process)

    # ------------------------------------------------------------------------------------------------------- the way
    def back(self, at: int, branch: int | None, answer: Answer) -> None:
        """Go to an instant of a branch (ps), by default of the one that is shown; answer when it is there.

        Raises:
            UsageError: no past is kept, or no such branch.
        """
        number = self.current if branch is None else branch
        self._branch(number)

        def check() -> None:
            parent = self.known.get(number)
            if parent is None:
                answer({"error": f"back: branch {number} has ended"})
            elif at > parent.now_ps:
                answer({"error": f"back: {readable(at)} has not come; the time is {readable(parent.now_ps)}"})
            else:
                self._ask_time(lambda: self._go_back(at, parent, answer), True)

        self._ask_time(check)

    def _go_back(self, at: int, parent: Branch, answer: Answer) -> None:
        fitting = [
            mark
            for mark in self.checkpoints
            if mark.time_ps <= at
            and (not parent.number or (mark.time_ps <= parent.shared_ps and mark.length <= parent.shared))
        ]
        if not fitting:
            answer({"error": f"back: nothing is kept of {readable(at)}: the process that kept it has ended"})
            return
        mark = fitting[-1]
        self.count = number = self.count + 1
        copy = Path(cast("TemporaryFolder", self.folder).name) / f"branch{number}"
        order = {
            "journal": str(parent.journal),
            "begin": mark.length,
            "to": at,
            "copy": str(copy),
            "branch": number,
            "token": self._token(),
            "breakpoints": self.server.breakpoints.rows,
        }

        def arrived(found: Data) -> None:
            if "error" in found:
                answer({"error": f"back: {found['error']}"})
                return
            made = Branch(number, parent.number, at, at, copy, copy.stat().st_size, at)
            if parent.number:
                made.shared, made.shared_ps = min(made.shared, parent.shared), min(at, parent.shared_ps)
            made.control, made.lines, made.process = found["control"], found["lines"], found["process"]
            self.known[number] = made
            try:
                self._put_on_leash(made)
                self._switch(made)
            except OSError as error:
                self._lose(made, str(error))
                answer({"error": f"back: {error}"})
                return
            answer({"branch": number, "time_ps": at})

        try:
            mark.orders.setblocking(True)
            mark.orders.sendall(json.dumps(order).encode() + b"\n")
            mark.orders.setblocking(False)
        except OSError:  # it has gone: there may be another one
            self._miss(mark)
            self._go_back(at, parent, answer)
            return
        mark.waiting[number] = arrived

    def _put_on_leash(self, branch: Branch) -> None:
        """Connect to a branch, to ask for its time, and to be told when it ends."""
        leash = branch.leash = connection(branch.control)
        leash.sendall(greeting(self._token()))
        leash.recv(1 << 16)  # its reply
        leash.setblocking(False)
        self.server.loop.watch(leash.fileno(), lambda: self._heard(branch, leash))

    def _heard(self, branch: Branch, leash: socket.socket) -> None:
        """A branch has told its time, or has ended."""
        try:
            data = leash.recv(1 << 16)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            branch.process = 0  # the number may be that of another process by now
            self._lose(branch, "its process has ended")
        *lines, branch.rest = (branch.rest + data).split(b"\n")
        for line in lines:
            branch.now_ps, branch.silent = json.loads(line)["time_ps"], 0
            branch.waiting.pop(0)()

    def _answered(self, mark: Checkpoint) -> None:
        """A world has said where it is, or a checkpoint has gone."""
        try:
            data = mark.orders.recv(1 << 16)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self._miss(mark)
        *lines, mark.rest = (mark.rest + data).split(b"\n")
        for line in lines:  # two that go to different instants come as they like
            found = json.loads(line)
            arrived = mark.waiting.pop(found["branch"], None)
            if arrived is not None:
                arrived(found)

    def _miss(self, mark: Checkpoint) -> None:
        """A checkpoint has gone by itself."""
        if mark in self.checkpoints:
            self.checkpoints.remove(mark)
            self._end(mark)
            for arrived in mark.waiting.values():
                arrived({"error": "the process that kept this instant has ended; try again"})

    def show(self, number: int, answer: Answer) -> None:
        """Go to a branch as it was left; answer when it is there.

        Raises:
            UsageError: no past is kept, or no such branch.
        """
        self._branch(number)

        def go() -> None:
            branch = self.known.get(number)
            if branch is None:
                answer({"error": f"branch {number} has ended"})
                return
            try:
                self._switch(branch)
            except OSError as error:
                self._lose(branch, str(error))
                answer({"error": f"branch {number} has ended: {error}"})
                return
            answer({"branch": number, "time_ps": branch.now_ps})

        self._ask_time(go, True)

    def branches(self, answer: Answer) -> None:
        """Answer with all branches.

        Raises:
            UsageError: no past is kept.
        """
        self._branch(self.current)

        def reply() -> None:
            keys = ("number", "parent", "from_ps", "now_ps")
            rows = [{key: getattr(one, key) for key in keys} for one in self.known.values()]
            answer({"branches": rows, "current": self.current, "time_ps": self.now_ps})

        self._ask_time(reply)

    def _branch(self, number: int) -> None:
        if self.folder is None:
            raise UsageError("nothing of the past is kept here; start the server with --journal FILE, or --panel")
        if whole(number) not in self.known:
            raise UsageError(f"no branch {number!r}; there are: {', '.join(map(str, self.known))}")

    def _ask_time(self, then: Callable[[], object], stand: bool = False) -> None:
        """Ask the branch that is shown what its time is, and to let it stand; then go on, one after the other."""
        self.asked.append((then, stand))
        if len(self.asked) == 1:
            self._ask_next()

    def _ask_next(self) -> None:
        """Ask for the first of those that wait."""
        branch = self.known[self.current]
        then, stand = self.asked[0]

        def go_on() -> None:
            then()
            self.asked.pop(0)
            if self.asked:
                self._ask_next()

        if branch.leash is None:
            if stand:
                self.server.breakpoints.stand()
            branch.now_ps = self.bench.now_ps
            go_on()
            return
        self._send(branch, STAND if stand else ASK, go_on)

    def _send(self, branch: Branch, request: bytes, go_on: Callable[[], object]) -> None:
        """Send a request of ours to a branch; go on when it has answered, or has ended."""
        branch.waiting.append(go_on)
        with suppress(OSError):  # `_heard` sees it
            cast("socket.socket", branch.leash).sendall(request)

    def _watch(self, branch: Branch) -> None:
        """Leave the branch that is shown as soon as it does not answer any more."""
        branch.watched = self.current == branch.number and self.known.get(branch.number) is branch
        if not branch.watched:
            return
        if not branch.waiting:
            branch.silent = 0
            self._send(branch, ASK, lambda: None)
        elif branch.silent >= LOOKS:  # looks, and not seconds: where the machine is busy, both are late
            self._lose(branch, f"it has not answered for {LOOKS * WATCH_S:g} s")
            return
        branch.silent += 1
        self.server.loop.after(WATCH_S, lambda: self._watch(branch))

    # -------------------------------------------------------------------------------------------------------- a switch
    def _switch(self, branch: Branch) -> None:
        """Show another branch: what comes from outside goes there from now on.

        Raises:
            OSError: it cannot be reached; the one that was shown still is.
        """
        before = self.known[self.current]
        if branch is not before:
            self.roads = rebuilt(self.server.loop, [*self.server.lines.values()], branch, self.roads)
        self.current = branch.number
        if branch.number and not branch.watched:
            self._watch(branch)
        event = {"event": "branch", "branch": branch.number, "time_ps": branch.now_ps}
        for client in [client for control in self.server.controls() for client in control.clients]:
            client.divert(branch.control, event)
        if before.number and not before.touched and before is not branch:
            self._drop(before)
        for old in [one for one in self.known.values() if one.number][:-MOST_BRANCHES]:
            if old is not branch:
                self._drop(old)

    def _lose(self, branch: Branch, why: str) -> None:
        """A branch has ended by itself: the first one is shown again."""
        if self.known.get(branch.number) is not branch:
            return
        self.server.log.event("server", f"branch {branch.number}: {why}")
        if self.current == branch.number:
            self._switch(self.known[0])
        if branch.number in self.known:
            self._drop(branch)

    def _drop(self, branch: Branch) -> None:
        """Forget a branch; who waits for its time goes on with what was known of it."""
        del self.known[branch.number]
        for go_on in branch.waiting:
            self.server.loop.ask(go_on)
        if branch.leash is not None and branch.leash.fileno() >= 0:
            self.server.loop.watch(branch.leash.fileno())
            branch.leash.close()
        for path in (branch.journal, Path(branch.control), *map(Path, branch.lines.values())):
            with suppress(OSError):
                path.unlink()
        if branch.process:
            with suppress(OSError):
                os.kill(branch.process, *system.numbers("SIGKILL"))  # the only signal that a stopped process takes

    def touch(self) -> None:
        """Take notice that the branch that is shown is no longer what it was at first, and worth to be kept."""
        self.known[self.current].touched = True

    def _token(self) -> str | None:
        return next((control.token for control in self.server.controls()), None)

    def close(self) -> None:
        """End all worlds and checkpoints."""
        for road in self.roads:
            road.close()
        self.roads.clear()
        self.current = 0  # clients to whom a branch owes a reply are let go by what is left
        for branch in [one for one in self.known.values() if one.number]:
            self._drop(branch)
        for checkpoint in self.checkpoints:
            self._end(checkpoint)
        self.checkpoints.clear()
        if self.folder is not None:
            self.folder.cleanup()
            self.folder = None
