"""GS-D200 behind a GS-C: translator, figure 7, phase current of figures 6 and 11, and a clock line per direction."""

from __future__ import annotations

from itertools import pairwise
from math import isclose

import pytest
from modules import C200S, STR, US, Modules, both

import slewline
from slewline.parts.drivers.gsd200 import NETWORKS, beside, set_point, to_ground, to_supply

GRAY = ["0101", "0001", "1001", "1000", "1010", "0010", "0110", "0100"]


def driven(part: str, *wires: str, **options: object) -> Modules:
    m = Modules(part, **options)
    m.driver = m.bench.part("gs_d200", name="driver", to="x")
    m.wire(*wires)
    m.connect()
    m.states = []
    m.driver.pin("clock").net.watch(lambda net: m.states.append(m.driver.state) if net.level == 0 else None)
    return m


def phases(driver) -> str:
    return "".join(str(driver.pin(phase).level) for phase in "abcd")


# ------------------------------------------------------------------------------------------------------- translator
@both
@pytest.mark.fact("GSC-SYS-GSD-1")
def test_half_step_goes_through_eight_states_and_back(part):
    m = driven(part)
    seen = []
    m.driver.pin("clock").net.watch(lambda net: seen.append((m.driver.state, phases(m.driver))) if not net.level else 0)
    m.run(*STR, "+9", "-4")
    clockwise = [(n % 8 + 1, GRAY[n % 8]) for n in range(10)]
    assert seen == [*clockwise[:9], *reversed(clockwise[6:])]
    assert (m.driver.state, phases(m.driver)) == (6, "0010")
    for one, two in zip(GRAY, [*GRAY[1:], GRAY[0]], strict=True):
        assert sum(a != b for a, b in zip(one, two, strict=True)) == 1  # a Gray code
    assert [code.count("1") for code in GRAY] == [2, 1] * 4


@pytest.mark.fact("GSC-SYS-GSD-1")
@pytest.mark.parametrize(("before", "states", "on"), [(8, [1, 3, 5, 7], 2), (1, [2, 4, 6, 8], 1)])
def test_full_step_skips_the_lowest_bit_from_where_it_is_switched(before, states, on):
    m = driven(C200S)
    half = m.bench.pin("driver.half_full")
    if before == 1:
        m.run(*STR, "+1")
    half.drive(0)
    m.states.clear()
    m.run(*STR, "+5", "-5")
    assert m.states == [*states, states[0], states[1], states[0], *reversed(states[1:])]
    assert m.driver.state == states[0]
    assert {GRAY[state - 1].count("1") for state in m.states} == {on}
    half.drive(1)
    m.run(*STR, "+3")
    assert m.driver.state == (states[0] + 2) % 8 + 1


@both
@pytest.mark.fact("GSC-SYS-GSD-2")
def test_the_translator_advances_with_the_rise_of_clock_and_starts_at_state_1(part):
    m = driven(part)
    m.bench.record("driver.a", "driver.b", "driver.c", "driver.d")
    m.run(*STR, "+3")
    changes = sorted(time for phase in "abcd" for time, _ in m.edges(f"driver.{phase}", m.pulses()[0] - 1))
    assert changes == [time + 1_700_000 for time in m.pulses()]
    assert m.driver.state == 4
    m.x.power(False)
    m.x.power(True)
    assert (m.driver.state, phases(m.driver)) == (1, "0101")
    m.bench.pin("driver.reset").drive(0)
    m.bench.run("1 ms")
    m.run(*STR, "+3")
    assert m.driver.state == 1  # held


@both
@pytest.mark.fact("GSC-SYS-FIG7-1")
def test_user_outputs_switch_the_driver_its_decay_and_its_step(part):
    m = driven(part, "x.uo1 driver.enable", "x.uo2 driver.control", "x.uo3 driver.half_full")
    m.bench.run("1 ms")
    assert (phases(m.driver), m.driver.decay) == ("0000", "fast")
    m.run("A1", "A3", *STR, "+8")
    assert m.states == [1, 2, 3, 4, 5, 6, 7, 8]
    assert (m.driver.state, phases(m.driver)) == (1, "0101")
    m.run("A2", "C3", *STR, "+2")
    assert (m.states[8:], m.driver.state, m.driver.decay) == ([1, 3], 5, "slow")
    m.run("C1")
    assert (phases(m.driver), m.driver.state) == ("0000", 5)
    m.run("A1")
    assert phases(m.driver) == GRAY[4]


@pytest.mark.fact("GSC-SYS-GSD-2")
def test_a_promised_reset_comes_while_the_clock_is_stopped():
    bench = slewline.Bench()
    driver, delay = bench.part("gs_d200", "driver"), bench.part("delay", delay="1 ms")
    bench.wire(f"{delay.name}.out", "driver.reset")
    clock, before = bench.pin("driver.clock"), bench.pin(f"{delay.name}.in")
    before.drive(1)
    bench.run("2 ms")
    for level in (0, 1, 0, 1, 0, 1):
        clock.drive(level)
        bench.run("10 us")
    assert (driver.state, phases(driver)) == (4, "1000")
    before.drive(0)
    bench.run("0.9 ms")
    assert (driver.state, phases(driver)) == (4, "1000")
    bench.run("0.2 ms")
    assert (driver.state, phases(driver)) == (1, "0101")
    before.drive(1)
    bench.run("2 ms")
    assert (driver.state, phases(driver)) == (1, "0101")


# ----------------------------------------------------------------------------------------------------- phase current
@both
@pytest.mark.fact("GSC-SYS-CUR-1")
def test_mov_and_ramp_choose_the_phase_current(part):
    m = Modules(part)
    current = m.bench.part("phase_current", name="current", to="x")
    m.bench.record("x.mov", "x.ramp")
    m.connect()
    m.run("S10", "T100", "R50", "+1000")
    assert [round(amperes, 2) for _, amperes in current.past] == [0.25, 1.5, 0.5, 1.5, 0.25]
    (start, end), (_, slew, down, _) = (t for t, _ in m.edges("x.mov", 1)), (t for t, _ in m.edges("x.ramp", 1))
    assert [ps for ps, _ in current.past] == [0, start, slew, down, end]
    assert end - start == m.pulses()[-1] - m.pulses()[0] + 10 * US + 1_700_000
    assert slew == m.pulses()[50]
    assert down == m.pulses()[949]


@pytest.mark.fact("GSC-SYS-CUR-1")
def test_the_current_is_known_at_every_instant_of_the_past():
    m = Modules(C200S)
    current = m.bench.part("phase_current", name="current", to="x")
    m.connect()
    m.run("S10", "T100", "R50", "+1000")
    times = [0, *(ps + late for ps, _ in current.past[1:] for late in (-1, 0))]
    levels = [amperes for _, amperes in current.past]
    expected = [levels[0], *(level for pair in pairwise(levels) for level in pair)]
    assert [current.current_at(ps) for ps in times] == expected
    assert current.currents_at(times).tolist() == expected
    assert current.currents_at([times]).shape == (1, 9)


@pytest.mark.fact("GSC-SYS-CUR-1")
def test_the_transistors_follow_mov_and_ramp():
    bench = slewline.Bench()
    current = bench.part("phase_current", name="current")
    found = {}
    for mov, ramp in ((0, 0), (1, 1), (1, 0)):
        bench.pin("current.mov").drive(mov)
        bench.pin("current.ramp").drive(ramp)
        found[mov, ramp] = current.transistors
    assert found == {(0, 0): (False, True), (1, 1): (True, False), (1, 0): (False, False)}


@pytest.mark.fact("GSC-SYS-CUR-2")
def test_the_resistors_of_slew_and_rest_current():
    for amperes, ohms in ((0.5, 937), (0.25, 326)):
        assert isclose(to_ground(amperes), ohms, rel_tol=1e-3)
        assert isclose(to_ground(amperes), 1000 * amperes / (1 - 0.933 * amperes), rel_tol=1e-3)
    assert isclose(beside(to_ground(0.25), to_ground(0.5)), 500, rel_tol=1e-3)
    assert isclose(set_point(937), 0.5, rel_tol=1e-3)
    assert isclose(set_point(937, 500), 0.25, rel_tol=1e-3)


@pytest.mark.fact("GSC-SYS-CUR-3")
def test_the_resistor_of_the_ramp_current_follows_from_the_divider():
    assert isclose(set_point(), 1 / 0.9333, rel_tol=1e-4)  # 12/11.2 A with nothing around: where 1 - 0.933 I is 0
    assert isclose(to_supply(1.5, 937), 4245, rel_tol=1e-3)
    assert isclose(set_point(937, to_supply=4245), 1.501, rel_tol=1e-3)
    with pytest.raises(slewline.UsageError, match=r"1\.2 A by a resistor to ground: not possible"):
        to_ground(1.2)
    with pytest.raises(slewline.UsageError, match=r"0\.4 A by a resistor to 5 V"):
        to_supply(0.4, 937)


@pytest.mark.fact("GSC-SYS-CUR-4", "GSC-CON-R1")
def test_the_numbers_of_the_example_belong_to_the_driver_with_1200_ohm():
    assert {name: network.ground for name, network in NETWORKS.items()} == {"gs-d200": 1200, "gs-d200s": 750}
    assert isclose(to_supply(1.5, 937, ground=750), 3090, rel_tol=1e-3)  # the sheet prints 4245 for it
    assert isclose(to_supply(1.5, 937, ground=1200), 4245, rel_tol=1e-3)
    bench = slewline.Bench()
    for driver, ramp in (("gs-d200", 1.501), ("gs-d200s", 1.226)):
        assert isclose(bench.part("phase_current", driver=driver)._currents[True, False], ramp, rel_tol=1e-3)


def test_a_driver_is_not_loaded_beyond_its_rating():
    bench = slewline.Bench()
    with pytest.raises(slewline.UsageError, match=r"c: 2\.1 A on ramps; the gs-d200 allows up to 2 A; use a larger r1"):
        bench.part("phase_current", "c", r1=to_supply(2.1, 937))
    with pytest.raises(slewline.UsageError, match="driver 'gs-d300'; allowed gs-d200, gs-d200s"):
        bench.part("phase_current", "c", driver="gs-d300")
    with pytest.raises(slewline.UsageError, match="r2 0; allowed more than 0 ohm"):
        bench.part("phase_current", "c", r2=0)


# --------------------------------------------------------------------------------------------------------- two clocks
@both
@pytest.mark.fact("GSC-SYS-CLK2-1")
def test_a_gate_makes_a_clock_line_for_each_direction(part):
    m = Modules(part)
    m.bench.part("two_clocks", name="gate", to="x")
    m.bench.record("gate.cw", "gate.ccw", "x.dir")
    m.connect()
    m.run(*STR, "+5", "-3", "+1")
    pulses = m.pulses()
    for pin, own in (("gate.cw", pulses[:5] + pulses[8:]), ("gate.ccw", pulses[5:8])):
        assert m.edges(pin) == [(time + late, level) for time in own for late, level in ((0, 0), (1_700_000, 1))]
    assert m.edges("x.dir", 1) == [(pulses[5] - 10 * US, 0), (pulses[8] - 10 * US, 1)]  # and no edge on the gate
