"""Executes a lesson as Jupyter does, and keeps what its cells print: the prose of a lesson quotes these figures."""

from __future__ import annotations

import os
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import nbformat
from nbclient import NotebookClient
from traitlets.config import Config

from .blocks import ROOT

LESSONS = sorted((ROOT / "docs/lessons").glob("*.ipynb"))
PRINTED = Path(__file__).parent / "printed"
CLOCK = "import time; print(time.process_time())"


class Played(NamedTuple):
    """What came of a lesson: what each cell printed, what it showed, and the seconds of a processor."""

    printed: str
    shown: list[dict[str, Any]]
    seconds: float


def play(lesson: Path, folder: Path) -> Played:
    """Execute all cells of a lesson in a folder; a cell that fails is an error."""
    book = nbformat.read(lesson, as_version=4)
    book.cells.append(nbformat.v4.new_code_cell(CLOCK))
    with TemporaryDirectory() as sockets:
        # By a port a kernel may not be reached: one that was free when it was looked for may be taken meanwhile.
        named = {"transport": "ipc", "ip": f"{sockets}/kernel"} if os.name == "posix" else {}
        where = {"metadata": {"path": str(folder)}}
        config = Config({"KernelManager": named})
        NotebookClient(book, timeout=100, kernel_name="python3", resources=where, config=config).execute()
    cells = [cell for cell in book.cells if cell.cell_type == "code"]
    printed = [
        f"--- {cell.id}\n{text}" for cell in cells[:-1] if (text := "".join(said(output) for output in cell.outputs))
    ]
    shown = [output.data for cell in cells for output in cell.outputs if "data" in output]
    return Played("".join(printed), shown, float(said(cells[-1].outputs[0])))


def said(output: Any) -> str:
    """What an output of a cell adds to its text; a warning fails."""
    if output.output_type != "stream":
        return ""
    assert output.name == "stdout", output.text
    return str(output.text)


def printed_by(lesson: Path) -> Path:
    """The file that keeps what a lesson prints."""
    return PRINTED / f"{lesson.stem}.out"
