"""The Python face of the modules: what a user may hand in, and what the bench makes of it."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from gsc import STR, base, both

import slewline
from slewline import Timeout, UsageError, WiringError
from slewline.errors import BenchFileError, UnknownName


@both
def test_a_homing_that_is_stopped_never_changes_the_register(part):
    rig = base(part)
    rig.run(*STR, "+20")
    assert rig.asks("H+") == ["Y"]
    rig.bench.run("1 s")
    moved = rig.x.travel - 20
    assert moved > 90 and rig.x.position == rig.x.registers["position"] == 20
    steps = rig.x.steps()
    assert set(steps.positions[20:].tolist()) == {20} and len(steps) == 20 + moved
    assert rig.x.position_at(rig.bench.now_ps) == 20
    assert rig.asks("K") == ["Y"]
    assert rig.x.position == rig.pos() == 20


@both
def test_power_up_takes_its_time_before_the_module_is_idle(part):
    rig = base(part)
    rig.x.power(False)
    assert rig.x.idle
    rig.bench.run("1 ms")
    rig.x.power(True)
    assert not rig.x.idle
    begin = rig.bench.now_ps
    rig.bench.run_until_idle()
    assert rig.bench.now_ps - begin == 400_000_000
    with pytest.raises(UsageError, match=r"power\('off'\); allowed True, False"):
        rig.x.power("off")


def test_a_pulse_ends_at_the_level_that_was_driven_before():
    rig = base("gs-c200s")
    pin = rig.x.pin("ui2")
    pin.drive(0)
    pin.pulse(1, "20 us")
    pin.pulse(1, "20 us", at=rig.bench.now_ps + 10**9)
    levels = []
    for _ in range(2):
        levels.append(pin.level)
        rig.bench.run("20 us")
        levels.append(pin.level)
        rig.bench.run("980 us")
    assert levels == [1, 0, 1, 0]
    pin.release()
    assert pin.level == 1
    pin.pulse(0, "20 us")
    rig.bench.run("20 us")
    assert pin.level == 1
    with pytest.raises(UsageError, match="is in the past"):
        pin.pulse(0, "20 us", at="5 ps")
    pin.drive(True)
    assert pin.level == 1


def test_a_host_takes_chips_and_names_and_one_command_at_a_time():
    bench = slewline.Bench()
    x, y = (
        bench.add("gs-c200", name=name, straps={"br0": 0, strap: 0}) for name, strap in (("x", "sel0"), ("y", "sel1"))
    )
    host = bench.host(x, y)
    assert host.to(y).chip.name == "y" and host.to("x").chip.name == "x"
    with pytest.raises(UnknownName, match="no chip 'z'; it serves x, y"):
        host.to("z")
    with pytest.raises(UsageError, match="one command without a carriage return"):
        host.ask("V1\rF")
    with pytest.raises(UsageError, match="list of numbers"):
        host.send(5)
    with pytest.raises(WiringError, match="host is on the line of y already"):
        bench.host(y)
    with pytest.raises(UsageError, match="host: 5"):
        bench.host(5)


@pytest.mark.parametrize("timeout", ["1 ms", "4 ms"])
def test_a_query_that_is_given_up_is_sent_completely_and_leaves_the_host_in_order(timeout):
    bench = slewline.Bench()
    host = bench.host(bench.add("gs-c200s", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0}))
    bench.run("2 ms")
    with pytest.raises(Timeout, match="an answer to 'V1'"):
        host.ask("V1", timeout=timeout)
    host.send("V2\r")
    bench.run("50 ms")
    assert host.received == b"V+0\rV70\r"
    assert host.ask("F") == "R"


def test_a_journal_takes_no_functions(tmp_path):
    bench = slewline.Bench(journal=tmp_path / "run.jsonl")
    with pytest.raises(BenchFileError, match=r"add: .*function.*; journals store only numbers and text"):
        bench.add("gs-c200", law=lambda start, top, ramp, k: start)


def test_a_journal_takes_exact_numbers_of_any_type(tmp_path):
    path = tmp_path / "run.jsonl"
    bench = slewline.Bench(journal=path)
    bench.add("gs-c200", straps={"br0": np.int64(0)}, address=np.int64(2))
    bench.part("serial_sender", baud=Fraction(75, 2))
    bench.part("motor", loses=[np.int64(3)], lag=np.int64(5000))
    bench.run("1 ms")
    assert [*slewline.replay(path).parts] == ["serial_sender", "motor"]


def test_a_host_at_another_rate_is_notified():
    bench = slewline.Bench()
    x = bench.add("gs-c200")
    host = bench.host(x)
    assert host.ask("V1") == "V0"
    host.change_line(4800, 7, "odd", 2)
    with pytest.raises(Timeout, match=r"host is set to 4800 7O2, and gs_c200 to 110 7O2 \(br0=1, br1=1, br2=1\): set"):
        host.ask("F")
    assert host.baud == 4800


def test_options_agree_with_their_description():
    bench = slewline.Bench()
    for options, text in (
        ({"lenient": "no"}, "lenient 'no'; allowed True, False"),
        ({"store": "file"}, r"store 'file'; expected an object with read\(\) and write\(data\)"),
        ({"straps": [1]}, r"straps \[1\]; expected pins with levels"),
        ({"name": 5}, "name 5: allowed letters"),
        ({"crystal": "4 MHz"}, "the gs-c200 has no selectable crystal"),
        ({"supply": "24 V"}, r"supply '24 V'; allowed a number \(V\)"),
        ({"load": 80}, "load 80; allowed a table of v5_20, v5_21"),
        ({"load": {"v5_20": "80"}}, r"load: v5_20 '80'; allowed a number \(mA\)"),
    ):
        with pytest.raises(UsageError, match=text):
            bench.add("gs-c200", **options)
    for part in (None, 5, object):
        with pytest.raises(UsageError, match="expected a part number"):
            bench.add(part)
    assert not bench.chips


def test_names_and_functions_are_checked_where_they_are_given():
    bench = slewline.Bench()
    x = bench.add("gs-c200")
    for call in (lambda: bench.record(5), lambda: bench.wire(5, 6)):
        with pytest.raises((UsageError, UnknownName), match="pin"):
            call()
    with pytest.raises(UsageError, match="expected a function"):
        bench.at("1 ms", 5)
    for position in ("a", 1.5, 10**7, -1):
        with pytest.raises(UsageError, match=r"allowed 0\.\.9999999"):
            x.reaches(position)


def test_a_part_without_a_bus_records_none(tmp_path):
    bench = slewline.Bench()
    bench.add("gs-c200", name="x")
    bench.record()
    assert "x.db" not in bench.recorded and "x.clock" in bench.recorded
    bench.add("cy525", name="y")
    bench.record()
    assert "y.db" in bench.recorded
