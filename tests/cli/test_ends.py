"""How commands end: by any signal, with all their child processes, without a traceback; what a child's end leads to."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path
from random import Random
from shlex import quote

import pytest

from slewline.cli import main as entry
from tests.links.conftest import PATIENCE, Asks, Client, children

pytestmark = [pytest.mark.posix, pytest.mark.system]

GONE_S = 15.0  # a tenth of a second is usual; what is orphaned stays for good
BEGUN = "begun\n"
MAIN = f"from slewline.cli.main import main; import os; os.write(2, {BEGUN.encode()!r}); main()"
MOTOR = ("--motor", "QSH4218-51-10-049", "--load", "inertia 68 g cm2, friction 5 mNm", "--driver", "24 V, 1 A averaged")
TUNE = ("tune", "cy525", *MOTOR, "--steps", "500", "--map")
MODULE = "slewline://gs-c200s?chs=0&rate=1"
SCRIPT = "".join(f"{line}\n" for line in ("A 0", "F 10", "R 100", "S 240", "N 60000", *["G"] * 200))
DEBUG = (
    "import sys, time; from slewline.cli.live.debug import server_process\n"
    "with server_process(['cy525']) as (where, token): print('control:', where, flush=True); time.sleep(1000)"
)
ARRIVING = """
import os, socket, time
from types import SimpleNamespace
from slewline.links.time.worlds import World
class Slow(World):
    def arrive(self):
        print("begun", flush=True)
        time.sleep(1000)
ours, theirs = socket.socketpair()
log = SimpleNamespace(file=None)
nothing = dict.fromkeys(("bench", "past", "branches", "loop"))
server = SimpleNamespace(**nothing, ports=(), report=print, log=log, controls=lambda: [])
if not os.fork():
    ours.close()
    Slow(server, {"branch": 1}, theirs).run()
theirs.close()
time.sleep(1000)
"""


def session(leader):
    """The processes of a session that have not ended: a command, and all that it has started."""
    found = []
    for place in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            state, _, _, number = (place / "stat").read_text().rpartition(")")[2].split()[:4]
            if int(number) == leader and state != "Z":
                found.append(int(place.name))
    return found


class Started:
    """A command in a session of its own, so that what it leaves is found."""

    def __init__(self, command, folder):
        self.out = open(folder / "out", "w+b")  # noqa: SIM115  # a pipe would have to be read, and is held by orphans
        self.err = open(folder / "err", "w+b")  # noqa: SIM115
        self.process = subprocess.Popen(
            command,
            cwd=folder,
            stdin=subprocess.PIPE,
            stdout=self.out,
            stderr=self.err,
            start_new_session=True,
            env=os.environ | {"TMPDIR": str(folder)},  # what a killed process leaves
        )

    def until(self, met):
        end = time.monotonic() + PATIENCE
        while not met():
            assert self.process.poll() is None, self.said("err")
            assert time.monotonic() < end, self.said("err")
            time.sleep(0.01)

    def said(self, name):
        file = getattr(self, name)
        return os.pread(file.fileno(), 1 << 20, 0).decode()

    def where(self, name):
        """Where the command says that a port is; "": it has not said it."""
        return next((line.partition(": ")[2] for line in self.said("out").splitlines() if line.startswith(name)), "")

    def left(self):
        """What is left of the session after its leader has ended."""
        self.process.wait(PATIENCE)
        end = time.monotonic() + GONE_S
        while (left := session(self.process.pid)) and time.monotonic() < end:
            time.sleep(0.02)
        return [Path(f"/proc/{each}/cmdline").read_bytes().replace(b"\0", b" ") for each in left]

    def close(self):
        for each in session(self.process.pid):
            with suppress(ProcessLookupError):
                os.kill(each, signal.SIGKILL)
        self.process.wait(PATIENCE)
        for file in (self.process.stdin, self.out, self.err):
            file.close()


@contextmanager
def started(*arguments, folder, code=MAIN):
    x = Started([sys.executable, "-c", code, *arguments], folder)
    try:
        yield x
    finally:
        x.close()


# --------------------------------------------------------------------------------------------- kill -9 of the parent
def kill(x):
    x.process.kill()
    assert x.left() == []


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes are looked for in /proc")
class TestKilled:
    """After kill -9 of a command none of its children is left."""

    def test_workers_of_tune(self, tmp_path):
        with started(*TUNE, "--jobs", "2", folder=tmp_path) as x:
            x.until(lambda: len(session(x.process.pid)) == 4)  # with Python's own helper
            kill(x)

    def test_a_panel(self, tmp_path):
        with started("panel", "cy525", "--no-browser", folder=tmp_path) as x:
            x.until(lambda: x.where("panel"))
            kill(x)

    def test_a_server_with_panel_checkpoints_and_a_branch(self, tmp_path):
        ports = ("--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0", "--panel", "127.0.0.1:0")
        with started("serve", "gs-c200s", *ports, folder=tmp_path) as x:
            x.until(lambda: x.where("panel"))
            client = Client(x.where("control"))
            ask = Asks(client)
            ask("pause")
            assert ask("back", time="1 us")["branch"] == 1
            client.close()
            assert len(session(x.process.pid)) > 3
            kill(x)

    def test_the_server_of_a_debugger(self, tmp_path):
        pytest.importorskip("textual")
        with started(folder=tmp_path, code=DEBUG) as x:
            x.until(lambda: x.where("control"))
            kill(x)

    def test_a_branch_in_progress(self, tmp_path):
        with started(folder=tmp_path, code=ARRIVING) as x:
            x.until(lambda: "begun" in x.said("out"))
            kill(x)


# ------------------------------------------------------------------------------------------------ a child that has died
def panel_of(process):
    """The process of the panel."""
    found = [each for each in children(process) if b"slewline.panel" in Path(f"/proc/{each}/cmdline").read_bytes()]
    return found[0] if found else None


@pytest.mark.parametrize("attached", [False, True])
def test_a_panel_that_was_killed_is_started_again_once(tmp_path, attached):
    with started("serve", "cy525", "--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0", folder=tmp_path) as server:
        server.until(lambda: server.where("control"))
        what = ("--attach", server.where("control")) if attached else ("cy525",)
        (tmp_path / "panel").mkdir()
        with started("panel", *what, "--no-browser", folder=tmp_path / "panel") as x:
            x.until(lambda: x.where("panel"))
            os.kill(panel_of(x.process.pid), signal.SIGKILL)
            first = x.where("panel")
            again = "out" if attached else "err"
            x.until(lambda: x.said(again).count("panel: http://") == 1 + attached)
            assert "slewline: the panel has ended (signal 9), and is being restarted\n" in x.said("err")
            assert x.said(again).split()[-1] != first
            os.kill(panel_of(x.process.pid), signal.SIGKILL)
            if attached:
                assert x.process.wait(PATIENCE) == 0
            else:
                x.until(lambda: "is not restarted" in x.said("err"))
            assert "has ended (signal 9) again, and is not restarted; to get the page back, restart" in x.said("err")
            if not attached:
                x.process.send_signal(signal.SIGINT)
                assert x.process.wait(PATIENCE) == 0
            assert x.left() == []


def test_a_worker_of_tune_that_was_killed_is_reported(tmp_path):
    with started(*TUNE, "--jobs", "2", folder=tmp_path) as x:
        x.until(lambda: len(session(x.process.pid)) == 4)
        worker = [
            each for each in children(x.process.pid) if b"spawn_main" in Path(f"/proc/{each}/cmdline").read_bytes()
        ]
        os.kill(worker[0], signal.SIGKILL)
        assert x.process.wait(PATIENCE) != 0
        assert "a process of the pool has died; try fewer jobs" in x.said("err")
        assert "Traceback" not in x.said("err")
        assert x.left() == []


# -------------------------------------------------------------------------------------------------------- any signal
PORT = ("--tcp", "127.0.0.1:0")
PANEL = ("--panel", "127.0.0.1:0")
SLOW = "slewline://gs-c200s?chs=0&br0=1&br1=1&br2=1&rate=1"  # the last of the rates that are tried
FILES = {
    "long.cy525": SCRIPT,
    "p.gs-c200s": "Po\nS10\nR5\nPx\n",
    "b.toml": '[[chip]]\nname = "x"\npart = "cy525"\n[[serve]]\nchips = ["x"]\ntcp = "127.0.0.1:0"\n',
    "said.dialogue": '{"slewline":"dialogue 1","part":"gs-c200s","baud":9600,"checksum":false}\n'
    + "".join(
        f'{{"at_us":{at + late},"last_us":{at + late},"from":"{who}","text":"{what}"}}\n'
        for at in range(0, 60_000_000, 300_000)
        for who, what, late in (("host", "V1\\r", 0), ("module", "V+0\\r", 6_000))
    ),
}
COMMANDS = {
    "run": ("run", "long.cy525", "--vcd", "o.vcd", "--journal", "o.journal", "--timeout", "1000 s"),
    "tune": (*TUNE, "--jobs", "1"),
    "tune with workers": (*TUNE, "--jobs", "2"),
    "panel": ("panel", "cy525", "--no-browser"),
    "panel of a bench": ("panel", "b.toml", "--no-browser"),
    "serve": ("serve", "gs-c200s", *PORT),
    "serve with a panel": ("serve", "gs-c200s", *PORT, *PANEL, "--journal", "o.journal", "--state", "kept"),
    "debug": ("debug", "cy525", "--control", "127.0.0.1:0", "--while-input"),
    "pull": ("pull", SLOW, "-o", "saved.gs-c200s"),
    "push": ("push", SLOW, "p.gs-c200s"),
    "terminal": ("terminal", MODULE, "--part", "gs-c200s"),
    "proxy": ("proxy", "--serial", MODULE, *PORT, "--chip", "gs-c200s", "--dialogue", "new.dialogue"),
    "compare": ("compare", "said.dialogue", "--port", MODULE),
    "drive": ("drive", "gs-c200s", "--board", "twin", *PORT, "--black-box", "kept"),
    "epics": ("epics", MODULE, "--chip", "gs-c200s", "--record", "x", "--replace", "S=10", "T=1000 steps/s", "R=50"),
}
KINDS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGKILL")
ORDERLY = ("SIGINT", *getattr(entry, "ENDS", ()))  # the signals at which a command removes what is unfinished
LONGEST_S = 2.5


def hit(command, kind, seed, folder):
    """Send a signal to a command, or to all of its processes, at some instant; see that nothing is left."""
    folder.mkdir()
    for name, text in FILES.items():
        (folder / name).write_text(text)
    random = Random(f"{command} {kind} {seed}")
    number = getattr(signal, kind)
    code = f"import slewline.testing; {MAIN}" if "slewline://" in str(COMMANDS[command]) else MAIN  # pySerial knows it
    with started(*COMMANDS[command], folder=folder, code=code) as x:
        x.until(lambda: BEGUN in x.said("err"))
        early = seed % 3 == 0  # while it is being loaded
        time.sleep(random.uniform(0.02, 0.5 if early else LONGEST_S))
        with suppress(ProcessLookupError):  # it has done its work
            (os.killpg if seed % 2 else os.kill)(x.process.pid, number)
        assert x.left() == [], (command, kind, seed)
        assert "Traceback" not in x.said("err"), (command, kind, seed, x.said("err"))
        if kind in ORDERLY:
            assert not list(folder.glob("**/*.part")), (command, kind, seed)


@pytest.mark.parametrize(("number", "command"), [*enumerate(COMMANDS)])
def test_a_signal_at_some_instant_leaves_nothing(tmp_path, number, command):
    hit(command, KINDS[number % len(KINDS)], number, tmp_path / "here")


@pytest.mark.long
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("command", COMMANDS)
def test_sixty_signals_at_any_instant_leave_nothing(tmp_path, command, kind):
    for seed in range(60):
        hit(command, kind, seed, tmp_path / str(seed))


DROPPED = """
import os, signal, time
from slewline.cli import main
class Taken:
    def __del__(self):
        os.kill(os.getpid(), signal.{kind})
        for _ in range(1000):  # Python looks at signals between two instructions
            pass

def command(_arguments):
    print("begun", flush=True)
    Taken()
    time.sleep(60)

main.invoke = command
main.main()
"""


WRAPPED = """
import os, signal
from slewline.cli import main
class Named:
    def __set_name__(self, owner, name):
        os.kill(os.getpid(), signal.{kind})
        for _ in range(1000):
            pass

def called(self, *_arguments, **_options):
    class Owner:  # Python makes a RuntimeError of what __set_name__ raises, up to 3.11
        one = Named()

print("begun", flush=True)
from slewline.cli.commands import cli
type(cli).main = called
main.main()
"""


@pytest.mark.parametrize("kind", ORDERLY)
@pytest.mark.parametrize("program", [DROPPED, WRAPPED], ids=["dropped", "wrapped"])
def test_a_signal_that_python_drops_or_makes_another_exception_of_ends_the_command(tmp_path, program, kind):
    code = f"import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n{program.format(kind=kind)}"
    found = subprocess.run(
        [sys.executable, "-c", code], check=False, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE / 2
    )
    assert (found.returncode, found.stdout) == (1, "begun\n")
    assert found.stderr == "slewline: interrupted; unfinished files are unchanged\n"


# ---------------------------------------------------------------------------------------------- what a process may lack
def without(streams, *arguments, folder):
    """Call a command whose standard streams are closed, as some supervisors have it."""
    shell = [
        "sh",
        "-c",
        f'exec "$@" {streams}',
        "sh",
        sys.executable,
        "-c",
        "from slewline.cli.main import main; main()",
    ]
    return subprocess.run(
        [*shell, *arguments], check=False, cwd=folder, capture_output=True, text=True, timeout=PATIENCE
    )


def test_output_to_closed_standard_streams_is_dropped(tmp_path):
    (tmp_path / "p.cy525").write_text("R 5\n")
    found = without(">&-", "chips", folder=tmp_path)
    assert (found.returncode, found.stderr) == (0, "")
    assert without("2>&-", "chips", folder=tmp_path).stdout.count("cy525")
    found = without("<&-", "run", "-", "--chip", "cy525", folder=tmp_path)
    assert (found.returncode, found.stderr) == (
        2,
        "slewline: - has no commands; write one command per line, such as R 100\n",
    )
    found = without("<&- >&- 2>&-", "run", "p.cy525", "--vcd", "o.vcd", folder=tmp_path)
    assert found.returncode == 0
    assert "$enddefinitions" in (tmp_path / "o.vcd").read_text()


def test_a_server_and_its_panel_need_no_standard_streams(tmp_path):
    shell = f'exec {quote(sys.executable)} -c "{MAIN}" serve cy525 --pty link --panel 127.0.0.1:0 <&- >&- 2>&-'
    x = Started(["sh", "-c", shell.replace(f"; import os; os.write(2, {BEGUN.encode()!r})", "")], tmp_path)
    try:
        x.until(lambda: (tmp_path / "link").exists() and panel_of(x.process.pid))
        x.process.send_signal(signal.SIGINT)
        assert x.process.wait(PATIENCE) == 0
        assert x.left() == []
    finally:
        x.close()
