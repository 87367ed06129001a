"""tools/setup.py on a machine that cannot run slewline: it has to say so, and what to do about it."""

import ast
import importlib.util
import os
import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

SCRIPT = Path(__file__).parents[2] / "tools" / "setup.py"
BIN = "Scripts" if os.name == "nt" else "bin"
MAKEFILE = (SCRIPT.parents[1] / "Makefile").read_text("utf-8")


def load(path):
    spec = importlib.util.spec_from_file_location("slewline_setup", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def setup(tmp_path):
    """The script in an otherwise empty checkout, where nothing it does can reach the real .venv."""
    (tmp_path / "tools").mkdir()
    (tmp_path / "requirements").mkdir()
    (tmp_path / "requirements/run.lock").write_text("numpy==1\n")
    (tmp_path / "requirements/dev.lock").write_text("numpy==1\n")
    (tmp_path / "requirements/compiled.lock").write_text("setuptools==1\n")
    (tmp_path / "pyproject.toml").write_text("[build-system]\n[project]\n[tool.hatch]\n")
    (tmp_path / "src/slewline").mkdir(parents=True)
    (tmp_path / "src/slewline/version.py").write_text("0.1.0\n")
    return load(shutil.copy(SCRIPT, tmp_path / "tools"))


class Machine:
    """Stands in for subprocess.call: notes what was asked for, and does nothing but succeed or fail."""

    def __init__(self):
        self.installed = []
        self.ran = []  # how a task calls Python
        self.tools = set()
        self.online = True
        self.status = 0

    def call(self, command, cwd, env=None):
        tool = Path(command[0]).name
        self.tools.add(tool if tool in ("uv", "virtualenv") else "python")
        if "venv" in command or tool == "virtualenv":
            for folder, name in (("bin", "python"), ("Scripts", "python.exe")):
                python = Path(command[-1], folder, name)
                python.parent.mkdir(parents=True)
                python.touch()
        elif "install" not in command:
            self.ran.append([Path(command[0]).parent.name, *command[1:]])
            return self.status
        elif not self.online:
            return 1
        self.installed.append(Path(command[-1]).name)
        return 0


@pytest.fixture
def machine(monkeypatch):
    machine = Machine()
    monkeypatch.setattr(subprocess, "call", machine.call)
    return machine


def test_an_old_python_is_reported_with_the_version_to_install(setup, monkeypatch, capsys):
    monkeypatch.setattr(sys, "version_info", (3, 9, 18, "final", 0))
    assert setup.main(["dev"]) == 1
    message = capsys.readouterr().err
    assert "needs Python 3.11 or newer; this is Python 3.9.18" in message
    assert sys.executable in message
    assert "apt install python3.11 python3.11-venv" in message
    assert "PYTHON=python3.12 make demo" in message


def test_an_old_python_can_parse_the_script():
    tree = ast.parse(SCRIPT.read_text(), feature_version=(3, 4))
    too_new = (ast.JoinedStr, ast.AnnAssign, ast.NamedExpr, ast.Nonlocal, ast.YieldFrom)
    for node in ast.walk(tree):
        assert not isinstance(node, too_new), f"line {node.lineno}"
        assert not (isinstance(node, ast.Raise) and node.cause), f"line {node.lineno}"


def test_a_missing_ensurepip_is_named_with_its_package(setup, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "ensurepip", None)
    monkeypatch.setattr(shutil, "which", lambda _name: None)
    assert setup.main(["dev"]) == 1
    message = capsys.readouterr().err
    assert "`ensurepip` is missing" in message
    assert "apt install python3-venv" in message


def test_a_second_setup_does_nothing(setup, machine):
    assert setup.main(["dev"]) == 0
    assert machine.installed == [".venv", "dev.lock", ""]
    assert setup.main(["dev"]) == 0
    assert setup.main(["run"]) == 0
    assert machine.installed == [".venv", "dev.lock", ""]


def test_a_changed_lock_is_installed(setup, machine, tmp_path):
    assert setup.main(["run"]) == 0
    (tmp_path / "requirements/run.lock").write_text("numpy==2\n")
    assert setup.main(["run"]) == 0
    assert machine.installed == [".venv", "run.lock", "", "run.lock"]


def test_another_version_is_installed(setup, machine, tmp_path):
    assert setup.main(["run"]) == 0
    (tmp_path / "src/slewline/version.py").write_text("0.2.0\n")
    assert setup.main(["run"]) == 0
    assert machine.installed == [".venv", "run.lock", "", ""]


def test_a_failed_installation_explains_itself_and_is_tried_again(setup, machine, capsys):
    machine.online = False
    assert setup.main(["run"]) == 1
    message = capsys.readouterr().err
    assert "could not install requirements/run.lock" in message
    assert "No network?" in message
    assert "PIP_INDEX_URL" in message
    machine.online = True
    assert setup.main(["run"]) == 0
    assert machine.installed == [".venv", "run.lock", ""]


def test_the_dev_lock_contains_the_run_lock():
    requirements = SCRIPT.parents[1] / "requirements"
    run, dev = ((requirements / f"{name}.lock").read_text() for name in ("run", "dev"))
    pins = {line for line in run.splitlines() if "==" in line}
    assert pins
    assert pins <= set(dev.splitlines())


def test_usage(setup, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", [setup.__file__, "all"])
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(setup.__file__, run_name="__main__")
    assert ended.value.code == 2
    assert "usage" in capsys.readouterr().err


# --------------------------------------------------------------------------------------------------------- no ensurepip
@pytest.mark.parametrize("tool", ["uv", "virtualenv"])
def test_without_ensurepip_another_maker_is_tried(setup, machine, monkeypatch, capsys, tool):
    monkeypatch.setitem(sys.modules, "ensurepip", None)
    monkeypatch.setattr(shutil, "which", lambda name: f"/usr/bin/{name}" if name == tool else None)
    for _ in range(2):
        assert setup.main(["run"]) == 0
    assert machine.installed == [".venv", "run.lock", ""]
    assert machine.tools == ({"uv"} if tool == "uv" else {"virtualenv", "python"})  # virtualenv brings pip
    assert f"no ensurepip here; {tool} takes its place" in capsys.readouterr().err


def test_without_any_maker_all_of_them_are_named(setup, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "ensurepip", None)
    monkeypatch.setattr(shutil, "which", lambda _name: None)
    assert setup.main(["dev"]) == 1
    message = capsys.readouterr().err
    assert "apt install python3-venv" in message and "`uv` or `virtualenv`" in message


# ---------------------------------------------------------------------------------------------------------------- tasks
def test_make_has_a_task_for_every_task_and_the_same_description(setup):
    told = re.findall(r"^([a-z-]+): ## (.*)$", MAKEFILE, re.MULTILINE)
    assert told == [(name, what) for name, _, what, _ in setup.TASKS if name not in ("run", "dev")]
    assert re.search(r"^TASKS := (.*)$", MAKEFILE, re.MULTILINE)[1].split() == [name for name, _ in told]


@pytest.mark.parametrize("task", ["demo", "test", "check", "conformance", "mutations", "bench", "docs"])
def test_a_task_is_done_in_the_environment_and_its_status_counts(setup, machine, task):
    assert setup.main([task]) == 0
    assert machine.installed == [".venv", "run.lock" if task == "demo" else "dev.lock", ""]
    assert machine.ran and {call[0] for call in machine.ran} == {BIN}
    for call in machine.ran:  # what it calls is there
        found = Path(SCRIPT.parents[1], call[1]).is_file() if call[1][0] != "-" else call[1] in ("-m", "-c")
        assert found, call
    machine.status = 3
    assert setup.main([task]) != 0


@pytest.fixture
def source(setup, tmp_path):
    """A source file in the checkout, and the hook that compiles it."""
    shutil.copy(SCRIPT.with_name("compile_core.py"), tmp_path / "tools")
    (tmp_path / "src/slewline/kernel.py").write_text("now = 0\n")
    return tmp_path / "src/slewline/kernel.py"


def test_the_core_is_compiled_again_when_a_source_file_has_changed(setup, machine, source):
    for _ in range(2):
        assert setup.main(["compiled"]) == 0
    assert machine.installed == [".venv", "dev.lock", "compiled.lock", "", ""]
    source.write_text("now = 1\n")
    assert setup.main(["compiled"]) == 0
    assert machine.installed == [".venv", "dev.lock", "compiled.lock", "", "", ""]
    assert not machine.ran


@pytest.mark.parametrize("task, runs", [("test-compiled", [True]), ("test-long", [False, True])])
def test_tasks_over_the_compiled_build_notify_pytest(setup, machine, source, task, runs):
    assert setup.main([task]) == 0
    assert machine.installed == [".venv", "dev.lock", "compiled.lock", "", ""]
    assert ["tests.compiled" in call for call in machine.ran] == runs


def test_a_build_that_fails_mentions_the_alternative(setup, machine, source, capsys):
    assert setup.main(["dev"]) == 0
    machine.online = False
    (Path(setup.ROOT) / ".venv/stamp-compiled").touch()
    assert setup.main(["compiled"]) == 1
    assert "could not install requirements/compiled.lock" in capsys.readouterr().err


def test_arguments_go_to_the_last_call(setup, machine):
    assert setup.main(["test", "-k", "cy525", "tests/chips"]) == 0
    assert machine.ran == [[BIN, "-m", "pytest", "-n", "2", "--dist", "worksteal", "-k", "cy525", "tests/chips"]]


def test_a_check_that_fails_ends_them(setup, machine):
    machine.status = 1
    assert setup.main(["check"]) == 1
    assert len(machine.ran) == 1


def test_windows_has_scripts(setup, machine, monkeypatch):
    monkeypatch.setattr(setup, "WINDOWS", True)
    assert setup.main(["demo"]) == 0
    assert machine.ran == [["Scripts", "-m", "slewline", "demo"]]


def test_windows_locks_a_byte_far_beyond_the_end(setup, monkeypatch):
    locked = []

    def locking(file, mode, length):
        locked.append((os.lseek(file, 0, os.SEEK_CUR) > 1 << 20, mode, length))
        if len(locked) < 3:
            raise OSError  # the other one has it for more than ten seconds

    monkeypatch.setitem(sys.modules, "fcntl", None)
    monkeypatch.setitem(sys.modules, "msvcrt", SimpleNamespace(locking=locking, LK_LOCK=1))
    with open(SCRIPT, "rb") as file:
        setup.lock(file)
    assert locked == [(True, 1, 1)] * 3


def test_clean_takes_away_what_was_made(setup, tmp_path):
    for made in (".venv/bin", "build/docs", "src/slewline/__pycache__", ".mypy_cache"):
        (tmp_path / made).mkdir(parents=True)
    (tmp_path / "src/slewline/bench.py").touch()
    (tmp_path / ".coverage").touch()
    assert setup.main(["clean"]) == 0
    left = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file()}
    assert left == {
        "src/slewline/bench.py",
        "src/slewline/version.py",
        "tools/setup.py",
        "requirements/run.lock",
        "requirements/dev.lock",
        "requirements/compiled.lock",
        "pyproject.toml",
    }
    assert not list(tmp_path.rglob("__pycache__"))


# ----------------------------------------------------------------------------------------------- a read-only checkout
@pytest.fixture
def frozen(setup, monkeypatch, tmp_path):
    """The checkout cannot be written; the caches of the user can."""
    real = setup.is_writable
    monkeypatch.setattr(setup, "is_writable", lambda folder: folder != setup.ROOT and real(folder))
    for name in ("XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.setenv(name, str(tmp_path / "caches"))
    return tmp_path


def test_a_checkout_that_can_only_be_read_gets_its_environment_elsewhere(setup, machine, frozen, capsys):
    before = {path for path in frozen.rglob("*") if "caches" not in path.parts}
    for _ in range(2):
        assert setup.main(["demo"]) == 0
    assert machine.installed == [".venv", "run.lock", ""]
    place = next((frozen / "caches/slewline").iterdir())
    assert (place / ".venv" / BIN).is_dir()
    assert f"is read-only; the environment and build products go to {place}" in capsys.readouterr().err
    assert machine.ran[0] == [BIN, "-m", "slewline", "demo", "-o", str(place / "build/demo")]
    assert {path for path in frozen.rglob("*") if "caches" not in path.parts} == before


def test_without_a_writable_place_a_remedy_is_reported(setup, frozen, monkeypatch, capsys):
    (frozen / "file").touch()
    for name in ("XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.setenv(name, str(frozen / "file"))
    assert setup.main(["demo"]) == 1
    assert "XDG_CACHE_HOME=/some/folder" in capsys.readouterr().err


@pytest.mark.posix
def test_whether_a_folder_can_be_written_is_found_out(setup, tmp_path):
    assert setup.is_writable(str(tmp_path)) and not list(tmp_path.glob(".setup-*"))
    assert not setup.is_writable(str(tmp_path / "none"))
    assert not setup.is_writable("/proc")
