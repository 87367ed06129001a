"""A memory in a file: whatever fails, and wherever the power goes, it holds the old content or the new.

The disk of these tests forgets at a power cut what no fsync has told it to keep: of a file the data, of a directory the
names.  A store must be right on every disk that can be left behind.
"""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

import slewline
from slewline.errors import StoreError
from slewline.links.pace import Lockstep
from slewline.links.server import Server
from slewline.links.status import status
from slewline.links.store import FileStore

OLD, NEW = b"S10 T100 R50 +5", b"S10 T100 R50 G500000" * 4
PATH = Path("/state/x.eeprom")


class PowerCut(BaseException):
    """Nothing runs any more."""


class File:
    """What a file holds now, and what is certain to be there after a power cut."""

    def __init__(self, data=b""):
        self.data, self.kept = data, data

    def left(self):
        """The contents that a power cut can leave."""
        return {self.kept} if self.data == self.kept else {self.kept, self.data, self.data[: len(self.data) // 2]}


class Disk:
    """The file operations of `os` on one directory; `trouble` may raise before any of them, or garble a write."""

    def __init__(self, names):
        self.names = dict(names)
        self.states = [dict(self.names)]  # what the directory can be after a power cut; the last one is the present
        self.opened = {}
        self.calls = []
        self.trouble = lambda number, call: None

    def _call(self, name):
        self.calls.append(name)
        return self.trouble(len(self.calls), name)

    def open(self, path, flags, mode):
        self._call("open")
        if path == PATH.parent:
            file = None
        elif flags & os.O_CREAT:
            file = self.names.setdefault(path, File())
            file.data = b"" if flags & os.O_TRUNC else file.data
            self.states.append(dict(self.names))
        elif path in self.names:
            file = self.names[path]
        else:
            raise FileNotFoundError(errno.ENOENT, "no such file")
        number = len(self.opened)
        self.opened[number] = [file, 0]
        return number

    def write(self, number, data):
        instead = self._call("write")
        data = data if instead is None else instead(data)
        self.opened[number][0].data += data
        return len(data)

    def read(self, number, count):
        self._call("read")
        file, at = self.opened[number]
        self.opened[number][1] += count
        return file.data[at : at + count]

    def fsync(self, number):
        self._call("fsync")
        file = self.opened[number][0]
        if file is None:
            self.states = [dict(self.names)]
        else:
            file.kept = file.data

    def close(self, number):
        file = self.opened.pop(number)
        try:
            self._call("close")
        except PowerCut:
            self.opened[number] = file
            raise

    def replace(self, source, target):
        self._call("replace")
        self.names[target] = self.names.pop(source)
        self.states.append(dict(self.names))

    def unlink(self, path):
        self._call("unlink")
        if path not in self.names:
            raise FileNotFoundError(errno.ENOENT, "no such file")
        del self.names[path]
        self.states.append(dict(self.names))

    def after_power_cut(self):
        """Every disk that a power cut can leave."""
        for state in self.states:
            contents = state[PATH].left() if PATH in state else {None}
            yield from (Disk({} if data is None else {PATH: File(data)}) for data in contents)


def disk_with(data):
    """A disk on which a memory is safe; None: without one."""
    disk = Disk({})
    if data is not None:
        FileStore(PATH, disk).write(data)
    disk.calls.clear()
    return disk


def written(trouble, old=OLD):
    """Write NEW over `old` while there is trouble: was it refused, and what can be found afterwards?"""
    disk = disk_with(old)
    disk.trouble = trouble
    refused = False
    try:
        FileStore(PATH, disk).write(NEW)
    except (StoreError, PowerCut):
        refused = True
    disk.trouble = lambda number, call: None
    now = FileStore(PATH, disk).read()
    return refused, now, {FileStore(PATH, later).read() for later in disk.after_power_cut()}, disk


def steps(old):
    disk = disk_with(old)
    FileStore(PATH, disk).write(NEW)
    return disk.calls


EVERY_STEP = [
    pytest.param(old, number, id=f"{'over' if old else 'first'}-{number}-{call}")
    for old in (OLD, None)
    for number, call in enumerate(steps(old), 1)
]


def failing(number, error):
    def trouble(count, call):
        if count == number:
            raise error

    return trouble


@pytest.mark.parametrize(("old", "number"), EVERY_STEP)
def test_a_step_that_fails_leaves_the_old_content_or_is_no_failure(old, number):
    refused, now, later, disk = written(failing(number, OSError(errno.EIO, "input/output error")), old)
    before = old or b""
    assert {now} | later <= {before, NEW}
    assert refused == (later != {NEW})
    assert set(disk.names) <= {PATH}  # nothing is left lying about
    assert not disk.opened


@pytest.mark.parametrize(("old", "number"), EVERY_STEP)
def test_power_that_goes_at_a_step_leaves_old_or_new(old, number):
    def cut(count, call):
        if count >= number:
            raise PowerCut

    refused, now, later, disk = written(cut, old)
    before = old or b""
    assert refused
    assert {now} | later <= {before, NEW}
    FileStore(PATH, disk).write(b"the next")  # over what the killed one has left
    assert {FileStore(PATH, left).read() for left in disk.after_power_cut()} == {b"the next"}


def test_order_of_writes_and_syncs():
    calls = [call for call in steps(OLD) if call in ("write", "fsync", "replace")]
    assert calls == ["write", "fsync", "replace", "fsync"]


def test_what_was_answered_is_there_after_any_power_cut():
    refused, now, later, _ = written(lambda number, call: None)
    assert (refused, now, later) == (False, NEW, {NEW})


def test_a_disk_that_takes_a_byte_at_a_time():
    refused, now, later, _ = written(lambda number, call: (lambda data: data[:1]) if call == "write" else None)
    assert (refused, now, later) == (False, NEW, {NEW})


def test_a_disk_that_keeps_something_else_is_found_out_while_the_old_content_is_there():
    def garbling(number, call):
        return (lambda data: data[:-1] + b"?") if call == "write" else None

    refused, now, later, _ = written(garbling)
    assert (refused, now, later) == (True, OLD, {OLD})


# ----------------------------------------------------------------------------------------- a module on such a memory
def module(disk):
    """A server of a module whose memory is on the disk, and what asks it."""
    bench = slewline.Bench(stores=lambda name: FileStore(PATH, disk))
    x = bench.add("gs-c200s", "x", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0}, eeprom_time=0)
    told = []
    server = Server(bench, Lockstep(bench), tell=told.append)
    line = server.line(x)
    bench.run("10 ms")
    answers = bytearray()
    line.attach("host", lambda data: answers.extend(data) or 0, lambda: None)

    def ask(*commands):
        answers.clear()
        for command in commands:
            line.take(command.encode() + b"\r")
            bench.run("100 ms")
        return answers.decode().split("\r")[:-1]

    return server, ask, told


SAVED = ("Po", "A1", "Px", "M")


def operations():
    disk = Disk({})
    server, ask, _ = module(disk)
    assert ask(*SAVED) == ["Y"] * 4
    server.close()
    return len(disk.calls)


@pytest.mark.parametrize("number", range(1, operations() + 1))
def test_a_save_that_fails_at_any_operation_loses_nothing_and_the_reason_is_told(number):
    disk = Disk({})
    server, ask, told = module(disk)
    assert ask(*SAVED) == ["Y"] * 4
    assert ask("Po", "A2", "Px") == ["Y"] * 3
    begin = len(disk.calls)

    def trouble(count, call):
        if count - begin == number:
            raise OSError(errno.EIO, "input/output error")

    disk.trouble = trouble
    (answer,) = ask("M")
    disk.trouble = lambda count, call: None
    assert ask("Q") == ["A2", "END"]
    if answer == "Y":  # a file that could not be closed, or a neighbour that could not be removed
        assert ask("X", "Q") == ["Y", "A2", "END"] and told == []
    else:
        assert answer == "E6" and ask("X", "Q") == ["E6", "A2", "END"]
        text = told[0]
        assert told[1:] == [f"x: E6: the EEPROM was not written: {text}"]
        assert "the memory: input/output error" in text and status(server)["troubles"] == [text]
        assert FileStore(PATH, disk).read() in (b"A\1", b"A\2")
        assert ask("M", "X", "Q") == ["Y", "Y", "A2", "END"]
    server.close()


def test_the_same_trouble_is_told_once():
    disk = Disk({})
    server, ask, told = module(disk)

    def full(count, call):
        if call == "write":
            raise OSError(errno.ENOSPC, "no space left")

    disk.trouble = full
    assert ask("M", "M", "X") == ["E6"] * 3
    why = f"{PATH}: cannot write the memory: no space left; give a file in a writable directory"
    assert told == [why, f"x: E6: the EEPROM was not written: {why}"]
    server.close()


# ---------------------------------------------------------------------------------------------------------- real files
@pytest.fixture
def store(tmp_path):
    return FileStore(tmp_path / "x.eeprom")


@pytest.mark.parametrize("data", [b"", b"\0", bytes(range(119)), bytes(300_000)])
def test_another_store_reads_what_was_written(store, data):
    store.write(b"something longer, or shorter, before")
    store.write(data)
    assert FileStore(store.path).read() == data
    assert list(store.path.parent.iterdir()) == [store.path]


def test_a_new_memory_is_empty(store):
    assert store.read() == b""


def test_any_damage_is_noticed_and_a_write_mends_it(store):
    store.write(OLD)
    good = store.path.read_bytes()
    damaged = [good[:n] for n in range(len(good))] + [good + b"\0"]
    damaged += [good[:n] + bytes([good[n] ^ 1 << bit]) + good[n + 1 :] for n in range(len(good)) for bit in range(8)]
    for content in damaged:
        store.path.write_bytes(content)
        with pytest.raises(StoreError, match=r"x\.eeprom: .*remove"):
            store.read()
    store.path.write_bytes(good[:-1])
    store.write(NEW)
    assert store.read() == NEW


def test_a_file_of_somebody_else_is_not_touched(store):
    store.path.write_text("Dear Sir or Madam")
    for action in (store.read, lambda: store.write(NEW)):
        with pytest.raises(StoreError, match="no memory of slewline; name another file"):
            action()
    assert store.path.read_text() == "Dear Sir or Madam"


def test_a_directory_that_is_missing(tmp_path):
    store = FileStore(tmp_path / "nowhere" / "x.eeprom")
    assert store.read() == b""
    with pytest.raises(StoreError, match=r"x\.eeprom: cannot write the memory: No such file .*writable directory"):
        store.write(OLD)


def test_it_can_be_caught_as_the_error_of_the_system_that_it_is(tmp_path):
    with pytest.raises(OSError, match="cannot read the memory: Is a directory"):
        FileStore(tmp_path).read()


@pytest.mark.parametrize("name", ["x.eeprom", ".x.eeprom.part"])
def test_what_is_no_regular_file_is_refused_and_not_waited_for(tmp_path, name):
    """To open a FIFO is to wait for its other end."""
    os.mkfifo(tmp_path / name)
    store = FileStore(tmp_path / "x.eeprom")
    for call in (store.read, lambda: store.write(NEW)):
        with pytest.raises(StoreError, match="is no regular file"):
            call()
