"""The first change of CONTRIBUTING.md, word for word, in a copy of the project."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys

import pytest

from .blocks import ROOT, differs

pytestmark = [pytest.mark.long, pytest.mark.timeout(600)]
LEFT = shutil.ignore_patterns(".venv", "build", "dist", ".git", ".*_cache", ".hypothesis", "__pycache__")
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
WHERE = re.compile(r"`([\w/.]+)`:$")  # a block goes there


def added(text: str, new: str) -> str:
    """A file with something new at its end; rows of a tuple go before what closes it."""
    return text.replace("\n)\n# fmt: on", f"\n{new})\n# fmt: on") if new.startswith("    _Q(") else f"{text}\n{new}"


@pytest.fixture(scope="module")
def clone(tmp_path_factory):
    clone = tmp_path_factory.mktemp("clone") / "slewline"
    shutil.copytree(ROOT, clone, ignore=LEFT)
    return clone


def test_a_first_change_passes_its_checks_word_for_word(clone):
    text = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
    chapter = text.partition("## A first change")[2].partition("\n## ")[0]
    environ = {**os.environ, "PYTHONPATH": str(clone / "src")}
    calls = []
    for block in BLOCK.finditer(chapter):
        if block[1] == "console":
            calls += re.split(r"^\$ ", block[2], flags=re.MULTILINE)[1:]
            continue
        while calls:
            typed(calls.pop(0), clone, environ)
        (name,) = WHERE.findall(chapter[: block.start()].rstrip())
        path = clone / name
        path.write_text(added(path.read_text("utf-8"), block[2]), "utf-8")
    done = [typed(call, clone, environ) for call in calls]
    assert done == [True, True, False, True, False, False, False]  # git and make need a clone
    for check in (
        "-m ruff check",
        "-m ruff format --check",
        "tools/conformance.py --check",
        "-m pytest -m 'not long' tests/chips/test_quirks.py tests/house/test_mutations.py",
    ):
        assert typed(f"python {check}", clone, environ)


def typed(call: str, clone, environ) -> bool:
    """Do what a line says, and compare what it prints; whether it was a call of Python."""
    line, _, wanted = call.partition("\n")
    program, *words = shlex.split(line, comments=True)
    if program != "python":
        return False
    command = [sys.executable, *words]
    ran = subprocess.run(command, cwd=clone, env=environ, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert not wanted or differs(wanted, ran.stdout) is None, ran.stdout
    return True
