"""Plots: what is drawn (the outlines), and files that are the same every time."""

from __future__ import annotations

import builtins
import re
import subprocess
import sys
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest

from slewline.core.axis import Steps
from slewline.core.timebase import Clock
from slewline.core.train import StepTrain
from slewline.errors import NotRecorded, UsageError
from slewline.record import outlines
from slewline.record.plots import Motion, TimeAxis, Trace, plot

MS = 10**9


def steps(times, signs=1, before=0) -> Steps:
    times = np.array(times, np.int64)
    signs = np.broadcast_to(np.array(signs, np.int8), times.shape)
    return Steps(times, signs, before + np.cumsum(signs, dtype=np.int64))


def pairs(outline) -> list[tuple[int, float]]:
    return list(zip(outline[0].tolist(), outline[1].tolist(), strict=True))


# -------------------------------------------------------------------------------------------------------- velocity
def test_velocity_is_a_line_of_runs_and_the_last_step_lasts_as_long_as_the_one_before():
    move = steps([10 * MS, 12 * MS, 14 * MS, 15 * MS, 16 * MS, 18 * MS])
    expected = [(0, 0), (10 * MS, 500), (14 * MS, 1000), (16 * MS, 500), (20 * MS, 0), (30 * MS, 0)]
    assert pairs(outlines.velocity(move, 0, 30 * MS)) == expected


def test_velocity_has_the_sign_of_the_direction_and_rests_between_moves():
    times = [10, 12, 14, 40, 42, 44]
    for back in (-1, 1):
        move = steps([t * MS for t in times], [1, 1, 1, back, back, back])
        expected = [(0, 0), (10, 500), (16, 0), (40, back * 500), (46, 0), (50, 0)]
        assert pairs(outlines.velocity(move, 0, 50 * MS)) == [(t * MS, v) for t, v in expected]


def test_velocity_that_turns_without_a_pause():
    move = steps([10 * MS, 12 * MS, 14 * MS, 16 * MS], [1, 1, -1, -1])
    expected = [(0, 0), (10, 500), (14, -500), (18, 0), (20, 0)]
    assert pairs(outlines.velocity(move, 0, 20 * MS)) == [(t * MS, v) for t, v in expected]


def test_velocity_at_the_edges_of_a_window_in_mid_move():
    move = steps([t * MS for t in range(0, 100, 2)])
    at, what = outlines.velocity(move, 50 * MS, 60 * MS)
    assert (at[-1], what[-1]) == (60 * MS, 500)
    assert what[np.searchsorted(at, 50 * MS, side="right") - 1] == 500


def test_velocity_of_lone_steps_is_that_of_their_distance():
    assert pairs(outlines.velocity(steps([]), 5, 9)) == [(5, 0), (9, 0)]
    assert pairs(outlines.velocity(steps([7]), 5, 9)) == [(5, 0), (9, 0)]
    lone = steps([10 * MS, 110 * MS, 112 * MS, 300 * MS, 500 * MS, 502 * MS, 504 * MS])
    assert pairs(outlines.velocity(lone, 0, 600 * MS))[-4:] == [
        (300 * MS, 5),
        (500 * MS, 500),
        (506 * MS, 0),
        (600 * MS, 0),
    ]


def test_a_pause_is_longer_than_what_is_around_it():
    assert outlines.pauses(np.array([3, 13, 3])).tolist() == [False, True, False]
    assert outlines.pauses(np.array([3, 12, 3])).tolist() == [False, False, False]
    assert outlines.pauses(np.array([30, 1, 1, 30, 30])).tolist() == [False] * 5  # slow first rate, steep slope
    assert outlines.pauses(np.array([30])).tolist() == [False]


def test_a_long_move_takes_few_points():
    train = StepTrain(Clock(11_000_000), 0, [(2000 - n, 40) for n in range(1500)])
    move = steps(train.begins())
    stop = int(move.times_ps[-1]) + MS
    at, what = outlines.velocity(move, 0, stop)
    assert len(at) <= 1504  # a point a run
    fast = steps(StepTrain(Clock(10**9), 0, [(1000 + n % 7 * 10, 1) for n in range(100_000)]).begins())
    at, what = outlines.velocity(fast, 0, int(fast.times_ps[-1]))
    assert len(at) <= 4 * outlines.COLUMNS
    assert what.max() == 10**6
    assert (np.diff(at) >= 0).all()


# -------------------------------------------------------------------------------------------------------- position
def test_few_steps_are_a_staircase():
    outline = outlines.position(steps([10, 20, 30], [1, 1, -1], before=5), 5, 0, 40)
    assert pairs(outline) == [(0, 5), (10, 5), (10, 6), (20, 6), (20, 7), (30, 7), (30, 6), (40, 6)]
    assert pairs(outlines.position(steps([]), 7, 0, 40)) == [(0, 7), (40, 7)]


def test_many_steps_are_straight_in_each_run():
    times = 1000 * np.concatenate([np.arange(100, 300), np.arange(302, 502, 2), np.arange(2000, 2200)])
    signs = [1] * 300 + [-1] * 200
    up = [(0, 0), (100, 0), (100, 1), (299, 200), (302, 201), (500, 300)]
    down = [(2000, 300), (2000, 299), (2199, 100), (2300, 100)]
    outline = outlines.position(steps(times, signs), 0, 0, 2_300_000)
    assert pairs(outline) == [(at * 1000, where) for at, where in (*up, *down)]


def test_position_that_turns_in_full_flight():
    outline = outlines.position(steps(range(1000, 401_000, 1000), [1] * 200 + [-1] * 200), 0, 0, 500_000)
    assert pairs(outline) == [(0, 0), (1000, 0), (1000, 1), (200_000, 200), (400_000, 0), (500_000, 0)]


def test_position_that_was_set_is_a_jump():
    move = steps(range(10, 410))
    move.positions[200:] += 1000
    outline = pairs(outlines.position(move, 0, 0, 500))
    assert (209, 200) in outline
    assert (210, 200) in outline
    assert (210, 1201) in outline


# ---------------------------------------------------------------------------------------------------------- traces
def test_edges_that_can_be_told_apart_are_a_line():
    outline, bands = outlines.logic(np.array([30_000, 60_000]), np.array([0, 1], np.int8), 1, 0, 300_000)
    assert pairs(outline) == [(0, 1), (30_000, 0), (60_000, 1), (300_000, 1)]
    assert bands.tolist() == []


def test_edges_that_cannot_are_a_band():
    burst = np.arange(100_000, 200_000, 100)  # ten in each of 300 stripes
    times = np.concatenate([[50_000], burst, [250_000]])
    values = (np.arange(len(times)) % 2).astype(np.int8)
    (at, what), bands = outlines.logic(times, values, 1, 0, 300_000)
    assert bands.tolist() == [[100_000, 199_900]]
    assert at.tolist() == [0, 50_000, 100_000, 199_900, 250_000, 300_000]
    assert np.isnan(what[2])
    assert what[[0, 1, 3, 4, 5]].tolist() == [1, 0, values[-2], values[-1], values[-1]]


def test_bands_with_a_gap_are_two():
    times = np.concatenate([np.arange(0, 10_000, 100), np.arange(20_000, 30_000, 100)])
    _, bands = outlines.logic(times, (np.arange(200) % 2).astype(np.int8), 1, 0, 300_000)
    assert bands.tolist() == [[0, 9_900], [20_000, 29_900]]
    empty, bands = outlines.logic(np.empty(0, np.int64), np.empty(0, np.int8), -1, 0, 9)
    assert pairs(empty) == [(0, -1), (9, -1)]
    assert len(bands) == 0


def test_thinning_keeps_what_shows():
    at = np.arange(100_000)
    what = np.sin(at / 7.0)
    what[12_345] = 99.0
    thin_at, thin = outlines.thinned(at, what, 0, 99_999)
    assert len(thin_at) <= 4 * outlines.COLUMNS
    assert thin.max() == 99.0
    assert thin.min() == what.min()
    assert (thin_at[0], thin_at[-1]) == (0, 99_999)


# ----------------------------------------------------------------------------------------------------------- files
def tracks(rig):
    for net in (rig.net("x.slew", pull=1), rig.bus("x.db"), rig.net("x.pulse", pull=1), rig.net("x.wait")):
        rig.recorder.record(net)
    rig.on(MS, x_db=(255, 0x5A), x_pulse=rig.pulses(Clock(11_000_000), 22_000, (3000, 200), (1840, 400), (3000, 100)))
    rig.on(2 * MS, x_db=None, x_wait=1)
    rig.on(50 * MS, x_slew=0)
    rig.kernel.run(200 * MS)
    move = steps(StepTrain(Clock(11_000_000), 22_000, [(3000, 200), (1840, 400), (3000, 100)]).begins())
    motion = Motion("x", move, {"F = 3": 3667, "R = 80": 5978}, {"S": 200, "Z": 1})
    traces = [Trace.of(name, net, rig.recorder, 0, 200 * MS) for name, net in rig.nets.items()]
    return [motion, *traces]


def test_svg_says_what_it_shows_and_is_small(rig, tmp_path):
    path = tmp_path / "a.svg"
    plot(path, "Drilling & more", *tracks(rig), start=0, stop=200 * MS)
    text = path.read_text()
    ElementTree.fromstring(text)
    for words in (
        "Drilling &amp; more",
        "Velocity in steps/s",
        "Position in steps",
        "Time in ms",
        "R = 80",
        "F = 3",
        "x.pulse",
        "5\u2009978 steps/s",
        "S = 200",
    ):
        assert words in text
    assert len(text) < 60_000
    assert not re.search(r"\d{4}-\d\d-\d\d", text)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("suffix", ["svg", "png"])
def test_same_bytes_every_time_whatever_the_configuration(rig, tmp_path, suffix):
    shown = tracks(rig)
    plot(tmp_path / f"a.{suffix}", "x", *shown, start=0, stop=200 * MS)
    with matplotlib.rc_context(
        {"axes.facecolor": "red", "xtick.major.pad": 40, "font.size": 30, "svg.hashsalt": None, "axes.grid": False}
    ):
        plot(tmp_path / f"b.{suffix}", "x", *shown, start=0, stop=200 * MS)
        assert matplotlib.rcParams["font.size"] == 30
    assert (tmp_path / f"a.{suffix}").read_bytes() == (tmp_path / f"b.{suffix}").read_bytes()
    if suffix == "png":
        assert (tmp_path / "a.png").read_bytes()[:4] == b"\x89PNG"


def test_plot_of_one_kind_of_track(rig, tmp_path):
    motion, *traces = tracks(rig)
    other = Motion("y", steps([5 * MS, 9 * MS], -1, before=3), {"R": 250, "limit": 255})
    plot(tmp_path / "a.png", "two axes", motion, other, start=0, stop=200 * MS)
    plot(tmp_path / "b.png", "pins", *traces, start=100, stop=3 * MS)
    plot(tmp_path / "c.png", "nothing moves", Motion("y", steps([])), start=0, stop=MS)


def test_plot_does_not_load_pyplot(tmp_path):
    code = (
        "import sys, numpy as np; from slewline.core.axis import Steps; from slewline.record.plots import *; "
        "z = np.array([1, 2, 3]); "
        f"plot({str(tmp_path / 'a.svg')!r}, 't', Motion('x', Steps(z, z, z)), start=0, stop=9); "
        "print('matplotlib.pyplot' in sys.modules)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == "False\n"


@pytest.mark.parametrize(
    ("start", "stop", "label", "scaled"),
    [
        (0, 3 * MS, "Time in ms", 3.0),
        (0, 1_999_999, "Time in ns", 1999.999),
        (0, 2_000_000, "Time in µs", 2.0),
        (0, 5 * 10**12, "Time in s", 5.0),
        (0, 100, "Time in ps", 100.0),
        (MS, 3 * MS, "Time in ms", 3.0),
        (3600 * 10**12, 3600 * 10**12 + 5, "Time in ps, from 3600 s on", 5.0),
    ],
)
def test_time_axis_has_a_unit_that_suits(start, stop, label, scaled):
    axis = TimeAxis(start, stop)
    assert axis.label == label
    assert axis.scaled([stop]).tolist() == [scaled]


def test_errors_are_clear_and_leave_nothing(rig, tmp_path, monkeypatch):
    motion = tracks(rig)[0]
    for name, start, stop, shown, message in [
        ("a.pdf", 0, 9, [motion], "allowed are file names ending in .svg or .png"),
        ("a", 0, 9, [motion], "allowed are file names ending in .svg or .png"),
        ("a.svg", 9, 9, [motion], "nothing to draw from 9 ps to 9 ps"),
        ("a.svg", 0, 9, [], "nothing to draw"),
        ("no/a.svg", 0, 9, [motion], "there is no directory"),
    ]:
        with pytest.raises(UsageError, match=message):
            plot(tmp_path / name, "t", *shown, start=start, stop=stop)
    with pytest.raises(NotRecorded):
        Trace.of("x.run", rig.net("x.run"), rig.recorder, 0, 9)
    load = builtins.__import__

    def refuse(name, *rest):
        if name.split(".")[0] == "matplotlib":
            raise ImportError(name)
        return load(name, *rest)

    monkeypatch.setattr(builtins, "__import__", refuse)
    with pytest.raises(UsageError, match=r"pip install slewline\[plot\]"):
        plot(tmp_path / "a.svg", "t", motion, start=0, stop=9)
    assert list(tmp_path.iterdir()) == []
