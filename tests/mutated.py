"""Files from anybody: samples of every kind that is read, hostile values, mutations with a seed, and a watch over them.

`python -m tests.mutated 50000` reads so many mutated files in a process of its own, and prints what it has found.
"""

from __future__ import annotations

import json
import os
import random
import re
import signal
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from typing import Any

import slewline
from slewline.bench.file import BenchFile
from slewline.bench.files.images import read_image
from slewline.chips import CATALOGUE, sheet_of
from slewline.cli.files import read_program
from slewline.cli.motors.own import motor_value
from slewline.core.memory.image import to_hex
from slewline.drive.blackbox import LINES, BlackBox, read_line
from slewline.errors import LONGEST_LINE, SlewlineError
from slewline.links.lines.memory_file import FileStore
from slewline.modules.comparing.model_differences import DialogueComparison
from slewline.modules.dialogue import RecordedDialogue
from slewline.modules.programs.restore import ProgramText
from slewline.modules.speech import speech_of
from slewline.tuning.judging import Verdict
from slewline.tuning.sweep_log import Log

SECONDS = 8  # of work of the processor, for a file
BRACKETS = "[" * 100_000
NAMES = (
    "../..", "../../x", "/etc/hostname", ".profile", ".git/hooks/pre-commit", "Makefile", "x.py", "tool.sh", "link",
    "dir", "dir/../../x", "fifo", "/dev/zero", "/dev/null", "/dev/watchdog", "/dev/tty", "antigravity:x", "evil:Evil",
    "evil", "cy545", "", "\n", "\0", "x" * 5000, "\ud800",
)  # fmt: skip
HOSTILE: tuple[Any, ...] = (
    *NAMES,
    10**12,
    -1,
    10**400,
    1.5,
    float("inf"),
    None,
    True,
    [],
    ["x"],
    {},
    {"x": [1]},
    BRACKETS,
)
TOKENS = (
    b"0", b"-1", b"1e400", b"9" * 5000, b"null", b"{}", b"[" * 3000, b"\x00", b"\xff", b"\n", b'"', b"a" * 100_000,
    b"=", b"$end", b"#", b"b" + b"10" * 2000, b"true", b"18446744073709551616", b".", b"'" * 3, b":" * 40,
)  # fmt: skip
TASK = {"part": "cy525", "steps": 500, "motor": {"name": "m"}, "values": [1, 2]}


# -------------------------------------------------------------------------------------------------------------- samples
BENCH = """
[bench]
seed = 3
until = "20 ms"
timeout = "30 ms"

[[chip]]
part = "cy525"
name = "x"
crystal = "11 MHz"
straps = { ascii_binary = 1 }
bare = false
options = { rate = 80, stepwise = false }

[[chip]]
part = "gs-c200s"
name = "y"

[[chip]]
part = "cy545"
name = "z"

[[part]]
kind = "inverter"
name = "not"

[[part]]
kind = "ram"
name = "memory"
to = "z"
size = 2048
file = "image.hex"

[[part]]
kind = "motor"
name = "motor"
to = "x"

[[part]]
kind = "switch"
name = "home"
on = "motor"
low = 0
high = 3

[[wire]]
from = "x.programmable_output"
to = "not.in1"
invert = false

[[host]]
chips = ["x"]
name = "pc"
delay = "100 us"
file = "program.cy525"

[[serve]]
chips = ["y"]
pty = "y.pty"

[[serve]]
chips = ["z"]
over = "serial"
serial = "/dev/ttyUSB77"

[[drive]]
pin = "x.abort"
level = 1
at = "1 ms"

[[record]]
pins = ["x.slew"]
keep = "10 s"
"""
SPOKEN = (  # header, and what was said: when, by whom
    (
        {"part": "gs-c200s", "markings": "GS-C200S 9431", "baud": 9600, "checksum": False, "address": 0, "straps": {}},
        [(12_000, "host", "F\r"), (17_000, "module", "R\r"), (20_000, "tool", "a remark"), (30_000, "host", "+5\r")],
    ),
    (
        {"part": "cy545", "crystal_hz": 12_000_000, "baud": 9600, "checksum": None, "address": 0, "straps": {}},
        [(1_000, "host", "\r\r"), (60_000, "host", "? P\r"), (70_000, "module", "P=00000000\r")],
    ),
    (
        {"part": "cy525", "crystal_hz": None, "baud": 9600, "checksum": None, "address": 0, "straps": {}},
        [(1_000, "host", "?0\n"), (60_000, "module", "?0 00000\n")],
    ),
)
BACKUPS = {
    "gs-c200s": "; a module\nPo\nS10\nT100\nR50\n+200\nD10\nL3\nPx\n",
    "cy525": "A 0\nF 10\nR 60\nE\nP 300\nP 0\nT 0\n0\nQX\n",
    "cy545": "Y 0\nE\nN 100\nG\nJ 0\n0\nQ\n",
}
VCD = """$timescale 1 ns $end
$scope module x $end
$var wire 1 ! pulse $end
$var wire 4 " phases [3:0] $end
$var real 64 # speed $end
$upscope $end
$enddefinitions $end
#0
$dumpvars
0!
b0101 "
r1.5 #
$end
#100
1!
#250
0!
b1x0z "
"""


class Quiet:
    """A port on which a board has said something."""

    name = "quiet"

    def read(self) -> bytes:
        """Return what has come."""
        return b"\x01\x02"

    def write(self, data: bytes) -> int:
        """Take everything."""
        return len(data)

    def fileno(self) -> None:
        """Return nothing to wait for."""

    def close(self) -> None:
        """Close it."""


def make_bench(folder: Path) -> list[Path]:
    """Write bench files, and what they name."""
    (folder / "program.cy525").write_text("A 0\nR 100\nF 10\nS 200\nN 20\nG\n")
    (folder / "image.hex").write_text(to_hex(bytes(range(64))))
    (folder / "bench.toml").write_text(BENCH)
    return [folder / "bench.toml"]


def make_dialogues(folder: Path) -> list[Path]:
    """Write dialogues, one for each way to speak."""
    made = []
    for header, said in SPOKEN:
        entries = [{"at_us": at, "last_us": at + 1000, "from": by, "text": text} for at, by, text in said]
        lines = [{"slewline": "dialogue 1", **header}, *entries]
        made.append(folder / f"{header['part']}.dialogue")
        made[-1].write_text("".join(f"{json.dumps(line)}\n" for line in lines))
    return made


class Refusing:
    """A memory that refuses its second content."""

    def __init__(self) -> None:
        self.data, self.calls = bytes(range(40)), 0

    def read(self) -> bytes:
        """Return the content."""
        return self.data

    def write(self, data: bytes) -> None:
        """Take the content."""
        self.calls += 1
        if self.calls > 1:
            raise OSError("no room")
        self.data = data


def make_journals(folder: Path) -> list[Path]:
    """Write journals that have every kind of entry."""
    path = folder / "journal.jsonl"
    bench = slewline.Bench(seed=2, journal=path)
    x, y = bench.add("cy525", "x", straps={"ascii_binary": 1}, rate=80), bench.add("gs-c200s", "y", store=Refusing())
    bench.part("ram", name="memory", image=bytes(16))
    motor = bench.part("motor", name="motor", to=x)
    bench.part("switch", name="home", on=motor, low=0, high=3)
    bench.part("inverter", name="not")
    bench.wire("x.programmable_output", "not.in1")
    host, other = bench.host(x, delay="50 us"), bench.host(y)
    host.send("A 0\rR 100\rN 20\rG\r")
    other.send("Po\rD1\rPx\rM\r")
    x.pin("abort").drive(0, at="12 ms")
    bench.run("20 ms")
    x.power(False)
    x.power(True)
    host.send("A 0\r")
    bench.run("20 ms")
    bench.conclude()
    bench.journal.close()
    return [path]


def make_logs(folder: Path) -> list[Path]:
    """Write the log of a sweep."""
    path = folder / "tune.jsonl"
    log = Log(path, TASK)
    for number in range(3):
        log.add((f"{number:x}9a", "nominal"), {"F": number}, Verdict(number == 1, 0.1 * number, 1.4))
    log.close()
    return [path]


def make_motors(folder: Path) -> list[Path]:
    """Write the figures of a motor, as a table and as the row that calibrate prints."""
    (folder / "own.toml").write_text(MOTOR)
    (folder / "row.toml").write_text('motor = { like = "AS1010", iron = 0.000925, inertia = "80 g cm2" }\n')
    return [folder / "own.toml", folder / "row.toml"]


MOTOR = """current = "2 A"
resistance = 1.4
inductance = "3 mH"
torque = "62 oz-in"
inertia = "57 g cm2"
step_angle = "0.9 deg"
windings = "unipolar"
"""


def make_boxes(folder: Path) -> list[Path]:
    """Write the line of a black box."""
    ns = iter(range(0, 10**9, 1000))
    box = BlackBox(Quiet(), folder, lambda: next(ns), lambda at: at * 16)
    for number in range(6):
        box.write(bytes([number, 255]))
        box.read()
    box.close()
    return [folder / LINES[0]]


def make_backups(folder: Path) -> list[Path]:
    """Write programs as they are pulled."""
    for part, text in BACKUPS.items():
        (folder / f"backup.{part}").write_text(text)
    return [folder / f"backup.{part}" for part in BACKUPS]


def make_images(folder: Path) -> list[Path]:
    """Write images of memories, and the memory that a server keeps."""
    (folder / "dump.hex").write_text(to_hex(bytes(range(100))))
    (folder / "dump.bin").write_bytes(bytes(range(200)))
    store = FileStore(folder / "x.eeprom")
    store.append(bytes(range(60)))
    store.append(b"more", 7)
    return [folder / "dump.hex", folder / "dump.bin", folder / "x.eeprom"]


def make_waveforms(folder: Path) -> list[Path]:
    """Write a waveform, and tables of levels and of voltages."""
    (folder / "x.vcd").write_text(VCD)
    for name, text in TABLES.items():
        (folder / f"{name}.csv").write_text(text)
    return [folder / "x.vcd", *(folder / f"{name}.csv" for name in TABLES)]


TABLES = {
    "logic": "Time [s],STEP,DIR\n-0.000001000,0,0\n0.000002000,1,0\n0.000004500,0,1\n",
    "sigrok": "; Channels (2/2): STEP, DIR\n; Samplerate: 12 MHz\nnanoseconds,logic,logic\n83,0,1\n166,1,1\n",
    "beside": "Sample Interval,1e-06,,0.0,0.1,\nSource,CH1,,1.0e-06,3.3,\n,,,2.0e-06,3.2,\n,,,3.0e-06,0.0,\n",
    "bare": "0.0,0.1\n1.0e-06,3.3\n2.0e-06,3.2\n3.0e-06,0.0\n",
    "units": "Source,CH1,CH2\nt / s,Value,Value\n0.0,0.1,3.3\n1.0e-06,3.3,3.3\n2.0e-06,3.2,0.0\n",
    "scope": "X,CH1,CH2,Start,Increment\nSequence,Volt,Volt,-6.0e-03,1.0e-06\n0,0.1,3.2,,\n1,3.3,3.3,,\n2,0.0,3.1,,\n",
}


# -------------------------------------------------------------------------------------------------------------- readers
def load(path: Path) -> None:
    """Read a bench file, with what it wants to serve, and let some time pass."""
    file = BenchFile(path)
    bench = file.load()
    file.served(bench)
    bench.run("25 ms")


def compare(path: Path) -> None:
    """Read a dialogue, and compare it with the model that it names."""
    dialogue = RecordedDialogue.read(path)
    header = dialogue.header
    sheet = sheet_of(header.part, allow_code=False)
    speech = speech_of(sheet, header.baud, header.checksum, header.address)
    DialogueComparison(dialogue, speech).compare()


def replay(path: Path) -> None:
    """Replay a journal."""
    slewline.replay(path, until="25 ms")


def sweep(path: Path) -> None:
    """Go on with the log of a sweep."""
    Log(path, TASK).close()


def read_box(path: Path) -> None:
    """Read what a black box has of the line."""
    read_line(path.parent)


def read_backup(path: Path) -> None:
    """Read a program as `push` does."""
    ProgramText.read(read_program(str(path)), sheet_of(path.suffix[1:]), str(path))


def read_memory(path: Path) -> None:
    """Read an image into a part, or the memory of a server."""
    if path.suffix == ".eeprom":
        FileStore(path).read()
    else:
        slewline.Bench().part("ram", image=read_image(path))


def read_waveform(path: Path) -> None:
    """Read a waveform."""
    slewline.read_vcd(path) if path.suffix == ".vcd" else slewline.read_waveforms(path)


READERS: dict[str, tuple[Callable[[Path], list[Path]], Callable[[Path], None]]] = {
    "bench file": (make_bench, load),
    "dialogue": (make_dialogues, compare),
    "journal": (make_journals, replay),
    "tune log": (make_logs, sweep),
    "motor": (make_motors, lambda path: motor_value(str(path))),
    "black box": (make_boxes, read_box),
    "backup": (make_backups, read_backup),
    "memory": (make_images, read_memory),
    "waveform": (make_waveforms, read_waveform),
}


class Samples:
    """Every kind of file in folders of their own, beside what hostile names may find there."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.paths = folder, {}
        for kind, (make, read) in READERS.items():
            own = folder / kind.replace(" ", "_")
            own.mkdir()
            self.paths[kind] = make(own)
            (own / "dir").mkdir()
            (own / "evil.py").write_text("raise SystemExit('it ran')\n")
            with suppress(OSError):  # Windows asks for a privilege
                (own / "link").symlink_to("/etc/hostname")
            if hasattr(os, "mkfifo"):
                os.mkfifo(own / "fifo")
            for path in self.paths[kind]:
                data = path.read_bytes()
                read(path)
                path.write_bytes(data)
        self.data = {path: path.read_bytes() for paths in self.paths.values() for path in paths}

    def read(self, kind: str, path: Path, data: bytes) -> str:
        """Read a file that has other bytes; return "read" or "refused", or raise what is neither."""
        path.write_bytes(data)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", slewline.errors.JournalWarning)
                READERS[kind][1](path)
        except SlewlineError as error:
            says = str(error)
            assert says.encode() and all(len(line) < LONGEST_LINE + 50 for line in says.splitlines())
            return "refused"
        finally:
            path.write_bytes(self.data[path])
        return "read"


# ---------------------------------------------------------------------------------------------------------------- watch
WRITES = ("os.symlink", "os.link", "os.remove", "os.rename", "os.mkdir", "os.rmdir", "os.truncate", "os.chmod")
STARTS = ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.fork", "socket.connect", "socket.bind")
LOCKS = (("import", "fcntl"), ("import", "msvcrt"))  # `locks.py` looks for what the system has
FOUND_BY = "entry_points.txt"  # of installed packages: they are looked through for a name that is not ours


class Watch:
    """Notes what is done beyond the reading of files below a folder, while it is on.

    A hook cannot be taken away again, so there is one.
    """

    current: Watch | None = None
    hooked = False

    def __init__(self, folder: Path) -> None:
        self.folder, self.seen = os.path.realpath(folder), []
        for package in (slewline.chips, slewline.parts):  # whatever a value asks for is there
            for module in walk_packages(package.__path__, f"{package.__name__}."):
                import_module(module.name)
        CATALOGUE.brought()

    @contextmanager
    def on(self) -> Iterator[Watch]:
        """Watch."""
        if not Watch.hooked:
            sys.addaudithook(Watch.hook)
            Watch.hooked = True
        Watch.current = self
        try:
            yield self
        finally:
            Watch.current = None

    @staticmethod
    def hook(event: str, args: tuple[Any, ...]) -> None:
        """Note an event of Python."""
        watch = Watch.current
        if watch is None or event not in ("open", "import", *WRITES, *STARTS):
            return
        Watch.current = None  # what is asked here is not of interest
        try:
            watch.event(event, args)
        finally:
            Watch.current = watch

    def event(self, event: str, args: tuple[Any, ...]) -> None:
        """Note an event, unless it is about a file below the folder."""
        if (event, args[0]) in LOCKS or (event == "open" and isinstance(args[0], int)):
            return
        if event == "open" or event in WRITES:
            path = os.fsdecode(args[0])
            if os.path.realpath(path).startswith(self.folder + os.sep) or os.path.basename(path) == FOUND_BY:
                return
            if path in sys.path:  # an archive of modules, in which installed packages are looked for
                return
        self.seen.append(f"{event} {args[0]!r}")


# ------------------------------------------------------------------------------------------------------------- mutation
VALUE = re.compile(rb'"(?:[^"\\\n]|\\.)*"|-?\d+(?:\.\d+)?|\btrue\b|\bfalse\b|\bnull\b|\[[^\[\]\n]*\]|\{[^{}\n]*\}')


def spelled(value: Any) -> bytes:
    """Return a value as JSON spells it, which TOML mostly takes."""
    if value == BRACKETS:
        return value.encode()
    if value == float("inf"):
        return b"1e999"
    return str(value).encode() if isinstance(value, int) and not isinstance(value, bool) else json.dumps(value).encode()


def mutated(data: bytes, chance: random.Random) -> bytes:
    """Return bytes that differ in one to four places."""
    for _ in range(chance.choice((1, 1, 1, 2, 3, 4))):
        data = chance.choice(WAYS)(data, chance)
    return data


def replaced(data: bytes, chance: random.Random) -> bytes:
    """Put a hostile value in the place of a value."""
    found = [*VALUE.finditer(data)]
    if not found:
        return flipped(data, chance)
    at = chance.choice(found)
    return data[: at.start()] + spelled(chance.choice(HOSTILE)) + data[at.end() :]


def flipped(data: bytes, chance: random.Random) -> bytes:
    """Change a byte."""
    at = chance.randrange(len(data) + 1)
    return data[:at] + bytes([chance.randrange(256)]) + data[at + chance.randrange(2) :]


def cut(data: bytes, chance: random.Random) -> bytes:
    """Cut off the end."""
    return data[: chance.randrange(len(data) + 1)]


def doubled(data: bytes, chance: random.Random) -> bytes:
    """Write a line twice, or many times."""
    lines = data.splitlines(keepends=True) or [b""]
    at = chance.randrange(len(lines))
    return b"".join(lines[:at] + [lines[at]] * chance.choice((2, 3, 300)) + lines[at + 1 :])


def moved(data: bytes, chance: random.Random) -> bytes:
    """Let two lines change their places."""
    lines = data.splitlines(keepends=True) or [b""]
    one, two = chance.randrange(len(lines)), chance.randrange(len(lines))
    lines[one], lines[two] = lines[two], lines[one]
    return b"".join(lines)


def dropped(data: bytes, chance: random.Random) -> bytes:
    """Leave out some bytes."""
    at = chance.randrange(len(data) + 1)
    return data[:at] + data[at + chance.randrange(1, 20) :]


def put_in(data: bytes, chance: random.Random) -> bytes:
    """Put something in between, or in the place of a word."""
    token = chance.choice(TOKENS)
    words = data.split(b" ")
    if chance.randrange(2) and len(words) > 1:
        words[chance.randrange(len(words))] = token
        return b" ".join(words)
    at = chance.randrange(len(data) + 1)
    return data[:at] + token + data[at:]


WAYS = (replaced, replaced, replaced, flipped, cut, doubled, moved, dropped, put_in, put_in)


class Trouble(AssertionError):
    """A mutated file that was neither read nor refused, or did more than it may; the message has its bytes."""


def read_watched(samples: Samples, watch: Watch, kind: str, path: Path, data: bytes) -> str:
    """Read a file that has other bytes; return "read" or "refused".

    Raises:
        Trouble: it was neither, took too long, or did more than it may.
    """
    where = f"{path.name}: {data[:3000]!r}"
    try:
        with watch.on(), limited(SECONDS):
            found = samples.read(kind, path, data)
    except (Exception, Hangs) as error:
        raise Trouble(f"{error!r} of {where}") from error
    if watch.seen:
        seen, watch.seen = watch.seen, []
        raise Trouble(f"{seen} by {where}")
    return found


def read_mutated(samples: Samples, watch: Watch, kind: str, numbers: range) -> Counter[str]:
    """Read the mutated files of a kind with these numbers; return how many were read and refused.

    Raises:
        Trouble: one of them was neither, or did more than it may.
    """
    found: Counter[str] = Counter()
    for number in numbers:
        chance = random.Random(f"{kind} {number}")
        path = chance.choice(samples.paths[kind])
        found[read_watched(samples, watch, kind, path, mutated(samples.data[path], chance))] += 1
    return found


class Hangs(BaseException):
    """A file is not read in the time that it may take; nobody catches this."""


@contextmanager
def limited(seconds: int) -> Iterator[None]:
    """End whatever works longer, be the machine busy or not; where the system has no such alarm, nothing is ended."""
    if not hasattr(signal, "SIGPROF"):
        yield
        return

    def ring(*_: object) -> None:
        raise Hangs(f"more than {seconds} s")

    before = signal.signal(signal.SIGPROF, ring)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def main(count: int, first: int = 0) -> int:
    """Read so many mutated files, of all kinds by turns; print what was found. Returns the exit status."""
    import resource

    failures = []
    with tempfile.TemporaryDirectory() as folder:
        samples = Samples(Path(folder))
        watch = Watch(Path(folder))
        totals: dict[str, Counter[str]] = {kind: Counter() for kind in READERS}
        for number in range(first, first + count):
            kind = [*READERS][number % len(READERS)]
            try:
                totals[kind] += read_mutated(samples, watch, kind, range(number, number + 1))
            except Trouble as trouble:
                failures.append(f"{kind} {number}: {trouble}")
        memory_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        unit = 1024 if sys.platform == "darwin" else 1
    print(
        json.dumps(
            {
                "files": {kind: dict(total) for kind, total in totals.items()},
                "kb": memory_kb // unit,
                "failures": failures,
            }
        )
    )
    return int(bool(failures))


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
