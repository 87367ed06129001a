"""Figures of the performance page: what a ratio is taken to, which verdict a goal gets, what the page says first."""

from __future__ import annotations

import ast
import importlib
import re
import sys
from datetime import date
from itertools import count
from pathlib import Path

import numpy as np
import pytest

FOLDER = Path(__file__).parents[2] / "benchmarks"
TREES = {path.name: ast.parse(path.read_text("utf-8")) for path in sorted(FOLDER.glob("*.py"))}
CLOCKS = {  # where a clock is read, in this process or by a program that prints what it has measured
    "rows.py": {"timed"},
    "run.py": {"seconds_of"},
    "serve.py": {"timed", "one"},
    "asked.py": {"beside"},
}


@pytest.fixture(scope="module")
def load():
    before = {*sys.modules}
    sys.path.insert(0, str(FOLDER))
    yield importlib.import_module
    sys.path.remove(str(FOLDER))
    for name in {*sys.modules} - before:
        if str(getattr(sys.modules[name], "__file__", "")).startswith(str(FOLDER)):
            del sys.modules[name]


@pytest.fixture
def rows(load):
    return load("rows")


def row(rows, figure=1.0, goal=1.0, more=True, name="a", bound="b", unit="ms", **more_of_it):
    return rows.Row(name, figure, unit, goal, more, bound, **more_of_it)


# ------------------------------------------------------------------------------------------------------------ verdicts
@pytest.mark.parametrize(
    "figure, goal, more, verdict",
    [
        (10.6, 10, True, "yes"), (10.4, 10, True, "at the limit"), (10, 10, True, "at the limit"),
        (9.99, 10, True, "NO"), (0.94, 1, False, "yes"), (0.96, 1, False, "at the limit"),
        (1, 1, False, "at the limit"), (1.01, 1, False, "NO"), (-3, 1, False, "yes"),
        (0, 0, False, "yes"), (1, 0, False, "NO"), (5, None, True, ""),
    ],
)  # fmt: skip
def test_a_verdict_states_the_distance_from_the_goal(rows, figure, goal, more, verdict):
    assert row(rows, figure, goal, more).verdict == verdict


def test_missing_measurements_have_no_verdict_and_a_reason(rows):
    absent = row(rows, None, 10, unit="x C", absent="no C compiler here")
    assert (absent.verdict, absent.shown, absent.met) == ("no verdict", "no C compiler here", True)
    assert row(rows, None, None, unit="x C", absent="no C compiler here").verdict == ""
    with pytest.raises(TypeError, match="or the reason for its absence"):
        row(rows, None)


def test_a_verdict_by_hand_has_its_date_and_processor(rows):
    old = row(rows, 6, 8, unit="x Klipper", when="2026-11-29, a Zen")
    assert old.verdict == "NO, as measured on 2026-11-29, a Zen"


# ---------------------------------------------------------------------------------------------------------- yardsticks
def test_a_ratio_takes_what_was_measured_and_nothing_else(rows):
    second, two = rows.Measured(1.0), rows.Measured(2.0)
    assert row(rows, None, unit="x pyvcd", sides=[(two, second)]).figure == 2
    for constant in (2.0, 56 * second, second / 56, second + 1):
        with pytest.raises(TypeError, match="measured in this run, unchanged"):
            row(rows, None, unit="x pyvcd", sides=[(constant, second)])
    with pytest.raises(TypeError, match="x pyvcd was not measured in this run"):
        row(rows, 8.0, unit="x pyvcd")
    assert row(rows, 8.0, unit=rows.REAL).figure == 8  # real time is no yardstick that somebody measures


def test_a_ratio_is_the_median_of_its_turns_and_shows_half_of_them(rows):
    turns = [(rows.Measured(theirs), rows.Measured(1)) for theirs in (9, 1, 3, 4, 2)]
    faster, slower = (row(rows, None, 1, more, unit="x pyvcd", sides=turns) for more in (True, False))
    assert (faster.figure, faster.shown) == (3, "3 (2 to 4) x pyvcd")
    assert slower.figure == pytest.approx(1 / 3)


def test_both_sides_are_timed_by_turns_in_the_same_run(rows, monkeypatch):
    clock, order = [0.0], []
    monkeypatch.setattr(rows, "process_time", lambda: clock[0])

    def takes(seconds, name):
        def act():
            clock[0] += seconds
            order.append(name)

        return act

    sides = rows.by_turns(takes(3, "theirs"), takes(1, "ours"), 3)
    assert row(rows, None, unit="x pyvcd", sides=sides).ratios == [3, 3, 3]
    assert order[2:] == ["ours", "theirs", "theirs", "ours", "ours", "theirs"]


def calls(name):
    """Every call of a name in the benchmarks, with its file and the innermost function around it."""
    for file, tree in TREES.items():
        inside = {}
        for function in ast.walk(tree):  # outer ones first
            if isinstance(function, ast.FunctionDef):
                inside |= dict.fromkeys(ast.walk(function), function.name)
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == name:
                yield file, inside.get(node, ""), node


def given(call, name):
    """What a call of Row gives for a column, or None."""
    columns = "name", "figure", "unit", "goal", "more_is_better", "bound", "sides"
    by_name = {keyword.arg: keyword.value for keyword in call.keywords}
    place = columns.index(name) if name in columns else len(columns)
    return by_name.get(name) or (call.args[place] if place < len(call.args) else None)


def is_constant(node):
    """No name, no call and no attribute is in it, so it is the same in every run."""
    return not any(isinstance(part, ast.Name | ast.Call | ast.Attribute) for part in ast.walk(node))


def test_no_yardstick_is_a_constant():
    seen = {}
    for file, function, call in calls("Measured"):
        seen.setdefault(file, set()).add(function)
        assert not is_constant(call.args[0]), f"{file}: {ast.unparse(call)}"
        assert not isinstance(call.args[0], ast.Constant)
    assert seen == CLOCKS
    ratios = 0
    for file, _, call in calls("Row"):
        unit, sides = given(call, "unit"), given(call, "sides")
        text = unit.value if isinstance(unit, ast.Constant) else ""
        if sides is not None:
            ratios += 1
            figure = given(call, "figure")
            assert isinstance(figure, ast.Constant) and figure.value is None, f"{file}: {ast.unparse(call)}"
            assert not is_constant(sides), f"{file}: {ast.unparse(call)}"
        elif text.startswith("x "):
            raise AssertionError(f"{file}: {ast.unparse(call)}: no sides")
    assert ratios > 10


def test_no_text_guesses_at_a_time_or_a_size():
    guess = re.compile(r"\b(about|around|some|to) [\d.,]+ ?(ns|µs|ms|s|B|kB|MB)\b")
    assert guess.search("1.1 to 3.6 kB without keep") and guess.search("some 30 µs a move")
    texts = [
        (file, part.value)
        for file, tree in TREES.items()
        for part in ast.walk(tree)
        if isinstance(part, ast.Constant) and isinstance(part.value, str)
    ]
    assert [found for found in texts if guess.search(found[1])] == []


# ---------------------------------------------------------------------------------------- goals beside the reference
def test_a_goal_in_real_time_becomes_one_relative_to_the_reference(load, rows):
    asked = load("asked")
    name = "1,000 exchanges with a GS-C200S"
    assert asked.ASKED[name].ratio == round(100 / 49.19, 2) == 2.03

    def found(figure):
        return asked.Found(name, figure, rows.REAL, None, True, "calls")

    pairs = [(found(50.0), found(100.0)), (found(40.0), found(120.0)), (found(60.0), found(90.0))]
    plain, ratio, then = asked.beside(row(rows, 100.0, None, name=name, bound="calls", unit=rows.REAL), pairs)
    assert (plain.figure, plain.goal, plain.bound) == (100, None, "")
    assert (ratio.figure, ratio.goal, ratio.verdict) == (pytest.approx(2), 2.03, "NO")
    assert ratio.bound == "calls; the goal is 100 x real time on the machine on which df29ad1c reaches 49.2"
    assert (then.figure, then.goal, then.verdict) == (pytest.approx(2), 3.5, "NO")


def test_without_the_reference_such_a_goal_has_no_verdict(load, rows):
    asked = load("asked")

    def workload():
        return [row(rows, 9.0, None, name="CY545: a program that polls", unit=rows.REAL), row(rows, name="other")]

    plain, ratio, other = asked.judged(workload, None)
    assert (plain.shown, plain.verdict) == ("9 x real time", "")
    assert (ratio.shown, ratio.verdict) == ("commit df29ad1c is not in this repository", "no verdict")
    assert other.verdict == "at the limit"


def test_the_reference_is_absent_outside_of_its_repository(load, tmp_path, monkeypatch):
    trees = load("trees")
    monkeypatch.setattr(trees, "HERE", tmp_path)
    with trees.reference() as folder:
        assert folder is None


# ------------------------------------------------------------------------------------------------------------ the page
def test_a_table_shows_figure_goal_verdict_and_bound(rows):
    lines = rows.table([row(rows, 1234.5, 1000, name="n", unit="M steps/s", bound="memory"), row(rows, 2, 1, False)])
    assert lines.splitlines()[2:] == [
        "| n | 1,234 M steps/s | >= 1,000 | yes | memory |",
        "| a | 2 ms | <= 1 | NO | b |",
    ]


def test_missed_goals_come_first_each_with_its_bound(load, rows):
    page = load("page")
    text = page.missed([
        row(rows, 5, 1, name="a move: plan", bound="Python"),
        row(rows, 2, 3, name="the same: ticks", bound="the same, and memory"),
        row(rows, 3.1, 3, name="a scope", bound="cells"),
        row(rows, None, 3, name="a ratio", unit="x C", absent="no C compiler here"),
        row(rows, 6, 8, name="by hand", unit="x Klipper", bound="the plan", when="2026-11-29, a Zen"),
    ])  # fmt: skip
    assert text.splitlines() == [
        "- a move: ticks: 2 ms; goal >= 3. Bottleneck: Python, and memory.",
        "- by hand: 6 x Klipper, as measured on 2026-11-29, a Zen; goal >= 8. Bottleneck: the plan.",
        "",
        "At the limit: a scope (3.1 ms).",
        "",
        "No verdict: a ratio (no C compiler here).",
    ]
    assert page.missed([row(rows, 5, 1)]) == "None.\n"


def test_the_page_has_processor_and_day_and_keeps_manual_measurements(load, rows):
    page, asked = load("page"), load("asked")
    every = [row(rows, 1.0, None, name=name, unit=rows.REAL) for name in asked.ASKED]
    text = page.written({"Family": [*every, row(rows, 1, 2, name="made up")]}, date(2030, 1, 31))
    assert f"on 2030-01-31: {page.processor()}, CPython" in text and page.processor()
    titles = "- made up", "## Comparison with Klipper, measured once by hand", "## Family"
    order = [text.index(part) for part in titles]
    assert order == sorted(order)
    how, hand = page.by_hand()
    assert how in text and [each.goal for each in hand] == [10, 8, 1]
    for each in hand:
        assert f"| {each.name} | {each.shown} | {each.wanted} | {each.verdict} |" in text
        assert re.search(r", as measured on \d{4}-\d\d-\d\d, \w", each.verdict)
    with pytest.raises(ValueError, match="no row for the goals of 1,000 exchanges"):
        page.written({"Family": [each for each in every if "exchanges" not in each.name]}, date(2030, 1, 31))


def test_a_processor_has_family_and_model(load, tmp_path, monkeypatch):
    page = load("page")
    (tmp_path / "cpuinfo").write_text("cpu family\t: 26\nmodel\t\t: 2\nmodel name\t: AMD EPYC\nflags\t\t: fpu\n")
    monkeypatch.setattr(page, "Path", lambda _: tmp_path / "cpuinfo")
    assert page.processor() == "AMD EPYC (family 26, model 2)"


# --------------------------------------------------------------------------------------------------- what is run beside
def test_the_step_generator_adds_up_intervals(load, tmp_path):
    compiling = load("compiling")
    if compiling.COMPILER is None:
        pytest.skip("no C compiler")
    generate = compiling.step_generator(tmp_path)
    ticks = np.zeros(7, np.int64)
    assert generate(np.array([[10, 3, 2], [5, 0, 9], [7, 4, -1]], np.int64), ticks) == 7
    assert ticks.tolist() == [0, 10, 22, 36, 43, 49, 54]


def test_a_profile_lists_calls_and_time(load):
    profiled = load("profiled")
    stats = {
        ("/a/net.py", 1, "f"): (2, 2, 3.0, 9.0, {}),
        ("/a/kernel.py", 1, "g"): (7, 7, 1.0, 9.0, {}),
        ("~", 0, "<len>"): (1, 1, 6.0, 6.0, {("/a/kernel.py", 1, "g"): (1, 1, 6.0, 6.0)}),
    }
    assert profiled.sentence(stats, 5, "per packet") == "2 calls per packet; share of the time: kernel 70%, net 30%"


def test_initial_loading_does_not_count_in_a_profile(load):
    profiled, runs = load("profiled"), count()
    text = profiled.bound("once", lambda: lambda: next(runs) == 0 and sum(map(abs, range(1000))), 1, "a run")
    assert next(runs) == 2 and int(text.partition(" ")[0]) < 10
    profiled.bound("once", lambda: lambda: next(runs), 1, "a run")
    assert next(runs) == 3
