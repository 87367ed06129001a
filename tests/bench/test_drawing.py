"""Pictures of a bench: the lines are what the axes did; the window, the axes and the runs that are asked for."""

from __future__ import annotations

import contextlib
import re
import runpy
from inspect import Parameter, signature
from pathlib import Path

import numpy as np
import pytest

import slewline
from slewline.bench.pictures.picture_options import DIAGRAM, PICTURE, DiagramOptions, Picture
from slewline.bench.pictures.track_notes import differences
from slewline.cli.main import invoke
from slewline.core.chip import Chip
from slewline.core.motion.deviation import Deviation
from slewline.errors import NotRecorded, UnknownName
from slewline.record.pictures.tracks import Track
from slewline.record.recording.traces import Trace
from tests.ensembles import few, in_long_runs
from tests.rows import rows

MS = 10**9
ROOT = Path(__file__).parents[2]
SCRIPTS = sorted((ROOT / "examples").glob("*.py"))
PROGRAMS = [
    *sorted((ROOT / "examples" / "programs").glob("*.[cg][ys]*")),
    *sorted((ROOT / "examples" / "drill").glob("*.toml")),
    *sorted((ROOT / "examples" / "mc1451a").glob("[!s]*.mc1451a")),
    ROOT / "examples" / "mc1451a" / "stall_recovery.toml",
]
PINS = ("x.slew", "x.motion_complete")


def move(*commands, slope=240, pins=PINS) -> slewline.Bench:
    bench = slewline.Bench()
    host = bench.host(bench.add("cy525", name="x"))
    if pins:
        bench.record(*pins)
    text = f"A 0 | F 10 | R 80 | S {slope} | Z 1 | N 400 | " + " | ".join(commands or ["G"])
    host.send("".join(f"{command.strip()}\r" for command in text.split("|")))
    bench.run_until_idle()
    return bench


def chipset(**moves) -> slewline.Bench:
    """A chip set whose axes go to positions: axis1=500."""
    bench = slewline.Bench()
    host = bench.host(bench.add("mc1451a", name="m"))
    for name, position in moves.items():
        axis = host.axis(int(name[-1]))
        axis.command("SET_VEL", 131072)
        axis.command("SET_ACC", 400)
        axis.command("SET_POS", position)
    host.command("MULTI_UPDATE", 15)
    bench.run_until_idle()
    return bench


def lines(figure) -> dict[str, object]:
    return {line.get_gid(): line for axes in figure.axes for line in axes.lines if line.get_gid()}


def headings(figure) -> list[str]:
    return [axes.get_title(loc="left") for axes in figure.axes]


def words(figure) -> set[str]:
    found = {text.get_text() for text in figure.texts}
    return found | {text.get_text() for axes in figure.axes for text in axes.texts}


def unit_of(figure) -> float:
    label = figure.axes[-1].get_xlabel().split(",")[0].removeprefix("Time in ")
    return {"s": 1e12, "ms": 1e9, "µs": 1e6, "ns": 1e3, "ps": 1}[label]


def drawn_at(line, times, unit) -> np.ndarray:
    """What a line shows at instants: the value of the last point at or before each."""
    at = np.searchsorted(line.get_xdata(), times / unit, side="right") - 1
    return line.get_ydata()[at]


# ------------------------------------------------------------------------------------------------------------ the truth
def check_truth(bench, instants=1000) -> int:
    """Every line is what its axis says at instants in the window; returns how many lines there were."""
    picture = bench.figure(pins=[], start=0)
    unit, drawn = unit_of(picture), lines(picture)
    whole = np.linspace(0, bench.now_ps, instants).astype(np.int64)
    for _, _, axis in bench._circuit.axes():
        for quantity in axis.quantities():
            line = drawn.get(f"{quantity.name} of {bench._pictures.name_of(axis)}")
            if line is None:
                assert not axis.motor.count(0, bench.now_ps)
                continue
            seen, exact = drawn_at(line, whole, unit), quantity.at(whole)
            if not quantity.is_staircase:  # straight from point to point
                seen = np.interp(whole / unit, line.get_xdata(), line.get_ydata())
                np.testing.assert_allclose(seen, exact, rtol=1e-9, atol=1e-6)
            elif len(quantity.changes(0, bench.now_ps).times_ps) <= len(line.get_xdata()):
                np.testing.assert_array_equal(seen, exact)
            else:  # thinned: in each column, the line goes from the lowest to the highest value
                column = bench.now_ps / 800 / unit
                first = np.searchsorted(line.get_xdata(), whole / unit - column, side="right") - 1
                last = np.searchsorted(line.get_xdata(), whole / unit + column, side="right")
                near = [line.get_ydata()[max(a, 0) : b + 1] for a, b in zip(first, last, strict=True)]
                assert all(np.nanmin(y) <= value <= np.nanmax(y) for y, value in zip(near, exact, strict=True))
            edges = (line.get_xdata() * unit).round().astype(np.int64)
            kept = ~np.isnan(line.get_ydata()) & np.append(
                edges[1:] != edges[:-1], True
            )  # where it jumps, the new value
            np.testing.assert_array_equal(line.get_ydata()[kept], quantity.at(edges[kept]))
            if quantity.name == "position":
                np.testing.assert_array_equal(axis.position_at(edges[kept]), line.get_ydata()[kept])
    return len(drawn)


@pytest.fixture
def made(monkeypatch, tmp_path) -> list[slewline.Bench]:
    """The benches that are made from now on."""
    monkeypatch.chdir(tmp_path)
    found: list[slewline.Bench] = []
    build = slewline.Bench.__init__

    def remember(self, *arguments, **options):
        build(self, *arguments, **options)
        found.append(self)

    monkeypatch.setattr(slewline.Bench, "__init__", remember)
    return found


@pytest.mark.parametrize("script", few(SCRIPTS, 6), ids=lambda path: path.stem)
def test_the_lines_of_every_example_agree_with_its_axes(script, capsys, made):
    runpy.run_path(str(script), run_name="__main__")
    moved = any(len(axis.steps()) for bench in made for *_, axis in bench._circuit.axes())
    assert sum(check_truth(bench) for bench in made if bench.chips and bench.now_ps) >= 1 + moved


@pytest.mark.long
@pytest.mark.parametrize("file", PROGRAMS, ids=lambda path: path.name)
def test_the_lines_of_every_program_and_bench_file_agree_with_its_axes(file, capsys, made):
    with contextlib.suppress(SystemExit):
        invoke(["run", str(file), "--quiet", "--until", "5 s"])
    (bench,) = made
    assert bench.now_ps == 5 * 10**12
    assert check_truth(bench)


def test_a_rest_is_drawn_as_zero_and_a_load_as_a_break():
    bench = move("G", "A 5000", "-", "G")
    position, velocity = (lines(bench.figure(pins=[]))[f"{name} of x"] for name in ("position", "velocity"))
    (broken,) = np.flatnonzero(np.isnan(position.get_ydata()))
    assert position.get_ydata()[[broken - 1, broken + 1]].tolist() == [400, 5000]
    rests = velocity.get_ydata() == 0
    assert rests.sum() >= 2
    assert velocity.get_ydata()[-1] == 0
    assert velocity.get_ydata().min() < 0 < velocity.get_ydata().max()


# ----------------------------------------------------------------------------------------------------------- the window
def test_the_window_is_the_motion_and_a_twentieth_around_it():
    bench = move()
    bench.run("2 s")
    steps = bench["x"].steps().times_ps
    shown = lines(bench.figure(pins=[]))["velocity of x"].get_xdata()
    around = (steps[-1] - steps[0]) / MS / 20
    assert steps[0] / MS - around <= shown[0] < steps[0] / MS
    assert steps[-1] / MS + 0.9 * around < shown[-1] < steps[-1] / MS + 1.2 * around
    everything = lines(bench.figure(pins=[], start=0, stop=bench.now_ps))["velocity of x"].get_xdata()
    assert everything[0] == 0
    assert everything[-1] == bench.now_ps / unit_of(bench.figure(pins=[], start=0, stop=bench.now_ps))


def test_the_value_of_a_register_before_a_load_is_not_in_the_window():
    position = lines(move().figure(pins=[]))["position of x"].get_ydata()
    assert (position[0], position.max()) == (0, 400)


def test_without_a_motion_the_window_spans_the_activity_of_the_pins():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.record("x.wait")
    bench.run("100 ms")
    x.pin("wait").pulse(1 - x.pin("wait").level, "2 ms")
    bench.run("500 ms")
    picture = bench.figure(start=None)
    assert picture.axes[-1].get_xlabel() == "Time in ms, from 99.9 ms on"
    assert 2 < picture.axes[-1].get_xlim()[1] < 3
    assert "no motion" in words(picture)


def test_a_bench_at_time_0_and_a_window_of_no_length_are_refused():
    bench = slewline.Bench()
    with pytest.raises(UnknownName, match="no chip"):
        bench.figure()
    bench.add("cy525")
    with pytest.raises(slewline.UsageError, match=r"nothing to draw from 0 ps to 0 ps; call bench.run\(\) first"):
        bench.figure()
    bench.run("1 ms")
    with pytest.raises(slewline.UsageError, match="start 900 µs, stop 100 µs: give a stop after the start"):
        bench.figure(start="900 us", stop="100 us")
    assert headings(bench.figure()) == ["Velocity, steps/s"]  # a position that never moves is no news


# ------------------------------------------------------------------------------------------------------------- the axes
def test_axes_share_panels_and_idle_axes_are_left_out():
    bench = chipset(axis1=500, axis3=-700)
    assert headings(bench.figure()) == ["Velocity, steps/s", "Position, steps", "Acceleration, steps/s²"]
    chosen = [
        (None, {1, 3}),
        (3, {3}),
        ([1, 3], {1, 3}),
        ("m axis 2", {2}),
        ("m", {1, 2, 3, 4}),
        ([1, "m axis 1"], {1}),
    ]
    for axes, shown in chosen:
        picture = bench.figure(axes=axes)
        found = {name for name in lines(picture) if name.startswith("velocity")}
        assert found == {f"velocity of axis {number}" for number in shown}
        assert ("axis 1" in words(picture)) == (1 in shown and len(shown) > 1)  # a single one needs no legend
    for unknown in (5, True, "m axis 5"):
        with pytest.raises(UnknownName, match=f"no axis {unknown!r}; allowed m axis 1, m axis 2"):
            bench.figure(axes=[1, unknown])


def test_runs_are_overlaid_from_the_start_of_their_motion():
    slow, fast = move(slope=200), move(slope=250)
    fast.run("1 s")
    picture = slow.figure(pins=[], runs={"S = 200": slow, "S = 250": fast})
    drawn = lines(picture)
    assert set(drawn) == {f"{what} of S = {slope}" for what in ("velocity", "position") for slope in (200, 250)}
    for slope in (200, 250):
        velocity = drawn[f"velocity of S = {slope}"]
        assert velocity.get_xdata()[np.flatnonzero(velocity.get_ydata())[0]] == 0
    assert picture.axes[-1].get_xlabel() == "Time in ms, from the start of the motion"
    assert "velocity of this run" in lines(slow.figure(pins=[], runs={"S = 250": fast}))


@pytest.mark.parametrize("window", [{"start": "300 ms"}, {"stop": "400 us"}])
def test_a_window_next_to_the_motion_extends_to_the_end_of_the_run(window):
    bench = move()
    bench.run("400 ms")
    shown = bench.figure(pins=[], **window).axes[-1].lines[0].get_xdata()
    first, last = shown[[0, -1]] * (1 if "start" in window else 1e-3)
    assert (first, last) == ((300, bench.now_ps / MS) if "start" in window else (0, 0.4))


# ------------------------------------------------------------------------------------------------------ pins, and words
def test_pins_are_named_without_their_chip_if_there_is_but_one(tmp_path):
    bench = move()
    panel = bench.figure().axes[-1]
    assert [label.get_text().replace("\n", "") for label in panel.get_yticklabels()] == ["slew", "motion_complete"]
    times = np.array([10 * MS, 20 * MS])
    measured = Trace("measured", times, np.array([1, 0], np.int8), 0)
    panel = bench.figure(pins=["x.slew", measured]).axes[-1]
    assert [label.get_text() for label in panel.get_yticklabels()] == ["slew", "measured"]
    with pytest.raises(NotRecorded, match=r"x\.pulse is not recorded"):
        bench.figure(pins=["x.pulse"])


def lane(panel):
    """The ends of the line of the first lane, in ms, and how many of its points are edges."""
    (drawn,) = (line for line in panel.lines if line.get_drawstyle() == "steps-post")
    first, last = drawn.get_xdata()[[0, -1]]
    return round(first, 2), round(last, 2), len(drawn.get_xdata()) - 2


def test_a_pin_is_drawn_only_where_it_is_known():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.run("10 ms")
    bench.record("x.motion_complete")
    bench.host(x).send("A 0\rF 10\rR 80\rS 240\rZ 1\rN 400\rG\r")
    bench.run("290 ms")
    assert lane(bench.figure(pins=["x.motion_complete"], start=0, stop="300 ms").axes[-1]) == (10, 300, 1)
    assert bench.figure(pins=["x.motion_complete"], start=0, stop="5 ms").axes[-1].lines[:] == []
    longer = move("N 2000", "G", pins=[])
    shown = bench.figure(pins=["x.motion_complete"], runs={"short": bench, "long": longer}).axes[-1]
    first, last, edges = lane(shown)
    assert first < 0 < last < 300 < 350 < shown.get_xlim()[1] and edges == 1


def test_a_trace_of_a_file_is_drawn_within_the_window():
    times = np.array([1 * MS, 20 * MS, 30 * MS, 50 * MS])
    measured = Trace("measured", times, np.array([1, 0, 1, 0], np.int8), 0)
    panel = move().figure(pins=[measured], start="10 ms", stop="40 ms").axes[-1]
    drawn = np.concatenate([line.get_xdata() for line in panel.lines if len(line.get_xdata()) > 2])
    assert drawn.min() == 10 and drawn.max() == 40 and {20, 30} <= set(drawn.tolist())
    assert measured.within(10 * MS, 40 * MS).level == 1 and measured.within(0, 10 * MS).level == 0


def test_rates_parameters_commands_and_findings_are_reported():
    picture = move("G", "R 60", "-", "G").figure()
    told = words(picture)
    assert {
        "R = 80 (rate), 5\u2009978 steps/s",
        "F = 10 (firstrate), 1\u2009000 steps/s",
        "slope S = 240, divisor Z = 1, number N = 400",
    } <= told
    assert "G" in told
    assert "G" not in words(move().figure(marks=False))
    in_progress = move().figure(start="30 ms", stop="40 ms")
    assert "R = 80 (rate), 5\u2009978 steps/s" in words(in_progress)  # its motion has begun before
    picture = move("N 100", "G", "N 200", "G", "N 300", "G", "N 350", "G").figure()
    assert any("number N = 100, 200, 300 …" in text for text in words(picture))


@pytest.mark.parametrize("suffix", ["svg", "png", in_long_runs("pdf")])  # whose fonts take long
def test_the_same_run_gives_the_same_bytes(suffix, tmp_path):
    for name in "ab":
        move().plot(tmp_path / f"{name}.{suffix}", "One move", ["x.slew"], 0, "80 ms")
    assert (tmp_path / f"a.{suffix}").read_bytes() == (tmp_path / f"b.{suffix}").read_bytes()


def test_an_svg_describes_its_content(tmp_path):
    move().plot(tmp_path / "a.svg", dark=True, width="phone", cursors=["20 ms"])
    text = (tmp_path / "a.svg").read_text()
    assert "<title>CY525</title>" in text
    assert "x: 1 motion, velocity from 0 to 5\u2009929.92 steps/s, position from 0 to 400 steps. Pins: slew," in text


def test_an_unknown_suffix_is_refused_before_anything_is_drawn(tmp_path, monkeypatch):
    bench = move()
    monkeypatch.setattr(Chip, "quantities", None)
    with pytest.raises(slewline.UsageError, match=r"ends in \.svg, \.png or \.pdf"):
        bench.plot(tmp_path / "a.gif")


# ------------------------------------------------------------------------------------------------------------- readings
def test_readings_are_the_values_at_cursors_and_between_them(tmp_path):
    bench = move(pins=("x.slew", "x.db"))
    found = bench.readings(["20 ms", "50 ms", "60 ms"])
    rows = {row.name: row for row in found.rows}
    assert rows["position"].values == tuple(bench["x"].position_at(["20 ms", "50 ms", "60 ms"]))
    assert rows["velocity"].values == tuple(bench["x"].velocity_at(["20 ms", "50 ms", "60 ms"]))
    first, second, third = rows["position"].values
    assert rows["position"].differences == (second - first, third - second)
    assert rows["x.slew"].values == (1, 1, 1)
    assert rows["x.slew"].differences == rows["x.db"].differences == (None, None)
    assert rows["x.db"].bits == 8
    lines = str(found).splitlines()
    assert lines[0].split() == ["1", "2", "3", "2", "−", "1", "3", "−", "2"]
    assert lines[1].split()[:3] == ["time", "20", "ms"]
    assert lines[2].startswith("velocity, steps/s ")
    assert "floating" in lines[-1]
    assert len({len(line) for line in lines[:3]}) == 1
    for late in (["20 s"], "20 s", 20 * 10**12, (time for time in ["1 ms", "20 s"])):
        with pytest.raises(slewline.UsageError, match=r"^20 s is in the future"):
            bench.readings(late)
    with pytest.raises(slewline.UsageError, match="no instant"):
        bench.readings([])


def test_the_greatest_distance_from_the_ideals_is_given_in_numbers_and_words_that_agree():
    def says(*positions):
        ideals = [(None, Deviation(position, 0, 150.0, 0)) for position in positions]
        return [*differences([Track("x", [], ideals=ideals)])]

    assert says(0.5, -0.999) == ["Dotted: the ideal; position within 0.999 steps, velocity within 150 steps/s"]
    assert says(-0.9999, 0.5) == ["Dotted: the ideal; position within 1 step, velocity within 150 steps/s"]
    assert says() == []


@rows("instants", ["20 ms", 20 * MS, ["20 ms"], np.array([20 * MS]), [500, "20 ms"]])
def test_cursors_and_readings_take_the_same_instants(instants):
    bench = move()
    assert bench.readings(instants).instants_ps[-1] == 20 * MS
    drawn = bench._pictures.contents(PICTURE | {"pins": [], "start": 0, "cursors": instants}).cursors
    assert tuple(drawn) == bench.readings(instants).instants_ps


def test_readings_name_their_axis_where_there_are_several():
    rows = chipset(axis1=500).readings("5 ms", axes=[1, 2]).rows
    assert {"velocity of axis 1", "position of axis 2"} <= {row.name for row in rows}


# --------------------------------------------------------------------------------------------------------- options
_WINDOW = ["pins", "start", "stop"]
_PICTURE = ["title", *_WINDOW, "axes", "parts", "runs", "over", "ideal", "cursors", "dark", "width", "marks"]
_DIAGRAM = [*_WINDOW, "between", "causes", "title", "over", "names", "decode", "quiet", "width", "dark"]
NAMES = {  # of what each call takes
    "figure": [*_PICTURE, "ax"],
    "plot": ["path", *_PICTURE],
    "timing": ["path", *_DIAGRAM],
    "timing_figure": _DIAGRAM,
}


@rows("call", [*NAMES])
def test_an_unknown_option_is_refused_with_the_known_ones_and_the_name_of_the_call(call):
    says = f"{call}(): got an unexpected keyword argument 'widht'; its arguments: {', '.join(NAMES[call])}"
    with pytest.raises(slewline.UsageError, match=f"^{re.escape(says)}.*; did you mean width\\?$"):
        getattr(move(), call)(*(["x.svg"] if NAMES[call][0] == "path" else []), widht=3)


@rows("call", [*NAMES])
def test_signatures_have_each_option_with_its_type_and_default(call):
    found = signature(getattr(slewline.Bench, call)).parameters
    assert [*found] == ["self", *NAMES[call]]
    assert {one.kind for one in found.values()} == {Parameter.POSITIONAL_OR_KEYWORD, Parameter.KEYWORD_ONLY}
    assert (found["width"].default, found["dark"].default, found["dark"].annotation) == ("page", False, "bool")
    assert found["over"].annotation == "Mapping[str, Trace] | None"


def test_every_option_has_a_default_and_no_other_has():
    assert PICTURE.keys() == Picture.__annotations__.keys()
    assert DIAGRAM.keys() == DiagramOptions.__annotations__.keys()
