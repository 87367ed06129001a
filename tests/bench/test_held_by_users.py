"""What users hold in their hands: short texts, names of a bench, its present as a time, arrays, windows."""

from __future__ import annotations

import numpy as np
import pytest

import slewline
from slewline.errors import UsageError
from slewline.links.sockets.address import parse_address


@pytest.fixture
def run():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    host = bench.host(x)
    bench.record("x.slew", "x.pulse")
    host.send("A 0\rN 40\rG\r")
    bench.run_until_idle()
    return bench, x, host


def test_texts_are_a_line(run):
    bench, x, host = run
    assert repr(bench) == "<Bench: x (cy525), host; 136.046909 ms>"
    assert repr(x) == "<CY525 x: position 40, idle, 136.046909 ms>"
    assert repr(host) == "<BusHost host of x: nothing to send>"
    assert repr(x.steps()).startswith("<Steps: 40, ") and repr(x.steps()).endswith(", positions 1 to 40>")
    assert repr(x.steps("0 s", "0 s")) == "<Steps: none>"
    assert repr(x.sheet) == "<Sheet cy525: 40 pins, 26 commands>"
    assert repr(slewline.ramp("cy525", F=3, R=127, S=200)).startswith("<Ramp F=3, R=127, S=200, Z=1")
    for number in range(20):
        bench.part("inverter", name=f"n{number}")
    assert len(repr(bench)) < 120 and "14 more" in repr(bench)
    host.send("P 0\r")
    bench.run("20 ms")
    assert "in motion" in repr(x)


def test_a_bench_has_names(run):
    bench, _, _ = run
    assert list(bench) == ["x", "host"] and "x" in bench and "y" not in bench and 3 not in bench and bench


def test_now_is_a_time(run):
    bench, x, _ = run
    assert x.position_at(bench.now) == 40 and x.position_at([bench.now, "0 s"]).tolist()[0] == 40
    assert x.steps("1 ms", bench.now) == x.steps() and len(bench.edges("x.slew", bench.now)[0]) == 0
    x.pin("abort").drive(0, at=bench.now)
    assert bench.readings(bench.now).rows
    bench.run_to(bench.now)
    with pytest.raises(UsageError, match="a float would be rounded"):
        bench.run_to(bench.now + 0.5)


def test_steps_are_a_sequence(run):
    steps = run[1].steps()
    assert steps[0] == (int(steps.times_ps[0]), 1, 1) and steps[-1].position == 40
    assert [step.position for step in steps[:3]] == [1, 2, 3] and len(list(steps)) == 40
    assert steps == run[1].steps() != steps[:3]


def test_arrays(run, tmp_path):
    bench, x, _ = run
    bench.save_npz(tmp_path / "all.npz")
    bench.save_steps(tmp_path / "steps.npz")
    with np.load(tmp_path / "all.npz") as found:
        assert found["x.axis1.positions"].tolist() == list(range(1, 41))
        assert found["x.slew.times_ps"].tolist() == bench.edges("x.slew")[0].tolist()
    with np.load(tmp_path / "steps.npz") as found:
        assert sorted(found) == ["x.axis1.directions", "x.axis1.positions", "x.axis1.times_ps"]
        assert found["x.axis1.times_ps"].tolist() == x.steps().times_ps.tolist()


def test_an_image_may_be_the_path_of_a_file(run, tmp_path):
    bench, _, _ = run
    (tmp_path / "image").write_bytes(b"\x01\x02")
    assert bench.part("ram", image=tmp_path / "image").content[:3] == b"\x01\x02\xff"
    with pytest.raises(UsageError, match="is the name of a file"):
        bench.part("ram", image=str(tmp_path / "image"))
    assert bench.part("ram", image="A 0\r").content[:4] == b"A 0\r"


def test_a_second_host_of_a_chipset_is_refused_and_the_first_one_named():
    bench = slewline.Bench()
    m = bench.add("mc1451a")
    bench.host(m)
    with pytest.raises(slewline.WiringError, match="use bench\\['host'\\]"):
        bench.host(m)


def test_show_opens_a_window_or_reports_that_none_is_available(run, monkeypatch):
    from matplotlib import pyplot

    bench, shown = run[0], []
    with pytest.raises(
        UsageError, match=r"the backend agg has no windows; bench\.plot\('run\.svg'\) draws into a file"
    ):
        bench.show()
    monkeypatch.setattr(pyplot, "get_backend", lambda: "tkagg")
    monkeypatch.setattr(pyplot, "show", lambda: shown.append(pyplot.gcf()))
    bench.show("a title")
    assert [type(figure).__name__ for figure in shown] == ["Picture"]
    pyplot.close("all")


def test_a_run_without_motion_is_drawn_from_the_first_finding_to_the_last():
    bench = slewline.Bench()
    host = bench.host(bench.add("cy525", name="x"))
    host.send("a 0\rF 10\rS 300\r")
    bench.run("20 ms")
    bench.record()
    findings = [found.time_ps for found in bench.findings]
    panels = bench.figure(pins=[]).axes
    low, high = panels[0].get_xlim()
    assert len(findings) > 1 and low * 10**9 <= findings[0] + 10**8 and high * 10**9 >= findings[-1]
    assert len(panels) == 1  # no position that never moves


@pytest.mark.parametrize(("text", "where"), [("4001", ("127.0.0.1", 4001)), ("localhost:1", ("localhost", 1))])
def test_a_port_alone_is_one_of_this_machine(text, where):
    assert parse_address(text) == where
