"""Going back in one process: what is refused, what becomes of memories, and what it costs.

That the new run is the right one, to the bit, is a law: tests/laws/test_going_back.py.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import slewline
from slewline.bench.past import Past, TooLong, driven
from slewline.core.memory.store import Memory
from slewline.errors import BenchFileError, StoreError, UsageError

MS = 10**9
STRAPS = {"chs": 0, "br0": 0, "br1": 0, "br2": 0}


class Disk(Memory):
    """A store that counts what is written, and refuses while it is `full`."""

    writes = 0
    full = False

    def write(self, data: bytes) -> None:
        if self.full:
            raise StoreError("disk full")
        self.writes += 1
        super().write(data)


def module(folder: Path, disk: Disk) -> slewline.Bench:
    """A module that memorises a program of three steps at 100 ms, and asks for its position at 500 ms."""
    bench = slewline.Bench(journal=folder / "journal")
    x = bench.add("gs-c200s", "x", straps=STRAPS, store=disk)
    host = bench.host(x, name="h")
    host.send("Po\rS50\rT200\rR90\r+3\rPx\r")
    bench.run("100 ms")
    host.send("M\r")
    bench.run("400 ms")
    host.send("V1\r")
    bench.run("50 ms")
    return bench


def power(on: bool, at_ps: int) -> dict[str, Any]:
    return {"do": "power", "t": at_ps, "round": 1, "chip": "x", "on": on}


def test_unchanged_content_is_not_stored_twice(tmp_path: Path) -> None:
    disk = Disk()
    bench = module(tmp_path, disk)
    writes, content = disk.writes, disk.data
    assert b"+" in content or len(content) > 3
    past = Past(bench)
    past.follow(50 * MS)
    new = past.at(60 * MS).rerun([driven("x.ui1", 0, 60 * MS)], bench.now_ps, tmp_path / "copy")
    assert disk.writes == writes  # a bench that is not taken yet has no file
    past.go_on(new)
    assert (disk.writes, disk.data) == (writes, content)
    new["h"].send("Po\r+4\rPx\rM\r")
    new.run("500 ms")
    assert disk.writes > writes and disk.data != content
    again = slewline.replay(tmp_path / "journal")
    assert again["x"].program == new["x"].program and again.now_ps == new.now_ps


def test_a_run_can_go_back_twice_and_before_all_shadows(tmp_path: Path) -> None:
    disk = Disk()
    bench = module(tmp_path, disk)
    past = Past(bench)
    past.follow(50 * MS)
    for at in (60 * MS, 20 * MS):  # the second one is before all shadows
        new = past.at(at).rerun([driven("x.ui1", int(at == 60 * MS), at)], bench.now_ps)
        past.go_on(new, at)
        assert past.bench is new and not (tmp_path / "journal.other").exists()
    entries = [json.loads(line) for line in (tmp_path / "journal").read_text().splitlines()]
    assert [(one["t"], one["level"]) for one in entries if one["do"] == "drive"] == [(20 * MS, 0), (60 * MS, 1)]
    content = disk.data
    new["h"].send("Po\r+4\rPx\rM\r")
    new.run("500 ms")
    assert disk.data != content  # the second one has the file as well
    again = slewline.replay(tmp_path / "journal")
    assert again["x"].program == new["x"].program and again.pin("x.ui1").level == new.pin("x.ui1").level == 1


def test_items_not_stored_by_the_new_run_are_gone(tmp_path: Path) -> None:
    disk = Disk()
    bench = module(tmp_path, disk)
    content = disk.data
    past = Past(bench)
    new = past.at(90 * MS).rerun([power(False, 90 * MS)], bench.now_ps, tmp_path / "copy")
    assert disk.data == content
    past.go_on(new)
    assert disk.data != content


def test_a_disk_that_refuses_leaves_everything_as_it_was(tmp_path: Path) -> None:
    disk = Disk()
    bench = module(tmp_path, disk)
    content = disk.data
    past = Past(bench)
    new = past.at(90 * MS).rerun([power(False, 90 * MS)], bench.now_ps, tmp_path / "copy")
    disk.full = True
    with pytest.raises(StoreError):
        past.go_on(new)
    disk.full = False
    assert disk.data == content
    bench["h"].send("Po\r+4\rPx\rM\r")
    bench.run("500 ms")
    assert disk.data != content
    assert (tmp_path / "copy").exists() and bench.journal is not None


def test_a_write_that_the_disk_has_refused_is_refused_again(tmp_path: Path) -> None:
    disk = Disk()
    bench = slewline.Bench(journal=tmp_path / "journal")
    x = bench.add("gs-c200s", "x", straps=STRAPS, store=disk)
    host = bench.host(x, name="h")
    host.send("Po\rS50\rT200\rR90\r+3\rPx\r")
    bench.run("100 ms")
    disk.full = True
    host.send("M\r")
    bench.run("400 ms")
    disk.full = False
    heard = bytes(host.received)
    past = Past(bench)
    past.follow(90 * MS)  # the fault comes after that
    new = past.at(95 * MS).rerun([driven("x.ui1", 0, 95 * MS)], bench.now_ps, tmp_path / "copy")
    assert bytes(new["h"].received) == heard and b"E" in heard
    past.go_on(new)
    new["h"].send("M\r")
    new.run("400 ms")
    assert new["h"].received.endswith(b"Y\r")
    assert slewline.replay(tmp_path / "journal")["h"].received == new["h"].received


def test_inputs_that_are_impossible_now_are_refused_with_their_line(tmp_path: Path) -> None:
    bench = slewline.Bench(journal=tmp_path / "journal")
    bench.add("cy525", "x")
    bench.run("10 ms")
    bench.part("motor", "m", to="x")
    bench.run("10 ms")
    past = Past(bench)
    past.follow(4 * MS)
    part = {"do": "part", "t": 5 * MS, "round": 1, "kind": "motor", "name": "m", "to": None, "options": {}}
    with pytest.raises(BenchFileError, match=r"copy, line 5: the bench has a 'm' already"):
        past.at(5 * MS).rerun([part], bench.now_ps, tmp_path / "copy")
    assert not (tmp_path / "copy").exists()
    with pytest.raises(BenchFileError, match=r"x \(cy525\) has no pin 'abrot'.*did you mean"):
        past.at(5 * MS).rerun([driven("x.abrot", 0, 5 * MS)], bench.now_ps, tmp_path / "copy")
    bench.run("1 ms")
    new = past.at(5 * MS).rerun([driven("x.abort", 0, 5 * MS)], bench.now_ps, tmp_path / "copy")
    assert new.pin("x.abort").level == 0 and bench.pin("x.abort").level == 1


@pytest.mark.parametrize("at", [0, 21 * MS])
def test_only_the_past_can_be_gone_back_to(at: int, tmp_path: Path) -> None:
    bench = slewline.Bench(journal=tmp_path / "journal")
    bench.add("cy525", "x")
    bench.run("20 ms")
    past = Past(bench)
    with pytest.raises(UsageError, match="allowed: later than 0, up to 20 ms"):
        past.at(at).rerun([driven("x.abort", 0, at)], bench.now_ps, tmp_path / "copy")
    with pytest.raises(UsageError, match="no input"):
        past.at(MS).rerun([], bench.now_ps, tmp_path / "copy")
    (tmp_path / "mine").write_text("a letter")
    with pytest.raises(BenchFileError, match="is not a journal"):
        past.at(MS).rerun([driven("x.abort", 0, MS)], bench.now_ps, tmp_path / "mine")
    assert (tmp_path / "mine").read_text() == "a letter"


def test_a_rewind_that_would_take_too_long_is_refused_before_it_begins(tmp_path: Path) -> None:
    bench = slewline.Bench(journal=tmp_path / "journal")
    host = bench.host(bench.add("cy525", "x"), name="h")
    for _ in range(100):
        host.send("B\r")
        bench.run("10 ms")
    past = Past(bench, shadows=1)
    past.entry_s = 0.01
    with pytest.raises(TooLong, match=r"203 inputs \(\d{5} bytes of journal\).*about 2\.030 s; allowed 1\.000 s"):
        past.at(900 * MS).rerun([driven("x.abort", 0, 900 * MS)], bench.now_ps, tmp_path / "copy", allowed_s=1)
    calls = 0

    def enough() -> bool:
        nonlocal calls
        calls += 1
        return calls % 50 == 0

    turns = 1
    while not past.follow(890 * MS, enough):
        turns += 1
    assert turns == 4 and past.since_ps == 890 * MS
    with pytest.raises(TooLong, match=r" 2\d inputs .*allowed 0\.000 s"):
        past.at(900 * MS).rerun([driven("x.abort", 0, 900 * MS)], bench.now_ps, tmp_path / "copy", allowed_s=0)
    new = past.at(900 * MS).rerun([driven("x.abort", 0, 900 * MS)], bench.now_ps, tmp_path / "copy", allowed_s=1)
    assert new.pin("x.abort").level == 0
    assert past.since_ps == -1  # there was one shadow alone
    past.follow(890 * MS)
    assert past.since_ps == 890 * MS
