"""Folders for the files of one process: none is left, whatever ends it, and no other one is touched."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys

import pytest

from slewline.temporary import TemporaryFolder

HOLDS = """
import sys, time
from pathlib import Path
from slewline import temporary
temporary.LONGEST, temporary.gettempdir = 1000, lambda: PLACE
with temporary.TemporaryFolder() as folder:
    Path(folder, "journal").write_text("much")
    print(folder, flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def place(tmp_path, monkeypatch):
    """Where temporary files are; sockets in it have short paths."""
    monkeypatch.setattr("slewline.temporary.LONGEST", 1000)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return tmp_path


def test_a_folder_is_gone_when_it_is_left(place):
    with TemporaryFolder() as folder:
        assert os.listdir(place) == [os.path.basename(folder)] and os.stat(folder).st_mode & 0o077 == 0
    assert os.listdir(place) == []


@pytest.mark.system
@pytest.mark.posix
def test_leftovers_of_a_killed_process_and_nothing_else_are_removed_by_the_next_one(place):
    code = HOLDS.replace("PLACE", repr(str(place)))
    started = [
        subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    killed, lives = (process.stdout.readline().strip() for process in started)
    started[0].send_signal(signal.SIGKILL)
    started[0].communicate()
    others = {"slewline-notes", "slewline-link", "slewline-with-a-file"}
    (place / "slewline-notes").mkdir()
    (place / "slewline-link").symlink_to(place / "slewline-notes")
    (place / "slewline-with-a-file").write_text("")
    with TemporaryFolder() as folder:
        assert {*os.listdir(place)} == others | {os.path.basename(lives), os.path.basename(folder)}
        assert not os.path.exists(killed)
        assert os.listdir(lives)
    started[1].communicate("", timeout=60)
    assert {*os.listdir(place)} == others


@pytest.mark.posix
def test_sockets_have_short_paths_wherever_temporary_files_are(tmp_path, monkeypatch):
    long = tmp_path / ("a folder for temporary files" * 5)
    long.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(long))
    with TemporaryFolder() as folder, socket.socket(socket.AF_UNIX) as end:
        end.bind(f"{folder}/branch1000.99")
