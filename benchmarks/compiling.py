"""C programs of the benchmarks: compiled when they run, if this system has a compiler."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
COMPILER = shutil.which("cc") or shutil.which("gcc")
ABSENT = "no C compiler is installed"


def compiled(source: str, target: Path, *flags: str) -> Path:
    """Compile a C file of this folder; return the result."""
    assert COMPILER is not None, ABSENT
    subprocess.run([COMPILER, "-O2", *flags, "-o", str(target), str(HERE / source)], check=True)
    return target


def step_generator(folder: Path) -> Callable[[np.ndarray, np.ndarray], int]:
    """Return stepgen.c as a function of segments (interval, count, add) and an array for the ticks of their steps."""
    generate = ctypes.CDLL(str(compiled("stepgen.c", folder / "stepgen.so", "-shared", "-fPIC"))).generate
    array = np.ctypeslib.ndpointer(np.int64, flags="C_CONTIGUOUS")
    generate.argtypes, generate.restype = (array, ctypes.c_int64, ctypes.c_int64, array), ctypes.c_int64
    return lambda segments, ticks: int(generate(segments, len(segments), 0, ticks))
