"""What was measured, over the model's: where pins differ, what is drawn of it, and what measured steps tell."""

from __future__ import annotations

import numpy as np
import pytest

from slewline.core.motion.axis import Steps
from slewline.errors import UsageError
from slewline.record.measuring.intervals import SignalEdges
from slewline.record.measuring.overlay import differences, differing, fitting, marked
from slewline.record.pictures.diagram import Diagram, Lane
from slewline.record.pictures.figures import Contents, description_of, figure
from slewline.record.pictures.measured import position, track, velocity
from slewline.record.pictures.timing_diagram import draw
from slewline.record.recording.traces import Trace
from slewline.record.style import LIGHT
from tests.rows import rows

US, MS = 10**6, 10**9


def trace(*times, name="a", level=1, levels=None, **more) -> Trace:
    levels = [(level + n + 1) % 2 for n in range(len(times))] if levels is None else levels
    return Trace(name, np.array(times, np.int64), np.array(levels, np.int16), level, **more)


def stretches(model, measured, start=0, stop=100) -> list[list[int]]:
    return differing(model, measured, start, stop).tolist()


def steps(*times, directions=None, position=0) -> Steps:
    ways = np.ones(len(times), np.int8) if directions is None else np.array(directions, np.int8)
    return Steps(np.array(times, np.int64), ways, position + np.cumsum(ways, dtype=np.int64))


# --------------------------------------------------------------------------------------------------- where they differ
@rows(
    ("measured", "found"),
    [
        (trace(20, 40, 60, 80), []),
        (trace(22, 39, 60, 80), [[20, 22], [39, 40]]),  # late, early
        (trace(20, 40), [[60, 80]]),  # a missing pulse
        (trace(20, 40, 50, 53, 60, 80), [[50, 53]]),  # an extra one
        (trace(20, 40, 60, 80, level=0), [[0, 100]]),
        (trace(20, 40, 70, 80, since=65), [[65, 70]]),
        (trace(22, 40, 60, until=85), [[20, 22], [80, 85]]),
        (trace(30, since=70, until=65), []),
        (trace(20, 30, 50, 60, 80, levels=[0, -1, 1, 0, 1]), []),  # who floats is not compared
        (trace(-5, 10, 40, 60, 80, levels=[0, 1, 1, 0, 1]), [[0, 10], [20, 40]]),
    ],
)
def test_stretches_are_exact(measured, found):
    assert stretches(trace(20, 40, 60, 80), measured) == found


def test_a_floating_level_of_the_model_can_be_measured_as_either_level():
    assert stretches(trace(50, levels=[-1]), trace(30, 60)) == [[30, 50]]


def test_values_of_a_bus_differ():
    model = trace(10, 50, levels=[0x4A, 0x0D], bus=True)
    assert stretches(model, trace(10, 50, levels=[0x4B, 0x0D], bus=True)) == [[10, 50]]


def test_up_to_the_tolerance_nothing_is_marked():
    measured = trace(22, 43, tolerance_ps=2)
    assert marked(trace(20, 40), measured, 0, 100).tolist() == [[40, 43]]
    assert marked(trace(20, 40), trace(22, 43), 0, 100).tolist() == [[20, 22], [40, 43]]


def test_a_shift_moves_all_of_a_trace():
    moved = trace(20, 40, since=5, until=90, over=trace(21)).shifted(-5)
    assert (moved.since, moved.until, moved.times_ps.tolist()) == (0, 85, [15, 35])
    assert moved.over.times_ps.tolist() == [16]


@rows(
    ("measured", "says"),
    [
        (trace(20 * US, 42 * US + 345678, 60 * US), "up to 2.35 µs late"),
        (trace(19 * US, 40 * US, 60 * US), "up to 1 µs early"),
        (trace(20 * US + 512, 40 * US, 60 * US, tolerance_ps=US), "within 512 ps"),
        (trace(20 * US, 40 * US, 60 * US), "agrees"),
        (trace(20 * US, 60 * US, levels=[0, 0]), "agrees, 1 edge missing"),
        (trace(20 * US, 21 * US, 22 * US, 40 * US, 60 * US), "agrees, 2 edges extra"),
        (trace(), "3 edges missing"),
        (trace(20, since=2 * MS), "covers none of this window"),
        (trace(20 * US, 40 * US, until=50 * US), "agrees"),  # an edge behind what is known is not missing
    ],
)
def test_the_greatest_difference_is_reported(measured, says):
    model = trace(20 * US, 40 * US, 60 * US)
    assert differences([("a", model, measured), ("b", model, None)], 0, MS) == [f"Measured (dashed): a {says}"]


def test_pins_without_edges_and_pins_without_overlay():
    said = differences([("a", trace(), trace(level=0)), ("b", trace(), trace())], 0, MS)
    assert said == ["Measured (dashed): a differs; b agrees"]
    assert differences([("a", trace(5), None)], 0, MS) == []


def test_a_bus_is_not_overlaid_on_a_pin():
    with pytest.raises(UsageError, match=r"over: 'x.db' is a bus, but the trace 'slew' is one pin"):
        fitting("x.db", True, trace(name="slew"))


# --------------------------------------------------------------------------------------------------------------- lanes
def drawn(axes, gid):
    (found,) = (line for line in (*axes.lines, *axes.collections) if line.get_gid() == gid)
    return found


def across(collection) -> list[tuple[float, float]]:
    return [(path.vertices[:, 0].min(), path.vertices[:, 0].max()) for path in collection.get_paths()]


def lanes(**more):
    measured = trace(22 * US, 80 * US, name="measured", since=5 * US, until=90 * US, **more)
    return figure(Contents("t", [], [trace(20 * US, 80 * US, name="slew", over=measured)], 0, 100 * US))


def test_a_lane_shows_both_and_where_they_differ():
    picture = lanes()
    (axes,) = picture.axes
    model, measured = axes.lines[0], drawn(axes, "measured measured")
    assert model.get_xdata().tolist() == [0, 20, 80, 100]
    assert measured.get_xdata().tolist() == [5, 22, 80, 90]  # as far as it is known
    assert set(model.get_ydata()) == set(measured.get_ydata())
    assert (measured.get_color(), measured.get_linestyle()) == (LIGHT.measured, "--")
    assert across(drawn(axes, "where slew differs")) == [(20, 22)]
    assert "Measured (dashed): slew up to 2 µs late" in [text.get_text() for text in picture.texts]
    assert "slew up to 2 µs late." in description_of(picture)


def test_agreement_has_no_ticks():
    assert not [each for each in lanes(tolerance_ps=2 * US).axes[0].collections if each.get_gid()]


def test_ticks_that_no_eye_can_tell_apart_are_one():
    times = np.arange(0, 100 * US, US // 100)
    late = trace(*(times + US // 500))
    picture = figure(Contents("t", [], [trace(*times, over=late)], 0, 100 * US))
    assert len(across(drawn(picture.axes[0], "where a differs"))) == 1


def test_a_measured_bus_is_an_outline_without_values():
    over = trace(10, 60, name="db", levels=[0x4B, 0x0D], bus=True)
    bus = trace(10, 50, name="db", levels=[0x4A, 0x0D], bus=True, over=over)
    (axes,) = figure(Contents("t", [], [bus], 0, 100)).axes
    words = [text.get_text() for text in axes.texts]
    assert {"4A", "0D"} <= set(words)
    assert "4B" not in words
    assert across(drawn(axes, "where db differs")) == [(10, 60)]


# ----------------------------------------------------------------------------------------------------- timing diagrams
def diagram(model, measured, **more):
    signal = SignalEdges(model.times_ps, model.levels, model.level, model.bus)
    return Diagram("t", 0, 100, [Lane("x.a", "A", signal, over=measured, **more)])


def test_a_timing_diagram_shows_both_and_where_they_differ():
    shown = diagram(trace(20, 80), trace(30, 80, since=10))
    (axes,) = draw(shown).axes
    begin, end = axes.lines[0].get_xdata()[[0, -1]]
    place = lambda at: begin + 0.08 + (end - begin - 0.16) * at / 100  # noqa: E731
    measured = drawn(axes, "measured x.a").get_xdata()
    assert measured[0] == pytest.approx(place(10))
    assert measured[-1] == pytest.approx(end)
    assert (measured[1] + measured[2]) / 2 == pytest.approx(place(30))
    assert across(drawn(axes, "where x.a differs")) == [pytest.approx((place(20), place(30)))]
    assert "Measured (dashed): A up to 10 ps late" in [text.get_text() for text in axes.texts]
    assert shown.description.endswith("Measured (dashed): A up to 10 ps late.")


def test_notes_make_a_timing_diagram_higher_and_move_no_lane():
    with_notes, without = (draw(diagram(trace(20, 80), over)) for over in (trace(30, 80), None))
    assert with_notes.get_figheight() == pytest.approx(without.get_figheight() + 0.17)
    assert with_notes.axes[0].lines[0].get_ydata().tolist() == without.axes[0].lines[0].get_ydata().tolist()


def test_a_measured_bus_in_a_timing_diagram():
    model = trace(20, 80, level=-1, levels=[0x41, -1], bus=True)
    (axes,) = draw(diagram(model, trace(20, 70, level=-1, levels=[0x41, 0x43], bus=True))).axes
    assert len([line for line in axes.lines if line.get_gid() == "measured x.a"]) == 3
    assert len(across(drawn(axes, "where x.a differs"))) == 1


# --------------------------------------------------------------------------------------------------------------- steps
def test_velocity_of_measured_steps_is_one_by_their_interval():
    found = velocity(steps(10 * MS, 12 * MS, 13 * MS, 15 * MS))
    at = np.array([9, 10, 11, 12, 13, 14, 15, 16]) * MS
    np.testing.assert_array_equal(found.at(at), [np.nan, 500, 500, 1000, 500, 500, np.nan, np.nan])


def test_a_turn_and_a_long_interval_are_rests():
    turned = velocity(steps(0, MS, 2 * MS, 3 * MS, directions=[1, 1, -1, -1]))
    np.testing.assert_array_equal(turned.values, [1000, 0, -1000, np.nan])
    rested = velocity(steps(0, MS, 12 * MS, 13 * MS, 23 * MS, 24 * MS))
    np.testing.assert_array_equal(rested.values, [1000, 0, 1000, 100, 1000, np.nan])
    np.testing.assert_array_equal(velocity(steps(0, MS, 13 * MS)).values, [1000, 0, np.nan])
    np.testing.assert_array_equal(velocity(steps(0, 50 * MS)).values, [20, np.nan])
    np.testing.assert_array_equal(velocity(steps(7)).values, [np.nan])


def test_position_of_measured_steps_is_counted():
    found = position(steps(10, 20, 30, directions=[1, 1, -1], position=5))
    np.testing.assert_array_equal(found.at(np.array([9, 10, 25, 40])), [np.nan, 6, 7, 6])


def test_changes_begin_with_the_window():
    times, values = position(steps(10, 20, 30)).changes(15, 30)
    assert (times.tolist(), values.tolist()) == ([15, 20, 30], [1, 2, 3])


def test_a_track_of_measured_steps_is_drawn_from_its_first_to_its_last_step():
    run = track("measured", steps(10 * MS, 12 * MS, 13 * MS), MS)
    model = track("model", steps(MS, 2 * MS, 5 * MS), MS)
    picture = figure(Contents("t", [model, run], [], 0, 10 * MS))
    speeds, places = drawn(picture.axes[0], "velocity of measured"), drawn(picture.axes[1], "position of measured")
    assert speeds.get_xdata().tolist() == [1, 3, 4]
    np.testing.assert_array_equal(speeds.get_ydata(), [500, 1000, np.nan])
    assert list(zip(places.get_xdata(), places.get_ydata(), strict=True)) == [(1, 1), (3, 2), (4, 3)]


@pytest.mark.parametrize("times", [(), (5, 5)])
def test_steps_that_are_none_are_refused(times):
    with pytest.raises(UsageError, match="runs: 'measured' has"):
        track("measured", steps(*times), 0)
