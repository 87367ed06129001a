"""Every run is checked once before its pulses are promised: a law of motion that errs is stopped, and named."""

from __future__ import annotations

import pytest

import slewline
from slewline.chips.mc1451a.axis import generator
from slewline.chips.mc1451a.axis.verified import fault_of_curve, fault_of_run
from slewline.chips.mc1451a.profiles.cycle_train import Linear
from slewline.chips.mc1451a.profiles.profile import CycleRun, MoveLimits, Phases, brake, contour, s_curve, trapezoid
from slewline.chips.mc1451a.profiles.s_curves import PLACES, SCurve
from slewline.core.motion.train import OPEN
from slewline.errors import PlanError, SlewlineError

LIMITS = MoveLimits(velocity=1000, acceleration=70, start=200)
CURVE = s_curve(10_000_000, 60_000, 900, 30_000_000)


def fault(run, before=0, remaining=10**6, limits=LIMITS):
    return fault_of_run(Linear(run.speed, run.change), run, limits, before, remaining)


@pytest.mark.parametrize(
    ("run", "before", "says"),
    [
        (CycleRun(0, 200), 0, "0 cycles"),
        (CycleRun(OPEN, 200, 1), 200, "cycles"),
        (CycleRun(1, 201), 0, "from speed 0 to 201; the acceleration is 70"),
        (CycleRun(1, 799), 1000, "from speed 1000 to 799"),
        (CycleRun(3, 400, 71), 400, "accelerates by 71"),
        (CycleRun(3, 400, -71), 400, "accelerates by -71"),
        (CycleRun(12, 240, 70), 200, "from speed 240 to 1010; allowed 0 to 1000"),
        (CycleRun(4, 200, -70), 200, "from speed 200 to -10"),
        (CycleRun(1, 1100), 1050, "from speed 1100 to 1100; allowed 0 to 1050"),
        (CycleRun(1, 199, landing=True), 200, "lands after 199; the destination is 1000000 away"),
    ],
)
def test_an_inconsistent_run_is_found(run, before, says):
    assert says in fault(run, before)


@pytest.mark.parametrize(
    ("run", "before"),
    [(CycleRun(1, 200), 0), (CycleRun(11, 270, 70), 200), (CycleRun(OPEN, 1000), 930), (CycleRun(8, 1130, -70), 1200)],
)
def test_values_exactly_at_the_bound_are_allowed(run, before):
    assert fault(run, before) == ""
    assert fault(CycleRun(1, 150, landing=True), 200, 150) == ""


def test_the_laws_of_motion_make_no_faults():
    speed, left = 0, 123_457
    while True:
        run = trapezoid(LIMITS, left, speed)
        assert fault(run, speed, left) == ""
        law = Linear(run.speed, run.change)
        speed, left = law.velocity(run.cycles - 1), left - law.travel(run.cycles)
        if run.landing:
            break
    assert left == 0
    assert fault(contour(LIMITS, 0)) == fault(brake(LIMITS, 700), 700) == fault(contour(LIMITS, 1200), 1200) == ""


def test_an_s_curve_and_each_rest_of_it_holds_and_a_bent_one_does_not():
    for done in (0, 1, CURVE.cycles // 3, CURVE.cycles - 1):
        law = SCurve(CURVE.pieces(), done)
        before = SCurve(CURVE.pieces()).velocity(done - 1) if done else 0
        run = CycleRun(CURVE.cycles - done, 0, landing=True)
        assert fault_of_curve(law, run, CURVE, before) == ""
        assert "from speed" in fault_of_curve(law, run, CURVE, before + 2000)
        assert "lands at" in fault_of_curve(law, run, CURVE._replace(distance=CURVE.distance + (1 << PLACES)), before)
        assert fault_of_curve(law, CycleRun(0, 0), CURVE, before) == "0 cycles"
    law, run = SCurve(CURVE.pieces()), CycleRun(CURVE.cycles, 0, landing=True)
    assert "speed" in fault_of_curve(law, run, CURVE._replace(velocity=50_000), 0)
    pieces = CURVE.pieces()
    pieces[2] = pieces[2]._replace(position=pieces[2].position + (2 << PLACES))
    assert "does not end where the next one begins" in fault_of_curve(SCurve(pieces), run, CURVE, 0)


def chip(**options):
    bench = slewline.Bench()
    host = bench.host(bench.add("mc1451a", name="m", **options)).axis(2)
    bench.run("3 ms")
    for command, value in (("SET_VEL", 65536), ("SET_ACC", 3000), ("SET_MAX_ACC", 900), ("SET_JERK", 10**6)):
        host.command(command, value)
    return host, bench


@pytest.mark.parametrize(
    ("law", "wrong", "says"),
    [
        ("trapezoid", lambda limits, left, speed: CycleRun(1, left, landing=True), "from speed 0 to 1310720"),
        (
            "trapezoid",
            lambda limits, left, speed: CycleRun(1, left - 1, landing=True) if speed else CycleRun(1, 1000),
            "speed",
        ),
    ],
)
def test_a_law_that_errs_stops_the_model_before_a_pulse_and_names_axis_and_run(monkeypatch, law, wrong, says):
    host, bench = chip()
    monkeypatch.setattr(generator, law, wrong)
    host.command("SET_POS", 20)
    with pytest.raises(PlanError, match=rf"m axis 2, cycle \d+: CycleRun\(.*is inconsistent: .*{says}"):
        host.command("UPDATE")
        bench.run("5 ms")
    assert len(bench["m"].axis(2).steps()) == 0


def test_an_s_curve_that_errs_stops_the_model(monkeypatch):
    host, bench = chip()
    honest = Phases.pieces

    def bent(self):
        first, second, *others = honest(self)
        return [first, second._replace(position=second.position + (9 << PLACES)), *others]

    monkeypatch.setattr(Phases, "pieces", bent)
    host.command("SET_PRFL_S_CRV")
    host.command("SET_POS", 200)
    with pytest.raises(PlanError, match=r"axis 2.*phase 1 does not end where the next one begins"):
        host.command("UPDATE")
        bench.run("5 ms")


def test_it_can_be_caught_as_a_failed_assertion_too():
    assert issubclass(PlanError, SlewlineError) and issubclass(PlanError, AssertionError)


@pytest.mark.parametrize("stepwise", [False, True])
def test_contouring_reverses_immediately_below_the_starting_velocity_even_if_that_is_above_v(stepwise):
    bench = slewline.Bench()
    x = bench.add("mc1151a", stepwise=stepwise)
    host = bench.host(x)
    for name, value in (("START_VEL", (1 << 30) - 1), ("VEL", 1 << 14), ("ACC", 3)):
        host.command(f"SET_{name}", value)
    host.command("SET_PRFL_VEL")
    host.command("UPDATE")
    bench.run("20 ms")
    assert x.travel > 0
    host.command("SET_VEL", 100)
    host.command("SET_ACC", -3)
    host.command("UPDATE")
    bench.run("2 s")
    assert x.registers["trgt_vel"] == -100
