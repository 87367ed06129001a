"""Programs that know nothing of slewline, and what they say about its files."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import NamedTuple

import pytest


class Annotation(NamedTuple):
    """What a decoder says about samples: from `start` to `stop`, counted from the first instant of the file."""

    start: int
    stop: int
    text: str


PACKAGES = {"vcd2fst": "gtkwave", "fst2vcd": "gtkwave", "xvfb-run": "xvfb"}  # if not of the program's own name


def find(program: str) -> str:
    """Return the path of a program; where it is missing the test is skipped, in CI (`CI` is set) it fails."""
    path = shutil.which(program)
    if path is None:
        reason = f"{program} is not installed; on Debian:  apt install {PACKAGES.get(program, program)}"
        if os.environ.get("CI"):
            pytest.fail(f"{reason}\n.ci/run does it: this test must not be skipped in CI")
        pytest.skip(reason)
    return path


def sigrok(path: Path, decoder: str, rows: str, downsample: int = 1, warned: str = "") -> list[Annotation]:
    """Return what a decoder of sigrok-cli says about a VCD file.

    Args:
        decoder: its name, channels and options, as "uart:rx=rxd:baudrate=9600".
        rows: classes of its annotations, as "speed" or "rx-data:tx-data".
        downsample: units of the file to a sample.
        warned: pattern of what it may complain of.
    """
    name = decoder.partition(":")[0]
    words = ["-I", f"vcd:downsample={downsample}", "-i", str(path), "-P", decoder, "-A", f"{name}={rows}"]
    out = called(["sigrok-cli", *words, "--protocol-decoder-samplenum"], warned)
    lines = [re.fullmatch(r"(\d+)-(\d+) [\w-]+: (.*)", line) for line in out.splitlines()]
    return [Annotation(int(line[1]), int(line[2]), line[3]) for line in lines if line]


def called(words: list[str], warned: str = "") -> str:
    """Return what a program prints; it must end well, and complain of nothing but what is `warned` of.

    Debian 12's sigrok-cli aborts behind its last line, when its Python ends: a decoder with many channels counts one
    reference too few for each.  All is printed by then.
    """
    ran = subprocess.run([find(words[0]), *words[1:]], check=False, capture_output=True, text=True, timeout=60)
    if "bool_dealloc" in ran.stderr and "Python runtime state: finalizing" in ran.stderr:
        return ran.stdout
    complaints = [line for line in ran.stderr.splitlines() if not re.fullmatch(warned, line)]
    assert (ran.returncode, complaints) == (0, []), f"status {ran.returncode}: {ran.stderr}"
    return ran.stdout
