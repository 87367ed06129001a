"""Answer times of served modules: exchanges over TCP and a pseudo-terminal, registers, and a hundred modules together.

    python benchmarks/serve.py [--long]

Every server runs in a separate process.  The paced figures are the time of an exchange beyond its time on a wire: its
characters and one more (1.146 ms each at 9600 baud), and the turn-round of the module (1 ms).  The registers of a
chipset are compared alternately with a plain echo of two bytes, in a separate process as well.  A host in C
(registers.c, with the header of the examples) has its own echo, because its echoes are faster.  `--long` makes ten
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
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from functools import partial
from pathlib import Path
from statistics import median
from time import clock_gettime, perf_counter, process_time, sleep
from typing import TypeVar

import compiling
from rows import Measured, Row, Sides

from slewline.links.clients.chipset_port import COMMAND, DATA, HOSTRDY, STATUS, ChipsetPort

CHARACTER_MS = 11 / 9.6
TURNROUND_MS = 1.0
SERVE = [sys.executable, "-c", "from slewline.cli.main import main; main()", "serve"]
MODULES, MOVING, POLLS_PER_S = 100, 20, 10
PROGRAM = (b"Po", b"S50", b"T400", b"R100", b"+9000", b"-9000", b"j12")

SERVER = "an exchange, CPU time of the server"
WARM = 20  # exchanges before the timed ones
BATCHES = 5
HERE = Path(__file__).parent
SERIES = bytes.fromhex("c00b 2464 1210 2464 1000 1000 2464 1030 1039 2464 0000 0000")  # SET_POS 12345 as one message
ECHO = """
import socket
server = socket.create_server(("127.0.0.1", 0))
print("echo: echo://{}:{}".format(*server.getsockname()), flush=True)
while True:
    connection, _ = server.accept()
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    while data := connection.recv(4096):
        connection.sendall(data)
"""

Ask = Callable[[bytes], bytes]
Number = TypeVar("Number", bound=float)


class Ports(list[str]):
    """The ports of a server, from its output, and its process."""

    def __init__(self, said: Iterable[str], pid: int) -> None:
        super().__init__(said)
        self.pid = pid

    @property
    def processor_s(self) -> float:
        """Processor seconds of all threads of the server; Linux numbers such clocks by process."""
        return clock_gettime(~self.pid << 3 | 2)


def served(*arguments: str, ports: int = 1) -> AbstractContextManager[Ports]:
    """Start `slewline serve` with these arguments; yield its ports."""
    return started([*SERVE, *arguments], ports)


@contextmanager
def started(command: list[str], ports: int = 1) -> Iterator[Ports]:
    """Start a server; yield its ports."""
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert server.stdout is not None
    try:
        yield Ports([server.stdout.readline().strip().partition(": ")[2] for _ in range(ports)], server.pid)
    finally:
        server.terminate()
        server.wait()


def connected(url: str) -> socket.socket:
    """Return a socket connected to a port."""
    host, port = url.rpartition("//")[2].rsplit(":", 1)
    connection = socket.create_connection((host, int(port)))
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return connection


def asking(fd: int) -> Ask:
    """Return a function that sends a line and waits for the carriage return of its answer."""

    def ask(line: bytes) -> bytes:
        os.write(fd, line)
        answer = b""
        while not answer.endswith(b"\r"):
            answer += os.read(fd, 64)
        return answer

    return ask


def opened(link: str) -> int:
    """Open a pseudo-terminal, raw; return its file descriptor."""
    fd = os.open(link, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(fd, termios.TCSANOW)
    return fd


def exchanges(ask: Ask, count: int, server: Ports) -> tuple[list[Measured], float]:
    """Return the milliseconds of `count` queries for readiness, and the server's CPU milliseconds for each."""

    def exchange() -> None:
        assert ask(b"F\r") == b"R\r"

    return served_by(server, exchange, count)


def served_by(server: Ports, exchange: Callable[[], object], count: int) -> tuple[list[Measured], float]:
    """Return the milliseconds of `count` exchanges, and the server's CPU milliseconds for each."""
    exchange()  # the loading by the first one is not counted
    begun = server.processor_s
    times = timed(exchange, count)
    return times, (server.processor_s - begun) / (count + WARM) * 1000


def single(count: int) -> Iterator[tuple[str, list[float]]]:
    """Yield the times of one module with one host; in lockstep also the server's CPU time, as one time."""
    module = ("gs-c200s", "--strap", "chs=0")
    wire = 5 * CHARACTER_MS + TURNROUND_MS  # F, CR, R, CR and one more
    with tempfile.TemporaryDirectory() as folder:
        for pace, arguments in (("lockstep", ["--lockstep"]), ("paced", [])):
            beyond = 0.0 if pace == "lockstep" else wire
            what = "an exchange" if pace == "lockstep" else "answer time beyond the time on the wire"
            with served(*module, "--tcp", "127.0.0.1:0", *arguments) as server, connected(server[0]) as connection:
                times, each = exchanges(asking(connection.fileno()), count, server)
                yield f"{pace}, TCP: {what}", [ms - beyond for ms in times]
                yield f"{pace}, TCP: {SERVER}", [each]
            with served(*module, "--pty", str(Path(folder, "x")), *arguments) as server:
                fd = opened(server[0])
                times, each = exchanges(asking(fd), count, server)
                yield f"{pace}, pty: {what}", [ms - beyond for ms in times]
                yield f"{pace}, pty: {SERVER}", [each]
                os.close(fd)


def registers(count: int) -> Iterator[tuple[str, Sides]]:
    """Yield accesses to the registers of a chipset, and packets, whole and byte by byte: medians, with an echo's."""
    for pace, arguments in (("lockstep", ["--lockstep"]), ("paced", [])):
        with (
            started([sys.executable, "-c", ECHO]) as (echo,),
            connected(echo) as connection,
            served("mc1451a", "--tcp", "127.0.0.1:0", *arguments) as server,
            port_of(server) as port,
        ):
            for what, exchange, number in (
                (f"{pace}, registers: an access", partial(port.inp, STATUS), count),
                (f"{pace}, registers: a packet", partial(packed, port), count),
                (f"{pace}, registers: a packet, byte by byte", partial(by_bytes, port), count // 5),
            ):
                part, echoing = number // BATCHES, partial(echoed, connection)
                yield what, [(middle(timed(echoing, part)), middle(timed(exchange, part))) for _ in range(BATCHES)]


def port_of(server: Ports) -> ChipsetPort:
    """Return the registers of a served chipset."""
    host, number = server[0].rpartition("//")[2].rsplit(":", 1)
    return ChipsetPort(host, int(number))


def echoed(connection: socket.socket) -> None:
    """Send two bytes and read them back."""
    connection.sendall(b"\x04\0")
    connection.recv(2)


def packed(port: ChipsetPort) -> None:
    """Send SET_POS 12345 as one message."""
    check(port.packet(0x10, (0, 12345)))


def packet_of_server(count: int) -> float:
    """Return the server's CPU milliseconds for a packet as one message."""
    with served("mc1451a", "--tcp", "127.0.0.1:0", "--lockstep") as server, port_of(server) as port:
        return served_by(server, partial(packed, port), count)[1]


def in_c(count: int) -> Sides:
    """Return the medians of a host in C, in milliseconds, alternately: of an echo, and of a packet byte by byte."""
    with (
        tempfile.TemporaryDirectory() as folder,
        started([sys.executable, "-c", ECHO]) as (echo,),
        served("mc1451a", "--tcp", "127.0.0.1:0", "--lockstep") as (server,),
    ):
        header = f"-I{HERE.parent / 'examples' / 'mc1451a'}"
        program = str(compiling.compiled("registers.c", Path(folder, "registers"), header))

        def one(*words: str, where: str = "") -> Measured:
            command = [program, str(count // BATCHES), *words]
            ran = subprocess.run(command, check=True, capture_output=True, env={"SLEWLINE": where})
            return Measured(float(ran.stdout))

        return [(one(echo.rpartition(":")[2]), one(where=server.rpartition("//")[2])) for _ in range(BATCHES)]


def processor(count: int) -> tuple[float, float]:
    """Return the CPU milliseconds of a packet as one message: in a server, and in the simulation alone."""
    from slewline import Bench
    from slewline.links.lines.pace import Lockstep
    from slewline.links.server import Server

    bench = Bench()
    server = Server(bench, Lockstep(bench))
    line = server.line(bench.add("mc1451a"))
    board, kernel = server.lines["mc1451a"].board, bench.kernel  # type: ignore[attr-defined]
    server.pace.start()

    def simulated() -> None:
        request = board.series(SERIES[2:].hex(), "100 us")
        kernel.run_while(lambda: request.done, kernel.now + 10**12)

    port = server.tcp(line, "127.0.0.1:0")
    both = []
    with connected(port.where) as connection:
        connection.setblocking(False)

        def turn() -> None:
            server.pace.pass_time()
            server.loop.serve(server.loop.sleep(0))

        def exchanged() -> None:
            connection.sendall(SERIES)
            found = b""
            while len(found) < SERIES[1]:
                turn()
                with suppress(BlockingIOError):
                    found += connection.recv(64)

        while True:
            turn()
            with suppress(BlockingIOError):
                if connection.recv(100).endswith(b"\n"):
                    break
        for _ in range(10):  # by turns
            for call in (exchanged, simulated):
                begun = process_time()
                for _ in range(count):
                    call()
                both.append((process_time() - begun) / count * 1000)
    server.close()
    return min(both[::2]), min(both[1::2])


def by_bytes(port: ChipsetPort) -> None:
    """Send SET_POS 12345 as an old host program does, polling the status before every byte."""

    def ready() -> None:
        while not port.inp(STATUS) & HOSTRDY:
            pass

    for register, byte in ((COMMAND, 0x10), (DATA, 0), (DATA, 0), (DATA, 0x30), (DATA, 0x39)):
        ready()
        port.out(register, byte)
    ready()
    high = port.inp(DATA)
    ready()
    check((high << 8 | port.inp(DATA),))


def check(found: tuple[int, ...]) -> None:
    """Check the checksum of SET_POS 12345."""
    assert found == (0x3049,)


def timed(exchange: Callable[[], object], count: int) -> list[Measured]:
    """Return the milliseconds of `count` exchanges, one after the other."""
    for _ in range(WARM):
        exchange()
    times = []
    for _ in range(count):
        start = perf_counter()
        exchange()
        times.append(Measured((perf_counter() - start) * 1000))
    return times


def middle(times: Iterable[Measured]) -> Measured:
    """Return the median, which is one of the times themselves."""
    return at(sorted(times), 0.5)


def bench_file(folder: str) -> str:
    """Write a bench file of a hundred modules, each on its own port; return its path."""
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
    """Yield the times of a hundred modules, each polled ten times a second; at rest, then twenty in endless motion."""
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
    """Return the milliseconds of answers when every module is polled ten times a second, spread over time."""
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
            if following[1].fileno() not in asked:  # a host queries again when it has its answer
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


def module_rows() -> list[Row]:
    """Return the rows of the benchmark table for modules on serial lines."""
    times = {name: sorted(found) for name, found in (*single(1000), *many(10.0))}
    switch = "two process switches, in addition to the exchange itself"
    timer = "the system timer; the time on the wire is calculated for one character more than the exchange has"
    loop = "the exchange in virtual time; one iteration of the loop with its system calls"
    found = [
        Row(f"{name}{what}", at(times[name], part), "ms", goal, False, bound)
        for name, what, part, goal, bound in (
            ("lockstep, TCP: an exchange", ", median", 0.5, 0.3, switch),
            (f"lockstep, TCP: {SERVER}", "", 0, 0.15, loop),
            ("lockstep, pty: an exchange", ", median", 0.5, 0.3, switch),
            (f"lockstep, pty: {SERVER}", "", 0, 0.15, loop),
            ("paced, TCP: answer time beyond the time on the wire", ", median", 0.5, 1, timer),
            ("paced, TCP: answer time beyond the time on the wire", ", p99", 0.99, 5, "other work of the machine"),
            ("paced, pty: answer time beyond the time on the wire", ", median", 0.5, 1, timer),
            ("paced, pty: answer time beyond the time on the wire", ", p99", 0.99, 5, "other work of the machine"),
        )
    ]
    alone, busy = (at(times[name], 0.99) for name in ("1 module of 100 polled", "100 modules polled, 20 moving"))
    bound = f"{MODULES * POLLS_PER_S:,} exchanges per second in one thread"
    found.append(
        Row(
            "100 served modules, 20 of them moving: added delay compared with one module, p99",
            busy - alone,
            "ms",
            10,
            False,
            bound,
        )
    )
    return found


def register_rows() -> list[Row]:
    """Return the rows of the benchmark table for the registers of a chipset."""
    found = dict(registers(1000))
    rows = [
        Row(f"{name}, median", None, "x a plain echo", None, False, bound, found[name])
        for name, bound in (
            ("lockstep, registers: an access", "a bus cycle in virtual time"),
            ("lockstep, registers: a packet", "the packet itself, through the pins, as one message"),
            ("lockstep, registers: a packet, byte by byte", "the packet, polls, and two messages with a wait for each"),
        )
    ]
    name, unit = "lockstep, registers: a packet, byte by byte, through the C header, median", "x an echo in C"
    if compiling.COMPILER is None:
        rows.append(Row(name, None, unit, None, False, "the same", absent=compiling.ABSENT))
    else:
        sides = in_c(1000)
        bound = f"the same; an echo in C takes {min(echo for echo, _ in sides):.3f} ms"
        rows.append(Row(name, None, unit, None, False, bound, sides))
    total, simulation = processor(100)
    bound = f"the simulation, {simulation:.3f} ms with both ends in one process; the loop and its system calls"
    rows.append(Row("lockstep, a packet: CPU time of the server", packet_of_server(1000), "ms", 0.2, False, bound))
    rows.append(Row("lockstep, a packet: CPU time of both ends", total, "ms", None, False, "the same"))
    bound = "one iteration of the loop, with the system calls of both ends"
    rows.append(
        Row(
            "lockstep, a packet: CPU time of both ends, without the simulation",
            total - simulation,
            "ms",
            None,
            False,
            bound,
        )
    )
    return rows


def at(ordered: list[Number], part: float) -> Number:
    """Return the time below which a fraction of the times is."""
    return ordered[min(int(len(ordered) * part), len(ordered) - 1)]


def line(name: str, times: list[float]) -> str:
    """Return one line of the output of this script."""
    ordered = sorted(times)
    return f"{name:<50}" + "".join(f"{at(ordered, part):>10.3f}" for part in (0.5, 0.99, 1)) + f"{len(ordered):>10}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--long", action="store_true", help="ten times as many exchanges")
    times = 10 if parser.parse_args().long else 1
    print(f"{'milliseconds':<50}{'median':>10}{'p99':>10}{'worst':>10}{'exchanges':>11}")
    for name, found in single(500 * times):
        print(line(name, found), flush=True)
        sleep(0.2)
    sides = [*registers(500 * times)]
    if compiling.COMPILER is not None:
        sides.append(("lockstep, in C, byte by byte", in_c(500 * times)))
    for name, both in sides:
        echoes = median(theirs for theirs, _ in both), median(ours / theirs for theirs, ours in both)
        print(
            f"{name:<50}{median(ours for _, ours in both):>10.4f}  an echo {echoes[0]:.4f}: {echoes[1]:.1f}",
            flush=True,
        )
    total, simulation = processor(100)
    print(f"a packet, processor: {total:.3f} ms, of which simulation {simulation:.3f} ms", flush=True)
    for name, found in many(3.0 * times):
        print(line(name, found), flush=True)


if __name__ == "__main__":
    main()
