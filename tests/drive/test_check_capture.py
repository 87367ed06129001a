"""Recordings of STEP and DIR against the data sheets of drivers and parts: what is wrong is named, with its instant."""

from __future__ import annotations

import pytest

import slewline
from slewline import check_capture
from slewline.drive.step_drivers import STEP_DRIVERS, StepDriver
from slewline.errors import SlewlineError, UnknownName, UsageError
from tests.captures import MS, US, Sampled, Wave, saleae_csv, sigrok_vcd, wave

MHZ = 1_000_000
XY = {"x": ("STEP", "DIR")}


def written(of: Wave, path, mhz: int = 24, **more):
    path.write_bytes(sigrok_vcd(Sampled(of, mhz * MHZ), **more))
    return path


def steps(*at: int, high: int = 5 * US, direction: tuple[int, ...] = (MS // 2,)) -> Wave:
    """Pulses that begin at some instants."""
    edges = [edge for begin in at for edge in (begin, begin + high)]
    return Wave({"STEP": edges, "DIR": list(direction)}, {"STEP": 0, "DIR": 0}, at[-1] + MS)


ROW = tuple(MS + n * 500 * US for n in range(40))


def test_a_good_recording(tmp_path):
    found = check_capture(written(wave(), tmp_path / "a.vcd"), XY, driver="DM542")
    assert found.good and not found.notes and [row.verdict for row in found.limits] == ["met"] * 4
    (axis,) = found.axes
    assert str(axis).startswith("x: 190 steps, 120 forward and 70 back, ends at 50")
    assert axis.jitter is not None and axis.jitter.rms_ps < 41_667
    assert axis.jitter.rate_sps == pytest.approx(4400, rel=1e-3)


def test_an_axis_without_a_step_is_not_good(tmp_path):
    still = Wave({"STEP": [], "DIR": [MS, 2 * MS]}, {"STEP": 0, "DIR": 0}, 5 * MS)
    found = check_capture(written(still, tmp_path / "a.vcd"), XY)
    assert not found.good
    assert "x: no step on STEP; check whether STEP and DIR are exchanged" in str(found)


def test_each_time_that_is_too_short_is_named(tmp_path, subtests):
    short = 3 * US
    cases = {
        "STEP active": (steps(*ROW, high=2 * US), "high_ps"),
        "STEP inactive": (steps(*ROW, ROW[-1] + 5 * US + short), "low_ps"),
        "DIR before STEP": (steps(*ROW, direction=(ROW[9] - short,)), "setup_ps"),
        "DIR after STEP": (steps(*ROW, direction=(ROW[9] + short,)), "hold_ps"),
    }
    for says, (of, field) in cases.items():
        with subtests.test(says):
            path = written(of, tmp_path / "a.vcd")
            driver = StepDriver("mine", *([1000] * 4), 0, "its sheet")._replace(**{field: 4 * US})
            found = check_capture(path, XY, driver=driver)
            (wrong,) = found.limits.violated
            assert wrong.bound.limit.description == says and wrong.verdict.startswith("VIOLATED") and not found.good
            found.plot(tmp_path / "a.svg")
            assert says.encode() in (tmp_path / "a.svg").read_bytes()
            kept = check_capture(path, XY, driver=driver._replace(**{field: 2 * US}))
            assert not kept.limits.violated


def test_deviations_explained_by_sampling_are_not_violations(tmp_path):
    """A pulse that is sampled at 12 MHz is seen as 11 or 12 samples: 0.917 µs may be right, 0.75 µs cannot be."""
    of = steps(*(at + n * 17_000 for n, at in enumerate(ROW)), high=960_000)
    found = check_capture(written(of, tmp_path / "a.vcd", 12), XY, driver="A4988")
    row = found.limits[0]
    assert row.kept and row.doubtful and row.shortest_ps < US and row.verdict == "met, within 83.434 ns"
    less = steps(*(at + n * 17_000 for n, at in enumerate(ROW)), high=750_000)
    assert not check_capture(written(less, tmp_path / "b.vcd", 12), XY, driver="A4988").good
    coarse = check_capture(written(steps(*ROW), tmp_path / "c.vcd", 1), XY, driver="A4988")
    assert coarse.notes == (
        "Sampled every 1 µs: too coarse for A4988, whose pulses may be 1 µs short; record at 4 MHz or more.",
    )


def test_a_driver_that_steps_at_both_edges(tmp_path):
    """Klipper and others set this in a TMC2209: a change of STEP is a step, and a pulse lasts as long as one."""
    at = [MS + sum(500 * US // (1 + min(k, 39 - k, 9)) for k in range(n)) for n in range(40)]  # up to ten times as fast
    of = Wave({"STEP": at, "DIR": [at[20] - 30 * US]}, {"STEP": 0, "DIR": 0}, at[-1] + MS)
    path = written(of, tmp_path / "a.vcd")
    waves = slewline.read_waveforms(path)
    both = waves.steps("STEP", "DIR", edge="both")
    assert len(both.times_ps) == 40 and both.positions[-1] == 0
    halves = [len(waves.steps("STEP", edge=edge).times_ps) for edge in ("rising", "falling")]
    assert sum(halves) == 40 and both.times_ps.tolist() == sorted(waves.edges("STEP")[0].tolist())
    found = check_capture(path, XY, driver="high 40 us, low 40 us, setup 20 us, hold 20 us", edge="both")
    assert found.good, str(found)
    assert [row.bound.limit.description for row in found.limits] == [
        "STEP high",
        "STEP low",
        "DIR before STEP",
        "DIR after STEP",
    ]
    for driver, says in (
        ("high 60 us", "STEP high"), ("low 60 us", "STEP low"),
        ("low 1 us, setup 40 us", "DIR before STEP"), ("low 1 us, hold 25 us", "DIR after STEP"),
    ):  # fmt: skip
        (wrong,) = check_capture(path, XY, driver=driver, edge="both").limits.violated
        assert wrong.bound.limit.description == says
    short = written(Wave({**of.edges, "STEP": [*at, at[-1] + US]}, of.first, of.end), tmp_path / "b.vcd")
    assert not check_capture(short, XY, edge="both").axes[0].glitches
    assert check_capture(short, XY, edge="both", glitch="2 us").axes[0].glitches
    with pytest.raises(UsageError, match="edge='each': allowed falling, rising, both"):
        check_capture(path, XY, edge="each")


def test_a_driver_by_the_times_of_its_data_sheet(tmp_path, subtests):
    path = written(steps(*ROW), tmp_path / "a.vcd")
    found = check_capture(path, XY, driver="high 30 us, low 30 us")
    assert [row.verdict[:11] for row in found.limits] == ["VIOLATED 40", "met"]
    assert check_capture(path, XY, driver=" high 5 us ").good
    for driver, says in {
        "high 5 us, high 5 us": "'high'; allowed high, low, setup, hold, each once, such as 'high 30 us",
        "width 5 us": "'width'; allowed high, low",
        "setup 5 us": "expected minimum times of STEP high or low",
        "high 5": "a bare number is picoseconds|unit",
        "high soon": "soon",
    }.items():
        with subtests.test(driver), pytest.raises(SlewlineError, match=says):
            check_capture(path, XY, driver=driver)
    with pytest.raises(
        UnknownName, match=r"driver 'TB6560'; known: .*; for any other driver, give its times, such as 'high 30"
    ):
        check_capture(path, XY, driver="TB6560")


def test_glitches(tmp_path):
    more = sorted([*(edge for at in ROW for edge in (at, at + 5 * US)), ROW[4] + 100 * US, ROW[4] + 101 * US])
    found = check_capture(
        written(Wave({"STEP": more, "DIR": []}, {"STEP": 0, "DIR": 0}, 30 * MS), tmp_path / "a.vcd"), XY
    )
    assert len(found.axes[0].glitches) == 1 and "GLITCHES: 1, first at 3.1" in str(found)
    toggled = steps(*ROW, direction=(ROW[7] + 10 * US, ROW[7] + 14 * US))
    found = check_capture(written(toggled, tmp_path / "b.vcd"), XY)
    assert len(found.axes[0].glitches) == 1 and not found.good
    assert check_capture(tmp_path / "b.vcd", XY, glitch="2 us").good


@pytest.mark.parametrize("by", [0, 400_000, 2 * US])
def test_jitter_is_measured(tmp_path, by):
    even = steps(*ROW, *(ROW[-1] + n * 500 * US for n in range(1, 160)))
    of = even.jittered(by, 3) if by else even
    found = check_capture(written(of, tmp_path / "a.vcd", 48), XY).axes[0].jitter
    assert found is not None and found.steps >= 190
    assert found.rms_ps == pytest.approx(by / 3**0.5, rel=0.15, abs=13_000)


def test_skew_between_axes(tmp_path):
    one, second = steps(*ROW), steps(*(at + 2 * US for at in ROW[::2]))
    both = Wave(
        {"XS": one.edges["STEP"], "XD": [], "YS": second.edges["STEP"], "YD": []},
        dict.fromkeys(("XS", "XD", "YS", "YD"), 0),
        30 * MS,
    )
    (tmp_path / "a.csv").write_bytes(saleae_csv(Sampled(both, 100 * MHZ)))
    found = check_capture(tmp_path / "a.csv", {"x": ("XS", "XD"), "y": ("YS", None)})
    (skew,) = found.skews.values()
    assert skew.pairs == 20 and skew.median_ps == pytest.approx(2 * US, abs=10_000)
    assert "y after x: 2 µs, ±" in str(found)


def test_first_levels_that_are_missing_lose_no_step(tmp_path):
    """A file of changes has no level before the first of them."""
    found = check_capture(written(steps(*ROW), tmp_path / "a.vcd", 4, first=False), XY)
    assert len(found.axes[0].steps.times_ps) == 40


def test_a_part_is_checked_at_its_pins(tmp_path):
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.record("x.pulse", "x.direction", "x.slew")
    bench.host(x).send("A 0\rF 10\rR 80\rS 240\rZ 1\rN 300\rG\r")
    bench.run_until_idle()
    bench.save_vcd(tmp_path / "a.vcd")
    pins = {"pulse": "pulse", "slew": "slew", "direction": "direction"}
    found = check_capture(
        tmp_path / "a.vcd", {"x": ("pulse", "direction")}, edge="falling", part="cy525", pins=pins, crystal="11 MHz"
    )
    model = {row.bound.limit.description: row for row in bench.check_timing() if row.count}
    seen = {row.bound.limit.description: row for row in found.limits if row.count}
    assert seen.keys() == model.keys() and found.good
    assert all(abs(seen[says].shortest_ps - row.shortest_ps) <= 1000 for says, row in model.items())


def test_mistakes(tmp_path):
    path = written(steps(*ROW), tmp_path / "a.vcd")
    for given, error, says in (
        ({"axes": {}}, UsageError, "axes={}: expected the signals STEP and DIR"),
        ({"axes": {"x": "STEP"}}, UsageError, "axes: 'x': found 'STEP'; expected STEP and DIR"),
        ({"edge": "up"}, UsageError, "edge='up': allowed falling, rising"),
        ({"driver": "DM543"}, UnknownName, "driver 'DM543'; known: A4988"),
        ({"part": "cy525"}, UsageError, "part and pins: give both"),
        ({"part": "cy525", "pins": {"puls": "STEP"}}, UsageError, "pins: cy525 has no pin 'puls'"),
        ({"axes": {"x": ("STOP", None)}}, UnknownName, "no signal 'STOP'"),
    ):
        with pytest.raises(error, match=says):
            check_capture(path, given.pop("axes", XY), **given)
    with pytest.raises(UsageError, match="plot: no limit was measured"):
        check_capture(path, XY).plot(tmp_path / "a.svg")


def test_every_driver_has_its_limits(tmp_path):
    path = written(steps(*ROW, high=100 * US), tmp_path / "a.vcd")
    for name in STEP_DRIVERS:
        assert check_capture(path, XY, driver=name).good, name
