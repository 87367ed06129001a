"""What the explaining pages say about the code is so."""

from __future__ import annotations

import ast
import re
import sys
from functools import cache

import pytest

import slewline
from slewline.chips.cy545 import profile
from tests.sources import tree

from .blocks import ROOT

SRC = ROOT / "src/slewline"
PAGES = [*sorted((ROOT / "docs/explanation").glob("*.md")), *sorted((ROOT / "docs/decisions").glob("*.md"))]
FLOW = (ROOT / "docs/explanation/code_flow.md").read_text("utf-8")


def test_decisions_are_numbered_one_by_one():
    titles = [page.read_text("utf-8").split(". ")[0] for page in sorted((ROOT / "docs/decisions").glob("0*.md"))]
    assert titles == [f"# {n}" for n in range(1, len(titles) + 1)]


ROW = re.compile(r"^\| \[(\d+)\]\(([\w-]+\.md)\) \| [^|]+ \| (.+) \|$", re.MULTILINE)
MARK = re.compile(r"\*\*(superseded|amended)\*\* by \[(\d+)\]\(([\w-]+\.md)\)", re.IGNORECASE)


def records():
    """The decisions, by their numbers."""
    return {int(page.name[:4]): page for page in sorted((ROOT / "docs/decisions").glob("0*.md"))}


def marks(text):
    """What has become of a decision since, in its record or in its row of the list: how, and by which one."""
    return {(how.lower(), int(number), file) for how, number, file in MARK.findall(text)}


def test_each_decision_is_in_the_list_once_and_marked_there_as_in_its_record():
    rows = ROW.findall((ROOT / "docs/decisions/index.md").read_text("utf-8"))
    assert sorted((int(number), file) for number, file, _ in rows) == [(n, page.name) for n, page in records().items()]
    assert {file: marks(row) for _, file, row in rows if marks(row)} == {
        page.name: marks(page.read_text("utf-8")) for page in records().values() if marks(page.read_text("utf-8"))
    }


def test_a_decision_that_changes_another_one_names_it():
    """So a reader of either finds the other, and nothing is changed by what is older."""
    changed = [(n, page, mark) for n, page in records().items() for mark in marks(page.read_text("utf-8"))]
    assert len(changed) >= 3
    for n, page, (_, number, file) in changed:
        assert number > n and records()[number].name == file
        assert f"]({page.name})" in records()[number].read_text("utf-8")


# ------------------------------------------------------------------------------------------------------------ code flow
def told(heading):
    """The calls that a chapter of the page tells, in its order: (file, qualified name)."""
    (chapter,) = (part for part in re.split(r"^## ", FLOW, flags=re.MULTILINE) if part.startswith(heading))
    return re.findall(r"^\| `([\w/]+\.py)` `([\w.]+)` \|", chapter, re.MULTILINE)


def traced(action):
    """Every call inside slewline, in order: (file, qualified name)."""
    calls = []

    def note(frame, event, _argument):
        if event == "call" and frame.f_code.co_filename.startswith(str(SRC)):
            calls.append((frame.f_code.co_filename[len(str(SRC)) + 1 :], frame.f_code.co_qualname))

    sys.setprofile(note)
    try:
        action()
    finally:
        sys.setprofile(None)
    return calls


def in_order(wanted, calls):
    """The first of the wanted calls that does not come, in their order; None: all do."""
    rest = iter(calls)
    return next((call for call in wanted if call not in rest), None)


@pytest.fixture
def x():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.host(x).send("A 0\rF 10\rS 240\rZ 1\rN 3000\r")
    bench.run_until_idle()
    x.bench = bench
    x.send_and_run = lambda text: (bench["host"].send(text), bench.run_until_idle())
    return x


def test_a_command_flows_through_the_code_as_documented(x):
    x.pin("ready").net.watch(lambda _net: None)  # else it goes as a value
    wanted = told("`host.send")
    assert len(wanted) > 20
    assert in_order(wanted, traced(lambda: x.send_and_run("R 100\r"))) is None
    assert x.registers["rate"] == 100


def test_a_motion_flows_through_the_code_as_documented(x):
    x.send_and_run("R 100\r")
    x.pin("abort").drive(0, at="150 ms")
    wanted = told("`G`")
    assert len(wanted) > 20
    assert in_order(wanted, traced(lambda: x.send_and_run("G\r"))) is None
    assert 0 < x.position < 3000


@pytest.fixture
def c():
    bench = slewline.Bench()
    c = bench.add("cy545b", name="c")
    bench.part("ram", to=c)
    c.bench, c.host = bench, bench.host(c)
    c.host.send("O 81H\rY 0\rE\rN 300\r+\rG\r0\rQY 0\r")
    bench.run_until_idle()
    return c


def test_a_query_flows_through_the_code_as_documented(c):
    c.pin("busy").net.watch(lambda _net: None)  # else the command goes as a value
    wanted = told('`host.ask("? R")')
    assert len(wanted) > 10
    assert in_order(wanted, traced(lambda: c.host.ask("? R"))) is None


def test_a_program_in_a_memory_flows_through_the_code_as_documented(c):
    def ran():
        profile.ramp.cache_clear()  # another test may have planned this very move
        profile.move.cache_clear()
        c.host.send("X\r")
        c.bench.run_until_idle()

    wanted = told("`X`")
    assert len(wanted) > 15
    assert in_order(wanted, traced(ran)) is None
    assert c.position == 300


def test_a_line_flows_through_the_code_as_documented():
    bench = slewline.Bench()
    y = bench.add("gs-c200s", name="y", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0})
    host = bench.host(y)
    for line in ("Po", "S20", "T100", "R5", "+200"):
        host.ask(line)

    def ran():
        host.ask("E")
        bench.run_until_idle()

    wanted = told('`host.ask("E")')
    assert len(wanted) > 15
    assert in_order(wanted, traced(ran)) is None
    assert y.position == 200


@pytest.fixture
def m():
    bench = slewline.Bench()
    m = bench.add("mc1451a", name="m")
    m.bench, m.host = bench, bench.host(m)
    m.host.command("SET_VEL", 65536)
    m.host.command("SET_ACC", 1024)
    return m


def test_a_packet_flows_through_the_code_as_documented(m):
    wanted = told('`host.command("SET_POS"')
    assert len(wanted) > 15
    assert in_order(wanted, traced(lambda: m.host.command("SET_POS", 12345))) is None
    assert m.registers_of(1)["pos"] == 12345


def test_an_update_flows_through_the_code_as_documented(m):
    m.host.command("SET_POS", 12345)
    wanted = told('`host.command("UPDATE")')
    assert len(wanted) > 15

    def moved():
        m.host.command("UPDATE")
        m.bench.run("20 ms")
        return m.position

    assert in_order(wanted, traced(moved)) is None
    assert 0 < m.position < 12345


def test_a_picture_flows_through_the_code_as_documented(x, tmp_path):
    x.send_and_run("R 100\r")
    x.bench.record("x.slew")
    x.send_and_run("G\r")
    wanted = told("`bench.plot")
    assert len(wanted) > 10
    x.bench.plot(tmp_path / "move.svg")  # matplotlib is there
    assert in_order(wanted, traced(lambda: x.bench.plot(tmp_path / "move.svg"))) is None


def test_the_instants_of_the_first_and_the_last_byte_are_those_of_the_page(x):
    bench, begin = x.kernel, x.kernel.now
    seen = []
    for pin in ("instrobe", "ready"):
        x.pin(pin).net.watch(lambda net: seen.append((bench.now - begin) // 10**6))
    x.send_and_run("R 100\r")
    strobes = seen[:4], [us - seen[-4] + 15 for us in seen[-4:]]  # INSTROBE falls 15 us after the request
    shown = [
        [int(us) for us in re.findall(r"\| (\d+) \|$", table, re.MULTILINE)]
        for table in FLOW.split("carriage return, completes")
    ]
    assert strobes[0] == [15, *shown[0][1:]] == [15, 16, 26, 187]
    assert (shown[1], strobes[1]) == ([0, 26, 209, 226], [15, 16, 26, 226])


def test_every_row_of_the_page_is_described_in_a_chapter_that_is_traced():
    rows = [line for line in FLOW.splitlines() if line.startswith("| ") and not line.startswith("| where")]
    traced_ones = (
        "`host.send", "`G`", '`host.ask("? R")', "`X`", '`host.ask("E")', '`host.command("SET_POS"',
        '`host.command("UPDATE")', "`bench.plot",
    )  # fmt: skip
    assert len(rows) == sum(len(told(heading)) for heading in traced_ones)


# ----------------------------------------------------------------------------------------------------- names and places
@cache
def definitions():
    """Every function, method, class and class attribute of the sources, by plain and by qualified name."""
    names = set()
    for path in SRC.rglob("*.py"):
        for node in ast.walk(tree(path)):
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
                names.add(node.name)
            if isinstance(node, ast.ClassDef):
                names |= {f"{node.name}.{inner.name}" for inner in ast.walk(node) if hasattr(inner, "name")}
                names |= {f"{node.name}.{inner.target.id}" for inner in node.body if isinstance(inner, ast.AnnAssign)}
    return names


@cache
def modules():
    """Every Python file of the project, from its root."""
    return [
        path.relative_to(ROOT).as_posix()
        for folder in ("src", "tests", "tools", "benchmarks")
        for path in (ROOT / folder).rglob("*.py")
    ]


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_files_and_names_on_a_page_exist(page):
    text = re.sub(r"```.*?```", "", page.read_text("utf-8"), flags=re.DOTALL)
    files = set(re.findall(r"`([\w/]+\.py)`", text))
    assert [name for name in files if not any(f"/{path}".endswith(f"/{name}") for path in modules())] == []
    known = definitions()
    named = set(re.findall(r"`([A-Z][a-z]\w+(?:\.\w+)?)(?:\(.*?\))?`", text))
    assert [name for name in named - {"ValueError", "KeyError"} if name not in known] == []


def test_the_layers_on_the_page_are_those_of_the_import_contracts():
    import tomllib

    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["contracts"]
    layers = [set(re.findall(r"\w+", layer)) for layer in contracts[0]["layers"]]
    picture, *_ = re.findall(r"```text\n(.*?)```", (ROOT / "docs/explanation/where.md").read_text("utf-8"), re.DOTALL)
    rows = [re.split(r" {4,}", row.strip())[0] for row in picture.splitlines() if row.strip() not in ("|", "")]
    assert [set(re.findall(r"\w+", row)) for row in rows] == layers


# ---------------------------------------------------------------------------------------------------------------- rooms
ROOMS = {init.parent.relative_to(SRC).as_posix() for init in SRC.rglob("__init__.py")} - {"."}


def named_rooms():
    """The rooms in the table of the page: those of its first column, and their own rooms that the second one names."""
    table = (ROOT / "docs/explanation/where.md").read_text("utf-8").split("## Rooms")[1].split("\n## ")[0]
    for first, second in re.findall(r"^\| (`.*?) \| (.*?) \|", table, re.MULTILINE):
        place = ""
        for name in re.findall(r"`([\w/]+)`", first):
            room = name if "/" in name or not place else place + name
            place = f"{room.partition('/')[0]}/" if "/" in room else ""
            yield room
            yield from (f"{room}/{inner}" for inner in re.findall(r"`(\w+)`", second) if f"{room}/{inner}" in ROOMS)


def test_each_room_is_in_the_table_once():
    found = sorted(named_rooms())
    assert found == sorted({*found}) and {*found} <= ROOMS
    parents = {room.partition("/")[0] for room in found if "/" in room}
    beneath = {room for room in ROOMS if room.startswith("chips/")}  # a part or a family each
    assert {*ROOMS} - {*found} - beneath <= parents
    assert len(found) > 40


def test_files_and_names_in_the_docstrings_of_rooms_exist():
    wrong = []
    for room in sorted(ROOMS):
        doc = ast.get_docstring(tree(SRC / room / "__init__.py"))
        files = set(re.findall(r"[\w/]+\.py\b", doc))
        wrong += [f"{room}: {name}" for name in files if not any(f"/{path}".endswith(f"/{name}") for path in modules())]
        named = set(re.findall(r"`@?([A-Z][a-z]\w+(?:\.\w+)?)`", doc))
        wrong += [f"{room}: {name}" for name in named if name not in definitions()]
    assert wrong == []
