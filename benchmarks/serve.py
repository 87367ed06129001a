"""How fast served modules answer: exchanges over TCP and a pseudo-terminal, and a hundred modules at once.

    python benchmarks/serve.py [--long]

Every server runs in a process of its own.  The paced figures are what an exchange takes beyond what it takes on a wire:
its characters and one more (1.146 ms each at 9600 baud), and the turn-round of the module (1 ms).  `--long` makes ten
times as many exchanges.
"""

from __future__ import annotations

import argparse
import os
import select
import socket
import subprocess
import sys
import tempfile
import termios
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter, sleep

CHARACTER_MS = 11 / 9.6
TURNROUND_MS = 1.0
SERVE = [sys.executable, "-c", "from slewline.tools.main import main; main()", "serve"]
MODULES, MOVING, POLLS_PER_S = 100, 20, 10
PROGRAM = (b"Po", b"S50", b"T400", b"R100", b"+9000", b"-9000", b"j12")

Ask = Callable[[bytes], bytes]


@contextmanager
def served(*arguments: str, ports: int = 1) -> Iterator[list[str]]:
    """`slewline serve` with these arguments; gives what it says of its ports."""
    server = subprocess.Popen([*SERVE, *arguments], stdout=subprocess.PIPE, text=True)
    assert server.stdout is not None
    try:
        yield [server.stdout.readline().strip().partition(": ")[2] for _ in range(ports)]
    finally:
        server.terminate()
        server.wait()


def connected(url: str) -> socket.socket:
    """A socket to a port."""
    host, port = url.rpartition("//")[2].rsplit(":", 1)
    connection = socket.create_connection((host, int(port)))
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return connection


def asking(fd: int) -> Ask:
    """Send a line and wait for the carriage return of its answer."""

    def ask(line: bytes) -> bytes:
        os.write(fd, line)
        answer = b""
        while not answer.endswith(b"\r"):
            answer += os.read(fd, 64)
        return answer

    return ask


def opened(link: str) -> int:
    """A pseudo-terminal, raw."""
    fd = os.open(link, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(fd, termios.TCSANOW)
    return fd


def exchanges(ask: Ask, count: int) -> list[float]:
    """Milliseconds of so many questions whether the module is ready, one after the other."""
    for _ in range(20):
        ask(b"F\r")
    times = []
    for _ in range(count):
        start = perf_counter()
        assert ask(b"F\r") == b"R\r"
        times.append((perf_counter() - start) * 1000)
    return times


def single(count: int) -> Iterator[tuple[str, list[float]]]:
    """One module, one host."""
    module = ("gs-c200s", "--strap", "chs=0")
    wire = 5 * CHARACTER_MS + TURNROUND_MS  # F, CR, R, CR and one more
    with tempfile.TemporaryDirectory() as folder:
        for pace, arguments in (("lockstep", ["--lockstep"]), ("paced", [])):
            beyond = 0.0 if pace == "lockstep" else wire
            what = "an exchange" if pace == "lockstep" else "beyond the wire"
            with served(*module, "--tcp", "127.0.0.1:0", *arguments) as (where,), connected(where) as connection:
                yield f"{pace}, TCP: {what}", [ms - beyond for ms in exchanges(asking(connection.fileno()), count)]
            with served(*module, "--pty", str(Path(folder, "x")), *arguments) as (where,):
                fd = opened(where)
                yield f"{pace}, pty: {what}", [ms - beyond for ms in exchanges(asking(fd), count)]
                os.close(fd)


def bench_file(folder: str) -> str:
    """A hundred modules, each on a port of its own."""
    path = Path(folder, "many.toml")
    straps = "{ br0 = 0, br1 = 0, br2 = 0, chs = 0 }"
    path.write_text(
        "".join(
            f'[[chip]]\npart = "gs-c200s"\nname = "m{n}"\nstraps = {straps}\n'
            f'[[serve]]\nchips = ["m{n}"]\ntcp = "127.0.0.1:0"\n'
            for n in range(MODULES)
        )
    )
    return str(path)


def many(seconds: float) -> Iterator[tuple[str, list[float]]]:
    """A hundred modules, each polled ten times a second; first at rest, then with twenty of them in endless motion."""
    with tempfile.TemporaryDirectory() as folder, served("--bench", bench_file(folder), ports=MODULES) as urls:
        connections = [connected(url) for url in urls]
        yield "1 module of 100 polled", polled(connections[:1], seconds)
        yield "100 modules polled", polled(connections, seconds)
        for connection in connections[:MOVING]:
            ask = asking(connection.fileno())
            for line in (*PROGRAM, b"E"):
                assert ask(line + b"\r") == b"Y\r", line
        yield "100 modules polled, 20 moving", polled(connections, seconds)
        for connection in connections:
            connection.close()


def polled(connections: list[socket.socket], seconds: float) -> list[float]:
    """Milliseconds of answers when every module is asked ten times a second, spread over time."""
    poll = select.epoll()
    by_fd = {connection.fileno(): connection for connection in connections}
    for fd in by_fd:
        poll.register(fd, select.EPOLLIN)
    begin = perf_counter() + 0.1
    plan = iter(
        (begin + (n + number / len(connections)) / POLLS_PER_S, connection)
        for n in range(int(seconds * POLLS_PER_S))
        for number, connection in enumerate(connections)
    )
    asked: dict[int, float] = {}
    answers: dict[int, bytes] = dict.fromkeys(by_fd, b"")
    times: list[float] = []
    following = next(plan, None)
    while following is not None or asked:
        if following is not None and perf_counter() >= following[0]:
            asked[following[1].fileno()] = perf_counter()
            following[1].send(b"F\r")
            following = next(plan, None)
        pause = max(following[0] - perf_counter(), 0) if following is not None else 1.0
        select.select([poll.fileno()], [], [], pause)
        for fd, _ in poll.poll(0):
            answers[fd] += by_fd[fd].recv(64)
            if answers[fd].endswith(b"\r"):
                times.append((perf_counter() - asked.pop(fd)) * 1000)
                answers[fd] = b""
    poll.close()
    return times


def row(name: str, times: list[float]) -> str:
    """One line of the table."""
    ordered = sorted(times)
    at = [ordered[min(int(len(ordered) * part), len(ordered) - 1)] for part in (0.5, 0.99, 1)]
    return f"{name:<34}" + "".join(f"{ms:>10.3f}" for ms in at) + f"{len(ordered):>10}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--long", action="store_true", help="ten times as many exchanges")
    times = 10 if parser.parse_args().long else 1
    print(f"{'milliseconds':<34}{'median':>10}{'p99':>10}{'worst':>10}{'exchanges':>11}")
    for name, found in single(500 * times):
        print(row(name, found), flush=True)
        sleep(0.2)
    for name, found in many(3.0 * times):
        print(row(name, found), flush=True)


if __name__ == "__main__":
    main()
