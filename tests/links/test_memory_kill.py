"""An EEPROM beside a chip, kept in a file: the process is killed at any moment of a long program entry.

Each round starts a process on the same file, which enters another program from address 0 on, and tells with every flush
how many of its bytes had been read back by then.  It is killed; what it had told is in the file, whole, and behind it
lies what was there before.
"""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import time
from pathlib import Path
from random import Random

import pytest

from slewline.core.memory.store import BufferedStore
from slewline.links.lines.memory_file import FileStore

DEADLINE_S = 60.0
SIZE = 65536
CHILD = """
import sys
import slewline
from slewline.links.lines.memory_file import FileStore

path, number = sys.argv[1], int(sys.argv[2])
bench = slewline.Bench(stores=lambda name: FileStore(path))
x = bench.add("cy545b", name="x")
memory = bench.part("eeprom", name="memory", to=x, write_time="150 us", flush="3 ms")
flush = memory.flush

def told():
    read_back = x.registers["pointer"]  # it counts on behind the read that was right
    flush()
    print(read_back, flush=True)

memory.flush = told
host = bench.host(x)
host.send("E\\r" + f"N {number}\\r" * 4000)
bench.run("60 s")
"""


def program(number: int) -> bytes:
    """What a round enters."""
    return f"N {number}\r".encode() * 4000


class Rounds:
    """Kills, one behind the other, of processes on one file."""

    def __init__(self, path: Path, seed: int) -> None:
        self.path, self.random = path, Random(seed)
        self.before = b"\xff" * SIZE
        self.told = self.more = 0  # bytes that had been told, and that were there beyond

    def round(self, number: int) -> None:
        """Start, kill, and look."""
        words = [sys.executable, "-c", CHILD, str(self.path), str(number)]
        process = subprocess.Popen(words, stdout=subprocess.PIPE, cwd=self.path.parent)
        try:
            assert select.select([process.stdout], [], [], DEADLINE_S)[0], "no flush"
            time.sleep(self.random.uniform(0, 0.3))
        finally:
            process.send_signal(signal.SIGKILL)
            process.wait()
        lines = process.stdout.read().split(b"\n")[:-1]
        process.stdout.close()
        told = int(lines[-1]) if lines else 0
        content = FileStore(self.path).read()
        entered = program(number)
        there = next((n for n in range(told, len(entered)) if content[n:] == self.before[n:]), -1)
        assert content[:told] == entered[:told], f"round {number}: {told} bytes had been flushed"
        assert there >= told and content[:there] == entered[:there], f"round {number}: a byte is torn"
        self.told += told
        self.more += there - told
        self.before = content


def killed(path: Path, rounds: int, seed: int) -> Rounds:
    """So many kills, with programs of different lengths."""
    done = Rounds(path, seed)
    for number in range(1, rounds + 1):
        done.round(int("123456789"[: number % 7 + 1]) + number)
    assert {other.name for other in path.parent.iterdir()} <= {path.name, f".{path.name}.part"}
    return done


@pytest.mark.system
def test_a_few_kills(tmp_path: Path) -> None:
    assert killed(tmp_path / "memory.eeprom", 3, 1).told > 0  # how many is a matter of the machine


@pytest.mark.long
@pytest.mark.timeout(3600)
def test_two_hundred_kills(tmp_path: Path) -> None:
    done = killed(tmp_path / "memory.eeprom", 200, 2)
    print(f"{done.told} bytes had been told as flushed, and were there; {done.more} were there beyond")
    assert done.told > 10_000


# ------------------------------------------------------------------------------------------------------------- 64 K
class Counting:
    """The module `os`, with its fsyncs counted."""

    def __init__(self) -> None:
        self.syncs = 0

    def __getattr__(self, name: str) -> object:
        return getattr(os, name)

    def fsync(self, file: int) -> None:
        self.syncs += 1
        os.fsync(file)


def stored(path: Path, each: int) -> tuple[float, int, bytes]:
    """Put 64K single bytes, with a flush behind so many; returns seconds, fsyncs, and what a later process finds."""
    system, data = Counting(), Random(1).randbytes(SIZE)
    gathered = BufferedStore(FileStore(path, system), b"\xff" * SIZE)
    start = time.perf_counter()
    for address, byte in enumerate(data):
        gathered.put(address, byte)
        if address % each == each - 1:
            gathered.flush()
    taken = time.perf_counter() - start
    assert FileStore(path).read() == data
    return taken, system.syncs, data


def test_single_bytes_cost_what_a_flush_costs(tmp_path: Path) -> None:
    _, syncs, _ = stored(tmp_path / "memory.eeprom", SIZE // 8)  # the long form says how fast it is
    assert syncs == 2 + 2 + 7  # the file, twice whole with its directory, and a record a flush


@pytest.mark.long
def test_64k_single_bytes_are_stored_in_a_second(tmp_path: Path) -> None:
    taken, _, data = min(stored(tmp_path / f"{n}.eeprom", SIZE // 8) for n in range(5))
    plain = tmp_path / "plain"
    start = time.perf_counter()
    with plain.open("wb") as file:
        file.write(data)
        os.fsync(file.fileno())
    once = time.perf_counter() - start
    print(f"64K single bytes, eight flushes: {taken:.3f} s, {taken / once:.0f} times a plain file written at once")
    assert taken < 1
