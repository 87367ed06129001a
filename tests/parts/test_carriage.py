"""A carriage with backlash and stops, and switches on it: chips that home, are stopped, and run into it."""

from __future__ import annotations

from itertools import pairwise
from random import Random

import numpy as np
import pytest

import slewline
from tests.ensembles import few

NINE_SIX = {"br0": 0, "br1": 0, "br2": 0}
PATTERN = ("x.clock", "x.dir", "x.mov", "home.out", "plus.out")


class Machine:
    """A GS-C200S that moves a carriage between -520 and 520: HOME from -20 to 0, EOT from 500 on."""

    def __init__(self, start, *, shuffle=None, watched=False, **options):
        self.bench = bench = slewline.Bench(shuffle=shuffle)
        x = bench.add("gs-c200s", name="x", straps=NINE_SIX, **options)
        motor = bench.part("translator", "motor", to=x)
        self.carriage = bench.part("carriage", "carriage", on=motor, backlash=7, low=-520, high=520, start=start)
        bench.part("switch", "home", on=self.carriage, to=x, role="home", low=-20, high=0, hysteresis=3)
        bench.part("switch", "plus", on=self.carriage, to=x, role="end", low=500, hysteresis=3)
        self.motor, self.x, self.host, self.seen = motor, x, bench.host(x), []
        if watched:
            for pin in ("home.out", "plus.out", "x.clock"):
                bench.pin(pin).net.watch(lambda net: self.seen.append(bench.now_ps))
            bench.record(*PATTERN)

    def tell(self, *lines):
        for line in lines:
            assert self.host.ask(line).startswith(("Y", "R"))
        self.bench.run_until_idle("1000 s")

    def home(self):
        """The module homes; returns where the carriage and the shaft are, and when that was."""
        self.tell("Po", "S10", "T100", "R10", "E")
        self.tell("H")
        return self.carriage.place, self.bench.now_ps


def homes_on_the_same_step(seed):
    random = Random(seed)
    start = random.choice(
        [
            random.randrange(-519, 520),
            random.randrange(-25, 8),
            random.randrange(490, 520),
            random.randrange(-519, -510),
        ]
    )
    machine = Machine(start, shuffle=random.choice([None, seed]), watched=seed % 4 == 0)
    place, _ = machine.home()
    assert place == -1  # the first step at which HOME is closed, from above
    assert machine.motor.position + start == -1 - 7  # the shaft is the backlash ahead, whatever came before
    assert machine.x.position == 0
    assert not machine.carriage.findings


@pytest.mark.parametrize("seed", few(range(50), 17))
def test_homing_ends_on_the_same_step_wherever_it_begins(seed):
    homes_on_the_same_step(seed)


@pytest.mark.long
def test_it_does_so_from_a_thousand_more_starts():
    for seed in range(50, 1050):
        homes_on_the_same_step(seed)


def trace(start, **options):
    machine = Machine(start, watched=True, **options)
    machine.home()
    machine.tell("Po", "+40", "-35", "E")
    return [[list(map(int, part)) for part in machine.bench.edges(pin)] for pin in PATTERN]


@pytest.mark.parametrize("start", few([505, -12, 440], 1))
def test_the_edges_are_the_same_planned_and_stepwise_ties_shuffled_or_not(start):
    first = trace(start)
    assert all(times for times, _ in first[:4])
    assert trace(start, stepwise=True) == trace(start, shuffle=1) == trace(start, shuffle=2, stepwise=True) == first


def test_it_homes_just_as_well_when_unwatched():
    (place, over), watched = Machine(120).home(), Machine(120, watched=True)
    assert watched.home() == (place, over)
    assert watched.seen


def test_a_module_that_begins_on_the_wrong_end_switch_runs_into_the_stop_and_reports_it():
    machine = Machine(-505)
    machine.bench.part("switch", "minus", on="carriage", to="x", role="end", high=-500)
    machine.tell("Po", "S10", "T100", "R10", "E")
    machine.host.ask("H")
    machine.bench.run("10 s")
    (found,) = machine.carriage.findings
    assert found.code == "hard-stop" and "-520" in found.text
    assert machine.carriage.place == -520
    lost = machine.carriage.lost
    assert lost == machine.x.steps().directions.tolist().count(-1) - (-505 + 520) - 7
    machine.bench.run("1 s")
    assert machine.carriage.lost == lost + 100
    assert len(machine.carriage.findings) == 1


def test_a_carriage_leaves_its_stop_immediately_and_each_collision_is_reported():
    machine = Machine(510)
    machine.tell("Po", "S10", "T100", "R10", "+20", "-9", "+20", "E")
    assert machine.carriage.lost == 10 + 11
    assert machine.carriage.place == 520
    assert [found.code for found in machine.carriage.findings] == ["hard-stop"] * 2
    machine.tell("Po", "-8", "E")
    assert machine.carriage.place == 519  # the backlash first
    assert machine.x.position == 20 - 9 + 20 - 8


def test_two_end_switches_share_a_wire():
    machine = Machine(0)
    machine.bench.part("switch", "minus", on="carriage", to="x", role="end", high=-500)
    machine.tell("Po", "S10", "T1000", "R10", "+505", "E")
    assert machine.bench["plus"].closed and machine.x.pin("eot").level == 0
    machine.tell("Po", "-5", "-1010", "E")
    assert machine.bench["minus"].closed and not machine.bench["plus"].closed and machine.x.pin("eot").level == 0
    machine.tell("Po", "+50", "E")
    assert machine.x.pin("eot").level == 1


# --------------------------------------------------------------------------------------------------------- other chips
@pytest.mark.parametrize("stepwise", [False, True])
@pytest.mark.parametrize("watched", [False, True])
def test_an_end_switch_on_abort_brings_a_cy525_down_along_its_ramp(stepwise, watched):
    bench = slewline.Bench()
    x = bench.add("cy525", name="x", stepwise=stepwise)
    motor = bench.part("translator", "motor", to=x)
    end = bench.part("switch", "end", on=motor, to=x, role="abort", low=700)
    if watched:
        end.pin("out").net.watch(lambda net: None)
    host = bench.host(x)
    host.send("A 0\rF 10\rR 90\rS 250\rZ 1\rN 2000\rG\r")
    bench.run_until_idle()
    gaps = [(after - before) // 1000 for before, after in pairwise(x.steps().times_ps.tolist())]
    assert 700 < x.position == motor.position < 1000
    # ABORT is looked at as a step begins: the one behind the switch is the first that is slower
    assert gaps[699] == min(gaps) < gaps[700] and gaps[700:] == sorted(gaps[700:]) and gaps[-1] > 4 * gaps[699]


@pytest.mark.parametrize("shuffle", [None, 1])
def test_a_limit_switch_stops_an_mc1451a(shuffle):
    bench = slewline.Bench(shuffle=shuffle)
    x = bench.add("mc1451a-e", name="x")
    enc = bench.part("encoder", "enc", to=x, counts=200, steps=200)
    limit = bench.part("switch", "limit", on=enc, to=x, role="end_plus", low=300)
    assert limit.pin("out").level == 0
    host = bench.host(x)
    host.send("SET_PRFL_TRAP\nSET_POS 1000\nSET_VEL 65536\nSET_ACC 200\nUPDATE\n")
    bench.run("5 s")
    assert enc.counts == x.position == 300  # at once, in the cycle that sees it
    assert limit.closed and x.pin("poslimit1").level == 1


def test_a_switch_that_gates_its_own_clock_goes_by_edges():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    gate = bench.part("and", "gate")
    motor = bench.part("translator", "motor")
    bench.part("switch", "end", on=motor, low=50)
    wires = [("x.pulse", "gate.in1"), ("end.out", "gate.in2"), ("x.direction", "motor.direction")]
    for a, b in [*wires, ("gate.out", "motor.pulse")]:
        bench.wire(a, b)
    host = bench.host(x)
    host.send("A 0\rF 10\rR 90\rS 250\rZ 1\rN 200\rG\r")
    bench.run_until_idle()
    assert (motor.position, x.position) == (50, 200)
    assert motor.rule.edge_driven and gate.rule.edge_driven


# ------------------------------------------------------------------------------------------------------ what is refused
def test_unsuitable_parts_are_refused_with_the_reason():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    motor = bench.part("translator", "motor", to=x)
    gate = bench.part("and", "gate")
    for kind, given, says in (
        ("switch", {"low": 1}, "needs a shaft; name its owner"),
        ("uart", {"on": motor}, "is not mounted on a shaft"),
        ("switch", {"on": gate, "low": 1}, r"gate has no shaft; parts with a shaft: motor"),
        ("switch", {"on": motor}, "low must be below high, and only one of them may be None"),
        ("switch", {"on": motor, "low": 2, "high": 2}, "low must be below high"),
        ("switch", {"on": motor, "low": "2"}, "low '2'; allowed a number"),
        ("carriage", {"on": motor, "low": 1}, "start 0 is beyond the stop at 1"),
        ("gear", {"on": motor, "wheel": 0}, "wheel 0; allowed"),
    ):
        with pytest.raises(slewline.UsageError, match=says):
            bench.part(kind, **given)
    with pytest.raises(slewline.WiringError, match="needs"):
        bench.part("switch", on=motor, to=x, role="home", low=1)
    assert not motor.shaft.on_cut and not motor.shaft.stops


def test_a_gear_a_carriage_and_an_encoder_are_repeated_by_the_journal(tmp_path):
    journal = tmp_path / "journal"
    bench = slewline.Bench(journal=journal)
    x = bench.add("cy525", name="x")
    motor = bench.part("translator", "motor", to=x)
    gear = bench.part("gear", "gear", on=motor, pinion=20, wheel=60, reverse=True)
    bench.part("carriage", "carriage", on="gear", backlash=2.5, scale=0.01, unit="mm")
    bench.part("encoder", "enc", on=gear, counts=1000)
    host = bench.host(x)
    host.send("A 0\rF 10\rR 90\rS 250\rZ 1\rN 301\rG\r")
    bench.run_until_idle()
    bench["enc"].push(3)
    bench.run("1 ms")
    found = [bench["enc"].counts, bench["carriage"].place, gear.position]
    assert found[0] == -(-(-301 * 1000) // 600) + 2 and found[1] == pytest.approx(-(301 / 3 - 2.5) / 100, abs=1e-2)
    bench.journal.close()
    again = slewline.replay(journal)
    assert [again["enc"].counts, again["carriage"].place, again["gear"].position] == found


def test_a_carriage_and_its_motor_have_curves():
    machine = Machine(440, stepwise=True)
    fine = machine.bench.part("carriage", "fine", on="motor", scale=0.5, unit="mm")
    machine.home()
    (place,), (position,) = machine.carriage.quantities(), machine.motor.quantities()
    steps = machine.x.steps()
    after = steps.times_ps + 10**7
    made = np.cumsum(steps.directions)
    assert position.at(after).tolist() == made.tolist()
    assert place.at(after).tolist() == [
        440 + min(n, 60) if k < 60 else 440 + n + 7 if n < 53 else 500 for k, n in enumerate(made)
    ]
    assert fine.quantities()[0].unit == "mm" and fine.quantities()[0].at(after).tolist() == (made / 2).tolist()
    assert len(position.changes(-1, machine.bench.now_ps).times_ps) == len(made) + 1
