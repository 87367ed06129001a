"""tools/setup.py on a machine that cannot run slewline: it has to say so, and what to do about it."""

import ast
import importlib.util
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "tools" / "setup.py"


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
    (tmp_path / "pyproject.toml").write_text("[build-system]\n[project]\n[tool.hatch]\n")
    return load(shutil.copy(SCRIPT, tmp_path / "tools"))


class Machine:
    """Stands in for subprocess.call: notes what was asked for, and does nothing but succeed or fail."""

    def __init__(self):
        self.installed = []
        self.online = True

    def call(self, command, cwd):
        if "pip" not in command:
            python = Path(command[-1], "bin/python")
            python.parent.mkdir(parents=True)
            python.touch()
        elif not self.online:
            return 1
        self.installed.append(Path(command[-1]).name)
        return 0


@pytest.fixture
def machine(monkeypatch):
    machine = Machine()
    monkeypatch.setattr(subprocess, "call", machine.call)
    return machine


def test_an_old_python_is_told_what_to_install(setup, monkeypatch, capsys):
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


def test_usage(setup):
    result = subprocess.run([sys.executable, setup.__file__, "all"], capture_output=True, text=True, check=False)
    assert result.returncode == 2
    assert "usage" in result.stderr
