"""Host scripts in Python, with pySerial on a pseudo-terminal; at its other end is grbl, as the reader has it."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import pytest

from slewline.translation.reading_back.grbl_reader import Machine
from slewline.translation.reading_back.surroundings import RefusedLine
from slewline.translation.target_writer import WriterOptions

from .ten import TEN, agree, of_part, stretches, written

pytestmark = [pytest.mark.system, pytest.mark.posix]
THREE = [case for case in TEN if case.file in ("handoff.cy525", "weld.cy525", "two_ramps.gs-c200")]
PINS = {1: "P", 2: "X"}


@contextmanager
def board(levels: dict[int, int]) -> Iterator[tuple[Machine, str]]:
    """A grbl on a pseudo-terminal, and the name of the host's end."""
    import pty
    import tty

    machine = Machine(WriterOptions())
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    pins = "".join(PINS[number] for number, level in levels.items() if not level)

    def serve() -> None:
        line = b""
        with suppress(OSError):
            while byte := os.read(ours, 1):
                if byte == b"?":
                    os.write(ours, machine.status(pins).encode() + b"\r\n")
                elif byte == b"\n":
                    os.write(ours, answered(machine, line.decode()).encode() + b"\r\n")
                    line = b""
                else:
                    line += byte

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    try:
        yield machine, os.ttyname(theirs)
    finally:
        os.close(theirs)
        os.close(ours)
        thread.join(5)


def answered(machine: Machine, line: str) -> str:
    """Return what grbl answers to a line."""
    try:
        machine.line(1, line)
    except RefusedLine as error:
        return f"error:1 {error}"
    return "ok"


@pytest.mark.parametrize("case", THREE, ids=lambda case: case.file)
def test_steps_are_those_of_the_part(case, tmp_path):
    levels = {"wait": 1, "dowhile": 2}
    with board({levels[pin]: level for pin, level in case.levels.items()}) as (machine, port):
        script = tmp_path / "program.py"
        script.write_text(written(case, "python", port=port), encoding="utf-8")
        subprocess.run([sys.executable, str(script)], check=True, timeout=60)
        moves = [each.value for each in machine.around.happened if each.kind == "move"]
    agree(stretches(moves), of_part(case, tmp_path), case)


def test_an_error_of_the_board_ends_the_script_with_the_line(tmp_path):
    case = THREE[-1]
    with board({}) as (_, port):
        script = tmp_path / "program.py"
        script.write_text(written(case, "python", port=port).replace("G91 G1", "G91 G77"), encoding="utf-8")
        ran = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=60, check=False)
    assert ran.returncode == 1
    assert "G91 G77 X3000: error:1" in ran.stderr
