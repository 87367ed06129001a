"""Figures: what is drawn, read back from the lines and texts; the look; and files that are the same every time."""

from __future__ import annotations

import builtins
import re
import subprocess
import sys
from itertools import pairwise
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from slewline.core.motion.motions import Mark, MotionStart
from slewline.core.motion.quantity import Outline, Quantity
from slewline.core.time.timebase import Clock
from slewline.errors import UsageError
from slewline.record.pictures import figures, lanes, marks, panels, rate_lines
from slewline.record.pictures.figures import Contents, description_of, figure
from slewline.record.pictures.picture_files import save
from slewline.record.pictures.tracks import Track
from slewline.record.recording.traces import Trace
from slewline.record.style import DARK, LIGHT, TimeAxis, duration, inches, number
from tests.rows import rows

MS = 10**9


class Told(Quantity):
    """A quantity of which the changes are given."""

    def __init__(self, name, unit, points, is_staircase=True):
        self.name, self.unit, self.is_staircase, self.points = name, unit, is_staircase, points

    def changes(self, start, stop):
        times, values = zip(*self.points, strict=True)
        return Outline(np.array(times, np.int64), np.array(values, np.float64))

    def outline(self, start, stop, columns):
        return self.changes(start, stop)


def track(name="x", top=1000.0, reach=50.0, **more) -> Track:
    velocity = Told("velocity", "steps/s", [(0, 0), (10 * MS, top), (60 * MS, 0)])
    position = Told("position", "steps", [(0, 0), (10 * MS, 1), (60 * MS, reach)])
    return Track(name, [velocity, position], **more)


def contents(*tracks, traces=(), start=0, stop=100 * MS, **more) -> Contents:
    return Contents("A move", tracks, traces, start, stop, **more)


def texts(shown) -> list[str]:
    found = [text.get_text() for text in shown.texts]
    for axes in shown.axes:
        found += [text.get_text() for text in axes.texts] + [axes.get_title(loc="left"), axes.get_xlabel()]
    return [text for text in found if text]


def line(shown, name):
    """The line of a quantity, by its name."""
    return next(line for axes in shown.axes for line in axes.lines if line.get_gid() == name)


# -------------------------------------------------------------------------------------------------------- what is drawn
def test_a_line_is_the_outline_extended_to_the_end_of_the_window():
    drawn = line(figure(contents(track())), "velocity of x")
    assert drawn.get_xdata().tolist() == [0, 10, 60, 100]
    assert drawn.get_ydata().tolist() == [0, 1000, 0, 0]
    assert drawn.get_drawstyle() == "steps-post"


def test_a_continuous_quantity_is_drawn_straight():
    angle = Told("angle", "°", [(0, 0), (50 * MS, 3)], is_staircase=False)
    drawn = line(figure(contents(Track("m", [angle]))), "angle of m")
    assert drawn.get_drawstyle() == "default"


def test_a_load_is_a_break_and_earlier_values_do_not_flatten_the_motion():
    position = Told("position", "steps", [(0, 42330), (MS, np.nan), (MS, 0), (10 * MS, 1), (60 * MS, 50)])
    shown = figure(contents(Track("x", [position])))
    drawn = line(shown, "position of x").get_ydata()
    assert np.isnan(drawn[1])
    assert drawn[0] == 42330
    low, high = shown.axes[0].get_ylim()
    assert -10 < low < 0 < 50 < high < 60
    assert "↑ 42\u2009330" in texts(shown)


def test_a_load_in_a_motion_belongs_to_it():
    position = Told("position", "steps", [(0, 0), (MS, 5), (2 * MS, np.nan), (2 * MS, 900), (9 * MS, 910)])
    assert figure(contents(Track("x", [position]))).axes[0].get_ylim()[1] > 910


def test_axes_and_runs_share_one_column_of_panels_and_are_distinguishable():
    shown = figure(contents(*(track(f"axis {n}", top=1000.0 * n) for n in (1, 2, 3, 4))))
    assert [axes.get_title(loc="left") for axes in shown.axes] == ["Velocity, steps/s", "Position, steps"]
    lines = [line(shown, f"velocity of axis {n}") for n in (1, 2, 3, 4)]
    assert len({each.get_color() for each in lines}) == len({str(each._unscaled_dash_pattern) for each in lines}) == 4
    assert {f"axis {n}" for n in (1, 2, 3, 4)} <= set(texts(shown))  # the legend


def test_lines_are_solid_dashed_dotted_and_both_by_turns(tmp_path):
    shown = figure(contents(*(track(f"axis {n}", top=1000.0 * n) for n in (1, 2, 3, 4))))
    save(shown, tmp_path / "axes.svg", "Axes", "Four axes.")
    groups = {each.get("id"): each for each in ElementTree.parse(tmp_path / "axes.svg").iter()}
    styles = [groups[f"velocity of axis {n}"][0].get("style") for n in (1, 2, 3, 4)]
    dashes = [re.search("stroke-dasharray: ([0-9.,]+)", style) for style in styles]
    assert [each and each[1] for each in dashes] == [None, "7.5,2.4", "1.8,1.8", "9,2.25,1.8,2.25"]  # points


def test_a_run_is_overlaid_at_its_own_zero():
    late = Track(
        "late", [Told("velocity", "steps/s", [(0, 0), (30 * MS, 7), (80 * MS, 0)])], zero=20 * MS, until=90 * MS
    )
    drawn = line(figure(contents(track("x"), late)), "velocity of late")
    assert drawn.get_xdata().tolist() == [-20, 10, 60, 70]


def test_an_otherwise_flat_line_gets_a_panel_of_its_own():
    shown = figure(contents(track("slow", top=10), track("fast", top=9000), track("other", top=8000)))
    assert [axes.get_title(loc="left") for axes in shown.axes] == [
        "Velocity of slow, steps/s",
        "Velocity of fast, other, steps/s",
        "Position, steps",
    ]


def test_great_numbers_are_written_in_thousands_or_millions():
    jerk = Told("jerk", "steps/s³", [(0, 0), (10 * MS, 2_500_000), (60 * MS, 0)])
    shown = figure(contents(Track("x", [jerk])))
    assert shown.axes[0].get_title(loc="left") == "Jerk, 10⁶ steps/s³"
    assert shown.axes[0].yaxis.get_major_formatter()(2_000_000) == "2"
    shown = figure(contents(track(top=999_999)))
    assert shown.axes[0].get_title(loc="left") == "Velocity, steps/s"
    assert shown.axes[0].yaxis.get_major_formatter()(-20_000) == "\u221220\u2009000"


def test_a_title_of_any_letters_is_announced_to_a_screen_reader(tmp_path):
    shown = figure(Contents('R < 80 & "S" > 2', [track()], [], 0, 100 * MS))
    save(shown, tmp_path / "a.svg", 'R < 80 & "S" > 2', description_of(shown))
    svg = ElementTree.parse(tmp_path / "a.svg")
    assert svg.findtext("{*}title") == 'R < 80 & "S" > 2'
    assert svg.findtext("{*}desc").startswith('R < 80 & "S" > 2, from 0 ps to 100 ms.')


# ---------------------------------------------------------------------------------------------------------------- rates
def dashed(axes) -> list[tuple[float, list[tuple[float, float]]]]:
    collections = [each for each in axes.collections if type(each).__name__ == "LineCollection"]
    return [(c.get_segments()[0][0][1], [(s[0][0], s[1][0]) for s in c.get_segments()]) for c in collections]


def test_a_rate_is_drawn_until_another_takes_its_place_in_the_same_motion():
    velocity = Told("velocity", "steps/s", [(0, 0), (10 * MS, 700), (30 * MS, 500), (40 * MS, 0), (50 * MS, 900)])
    changes = ((20 * MS, {"R = 5": 500.0}), (40 * MS, {}), (50 * MS, {"R = 90 and more": 900.0}))
    motion = MotionStart(10 * MS, "G", {"R = 7": 700.0}, changes=changes)
    whole = figure(contents(Track("x", [velocity], [motion])))
    assert dashed(whole.axes[0]) == [(700.0, [(10, 20)]), (500.0, [(20, 40)]), (900.0, [(50, 100)])]
    later = figure(contents(Track("x", [velocity], [motion]), start=25 * MS, stop=45 * MS))
    assert dashed(later.axes[0]) == [(500.0, [(25, 40)])]
    assert "R = 90 and more, 900 steps/s" in texts(whole)
    narrower = figure(contents(Track("x", [velocity], [MotionStart(10 * MS, "G", {"R = 7": 700.0})])))
    assert whole.axes[0].get_position().x1 < narrower.axes[0].get_position().x1  # room for the longest name


def test_a_rate_is_drawn_while_it_was_in_force_and_named_once():
    velocity = Told(
        "velocity",
        "steps/s",
        [(0, 0), (10 * MS, 500), (20 * MS, 0), (30 * MS, 500), (40 * MS, 0), (50 * MS, -700), (70 * MS, 0)],
    )
    motions = [MotionStart(begin * MS, "G", {"F = 5": 500.0, "R = 7": 700.4}) for begin in (10, 30, 50)]
    motions[1] = MotionStart(30 * MS, "G", {"F = 5": 500.0})
    shown = figure(contents(Track("x", [velocity], motions)))
    assert dict(dashed(shown.axes[0])) == {
        500.0: [(10, 20), (30, 40)],
        700.4: [(10, 20)],
        -500.0: [(50, 70)],
        -700.4: [(50, 70)],
    }
    named = [text for text in texts(shown) if " = " in text]
    assert sorted(named) == sorted(
        ["F = 5, 500 steps/s", "R = 7, 700 steps/s", "F = 5, \u2212500 steps/s", "R = 7, \u2212700 steps/s"]
    )


def test_a_rate_of_several_runs_is_one_line_as_long_as_it_was_in_force_in_one_of_them():
    spans = {"a": (10, 60), "b": (20, 30), "c": (70, 80)}
    runs = []
    for name, (begin, end) in spans.items():
        velocity = Told("velocity", "steps/s", [(0, 0), (begin * MS, 500), (end * MS, 0)])
        runs.append(Track(name, [velocity], [MotionStart(begin * MS, "G", {"F = 5": 500.0})]))
    assert dict(dashed(figure(contents(*runs)).axes[0])) == {500.0: [(10, 60), (70, 80)]}


def test_names_of_rates_do_not_meet_and_the_outermost_stay():
    rates = {f"R = {n}": 900.0 + n for n in range(40)}
    shown = figure(contents(track(motions=[MotionStart(10 * MS, "G", rates)])))
    axes = shown.axes[0]
    named = [text for text in axes.texts if "R = " in text.get_text()]
    places = sorted(text.xy[1] for text in named)
    low, high = axes.get_ylim()
    apart = (high - low) * rate_lines.RATE_HEIGHT / figures.HEIGHTS["velocity"]
    assert np.diff(places).min() > 0.99 * apart
    assert {"R = 0, 900 steps/s", "R = 39, 939 steps/s"} <= {text.get_text() for text in named}
    assert places[-1] <= high


def test_a_narrow_picture_names_rates_within_the_panel():
    motion = MotionStart(10 * MS, "G", {"R = 80": 900.0})
    shown = figure(contents(track(motions=[motion])), width="phone")
    assert "R = 80" in texts(shown)


# ---------------------------------------------------------------------------------------------------------------- marks
def test_events_are_flagged_and_thinned():
    happened = [Mark(10 * MS, "finding", "busy"), Mark(20 * MS, "limit", "poslimit"), Mark(90 * MS, "home", "home")]
    motions = [MotionStart(10 * MS, "G"), MotionStart(10 * MS, "G")]
    axis = TimeAxis(0, 100 * MS)
    flags = marks.flags_of([track(motions=motions, marks=happened)], axis, 8.0)
    assert [(flag.at, flag.kind, flag.text) for flag in flags] == [
        (10, "finding", "busy"),
        (20, "limit", "poslimit"),
        (90, "home", "home"),
        (10, "command", "G"),
    ]
    assert [flag.row for flag in flags] == [0, 0, 0, 1]
    many = [Mark(n * 10**7, "command", f"P {n}") for n in range(10_000)]
    flags = marks.flags_of([track(marks=many)], axis, 8.0)
    assert len(flags) <= 8.0 / marks.SIDE_BY_SIDE + 1
    assert sum(flag.row is not None for flag in flags) < 60


def test_events_of_each_run_are_flagged_from_its_own_zero():
    runs = [
        track("early", marks=[Mark(20 * MS, "finding", "lost")]),
        track("late", zero=50 * MS, marks=[Mark(120 * MS, "finding", "stalled")]),
    ]
    flags = marks.flags_of(runs, TimeAxis(0, 100 * MS), 8.0)
    assert [(flag.at, flag.text) for flag in flags] == [(20, "lost"), (70, "stalled")]


def test_marks_outside_the_window_and_unwanted_ones_are_not_drawn():
    tracks = track(marks=[Mark(200 * MS, "limit", "poslimit"), Mark(50 * MS, "home", "home 1")])
    assert "home 1" in texts(figure(contents(tracks)))
    assert "poslimit" not in texts(figure(contents(tracks)))
    assert "home 1" not in texts(figure(contents(tracks, marks=False)))


def test_phases_are_shaded_and_named_if_they_have_room():
    phases = [(10 * MS, 30 * MS, "1"), (30 * MS, 40 * MS, "2"), (40 * MS, 60 * MS, "3")]
    shown = figure(contents(track(phases=phases)))
    assert {"1", "2", "3"} <= set(texts(shown))
    assert all(len(axes.patches) == 2 for axes in shown.axes)  # every second one
    short = [(n * 10**7, (n + 1) * 10**7, "slew") for n in range(1000)]
    differing = [track("a", phases=phases), track("b", phases=phases[:1])]
    for tracks in ([track(phases=short)], differing):
        shown = figure(contents(*tracks))
        assert not {"slew", "1"} & set(texts(shown))
        assert not any(axes.patches for axes in shown.axes)  # no stripes


def test_the_start_of_a_motion_is_flagged_rather_than_a_load_next_to_it():
    loads = [Mark(9 * MS, "command", "A 0"), Mark(11 * MS, "command", "A 1"), Mark(90 * MS, "command", "A 2")]
    shown = set(texts(figure(contents(track(motions=[MotionStart(10 * MS, "G")], marks=loads)))))
    assert {"G", "A 2"} <= shown
    assert not {"A 0", "A 1"} & shown


def test_cursors_are_numbered_lines_through_all_panels():
    shown = figure(contents(track(), cursors=[20 * MS, 35 * MS]))
    assert {"1", "2"} <= set(texts(shown))
    for axes in shown.axes:
        at = [each.get_xdata()[0] for each in axes.lines if each.get_color() == LIGHT.cursor]
        assert at == [20, 35]


# ----------------------------------------------------------------------------------------------------------------- pins
def traces(rig) -> list[Trace]:
    for net in (rig.net("slew", pull=1), rig.bus("db"), rig.net("pulse", pull=1), rig.net("programmable_output")):
        rig.recorder.record(net)
    rig.on(MS, slew=1)
    rig.drivers["db"].drive((255, 0x5A))
    rig.drivers["pulse"].drive(rig.pulses(Clock(11_000_000), 22_000, (3000, 200), (1840, 400), (3000, 100)))
    rig.kernel.settle()
    rig.kernel.run(50 * MS)
    rig.drivers["db"].drive(None)
    rig.drivers["slew"].drive(0)
    rig.kernel.run(200 * MS)
    return [Trace.of(name, net, rig.recorder, 0, 200 * MS) for name, net in rig.nets.items()]


def test_pins_have_a_lane_each_and_a_bus_its_bytes(rig):
    shown = figure(contents(traces=traces(rig), stop=200 * MS))
    (panel,) = shown.axes
    assert [label.get_text() for label in panel.get_yticklabels()] == ["slew", "db", "pulse", "programmable_\noutput"]
    assert "5A" in texts(shown)
    slew = panel.lines[0]
    levels = slew.get_ydata()
    assert slew.get_xdata().tolist() == [0, 50, 200]
    assert levels[0] > levels[1] == levels[2]


def test_while_nothing_drives_a_pin_or_a_bus_its_lane_has_a_dashed_line_in_the_middle(rig):
    (panel,) = figure(contents(traces=traces(rig), stop=200 * MS)).axes
    assert dashed(panel) == [(pytest.approx(2.46), [(0, 1), (50, 200)]), (pytest.approx(0.46), [(0, 200)])]


def test_names_that_do_not_fit_next_to_their_lanes_are_above_them():
    assert lanes.wrapped("motion_complete", 13) == "motion_\ncomplete"
    assert lanes.wrapped("a.motion_complete_of_all", 13) is None
    none = np.empty(0, np.int64)
    shown = figure(contents(traces=[Trace("the_motion.is_complete_at_last_of_all", none, none.astype(np.int8), 1)]))
    assert "the_motion.is_complete_at_last_of_all" in texts(shown)
    assert shown.axes[0].get_yticks().tolist() == []


# ------------------------------------------------------------------------------------------------------------- the look
def test_light_and_dark():
    for dark, colours in ((False, LIGHT), (True, DARK)):
        shown = figure(contents(track(), notes=["slope S = 240"]), dark=dark)
        assert shown.get_facecolor()[:3] == to_rgb(colours.ground)
        assert line(shown, "velocity of x").get_color() == colours.series[0]


def luminance(color: str) -> float:
    red, green, blue = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(color))
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


@pytest.mark.parametrize("colours", [LIGHT, DARK])
def test_colours_differ_from_the_ground_and_from_each_other_in_grey(colours):
    ground = luminance(colours.ground)
    for ink, least in [(colours.ink, 7), (colours.soft, 4.5), *((each, 2.7) for each in colours.series)]:
        light, dark = max(luminance(ink), ground), min(luminance(ink), ground)
        assert (light + 0.05) / (dark + 0.05) > least, ink
    greys = sorted(luminance(each) + 0.05 for each in colours.series)
    assert min(b / a for a, b in pairwise(greys)) > 1.2


@pytest.mark.parametrize(("width", "size"), [("page", 9.6), ("phone", 4.2), (7, 7.0)])
def test_widths(width, size):
    assert figure(contents(track()), width=width).get_figwidth() == size
    assert inches(width) == size


def test_the_users_configuration_does_not_matter_and_stays(tmp_path):
    shown = contents(track(motions=[MotionStart(10 * MS, "G", {"R = 80": 900.0})]))
    strange = {
        "axes.facecolor": "red",
        "xtick.labelsize": 40,
        "font.size": 30,
        "axes.grid": False,
        "grid.color": "lime",
    }
    for suffix in ("svg", "png", "pdf"):
        save(figure(shown), tmp_path / f"a.{suffix}", "t", "d")
        with matplotlib.rc_context({**strange, "svg.hashsalt": None, "svg.fonttype": "path"}):
            save(figure(shown), tmp_path / f"b.{suffix}", "t", "d")
            if suffix != "pdf":
                figure(shown).savefig(tmp_path / f"c.{suffix}", dpi=144)  # drawn later: our look, too
            assert matplotlib.rcParams["font.size"] == 30
        assert (tmp_path / f"a.{suffix}").read_bytes() == (tmp_path / f"b.{suffix}").read_bytes()
    from matplotlib.image import imread

    assert (imread(tmp_path / "a.png") == imread(tmp_path / "c.png")).all()
    assert ">R = 80, 900 steps/s<" in (tmp_path / "c.svg").read_text()
    assert (tmp_path / "a.pdf").read_bytes()[:5] == b"%PDF-"


def test_numbers_and_times_of_a_picture():
    assert [number(value) for value in (12345, -0.5, 1000)] == ["12\u2009345", "\u22120.5", "1\u2009000"]
    assert duration(25_000_000) == "25 µs"


@rows(
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


# ---------------------------------------------------------------------------------------------------- files, and errors
def test_an_svg_names_its_content(rig, tmp_path):
    shown = contents(track(motions=[MotionStart(10 * MS, "G")]), traces=traces(rig), stop=200 * MS)
    picture = figure(shown)
    save(picture, tmp_path / "a.svg", "Drilling & more", description_of(picture))
    root = ElementTree.parse(tmp_path / "a.svg").getroot()
    space = "{http://www.w3.org/2000/svg}"
    assert root.get("role") == "img"
    assert root.find(f"{space}title").text == "Drilling & more"
    assert root.find(f"{space}desc").text == (
        "A move, from 0 ps to 200 ms. x: 1 motion, velocity from 0 to 1\u2009000 steps/s, position from 0 to 50 steps. "
        "Pins: slew, db, pulse, programmable_output."
    )
    text = (tmp_path / "a.svg").read_text()
    assert not re.search(r"\d{4}-\d\d-\d\d", text)
    assert ">Velocity, steps/s<" in text


def test_the_callers_axes_are_drawn_into():
    from matplotlib.figure import Figure

    theirs = Figure()
    axes = theirs.subplots(2)
    assert figure(contents(track()), ax=axes) is theirs
    assert [each.get_ylabel() for each in axes] == ["Velocity, steps/s", "Position, steps"]
    assert axes[0].lines[0].get_gid() == "velocity of x"
    alone = Figure().subplots()
    figure(contents(track(), track("y")), ax=alone)
    assert alone.get_legend() is not None
    assert alone.get_ylabel() == "Velocity, steps/s"
    with pytest.raises(UsageError, match="ax: 3 axes; this picture needs 1, or 2 for its panels: Velocity, steps/s"):
        figure(contents(track()), ax=Figure().subplots(3))


@pytest.mark.system
def test_pyplot_is_not_loaded(tmp_path):
    code = (
        "import sys, numpy as np; from slewline.record.pictures.figures import *; "
        "from slewline.record.pictures.picture_files import save; "
        "z = np.array([1, 2, 3]); c = Contents('t', [], [Trace('x', z, z % 2, 0)], 0, 9); "
        f"save(figure(c), {str(tmp_path / 'a.svg')!r}, 't', 'd'); print('matplotlib.pyplot' in sys.modules)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == "False\n"


def test_errors_are_clear_and_leave_nothing(tmp_path, monkeypatch):
    shown = figure(contents(track()))
    for name, message in [
        ("a.gif", "give a name that ends in .svg, .png or .pdf"),
        ("a", "give a name that ends in .svg, .png or .pdf"),
        ("no/a.svg", "there is no directory"),
    ]:
        with pytest.raises(UsageError, match=message):
            save(shown, tmp_path / name, "t", "d")
    for wrong in (contents(track(), stop=0), contents()):
        with pytest.raises(UsageError, match="nothing to draw"):
            figure(wrong)
    for width in ("wide", 2, True, None):
        with pytest.raises(UsageError, match='allowed "page", "phone", or 3 to 40 inches'):
            figure(contents(track()), width=width)
    load = builtins.__import__

    def refuse(name, *rest):
        if name.split(".")[0] == "matplotlib":
            raise ImportError(name)
        return load(name, *rest)

    monkeypatch.setattr(builtins, "__import__", refuse)
    with pytest.raises(UsageError, match="pip install matplotlib"):
        figure(contents(track()))
    assert list(tmp_path.iterdir()) == []


def test_a_line_of_many_points_has_no_gaps():
    count = 4 * panels.PIECE
    at = np.arange(count)
    line = panels.dense_line()(at, 0.5 + 0.25 * (-1.0) ** at, drawstyle="steps-post", color="k", linewidth=0.5)
    shown = Figure(figsize=(50, 0.5), dpi=100)  # five pixels a point
    axes = shown.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set(xlim=(0, count - 1), ylim=(0, 1))
    axes.add_line(line)
    canvas = FigureCanvasAgg(shown)
    canvas.draw()
    ink = np.asarray(canvas.buffer_rgba())[:, :, 0] < 250
    assert ink.any(axis=0).all()


def test_the_grid_of_time_is_the_same_in_all_panels():
    shown = figure(contents(track()))
    for window in ((0, 100), (20, 30)):  # as it is, and zoomed by hand
        shown.axes[-1].set_xlim(*window)
        FigureCanvasAgg(shown).draw()
        ticks = shown.axes[-1].xaxis.get_majorticklocs().tolist()
        grids = [grid for axes in shown.axes[:-1] for grid in axes.collections if isinstance(grid, LineCollection)]
        drawn = [[segment[0][0] for segment in grid.get_segments()] for grid in grids]
        assert ticks in drawn
        assert not any(axes.xaxis.get_visible() for axes in shown.axes[:-1])


def test_a_flag_at_the_end_has_its_text_on_its_left():
    shown = figure(contents(track(marks=[Mark(99 * MS, "finding", "range")])))
    text = next(text for text in shown.axes[0].texts if text.get_text() == "range")
    assert text.get_horizontalalignment() == "right"
    assert text.xy[0] == 99


def test_names_of_rates_have_thin_spaces_in_their_numbers():
    assert rate_lines.rate_text(["VEL = 65536", "R = 80"], 3052.0) == "VEL = 65\u2009536, R = 80, 3\u2009052 steps/s"


@pytest.mark.parametrize(("width", "bands"), [("page", 0), ("phone", 1)])
def test_a_narrow_picture_draws_dense_pulses_as_a_band(width, bands):
    count = np.arange(1, 400)
    pulses = Trace("pulse", count * MS // 4, (count % 2).astype(np.int8), 0)  # four edges a millisecond of 100
    panel = figure(contents(traces=[pulses]), width=width).axes[-1]
    assert len(panel.collections) == bands
