"""The reference pages name everything that there is, and nothing else."""

from __future__ import annotations

import ast
import builtins
import importlib
import importlib.util
import inspect
import re
import tomllib
from pathlib import Path
from types import SimpleNamespace

import pytest
from docutils import nodes
from sphinx.addnodes import download_reference

import slewline
import slewline.errors
from slewline import build
from slewline.cli.commands import cli
from slewline.core.chip import Chip
from slewline.modules import failures
from tests.sources import text, tree

from . import entries
from .blocks import ROOT

SOURCES = sorted((ROOT / "src/slewline").rglob("*.py"))


# ------------------------------------------------------------------------------------------------------------- findings
def codes_of(path):
    """The first arguments of all calls that make a finding, or in the decoder a note that becomes one."""
    nodes = list(ast.walk(tree(path)))
    makes = "_note" if path.match("language/text/decoder.py") else "finding"
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
        if called == "report" and ast.unparse(node.func).endswith(("self.findings.report", "self.report")):
            coded = len(node.args) > 1  # else it is a message for the user of a module
            yield from (code.value for code in node.args[:1] if coded and isinstance(code, ast.Constant))
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
bench = slewline.Bench()
x, module, chipset, sides = (bench.add(part) for part in ("cy525", "gs-c200", "mc1451a", "cy545"))
packets = bench.host(chipset)
SEEN_BY_USERS = {
    "bench": bench,
    "x": x,
    "module": module,
    "chipset": chipset,
    "sides": sides,
    "pin": x.pin("slew"),
    "host": bench.host(x),
    "serial": bench.host(module),
    "packets": packets,
    "view": packets.axis(1),
    "flow": bench.host(sides, over="parallel"),
    "adaptive": bench.host(sides, over="serial"),
}
API = "".join(page.read_text("utf-8") for page in [ROOT / "docs/reference/api.md", *entries.PAGES])
OF_SOME_CHIPS = set(re.findall(r"`x\.(\w+)`", API))


@pytest.mark.parametrize("name", SEEN_BY_USERS)
def test_names_in_dir_have_an_entry(name):
    one = SEEN_BY_USERS[name]
    listed = {name for name in dir(one) if not name.startswith("_")}
    assert listed - entries.named_of(one) - (OF_SOME_CHIPS if isinstance(one, Chip) else set()) == set()
    assert {"kernel", "drivers"}.isdisjoint(listed)


def test_names_in_dir_of_an_axis_have_an_entry_with_the_chip():
    axis = chipset.axis(1)
    assert {name for name in dir(axis) if not name.startswith("_")} - entries.MEMBERS[Chip] == set()


@pytest.mark.parametrize("face", [slewline, build, slewline.errors])
def test_everything_that_can_be_imported_has_an_entry(face):
    public = getattr(face, "__all__", None) or [name for name, cls in vars(face).items() if inspect.isclass(cls)]
    found = [(module, name) for module, name in entries.ENTRIES if "." not in name]
    about = [entries.top(module, name) for module, name in found]
    assert len({*found}) == len(found)
    assert [name for name in public if getattr(face, name) not in about] == []


CALLS = [(module, name) for module, name in entries.ENTRIES if callable(entries.subject(module, name))]
RAISED = {*vars(slewline.errors), *vars(failures), *vars(builtins), "NothingHolds"}


def strange(module, name):
    """What a docstring says of parameters that there are not, and of errors that nobody knows."""
    call = entries.subject(module, name)
    args, raised = (set(entries.section(inspect.getdoc(call) or "", title)) for title in ("Args", "Raises"))
    return (args and args - {*inspect.signature(call).parameters}) or raised - RAISED


def test_a_docstring_speaks_of_parameters_and_errors_that_there_are():
    assert len(CALLS) > 250
    assert {".".join(entry): found for entry in CALLS if (found := strange(*entry))} == {}
    assert [entry for entry in CALLS if not inspect.getdoc(entries.subject(*entry))] == []


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


# ---------------------------------------------------------------------------------------------------------- conformance
FACTS = sorted((ROOT / "docs/reference").glob("conformance_*.md"))


@pytest.mark.parametrize("page", FACTS, ids=lambda page: page.stem)
def test_a_fact_has_an_anchor_and_leads_to_its_tests(page):
    rows = [row.split(" | ") for row in re.findall(r"^\| (<a .*) \|$", page.read_text("utf-8"), re.MULTILINE)]
    anchors = [re.fullmatch(r'<a id="([\w.-]+)" href="#\1">\1</a>', cells[0])[1] for cells in rows]
    assert len(anchors) == len({*anchors}) > (4 if "readme" in page.stem else 20)
    for *_, tests in rows:
        for name, path in re.findall(r"\[`(\w+)`\]\(([^)]*)\)", tests):
            assert re.search(rf"(def|class) {name}\b", text((page.parent / path).resolve())), name


@pytest.mark.parametrize("url", ["", "https://host.example/slewline/blob/v1"])
def test_a_link_to_a_test_leads_to_its_line_on_the_code_host(url, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "docs/_extensions")
    sources = importlib.import_module("sources")
    name = "test_a_link_to_a_test_leads_to_its_line_on_the_code_host"
    link = download_reference("", "", nodes.literal("", name), reftarget="../../tests/docs/test_reference.py")
    page = nodes.paragraph("", "", link)
    env = SimpleNamespace(docname="a", doc2path=lambda _: ROOT / "docs/reference/a.md")
    sources.lead_to_host(SimpleNamespace(config=SimpleNamespace(source_url=url), env=env, srcdir=ROOT / "docs"), page)
    line = next(n for n, line in enumerate(text(Path(__file__)).splitlines(), 1) if line.startswith(f"def {name}("))
    led = f"{url}/tests/docs/test_reference.py#L{line}"
    assert [found.get("refuri") for found in page.children] == [led if url else None]
    assert page.astext() == name
    named = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"].get("urls", {}).get("Source")
    assert sources.address("1") == (f"{named}/blob/v1" if named else "")


# ------------------------------------------------------------------------------------------------------------ stability
STABILITY = (ROOT / "docs/reference/stability.md").read_text("utf-8")


def classified(heading):
    """The names of a section of the page about stability, by their classes."""
    table = STABILITY.split(f"\n## {heading}\n")[1].split("\n## ")[0]
    rows = re.findall(r"^\| (stable|provisional|internal) \| (.*) \|$", table, re.MULTILINE)
    return {stability: re.findall(r"`([\w.-]+)`", names) for stability, names in rows}


@pytest.mark.parametrize(
    ("heading", "public"),
    [("slewline", slewline.__all__), ("slewline.build", build.__all__), ("The command line", cli.commands)],
)
def test_every_public_name_is_stable_or_provisional(heading, public):
    found = classified(heading)
    assert [*found] == ["stable", "provisional"]
    assert sorted(name for names in found.values() for name in names) == sorted(public)


def test_the_pages_import_only_what_keeps_its_place():
    kept = [module for modules in classified("Modules").values() for module in modules]
    assert "slewline.testing" in kept
    assert [module for module in kept if importlib.util.find_spec(module) is None] == []
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    found = {}
    for page in pages:
        for block in re.findall(r"^```python\n(.*?)^```", page.read_text("utf-8"), re.MULTILINE | re.DOTALL):
            for module in re.findall(r"^\s*(?:from|import) (slewline[\w.]*)", block, re.MULTILINE):
                found.setdefault(module, []).append(page.name)
    assert "a_chip_of_your_own.md" in found["slewline.build"]
    assert {module: on for module, on in found.items() if module not in kept} == {}
