"""Run the tests in difficult surroundings: all adverse conditions that can be created here, at the same time.

    python tools/anywhere.py                   make test, then make test-system
    python tools/anywhere.py test -k serve     a task of tools/setup.py, and arguments for pytest

An ordinary user with umask 077 sets up a copy of this checkout in a folder whose name has blanks and umlauts.  There
the tests run as that user in the background, with SIGINT, SIGHUP and SIGQUIT ignored, without a network except
loopback, with the variables of VARIABLES, next to two busy loops.  No test may fail, and no process and no temporary
file may remain.  The ordinary user and the network isolation need root on Linux; otherwise they are left out.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pwd import struct_passwd

ROOT = Path(__file__).resolve().parent.parent
TASKS = ("test", "test-system")
USER = "nobody"
VARIABLES = {
    "COLUMNS": "40",
    "FORCE_COLOR": "1",
    "LANG": "tr_TR.UTF-8",
    "NO_COLOR": "1",
    "PYTHONSAFEPATH": "1",
    "SLEWLINE_TOKEN": "somebody's",
    "TERM": "dumb",
    "TZ": "Asia/Kolkata",
}
IGNORED = (signal.SIGINT, signal.SIGHUP, signal.SIGQUIT)
CLONE_NEWNET, SIOCSIFFLAGS, IFF_UP = 0x40000000, 0x8914, 0x1  # of Linux


def copy(target: Path) -> None:
    """Copy the files of the checkout that git lists, and the emulators of the boards, which need a network."""
    listed = ["git", "-C", str(ROOT), "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    for name in filter(None, subprocess.run(listed, capture_output=True, check=True).stdout.decode().split("\0")):
        if (ROOT / name).is_file():
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, target / name)
    for boards in ("boards", "firmware"):
        if (ROOT / "build" / boards).is_dir():
            shutil.copytree(ROOT / "build" / boards, target / "build" / boards, symlinks=True)


def give(place: Path, person: struct_passwd) -> None:
    """Make a user the owner of a folder."""
    for folder, _, names in os.walk(place):
        for path in (folder, *(os.path.join(folder, name) for name in names)):
            os.chown(path, person.pw_uid, person.pw_gid, follow_symlinks=False)


def cut_network() -> None:
    """Restrict the network of this process to loopback."""
    import fcntl

    libc = ctypes.CDLL(None, use_errno=True)
    if libc.unshare(CLONE_NEWNET) != 0:
        raise OSError(ctypes.get_errno(), "the network cannot be cut")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        fcntl.ioctl(any_socket, SIOCSIFFLAGS, struct.pack("16sh", b"lo", IFF_UP))


def becoming(person: struct_passwd | None, strange: bool) -> Callable[[], None]:
    """Return a function that prepares a process before its program begins."""

    def become() -> None:
        if strange:
            if person:
                cut_network()
            for number in IGNORED:
                signal.signal(number, signal.SIG_IGN)
        if person:
            os.setgroups([])
            os.setgid(person.pw_gid)
            os.setuid(person.pw_uid)
        os.umask(0o077)

    return become


@contextmanager
def busy_loops() -> Iterator[None]:
    """Keep two processors busy."""
    loops = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(2)]
    try:
        yield
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()


def python_for(person: struct_passwd | None) -> str:
    """Return the path of a Python that the user may start: this one, or that of the system."""
    own = os.path.realpath(sys.executable)
    if person and any(not folder.stat().st_mode & 0o001 for folder in Path(own).parents):
        return shutil.which("python3", path="/usr/local/bin:/usr/bin") or sys.exit(f"{USER} cannot start a Python")
    return own


def owned(person: struct_passwd | None, place: Path) -> list[str]:
    """Return the remains of a run: command lines of the user's processes, and files in the temporary folder."""
    found = [path.name for path in place.iterdir()]
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if person and process.stat().st_uid == person.pw_uid:
                command = (process / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
                found += [command] if command else []  # one that has ended, and waits for init, has none
        except OSError:
            continue
    return sorted(found)


def main(arguments: list[str]) -> int:
    """Run tasks in these surroundings; return the exit status: 0 if no test failed and nothing remains."""
    person = None
    if sys.platform == "linux" and os.geteuid() == 0:
        from pwd import getpwnam

        person = getpwnam(USER)
    else:
        print("anywhere: without root on Linux, with your user and network", flush=True)
    calls = [arguments] if arguments else [[task] for task in TASKS]
    with tempfile.TemporaryDirectory(prefix="slewline ä ö ü ", dir="/var/tmp") as name:
        place = Path(name)
        home, checkout, temporary = place / "home", place / "ein Ordner", place / "tmp"
        for folder in (home, checkout, temporary):
            folder.mkdir()
        copy(checkout)
        if person:
            give(place, person)
        plain = {key: value for key, value in os.environ.items() if key.startswith(("PIP_", "UV_", "SSL_"))}
        plain |= {"PATH": "/usr/local/bin:/usr/bin:/bin", "HOME": str(home), "TMPDIR": str(temporary)}
        if os.environ.get("CI"):
            plain["CI"] = os.environ["CI"]

        def run(*words: str, strange: bool, **variables: str) -> int:
            begin = becoming(person, strange)  # safe, because this process has one thread
            command = [python_for(person), "tools/setup.py", *words]
            return subprocess.call(command, cwd=checkout, env=plain | variables, preexec_fn=begin)

        if run("dev", strange=False) != 0:
            return 1
        before = owned(person, temporary)
        with busy_loops():
            statuses = [run(*call, strange=True, **VARIABLES) for call in calls]
        after = owned(person, temporary)
    for line in sorted(set(after) - set(before)):
        print(f"anywhere: remains: {line}", flush=True)
    return 1 if any(statuses) or after != before else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
