"""What holds of the core as a program: warnings, sizes, what it calls, and random bytes under sanitizers."""

from __future__ import annotations

import os
import re
import shutil
import subprocess

import numpy as np
import pytest

from slewline.chips.gs_c200 import profile

from . import library
from .library import CORE, FLAGS, HERE, Event

pytestmark = pytest.mark.system

CROSS = "arm-none-eabi-gcc"
PROCESSORS = {"Cortex-M0+": ("-mcpu=cortex-m0plus",), "Cortex-M33": ("-mcpu=cortex-m33", "-mfloat-abi=soft")}
CALLED = {"memcpy", "memmove", "memset", "sqrt"}  # of the library of C
STRICT = (
    "-std=c11",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Werror",
    "-Wpedantic",
    "-Wshadow",
    "-Wstrict-prototypes",
    "-Wundef",
)
MS, S = 10**9, 10**12
OPEN = 0x7EBF & ~0x38  # levels: 9600 baud, point to point, without checksums, REC high
SANITIZERS = ("-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
SEEDS, BYTES, LONG_BYTES = 5, 1_000_000, 10_000_000


def run(*command):
    """Run a command, and return what it prints."""
    ran = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False, timeout=900)
    assert (ran.returncode, ran.stderr) == (0, ""), ran.stderr
    return ran.stdout


def objects(tmp_path, compiler, *flags):
    """Compile the core; return the files."""
    for path in library.sources():
        run(compiler, *STRICT, *flags, "-c", path, "-o", tmp_path / f"{path.stem}.o")
    return sorted(tmp_path.glob("*.o"))


def test_it_compiles_without_a_warning_and_calls_nothing_but_copying_and_a_root(tmp_path):
    library.need()
    made = objects(tmp_path, library.COMPILER, "-O2", "-fno-builtin")
    needed, defined = set(), set()
    for line in run("nm", *made).splitlines():
        match = re.fullmatch(r"[0-9a-f ]*([A-Z]) (\w+)", line.strip())
        if match:
            (needed if match[1] == "U" else defined).add(match[2])
    theirs = {"gsc_on_pin", "gsc_on_step", "gsc_on_character", "gsc_on_store", "gsc_recall"}
    assert theirs <= needed - defined <= theirs | CALLED | {"_GLOBAL_OFFSET_TABLE_", "__stack_chk_fail"}


@pytest.mark.parametrize("processor", PROCESSORS)
def test_it_is_small(tmp_path, processor):
    if shutil.which(CROSS) is None:
        if os.environ.get("CI"):
            pytest.fail(f"{CROSS}: not installed; this test must not be skipped in CI")
        pytest.skip(f"{CROSS}: not installed")
    made = objects(
        tmp_path,
        CROSS,
        "--specs=picolibc.specs",
        "-Os",
        "-mthumb",
        *PROCESSORS[processor],
        "-ffunction-sections",
        "-fstack-usage",
    )
    sizes = [list(map(int, line.split()[:3])) for line in run("arm-none-eabi-size", *made).splitlines()[1:]]
    code, data, bss = map(sum, zip(*sizes, strict=True))
    assert 4000 < code < 12_000 and data == bss == 0  # all that it knows is in the struct of its user
    stacks = [int(line.split("\t")[1]) for path in tmp_path.glob("*.su") for line in path.read_text().splitlines()]
    assert max(stacks) < 300


def test_the_state_of_a_part_is_less_than_a_kilobyte(tmp_path):
    library.need()
    source = tmp_path / "size.c"
    source.write_text(
        '#include "gsc200.h"\n#include <stdio.h>\nint main(void) { printf("%zu", sizeof(struct gsc)); }\n'
    )
    run(library.COMPILER, f"-I{CORE}", source, "-o", tmp_path / "size")
    assert 400 < int(run(tmp_path / "size")) < 1000


def fuzz(tmp_path, seeds, count):
    """Return how many bytes, steps, motions, answers and programs there were for each seed."""
    library.need()
    program = tmp_path / "fuzz"
    run(library.COMPILER, *FLAGS, *SANITIZERS, f"-I{CORE}", *library.sources(), HERE / "fuzz.c", "-lm", "-o", program)
    return [list(map(int, re.findall("[0-9]+", run(program, seed, count)))) for seed in seeds]


@pytest.mark.timeout(300)
def test_random_bytes(tmp_path):
    for found, steps, motions, answers, kept in fuzz(tmp_path, range(1, 1 + SEEDS), BYTES):
        assert found >= BYTES and steps > BYTES / 4 and motions > 500 and answers > BYTES / 20 and kept > 100


@pytest.mark.long
@pytest.mark.timeout(3600)
def test_a_hundred_million_random_bytes(tmp_path):
    assert sum(counts[0] for counts in fuzz(tmp_path, range(101, 111), LONG_BYTES)) >= 10 * LONG_BYTES


# ------------------------------------------------------------------------------------------ what no dialogue can show
def typed(text, since):
    """Return the characters of a text, a millisecond each from an instant on (ps)."""
    return [Event(since + n * MS, library.CHARACTER, ord(c), since + n * MS + MS // 4) for n, c in enumerate(text)]


def test_characters_before_the_end_of_the_reset_pulse_do_not_count(core):
    early = [Event(0, library.ON, OPEN), Event(10**8, library.CHARACTER, ord("V"), 2 * 10**8)]
    found = core.play("gs-c200s", [*early, *typed("F\r", 10 * MS), Event(S, library.END)])
    assert bytes(code for _, code in found.characters) == b"R\r"


@pytest.mark.parametrize("part", ["gs-c200", "gs-c200s"])
@pytest.mark.parametrize(
    ("start", "top", "ramp"),
    [(1, 2, 999), (1, 9, 777), (31, 279, 777), (999, 1000, 999), (1, 1000, 1), (500, 500, 9), (7, 3, 2)],
)
def test_the_longest_ramps_are_those_of_the_model(core, part, start, top, ramp):
    begin = "P" if part == "gs-c200" else "Po"
    lines = "".join(f"{text}\r" for text in (begin, f"S{start}", f"T{top}", f"R{ramp}", "+2500", "E"))
    found = core.play(part, [Event(0, library.ON, OPEN), *typed_slowly(lines), Event(900 * S, library.END)])
    intervals = [interval for interval, count in profile.move(2500, start, top, ramp).runs for _ in range(count)]
    assert np.diff(found.times).tolist() == intervals[:-1]


def test_the_upper_end_of_the_counter_of_a_gs_c200(core):
    lines = "".join(f"{text}\r" for text in ("P", "S1000", "T1000", "R1", "G9999999", "A1", "+1", "C1", "E"))
    program = [Event(0, library.ON, OPEN), *typed_slowly(lines)]
    asked = [event for number, text in enumerate(("F\r", "V1\r", "V2\r")) for event in typed(text, (1002 + number) * S)]
    found = core.play("gs-c200", [*program, *asked, Event(1010 * S, library.END)])
    assert bytes(code for _, code in found.characters).endswith(b"Y\rE5\rV9999999\rV71\r")


def typed_slowly(text):
    """Return the characters of a text, 20 ms each."""
    return [Event(20 * MS * n, library.CHARACTER, ord(c), 20 * MS * n + MS // 4) for n, c in enumerate(text, 1)]
