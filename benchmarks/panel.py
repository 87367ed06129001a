"""The cost of a panel: going back in time, views of eight chips, a window of an hour.

    python benchmarks/run.py panel

The session for going back has a thousand commands in ten virtual minutes, including pins and faults; the targets are
random instants of it, compared with a replay of the journal in this process.  The views are those of a page with thirty
frames per second, on eight moving modules, one of which is queried.
"""

from __future__ import annotations

import json
import random
import socket
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from subprocess import Popen
from time import perf_counter, sleep
from typing import Any

from rows import Row, timed
from serve import CHARACTER_MS, connected, served

import slewline
from slewline.bench import replay
from slewline.bench.scripts.script import run_script
from slewline.links.views.scope import Scope

STRAPS = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}
MODULE = ("gs-c200s", *(f"--strap={pin}={level}" for pin, level in STRAPS.items()))
PORTS = ("--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0")
COMMANDS = (b"V1", b"V2", b"F", b"E", b"S300", b"R50", b"Z", b"H", b"W", b"HELLO", b"A1", b"C1")
PROGRAM = (b"Po", b"S50", b"T200", b"R20", b"+400", b"-400", b"E")
COUNT, MINUTES, BACKS = 1000, 10, 100
CHIPS, FRAME_MS, LONG_S = 8, 33, 8.0
PAGE = f"""
import socket, sys
page = socket.create_connection((sys.argv[1], int(sys.argv[2])))
page.sendall(b'{{"do": "subscribe", "every": "{FRAME_MS} ms"}}\\n')
while page.recv(1 << 16):
    pass
"""
TO_AND_FRO = "R 90\nS 200\nF 10\nN 400\nE\n+\nG\n-\nG\nT 0\n0\nQX"


class Client:
    """A client of the control port."""

    def __init__(self, where: str) -> None:
        self.socket = connected(where)
        self.lines = self.socket.makefile("rw")

    def ask(self, do: str, **keys: Any) -> dict[str, Any]:
        """Send a request, and return the reply; events are dropped."""
        self.lines.write(json.dumps({"do": do, **keys}) + "\n")
        self.lines.flush()
        while "event" in (reply := json.loads(self.lines.readline())):
            pass
        return dict(reply)


def answered(host: socket.socket, line: bytes) -> None:
    """Send a line and wait for the answer."""
    host.sendall(line + b"\r")
    found = b""
    while not found.endswith(b"\r"):
        found += host.recv(64)


def session(host: socket.socket, client: Client, chance: random.Random) -> None:
    """Play a thousand commands, with pins and faults."""
    for line in PROGRAM:
        answered(host, line)
    for number in range(COUNT):
        answered(host, chance.choice(COMMANDS))
        if not number % 10:
            client.ask("drive", pin="gs_c200s.ui1", level=chance.randrange(2))
        if not number % 25:
            client.ask("fault", line="gs_c200s", to="chip", kind="parity")


def back() -> Iterator[Row]:
    """Yield the rows of going back in time."""
    chance = random.Random(1)
    with tempfile.TemporaryDirectory() as folder:
        journal = Path(folder) / "journal"
        with served(*MODULE, *PORTS, "--rate", "30", "--journal", str(journal), ports=2) as (port, control):
            client, host = Client(control), connected(port)
            session(host, client, chance)
            busy = client.ask("read", pins=[])["time_ps"]  # then the program runs without its host
            client.ask("until", time=f"{MINUTES * 60} s")
            client.ask("pause")
            took, plainly = [], []
            for number in range(BACKS):
                at = chance.randrange(busy if number % 2 else MINUTES * 60 * 10**12)
                start = perf_counter()
                reply = client.ask("back", time=at, branch=0)
                assert reply.get("branch"), reply
                took.append((perf_counter() - start) * 1e3)
                if not number % 10:
                    plainly.append(timed(lambda at=at: replay(journal, until=f"{at} ps"))[0] * 1e3)  # type: ignore[misc]
            host.close()
    why = "a fork, the journal since the checkpoint, and two connections"
    yield Row(
        "going back in a session of ten minutes with 1,000 commands, median", median(took), "ms", None, False, why
    )
    yield Row(
        "going back in a session of ten minutes with 1,000 commands, the slowest of 100",
        max(took),
        "ms",
        200,
        False,
        "the work between two checkpoints",
    )
    yield Row(
        "going to an instant of that session by replaying the whole journal, median",
        median(plainly),
        "ms",
        None,
        False,
        "the whole session",
    )


@contextmanager
def eight() -> Iterator[tuple[list[socket.socket], str]]:
    """Start a server of eight modules; yield its hosts, and the control port."""
    chips = "".join(
        f'[[chip]]\nname = "m{n}"\npart = "gs-c200s"\nstraps = {{ br0 = 0, br1 = 0, br2 = 0, chs = 0 }}\n'
        for n in range(CHIPS)
    )
    ports = "".join(f'[[serve]]\nchips = ["m{n}"]\ntcp = "127.0.0.1:0"\n' for n in range(CHIPS))
    with tempfile.TemporaryDirectory() as folder:
        bench = Path(folder) / "eight.toml"
        bench.write_text(chips + ports, "utf-8")
        journal = str(Path(folder) / "journal")
        arguments = ("--bench", str(bench), "--control", "127.0.0.1:0", "--journal", journal)
        with served(*arguments, ports=CHIPS + 1) as where:
            hosts = [connected(url) for url in where[:CHIPS]]
            for host in hosts:
                for line in (*PROGRAM[:-3], b"+30000", b"-30000", b"E"):
                    answered(host, line)
            yield hosts, where[-1]
            for host in hosts:
                host.close()


def answers(host: socket.socket) -> list[float]:
    """Return the answer times of a module beyond the time on a wire, ms, sorted."""
    found, end = [], perf_counter() + LONG_S
    while perf_counter() < end:
        start = perf_counter()
        answered(host, b"V1")
        found.append((perf_counter() - start) * 1e3 - 3 * CHARACTER_MS)
        sleep(0.01)
    return sorted(found)


def views() -> Iterator[Row]:
    """Yield the rows of a page on eight modules."""
    with eight() as (hosts, control):
        before = answers(hosts[0])
        page = Popen([sys.executable, "-c", PAGE, *control.rsplit(":", 1)])
        after = answers(hosts[0])
        page.terminate()
        page.wait()
    late = after[len(after) * 99 // 100] - before[len(before) * 99 // 100]
    yield Row(
        "answers while a page shows 8 chips: added delay, p99",
        late,
        "ms",
        1,
        False,
        "the comparisons for the page in each iteration",
    )


def windows() -> Iterator[Row]:
    """Yield the rows of a window of an hour."""
    bench = slewline.Bench()
    chip = bench.add("cy525", "x", straps={"dowhile": 0})
    names = [f"x.{pin}" for pin in ("pulse", "slew", "direction", "run", "ready", "wait")]
    bench.record(*names)
    run_script(bench, bench.host(chip), TO_AND_FRO)
    for _ in range(100):
        bench.run("36 s")
    scope = Scope(bench)

    def ask() -> None:
        for _ in scope.window([*names, "x.velocity", "x.position"], 0, bench.now_ps, 1200):
            pass

    first = timed(ask)[0] * 1e3
    again = min(timed(ask)[0] for _ in range(5)) * 1e3
    moves = len(chip.motions())
    yield Row(
        "scope: an hour of 8 signals, 1,200 columns", again, "ms", 50, False, "the cells of each signal, from a table"
    )
    bound = f"{moves:,} moves, processed once, in slices between other work"
    yield Row("scope: an hour of 8 signals, 1,200 columns, for the first time", first, "ms", None, False, bound)


def rows() -> list[Row]:
    """Return all rows."""
    return [*back(), *views(), *windows()]
