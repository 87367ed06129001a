"""What `slewline` and `slewline.build` export is loaded when it is asked for; names of objects stand on a page."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from inspect import getattr_static
from pathlib import Path

import pytest

import slewline
import slewline.build
from slewline.chips import PARTS
from slewline.core.chip import Chip
from slewline.core.messages.instead import Instead
from slewline.drive.board.rehearsal import TwinPort
from slewline.drive.motor_drive import Drive
from slewline.links.lines.pace import Lockstep
from slewline.links.server import Server
from slewline.modules.module import Module
from slewline.modules.speech import speech_of
from slewline.parts import KINDS, part_class
from slewline.parts.base.part import Part
from slewline.parts.hosts.host import Host
from tests.docs import entries


def loaded(statement: str) -> set[str]:
    """The modules that a statement loads."""
    code = f"import sys; before = {{*sys.modules}}; {statement}; print(*{{*sys.modules}} - before)"
    return set(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.split())


def ours(modules: set[str]) -> set[str]:
    """Those of slewline."""
    return {name for name in modules if name.startswith("slewline")}


@pytest.mark.system
def test_only_requested_modules_are_loaded() -> None:
    light = {"slewline", "slewline.lazy", "slewline.version"}
    assert ours(loaded("import slewline")) == light
    assert ours(loaded("import slewline.build")) == {*light, "slewline.build"}
    assert "slewline.core.datasheet.table" in (sheet := loaded("from slewline.build import Row, Sheet"))
    assert not sheet & {"slewline.core.chip", "slewline.parts", "slewline.chips", "slewline.bench"}


def within(modules: set[str], *layers: str) -> set[str]:
    """The modules of some layers."""
    return {name for name in modules if name.startswith(tuple(f"slewline.{layer}." for layer in layers))}


@pytest.mark.system
def test_an_empty_bench_loads_no_chip_no_language_no_host_and_nothing_that_draws() -> None:
    empty = loaded("import slewline; slewline.Bench()")
    assert within(empty, "chips", "language", "parts", "record", "links") == {
        "slewline.parts.base",
        "slewline.parts.base.recent",
        "slewline.parts.base.part",
    }
    asked = {"bench", "circuit", "hosting", "pictures", "runner", "wiring"}
    drawn = {"bench_pictures", "named_curves", "picture_options", "signals", "timing", "track_notes", "waveform_files"}
    asked |= {f"pictures.{name}" for name in drawn}
    assert within(empty, "bench") == {f"slewline.bench.{name}" for name in asked}
    assert not within(empty, "core") & {
        f"slewline.core.{name}" for name in ("motion.deviation", "motion.ideal_motion", "wires.serial")
    }
    assert not empty & {"difflib", "json", "numpy", "pathlib", "textwrap"}


@pytest.mark.system
@pytest.mark.parametrize(
    ("part", "host", "speech"),
    [("cy525", "bus_host", "text"), ("gs-c200", "serial_host", "lines"), ("mc1451a", "packet_host", "packets")],
)
def test_a_chip_brings_its_own_language_and_its_own_host(part: str, host: str, speech: str) -> None:
    furnished = loaded(f"import slewline; bench = slewline.Bench(); bench.host(bench.add({part!r}))")
    hosts = {"slewline.parts.hosts.bus_host", "slewline.parts.hosts.serial_host", "slewline.parts.hosts.packet_host"}
    assert furnished & hosts == {f"slewline.parts.hosts.{host}"}
    spoken = {"slewline.language.text", "slewline.language.lines", "slewline.language.packets"}
    assert furnished & spoken == {f"slewline.language.{speech}"}
    assert not within(furnished, "record")


@pytest.mark.parametrize("face", [slewline, slewline.build])
def test_a_face_has_the_names_that_it_lists_and_no_others(face) -> None:
    assert set(face.__all__) - {"__version__"} <= set(dir(face))
    for name in face.__all__:
        assert getattr(face, name) is vars(face)[name]  # it stays there
    with pytest.raises(AttributeError, match=f"module '{face.__name__}' has no attribute 'nonsense'"):
        face.nonsense  # noqa: B018


# ------------------------------------------------------------------------------------------------------ public names
PAGES = Path(__file__).parents[2] / "docs/reference"
FOR_USERS = ("api.md", "parts.md", *(f"api/{page.name}" for page in entries.PAGES if page.name != "build.md"))
FOR_AUTHORS = (*FOR_USERS, "build.md", "api/build.md")
OF_USERS = frozenset().union(*(names for cls, names in entries.MEMBERS.items() if cls is not Part))  # for users
MOST = {Chip: 87, Host: 63, object: 48}  # public names of a chip, of a host, of anything else
GIVEN = {"prom": {"image": b"\xff"}, "switch": {"low": 0}}  # to parts that must be told something


def written(*pages: str) -> set[str]:
    """The names in code on pages, and those of the entries for users."""
    code = [
        found for page in pages for found in re.findall(r"(?s)```.*?```|`[^`\n]+`", (PAGES / page).read_text("utf-8"))
    ]
    return OF_USERS.union(re.findall(r"[A-Za-z]\w*", " ".join(code)))


def public(thing: object) -> set[str]:
    """The names without underscore of an object; what only says what there is instead is none."""
    names = (name for name in object.__dir__(thing) if not name.startswith("_"))
    return {name for name in names if not isinstance(getattr_static(thing, name, None), Instead)}


class Nowhere:
    """The port of a module that is not there."""

    where = "nowhere"


def outside() -> Iterator[object]:
    """A drive, a server and a real module."""
    bench = slewline.Bench()
    x = bench.add("gs-c200")
    yield slewline.Drive(bench, x, TwinPort(), black_box=False)
    yield Server(bench, Lockstep(bench))
    yield Module(Nowhere(), speech_of(x.sheet))


def everything() -> Iterator[object]:
    """A bench, every chip with a host on each of its sides, every kind of part, and what the outside world has."""
    yield from outside()
    bench = slewline.Bench()
    yield bench
    for part in PARTS:
        x = bench.add(part)
        yield from (x, bench.host(x))
        if len(x.sheet.channels) > 1:
            yield bench.host(x, over="serial")
    shaft = bench.part("motor", "shaft")
    for kind in KINDS:
        yield bench.part(kind, on=shaft if part_class(kind).sits == "must" else None, **GIVEN.get(kind, {}))


def test_every_public_name_is_on_a_page_and_they_are_few() -> None:
    for thing in everything():
        names = public(thing)
        assert names <= written(*FOR_AUTHORS), thing
        assert len(names) <= next(most for cls, most in MOST.items() if isinstance(thing, cls)), thing


def test_dir_lists_names_on_pages_for_users_and_none_for_authors() -> None:
    for thing in everything():
        listed = {name for name in dir(thing) if not name.startswith("_")}
        assert listed <= public(thing) & written(*FOR_USERS), thing
        of_authors = {"kernel", "drivers", "finding", "input", "start", "stop", "queue"}
        assert isinstance(thing, Drive | Server) or not listed & of_authors, thing


def test_every_public_name_of_the_outside_world_has_an_entry_with_its_class() -> None:
    for thing in outside():
        assert public(thing) - entries.named_of(thing) == set(), thing


def test_a_name_that_is_on_no_page_is_noticed() -> None:
    x = slewline.Bench().add("cy525")
    x.unheard_of = 1
    assert public(x) - written(*FOR_AUTHORS) == {"unheard_of"}
    assert not {"send", "db0", "RATE"} & public(x)  # they say what there is instead
