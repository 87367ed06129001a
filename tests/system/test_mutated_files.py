"""Files that somebody has damaged, by chance or with a purpose: an error of ours, or they are read; nothing else."""

from __future__ import annotations

import json
import signal
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from random import Random

import pytest

import slewline
from slewline.bench.file import BenchFile
from slewline.errors import LONGEST_LINE, SlewlineError
from slewline.links.lines.store import FileStore

SHORT, LONG = 25, 16  # mutations of each kind in a short run; so many times the seeds in a long one
SHARES = {"journal": 700, "vcd": 700, "bench": 350, "hex": 125, "state": 125}  # 2000 a seed of the long run
LONGEST = LONGEST_LINE + 50  # characters of a message
HANGS_S = 8  # of work of the processor
TOKENS = [
    b"0",
    b"-1",
    b"1e400",
    b"9" * 5000,
    b"null",
    b"{}",
    b"[" * 3000,
    b"\x00",
    b"\xff",
    b"\n",
    b'"',
    b"a" * 100_000,
]
TOKENS += [b"=", b"$end", b"#", b"b" + b"10" * 2000, b"true", b"18446744073709551616", b".", b"'" * 3, b":" * 40]
VALUES = [None, -1, 0, 1, 7, 10**20, 0.5, "", "x", "y", "x.abort", [], [None], {}, {"a": 1}, True]
BENCH = """[bench]
seed = 5
until = "20 ms"
[[chip]]
part = "cy525"
name = "x"
crystal = "6 MHz"
straps = { ascii_binary = 1 }
options = { rate = 80 }
[[chip]]
part = "gs-c200s"
name = "y"
[[part]]
kind = "inverter"
name = "not"
[[wire]]
from = "x.programmable_output"
to = "not.in1"
[[host]]
chips = ["x"]
script = ["A 0", "N 12", "G"]
[[drive]]
pin = "x.abort"
level = 1
at = "5 ms"
[[record]]
pins = ["x.slew"]
"""


@cache
def originals(folder: str) -> dict[str, bytes]:
    """A good file of each kind."""
    bench = slewline.Bench(journal=f"{folder}/journal")
    x, y = bench.add("cy525", "x"), bench.add("gs-c200s", "y", eeprom_time=0)
    bench.part("motor", "m")
    bench.part("prom", "p", image=bytes(range(64)))
    host = bench.host(x, name="pc")
    bench.host(y, name="other")
    bench.record()
    host.send("A 0\rN 20\rG\r")
    bench.at("3 ms", lambda: bench.pin("x.abort").drive(1))
    bench.run("20 ms")
    bench.save_vcd(f"{folder}/vcd", values=True)
    Path(f"{folder}/bench").write_text(BENCH)
    slewline.write_image(f"{folder}/image.hex", bytes(range(256)) * 2)
    store = FileStore(f"{folder}/state")
    for n in range(5):
        store.append(bytes([n]) * 40, n * 10)
    files = {"journal": "journal", "vcd": "vcd", "bench": "bench", "hex": "image.hex", "state": "state"}
    return {kind: Path(folder, name).read_bytes() for kind, name in files.items()}


def mutated(data: bytes, chance: Random) -> bytes:
    """The data with one to four changes: bytes, tokens, lines, values of entries."""
    for _ in range(chance.randint(1, 4)):
        at, to = sorted(chance.randrange(len(data) + 1) for _ in range(2))
        to = min(to, at + chance.choice((1, 5, 60, 10**9)))
        lines = data.split(b"\n")
        number = chance.randrange(len(lines))
        how = chance.randrange(8)
        if how == 0:
            data = data[:at] + bytes(chance.randrange(256) for _ in range(chance.randint(1, 4))) + data[at + 1 :]
        elif how == 1:
            data = data[:at] + chance.choice(TOKENS) + data[at:]
        elif how == 2:
            data = data[:at] + data[to:]
        elif how == 3:
            data = data[:to] + data[at:to] + data[to:]
        elif how == 4:
            data = b"\n".join([*lines[:number], *lines[number + 1 :]])
        elif how == 5:
            lines.insert(chance.randrange(len(lines)), lines[number])
            data = b"\n".join(lines)
        elif how == 6:
            words = lines[number].split(b" ")
            words[chance.randrange(len(words))] = chance.choice(TOKENS)
            lines[number] = b" ".join(words)
            data = b"\n".join(lines)
        else:
            lines[number] = changed(lines[number], chance)
            data = b"\n".join(lines)
    return data


def changed(line: bytes, chance: Random) -> bytes:
    """An entry of a journal in which a field has another value, or is gone; another line as it is."""
    try:
        entry = json.loads(line)
        name = chance.choice(sorted(entry))
    except (ValueError, TypeError, IndexError, RecursionError):
        return line
    del entry[name]
    if chance.random() < 0.7:
        entry[name] = chance.choice(VALUES)
    return json.dumps(entry).encode()


READ: dict[str, Callable[[Path], object]] = {
    "journal": lambda path: slewline.replay(path, until="25 ms"),
    "vcd": lambda path: slewline.read_vcd(path).edges("x.slew"),
    "bench": lambda path: BenchFile(path).load().run("25 ms"),
    "hex": slewline.read_image,
    "state": lambda path: FileStore(path).read(),
}


@contextmanager
def alarm(seconds: int) -> Iterator[None]:
    """What hangs is ended by an error that nobody catches: it has worked for so long, be the machine busy or not."""

    def ring(*_: object) -> None:
        raise BaseException(f"hangs for more than {seconds} s")

    before = signal.signal(signal.SIGPROF, ring)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def faults(kind: str, seed: int, count: int, folder: Path) -> tuple[int, list[str]]:
    """Return how many mutated files were refused, and which went wrong: another exception, a long text."""
    chance, good = Random(f"{kind} {seed}"), originals(str(folder))[kind]
    path, refused, wrong = folder / f"mutated{'.hex' if kind == 'hex' else ''}", 0, []
    for number in range(count):
        path.write_bytes(mutated(good, chance))
        try:
            with alarm(HANGS_S), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                READ[kind](path)
        except SlewlineError as error:
            refused += 1
            if len(str(error)) > LONGEST:
                wrong.append(f"{kind} {seed}, {number}: {len(str(error))} characters: {str(error)[:200]}")
        except BaseException as error:
            wrong.append(f"{kind} {seed}, {number}: {error!r:.300}")
            (folder / f"wrong-{kind}-{seed}-{number}").write_bytes(path.read_bytes())
    return refused, wrong


@pytest.mark.posix
@pytest.mark.parametrize("kind", READ)
def test_mutated_files_are_read_or_refused(tmp_path, kind):
    refused, wrong = faults(kind, 0, SHORT * SHARES[kind] // 700 + SHORT, tmp_path)
    assert wrong == []
    assert refused > SHORT // 2


@pytest.mark.posix
@pytest.mark.long
@pytest.mark.parametrize("seed", range(1, LONG + 1))
@pytest.mark.parametrize("kind", READ)
def test_32_000_mutated_files_are_read_or_refused(tmp_path, kind, seed):
    refused, wrong = faults(kind, seed, SHARES[kind], tmp_path)
    print(f"{kind}, seed {seed}: {SHARES[kind]} files, {refused} refused")
    assert wrong == []
    assert refused > SHARES[kind] // 3
