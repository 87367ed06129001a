"""A memory in a file: whatever fails, and wherever the power goes, it holds the old content or the new.

The disk of these tests forgets at a power cut what no fsync has told it to keep: of a file the data, of a directory the
names.  A store must be right on every disk that can be left behind.
"""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from random import Random

import pytest

import slewline
from slewline.core.memory.store import Memory
from slewline.errors import StoreError, UsageError
from slewline.links.lines import memory_file as store_module
from slewline.links.lines.memory_file import HEADER, MAGIC, RECORD, FileStore, packed
from slewline.links.lines.pace import Lockstep
from slewline.links.server import Server
from slewline.links.views.server_status import status

OLD, NEW = b"S10 T100 R50 +5", b"S10 T100 R50 G500000" * 4
PATH = Path("/state/x.eeprom")


class PowerCut(BaseException):
    """Nothing runs any more."""


class File:
    """What a file holds now, and what is certain to be there after a power cut."""

    def __init__(self, data=b""):
        self.data, self.kept = data, data

    def left(self):
        """The contents that a power cut can leave: what was there is not lost, what came behind it may be in part."""
        common = next((n for n, (a, b) in enumerate(zip(self.data, self.kept)) if a != b), len(self.kept))  # noqa: B905
        return {self.kept, self.data, self.data[: (common + len(self.data)) // 2]}


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
            if flags & os.O_EXCL and path in self.names:
                raise FileExistsError(errno.EEXIST, "file exists")
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

    def lseek(self, number, place, whence):
        self._call("lseek")
        file = self.opened[number]
        file[1] = len(file[0].data) if whence == os.SEEK_END else place
        return file[1]

    def ftruncate(self, number, length):
        self._call("ftruncate")
        self.opened[number][0].data = self.opened[number][0].data[:length]

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


def every_step():
    """What is there before, number and name of a call, for each call of a write."""
    return [(old, number, call) for old in (OLD, None) for number, call in enumerate(steps(old), 1)]


def failing(number, error):
    def trouble(count, call):
        if count == number:
            raise error

    return trouble


def dark_from(number):
    def trouble(count, call):
        if count >= number:
            raise PowerCut

    return trouble


def test_a_step_that_fails_leaves_the_old_content_or_is_harmless(subtests):
    for old, number, call in every_step():
        with subtests.test(old=old, number=number, call=call):
            refused, now, later, disk = written(failing(number, OSError(errno.EIO, "input/output error")), old)
            before = old or b""
            assert {now} | later <= {before, NEW}
            assert refused == (later != {NEW})
            assert set(disk.names) <= {PATH}  # nothing is left lying about
            assert not disk.opened


def test_power_that_goes_at_a_step_leaves_old_or_new(subtests):
    for old, number, call in every_step():
        with subtests.test(old=old, number=number, call=call):
            refused, now, later, disk = written(dark_from(number), old)
            before = old or b""
            assert refused
            assert {now} | later <= {before, NEW}
            FileStore(PATH, disk).write(b"the next")  # over what the killed one has left
            assert {FileStore(PATH, left).read() for left in disk.after_power_cut()} == {b"the next"}


def test_order_of_writes_and_syncs():
    calls = [call for call in steps(OLD) if call in ("write", "fsync", "replace")]
    assert calls == ["write", "fsync", "replace", "fsync"]


def test_acknowledged_writes_survive_any_power_cut():
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


# ----------------------------------------------------------------------------------------------- bytes that are added
LARGE = bytes(range(256)) * 20
ADDED, AT = b"the next characters", 77


def store_of(disk, kind):
    """A store of LARGE whose next append makes the first journal of the file, is the next record, or writes it anew."""
    store = FileStore(PATH, disk)
    store.write(LARGE)
    if kind != "first":
        store.append(b"x", 3)
    for _ in range(4 if kind == "anew" else 0):  # records that leave no room for another one
        store.append(LARGE[: len(LARGE) - RECORD.size - 6], 0)
    disk.calls.clear()
    return store


def appended(kind, trouble):
    """Append while there is trouble: contents before and after, was it refused, and what can be found afterwards?"""
    disk = Disk({})
    store = store_of(disk, kind)
    before = store.read()
    after = before[:AT] + ADDED + before[AT + len(ADDED) :]
    disk.calls.clear()
    disk.trouble = trouble
    refused = False
    try:
        store.append(ADDED, AT)
    except (StoreError, PowerCut):
        refused = True
    disk.trouble = lambda number, call: None
    left = [*disk.after_power_cut()]
    return before, after, refused, store, disk, left


def calls_of_append(kind):
    disk = Disk({})
    store_of(disk, kind).append(ADDED, AT)
    return disk.calls


def every_append():
    """Kind of append, number and name of a call, for each call of an append."""
    return [(kind, n, call) for kind in ("first", "next", "anew") for n, call in enumerate(calls_of_append(kind), 1)]


def test_only_the_first_append_and_occasional_ones_rewrite_the_file():
    assert ["replace" in calls_of_append(kind) for kind in ("first", "next", "anew")] == [True, False, True]
    assert calls_of_append("next") == ["open", "lseek", "write", "fsync", "lseek", "read", "read", "close"]


def test_an_append_that_fails_at_a_step_leaves_the_old_content_or_is_harmless(subtests):
    for kind, number, call in every_append():
        with subtests.test(kind=kind, number=number, call=call):
            trouble = failing(number, OSError(errno.EIO, "input/output error"))
            before, after, refused, store, disk, left = appended(kind, trouble)
            later = {FileStore(PATH, each).read() for each in left}
            now = store.read()
            assert {now} | later <= {before, after}
            assert refused == (later != {after})
            assert set(disk.names) <= {PATH} and not disk.opened
            store.append(b"!", AT)  # what comes next is neither lost nor put into a broken file
            assert {FileStore(PATH, each).read() for each in disk.after_power_cut()} == {
                now[:AT] + b"!" + now[AT + 1 :]
            }


def test_a_power_cut_in_an_append_leaves_old_or_new_and_the_next_one_continues_from_there(subtests):
    for kind, number, call in every_append():
        with subtests.test(kind=kind, number=number, call=call):
            before, after, refused, _, _, left = appended(kind, dark_from(number))
            assert refused
            for disk in left:
                found = FileStore(PATH, disk).read()
                assert found in (before, after)
                next_one = FileStore(PATH, disk)
                next_one.append(b"and more", 1)
                next_one.append(b"and more")
                wanted = found[:1] + b"and more" + found[9:] + b"and more"
                assert {FileStore(PATH, each).read() for each in disk.after_power_cut()} == {wanted}


def test_acknowledged_appends_survive_any_power_cut():
    for kind in ("first", "next", "anew"):
        _, after, refused, _, _, left = appended(kind, lambda number, call: None)
        assert not refused and {FileStore(PATH, each).read() for each in left} == {after}


def test_a_record_that_the_disk_garbles_or_takes_byte_by_byte():
    slow = lambda number, call: (lambda data: data[:1]) if call == "write" else None  # noqa: E731
    before, after, refused, store, _, _ = appended("next", slow)
    assert (refused, store.read()) == (False, after)
    garbling = lambda number, call: (lambda data: data[:-1] + b"?") if call == "write" else None  # noqa: E731
    before, after, refused, store, _, _ = appended("next", garbling)
    assert (refused, store.read()) == (True, before)


# ----------------------------------------------------------------------------------------- a module on such a memory
def module(disk, journal=None):
    """A server of a module whose memory is on the disk, and what asks it."""
    bench = slewline.Bench(stores=lambda name: FileStore(PATH, disk), journal=journal)
    x = bench.add("gs-c200s", "x", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0}, eeprom_time=0)
    told = []
    server = Server(bench, Lockstep(bench), report=told.append)
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
def test_a_save_that_fails_at_any_operation_loses_nothing_and_the_reason_is_reported(number):
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
        not_valid = f"the EEPROM contains no valid program: the last write failed ({text})"
        assert told[1:] == [f"x: E6: the EEPROM was not written: {text}", f"x: E6: {not_valid}"]
        assert "the memory: input/output error" in text and status(server)["troubles"] == [text]
        assert FileStore(PATH, disk).read() in (b"A\1", b"A\2")
        assert ask("M", "X", "Q") == ["Y", "Y", "A2", "END"]
    server.close()


@pytest.mark.parametrize("number", range(1, operations() + 1))
def test_a_save_that_fails_is_in_the_journal_and_fails_again_in_a_replay(tmp_path, number):
    disk = disk_with(b"A9\1")
    server, ask, _ = module(disk, tmp_path / "j")
    server.bench.record()
    ask(*SAVED)
    begin = len(disk.calls)

    def trouble(count, call):
        if count - begin == number:
            raise OSError(errno.EIO, "input/output error")

    disk.trouble = trouble
    failed = "E6" in ask("Po", "A2", "Px", "M", "X", "Q")
    disk.trouble = lambda count, call: None
    del disk.names[PATH]  # somebody takes the memory away
    ask("X", "M", "X", "Q")
    server.close()
    bench, x = server.bench, server.bench.chips["x"]
    again = slewline.replay(tmp_path / "j", until=bench.now_ps, prepare=lambda bench: bench.record())
    assert again.findings == bench.findings
    assert failed is ('"error":' in (tmp_path / "j").read_text())
    assert '"content":[]' in (tmp_path / "j").read_text()
    assert again.chips["x"].program == x.program
    for pin in ("txd", "rdy"):
        edges, before = again.edges(f"x.{pin}"), bench.edges(f"x.{pin}")
        since = edges[0] >= before[0][0]  # the server made its line before anything was recorded
        assert [list(each[since]) for each in edges] == [list(each) for each in before]


def test_a_store_without_append_has_its_faults_in_the_journal(tmp_path):
    class Weak:
        """Non-volatile memory that takes no byte more once it is full."""

        def __init__(self):
            self.data, self.writes = b"", 0

        def read(self):
            return self.data

        def write(self, data):
            self.writes += 1
            if 3 <= self.writes <= 5:
                raise OSError("worn out")
            self.data = data

    def put(bench):
        memory = bench.parts["memory"]
        for at in (5, 6, 5000, 7):
            memory.load(bytes([at & 0xFF]), at)
            bench.run("20 ms")

    bench = slewline.Bench(journal=tmp_path / "j")
    bench.part("eeprom", "memory", store=Weak())
    put(bench)
    bench.run("1 s")
    again = slewline.replay(tmp_path / "j")
    assert "worn out" in (tmp_path / "j").read_text()
    assert again.findings == bench.findings
    assert again.parts["memory"].content == bench.parts["memory"].content
    assert again.parts["memory"].store.read() == bench.parts["memory"].store.read()


def test_the_same_trouble_is_reported_once():
    disk = Disk({})
    server, ask, told = module(disk)

    def full(count, call):
        if call == "write":
            raise OSError(errno.ENOSPC, "no space left")

    disk.trouble = full
    assert ask("M", "M", "X") == ["E6"] * 3
    why = f"{PATH}: cannot write the memory: no space left; give a file in a writable directory"
    not_valid = f"the EEPROM contains no valid program: the last write failed ({why})"
    assert told == [why, f"x: E6: the EEPROM was not written: {why}", f"x: E6: {not_valid}"]
    server.close()


# ---------------------------------------------------------------------------------------------------------- real files
@pytest.fixture
def store(tmp_path):
    return FileStore(tmp_path / "x.eeprom")


@pytest.fixture
def no_sync(monkeypatch):
    """What is read back was not cut off from power: nobody waits for the disk."""
    monkeypatch.setattr(os, "fsync", lambda _number: None)


@pytest.mark.parametrize("data", [b"", b"\0", bytes(range(119)), bytes(300_000)])
def test_another_store_reads_the_written_content(store, data):
    store.write(b"something longer, or shorter, before")
    store.write(data)
    assert FileStore(store.path).read() == data
    assert list(store.path.parent.iterdir()) == [store.path]


def test_a_new_memory_is_empty(store):
    assert store.read() == b""


@pytest.mark.usefixtures("no_sync")
def test_any_damage_is_noticed_and_a_write_mends_it(store):
    store.write(OLD)
    good = store.path.read_bytes()
    damaged = [good[:n] for n in range(len(good))] + [good + b"\0"]
    damaged += [good[:n] + bytes([good[n] ^ 1 << bit]) + good[n + 1 :] for n in range(len(good)) for bit in range(8)]
    for content in damaged:
        store.path.write_bytes(content)
        with pytest.raises(StoreError, match=r"x\.eeprom.*(move|name another)"):
            store.read()
    store.path.write_bytes(good[:-1])
    store.write(NEW)
    assert store.read() == NEW


def test_a_foreign_file_is_not_touched(store):
    store.path.write_text("Dear Sir or Madam")
    for action in (store.read, lambda: store.write(NEW)):
        with pytest.raises(StoreError, match="not a slewline memory; name another file"):
            action()
    assert store.path.read_text() == "Dear Sir or Madam"


def test_a_directory_that_is_missing(tmp_path):
    store = FileStore(tmp_path / "nowhere" / "x.eeprom")
    assert store.read() == b""
    with pytest.raises(StoreError, match=r"x\.eeprom: cannot write the memory: No such file .*writable directory"):
        store.write(OLD)


def test_it_can_be_caught_as_the_error_of_the_system_that_it_is(tmp_path):
    with pytest.raises(OSError, match=r"cannot read the memory: (Is a directory|Permission denied)"):
        FileStore(tmp_path).read()


@pytest.mark.posix
def test_an_irregular_file_is_refused_and_not_waited_for(tmp_path):
    """To open a FIFO is to wait for its other end."""
    os.mkfifo(tmp_path / "x.eeprom")
    store = FileStore(tmp_path / "x.eeprom")
    for call in (store.read, lambda: store.write(NEW)):
        with pytest.raises(StoreError, match="is not a regular file"):
            call()


@pytest.mark.posix
def test_a_fifo_in_the_place_of_the_neighbour_is_replaced(tmp_path):
    os.mkfifo(tmp_path / ".x.eeprom.part")
    FileStore(tmp_path / "x.eeprom").write(NEW)
    assert [path.name for path in tmp_path.iterdir()] == ["x.eeprom"]


@pytest.mark.posix
@pytest.mark.parametrize("call", [FileStore.write, FileStore.append])
@pytest.mark.parametrize("there", [True, False])
def test_a_link_in_the_place_of_the_neighbour_is_not_followed(tmp_path, call, there):
    victim = tmp_path / "victim"
    if there:
        victim.write_bytes(OLD)
    (tmp_path / ".x.eeprom.part").symlink_to(victim)
    store = FileStore(tmp_path / "x.eeprom")
    call(store, NEW)
    assert store.read() == NEW
    assert not store.path.is_symlink()
    assert victim.exists() is there
    assert not there or victim.read_bytes() == OLD


def test_a_file_put_in_the_place_of_the_neighbour_at_the_last_moment_is_not_opened():
    disk, victim = disk_with(OLD), File(OLD)

    def schedule(number, call):
        if disk.calls[-2:] == ["unlink", "open"]:
            disk.names[PATH.with_name(".x.eeprom.part")] = victim

    disk.trouble = schedule
    with pytest.raises(StoreError, match="file exists"):
        FileStore(PATH, disk).write(NEW)
    assert (victim.data, disk.names[PATH].data) == (OLD, packed(OLD))


@pytest.mark.posix
def test_a_link_in_the_place_of_the_memory_is_refused(tmp_path):
    other = FileStore(tmp_path / "other")
    other.write(OLD)
    (tmp_path / "x.eeprom").symlink_to(other.path)
    store = FileStore(tmp_path / "x.eeprom")
    for call in (store.read, lambda: store.write(NEW), lambda: store.append(NEW)):
        with pytest.raises(StoreError, match=r"is a symbolic link; name the file itself"):
            call()
    assert other.read() == OLD


@pytest.mark.posix
def test_a_link_that_comes_between_two_records_is_not_followed(tmp_path):
    store, other = FileStore(tmp_path / "x.eeprom"), tmp_path / "other"
    store.append(OLD)
    store.path.rename(other)
    before = other.read_bytes()
    store.path.symlink_to(other)
    with pytest.raises(StoreError):
        store.append(NEW)
    assert other.read_bytes() == before


def test_a_file_too_long_for_a_memory_is_not_read(tmp_path):
    store = FileStore(tmp_path / "x.eeprom")
    store.append(OLD)
    os.truncate(store.path, 10_000_000_000)
    with pytest.raises(StoreError, match="more than 16777216 bytes, which no memory has"):
        store.read()


@pytest.mark.usefixtures("no_sync")
def test_records_do_not_make_a_file_that_cannot_be_read(tmp_path, monkeypatch):
    monkeypatch.setattr(store_module, "LARGEST", 5000)
    store = FileStore(tmp_path / "x.eeprom")
    for at in range(100):
        store.append(bytes([at]) * 2000, 0)
    assert store.path.stat().st_size <= 5000
    assert FileStore(store.path).read() == bytes([99]) * 2000
    with pytest.raises(StoreError, match="more than 5000 bytes"):
        store.append(bytes(5000), 0)
    assert FileStore(store.path).read() == bytes([99]) * 2000


# ------------------------------------------------------------------------------------------------- added to real files
@pytest.mark.usefixtures("no_sync")
@pytest.mark.parametrize("kind", [FileStore, lambda path: Memory()])
def test_a_memory_of_any_kind_is_what_was_put_into_it(kind, tmp_path):
    random, wanted = Random(5), bytearray()
    store = kind(tmp_path / "x.ram")
    for _ in range(150):
        data, at = random.randbytes(random.choice((0, 1, 1, 30))), random.choice((None, random.randint(0, len(wanted))))
        if random.random() < 0.01:
            wanted = bytearray(data)
            store.write(data)
        else:
            store.append(data, at)
            at = len(wanted) if at is None else at
            wanted[at : at + len(data)] = data
        assert store.read() == wanted
    if kind is FileStore:
        assert FileStore(store.path).read() == wanted


@pytest.mark.parametrize("kind", [FileStore, lambda path: Memory()])
def test_a_hole_is_refused(kind, tmp_path):
    store = kind(tmp_path / "x.ram")
    store.append(b"ab")
    for at in (3, -1):
        with pytest.raises(UsageError, match=f"append at {at}: the memory has 2 bytes; allowed 0 to 2"):
            store.append(b"c", at)
    store.append(b"c", 2)
    assert store.read() == b"abc"


def test_the_file_does_not_grow_without_end():
    disk = Disk({})
    store = FileStore(PATH, disk)
    store.write(bytes(1000))
    sizes = []
    for n in range(6000):
        store.append(b"%d" % (n % 10), n % 1000)
        sizes.append(len(disk.names[PATH].data))
    assert max(sizes) <= 1000 + HEADER.size + (1 << 14)
    assert sum(later < size for size, later in pairwise(sizes)) <= 6
    assert FileStore(PATH, disk).read() == bytes(ord("0") + n % 10 for n in range(1000))


@pytest.mark.usefixtures("no_sync")
def test_part_of_a_record_at_the_end_is_dropped_and_damage_before_a_complete_one_is_reported(store):
    store.write(LARGE)
    store.append(b"one", 0)
    begin = store.path.stat().st_size
    store.append(b"two", 1)
    middle = store.path.stat().st_size
    store.append(b"three", 5)
    good = store.path.read_bytes()
    with_two = b"otwo" + LARGE[4:5]
    for n in range(middle, len(good)):
        store.path.write_bytes(good[:n])
        assert FileStore(store.path).read()[:10] == with_two + LARGE[5:10]
    for n in range(middle, len(good)):
        store.path.write_bytes(good[:n] + bytes([good[n] ^ 4]) + good[n + 1 :])
        assert FileStore(store.path).read()[:10] == with_two + LARGE[5:10]
    for n in (*range(len(MAGIC), HEADER.size + 3), begin - 1, *range(begin, middle)):
        store.path.write_bytes(good[:n] + bytes([good[n] ^ 4]) + good[n + 1 :])
        with pytest.raises(StoreError, match="damaged"):
            FileStore(store.path).read()
        with pytest.raises(StoreError, match="damaged"):
            FileStore(store.path).append(b"x")
    store.path.write_bytes(good + bytes(40))  # a file system that makes a file longer before it has its data
    assert FileStore(store.path).read()[:10] == with_two + b"three"


def test_a_file_that_is_removed_or_changed_by_another_program_is_rewritten_or_refused(store):
    store.write(LARGE)
    store.append(b"one", 0)
    store.path.unlink()
    store.append(b"two", 3)
    assert store.read()[:6] == b"onetwo"
    FileStore(store.path).append(b"of another")
    store.append(b"six", 6)
    assert store.read() == b"onetwosix" + LARGE[9:]
    store.path.write_text("Dear Sir or Madam")
    with pytest.raises(StoreError, match="not a slewline memory"):
        store.append(b"x")
    assert store.path.read_text() == "Dear Sir or Madam"


KILLED = """
import sys
from slewline.links.lines.memory_file import FileStore
store = FileStore(sys.argv[1])
n = len(store.read())
while True:
    store.append(b"%c" % (n % 251))
    n += 1
    print(n, flush=True)
"""


@pytest.mark.real("kill")
def test_a_process_that_is_killed_while_it_appends_loses_nothing_that_it_has_answered(tmp_path):
    path, answered = tmp_path / "x.ram", 0
    for lines in (1, 30, 300, 7):
        with subprocess.Popen([sys.executable, "-c", KILLED, path], stdout=subprocess.PIPE) as process:
            for _ in range(lines):
                answered = int(process.stdout.readline())
            process.kill()
            answered = max([answered, *(int(line) for line in process.stdout.read().split(b"\n")[:-1])])
        found = FileStore(path).read()
        assert len(found) in (answered, answered + 1)
        assert found == bytes(n % 251 for n in range(len(found)))
