"""What the page about packages of one's own says, typed word for word where nothing but the wheel is installed."""

from __future__ import annotations

import re
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest

from ..ports import free_port
from .test_newcomer import BLOCK, KEPT, Shell, serving, typed
from .test_pages import ROOT, TYPED

EDIT = re.compile(r"# ([\w/.]+)(?:, (?:below `(.*)`|(at the end)))?\n")


@pytest.fixture
def shell(tmp_path, monkeypatch):
    """A shell in an empty folder, with an environment in which there is nothing but the wheel and what it needs."""
    import os

    kept = {name: value for name, value in os.environ.items() if KEPT.fullmatch(name)}
    environ = kept | {"HOME": str(tmp_path), "PATH": "/usr/local/bin:/usr/bin:/bin", "LANG": "C.UTF-8"}
    build = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation", "-w", tmp_path / "dist"]
    subprocess.run([*build, ROOT], check=True)
    (wheel,) = (tmp_path / "dist").iterdir()
    subprocess.run([sys._base_executable, "-m", "venv", tmp_path / ".venv"], env=environ, check=True)
    install = [tmp_path / ".venv/bin/pip", "install", "-q", f"slewline[cli,files,pytest] @ {wheel.as_uri()}"]
    subprocess.run(install, env=environ, cwd=tmp_path, check=True)
    shell = Shell(tmp_path, environ)
    shell.type(". .venv/bin/activate")
    yield shell
    shell.close()


def edit(folder: Path, code: str) -> None:
    """Write what a block says into the file that its first line names: a new one, at its end, or below a line of it."""
    name, below, end = EDIT.match(code).groups()
    code = code.partition("\n")[2]
    path = folder / name
    if below:
        before, line, after = path.read_text("utf-8").partition(below)
        rest, _, after = after.partition("\n")
        assert line, f"{name} has no line with {below}"
        code = f"{before}{line}{rest}\n{code}{after}"
    elif end:
        code = path.read_text("utf-8") + code
    path.write_text(code, "utf-8")


@pytest.mark.check
@pytest.mark.posix
@pytest.mark.timeout(600)
def test_the_page_is_typed_word_for_word_with_the_wheel_alone(shell):
    text = TYPED.read_text("utf-8").replace("4001", str(port := free_port()))
    done = {"console": 0, "edit": 0, "serve": 0}
    with ExitStack() as servers:
        for match in BLOCK.finditer(text):
            if match[3]:
                for path in shell.folder.glob("*.toml"):
                    path.write_text(path.read_text("utf-8").replace("4001", str(port)), "utf-8")
                first = servers.enter_context(serving(shell, f"{match[3]} {match[4]}"))
                assert first.endswith(f"socket://127.0.0.1:{port}\n"), first
                done["serve"] += 1
            elif match[1] == "console":
                typed(shell, "console", match[2])
                done["console"] += 1
                servers.close()
            else:
                edit(shell.folder, match[2])
                done["edit"] += 1
    assert done == {"console": 7, "edit": 5, "serve": 2}
