"""A memory that a thread writes: while the disk is slow its module waits, and nothing else does."""

from __future__ import annotations

import errno
import os
import select
import socket
import subprocess
import sys
import threading
import time

import pytest

import slewline
from slewline.core.memory.store import BufferedStore
from slewline.errors import StoreError
from slewline.links.lines.background import BackgroundStore
from slewline.links.lines.memory_file import FileStore
from tests.links.test_kill import DEADLINE_S

OLD, NEW = b"S10 T100 R50 +5", b"S10 T100 R50 G500000" * 4


class SlowDisk:
    """The module `os`, but its fsync waits until `ready` is set, and fails as often as `failures` says."""

    def __init__(self) -> None:
        self.ready = threading.Event()
        self.ready.set()
        self.failures = 0

    def __getattr__(self, name):
        return getattr(os, name)

    def fsync(self, _file):
        assert self.ready.wait(DEADLINE_S)
        if self.failures:
            self.failures -= 1
            raise OSError(errno.EIO, "input/output error")


@pytest.fixture
def disk():
    disk = SlowDisk()
    yield disk
    disk.ready.set()


@pytest.fixture
def store(tmp_path, disk):
    store = BackgroundStore(FileStore(tmp_path / "x.eeprom", disk))
    yield store
    disk.ready.set()
    store.close()


def kept(store):
    """What another process would find."""
    return FileStore(store.path).read()


def test_a_write_returns_before_it_is_done_and_is_read_immediately(store, disk):
    store.write(OLD)
    store.wait()
    disk.ready.clear()
    store.write(NEW)
    assert store.pending() and store.read() == NEW and kept(store) == OLD
    disk.ready.set()
    assert store.wait(DEADLINE_S) and not store.pending()
    assert store.read() == kept(store) == NEW


def test_a_write_that_was_refused_is_raised_once_and_reported_once(store, disk):
    store.write(OLD)
    store.wait()
    reported = []
    store.on_failure.add(reported.append)
    disk.failures = 1
    store.write(NEW)
    store.wait()
    with pytest.raises(StoreError, match="cannot write the memory: input/output error"):
        store.pending()
    assert not store.pending() and store.read() == OLD and len(reported) == 1


def test_a_waiting_write_is_replaced_by_a_later_one(store, disk):
    """A disk that stands for an hour while a supply is switched does not fill the memory."""
    disk.ready.clear()
    store.write(b"")
    while store._todo:
        time.sleep(0.001)
    for number in range(1000):
        store.write(b"%d" % number)
    disk.failures = 1  # the first one, which is under way
    assert len(store._todo) <= 1
    disk.ready.set()
    store.wait()
    assert not store.pending() and kept(store) == b"999"


def test_bytes_that_are_put_while_others_are_written_go_with_the_next_flush(store, disk):
    memory = BufferedStore(store, bytes(64))
    store.wait()
    disk.ready.clear()
    memory.put(3, 7)
    memory.put(5, 1)
    assert not memory.flush()
    memory.put(3, 8)
    memory.put(60, 9)
    assert not memory.flush() and memory.unsaved == {3, 5, 60}
    disk.failures = 1
    disk.ready.set()
    memory.wait()
    with pytest.raises(StoreError):
        memory.flush()
    assert memory.unsaved == {3, 5, 60}
    memory.flush()
    memory.wait()
    assert memory.flush() and not memory.unsaved
    assert kept(store) == memory.content and (memory.content[3], memory.content[60]) == (8, 9)


# --------------------------------------------------------------------------------------------------------- the modules
def two_modules(stores, journal=None):
    bench = slewline.Bench(journal=journal, stores=lambda name: stores[name])
    hosts = []
    for name in "xy":
        chip = bench.add("gs-c200s", name, straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0})
        hosts.append(bench.host(chip))
    bench.run("1 s")
    return bench, *hosts


@pytest.fixture
def stores(tmp_path, disk):
    stores = {"x": BackgroundStore(FileStore(tmp_path / "x.eeprom", disk))}
    stores["y"] = BackgroundStore(FileStore(tmp_path / "y.eeprom"))
    yield stores
    disk.ready.set()
    for each in stores.values():
        each.close()


def lines(host):
    """What has come, and is not looked at again."""
    text = host.received.decode("latin-1")
    host.received.clear()
    return text.split("\r")[:-1]


def test_a_module_answers_when_its_disk_has_confirmed_and_others_continue(stores, disk):
    bench, x, y = two_modules(stores)
    x.send("Po\rS77\rPx\r")
    bench.run("1 s")
    assert lines(x) == ["Y"] * 3
    disk.ready.clear()
    x.send("M\r")
    y.send("Po\rS88\rPx\rM\r")
    bench.run("3 s")
    assert lines(x) == []
    assert stores["y"].wait(DEADLINE_S)
    bench.run("3 s")
    assert lines(y) == ["Y"] * 4
    assert kept(stores["x"]) == b"" != kept(stores["y"])
    disk.ready.set()
    assert stores["x"].wait(DEADLINE_S)
    bench.run("20 ms")
    assert lines(x) == ["Y"] and kept(stores["x"]) == stores["x"].read() != b""
    assert not bench.findings


def test_a_module_whose_disk_refuses_reports_it(stores, disk):
    bench, x, _ = two_modules(stores)
    disk.ready.clear()
    disk.failures = 1
    x.send("M\r")
    bench.run("2 s")
    disk.ready.set()
    stores["x"].wait(DEADLINE_S)
    bench.run("4 s")
    assert lines(x) == ["E6"]
    (found,) = bench.findings
    assert "the EEPROM was not written" in found.text and "input/output error" in found.text
    x.send("M\r")
    bench.run("1 s")
    stores["x"].wait(DEADLINE_S)
    bench.run("2 s")
    assert lines(x) == ["Y"]


@pytest.mark.parametrize("failures", [0, 1])
def test_a_replay_waits_as_long_as_the_disk_did(tmp_path, stores, disk, failures):
    bench, x, _ = two_modules(stores, tmp_path / "run.journal")
    disk.ready.clear()
    disk.failures = failures
    x.send("M\r")
    bench.run("2 s")
    disk.ready.set()
    stores["x"].wait(DEADLINE_S)
    bench.run("4 s")
    bench.journal.close()

    again = slewline.replay(tmp_path / "run.journal", prepare=lambda bench: bench.record())
    assert again.findings == bench.findings and len(again.findings) == failures
    assert (tmp_path / "run.journal").read_text().count('"pending":true') > 5
    answered = [each / 1e12 for each in again.edges("x.txd")[0] if each > 10**12]
    assert 3 < answered[0] < 6


def test_a_memory_next_to_a_chip_is_complete_when_its_bench_is_closed(tmp_path, disk):
    store = BackgroundStore(FileStore(tmp_path / "memory", disk))
    bench = slewline.Bench(stores=lambda _name: store)
    x = bench.add("cy545b", name="x")
    memory = bench.part("eeprom", name="memory", to=x, write_time="150 us", flush="3 ms")
    host = bench.host(x)
    disk.failures = 1
    host.send("E\rN 12345\rN 777\r")
    bench.run("3 s")
    memory.leave()  # as a server does when it ends
    store.close()
    assert memory.content.startswith(b"N 12345\rN 777\r")
    assert kept(store) == memory.content
    assert [each.code for each in bench.findings] == ["not-kept"]


SERVER = """
import os, sys, time
from slewline.cli.main import main

fsync = os.fsync
def slow(file):
    time.sleep(3)
    fsync(file)

os.fsync = slow
sys.argv = ["slewline", *sys.argv[1:]]
main()
"""


def answer_of(module):
    """The next answer of a module."""
    received = b""
    while not received.endswith(b"\r"):
        received += module.recv(1)
    return received


@pytest.mark.system
def test_a_server_with_a_slow_disk_loses_no_time(tmp_path):
    """Each fsync takes 3 s, and `M` needs more than one: meanwhile another module answers as ever."""
    tables = [
        f'[[chip]]\nname = "{name}"\npart = "gs-c200s"\nstraps = {{ br0 = 0, br1 = 0, br2 = 0, chs = 0 }}\n'
        for name in "xy"
    ]
    ports = [f'[[serve]]\nchips = ["{name}"]\ntcp = "127.0.0.1:0"\n' for name in "xy"]
    (tmp_path / "two.toml").write_text("".join(tables + ports))
    words = ["serve", "--bench", str(tmp_path / "two.toml"), "--state", str(tmp_path / "state")]
    with subprocess.Popen(
        [sys.executable, "-c", SERVER, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            where = [process.stdout.readline().strip().rpartition(":")[2] for _ in "xy"]
            x, y = (socket.create_connection(("127.0.0.1", int(port)), DEADLINE_S) for port in where)
            with x, y:
                x.sendall(b"M\r")
                answers = 0
                while not select.select([x], [], [], 0)[0]:
                    y.sendall(b"F\r")
                    assert answer_of(y) == b"R\r"
                    answers += 1
                assert answer_of(x) == b"Y\r"
                assert answers > 20
                x.sendall(b"M\r")
                time.sleep(0.5)
        finally:
            process.terminate()
        errors = process.communicate(timeout=DEADLINE_S)[1]
    assert "behind" not in errors and "lost" not in errors, errors
    assert "is still being written: the disk is slow" in errors
    assert process.returncode == 0
