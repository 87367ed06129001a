"""A measured recording over a bench: its pins over the model's, its steps as a run."""

from __future__ import annotations

import numpy as np
import pytest

import slewline
from slewline.errors import NotRecorded, UnknownName, UsageError

COMMANDS = "A 0\rF 10\rR 80\rS 240\rZ 1\rN 600\rG\r"
US, MS = 10**6, 10**9
WAIT = 3 * MS


def run(name: str, wait: int = 0, **options) -> slewline.Bench:
    bench = slewline.Bench()
    host = bench.host(bench.add("cy525", name=name, **options))
    bench.record(f"{name}.pulse", f"{name}.slew", f"{name}.direction", f"{name}.db")
    bench.run(wait)
    host.send(COMMANDS)
    bench.run_until_idle()
    return bench


@pytest.fixture(scope="module")
def model() -> slewline.Bench:
    return run("x")


@pytest.fixture(scope="module")
def measured(tmp_path_factory) -> slewline.Waveforms:
    """The same motion of a chip whose crystal is 0.01 % slow, sampled every 100 ns, 3 ms later."""
    path = tmp_path_factory.mktemp("measured") / "board.vcd"
    run("D", WAIT, crystal=10_998_900).save_vcd(path, timescale="100 ns")
    return slewline.read_vcd(path)


def shift_of(model, measured) -> int:
    return slewline.compare_edges(model.edges("x.pulse"), measured.edges("pulse")).shift_ps


def drawn(axes, gid):
    (found,) = (each for each in (*axes.lines, *axes.collections) if each.get_gid() == gid)
    return found


def late_of(model, measured) -> tuple[np.ndarray, int]:
    """The stretches in which pulse differs, from pairs of edges, and the unit of the file."""
    found = slewline.compare_edges(model.edges("x.pulse"), measured.edges("pulse"))
    assert not len(found.missing) + len(found.extra)
    times = found.model[0]
    pairs = np.sort(np.stack([times, times + found.late_ps], axis=1), axis=1)
    return pairs, measured.timescale_ps


def test_a_measured_pin_is_drawn_over_the_models(model, measured):
    shift = shift_of(model, measured)
    over = {"x.pulse": measured.trace("pulse", shift=shift)}
    begin, end = model.edges("x.pulse")[0][[20, 30]]
    axes = model.figure(pins=["x.pulse"], over=over, start=int(begin) - 5, stop=int(end) + 50 * US).axes[-1]
    both = (
        (axes.lines[0], model.edges("x.pulse")[0]),
        (drawn(axes, "measured pulse"), measured.edges("pulse")[0] + shift),
    )
    for line, times in both:
        seen = line.get_xdata()[1:-1]
        inside = times[(times > begin - 5) & (times <= end + 50 * US)]
        np.testing.assert_allclose(seen, inside / MS, rtol=1e-12)
    pairs, unit = late_of(model, measured)
    differ = pairs[20:31][pairs[20:31, 1] - pairs[20:31, 0] > unit]
    assert len(differ) > 5
    shown = drawn(axes, "where pulse differs").get_paths()
    ticks = [(path.vertices[:, 0].min(), path.vertices[:, 0].max()) for path in shown]
    np.testing.assert_allclose(ticks, differ / MS, rtol=1e-12)


def test_a_pin_that_is_measured_gets_a_lane(model, measured):
    over = {"x.slew": measured.trace("slew")}
    assert drawn(model.figure(pins=[], over=over).axes[-1], "measured slew")
    assert drawn(model.timing_figure(pins=["x.pulse"], over={"slew": over["x.slew"]}).axes[0], "measured x.slew")


def test_all_edges_are_compared_also_where_they_are_a_band(model, measured):
    pairs, _ = late_of(model, measured)
    over = {"x.pulse": measured.trace("pulse", shift=shift_of(model, measured))}
    inside = pairs[pairs[:, 1] < model.now_ps]
    most = (inside[:, 1] - inside[:, 0]).max() / US
    picture = model.figure(pins=["x.pulse"], over=over, start=0, stop=model.now_ps)
    assert f"Measured (dashed): pulse up to {most:.3g} µs late" in [text.get_text() for text in picture.texts]


def test_a_measured_pin_is_drawn_as_far_as_its_file_goes(model, measured):
    slew = measured.trace("slew", shift="-40 ms")
    for pins in ([slew], []):
        axes = model.figure(pins=pins, over={"x.slew": slew} if not pins else None, start=0, stop=model.now_ps).axes[-1]
        line = axes.lines[0] if pins else drawn(axes, "measured slew")
        assert line.get_xdata()[-1] == pytest.approx(measured.stop_ps / MS - 40)
    assert measured.stop_ps - 40 * MS < model.now_ps


def test_a_tolerance_can_be_given(model, measured):
    shift = shift_of(model, measured)
    axes = model.figure(pins=[], over={"x.pulse": measured.trace("pulse", shift=shift, tolerance="1 ms")}).axes[-1]
    assert not [each for each in axes.collections if each.get_gid()]


def test_measured_steps_are_a_run_that_begins_with_the_models(model, measured):
    steps = measured.steps("pulse", "direction")
    first = model["x"].steps().times_ps[0]
    picture = model.figure(pins=[], runs={"measured": steps})
    velocity, position = picture.axes
    line = drawn(velocity, "velocity of measured")
    np.testing.assert_allclose(line.get_xdata()[0], drawn(velocity, "velocity of this run").get_xdata()[1], atol=1e-9)
    np.testing.assert_allclose(np.diff(line.get_xdata()), np.diff(steps.times_ps) / MS, rtol=1e-9)
    np.testing.assert_allclose(line.get_ydata()[:-1], 1e12 / np.diff(steps.times_ps))
    assert np.isnan(line.get_ydata()[-1])
    assert drawn(position, "position of measured").get_ydata().tolist() == [*range(1, 601)]
    assert first > 0


def test_runs_of_benches_and_steps_can_be_mixed(model, measured):
    runs = {"measured": measured.steps("pulse"), "model": model, "again": run("x")}
    lines = {line.get_gid() for line in model.figure(pins=[], runs=runs).axes[0].lines}
    assert {f"velocity of {name}" for name in runs} <= lines


def test_a_longer_measured_motion_is_in_the_window(model, measured):
    steps = measured.steps("pulse")
    late = slewline.core.motion.axis.Steps(steps.times_ps * 5, steps.directions, steps.positions)
    axes = model.figure(pins=[], runs={"measured": late}).axes[0]
    assert drawn(axes, "velocity of measured").get_xdata()[-1] <= axes.get_xlim()[1]
    assert len(drawn(axes, "velocity of measured").get_xdata()) > 100


def test_readings_have_the_measured_values(model, measured):
    shift = shift_of(model, measured)
    at = int(model.edges("x.pulse")[0][40]) + 1  # the measured edge is still to come
    over = {"x.pulse": measured.trace("pulse", shift=shift), "x.db": measured.trace("db", shift=shift)}
    rows = {row.name: row.values for row in model.readings([at, 10], pins=["x.pulse", "x.db"], over=over).rows}
    assert rows["x.pulse"] == (0, 1)
    assert rows["x.pulse measured"] == (1, 1)
    assert rows["x.db measured"] == rows["x.db"] == (None, ord("A"))
    before = model.readings([10], pins=[], over={"x.pulse": measured.trace("pulse")}).rows[-1]
    assert before.values == (None if measured.start_ps > 10 else 1,)


@pytest.mark.parametrize(
    ("over", "says"),
    [
        ({"x.pulse": "pulse"}, "over: 'x.pulse': found 'pulse'; expected a trace"),
        ([1], r"over=\[1\]: expected pins and traces"),
        ({"x.db": "slew"}, "over: 'x.db' is a bus, but the trace 'slew' is one pin"),
    ],
)
def test_incompatible_runs_cannot_be_overlaid(model, measured, over, says):
    if isinstance(over, dict) and "x.db" in over:
        over = {"x.db": measured.trace("slew")}
    for draw in (model.figure, model.timing_figure):
        with pytest.raises(UsageError, match=says):
            draw(over=over)


def test_over_a_pin_that_is_not_recorded(model, measured):
    for draw in (model.figure, model.timing_figure):
        with pytest.raises(NotRecorded, match=r"x\.run is not recorded"):
            draw(over={"x.run": measured.trace("slew")})


def test_a_run_that_is_neither_a_bench_nor_steps(model):
    with pytest.raises(UsageError, match="runs: 'a': expected a bench, or steps"):
        model.figure(runs={"a": 3})


# ------------------------------------------------------------------- every entry that takes pins, and what may be one
def entries(model, path) -> dict:
    """Calls that take pins: those that draw also take a measured trace, those that write do not."""
    at = model.now_ps // 2
    return {
        "plot": lambda pins, **more: model.plot(path / "a.svg", pins=pins, **more),
        "figure": lambda pins, **more: model.figure(pins=pins, **more),
        "timing": lambda pins, **more: model.timing(path / "a.svg", pins=pins, stop="12 ms", **more),
        "timing_figure": lambda pins, **more: model.timing_figure(pins=pins, stop="12 ms", **more),
        "readings": lambda pins, **more: model.readings([at], pins=pins, **more),
        "save_vcd": lambda pins: model.save_vcd(path / "a.vcd", pins=pins),
        "save_csv": lambda pins: model.save_csv(path / "a.csv", pins=pins),
        "save_npz": lambda pins: model.save_npz(path / "a.npz", pins=pins),
        "stream_vcd": lambda pins: model.stream_vcd(path / "b.vcd", pins=pins),
    }


WRITES = ("save_vcd", "save_csv", "save_npz", "stream_vcd")


def test_every_entry_takes_what_it_documents(model, measured, subtests, tmp_path):
    pulse, bus = measured.trace("pulse", shift="-3 ms"), measured.trace("db", shift="-3 ms")
    given = {
        "name": ((["x.pulse"],), {}),
        "trace": ((["x.pulse", pulse],), {}),
        "trace first": (([pulse, "x.pulse"],), {}),
        "trace alone": (([pulse],), {}),
        "trace of a bus": ((["x.db", bus],), {}),
        "over": ((["x.pulse"],), {"over": {"x.pulse": pulse}}),
        "over and beside": ((["x.pulse", pulse],), {"over": {"x.pulse": pulse, "x.db": bus}}),
    }
    for entry, call in entries(model, tmp_path).items():
        for what, (arguments, more) in given.items():
            with subtests.test(entry=entry, what=what):
                if entry not in WRITES:
                    call(*arguments, **more)
                elif more:
                    with pytest.raises(TypeError, match="over"):
                        call(*arguments, **more)
                elif what == "name":
                    call(*arguments)
                else:
                    with pytest.raises(UnknownName, match=r"<Trace .*>: expected the name of a recorded pin"):
                        call(*arguments)


def test_a_trace_in_a_timing_diagram_is_the_measurement(model, measured):
    shift = shift_of(model, measured)
    pulse = measured.trace("pulse", shift=shift)
    begin, end = (int(at) for at in model.edges("x.pulse")[0][[20, 30]])
    axes = model.timing_figure(pins=["x.pulse", pulse], start=begin - 5, stop=end + 5).axes[0]
    assert {"/PULSE", "pulse"} <= {text.get_text() for text in axes.texts}
    at = int(model.edges("x.pulse")[0][20]) + 1
    rows = {row.name: row.values for row in model.readings([at], pins=["x.pulse", pulse]).rows}
    assert rows["pulse measured"] == (1,) and rows["x.pulse"] == (0,)


def test_a_trace_floats_where_its_file_has_nothing(model, measured):
    slew = measured.trace("slew", shift="-40 ms")
    lane = slewline.record.measuring.intervals.SignalEdges.of_trace(slew, 0, model.now_ps)
    end = measured.stop_ps - 40 * MS
    assert (lane.times_ps[-1], lane.levels[-1]) == (end + 1, -1) and end < model.now_ps
    late = slewline.record.measuring.intervals.SignalEdges.of_trace(measured.trace("slew", shift="1 ms"), 0, 5 * MS)
    assert (late.level, late.times_ps[0], late.levels[0]) == (-1, MS, 1)
