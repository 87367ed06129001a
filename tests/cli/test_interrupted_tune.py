"""A search that a real signal interrupts says what its store has, and the same command resumes from there."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
from pathlib import Path
from time import monotonic, sleep

import pytest

pytestmark = [pytest.mark.system, pytest.mark.posix]
MAIN = "from slewline.cli.main import main; main()"
TUNE = (
    "tune", "cy525", "--motor", "QSH4218-51-10-049", "--driver", "L/4R 20 V", "--load", "inertia 68 g cm2",
    "--steps", "48", "--grid", "F=3..10 R=4..40/12 S=1..250/12", "--perturb", "inertia 20%, current -20%", "--map",
)  # fmt: skip
PATIENCE = 120
AFTER = 60  # runs


def lines(path: Path) -> list[bytes]:
    """The whole lines of a log."""
    return path.read_bytes().splitlines(keepends=True) if path.exists() else []


def begun(folder: Path, *more: str) -> subprocess.Popen[str]:
    return subprocess.Popen([sys.executable, "-c", MAIN, *TUNE, *more], cwd=folder, text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE)  # fmt: skip


def keys(rows: list[bytes]) -> list[tuple[str, str]]:
    return [(each["move"], each["run"]) for each in map(json.loads, rows)]


@pytest.mark.parametrize(("number", "jobs"), [(signal.SIGINT, "1"), (signal.SIGINT, "2"), (signal.SIGTERM, "1")])
def test_the_store_has_the_content_in_the_message_and_the_same_command_resumes(tmp_path, number, jobs):
    store, given = tmp_path / "st.jsonl", ("--jobs", jobs, "--store", "st.jsonl")
    process = begun(tmp_path, *given)
    until = monotonic() + PATIENCE
    while len(lines(store)) <= AFTER and monotonic() < until and process.poll() is None:
        sleep(0.01)
    process.send_signal(number)
    out, err = process.communicate(timeout=PATIENCE)
    kept = lines(store)
    says = re.fullmatch(
        r"\s*slewline: interrupted; st\.jsonl has ([\d,]+) of up to ([\d,]+) runs: "
        r"run the same command again to continue\n",
        err,
    )
    assert (process.returncode, out) == (1, "") and says is not None, err
    has, most = (int(each.replace(",", "")) for each in says.groups())
    assert len(kept) - 1 == has >= AFTER and kept[-1].endswith(b"\n")
    again = begun(tmp_path, *given)
    out, err = again.communicate(timeout=PATIENCE)
    whole = lines(store)
    assert again.returncode == 0 and whole[: len(kept)] == kept
    assert len(set(keys(whole[1:]))) == len(whole) - 1  # no run is made twice
    ran = re.search(r"^runs +(\d+) of (\d+), (\d+) of them now$", out, re.MULTILINE)
    assert ran is not None, out
    runs, all_runs, now = map(int, ran.groups())
    assert (now, runs, all_runs) == (len(whole) - len(kept), len(whole) - 1, most) and 0 < now < runs
