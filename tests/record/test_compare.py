"""A measured recording against the model's: pairs of edges, what is missing, what is late."""

from __future__ import annotations

import numpy as np
import pytest

import slewline
from slewline.errors import TimeError, UsageError
from slewline.record.measuring.compare_edges import _fits, _pairs
from tests.rows import rows

US = 10**6


def pulses(count: int, period: int = 100 * US, width: int = 5 * US, begin: int = 7 * US):
    """A pulse to 0 every period: times and levels."""
    falls = begin + period * np.arange(count, dtype=np.int64)
    times = np.stack([falls, falls + width], axis=1).ravel()
    return times, np.tile(np.array([0, 1], np.int8), count)


def without(edges, *indices):
    return np.delete(edges[0], indices), np.delete(edges[1], indices)


def moved(edges, index, by):
    times = edges[0].copy()
    times[index] += by
    return times, edges[1]


def differences(comparison):
    return [(row.kind, row.edge, row.time_ps, row.level, row.late_ps) for row in comparison.rows]


def test_the_same_edges_agree_whenever_the_recording_began():
    model = pulses(1000)
    measured = model[0] + 1_234_567, model[1]
    found = slewline.compare_edges(model, measured, name="x.pulse")
    assert found.agrees and found.shift_ps == -1_234_567 and len(found.pairs) == 2000 and found.rows == []
    assert (found.greatest_ps, found.mean_ps, found.drift_ppm) == (0, 0.0, 0.0)
    assert str(found) == (
        "x.pulse: 2000 edges in the model, 2000 measured, shifted by -1.234567 µs: agree\n"
        "  2000 pairs: at most 0 ps apart, 0 ps on average, drift +0.0 ppm"
    )


def test_a_late_edge_is_reported():
    model = pulses(1000)
    found = slewline.compare_edges(model, moved(moved(model, 412, 2_300_000), 413, -1), tolerance=1)
    assert differences(found) == [("late", 412, int(model[0][412]), 0, 2_300_000)]
    assert str(found.rows[0]) == "edge 412 (falls) at 20.607 ms is 2.3 µs late"
    assert not found.agrees and found.greatest_ps == 2_300_000 and found.mean_ps == 2_300_001 / 2000
    assert (
        "differ (tolerance 1 ps)\n  edge 412 (falls) at 20.607 ms is 2.3 µs late\n  2000 pairs: at most 2.3 µs"
        in str(found)
    )
    assert slewline.compare_edges(model, moved(model, 412, 2_300_000), tolerance="2.3 us").agrees
    assert ": agree within 2.3 µs\n" in str(slewline.compare_edges(model, moved(model, 412, 9), tolerance="2.3 us"))
    early = slewline.compare_edges(model, moved(model, 413, -7000))
    assert [str(row) for row in early.rows] == ["edge 413 (rises) at 20.612 ms is 7 ns early"]


@pytest.mark.parametrize("drift", [0, 80, 900])  # parts per million
def test_missing_and_extra_edges_are_reported_with_their_place(drift):
    model = pulses(5000)
    times, levels = without(model, 824, 825, 9998, 9999)
    extra = model[0][3001] + 30 * US  # a glitch: 2 us long, between two pulses
    at = int(np.searchsorted(times, extra))
    times = np.insert(times, at, [extra, extra + 2 * US])
    measured = times + (times - times[0]) * drift // 10**6, np.insert(levels, at, [0, 1])
    found = slewline.compare_edges(model, measured, tolerance="1 ms")
    assert found.missing.tolist() == [824, 825, 9998, 9999] and found.extra.tolist() == [3000, 3001]
    assert len(found.pairs) == 9996 and found.drift_ppm == pytest.approx(drift, abs=0.01)
    assert [row.kind for row in found.rows] == ["missing", "missing", "extra", "extra", "missing", "missing"]
    assert differences(found)[2][1:4:2] == (3000, 0) and found.rows[2].time_ps == pytest.approx(
        int(extra), abs=500 * US
    )
    assert str(found.rows[0]) == "edge 824 (falls) at 41.207 ms is missing"


def test_a_clock_that_is_slow_makes_nothing_missing():
    """Far from the first edge the drift is many pulses; across a rest it comes at once."""
    first = pulses(4000)
    later = first[0] + 30 * 10**12
    model = np.concatenate([first[0], later]), np.tile(first[1], 2)
    measured = model[0] + (model[0] - model[0][0]) * 100 // 10**6 + 5, model[1]
    found = slewline.compare_edges(model, measured, tolerance=0)
    assert len(found.pairs) == 16_000 and not len(found.missing) and not len(found.extra)
    assert found.drift_ppm == pytest.approx(100, abs=0.001) and not found.agrees
    assert str(found).endswith("ms on average, drift +100.0 ppm")
    assert "  and 15989 more; in all 0 missing, 0 extra" in str(found)


def test_as_many_edges_but_not_the_same_ones():
    """A pulse is missing and another one is extra: that is no drift."""
    model = pulses(100)
    times, levels = without(model, 40, 41)
    measured = np.sort(np.append(times, [model[0][140] + 30 * US, model[0][140] + 35 * US])), model[1]
    found = slewline.compare_edges(model, measured)
    assert found.missing.tolist() == [40, 41] and found.extra.tolist() == [140, 141]
    assert len(levels) == 198


def test_another_rate_is_not_a_drift():
    model = pulses(100)
    found = slewline.compare_edges(model, pulses(100, period=50 * US, width=3 * US))
    assert len(found.missing) == len(found.extra) > 50


def test_shifts():
    ramp = np.cumsum(np.linspace(200 * US, 20 * US, 300).astype(np.int64))
    model = np.stack([ramp, ramp + 3 * US], axis=1).ravel(), np.tile(np.array([0, 1], np.int8), 300)
    measured = model[0][6:] - 5_000_000_007, model[1][6:]  # it began too late
    first, best = (slewline.compare_edges(model, measured, shift=how) for how in ("first", "best"))
    assert first.shift_ps == model[0][0] - measured[0][0] and first.greatest_ps > 100 * US
    assert best.shift_ps == 5_000_000_007 and best.greatest_ps == 0 and best.missing.tolist() == [0, 1, 2, 3, 4, 5]
    given = slewline.compare_edges(model, measured, shift=5_000_000_000)
    assert given.greatest_ps == 7 and set(given.late_ps.tolist()) == {-7}
    assert slewline.compare_edges(model, measured, shift="5000.000007 us").greatest_ps == 0
    glitch = (
        np.append([measured[0][0] - 50 * US, measured[0][0] - 49 * US], measured[0]),
        np.append([0, 1], measured[1]),
    )
    found = slewline.compare_edges(model, glitch, shift="best")
    assert found.shift_ps == 5_000_000_007 and found.extra.tolist() == [0, 1]


def test_the_first_edges_that_meet_go_to_the_same_level():
    model = pulses(50)
    measured = model[0][1:] + 500, model[1][1:]  # it began within a pulse
    found = slewline.compare_edges(model, measured)
    assert found.shift_ps == model[0][0] - measured[0][1] and found.extra.tolist() == [0]
    assert slewline.compare_edges(model, measured, shift="best").shift_ps == -500


def test_buses_compare_their_values():
    times = 10 * US * np.arange(1, 6, dtype=np.int64)
    model = times, np.array([1, 2, 3, 2, 9], np.int16)
    found = slewline.compare_edges(model, (times, np.array([1, 2, 0x2A, 2, 9], np.int16)))
    assert [str(row) for row in found.rows] == [
        "edge 2 (becomes 03) at 30 µs is missing", "edge 2 (becomes 2A) at 30 µs is extra",
    ]  # fmt: skip


def test_nothing_to_compare():
    empty, some = (np.empty(0, np.int64), np.empty(0, np.int8)), pulses(2)
    assert slewline.compare_edges(empty, empty).agrees
    for found in (slewline.compare_edges(some, empty, shift="best"), slewline.compare_edges(some, empty)):
        assert found.missing.tolist() == [0, 1, 2, 3] and found.shift_ps == 0 and found.drift_ppm == 0
    assert slewline.compare_edges(empty, some).extra.tolist() == [0, 1, 2, 3]
    assert str(slewline.compare_edges(some, empty)).endswith("edge 3 (rises) at 112 µs is missing")


def test_wrong_use():
    model = pulses(3)
    with pytest.raises(UsageError, match="measured: 6 times and 5 levels; expected ascending times"):
        slewline.compare_edges(model, (model[0], model[1][1:]))
    with pytest.raises(UsageError, match="model: 6 times and 6 levels; expected ascending times, and a level for each"):
        slewline.compare_edges((model[0][::-1], model[1]), model)
    for options in ({"shift": "soon"}, {"shift": 0.5}, {"tolerance": "-1 us"}):
        with pytest.raises(TimeError):
            slewline.compare_edges(model, model, **options)


def stepwise(model, measured):
    """The same rule, an edge at a time: the twin of the runs."""
    ends = np.array([1 << 62] * 2)
    columns = [np.append(edges[0], ends) for edges in (model, measured)]
    columns += [np.append(edges[1].astype(np.int64), ends) for edges in (model, measured)]
    a = b = late = 0
    out = []
    while a < len(model[0]) and b < len(measured[0]):
        if _fits(columns, a, b, 1, late)[0]:
            out.append([a, b])
            late = int(measured[0][b] - model[0][a])
            a, b = a + 1, b + 1
        elif model[0][a] + late <= measured[0][b]:
            a += 1
        else:
            b += 1
    return out


@rows("seed", range(20))
def test_runs_of_pairs_are_those_found_one_by_one(seed):
    random = np.random.default_rng(seed)
    model = pulses(150, width=20 * US)
    jitter = model[0] + random.integers(-8 * US, 8 * US, len(model[0]))
    measured = without((jitter, model[1]), *random.choice(300, random.integers(1, 30), replace=False))
    assert _pairs(model, measured).tolist() == stepwise(model, measured)


def test_a_measured_recording_against_a_run(tmp_path):
    """Sampled at 1 MHz, started 3 ms late, with one step lost: the model says which."""
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.record("x.pulse", "x.slew")
    bench.host(x).send("A 0\rF 10\rR 80\rS 240\rZ 1\rN 300\rG\r")
    bench.run_until_idle()
    bench.save_vcd(tmp_path / "model.vcd", timescale="1 us")
    lines, time, falls = [], 0, 0
    for line in (tmp_path / "model.vcd").read_text().split("\n"):
        if line.startswith("#"):
            time = int(line[1:])
            line = f"#{time + 3000 if time else 0}"
        elif line == "0!" and time:
            falls += 1
            line = "" if falls == 200 else line
        lines.append(line)
    (tmp_path / "board.vcd").write_text("\n".join(lines))
    board = slewline.read_vcd(tmp_path / "board.vcd")
    found = slewline.compare_edges(bench.edges("x.pulse"), board.edges("pulse"), tolerance="1 us")
    assert abs(found.shift_ps + 3 * 10**9) <= US
    assert [(row.kind, row.level) for row in found.rows] == [("missing", 0), ("missing", 1)]
    assert found.rows[0].time_ps == x.steps().times_ps[199]
    assert len(board.steps("pulse")) == 299


@pytest.mark.parametrize("begin", [0, 13, 101, 500])
def test_the_best_shift_of_a_recording_that_begins_in_mid_move(begin):
    """In the ramp, in the plateau, and the other way round: the recording began before the model's."""
    gaps = [*range(900, 100, -8), *[100] * 800, *range(100, 900, 8)]
    times = np.cumsum(gaps) * US
    model = times, np.arange(len(times)) % 2
    found = slewline.compare_edges(model, (times[begin:] + 7_000 * US, model[1][begin:]), shift="best", tolerance=US)
    assert (found.shift_ps, len(found.missing), len(found.extra), len(found.rows)) == (-7_000 * US, begin, 0, begin)
    found = slewline.compare_edges((times[begin:] + 3_000 * US, model[1][begin:]), model, shift="best", tolerance=US)
    assert (found.shift_ps, len(found.missing), len(found.extra), len(found.rows)) == (3_000 * US, 0, begin, begin)
