"""A newcomer types the first pages word for word, with a fresh clone and an empty home, and installs as they say."""

from __future__ import annotations

import os
import re
import select
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic

import pytest

from ..ports import free_port
from .blocks import NAMED, ROOT, differs
from .test_door import PAGES, lines, requirements

pytestmark = [pytest.mark.long, pytest.mark.posix, pytest.mark.timeout(600)]
LEFT = shutil.ignore_patterns(".venv", "build", "dist", ".git", ".*_cache", ".hypothesis", "__pycache__")
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```|^    (slewline serve|pyserial-miniterm) ([^\n]*)", re.MULTILINE | re.DOTALL)
KEPT = re.compile(r"(?:https?|no)_proxy|PIP_\w+|SSL_\w+", re.IGNORECASE)  # how this machine reaches an index
PATIENCE = 60


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """An empty home, with nothing but the system and one Python on the PATH."""
    home = tmp_path_factory.mktemp("home")
    (home / "bin").mkdir()
    (home / "bin/python3").symlink_to(sys._base_executable)
    return home


@pytest.fixture(scope="module")
def environ(home):
    kept = {name: value for name, value in os.environ.items() if KEPT.fullmatch(name)}
    return kept | {"HOME": str(home), "PATH": f"{home / 'bin'}:/usr/local/bin:/usr/bin:/bin", "LANG": "C.UTF-8"}


@pytest.fixture(scope="module")
def clone(home):
    shutil.copytree(ROOT, home / "slewline", ignore=LEFT)
    return home / "slewline"


# -------------------------------------------------------------------------------------------------------- word for word
class Shell:
    """One shell, in which lines are typed as on the page."""

    def __init__(self, folder: Path, environ: dict[str, str]) -> None:
        self.environ, self.folder, self.clone = environ, folder, folder
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
        self.sh = subprocess.Popen(["sh"], cwd=folder, env=environ, text=True, **pipes)

    def type(self, line: str) -> tuple[str, str]:
        """What a line prints, and its status."""
        self.sh.stdin.write(f"{line}\nprintf '\\n@@ %s %s\\n' $? \"$PWD\"\n")
        self.sh.stdin.flush()
        shown = ""
        for got in self.sh.stdout:
            if got.startswith("@@ "):
                _, status, folder = got.rstrip("\n").split(" ", 2)
                self.folder = Path(folder)
                return shown.removesuffix("\n"), status
            shown += got
        raise AssertionError(f"{line!r} ended the shell:\n{shown}")

    def started(self, line: str) -> subprocess.Popen[str]:
        """What runs beside the shell, in its environment."""
        words = f". '{self.clone}/.venv/bin/activate' && exec {line}"
        return subprocess.Popen(
            ["sh", "-c", words], cwd=self.folder, env=self.environ, stdout=subprocess.PIPE, text=True
        )

    def close(self) -> None:
        self.sh.communicate(timeout=PATIENCE)


@contextmanager
def serving(shell: Shell, line: str) -> Iterator[str]:
    """A server on its port, until Ctrl-C; gives what it prints first."""
    server = shell.started(line)
    try:
        yield server.stdout.readline()
    finally:
        server.send_signal(signal.SIGINT)
        server.communicate(timeout=PATIENCE)
    assert server.returncode == 0, line


def parts(text: str) -> Iterator[tuple[str, str]]:
    """The blocks of a page and the servers that it starts, in their order; Python that shares names is one block."""
    found = [(match[1] or "serve", match[2] or f"{match[3]} {match[4]}") for match in BLOCK.finditer(text)]
    session = [code for kind, code in found if kind == "python" and not NAMED.match(code)]
    printed = [
        code
        for (kind, code), (before, _) in zip(found[1:], found, strict=False)
        if kind == "text" and before == "python" and not NAMED.match(code)
    ]
    for kind, code in found:
        if NAMED.match(code):
            yield "file", code
        elif kind == "python" and session:
            yield "session", "".join(session) + "\0" + "".join(printed)
            session = []
        elif kind in ("console", "serve"):
            yield kind, code


def typed(shell: Shell, kind: str, code: str) -> None:
    """Do what a block says, and compare what it prints."""
    if kind == "file":
        (shell.folder / NAMED.match(code)[1]).write_text(code)
    elif kind == "session":
        code, _, wanted = code.partition("\0")
        (shell.folder / "typed.py").write_text(code)
        shown, status = shell.type("python typed.py 2> typed.err")  # where a server reports what goes wrong
        assert (status, differs(wanted, shown)) == ("0", None)
    else:
        for call in re.split(r"^\$ ", code, flags=re.MULTILINE)[1:]:
            command, _, wanted = call.partition("\n")
            shown, status = shell.type(command)
            if wanted:
                assert differs(wanted, re.sub(r" in [\d.]+s", "", shown)) is None, command
            assert status == "0" or "FAILED" in shown or "AssertionError" in wanted, (command, shown)


@pytest.mark.parametrize(
    ("page", "blocks", "servers"),
    [
        ("README.md", 5, 1),
        ("docs/tutorial/first_motor.md", 4, 0),
        ("docs/howto/serve.md", 2, 6),
        ("docs/howto/pytest_plugin.md", 10, 0),
    ],
)
def test_a_page_is_typed_word_for_word(page, blocks, servers, clone, environ):
    shell = Shell(clone, environ)
    if "howto" in page:  # it goes on from the README
        assert [shell.type(line)[1] for line in ("make demo", ". .venv/bin/activate")] == ["0", "0"]
    text = (ROOT / page).read_text("utf-8").replace("4001", str(free_port())).replace("/tmp/gsc", f"{clone}/gsc")
    answers = re.findall(r"^    (Po|[STR+]\d+|E|V1) +(\S+)  ", text, re.MULTILINE)
    before, done = "", 0
    for kind, code in parts(text):
        line = re.split(r" {2,}", code)[0]
        if kind != "serve":
            typed(shell, kind, code)
            done += 1
        elif line.startswith("pyserial-miniterm"):
            with serving(shell, before):
                talk(shell, line, answers)
        elif "/dev/tty" not in line and "COM3" not in line:  # a cable is not here
            before = line
            with serving(shell, line) as first:
                assert re.search(r": (socket|rfc2217)://127.0.0.1:\d+|: /", first), line
            servers -= 1
    shell.close()
    assert (done >= blocks, servers) == (True, 0)
    assert "miniterm" not in text or len(answers) == 8


def talk(shell: Shell, line: str, answers: list[tuple[str, str]]) -> None:
    """Type lines into a terminal program, and see the answers; the last question is asked until it has its answer."""
    import pty

    keyboard, terminal = pty.openpty()
    program = subprocess.Popen(
        ["sh", "-c", f". '{shell.clone}/.venv/bin/activate' && exec {line}"],
        env=shell.environ | {"TERM": "dumb"}, stdin=terminal, stdout=terminal, stderr=terminal, start_new_session=True,
    )  # fmt: skip
    os.close(terminal)
    read_until(keyboard, "Quit: Ctrl+]", PATIENCE)
    for what, answer in answers[:-1]:
        os.write(keyboard, f"{what}\n".encode())
        assert read_until(keyboard, answer, PATIENCE)
    what, answer = answers[-1]
    until = monotonic() + PATIENCE
    while monotonic() < until:
        os.write(keyboard, f"{what}\n".encode())
        if read_until(keyboard, answer, 1):
            break
    else:
        raise AssertionError(f"{what} is never answered {answer}")
    os.write(keyboard, b"\x1d")
    assert program.wait(PATIENCE) == 0
    os.close(keyboard)


def read_until(keyboard: int, text: str, seconds: float) -> bool:
    """Whether a text has appeared on a terminal, behind the echo of what was typed."""
    seen, until = "", monotonic() + seconds
    while text not in seen.rpartition("\n")[2].rstrip("\r\n") and text not in seen:
        if not select.select([keyboard], [], [], max(0, until - monotonic()))[0]:
            return False
        seen += os.read(keyboard, 4096).decode()
    return True


# ----------------------------------------------------------------------------------------------------------- installing
OURS = [
    line
    for line in dict.fromkeys(lines(PAGES))
    if any("/" in wanted or wanted.startswith(".") for wanted in requirements(line))
]
BRINGS = {  # what can be imported then
    "all": "click, distributed, matplotlib, msgspec, numba, prompt_toolkit, pyvisa, serial, starlette",
    "panel": "starlette, uvicorn, websockets",
    "plot": "matplotlib",
    "pytest": "pytest, serial, slewline.testing",
}


@pytest.fixture(scope="module")
def wheel(clone, environ):
    """The wheel, built by the line of the page."""
    (line,) = re.findall(r"^    (pip wheel .*?) {2}", (ROOT / "docs/reference/systems.md").read_text(), re.MULTILINE)
    subprocess.run(f"python3 -m {line}", shell=True, cwd=clone, env=environ, check=True, capture_output=True)
    (wheel,) = (clone / "dist").iterdir()
    return wheel


@pytest.mark.parametrize("line", OURS)
def test_a_line_that_installs_slewline_does_so(line, clone, wheel, environ, tmp_path):
    line = re.split(r" {2,}", line)[0]
    tool = line.split()[0]
    if tool != "pip" and not shutil.which(tool):
        pytest.skip(f"no {tool} here")
    subprocess.run(["python3", "-m", "venv", tmp_path / "venv"], env=environ, check=True)
    scripts = tmp_path / "venv/bin"
    environ = environ | {"PATH": f"{scripts}:{environ['PATH']}"}
    line = line.replace(f"/path/to/{wheel.name}", str(wheel)).replace("/path/to/slewline[", f"{clone}[")
    subprocess.run(line, shell=True, cwd=clone, env=environ, check=True, capture_output=True)
    if tool == "pip":
        (extra,) = re.findall(r"\[(\w+)\]", line)
        asked = f"import slewline, {BRINGS[extra]}; print(slewline.__file__)"
        call = [scripts / "python", "-c", asked]
        ran = subprocess.run(call, cwd=tmp_path, env=environ, capture_output=True, text=True, check=True)
        assert (ran.stderr, Path(ran.stdout.strip()).is_relative_to(tmp_path)) == ("", True)


def test_the_wheel_carries_the_readme(wheel):
    from email import message_from_bytes
    from zipfile import ZipFile

    with ZipFile(wheel) as files:
        (name,) = (name for name in files.namelist() if name.endswith("METADATA"))
        told = message_from_bytes(files.read(name))
    assert told.get_payload(decode=True).decode().strip() == (ROOT / "README.md").read_text("utf-8").strip()
    assert told["Description-Content-Type"] == "text/markdown" and told["Project-URL"] is None
    assert {"indexer", "test double", "CY545", "RS-232"} <= {*told["Keywords"].split(",")}
