"""CSV and NPZ, and files that are whole or not there."""

from __future__ import annotations

import os
import stat
import warnings
from pathlib import Path

import numpy as np
import pytest

from slewline.core.motion.axis import Steps
from slewline.errors import NotRecorded, UsageError
from slewline.record import whole_file
from slewline.record.recording.export_csv import save_edges, save_steps
from slewline.record.recording.export_npz import edge_columns, save_npz
from slewline.record.whole_file import WholeFile


def steps(*rows: tuple[int, int, int]) -> Steps:
    times, signs, positions = zip(*rows, strict=True) if rows else ((), (), ())
    return Steps(np.array(times, np.int64), np.array(signs, np.int8), np.array(positions, np.int64))


def two_nets(rig):
    for net in (rig.net("y.wait", pull=1), rig.bus("x.db"), rig.net("a,b")):
        rig.recorder.record(net)
    rig.on(7, y_wait=0, x_db=(255, 200), **{"a,b": 1})
    rig.on(9, x_db=None)
    rig.on(11, **{"a,b": None})
    rig.kernel.run(20)
    return rig


def test_edges_by_time_then_name(rig, tmp_path):
    two_nets(rig)
    save_edges(tmp_path / "e.csv", rig.nets, rig.recorder, 0, 1 << 62)
    expected = b'time_ps,net,level\n7,"a,b",1\n7,x.db,200\n7,y.wait,0\n9,x.db,z\n11,"a,b",z\n'
    assert (tmp_path / "e.csv").read_bytes() == expected
    save_edges(tmp_path / "e.csv", rig.nets, rig.recorder, 8, 9)
    assert (tmp_path / "e.csv").read_bytes() == b"time_ps,net,level\n9,x.db,z\n"
    save_edges(tmp_path / "e.csv", {}, rig.recorder, 0, 9)
    assert (tmp_path / "e.csv").read_bytes() == b"time_ps,net,level\n"


def test_edges_in_pieces_are_all_there(lively, tmp_path, monkeypatch):
    rig = lively(2, events=100)
    rig.kernel.run(80_000_000)
    save_edges(tmp_path / "a.csv", rig.nets, rig.recorder, 0, 80_000_000)
    monkeypatch.setattr("slewline.record.recording.recorder.FIRST_CHUNK_PS", 1_000_000)
    monkeypatch.setattr("slewline.record.recording.recorder.CHUNK_EDGES", 4)
    save_edges(tmp_path / "b.csv", rig.nets, rig.recorder, 0, 80_000_000)
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    lines = (tmp_path / "a.csv").read_text().splitlines()[1:]
    rows = sorted((t, name, "z" if v < 0 else str(v)) for name in rig.nets for t, v in rig.edges(name))
    assert [f"{t},{name},{v}" for t, name, v in rows] == lines
    assert len(lines) > 100


def test_steps_by_time_then_chip_and_axis(tmp_path, monkeypatch):
    monkeypatch.setattr("slewline.record.recording.export_csv.ROWS", 2)
    rows = [
        ("y", 1, steps((5, -1, 65535), (9, -1, 65534))),
        ("x", 2, steps((5, 1, 1), (6, 1, 2))),
        ("x", 1, steps((5, 1, 41))),
        ("z", 1, steps()),
    ]
    save_steps(tmp_path / "s.csv", rows)
    assert (tmp_path / "s.csv").read_bytes() == (
        b"time_ps,chip,axis,direction,position\n5,x,1,1,41\n5,x,2,1,1\n5,y,1,-1,65535\n6,x,2,1,2\n9,y,1,-1,65534\n"
    )
    for nothing in ([], [("z", 1, steps())]):
        save_steps(tmp_path / "s.csv", nothing)
        assert (tmp_path / "s.csv").read_bytes() == b"time_ps,chip,axis,direction,position\n"


def test_npz_columns(rig, tmp_path):
    two_nets(rig)
    columns = edge_columns({"y.wait": rig.nets["y.wait"], "x.db": rig.nets["x.db"]}, rig.recorder, 0, 20)
    for name in ("a.npz", "b.npz"):
        save_npz(tmp_path / name, columns)
    loaded = np.load(tmp_path / "a.npz")
    assert {name: (loaded[name].dtype, loaded[name].tolist()) for name in loaded.files} == {
        "y.wait.times_ps": (np.int64, [7]),
        "y.wait.levels": (np.int8, [0]),
        "x.db.times_ps": (np.int64, [7, 9]),
        "x.db.levels": (np.int16, [200, -1]),
    }
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_errors_leave_nothing(rig, tmp_path):
    rig.net("x.slew")
    for write in (
        lambda path: save_edges(path, rig.nets, rig.recorder, 0, 9),
        lambda path: save_npz(path, edge_columns(rig.nets, rig.recorder, 0, 9)),
    ):
        with pytest.raises(NotRecorded):
            write(tmp_path / "a")
    for write in (
        lambda path: save_edges(path, {}, rig.recorder, 0, 9),
        lambda path: save_npz(path, {}),
        lambda path: save_steps(path, []),
    ):
        with pytest.raises(UsageError, match="is a directory"):
            write(tmp_path)
    assert list(tmp_path.iterdir()) == []


# --------------------------------------------------------------------------------------------------------- WholeFile
def test_file_appears_when_it_is_whole(tmp_path):
    path = tmp_path / "a"
    path.write_text("old")
    with WholeFile(path) as file:
        file.write(b"new")
        assert path.read_text() == "old"
        assert len(list(tmp_path.iterdir())) == 2
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]
    file.close()
    file.discard()
    assert path.read_text() == "new"


def test_block_that_raises_leaves_the_old_file(tmp_path):
    path = tmp_path / "a"
    path.write_text("old")
    with pytest.raises(ZeroDivisionError), WholeFile(path) as file:
        file.write(b"new")
        raise ZeroDivisionError
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_two_writers_do_not_meet(tmp_path):
    with WholeFile(tmp_path / "a") as first, WholeFile(tmp_path / "a") as second:
        first.write(b"first")
        second.write(b"second")
    assert (tmp_path / "a").read_bytes() == b"first"  # the last to end wins, whole
    assert len(list(tmp_path.iterdir())) == 1


def test_link_stays_a_link(tmp_path):
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to("real")
    with WholeFile(tmp_path / "link") as file:
        file.write(b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text() == "new"


def test_own_name_must_not_be_a_link(tmp_path):
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to("real")
    with pytest.raises(
        UsageError, match=r"link is a symbolic link, which is not followed here; move it away, or use another folder"
    ):
        WholeFile(tmp_path / "link", own=True)
    assert (tmp_path / "real").read_text() == "old"


def test_link_in_the_place_of_the_neighbour_is_left_alone(tmp_path, monkeypatch):
    monkeypatch.setattr(whole_file, "_NUMBERS", iter([1, 2]))
    planted = tmp_path / f".slewline-{os.getpid()}-1.part"
    planted.symlink_to(tmp_path / "victim")
    with WholeFile(tmp_path / "a") as file:
        file.write(b"new")
    assert (tmp_path / "a").read_bytes() == b"new"
    assert planted.is_symlink()
    assert not (tmp_path / "victim").exists()


def test_file_has_the_usual_rights(tmp_path):
    with WholeFile(tmp_path / "a"):
        pass
    (tmp_path / "b").touch()
    assert os.stat(tmp_path / "a").st_mode == os.stat(tmp_path / "b").st_mode


@pytest.mark.posix
@pytest.mark.parametrize("mode", [0o600, 0o640, 0o4755, 0o444])
def test_a_file_that_is_replaced_passes_its_mode_on_and_nobody_reads_it_meanwhile(tmp_path, mode):
    (tmp_path / "a").write_text("old")
    (tmp_path / "a").chmod(mode)
    file = WholeFile(tmp_path / "a")
    assert stat.S_IMODE(os.stat(file.part).st_mode) == mode
    file.write(b"new")
    file.close()
    assert (tmp_path / "a").read_bytes() == b"new"
    assert stat.S_IMODE(os.stat(tmp_path / "a").st_mode) == mode


class Owned:
    """A result of os.stat with another owner."""

    def __init__(self, found, uid, gid):
        self.st_mode, self.st_uid, self.st_gid = found.st_mode, uid, gid


@pytest.mark.posix
@pytest.mark.parametrize("permitted", [True, False])
def test_a_file_that_is_replaced_keeps_its_owner_or_that_is_reported(tmp_path, monkeypatch, recwarn, permitted):
    """Of two users there is one here: what the system says of owners is made up."""
    path, owners = tmp_path / "a", {"a": (4001, 4002)}
    path.write_text("old")
    path.chmod(0o6640)
    real = Path.stat

    def chown(part, uid, gid):
        if not permitted:
            raise PermissionError(1, "Operation not permitted")
        owners[part.name] = uid, gid
        os.chmod(part, 0o644)  # as the system does

    def differences(self, **more):
        return Owned(real(self, **more), *owners.get(self.name, (1, 1)))

    monkeypatch.setattr(os, "chown", chown)
    warnings.simplefilter("always")
    file = WholeFile(path)
    with monkeypatch.context() as patch:
        patch.setattr(Path, "stat", differences)
        file._kept_owner = file._take_over(file.part)
    file.close()
    assert stat.S_IMODE(os.stat(path).st_mode) == (0o6640 if permitted else 0o640)
    says = [str(each.message) for each in recwarn]
    assert says == ([] if permitted else [f"{path}: could not keep its owner and group; it now has yours"])
    assert not permitted or owners[file.part.name] == (4001, 4002)


def test_an_interrupt_while_its_neighbour_is_made_leaves_nothing(tmp_path, monkeypatch):
    """A disk may take milliseconds to make a file, in which a signal comes."""

    def interrupted(_file):
        raise KeyboardInterrupt

    monkeypatch.setattr("slewline.record.whole_file.lock", interrupted)
    with pytest.raises(KeyboardInterrupt):
        WholeFile(tmp_path / "one.vcd")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.posix
def test_leftovers_of_a_killed_process_are_removed_and_files_being_written_are_not(tmp_path):
    for name in (".slewline-4000000-7.part", ".slewline-x-7.part", ".slewline-4000000-7.parts", "slewline-1-1.part"):
        (tmp_path / name).write_text("dead")
    (tmp_path / ".slewline-1-1.part").symlink_to("slewline-1-1.part")
    one, other = WholeFile(tmp_path / "a"), WholeFile(tmp_path / "b")
    for file in (one, other):
        file.write(b"whole")
        file.close()
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        ".slewline-1-1.part",
        ".slewline-4000000-7.parts",
        ".slewline-x-7.part",
        "a",
        "b",
        "slewline-1-1.part",
    ]


@pytest.mark.posix
def test_a_durable_file_is_on_the_disk_before_its_name_is(tmp_path, monkeypatch):
    done = []
    for name in ("fsync", "replace"):
        real = getattr(os, name)
        monkeypatch.setattr(os, name, lambda *words, name=name, real=real: (done.append(name), real(*words)))
    for durable in (False, True):
        with WholeFile(tmp_path / "a", durable=durable) as file:
            file.write(b"whole")
    assert done == ["replace", "fsync", "replace", "fsync"]


@pytest.mark.posix
def test_an_irregular_file_is_written_in_place(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    with WholeFile(tmp_path / "pipe") as file:
        file.write(b"hello")
    assert os.read(reader, 9) == b"hello"
    os.close(reader)
    assert (tmp_path / "pipe").is_fifo()
    with WholeFile("/dev/null") as file:
        file.write(b"away")
    assert os.path.exists("/dev/null")
    assert not os.path.isfile("/dev/null")


def test_full_disk_is_reported_and_leaves_nothing():
    with (
        pytest.raises(UsageError, match="/dev/full cannot be written: No space left on device"),
        WholeFile("/dev/full") as file,
    ):
        file.write(b"x" * 1_000_000)
    with pytest.raises(UsageError, match="No space left"), WholeFile("/dev/full") as file:
        file.write(b"x")  # the system says so only when the file is closed
