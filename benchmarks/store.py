"""A memory of 64 KB in a file, stored character by character: appended, and as whole files, one for each character.

Both wait for the disk after every character, which takes most of the time.  Some characters are stored, and the total
is extrapolated: from 200 as whole files, short and long ones, and from the last 4,096 as records.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from time import perf_counter

from rows import Row

from slewline.links.lines.memory_file import FileStore

SIZE, TRIED, ADDED = 1 << 16, 100, 1 << 12
CONTENT = bytes(n * 7 % 256 for n in range(SIZE))


def appending(path: Path) -> float:
    """Return the seconds to append every character, from the mean of the last ones."""
    store = FileStore(path)
    store.write(CONTENT[:-ADDED])
    begin = perf_counter()
    for n in range(SIZE - ADDED, SIZE):
        store.append(CONTENT[n : n + 1])
    took = perf_counter() - begin
    assert FileStore(path).read() == CONTENT
    return took / ADDED * SIZE


def writing(path: Path) -> float:
    """Return the seconds to write the whole file for every character, from the mean of short and long ones."""
    store = FileStore(path)
    begin = perf_counter()
    for n in (*range(TRIED), *range(SIZE - TRIED, SIZE)):
        store.write(CONTENT[: n + 1])
    assert store.read() == CONTENT
    return (perf_counter() - begin) / (2 * TRIED) * SIZE


def rows() -> list[Row]:
    with tempfile.TemporaryDirectory() as folder:
        whole, appended = writing(Path(folder) / "whole"), appending(Path(folder) / "appended")
    return [
        Row(
            "64 KB written to a file, one character at a time",
            appended,
            "s",
            None,
            False,
            "extrapolated from the last 4,096 characters: one disk access per character",
        ),
        Row(
            "64 KB written to a file, one character at a time, the whole file each time",
            whole,
            "s",
            None,
            False,
            "extrapolated from 200 characters: disk access, and writing and reading the whole file",
        ),
    ]


if __name__ == "__main__":
    for row in rows():
        print(f"{row.name}: {row.figure:.1f} {row.unit}")
