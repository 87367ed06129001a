"""The runs of a server: the first run, and branches, each of which begins at an instant of another run.

While a branch is shown, the time of the server is paused.  All external input (client requests, bytes
from hosts) goes to the process of that branch (`worlds.py`), and its output (replies, answers) goes to
the clients and hosts.  Requests about branches are answered here; `server_past.py` recreates the past.
"""

from __future__ import annotations

import json
import os
import socket
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from ...bench.runner import NEVER_PS
from ...core.messages.whole import whole
from ...core.time.timebase import readable
from ...errors import UsageError
from ...temporary import TemporaryFolder
from ..sockets import system
from .roads import Branch, Road, connection, greeting, rebuilt

if TYPE_CHECKING:
    from ..face import ServerFace

WATCH_S, LOOKS = 0.25, 6  # between two polls of the branch that is shown; polls within which it has to answer
MOST_BRANCHES = 16  # branches besides the first run
ASK = b'{"do":"read","pins":[]}\n'  # request to a branch for its time
STAND = b'{"do":"pause"}\n'
Data = dict[str, Any]
Answer = Callable[[Data], object]


class Branches:
    """The branches of a server, and the one that is shown; without a record of the past there are none."""

    def __init__(self, server: ServerFace) -> None:
        self.server = server
        self.known: dict[int, Branch] = {}
        self.current = self.count = 0
        self.folder: TemporaryFolder | None = None
        self.asked: list[tuple[Callable[[], object], bool]] = []  # functions to call when the time of a branch is known
        self.roads: list[Road] = []  # relays of hosts' bytes to the branch that is shown

    @property
    def elsewhere(self) -> str:
        """Address of the control port of the branch that is shown; "" for the first run."""
        return self.known[self.current].control if self.current else ""

    @property
    def now_ps(self) -> int:
        """Last reported time of the branch that is shown, in ps."""
        return self.known[self.current].now_ps if self.current else self.server.bench.now_ps

    def begin(self) -> None:
        """Start recording the past, if this is possible, before any time has passed."""
        if self.server.past.begin():
            self.folder = TemporaryFolder()
            self.known[0] = Branch(0, None, 0, 0, self.server.past.path, NEVER_PS, NEVER_PS)  # the first run itself

    def back(self, at: int, branch: int | None, answer: Answer) -> None:
        """Begin and show a new branch at an instant (ps) of `branch` (None: the branch shown); then call `answer`.

        Raises:
            UsageError: the past is not recorded, or there is no such branch.
        """
        number = self.current if branch is None else branch
        self._branch(number)

        def check() -> None:
            parent = self.known.get(number)
            if parent is None:
                answer({"error": f"back: branch {number} has ended"})
            elif at > parent.now_ps:
                answer({"error": f"back: {readable(at)} is in the future; the time is {readable(parent.now_ps)}"})
            else:
                self._ask_time(lambda: self._go_back(at, parent, answer), True)

        self._ask_time(check)

    def _go_back(self, at: int, parent: Branch, answer: Answer) -> None:
        number = self.count + 1
        copy = Path(cast("TemporaryFolder", self.folder).name) / f"branch{number}"
        order = {
            "journal": str(parent.journal if parent.number else self.server.past.path),
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
            same = min(copy.stat().st_size, parent.shared), min(at, parent.shared_ps)
            made = Branch(number, parent.number, at, at, copy, *same)
            made.control, made.lines, made.process = found["control"], found["lines"], found["process"]
            self.known[number] = made
            try:
                self._tie_to_server(made)
                self._switch(made)
            except OSError as error:
                self._lose(made, str(error))
                answer({"error": f"back: {error}"})
                return
            answer({"branch": number, "time_ps": at})

        if self.server.past.at(at).world(order, parent.shared_ps, parent.shared, arrived):
            self.count = number
        else:
            answer({"error": f"back: there is no record of {readable(at)}: its process has ended"})

    def _tie_to_server(self, branch: Branch) -> None:
        """Connect to a branch, to query its time and to detect its end."""
        lifeline = branch.lifeline = connection(branch.control)
        lifeline.sendall(greeting(self._token()))
        lifeline.recv(1 << 16)  # its reply
        lifeline.setblocking(False)
        self.server.loop.watch(lifeline.fileno(), lambda: self._read_answer(branch, lifeline))

    def _read_answer(self, branch: Branch, lifeline: socket.socket) -> None:
        """Handle a message from a branch (the current time of the branch), or the end of its process."""
        try:
            data = lifeline.recv(1 << 16)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            branch.process = 0  # the number may be in use by another process by now
            self._lose(branch, "its process has ended")
        *lines, branch.rest = (branch.rest + data).split(b"\n")
        for line in lines:
            branch.now_ps, branch.silent = json.loads(line)["time_ps"], 0
            branch.waiting.pop(0)()

    def show(self, number: int, answer: Answer) -> None:
        """Show a branch again, in the state in which it was left; call `answer` once it is shown, or with an error.

        Raises:
            UsageError: the past is not recorded, or there is no such branch.
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

    def listed(self, answer: Answer) -> None:
        """Call `answer` with a list of all branches, and the current time.

        Raises:
            UsageError: the past is not recorded.
        """
        self._branch(self.current)

        def reply() -> None:
            keys = ("number", "parent", "from_ps", "now_ps")
            rows = [{key: getattr(one, key) for key in keys} for one in self.known.values()]
            answer({"branches": rows, "current": self.current, "time_ps": self.now_ps})

        self._ask_time(reply)

    def _branch(self, number: int) -> None:
        if self.folder is None:
            raise UsageError("the past is not recorded here; start the server with --journal FILE, or --panel")
        if whole(number) not in self.known:
            raise UsageError(f"no branch {number!r}; allowed: {', '.join(map(str, self.known))}")

    def _ask_time(self, then: Callable[[], object], stand: bool = False) -> None:
        """Query the time of the branch that is shown (if `stand`, pause it), then call `then`.

        Several queries are sent one after another, in the order of the calls.
        """
        self.asked.append((then, stand))
        if len(self.asked) == 1:
            self._ask_next()

    def _ask_next(self) -> None:
        """Send the first waiting query."""
        branch = self.known[self.current]
        then, stand = self.asked[0]

        def go_on() -> None:
            then()
            self.asked.pop(0)
            if self.asked:
                self._ask_next()

        if branch.lifeline is None:
            if stand:
                self.server.breakpoints.stand()
            branch.now_ps = self.server.bench.now_ps
            go_on()
            return
        self._send(branch, STAND if stand else ASK, go_on)

    def _send(self, branch: Branch, request: bytes, go_on: Callable[[], object]) -> None:
        """Send a request from the server to a branch; call `go_on` when the branch has answered, or has ended."""
        branch.waiting.append(go_on)
        with suppress(OSError):  # `_read_answer` handles it
            cast("socket.socket", branch.lifeline).sendall(request)

    def _watch(self, branch: Branch) -> None:
        """Poll a branch while it is shown; show the first run again if the branch stops answering."""
        branch.watched = self.current == branch.number and self.known.get(branch.number) is branch
        if not branch.watched:
            return
        if not branch.waiting:
            branch.silent = 0
            self._send(branch, ASK, lambda: None)
        elif branch.silent >= LOOKS:  # counted in polls, not seconds: on a busy machine both processes are late
            self._lose(branch, f"it has not answered for {LOOKS * WATCH_S:g} s")
            return
        branch.silent += 1
        self.server.loop.after(WATCH_S, lambda: self._watch(branch))

    # -------------------------------------------------------------------------------------------------------- a switch
    def _switch(self, branch: Branch) -> None:
        """Show another branch, and direct all later external input to it.

        Raises:
            OSError: the branch cannot be reached; the former branch is still shown.
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
        """Remove a branch that has ended by itself; if it is shown, show the first run again."""
        if self.known.get(branch.number) is not branch:
            return
        self.server.log.event("server", f"branch {branch.number}: {why}")
        if self.current == branch.number:
            self._switch(self.known[0])
        if branch.number in self.known:
            self._drop(branch)

    def _drop(self, branch: Branch) -> None:
        """Remove a branch, and end its process; requests that wait for its time use its last known time."""
        del self.known[branch.number]
        for go_on in branch.waiting:
            self.server.loop.ask(go_on)
        if branch.lifeline is not None and branch.lifeline.fileno() >= 0:
            self.server.loop.watch(branch.lifeline.fileno())
            branch.lifeline.close()
        for path in (branch.journal, Path(branch.control), *map(Path, branch.lines.values())):
            with suppress(OSError):
                path.unlink()
        if branch.process:
            with suppress(OSError):
                os.kill(branch.process, *system.numbers("SIGKILL"))  # the only signal that a stopped process handles

    def touch(self) -> None:
        """Record that the branch that is shown has changed since its start, and so is worth keeping."""
        self.known[self.current].touched = True

    def _token(self) -> str | None:
        return next((control.token for control in self.server.controls()), None)

    def close(self) -> None:
        """End the processes of all branches."""
        for road in self.roads:
            road.close()
        self.roads.clear()
        self.current = 0  # clients that wait for a reply of a branch are served by the rest
        for branch in [one for one in self.known.values() if one.number]:
            self._drop(branch)
        if self.folder is not None:
            self.folder.cleanup()
            self.folder = None
