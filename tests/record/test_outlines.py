"""What a picture draws of a pin: the same of a few edges as of all."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import slewline
from slewline.bench.scripts.script import run_script
from slewline.core.motion.step_views import PatternView, PulseView
from slewline.core.motion.train import Playing, StepTrain
from slewline.core.time.timebase import Clock
from slewline.record.recording import outlines
from slewline.record.recording.recorder import FLOATING, Recorder

MS = 10**9
S = outlines.STRIPES


def drawn(recorder: Recorder, probe: Any, start: int, stop: int, *, whole: bool) -> tuple[Any, ...]:
    """The line and the bands, from all edges or from those that show."""
    if whole:
        times, levels = recorder.edges(probe, max(start, recorder.since(probe)) + 1, stop)
    else:
        times, levels = outlines.edges(recorder, probe, start, stop)
    since = max(recorder.since(probe), start)
    (at, what), bands = outlines.logic(times, levels, recorder.level(probe, since), start, stop, since)
    return at.tolist(), np.nan_to_num(what, nan=99).tolist(), bands.tolist()


@pytest.mark.parametrize("seed", range(12))
def test_a_few_edges_show_what_all_edges_show(
    lively: Callable[..., Any], seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(outlines, "STRIPES", 8)
    rig = lively(seed, events=120, span=60_000_000)
    rig.kernel.run(60_000_000)
    bands = 0
    for start, stop in ((0, 60_000_000), (7_000_001, 31_000_000), (20_000_000, 20_500_000)):
        for name in ("x.n0", "x.n1", "x.n2", "x.db"):
            net = rig.nets[name]
            all_of_them = drawn(rig.recorder, net, start, stop, whole=True)
            assert drawn(rig.recorder, net, start, stop, whole=False) == all_of_them, (name, start, stop)
            bands += len(all_of_them[2])
    assert bands


def test_the_same_where_a_recording_begins_within_the_window(rig: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(outlines, "STRIPES", 8)
    clock, net = Clock(11_000_000), rig.net("x.pulse", pull=1)
    runs = [(500, 4), (9000, 1)] * 9
    rig.drivers["x.pulse"].play(PulseView(Playing(StepTrain(clock, 0, runs)), 28))
    rig.kernel.run(2 * MS)
    rig.recorder.record(net)
    rig.kernel.run(10 * MS)
    for stop in range(3 * MS, 10 * MS, MS // 7):
        whole = drawn(rig.recorder, net, 0, stop, whole=True)
        assert drawn(rig.recorder, net, 0, stop, whole=False) == whole and whole[0][0] == 2 * MS
    (at, _), bands = outlines.logic(*rig.recorder.edges(net, 2 * MS, 2 * MS), 0, 0, MS, 2 * MS)
    assert not len(at) and not len(bands)


def test_a_long_motion_is_not_expanded(rig: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Four motions of 20 s each, of which a picture of 100 s shows four bands."""
    clock, net = Clock(11_000_000), rig.net("x.pulse", pull=1)
    rig.recorder.record(net)
    trains = [StepTrain(clock, clock.ticks_from(n * 25 * 1000 * MS), [(3000, 5000), (1100, 187_000)]) for n in range(4)]
    for train in trains:
        rig.kernel.run(clock.ps(train.origin))
        rig.drivers["x.pulse"].play(PulseView(Playing(train), 28))
    rig.kernel.run(100_000 * MS)
    counted = []
    expanded = PulseView.edges
    monkeypatch.setattr(PulseView, "edges", lambda *of: (found := expanded(*of), counted.append(len(found[0])))[0])
    few = drawn(rig.recorder, net, 0, 100_000 * MS, whole=False)
    assert sum(counted) < 10_000  # of a million and a half
    assert len(outlines.edges(rig.recorder, net, 0, 100_000 * MS)[0]) < 6 * S
    assert few == drawn(rig.recorder, net, 0, 100_000 * MS, whole=True)
    assert len(few[2]) == 4


def test_phases_of_a_pattern_show_alike(rig: Any) -> None:
    clock, net = Clock(11_000_000), rig.net("x.phase1", pull=0)
    rig.recorder.record(net)
    playing = Playing(StepTrain(clock, 1000, [(9000, 50), (2000, 3000), (9000, 40)]))
    rig.drivers["x.phase1"].play(PatternView(playing, (0, 1, 1, 0), 0, 1, 0))
    rig.kernel.run(2000 * MS)
    for stop in (40 * MS, 300 * MS, 640 * MS, 2000 * MS):
        few = drawn(rig.recorder, net, 0, stop, whole=False)
        assert few == drawn(rig.recorder, net, 0, stop, whole=True)


def test_floating_stays_floating(rig: Any) -> None:
    net = rig.net("x.open")
    rig.recorder.record(net)
    rig.on(5 * MS, x_open=1)
    rig.on(7 * MS, x_open=None)
    rig.kernel.run(10 * MS)
    (at, what), bands = outlines.logic(*outlines.edges(rig.recorder, net, 0, 10 * MS), FLOATING, 0, 10 * MS)
    assert list(zip(at.tolist(), what.tolist(), strict=True)) == [
        (0, FLOATING),
        (5 * MS, 1),
        (7 * MS, FLOATING),
        (10 * MS, FLOATING),
    ]
    assert not len(bands)


def test_an_edge_at_the_start_of_a_window_is_outside_and_one_at_its_end_inside(rig: Any) -> None:
    net = rig.net("x.open", pull=0)
    rig.recorder.record(net)
    for ps, level in ((5 * MS, 1), (7 * MS, 0), (9 * MS, 1)):
        rig.on(ps, x_open=level)
    rig.kernel.run(10 * MS)
    times, levels = outlines.edges(rig.recorder, net, 5 * MS, 9 * MS)
    assert list(zip(times.tolist(), levels.tolist(), strict=True)) == [(7 * MS, 0), (9 * MS, 1)]


def test_edges_in_a_stripe_are_a_band_from_the_first_to_the_last() -> None:
    times = np.array([10, 1000, 1001, 1002, 1003, 5000]) * 1000
    levels = np.array([1, 0, 1, 0, 1, 0], np.int8)
    (at, what), bands = outlines.logic(times, levels, 0, 0, S * 10_000)
    assert bands.tolist() == [[1_000_000, 1_003_000]]
    assert at.tolist() == [0, 10_000, 1_000_000, 1_003_000, 5_000_000, S * 10_000]
    assert np.nan_to_num(what, nan=9).tolist() == [0, 1, 9, 1, 0, 0]


def test_the_pins_of_a_program_that_moves_over_and_over_show_alike() -> None:
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.record("x.pulse", "x.slew", "x.run", "x.direction")
    bench.host(x).send("A 0\rF 60\rR 120\rS 255\rZ 1\rE\rA$P 30\rP 0\rD 20\rJ A\r0\rQX\r")
    bench.run("9 s")
    for start in (0, 1_234_567_890_123):
        for name, net in bench.recorded.items():
            few = drawn(bench._signals.recorder, net, start, bench.now_ps, whole=False)
            assert few == drawn(bench._signals.recorder, net, start, bench.now_ps, whole=True), name
            assert len(outlines.edges(bench._signals.recorder, net, start, bench.now_ps)[0]) <= (outlines.DENSE + 2) * S


@pytest.mark.parametrize("part", ["cy525", "gs-c200s", "mc1451a"])
def test_the_pins_of_every_family_show_alike(part: str) -> None:
    bench = slewline.Bench()
    straps = {"br0": 0, "br1": 0, "br2": 0, "chs": 0} if part == "gs-c200s" else None
    x = bench.add(part, name="x", straps=straps)
    bench.record()
    run_script(bench, bench.host(x), {
        "cy525": "A 0\nF 20\nR 100\nS 200\nZ 1\nN 900\n+\nG\n-\nG\n",
        "gs-c200s": "Po\nS100\nT500\nR20\n+900\n-900\nE\n",
        "mc1451a": "SET_VEL 0x8000\nSET_ACC 0x400\nSET_POS 900\nUPDATE\n",
    }[part])  # fmt: skip
    bench.run("1500 ms")
    bands = 0
    for name, net in bench.recorded.items():
        few = drawn(bench._signals.recorder, net, 0, bench.now_ps, whole=False)
        assert few == drawn(bench._signals.recorder, net, 0, bench.now_ps, whole=True), name
        bands += len(few[2])
    assert bands
