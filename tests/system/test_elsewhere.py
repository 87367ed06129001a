"""On a system that is not POSIX (see tests/elsewhere.py): the server, the demo, and what the sources may lean on."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import serial

from tests.links.conftest import patient
from tests.sources import tree

ROOT = Path(__file__).parents[2]
HOME = {  # who may ask what there is
    "src/slewline/drive/board/reader_thread.py",
    "src/slewline/folders.py",
    "src/slewline/lifeline.py",
    "src/slewline/record/whole_file.py",
    "src/slewline/temporary.py",
    "src/slewline/links/sockets/system.py",
    "src/slewline/links/ports/pty.py",
    "src/slewline/links/time/worlds.py",
    "tools/anywhere.py",
}
MODULES = {"fcntl", "termios", "tty", "pty", "resource", "pwd", "grp", "syslog", "readline", "curses", "posix"}
NAMES = {
    "os": r"O_(DIRECTORY|NOCTTY|NONBLOCK)|fork|forkpty|openpty|ttyname|mkfifo|mknod|killpg|pipe|[gs]et_blocking|setsid"
    r"|getp?gid|gete?uid|uname|nice|f?chown|wait.*|statvfs|sched_.*|sync|getloadavg",
    "signal": r"SIG(?!INT$|TERM$|_IGN$|_DFL$)\w+|pthread_\w+|alarm|setitimer|sigwait|pause",
    "select": r"poll|epoll|kqueue|(E?POLL\w+)",
    "socket": "AF_UNIX",
}
PROGRAM = "import sys; import tests.elsewhere; from slewline.cli.main import invoke; sys.exit(invoke(sys.argv[1:]))"


# ----------------------------------------------------------------------------------------------------------- programs
class Elsewhere:
    """The command, in a process that has nothing of POSIX."""

    def __init__(self, *arguments, **more):
        self.process = subprocess.Popen(
            [sys.executable, "-W", "error", "-c", PROGRAM, *map(str, arguments)],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            **more,
        )

    def ended(self):
        out, err = self.process.communicate(timeout=60)
        return self.process.returncode, out, err


@pytest.fixture
def run():
    made = []

    def start(*arguments):
        made.append(Elsewhere(*arguments))
        return made[-1]

    yield start
    for one in made:
        one.process.kill()
        one.process.communicate()


SETTINGS = {"tcp": {}, "rfc2217": {"bytesize": 7, "parity": "O", "stopbits": 2}}


@pytest.mark.system
@pytest.mark.filterwarnings("ignore:set.* is deprecated:DeprecationWarning")  # of pySerial's own RFC 2217 client
@pytest.mark.parametrize("kind", SETTINGS)
def test_a_module_is_served(run, tmp_path, kind):
    arguments = ("serve", "gs-c200s", "--strap", "chs=0", f"--{kind}", "127.0.0.1:0", "--state", tmp_path)
    server = run(*arguments, "--option", "eeprom_time=1 ms")
    where = server.process.stdout.readline().split(": ")[1].strip()
    for position in (0, 40):
        with serial.serial_for_url(patient(where), timeout=60, **SETTINGS[kind]) as host:

            def ask(line, host=host):
                host.write(line + b"\r")
                return host.read_until(b"\r")

            assert ask(b"V1") == b"V+%d\r" % position
            if not position:
                program = (b"Po", b"S50", b"T200", b"R20", b"+40", b"E")
                assert [ask(line) for line in program] == [b"Y\r"] * 6
                while ask(b"M") != b"Y\r":  # it is busy
                    pass
    assert run(*arguments).ended()[0::2] == (
        2,
        f"slewline: --state {tmp_path}: used by another server; stop that server, or give another directory\n",
    )
    server.process.terminate()  # heard by way of the wake-up
    status, _, err = server.ended()
    assert status == 0 and "Traceback" not in err
    assert (tmp_path / "gs_c200s.eeprom").read_bytes().startswith(b"slewline memory")


@pytest.mark.system
def test_a_pty_is_refused_in_a_line(run, tmp_path):
    status, out, err = run("serve", "gs-c200s", "--pty", tmp_path / "x").ended()
    assert (status, out) == (2, "")
    assert err == (
        "slewline: --pty needs Linux or macOS: this system has no pseudo-terminals; "
        "serve with --tcp or --rfc2217 instead\n"
    )


@pytest.mark.system
def test_the_demo_runs(run, tmp_path):
    status, out, err = run("demo", "--output", tmp_path).ended()
    assert (status, err) == (0, "") and "12 spots, " in out
    assert {"weld.svg", "weld.png", "weld.vcd"} <= {path.name for path in tmp_path.iterdir()}


# ------------------------------------------------------------------------------------------------------------ sources
def leans(parsed: ast.Module) -> Iterator[str]:
    """What a source takes for granted that only POSIX has."""
    for node in parsed.body:
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names if name.name in MODULES)
        elif isinstance(node, ast.ImportFrom) and node.module in MODULES and not node.level:
            yield str(node.module)
    for node in ast.walk(parsed):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            module, name = node.value.id, node.attr
            if module in NAMES and re.fullmatch(NAMES[module], name):
                yield f"{module}.{name}"


@pytest.mark.check
def test_sources_lean_on_nothing_that_only_posix_has() -> None:
    found = {}
    for folder in ("src", "tools", "examples"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            place = path.relative_to(ROOT).as_posix()
            leaning = set(leans(tree(path)))
            if leaning and not (place in HOME and leaning.isdisjoint(MODULES)):
                found[place] = leaning
    assert not found


def test_uses_of_the_operating_system_are_found() -> None:
    source = "import fcntl, os\nfrom pty import spawn\ndef f():\n    import tty\n    os.pipe(); os.path; signal.SIGHUP"
    assert set(leans(ast.parse(source))) == {"fcntl", "pty", "os.pipe", "signal.SIGHUP"}


@pytest.mark.check
def test_every_text_is_opened_with_its_encoding() -> None:
    """Windows has others: `ruff` knows, in its preview."""
    command = [sys.executable, "-m", "ruff", "check", "-q", "--isolated", "--preview", "--select", "PLW1514"]
    ran = subprocess.run([*command, "src", "examples"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout + ran.stderr
