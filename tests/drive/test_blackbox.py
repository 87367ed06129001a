"""The black box: a journal that is replayed, and the bytes of the line."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

import slewline
from slewline.drive.blackbox import JOURNAL, KEPT_SESSIONS, MARK, MARK_TEXT, BlackBox, new_folder, read_line
from slewline.drive.board.wire import Decoder, FrameKind
from slewline.errors import UsageError

from .families import furnished
from .rig import MS_NS, TwinLine, drive_of


def test_it_has_every_byte_of_the_line_with_its_times(tmp_path):
    bench, x, _, _ = furnished("cy525 five steps")
    line = TwinLine()
    with drive_of(bench, x, line, black_box=tmp_path) as drive:
        drive.run_until_rest()
        folder = drive.port.folder
    assert folder == tmp_path
    rows = read_line(folder)
    assert [row[0] for row in rows] == sorted(row[0] for row in rows)
    sent = b"".join(data for *_, way, data in rows if way == ">")
    kinds = [frame.kind for frame in Decoder().feed(sent)]
    assert kinds[0] == FrameKind.HELLO and kinds.count(FrameKind.START) == 1 and FrameKind.PUSH in kinds
    heard = b"".join(data for *_, way, data in rows if way == "<")
    kinds = [frame.kind for frame in Decoder().feed(heard)]
    assert FrameKind.IDENT in kinds and FrameKind.EVENT in kinds
    assert 0 < rows[-1][1] <= line.twin.now


@pytest.mark.system
def test_a_replay_of_its_journal_makes_the_same_steps_findings_and_positions(tmp_path):
    bench, x, host, _ = furnished("cy525 top", journal=tmp_path / JOURNAL)
    line = TwinLine()
    with drive_of(bench, x, line) as drive:
        drive.run("700 ms")
        line.pass_to(line.now + 500 * MS_NS)
        drive.run("500 ms")
        assert drive.state == "halted"
        drive.clear()
        drive.run("100 ms")
        host.send("N 100\rG\r")
        drive.run_until_rest()
    again = slewline.replay(tmp_path / JOURNAL)
    assert again["x"].steps() == x.steps()
    assert again["x"].position == x.position == len(line.twin.steps)
    assert [str(each) for each in again.findings] == [str(each) for each in bench.findings]
    assert len(bench.findings) >= 2
    shown = subprocess.run(
        [sys.executable, "-m", "slewline", "run", "--replay", tmp_path / JOURNAL],
        capture_output=True,
        text=True,
        check=False,
    )
    assert "position-taken-over" in shown.stdout + shown.stderr, shown


def test_the_line_is_a_ring_of_bounded_size(tmp_path):
    class Quiet:
        """A port that says one byte a read."""

        name = "quiet"

        def read(self):
            return b"\x55"

        def write(self, data):
            return len(data)

        def fileno(self):
            return None

        def close(self):
            pass

    ns = [0]

    def clock():
        ns[0] += 1
        return ns[0]

    box = BlackBox(Quiet(), tmp_path, clock, lambda ns: 16 * ns, most=1000)
    for number in range(500):
        box.write(number.to_bytes(2, "big"))
        box.read()
    box.close()
    assert sum(path.stat().st_size for path in tmp_path.iterdir()) < 2200
    rows = [row for row in read_line(tmp_path) if row[2] == ">"]
    numbers = [int.from_bytes(row[3], "big") for row in rows]
    assert numbers == list(range(numbers[0], 500)) and len(numbers) > 8


def sessions(place, monkeypatch, count):
    """Make the folders of sessions, each with its files."""
    for number in range(count):
        monkeypatch.setattr("slewline.drive.blackbox.strftime", lambda _form, at=number: f"2020-01-01-0000{at:02}")
        folder = new_folder(place)
        for name in (JOURNAL, "line.0.jsonl", "line.1.jsonl"):
            (folder / name).write_text("{}\n")


def test_only_the_newest_sessions_are_kept(tmp_path, monkeypatch):
    sessions(tmp_path, monkeypatch, KEPT_SESSIONS + 5)
    left = sorted(path.name for path in tmp_path.iterdir())
    assert left == [f"2020-01-01-0000{number:02}" for number in range(5, KEPT_SESSIONS + 5)]
    assert new_folder(tmp_path) != new_folder(tmp_path)


def measurements(place, number):
    """Make a folder as loggers of measurements do."""
    folder = place / f"2020-01-01-0000{number:02}-my measurements"
    folder.mkdir()
    (folder / "data.csv").write_text("1,2\n")
    return folder


def measurements_with_a_mark_of_ours(place, number):
    """Make a folder with measurements and a file that is called as the mark is."""
    folder = measurements(place, number)
    (folder / MARK).write_bytes(MARK_TEXT)
    return folder


def empty(place, number):
    """Make an empty folder."""
    folder = place / f"2020-01-01-0000{number:02}"
    folder.mkdir()
    return folder


def of_a_session_without_a_mark(place, number):
    """Make a folder with the files of a session, which `new_folder` has not made."""
    folder = empty(place, number)
    (folder / JOURNAL).write_text("{}\n")
    return folder


def with_another_mark(place, number):
    """Make a folder with a mark that is not ours."""
    folder = empty(place, number)
    (folder / MARK).write_text("by hand\n")
    return folder


def a_link_to_a_session(place, number):
    """Make a link to a folder that is as one of ours."""
    other = place / "elsewhere" / str(number)
    other.mkdir(parents=True)
    (other / MARK).write_bytes(MARK_TEXT)
    link = place / f"2020-01-01-0000{number:02}"
    link.symlink_to(other)
    return link


FOREIGN = [
    measurements, measurements_with_a_mark_of_ours, empty, of_a_session_without_a_mark, with_another_mark,
    a_link_to_a_session,
]  # fmt: skip


@pytest.mark.parametrize("make", FOREIGN)
def test_it_removes_only_its_own_folders(tmp_path, monkeypatch, make):
    made = [make(tmp_path, number) for number in range(30)]
    before = sorted(path for path in tmp_path.rglob("*"))
    monkeypatch.setattr("slewline.drive.blackbox.strftime", lambda _form: "2030-01-01-000000")
    for _ in range(KEPT_SESSIONS + 2):
        new_folder(tmp_path)
    assert all(path.exists() for path in before) and len(made) == 30
    own = [path for path in tmp_path.iterdir() if path.name.startswith("2030")]
    assert len(own) == KEPT_SESSIONS


def test_without_a_home_a_folder_is_requested(monkeypatch):
    def nowhere():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_STATE_HOME", raising=False)
    monkeypatch.setattr("slewline.folders.Path.home", nowhere)
    with pytest.raises(UsageError, match=r"set HOME or \w+, or give a folder \(--black-box DIR\)"):
        new_folder()


DAMAGED = [
    b"\xff\xfe\n", b"[]\n", b"{}\n", b"3\n", b"not JSON\n", b"[" * 100_000 + b"\n",
    *(json.dumps({"ns": 1, "tick": 2, "way": ">", "data": "00"} | wrong).encode() + b"\n" for wrong in (
        {"ns": "x"}, {"tick": None}, {"ns": 1.5}, {"way": "!"}, {"way": []}, {"data": "0"}, {"data": 3}, {"data": None},
    )),
    b'{"ns":1e999,"tick":1,"way":">","data":""}\n',
]  # fmt: skip


def test_a_damaged_line_is_reported_with_its_number(tmp_path, subtests):
    good = b'{"ns":1,"tick":2,"way":">","data":"00"}\n'
    for line in DAMAGED:
        with subtests.test(line[:40]):
            (tmp_path / "line.0.jsonl").write_bytes(good + line + good)
            with pytest.raises(UsageError, match=r"line\.0\.jsonl, line 2: found .*; remove the line"):
                read_line(tmp_path)


def test_a_line_that_was_cut_off_is_left_out(tmp_path):
    good = b'{"ns":1,"tick":2,"way":">","data":"00"}\n'
    (tmp_path / "line.0.jsonl").write_bytes(good + good[:-9])
    assert read_line(tmp_path) == [(1, 2, ">", b"\0")]


def test_a_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match="give a folder that can be written"):
        new_folder(tmp_path / "file")
    with pytest.raises(UsageError, match="has no black box"):
        read_line(tmp_path)


def test_a_disk_that_is_full_ends_the_record_and_not_the_drive(tmp_path):
    bench, x, _, _ = furnished("cy525 five steps")
    line = TwinLine()
    with drive_of(bench, x, line, black_box=tmp_path) as drive:

        class Full:
            """A file that takes nothing."""

            def write(self, _text):
                raise OSError(28, "No space left on device")

            def close(self):
                pass

        drive.port._file.close()
        drive.port._file = Full()
        drive.run_until_rest()
        assert "No space left" in drive.port.failure
    assert len(line.twin.steps) == 5
