"""What `slewline` and `slewline.build` export is loaded when it is asked for."""

from __future__ import annotations

import subprocess
import sys

import pytest

import slewline
import slewline.build


def loaded(statement: str) -> set[str]:
    """The modules that a statement loads."""
    code = f"import sys; before = {{*sys.modules}}; {statement}; print(*{{*sys.modules}} - before)"
    return set(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.split())


def ours(modules: set[str]) -> set[str]:
    """Those of slewline."""
    return {name for name in modules if name.startswith("slewline")}


def test_what_is_asked_for_is_loaded_and_nothing_else() -> None:
    light = {"slewline", "slewline.lazy", "slewline.version"}
    assert ours(loaded("import slewline")) == light
    assert ours(loaded("import slewline.build")) == {*light, "slewline.build"}
    assert "slewline.core.datasheet.table" in (sheet := loaded("from slewline.build import Row, Sheet"))
    assert not sheet & {"slewline.core.chip", "slewline.parts", "slewline.chips", "slewline.bench"}


def within(modules: set[str], *layers: str) -> set[str]:
    """The modules of some layers."""
    return {name for name in modules if name.startswith(tuple(f"slewline.{layer}." for layer in layers))}


def test_an_empty_bench_loads_no_chip_no_language_no_host_and_nothing_that_draws() -> None:
    empty = loaded("import slewline; slewline.Bench()")
    assert within(empty, "chips", "language", "parts", "record", "links") == {
        "slewline.parts.base",
        "slewline.parts.base.part",
    }
    asked = {"bench", "circuit", "hosting", "pictures", "runner", "wiring"}
    drawn = {"curves", "drawing", "signals", "timing", "waveforms"}
    asked |= {f"pictures.{name}" for name in drawn}
    assert within(empty, "bench") == {f"slewline.bench.{name}" for name in asked}
    assert not within(empty, "core") & {
        f"slewline.core.{name}" for name in ("motion.deviation", "motion.ideal", "wires.serial")
    }
    assert not empty & {"difflib", "json", "numpy", "pathlib", "textwrap"}


@pytest.mark.parametrize(
    ("part", "host", "speech"),
    [("cy525", "bus_host", "letters"), ("gs-c200", "serial_host", "lines"), ("mc1451a", "packet_host", "packets")],
)
def test_a_chip_brings_its_own_language_and_its_own_host(part: str, host: str, speech: str) -> None:
    furnished = loaded(f"import slewline; bench = slewline.Bench(); bench.host(bench.add({part!r}))")
    hosts = {"slewline.parts.hosts.bus_host", "slewline.parts.hosts.serial_host", "slewline.parts.hosts.packet_host"}
    assert furnished & hosts == {f"slewline.parts.hosts.{host}"}
    spoken = {"slewline.language.letters", "slewline.language.lines", "slewline.language.packets"}
    assert furnished & spoken == {f"slewline.language.{speech}"}
    assert not within(furnished, "record")


@pytest.mark.parametrize("face", [slewline, slewline.build])
def test_a_face_has_the_names_that_it_lists_and_no_others(face) -> None:
    assert set(face.__all__) - {"__version__"} <= set(dir(face))
    for name in face.__all__:
        assert getattr(face, name) is vars(face)[name]  # it stays there
    with pytest.raises(AttributeError, match=f"module '{face.__name__}' has no attribute 'nonsense'"):
        face.nonsense  # noqa: B018
