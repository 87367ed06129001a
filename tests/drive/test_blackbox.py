"""The black box: a journal that is replayed, and the bytes of the line."""

from __future__ import annotations

import subprocess
import sys

import pytest

import slewline
from slewline.drive.blackbox import JOURNAL, KEPT_SESSIONS, BlackBox, new_folder, read_line
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


def test_only_the_newest_sessions_are_kept(tmp_path):
    for number in range(KEPT_SESSIONS + 5):
        (tmp_path / f"2020-01-01-0000{number:02}").mkdir()
    (tmp_path / "mine").mkdir()
    folder = new_folder(tmp_path)
    left = sorted(path.name for path in tmp_path.iterdir())
    assert folder.name in left and "mine" in left and len(left) == KEPT_SESSIONS + 1
    assert "2020-01-01-000000" not in left
    assert new_folder(tmp_path) != folder


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
