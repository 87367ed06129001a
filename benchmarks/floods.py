"""Answer times of a served module while a client floods another port of the server.

    python benchmarks/floods.py [--long] [--only WORD]

A server with ports of every kind runs in a separate process, paced; one host queries its module for readiness, ten
milliseconds apart, and a client in another process floods another port meanwhile.  The figures are milliseconds from
query to answer; the wire alone takes 6.7.  The throughput of the flood is printed with them.
"""

from __future__ import annotations

import argparse
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter, sleep

from serve import at, connected, served

SPACING_S = 0.01
BENCH = """
[[chip]]
part = "gs-c200s"
name = "healthy"
straps = { br0 = 0, br1 = 0, br2 = 0, chs = 0 }
[[serve]]
chips = ["healthy"]
tcp = "127.0.0.1:0"

[[chip]]
part = "gs-c200s"
name = "other"
straps = { br0 = 0, br1 = 0, br2 = 0, chs = 0 }
[[serve]]
chips = ["other"]
rfc2217 = "127.0.0.1:0"

[[chip]]
part = "mc1451a"
name = "chipset"
[[serve]]
chips = ["chipset"]
tcp = "127.0.0.1:0"

[[chip]]
part = "cy525"
name = "framed"
[[serve]]
chips = ["framed"]
framing = true
tcp = "127.0.0.1:0"

[[chip]]
part = "cy545"
name = "card"
[[serve]]
chips = ["card"]
over = "parallel"
tcp = "127.0.0.1:0"
"""
RATE = b"\xff\xfa\x2c\x01\x00\x00\x25\x80\xff\xf0"  # RFC 2217: 9600 baud
FLOODS = {  # what is sent without pause, to which port, and whether the answers are read
    "nothing": ("", b"", True),
    "status, read": ("control", b'{"do": "status"}\n' * 100, True),
    "status, unread": ("control", b'{"do": "status"}\n' * 100, False),
    "findings, read": ("control", b'{"do": "findings"}\n' * 100, True),
    "registers, polls, read": ("chipset", b"\x04\x00" * 1000, True),
    "registers, polls, unread": ("chipset", b"\x04\x00" * 1000, False),
    "registers, waits, read": ("chipset", b"\x44\x01" + b"\x24\x01\x10\x00" * 50 + b"\x04\x00" * 500, True),
    "registers, nonsense": ("chipset", b"\xee\xee" * 1000, True),
    "card, polls, read": ("card", b"\x04\x00" * 1000, True),
    "card, waits, read": ("card", b"\x34\x01" + b"\x04\x00" * 500, True),
    "framing, ?": ("framed", b"?\r" * 1000, True),
    "framing, commands": ("framed", b"N 1\r" * 1000, True),
    "framing, ?0": ("framed", b"?0\r" * 1000, True),
    "rfc2217, characters": ("other", b"F\r" * 1000, True),
    "rfc2217, settings": ("other", RATE * 200, True),
}
FLOOD = """
import socket, sys
host, port, data, reads = sys.argv[1], int(sys.argv[2]), bytes.fromhex(sys.argv[3]), sys.argv[4] == "True"
connection = socket.create_connection((host, port))
print(flush=True)
sent, read = memoryview(data), 0
connection.setblocking(False)
import select, time
begin = time.monotonic()
while time.monotonic() < begin + float(sys.argv[5]):
    readable, writable, _ = select.select([connection] * reads, [connection], [], 0.1)
    try:
        if readable:
            found = len(connection.recv(1 << 16))
            if not found:
                break
            read += found
        if writable:
            sent = sent[connection.send(sent):] or memoryview(data)
    except BlockingIOError:
        pass
    except OSError:
        break
print(int(read / (time.monotonic() - begin)))
"""


@contextmanager
def flooding(url: str, data: bytes, reads: bool, seconds: float) -> Iterator[subprocess.Popen[str]]:
    """Start a process that repeatedly sends the same data to a port, and prints the received bytes per second."""
    host, port = url.rpartition("//")[2].rsplit(":", 1)
    command = [sys.executable, "-c", FLOOD, host, port, data.hex(), str(reads), str(seconds)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    process.stdout.readline()
    try:
        yield process
    finally:
        process.wait()


def answers(connection: socket.socket, seconds: float) -> list[float]:
    """Return the milliseconds of answers to queries ten milliseconds apart."""
    times = []
    end = perf_counter() + seconds
    while (start := perf_counter()) < end:
        connection.sendall(b"F\r")
        answer = b""
        while not answer.endswith(b"\r"):
            answer += connection.recv(64)
        assert answer == b"R\r", answer
        times.append((perf_counter() - start) * 1000)
        sleep(max(start + SPACING_S - perf_counter(), 0))
    return times


def measured(name: str, seconds: float) -> tuple[list[float], str]:
    """Return the milliseconds of answers under a flood, and the bytes per second that the flood received."""
    to, data, reads = FLOODS[name]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "bench.toml")
        path.write_text(BENCH)
        names = ("healthy", "other", "chipset", "framed", "card", "control")
        with served("--bench", str(path), "--control", "127.0.0.1:0", ports=len(names)) as found:
            ports = dict(zip(names, found, strict=True))
            with connected(ports["healthy"]) as connection:
                answers(connection, 0.3)
                if not to:
                    return answers(connection, seconds), ""
                with flooding(ports[to], data, reads, seconds + 0.5) as flood:
                    sleep(0.3)
                    times = answers(connection, seconds)
                assert flood.stdout is not None
                return times, flood.stdout.read().strip()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--long", action="store_true", help="five times as long")
    parser.add_argument("--only", default="", help="floods with this word in their names")
    options = parser.parse_args()
    print(f"{'milliseconds':<28}{'median':>10}{'p99':>10}{'worst':>10}{'answers':>10}{'bytes/s back':>14}")
    for name in FLOODS:
        if options.only in name:
            times, back = measured(name, 10.0 if options.long else 2.0)
            ordered = sorted(times)
            shown = "".join(f"{at(ordered, part):>10.1f}" for part in (0.5, 0.99, 1))
            print(f"{name:<28}{shown}{len(ordered):>10}{back:>14}", flush=True)


if __name__ == "__main__":
    main()
