"""Runs a program in LinuxCNC's own interpreter, rs274 (package linuxcnc-uspace), which prints the motions.

rs274 moves no machine: all inputs have the level in parameter 5399, a search for an input ends at its
target, and there are no times.  rs274 is searched for on the PATH; SLEWLINE_RS274 sets another command
for it, including any words before it, such as
"env LD_LIBRARY_PATH=/opt/linuxcnc/lib /opt/linuxcnc/bin/rs274".
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import threading
from collections.abc import Iterable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import IO

from ...lifeline import start
from ..target_writer import PlayedTrace, WriterOptions
from .surroundings import MOST_EVENTS, RefusedLine, Surroundings

AXES = "XYZABC"
READ = re.compile(r"M66 P(\d+) L0")  # an input that decides a branch; a wait ends at any level
MOST_SECONDS = 5.0  # a program that waits in a loop has no end, and prints nothing
CALL = re.compile(r"\s*\d+\s+N\S*\s+([A-Z_0-9]+)\((.*)\)")


def command() -> list[str] | None:
    """Return the words of the command that calls rs274, or None if rs274 is not installed."""
    named = os.environ.get("SLEWLINE_RS274")
    if named:
        return shlex.split(named)
    found = shutil.which("rs274")
    return [found] if found else None


def run(text: str, options: WriterOptions) -> PlayedTrace | None:
    """Return the events of a program in rs274.

    The result is None if rs274 is not installed, or if the program needs input levels that rs274 cannot
    provide: inputs with different levels, or levels that change.

    Raises:
        RefusedLine: rs274 does not accept the program.
    """
    words = command()
    around = Surroundings(options)
    levels = {around.level(int(each) + 1) for each in READ.findall(text)} or {1}
    if words is None or len(levels) > 1 or (around.waits and "M66" in text):
        return None
    with TemporaryDirectory(prefix="slewline-") as folder:
        place = Path(folder)
        (place / "program.ngc").write_text(f"#5399 = {levels.pop()}\n{text}", encoding="utf-8")
        (place / "tools.tbl").write_text("T1 P1 D1 ;\n", encoding="utf-8")
        (place / "parameters.var").touch()
        files = ["-t", str(place / "tools.tbl"), "-v", str(place / "parameters.var"), "-g", str(place / "program.ngc")]
        with (place / "errors").open("w+b") as errors:
            stopped = _called([*words, *files], folder, errors, around)
            errors.seek(0)
            lines = errors.read().decode("utf-8", "replace").splitlines()
    if complaint := [line for line in lines if line.strip() not in ("", "executing")]:
        raise RefusedLine(0, complaint[0], "rs274 refuses the program")
    return around.trace("rs274", stopped)


def _called(words: Sequence[str], folder: str, errors: IO[bytes], around: Surroundings) -> bool:
    """Run rs274, and record the calls that it prints; return whether the program is endless.

    Args:
        words: the command, with its arguments.
        folder: the home folder of rs274.
        errors: the file for its error messages.
        around: the record of the events.
    """
    process = start(words, dict(os.environ) | {"HOME": folder}, errors)
    watch = threading.Timer(MOST_SECONDS, process.kill)
    watch.start()
    try:
        assert process.stdout is not None  # noqa: S101
        return _follow((line.decode("utf-8", "replace") for line in process.stdout), around)
    finally:
        watch.cancel()
        process.kill()
        process.communicate()


def _follow(lines: Iterable[str], around: Surroundings) -> bool:
    """Record the calls in lines that rs274 prints; return whether the program is endless."""
    at = [0.0] * 9
    offset = [0.0] * 9
    for line in lines:
        found = CALL.match(line)
        if not found:
            continue
        name, arguments = found.groups()
        if name == "PROGRAM_END":
            return False
        if name in ("STRAIGHT_FEED", "STRAIGHT_TRAVERSE", "STRAIGHT_PROBE"):
            target = [float(each) + offset[n] for n, each in enumerate(arguments.split(","))]
            for axis, (before, after) in enumerate(zip(at, target, strict=False)):
                spm = around.steps_per_mm
                steps = round(after * spm) - round(before * spm)
                if name == "STRAIGHT_PROBE" and steps:
                    around.run(axis + 1, 1 if steps > 0 else -1)
                else:
                    around.move(axis + 1, steps)
            at[: len(target)] = target
        elif name == "SET_G92_OFFSET":
            offset[:6] = [float(each) for each in arguments.split(",")]
        elif name in ("SET_AUX_OUTPUT_BIT", "CLEAR_AUX_OUTPUT_BIT"):
            around.output(int(arguments) + 1, int(name.startswith("SET")))
        elif name == "DWELL":
            around.delay(round(float(arguments) * 10**12))
        if len(around.happened) >= MOST_EVENTS:
            return True
    return True
