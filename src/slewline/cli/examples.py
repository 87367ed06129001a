"""slewline examples: lists them, and copies one out; the package brings them along."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path

import click

from ..bench.files.examples import files, folder, title
from ..core.messages.near import hint
from ..errors import UsageError
from ..record.whole_file import WholeFile
from .demo import made

LEAN = (".toml", ".c")  # on files next to them, which come along


def find(root: Path, name: str) -> list[Path]:
    """Return the files that a name means: a folder, a file, or a file without its folder or its ending.

    Raises:
        UsageError: none; the message names the command that lists them.
    """
    name = name.replace("\\", "/").rstrip("/")
    everything = {path.relative_to(root).as_posix(): path for path in files(root)}
    exact = [path for place, path in everything.items() if place == name or place.startswith(f"{name}/")]
    by_name = [path for path in everything.values() if path.name == name]
    by_stem = [path for path in everything.values() if path.stem == name]
    if found := exact or by_name or by_stem:
        leaning = {path.parent for path in found if path.suffix in LEAN}
        return [path for path in everything.values() if path in found or path.parent in leaning]
    near = hint(name, [word for place, path in everything.items() for word in (place, path.name, path.stem)])
    raise UsageError(f"no example {name!r}; slewline examples lists them{near}")


def copied(root: Path, found: Iterable[Path], output: str) -> Iterator[Path]:
    """Copy files with their folders; yield where each has gone.

    Raises:
        UsageError: another file is there; nothing is written then.
    """
    places = {path: made(output) / path.relative_to(root) for path in found}
    for path, place in places.items():
        known = not place.is_symlink() and place.is_file() and place.read_bytes() == path.read_bytes()
        if os.path.lexists(place) and not known:
            raise UsageError(f"{place}: this file exists and differs; give another folder with --output")
    for path, place in places.items():
        made(str(place.parent))
        with WholeFile(place, own=True) as file:
            file.write(path.read_bytes())
        yield place


def examples(name: str | None, output: str) -> int:
    """List the examples, or copy one out; returns the exit status."""
    root = folder()
    if name is not None:
        for written in copied(root, find(root, name), output):
            click.echo(f"wrote {written}")
        return 0
    everything = {path.relative_to(root).as_posix(): path for path in files(root)}
    width = max(map(len, everything))
    for place, path in everything.items():
        click.echo(f"{place:<{width}}  {title(path)}")
    click.echo("\nslewline examples NAME copies one here; a folder, such as drill, with all that is in it.")
    return 0
