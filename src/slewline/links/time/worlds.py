"""Worlds: copies of a server at an instant of its past, each in a separate process.

    server       journal  ............T1...........T2............now
                                       |            |
    checkpoint                       fork         fork             these wait, and cost only memory pages
                                       |
    world                            fork --> plays the journal up to the instant --> serves, paused

A running coroutine cannot be copied, but a process can.  A checkpoint closes all inherited connections,
so that no host depends on it, and waits for orders; for each order it forks once more, and itself stays
unchanged.  The new copy replays the journal from the checkpoint up to the requested instant, opens a
control port and a port for each line, as sockets in a private folder of this user, and reports their
addresses.  After that it is a server like the first one.
"""

from __future__ import annotations

import json
import os
import select
import signal
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from ...bench.replaying import go_on
from ...lifeline import follow
from ..sockets import system
from ..sockets.loop import Loop

if TYPE_CHECKING:
    from ..face import ServerFace

GRACE_S = 10.0  # time for the server to connect
MOST = 1 << 20  # bytes of an order or of its answer
Data = dict[str, Any]


def fork_checkpoint(server: ServerFace) -> tuple[int, socket.socket]:
    """Fork a checkpoint of a server; return its process number and the socket for orders."""
    ours, theirs = socket.socketpair()
    process = cast("Callable[[], int]", system.FORK)()
    if process:
        theirs.close()
        return process, ours
    try:
        let_go(theirs.fileno())
        wait_for_orders(server, theirs)
    except BaseException as error:  # the server has ended
        with suppress(OSError):
            sys.stderr.write(f"slewline: a checkpoint: {error}\n")
    finally:
        os._exit(0)


def let_go(kept: int) -> None:
    """Close every descriptor except `kept` and standard error, and ignore the signals of a terminal."""
    system.ignore(
        system.numbers("SIGINT", "SIGHUP", "SIGQUIT", "SIGUSR1")
    )  # a terminal sends them to all processes on it
    system.forget_children()
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.set_wakeup_fd(-1)
    nowhere = os.open(os.devnull, os.O_RDWR)
    for descriptor in open_descriptors():
        if descriptor not in (kept, nowhere, 2):
            with suppress(OSError):
                os.dup2(nowhere, descriptor)


def open_descriptors() -> list[int]:
    """Return the descriptors that are open in this process."""
    for folder in ("/proc/self/fd", "/dev/fd"):
        with suppress(OSError):
            return [int(name) for name in os.listdir(folder)]
    return list(range(3, 1024))


def wait_for_orders(server: ServerFace, orders: socket.socket) -> None:
    """Fork a world for each order, until the server has ended."""
    worlds: dict[int, int] = {}  # branch number, by process

    def buried(process: int) -> None:
        """Report a world that has ended; the server ignores this if the world has already reported its addresses."""
        if process in worlds:
            with suppress(OSError):  # the server has ended
                send(orders, {"error": "its process has ended", "branch": worlds.pop(process)})

    system.watch_children(buried)
    for line in lines_of(orders):
        order = json.loads(line)
        if process := cast("Callable[[], int]", system.FORK)():
            worlds[process] = order["branch"]
        else:
            system.forget_children()
            World(server, order, orders).run()
            os._exit(0)


def send(orders: socket.socket, found: Data) -> None:
    """Send the answer to an order, as one line."""
    orders.sendall(json.dumps(found).encode() + b"\n")


def lines_of(orders: socket.socket) -> Iterator[bytes]:
    """Yield the lines received on a socket."""
    rest = b""
    with suppress(ConnectionError):  # the server was killed
        while data := orders.recv(MOST):
            *lines, rest = (rest + data).split(b"\n")
            yield from lines


def hung_up(orders: int) -> None:
    """Wait until the other end of a socket is closed; read nothing, since a checkpoint reads its orders there."""
    poll = select.poll()
    poll.register(orders, 0)
    poll.poll()


class World:
    """A server in a copy of its process.

    Args:
        order: the data for the world, with these keys: `journal`, the file to replay; `begin`, the byte at which
            the replay starts; `to`, the instant (ps) at which it ends; `copy`, the file for the world's own
            journal; `branch`, the world's number; `token`, the token of its control port; `breakpoints`.
    """

    def __init__(self, server: ServerFace, order: Data, answers: socket.socket) -> None:
        self.server, self.order, self.answers = server, order, answers
        self.bench = server.bench
        self.inherited = server.past, server.branches, server.ports, server.loop  # connections of the server
        self.known = False  # whether the server that ordered this world knows it
        self.lifeline: object = None  # the server's first connection

    def run(self) -> None:
        """Go to the instant in the order, open the ports, report their addresses, and serve."""
        follow(partial(hung_up, os.dup(self.answers.fileno())), self.orphaned)
        try:
            with self.silence():
                self.arrive()
            found = self.open_ports()
        except Exception as error:
            found = {"error": str(error)}
        send(self.answers, found | {"branch": self.order["branch"]})
        self.answers.close()
        if "error" not in found:
            self.server.branch = self.order["branch"]
            self.server.loop.after(GRACE_S, self.grow_up)
            self.server.serve(self.deserted)

    def orphaned(self) -> None:
        """End this process if the server that started it has ended without connecting to it."""
        if not any(control.clients for control in self.server.controls()):
            os._exit(0)

    def grow_up(self) -> None:
        """End the grace period: this world now counts as deserted unless the server that started it is connected."""
        self.known = True

    def deserted(self) -> bool:
        """Return whether the server that started this world has disconnected.

        Other clients may seem connected for longer: a disconnection is only noticed when a pending reply is sent.
        """
        clients = [client for control in self.server.controls() for client in control.clients]
        if self.lifeline is None and clients:
            self.known, self.lifeline = True, clients[0]
        return self.known and self.lifeline not in clients

    @contextmanager
    def silence(self) -> Iterator[None]:
        """Suppress all output while the past is replayed."""
        server, report = self.server, self.server.report
        server.report = lambda _text: None
        server.log.file = None
        yield
        server.report = report

    def arrive(self) -> None:
        """Replay the journal up to the instant in the order, without hosts and clients; pause there."""
        server, order = self.server, self.order
        server.loop = server.reports.loop = Loop()
        server.ports = []
        server.past, server.branches = type(server.past)(server), type(server.branches)(server)
        for line in server.lines.values():
            line.host, line.host_name, line.resume, line.wait, line.detour = None, "", None, None, None
            line.concludes = False
            line.forget_half()
        for wait in list(server.pace.waits):
            server.pace.forget(wait)
        server.breakpoints.waits = []
        server.pace.pause_time()
        go_on(self.bench, order["journal"], order["begin"], order["to"], order["copy"])
        server.breakpoints.replace(order["breakpoints"])

    def open_ports(self) -> Data:
        """Open the ports; return their addresses, the process number, and the journal."""
        server = self.server
        place = Path(self.order["copy"])  # in a folder that other users cannot enter
        control = place.with_suffix(".c")
        server.control(control, self.order["token"])
        lines = {}
        for number, (name, line) in enumerate(server.lines.items()):
            lines[name] = str(path := place.with_suffix(f".{number}"))
            server.tcp(line, path)
        return {"control": str(control), "lines": lines, "process": os.getpid(), "journal": self.order["copy"]}
