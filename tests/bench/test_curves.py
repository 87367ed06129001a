"""Parts have curves as axes have: asked by name, drawn, read off, written; and lazy ones catch up first."""

from __future__ import annotations

import numpy as np
import pytest

import slewline
from slewline.core.motion.history import Polyline, Staircase
from slewline.core.time.kernel import Kernel
from slewline.errors import NotRecorded, UnknownName, UsageError
from slewline.parts.base.part import Part
from tests.oracles import waveform

MS = 10**9


class Tank(Part):
    """Fills by a litre a millisecond up to 30; it looks at that only when somebody asks."""

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.add_pin("mov", "in", "anything", pull=1)
        self.worked = 0

    def catch_up(self):
        if self.worked < 30 * MS <= self.kernel.seen:
            self.finding("full", "the tank is full", at=30 * MS)
        self.worked = self.kernel.seen

    def level(self, times):
        return np.minimum(times / MS, 30.0)

    def quantities(self):
        def points(start, stop):
            times = np.array([ps for ps in (30 * MS,) if start < ps <= stop], np.int64)
            return times, self.level(times)

        return (
            Polyline(self.kernel, "content", "l", self.level, points),
            Staircase(self.kernel, "lids", "1", lambda times: np.ones(times.shape), lambda start, stop: ([], [])),
        )


def moved():
    """A module with its phase current, and a tank, that has moved by 100 steps."""
    bench = slewline.Bench()
    x = bench.add("gs-c200s", name="x", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0})
    host = bench.host(x)
    bench.part("phase_current", name="driver", to=x)
    bench.part("phase_current", name="spare")
    tank = bench.place(Tank(bench.kernel, "tank"))
    bench.record("x.mov")
    for line in ("Po", "S20", "T100", "R5", "+100", "E"):
        host.ask(line)
    bench.run_until_idle()
    return bench, tank


def headings(figure):
    return [axes.get_title(loc="left") for axes in figure.axes if axes.get_title(loc="left")]


# --------------------------------------------------------------------------------------------------------------- asked
def test_quantities_of_axes_and_parts_are_queried_by_name():
    bench, _ = moved()
    current = bench.quantity("driver.current")
    assert (current.unit, current.is_staircase) == ("A", True)
    assert current.at(["1 ms", "50 ms"]).round(2).tolist() == [0.25, 1.5]
    at = bench["driver"].past[1][0]
    assert current.at([at - 1, at]).round(2).tolist() == [0.25, 1.5]
    assert bench.quantity("x.position").at(bench.now_ps) == 100
    assert bench.quantity("x.velocity").at("60 ms") == bench["x"].velocity_at("60 ms")
    assert bench.quantity("tank.content").at("12.5 ms") == 12.5
    with pytest.raises(UsageError, match="current: 3600 s is in the future"):
        current.at("1 h")


def test_of_several_axes_the_first_is_the_default():
    bench = slewline.Bench()
    m = bench.add("mc1451a", name="m")
    bench.run("3 ms")
    m.axes[0].load(5)
    m.axes[1].load(7)
    bench.run("1 ms")
    now = bench.now_ps
    names = ("m.position", "m.axis1.position", "m.axis2.position")
    assert [bench.quantity(name).at(now) for name in names] == [5, 5, 7]


def test_an_unknown_quantity_is_refused_with_the_existing_ones():
    bench, _ = moved()
    for name, listed in (
        ("driver.speed", r"'driver\.speed'; available: driver\.current$"),
        ("x.current", r"available: x\.velocity, x\.position$"),
        (
            "y.velocity",
            r"available: x\.velocity, x\.position, driver\.current, spare\.current, tank\.content, tank\.lids; did ",
        ),
        ("velocity", r"available: x\.velocity, "),
    ):
        with pytest.raises(UnknownName, match=listed):
            bench.quantity(name)
    with pytest.raises(UnknownName, match="none yet"):
        slewline.Bench().quantity("x.velocity")


# ------------------------------------------------------------------------------------------------------ drawn and read
def test_a_picture_shows_the_activity_of_the_parts_around_its_chips():
    bench, _ = moved()
    figure = bench.figure()
    assert headings(figure) == ["Velocity, steps/s", "Position, steps", "Current of driver, A"]
    (line,) = (line for axes in figure.axes for line in axes.lines if line.get_gid() == "current of driver")
    outline = bench.quantity("driver.current").changes(*(round(ms * MS) for ms in line.get_xdata()[[0, -1]]))
    assert line.get_ydata().tolist()[:-1] == outline.values.tolist() and line.get_linestyle() == "-"
    assert "driver: current from 0.249964 to 1.50067 A." in figure.description
    assert len(headings(bench.figure(parts=[]))) == 2


def test_parts_and_single_quantities_are_chosen_by_name():
    bench, _ = moved()
    assert headings(bench.figure(parts="tank"))[2:] == ["Content of tank, l", "Lids of tank, 1"]
    shown = headings(bench.figure(parts=["tank.content", "driver", "tank.content"]))[2:]
    assert shown == ["Content of tank, l", "Current of driver, A"]
    assert headings(bench.figure(parts=["driver", "spare"]))[2:] == ["Current, A"]  # the legend tells whose
    for wrong in ("tank.lid", "nobody", "host"):
        with pytest.raises(UnknownName, match=r"parts: no quantity .*available: driver\.current, spare\.current, tank"):
            bench.figure(parts=[wrong])


def test_a_part_that_is_wired_to_a_part_around_the_chip_is_shown_too():
    bench, _ = moved()
    assert [row.name for row in bench.readings("10 ms").rows][2:-1] == ["current of driver"]
    bench.wire("x.mov", "tank.mov")
    bench.wire("spare.mov", "tank.mov")
    bench.run("1 ms")
    names = [row.name for row in bench.readings("10 ms").rows]
    assert names[2:-1] == ["current of driver", "current of spare", "content of tank", "lids of tank"]
    assert headings(bench.figure(start=0))[2:] == ["Current of driver, A", "Content of tank, l"]  # the others rest
    assert headings(bench.figure(start="31 ms", stop="160 ms"))[2:] == [
        "Current of driver, A"
    ]  # nor does anything else
    (content,) = bench.readings(["10 ms", "40 ms"], parts="tank.content", axes="x").rows[2:3]
    assert (content.values, content.unit, content.differences) == ((10.0, 30.0), "l", (20.0,))


def test_a_waveform_file_has_the_quantities_that_parts_report(tmp_path):
    bench, _ = moved()
    bench.wire("x.mov", "tank.mov")
    bench.save_vcd(tmp_path / "x.vcd", values=True, timescale="1 ps")
    _, found = waveform.read(tmp_path / "x.vcd")
    current = bench.quantity("driver.current").staircase(0, bench.now_ps)
    assert found["driver.current"] == [*zip(current.times_ps.tolist(), current.values.tolist(), strict=True)]
    assert found["tank.content"] == [(0, 0.0), (30 * MS, 30.0)]
    assert found["tank.finding"][-1] == (30 * MS, r"full:\x20the\x20tank\x20is\x20full")
    assert "spare.current" not in found
    bench.save_vcd(tmp_path / "y.vcd")
    assert set(waveform.read(tmp_path / "y.vcd")[1]) == {"x.mov"}


def test_the_actual_position_of_an_axis_with_encoder_is_known_at_every_instant():
    bench = slewline.Bench()
    m = bench.add("mc1451a-e", name="m")
    host = bench.host(m)
    shaft = bench.part("encoder", "shaft", to=m, counts=400, steps=400)
    for name, value in (("SET_VEL", 65536), ("SET_ACC", 400), ("SET_POS", 300), ("UPDATE", None)):
        host.command(name, *([] if value is None else [value]))
    assert "actual_position" not in [quantity.name for quantity in m.axis(1).quantities()]
    seen = {}
    for ms in range(10, 200, 7):
        bench.run_to(f"{ms} ms")
        seen[ms * MS] = shaft.counts
        if ms == 80:
            shaft.slip(50)
        if ms == 150:
            host.command("SET_ACTL_POS", -7)
    bench.run_until_idle()
    actual = bench.quantity("m.actual_position")
    until, late = [at for at in seen if at <= 150 * MS], MS // 1000  # a count passes the filter within a microsecond
    assert actual.at([at + late for at in until]).tolist() == [seen[at] for at in until]
    assert actual.at(bench.now_ps) == host.query("GET_ACTL_POS")
    assert headings(bench.figure())[-1] == "Actual position, counts"
    m.axes[0].forget(100 * MS)
    assert actual.at("143 ms") == seen[143 * MS]
    with pytest.raises(NotRecorded):
        actual.changes(0, 99 * MS)


# -------------------------------------------------------------------------------------------------------------- lazy
ASKING = {
    "findings": lambda bench, path: bench.findings,
    "of the part": lambda bench, path: bench["tank"].findings,
    "picture": lambda bench, path: bench.plot(path / "a.svg"),
    "figure": lambda bench, path: bench.figure(),
    "vcd": lambda bench, path: bench.save_vcd(path / "a.vcd"),
    "csv": lambda bench, path: bench.save_csv(path / "a.csv"),
    "steps": lambda bench, path: bench.save_steps(path / "s.csv"),
}


@pytest.mark.parametrize("asks", ASKING)
def test_findings_of_a_lazy_part_are_made_on_the_first_query(asks, tmp_path):
    bench, tank = moved()
    heard = []

    def hear(found):
        heard.append((found.time_ps, found.code, bench["tank"].findings[-1] is found))  # asks, while it catches up

    tank.on_finding = hear
    bench.run("1 ms")
    assert heard == []
    for _ in range(2):
        ASKING[asks](bench, tmp_path)
        assert heard == [(30 * MS, "full", True)]


def test_late_findings_are_placed_at_the_time_of_their_cause():
    bench, tank = moved()
    tank.finding("early", "said at once", at=2 * MS)
    tank.finding("late", "said at once")
    assert [found.code for found in bench.findings] == ["early", "full", "late"]
    assert [found.code for found in tank.findings] == ["early", "full", "late"]


def test_parts_on_the_shaft_of_a_wired_part_are_drawn_with_it():
    bench = slewline.Bench()
    x, other = bench.add("cy525", name="x"), bench.add("cy525", name="other")
    motor = bench.part("translator", name="m", to=x)
    bench.part("carriage", name="car", on=bench.part("gear", name="g", on=motor, wheel=2))
    bench.part("carriage", name="far", on=bench.part("translator", name="n", to=other))
    bench.host(x).send("A 0\rN 40\rG\r")
    bench.run_until_idle()
    rows = {row.name for row in bench.readings("1 ms", axes=["x"]).rows}
    assert {"position of m", "position of g", "place of car"} <= rows
    assert not {"position of n", "place of far"} & rows
