"""slewline new-chip, new-part: write a package of the user's own, whose tests pass from the start.

The templates form such a package, but with placeholder words (see `words`).  Files for every package are
in the folder `both`; files only for a chip or only for a part are in `chip` or `part`.
"""

from __future__ import annotations

import builtins
import os
import re
import shutil
from collections.abc import Mapping
from importlib.util import find_spec
from keyword import iskeyword
from pathlib import Path
from typing import Literal

import click

from ... import build
from ...bench.files.shipped_files import named, title
from ...chips import CATALOGUE as CHIPS
from ...errors import UsageError
from ...parts import CATALOGUE as PARTS
from ..demo import made

Kind = Literal["chip", "part"]

SHAPE = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")
LONGEST = 30  # characters of a name: no line of a template may get longer than ruff allows
EXTENSIONS = {"bin", "hex", "json", "toml", "txt"}  # the extension of a program is the name of its chip
MEANT = {"src", "test", "tests"}  # folders of a package
DEVICES = {"aux", "con", "nul", "prn", *(f"{port}{n}" for port in ("com", "lpt") for n in range(10))}  # of Windows


def new(kind: Kind, name: str, output: str) -> int:
    """Write a package with a chip or a part of the user's own; return the exit status."""
    check_shape(kind, name)
    place = Path(output) / name
    if os.path.lexists(place):
        raise UsageError(f"{place} exists already; give another name, or another folder with --output")
    check_free(kind, name)
    texts = rendered(kind, name)
    made(output)
    write_whole(place, texts)
    width = max(len(str(place / path)) for path in texts)
    for path in texts:
        click.echo(f"{place / path!s:<{width}}  {title(place / path)}".rstrip())
    click.echo(f"\nThe generated package passes its tests: pytest {place}\n{place / 'README.md'} has the next steps.")
    return 0


def words(kind: Kind, name: str) -> dict[str, str]:
    """Return the text that replaces each template word, keyed by that word."""
    return {
        "new-name": name,
        "NEW-NAME": name.upper(),
        "new_name": name.replace("-", "_"),
        "NewName": "".join(map(str.capitalize, name.split("-"))),
        "new-kind": kind,
        "new_kind": kind,
    }


def check_shape(kind: Kind, name: str) -> None:
    """Check that a name can be used for a package, a module, a class and a file.

    Raises:
        UsageError: the name cannot be used; the message describes the allowed names.
    """
    if SHAPE.fullmatch(name) and len(name) <= LONGEST:
        return
    near = re.sub(r"^[^a-z]+", "", re.sub(r"[^a-z0-9]+", "-", name.lower()))[:LONGEST].strip("-")
    remedy = f"; did you mean {near}?" if SHAPE.fullmatch(near) else ""
    raise UsageError(
        f"new-{kind} {name!r}: expected lower-case letters, digits and single hyphens, beginning with a letter, at "
        f"most {LONGEST} characters, such as mx10{remedy}"
    )


def check_free(kind: Kind, name: str) -> None:
    """Check that a name is neither in use nor reserved.

    Raises:
        UsageError: the name is in use or reserved; the message states the reason.
    """
    module, cls = (words(kind, name)[word] for word in ("new_name", "NewName"))
    if {name, module} & {*(CHIPS if kind == "chip" else PARTS).names()}:
        why = f"is a {kind} that exists already"
    elif iskeyword(module) or iskeyword(cls):
        why = "is a keyword of Python"
    elif hasattr(builtins, cls) or cls in build.__all__:
        why = f"would have the class {cls}, a name in use by Python or slewline.build"
    elif module in MEANT or getattr(find_spec(module), "origin", None) is not None:
        why = f"would be the module {module}, whose name is in use"
    elif name in EXTENSIONS:
        why = f"would have programs that end in .{name}, like other kinds of files"
    elif name in DEVICES:
        why = "is a reserved device name of Windows"
    else:
        return
    raise UsageError(f"new-{kind} {name!r}: {why}; give another name, such as my-{name}")


def rendered(kind: Kind, name: str) -> dict[Path, bytes]:
    """Return the contents of a package's files, keyed by path within it; files in upper folders come first."""
    table = words(kind, name)
    pattern = re.compile("|".join(table))

    def filled(text: str) -> str:
        return pattern.sub(lambda found: table[found[0]], text)

    found = {}
    for template, path in named("templates").items():
        top, _, place = template.partition("/")
        if top in ("both", kind):
            found[Path(filled(place))] = filled(path.read_text("utf-8")).encode("utf-8")
    return {path: found[path] for path in sorted(found, key=lambda path: (len(path.parts), path))}


def write_whole(place: Path, texts: Mapping[Path, bytes]) -> None:
    """Write a folder of files, completely or not at all.

    Raises:
        UsageError: the system refuses to write; no file is left.
    """
    part = place.with_name(f".slewline-{os.getpid()}.part")
    try:
        part.mkdir()  # a new folder, not one of another program
        for path, text in texts.items():
            (part / path).parent.mkdir(parents=True, exist_ok=True)
            (part / path).write_bytes(text)
        part.rename(place)
    except OSError as error:
        why = f"{place} cannot be written ({error.strerror})"
        raise UsageError(f"{why}; give another folder with --output") from None
    finally:
        shutil.rmtree(part, ignore_errors=True)
