"""The reference pages name everything that there is, and nothing else."""

from __future__ import annotations

import ast
import inspect
import re

import pytest

import slewline
from slewline import build
from slewline.core.chip import Chip
from slewline.core.component import Finding
from slewline.core.motion.axis import Steps
from slewline.core.motion.one_axis import OneAxis
from slewline.core.wires.pin import Terminal
from slewline.parts.hosts.adaptive_host import AdaptiveHost
from slewline.parts.hosts.bus_host import BusHost
from slewline.parts.hosts.flow_host import FlowHost
from slewline.parts.hosts.packet_host import PacketHost
from slewline.parts.hosts.serial_host import SerialHost
from slewline.record.measuring.compare import Comparison
from slewline.record.waveforms.waveforms import Waveforms
from tests.sources import tree

from .blocks import ROOT

SOURCES = sorted((ROOT / "src/slewline").rglob("*.py"))


# ------------------------------------------------------------------------------------------------------------- findings
def codes_of(path):
    """The first arguments of all calls that make a finding, or in the decoder a note that becomes one."""
    nodes = list(ast.walk(tree(path)))
    makes = "_note" if path.name == "decoder.py" else "finding"
    loops = {inner: node for node in nodes if isinstance(node, ast.For) for inner in ast.walk(node)}
    for node in nodes:
        if isinstance(node, ast.FunctionDef) and node.name == "odd":  # what the loop below goes through
            yield from (each.value.elts[1].value for each in ast.walk(node) if isinstance(each, ast.Yield))
        if isinstance(node, ast.FunctionDef) and node.name == "left_over":  # what `conclude` goes through
            pairs = (each.elts for each in ast.walk(node) if isinstance(each, ast.Tuple) and len(each.elts) == 2)
            yield from (code.value for code, _ in pairs if isinstance(code, ast.Constant))
        if isinstance(node, ast.AnnAssign) and ast.unparse(node.target) == "TROUBLES":  # what boards tell, with texts
            yield from (row.elts[0].value for row in node.value.values)
        if not isinstance(node, ast.Call):
            continue
        called = getattr(node.func, "attr", None) or getattr(node.func, "id", None)
        if called == "report" and ast.unparse(node.func).endswith((".watch.report", "self.report")):
            yield from (code.value for code in node.args[:1] if isinstance(code, ast.Constant))
        if called == "Finding" and isinstance(node.args[2], ast.Constant):
            yield node.args[2].value  # made by itself, without a listener
        if called in (makes, "mistake", "finding_once") and node.args:
            first, loop = node.args[0], loops.get(node)
            if isinstance(first, ast.Constant):
                yield first.value
            elif isinstance(first, ast.Name) and first.id == "code" and loop:  # a column
                column = [ast.unparse(name) for name in loop.target.elts].index("code")
                if isinstance(loop.iter, ast.Tuple):
                    yield from (row.elts[column].value for row in loop.iter.elts)
            else:
                yield {"note.code": None, "found": None, "code": None}[ast.unparse(first)]  # passed on: made elsewhere


def test_every_finding_has_a_line_on_its_page():
    made = {code for path in SOURCES for code in codes_of(path)} - {None}
    page = (ROOT / "docs/reference/findings.md").read_text("utf-8")
    listed = re.findall(r"`([A-Za-z0-9-]+)`", "\n".join(re.findall(r"^\| (`.*?) \|", page, re.MULTILINE)))
    assert len(made) > 50
    assert sorted(listed) == sorted(made)


# ------------------------------------------------------------------------------------------------------------------ api
API = (ROOT / "docs/reference/api.md").read_text("utf-8")
OWNERS = {
    "bench": (bench := slewline.Bench()),
    "x": bench.add("cy525"),
    "pin": Terminal,
    "steps": Steps,
    "finding": Finding,
    "found": Comparison,
}
OWNERS["host"] = bench.host(OWNERS["x"])
with_module = slewline.Bench()
OWNERS["serial"] = with_module.host(with_module.add("gs-c200"))
with_chipset = slewline.Bench()
OWNERS["packets"] = with_chipset.host(with_chipset.add("mc1451a"))


@pytest.mark.parametrize("owner", ["bench", "x", "pin", "host", "serial", "packets"])
def test_dir_lists_what_the_page_names_of_it_and_little_else(owner):
    one = OWNERS["x"].pin("slew") if owner == "pin" else OWNERS[owner]
    listed = {name for name in dir(one) if not name.startswith("_")}
    own = set(re.findall(rf"`{owner}\.(\w+)", API))
    assert own - listed == set()
    common = set(re.findall(r"`(?:host|x|bench)\.(\w+)", API)) | {"pin", "pins", "name"}
    assert len(listed - own - common) <= 12 and {"kernel", "drivers"}.isdisjoint(listed)


@pytest.mark.parametrize("owner", OWNERS)
def test_what_the_api_page_names_exists(owner):
    named = set(re.findall(rf"`{owner}\.(\w+)", API))
    assert named
    assert [name for name in named if not (hasattr(OWNERS[owner], name) or name in fields(OWNERS[owner]))] == []


def fields(cls):
    return getattr(cls, "__annotations__", {})


def test_the_api_page_names_every_method_of_a_bench_and_everything_in_the_package():
    methods = [name for name, _ in inspect.getmembers(slewline.Bench, inspect.isfunction) if not name.startswith("_")]
    assert [name for name in methods if f"`bench.{name}(" not in API] == ["place"]  # for parts of one's own
    asked = [name for name, _ in inspect.getmembers(OneAxis, inspect.isfunction) if not name.startswith("_")]
    assert [name for name in asked if f"`x.{name}(" not in API] == []
    assert [name for name in slewline.__all__ if f"`slewline.{name}" not in API] == []


@pytest.mark.parametrize(
    ("owner", "cls"),
    [
        ("bench", slewline.Bench),
        ("x", Chip),
        ("host", BusHost),
        ("serial", SerialHost),
        ("packets", PacketHost),
        ("flow", FlowHost),
        ("adaptive", AdaptiveHost),
        ("pin", Terminal),
        ("waveforms", Waveforms),
    ],
)
def test_the_signatures_on_the_api_page_are_those_of_the_code(owner, cls):
    for call in re.findall(rf"`({owner}\.\w+\(.*?\))`", API):
        shown = ast.parse(call, mode="eval").body
        parameters = list(inspect.signature(getattr(cls, shown.func.attr)).parameters.values())[1:]
        names = [ast.unparse(argument).lstrip("*") for argument in shown.args]
        names += [keyword.arg or ast.unparse(keyword.value) for keyword in shown.keywords]
        defaults = {keyword.arg: ast.literal_eval(keyword.value) for keyword in shown.keywords if keyword.arg}
        assert names == [parameter.name for parameter in parameters][: len(names)], call
        assert defaults.items() <= {parameter.name: parameter.default for parameter in parameters}.items(), call


# ---------------------------------------------------------------------------------------------------------------- build
PAGE = (ROOT / "docs/reference/build.md").read_text("utf-8")
BUILD = re.sub("(?s)## What a chip and a part have.*?(?=## Programs)", "", PAGE)  # those are names of objects


def test_the_build_page_names_everything_that_can_be_imported_from_there():
    rows = "\n".join(re.findall(r"^\| (`.*?) \| ", BUILD, re.MULTILINE))
    named = {call.removeprefix("await ").partition("(")[0] for call in re.findall(r"`(.*?)`", rows)}
    assert sorted(named) == sorted(build.__all__)
    assert sorted(build.__all__) == sorted(name for names in build._FROM.values() for name in names)
    assert [name for name in build.__all__ if getattr(build, name) is None] == []


def test_the_calls_on_the_build_page_have_the_parameters_of_the_code():
    calls = [ast.parse(call, mode="eval").body for call in re.findall(r"`(?:await )?(\w+\([^`]*\))`[,`| ]", BUILD)]
    calls = [call for call in calls if call.func.id in build.__all__]
    assert len(calls) > 8
    for call in calls:
        shown = [argument.id for argument in call.args if isinstance(argument, ast.Name)]
        assert shown == list(inspect.signature(getattr(build, call.func.id)).parameters)[: len(shown)], ast.unparse(
            call
        )


KEPT = re.findall(r"`(slewline[\w.]*)`", BUILD.split("## What else keeps its place")[1].split("Where a name")[0])


def test_the_pages_import_only_what_keeps_its_place():
    assert "slewline.testing" in KEPT
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    found = {}
    for page in pages:
        for block in re.findall(r"^```python\n(.*?)^```", page.read_text("utf-8"), re.MULTILINE | re.DOTALL):
            for module in re.findall(r"^\s*(?:from|import) (slewline[\w.]*)", block, re.MULTILINE):
                found.setdefault(module, []).append(page.name)
    assert "a_chip_of_your_own.md" in found["slewline.build"]
    assert {module: on for module, on in found.items() if module not in [*KEPT, "slewline.build"]} == {}
