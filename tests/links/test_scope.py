"""What signals did, against the edges and steps of the bench itself."""

from __future__ import annotations

import random
from bisect import bisect_right

import pytest

import slewline
from slewline.links.views.cells import Cells, width_of
from slewline.links.views.scope import Scope
from tests.ensembles import in_long_runs

from .conftest import STRAPS

SINCE = 10**12  # when the recording begins


@pytest.fixture(scope="module")
def ran():
    """A module whose program has run for a minute, and its scope."""
    bench = slewline.Bench()
    x = bench.add("gs-c200s", name="x", straps=STRAPS)
    host = bench.host(x)
    bench.run("1 s")
    bench.record("x.clock", "x.mov")
    for line in ("Po", "S50", "T200", "R20", "L0", "+40", "-30", "D5", "L20", "E"):
        host.send(line.encode() + b"\r")
    bench.run("60 s")
    return bench, Scope(bench)


def windows(now, number, seed):
    """Windows by chance, short and long, some of them before the recording."""
    chance = random.Random(seed)
    for _ in range(number):
        start = chance.randrange(now)
        length = chance.choice((0, 1, 1000, 10**9, 10**11, 10**12, 10**13, 6 * 10**13))
        yield start, min(now, start + length), chance.choice((1, 2, 7, 50, 800))


def few_windows(number, many):
    """Look into so many windows in every run, into many in a long one."""
    return pytest.mark.parametrize("number", [number, in_long_runs(many)])


def shown(scope, name, start, stop, columns):
    return [found for found in scope.window([name], start, stop, columns) if found is not None][-1][name]


class Plain:
    """The edges of a pin."""

    def __init__(self, bench, name):
        times, levels = bench.edges(name)
        self.edges = [(t, level) for t, level in zip(times.tolist(), levels.tolist(), strict=True) if t > SINCE]
        self.times = [t for t, _ in self.edges]
        self.first = 1 - self.edges[0][1]

    def level(self, at):
        found = bisect_right(self.times, at)
        return self.edges[found - 1][1] if found else self.first

    def count(self, start, stop):
        """Edges after the start, up to the stop."""
        return bisect_right(self.times, stop) - bisect_right(self.times, start)


def test_few_edges_are_exact_and_columns_are_true_to_a_column(ran):
    bench, scope = ran
    plain = Plain(bench, "x.clock")
    for start, stop, columns in windows(bench.now_ps, 300, 1):
        found = shown(scope, "x.clock", start, stop, columns)
        first = max(start, SINCE)
        if "times_ps" in found:
            assert found["times_ps"] == [first, *(t for t in plain.times if first < t <= stop)]
            assert found["levels"] == [plain.level(t) for t in found["times_ps"]]
            continue
        assert len(found["columns"]) == columns
        slack = 0 if not width_of(start, stop, columns) else (stop - start) // columns + 1  # a cell may reach over
        for number, sign in enumerate(found["columns"]):
            begin, end = (start + (stop - start) * n // columns for n in (number, number + 1))
            if end <= SINCE:
                assert sign == "-" or slack
            elif sign == "x":
                assert plain.count(max(begin, SINCE) - slack, end + slack)
            elif not slack and sign != "-":
                assert not plain.count(max(begin, SINCE), end - 1) and sign == str(plain.level(max(begin, SINCE)))


@pytest.mark.parametrize("columns", [1, 7, 50])
def test_up_to_two_levels_a_column_are_exact(ran, columns):
    """The first level is that at the start."""
    bench, scope = ran
    times = Plain(bench, "x.clock").times
    last, one_more = times[2 * columns - 2], times[2 * columns - 1]
    assert shown(scope, "x.clock", SINCE, last, columns)["times_ps"] == [SINCE, *times[: 2 * columns - 1]]
    assert len(shown(scope, "x.clock", SINCE, one_more, columns)["columns"]) == columns


@few_windows(50, 150)
@pytest.mark.parametrize("name", ["x.clock", "x.mov"])
def test_the_search_finds_all_actual_edges_and_levels(ran, name, number):
    bench, scope = ran
    plain = Plain(bench, name)
    for start, stop, _ in windows(bench.now_ps, number, 2):
        first = max(start, SINCE)
        for last in (False, True):
            end = -1 if last else 0
            for edge, wanted in (("rises", (1,)), ("falls", (0,)), ("any", (0, 1))):
                times = [t for t, level in plain.edges if first <= t <= stop and level in wanted]
                assert scope.find({"pin": name, "edge": edge}, start, stop, last) == (times[end] if times else None)
            for level in (0, 1):
                begun = [first, *(t for t in plain.times if first < t <= stop)] if first <= stop else []
                spans = zip(begun, [*(t - 1 for t in begun[1:]), stop], strict=False)
                fitting = [span for span in spans if plain.level(span[0]) == level]
                expected = None if not fitting else fitting[-1][1] if last else fitting[0][0]
                assert scope.find({"pin": name, "level": level}, start, stop, last) == expected


def test_a_position_is_crossed_where_the_step_is(ran):
    bench, scope = ran
    steps = bench["x"].steps()
    rows = list(zip(steps.times_ps.tolist(), steps.positions.tolist(), steps.directions.tolist(), strict=True))
    for start, stop, _ in windows(bench.now_ps, 60, 3):
        for value in (1, 20, 39):
            times = [t for t, position, way in rows if start < t <= stop and position == value and way == 1]
            for last in (False, True):
                found = scope.find({"quantity": "x.position", "value": value, "slope": "rises"}, start, stop, last)
                assert found == (times[-1 if last else 0] if times else None)


@few_windows(8, 30)
def test_kept_cells_and_computed_cells_show_the_same(ran, number):
    bench, _ = ran
    kept = Scope(bench)
    for start, stop, columns in windows(bench.now_ps, number, 4):
        for name in ("x.clock", "x.velocity", "x.position"):
            assert shown(kept, name, start, stop, columns) == shown(Scope(bench), name, start, stop, columns)


def test_a_cell_that_ends_now_is_not_kept_yet():
    cells, work = Cells(), []
    width = 1 << 33
    for _ in range(2):
        list(cells.between("x", 0, 2 * width - 1, 33, lambda start, end: work.append((start, end)) or "0"))
    assert work == [(0, width - 1), (width, 2 * width - 1), (width, 2 * width - 1)]  # more may be done at this instant


def test_the_first_cell_is_the_one_in_which_a_window_begins():
    cells = Cells()
    width = 1 << 33
    begun = [begin for begin, _ in cells.between("x", width + 5, 3 * width, 33, lambda _start, _end: "0")]
    assert begun == [width, 2 * width, 3 * width]
