"""slewline examples: list the examples that come with the package, or copy one out."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path

import click

from ..bench.files.shipped_files import named, title
from ..core.messages.near import hint
from ..errors import UsageError
from ..record.whole_file import WholeFile
from .demo import made

LEAN = (".toml", ".c")  # may use files next to them, which are copied too


def find(everything: Mapping[str, Path], name: str) -> dict[str, Path]:
    """Return the files selected by a folder's name or a file's name, with or without its folder and extension.

    A .toml or .c file also selects all other files in its folder.

    Raises:
        UsageError: there is no such file; the message names the command that lists the examples.
    """
    name = name.replace("\\", "/").rstrip("/")
    exact = [path for place, path in everything.items() if place == name or place.startswith(f"{name}/")]
    by_name = [path for path in everything.values() if path.name == name]
    by_stem = [path for path in everything.values() if path.stem == name]
    if found := exact or by_name or by_stem:
        leaning = {path.parent for path in found if path.suffix in LEAN}
        return {place: path for place, path in everything.items() if path in found or path.parent in leaning}
    near = hint(name, [word for place, path in everything.items() for word in (*path_words(place), path.stem)])
    raise UsageError(f"no example {name!r}; `slewline examples` lists them{near}")


def path_words(place: str) -> tuple[str, ...]:
    """Return the names by which an example can be found: its path, its folders, its file name."""
    return (place, *Path(place).parts)


def copied(found: Mapping[str, Path], output: str) -> Iterator[Path]:
    """Copy files along with their folders; yield the path of each copy.

    Raises:
        UsageError: a different file already exists; then no file is written.
    """
    places = {made(output) / name: path for name, path in found.items()}
    for place, path in places.items():
        known = not place.is_symlink() and place.is_file() and place.read_bytes() == path.read_bytes()
        if os.path.lexists(place) and not known:
            raise UsageError(f"{place}: this file exists and differs; give another folder with --output")
    for place, path in places.items():
        made(str(place.parent))
        with WholeFile(place, own=True) as file:
            file.write(path.read_bytes())
        yield place


def examples(name: str | None, output: str) -> int:
    """List the examples, or copy one out; return the exit status."""
    everything = named()
    if name is not None:
        for written in copied(find(everything, name), output):
            click.echo(f"wrote {written}")
        return 0
    width = max(map(len, everything))
    for place, path in everything.items():
        click.echo(f"{place:<{width}}  {title(path)}")
    click.echo("\nslewline examples NAME copies one here; a folder, such as drill or lessons, with all that is in it.")
    return 0
