"""The frame of the tests: what a run inherits, what it leaves, and which tests may start processes and terminals."""

from __future__ import annotations

import ast
import json
import os
import re
import signal
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from tests.sources import tree

ROOT = Path(__file__).parents[2]
KINDS = ("pty", "socket", "kill", "emulator", "process")  # of `real`
CONFTEST = """
from tests.conftest import (
    pytest_configure,
    pytest_runtest_protocol,
    pytest_sessionfinish,
    pytest_terminal_summary,
    pytest_testnodedown,
)
"""
IMPORTS = "import os, pathlib, pytest, signal, subprocess, sys, tempfile, time\n"


# --------------------------------------------------------------------------------------------------------------- marks
def reals(path: Path) -> list[str]:
    """The kinds for which tests of a file are marked."""
    calls = (node for node in ast.walk(tree(path)) if isinstance(node, ast.Call))
    return [ast.literal_eval(call.args[0]) for call in calls if ast.unparse(call.func) == "pytest.mark.real"]


def test_one_test_of_each_kind_starts_processes_and_terminals_in_every_run() -> None:
    files = [path for path in sorted((ROOT / "tests").rglob("*.py")) if "mark.real(" in path.read_text("utf-8")]
    found = {str(path): reals(path) for path in files if path != Path(__file__)}
    assert Counter(kind for kinds in found.values() for kind in kinds) == dict.fromkeys(KINDS, 1)
    command = [sys.executable, "-m", "pytest", "-o", "addopts=", "-q", "--collect-only", "-m", "real", *found]
    collected = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert collected.count("::") == len(KINDS), "a mark is on several tests, or on none"


# ------------------------------------------------------------------------------------------------------- runs of tests
class Run:
    """A file of tests, run in a process of its own with the frame of these tests."""

    def __init__(self, folder: Path, code: str, *options: str) -> None:
        (folder / "conftest.py").write_text(CONFTEST)
        (folder / "test_it.py").write_text(IMPORTS + code)
        command = [sys.executable, "-m", "pytest", "-c", str(ROOT / "pyproject.toml"), "--rootdir", str(folder)]
        command += ["-o", "addopts=", "-p", "no:cacheprovider", "-rA", "--strict-markers", *options, str(folder)]
        environment = os.environ | {"TMPDIR": str(folder)}
        ran = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
        self.status, self.out = ran.returncode, ran.stdout
        self.left = re.findall(r"^left by the tests: (.*)", self.out, re.MULTILINE)
        self.kept = list(folder.glob("slewline-tests-*"))

    def outcomes(self) -> dict[str, str]:
        """How each test has ended."""
        return {name: end for end, name in re.findall(r"^(PASSED|FAILED) \S*::(\w+)", self.out, re.MULTILINE)}


STARTS = """
def starts():
    subprocess.run([sys.executable, "-c", ""], check=True)

def forks():
    if not (child := os.fork()):
        os._exit(0)
    os.waitpid(child, 0)

def opens():
    for each in os.openpty():
        os.close(each)

def test_a_process():
    starts()

def test_a_fork():
    forks()

def test_a_terminal():
    opens()

@pytest.mark.system
def test_system():
    starts(), forks(), opens()

@pytest.mark.real("process")
def test_real():
    starts(), forks(), opens()

def test_nothing():
    pass
"""


@pytest.mark.posix
def test_a_test_without_a_mark_starts_no_process_and_no_terminal(tmp_path: Path) -> None:
    run = Run(tmp_path, STARTS)
    refused = dict.fromkeys(("test_a_process", "test_a_fork", "test_a_terminal"), "FAILED")
    assert run.outcomes() == refused | dict.fromkeys(("test_system", "test_real", "test_nothing"), "PASSED")
    for call in ("init", "fork", "openpty"):
        assert f"{call}: `make test` starts no process and no terminal; do without, or mark the test" in run.out
    assert run.status == 1


LEAVES = """
@pytest.mark.system
def test_it():
    pathlib.Path(tempfile.gettempdir(), "forgotten").mkdir()
    code = "import sys, time; print(flush=True); time.sleep(600)"
    for name in ("running", "stopped"):
        process = subprocess.Popen([sys.executable, "-c", code, name], stdout=subprocess.PIPE)
        process.stdout.readline()
        if name == "stopped":
            process.send_signal(signal.SIGSTOP)
"""


def runs(pid: int) -> bool:
    """Is this process alive?  Of one that has ended and that nobody has asked for there is no command line."""
    try:
        return bool(Path(f"/proc/{pid}/cmdline").read_bytes())
    except OSError:
        return False


@pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="needs /proc")
@pytest.mark.parametrize("workers", ["0", "1"])
def test_leftovers_are_named_and_fail_the_run_and_processes_are_ended(tmp_path: Path, workers: str) -> None:
    run = Run(tmp_path, LEAVES, "-n", workers, "-W", "ignore")
    assert run.outcomes() == {"test_it": "PASSED"}
    assert run.status == 1
    processes = {name: int(pid) for pid, name in re.findall(r"a process: (\d+) .* (\w+)$", "\n".join(run.left), re.M)}
    assert processes.keys() == {"running", "stopped"}
    assert not [name for name, pid in processes.items() if runs(pid)]
    assert "in the folder for temporary files: forgotten" in run.left
    assert run.left[-1] == f"files are kept in {run.kept[0]}"


def test_a_run_that_leaves_nothing_passes_and_its_folder_is_gone(tmp_path: Path) -> None:
    code = "def test_it(tmp_path):\n    assert str(tmp_path).startswith(tempfile.gettempdir())\n"
    run = Run(tmp_path, code)
    assert (run.status, run.outcomes(), run.left, run.kept) == (0, {"test_it": "PASSED"}, [], [])


def test_a_run_that_fails_keeps_its_files(tmp_path: Path) -> None:
    run = Run(tmp_path, "def test_it(tmp_path):\n    (tmp_path / 'x').touch()\n    assert False\n")
    assert (run.status, run.left) == (1, [f"files are kept in {run.kept[0]}"])
    assert list(run.kept[0].rglob("x"))


# ------------------------------------------------------------------------------------------------- what is inherited
CLEARED = """
import json, os, signal, subprocess, sys, time
from tests import surroundings
surroundings.clear()
mask = os.umask(0)
os.kill(os.getpid(), signal.SIGINT)  # it is ignored here, as it was
child = "import json, signal as s; print(json.dumps([n for n in (1, 2, 3) if s.getsignal(n) == s.SIG_IGN]))"
print(json.dumps({
    "environment": sorted(os.environ),
    "mask": mask,
    "blocked": [*signal.pthread_sigmask(signal.SIG_BLOCK, ())],
    "zone": time.tzname,
    "ignored by a child": json.loads(subprocess.check_output([sys.executable, "-c", child])),
}))
"""
SET = {
    **{name: "1" for name in ("FORCE_COLOR", "NO_COLOR", "PYTHONSAFEPATH", "SLEWLINE_TOKEN", "SLEWLINE_MODULE")},
    **{"COLUMNS": "40", "TERM": "dumb", "LANG": "tr_TR.UTF-8", "LC_ALL": "tr_TR.UTF-8", "TZ": "XYZ-7"},
}


def roughly() -> None:
    """Begin a process as it begins under nohup, in the background, and for a careful user."""
    for number in (signal.SIGHUP, signal.SIGQUIT, signal.SIGINT):
        signal.signal(number, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGTERM, signal.SIGUSR1))
    os.umask(0o077)


@pytest.mark.posix
def test_variables_signals_and_the_mask_of_permissions_are_not_inherited() -> None:
    environment = os.environ | SET | {"PYTHONPATH": str(ROOT), "SLEWLINE_CACHE": os.environ.get("SLEWLINE_CACHE", "")}
    command = [sys.executable, "-c", CLEARED]
    ran = subprocess.run(command, env=environment, preexec_fn=roughly, capture_output=True, text=True, check=False)
    assert (ran.returncode, ran.stderr) == (0, "")
    found = json.loads(ran.stdout)
    assert not SET.keys() & set(found["environment"])
    assert {"PATH", "PYTHONPATH", "SLEWLINE_CACHE"} <= set(found["environment"])
    assert (found["mask"], found["blocked"]) == (0o022, [])
    assert "XYZ" not in found["zone"]
    assert found["ignored by a child"] == []
