"""A stepper motor by its pins: what steps, phases and levels of current ask for, what it loses, and what it says."""

from __future__ import annotations

from typing import Any

import pytest

import slewline
from tests.rows import rows

DRY = {"load": "friction 5 mNm", "step": "100 us"}


def stepper(**options: Any) -> tuple[slewline.Bench, Any]:
    bench = slewline.Bench()
    motor: Any = bench.part("stepper", "m", **{**DRY, **options})
    bench.run("1 ms")
    return bench, motor


def step(bench: slewline.Bench, motor: Any, *levels: int, wait: str = "30 ms") -> None:
    """Give levels to PULSE, each for some time."""
    for level in levels:
        motor.pin("pulse").drive(level)
        bench.run(wait)


# ------------------------------------------------------------------------------------------------------------- its pins
def test_each_fall_is_a_step_in_the_direction_of_that_instant() -> None:
    bench, motor = stepper()
    step(bench, motor, 1, 0)
    assert (motor.command, round(motor.place)) == (1, 1)
    step(bench, motor, 1, 0, 1)
    assert (motor.command, round(motor.place)) == (2, 2)
    motor.pin("direction").drive(0)
    step(bench, motor, 0, 1, 0, 1, 0)
    assert (motor.command, round(motor.place)) == (-1, -1)


def test_with_the_other_edge_each_rise_is_a_step() -> None:
    bench, motor = stepper(edge="rise", steps="half")
    step(bench, motor, 0)
    assert motor.command == 0
    step(bench, motor, 1, 0, 1)
    assert (motor.command, motor.place) == (1, pytest.approx(1, abs=0.1))


def test_phases_attract_to_the_nearest_position_with_their_field() -> None:
    bench, motor = stepper(inputs="phases", driver="24 V, 1 A")

    def phases(bits: str) -> float:
        for n, bit in enumerate(bits, 1):
            motor.pin(f"phase{n}").drive(int(bit))
        bench.run("40 ms")
        assert motor.place == pytest.approx(motor.command, abs=0.15)
        return float(motor.command)

    begun = phases("1010")
    assert [phases(bits) - begun for bits in ("0010", "0110", "0101", "0111", "1001", "1010")] == [0.5, 1, 2, 1.5, 3, 4]
    assert phases("1001") - begun == 3 and phases("0000") - begun == 3
    assert phases("0110") - begun == 3  # to the opposite side either way is as near


@rows(("pins", "amperes"), [
    ({"mov": 0}, 0.5), ({"mov": 1}, 1.0), ({"mov": 1, "ramp": 1}, 1.5), ({"mov": 0, "ramp": 1}, 1.5),
    ({"mov": 1, "enable": 0}, 0.0), ({"mov": 0, "ramp": 1, "enable": 0}, 0.0),
])  # fmt: skip
def test_levels_of_current(pins: dict[str, int], amperes: float) -> None:
    bench, motor = stepper(driver="24 V, 1 A, rest 0.5 A, ramp 1.5 A")
    for name, level in pins.items():
        motor.pin(name).drive(level)
    bench.run("50 ms")
    assert motor.currents == pytest.approx((amperes, amperes), abs=1e-3)


def test_without_levels_there_are_no_pins_for_them() -> None:
    bench, motor = stepper()
    assert "mov" not in motor.pins and motor.currents == pytest.approx((1.0, 1.0))
    motor.pin("enable").drive(0)
    bench.run("50 ms")
    assert motor.currents == pytest.approx((0.0, 0.0), abs=1e-3)


def test_a_chip_counts_up_clockwise_and_an_encoder_counts_in_the_middle_between_steps() -> None:
    bench = slewline.Bench()
    chip = bench.add("cy525", name="x")
    motor: Any = bench.part("stepper", "m", chip, **DRY)
    encoder: Any = bench.part("encoder", "e", on=motor, counts=200)
    bench.host(chip).send("A 0\rF 4\rR 8\rS 200\rZ 1\rN 5\rG\r")
    bench.run("300 ms")
    assert motor.command == 5 and motor.place == pytest.approx(5, abs=0.1)
    for push, counts in ((-0.3, 5), (-0.6, 4), (1.2, 6)):
        motor.block()
        motor.push(5 + push - motor.place)
        bench.run("1 ms")
        assert (round(motor.place - 5, 1), encoder.counts) == (push, counts), push


def test_encoders_on_a_carriage_with_backlash_count_its_overshoot_once_in_each_direction() -> None:
    bench, motor = stepper()
    carriage: Any = bench.part("carriage", "c", on=motor, backlash=2.5)
    up, down = (bench.part("encoder", on=carriage, counts=200, reverse=reverse) for reverse in (False, True))
    for direction, place, counts in ((1, 10.74, 11), (0, -0.74 + 2.5, 2)):
        motor.pin("direction").drive(direction)
        step(bench, motor, *(1, 0) * 10, wait="15 ms")
        assert carriage.place == pytest.approx(place, abs=0.05)
        assert (up.counts, down.counts) == (counts, -counts)


# ----------------------------------------------------------------------------------------------------------- its losses
def said(motor: Any) -> list[tuple[str, str]]:
    return [(found.code, found.text) for found in motor.findings]


def test_steps_are_lost_four_at_a_time() -> None:
    bench, motor = stepper()
    motor.block()
    step(bench, motor, *(1, 0) * 5, wait="1 ms")
    assert motor.command == 5 and motor.lag == pytest.approx(5, abs=0.1) and motor.lost == 0
    motor.free()
    bench.run("200 ms")
    assert motor.lost == 4 and motor.lag == pytest.approx(4, abs=0.1)
    assert [code for code, _ in said(motor)] == ["out-of-step", "steps-lost"]
    assert "2 steps behind its command" in said(motor)[0][1] and "4 steps lost" in said(motor)[1][1]


def test_a_lag_of_three_steps_is_harmless_if_it_is_made_up() -> None:
    bench, motor = stepper()
    motor.push(-3)
    bench.run("300 ms")
    assert motor.lost == 4 and motor.lag == pytest.approx(4, abs=0.1)
    bench, motor = stepper()
    motor.push(-1.8)
    bench.run("300 ms")
    assert motor.lost == 0 and motor.lag == pytest.approx(0, abs=0.1) and said(motor) == []


def test_surplus_steps_are_reported() -> None:
    bench, motor = stepper()
    motor.push(8)
    bench.run("300 ms")
    assert motor.lost == -8
    assert "ahead of its command" in said(motor)[0][1] and "8 steps too many" in said(motor)[1][1]


def test_stall_is_high_from_two_steps_on() -> None:
    bench, motor = stepper()
    motor.block()
    seen = []
    for steps in (-1.9, -0.2, -1, 2, 3.0, 1):
        motor.push(steps)
        bench.run("1 ms")
        seen.append((round(motor.lag, 1), motor.pin("stall").net.level))
    assert seen == [(1.9, 0), (2.1, 1), (3.1, 1), (1.1, 0), (-1.9, 0), (-2.9, 1)]


def test_a_shaft_that_runs_into_a_stop_reports_it() -> None:
    bench, motor = stepper(load={"friction": "5 mNm", "high": 2.5})
    step(bench, motor, *(1, 0) * 3)
    assert motor.place == pytest.approx(2.5)
    assert {*said(motor)} == {("hard-stop", "the shaft hits a hard stop at 2.5 steps")}


def test_it_comes_to_rest() -> None:
    bench, motor = stepper()
    motor.pin("pulse").drive(0)
    bench.run("100 us")
    assert not motor.rests.met()
    bench.run_until(motor.rests, timeout="1 s")
    assert motor.speed == 0 and motor.place == pytest.approx(1, abs=0.1)


@pytest.mark.parametrize("first", ["push", "edge"])
def test_a_push_and_an_edge_at_one_instant_both_count(first: str) -> None:
    bench = slewline.Bench()
    motor = bench.part("stepper", name="m", driver="current 1 A", load="friction 20 mNm")
    bench.pin("m.pulse").drive(1)
    bench.run("1 ms")
    if first == "push":
        motor.push(1)
    bench.pin("m.pulse").drive(0)
    if first == "edge":
        motor.push(1)
    bench.run("1 us")

    assert motor.command == 1
    assert motor.place == pytest.approx(1, abs=0.01)


# ------------------------------------------------------------------------------------------------------ what is refused
@rows("steps", [float("nan"), float("inf"), 1e30, True, "3", None])
def test_a_push_is_a_number_of_steps(steps: Any) -> None:
    bench, motor = stepper()

    with pytest.raises(slewline.UsageError, match=r"m: push by .* steps; expected a number up to \+/-1e\+06"):
        motor.push(steps)
    assert bench.findings == []


@pytest.mark.parametrize("step", ["1 ps", "10 ms"])
def test_a_step_of_the_integrator_has_bounds(step: str) -> None:
    with pytest.raises(slewline.UsageError, match=r"m: step '.*'; allowed 100 ns\.\.200 µs"):
        stepper(step=step)


# ------------------------------------------------------------------------------------------------ what nobody looks at
def test_an_unobserved_move_is_not_integrated() -> None:
    bench = slewline.Bench()
    x: Any = bench.add("cy525", "x")
    motor: Any = bench.part("stepper", "m", x, **DRY)
    bench.part("encoder", "e", on=motor)
    bench.part("switch", "s", on=motor, low=100)
    bench.host(x).send("A 0\rF 10\rR 60\rS 200\rZ 1\rN 2000\rG\r")
    bench.run_until_idle()

    assert motor._run.reached < 50_000_000_000 < bench.now_ps
    bench.run_until(motor.rests)
    assert abs(motor.place + motor.lost - 2000) < 0.1


def test_without_current_steps_are_lost_once() -> None:
    bench, motor = stepper(load="friction 20 mNm")
    bench.pin("m.enable").drive(0)
    for _ in range(40):
        step(bench, motor, 1, 0, wait="500 us")
    bench.pin("m.enable").drive(1)
    bench.run("200 ms")

    assert [found.code for found in bench.findings] == ["out-of-step", "steps-lost"]
    assert (motor.command, motor.lost) == (40, 40)
