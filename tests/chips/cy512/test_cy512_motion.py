"""How the CY512 moves: rates, ramps, TERMINATE, the two ways to end a motion, and what shows on the pins."""

from __future__ import annotations

from itertools import pairwise

import pytest

import slewline
from slewline.chips.cy512 import profile
from slewline.core.datasheet.channel import BusHandshake
from tests.chips.conftest import Rig

CLOCK = 11 * 10**6  # picoseconds are clocks * 10**12 / CLOCK
SET = "R 255\rS 0\rF 1\rN 1\rA\r"
both = pytest.mark.parametrize("stepwise", [False, True])


def made(**options: object) -> Rig:
    """A CY512 on a bench, whose registers have all been set."""
    r = Rig(part="cy512", **options)
    r.send(SET)
    return r


def clocks(r: Rig, instants: list[int]) -> list[int]:
    """Crystal clocks between instants."""
    return [b - a for a, b in pairwise(r.x.clock.ticks_until(at) for at in instants)]


def periods(r: Rig, since: int = 0) -> list[int]:
    """Clocks from step to step."""
    return clocks(r, r.x.steps(since).times_ps.tolist())


def us(count: float) -> int:
    return round(count * 10**6)


def moving(r: Rig, command: str = "G\r", steps: int = 1) -> int:
    """Send what begins a motion; time stands at the begin of one of its steps, which is returned."""
    made_before = len(r.x.steps())
    r.start(command)
    r.bench.run_until(lambda: len(r.x.steps()) == made_before + steps)
    return r.bench.now_ps


# ---------------------------------------------------------------------------------------------------------------- rates
@pytest.mark.fact("CY512-RATE-1", "CY512-RATE-3", "CY512-CMD-R-1")
@pytest.mark.parametrize(("rate", "expected"), [(1, 5741.82), (100, 3581.82), (200, 1400), (254, 221.82), (255, 200)])
@both
def test_a_step_takes_200_us_at_r_255_and_240_clocks_more_for_each_unit_below(rate, expected, stepwise):
    r = made(stepwise=stepwise)
    r.send(f"R {rate}\rN 4\rG\r")
    assert periods(r) == [round(expected * 11)] * 3


@pytest.mark.fact("CY512-CMD-R-1")
def test_the_rates_are_further_apart_the_higher_they_are():
    rates = [CLOCK / ticks for ticks in profile.LAW.periods]
    gaps = [b - a for a, b in pairwise(rates)]
    assert gaps == sorted(gaps) and gaps[0] > 0


@pytest.mark.fact("CY512-RATE-4", "CY512-RAMP-2")
def test_rates_are_finer_and_the_ramp_is_straighter_than_on_the_cy500():
    from slewline.chips.cy500.sheet import PERIODS

    def middle(periods: tuple[int, ...], top: int) -> float:
        """The speed at half the time of the ramp with S 1, over that at its end."""
        ramp, passed = periods[1:top], 0
        for period in ramp:
            passed += period
            if passed * 2 >= sum(ramp):
                return periods[top] / period
        raise AssertionError

    ours, theirs = profile.LAW.periods, PERIODS
    assert ours[254] / ours[255] == pytest.approx(1.109, abs=0.001)
    assert theirs[252] / theirs[253] == pytest.approx(1.262, abs=0.001)
    assert middle(ours, 255) == pytest.approx(0.049, abs=0.001) and middle(theirs, 253) == pytest.approx(
        0.021, abs=0.001
    )


@pytest.mark.fact("CY512-CMD-F-1")
@pytest.mark.parametrize(("factor", "times"), [(1, 1), (10, 10), (255, 255), (0, 256)])
@both
def test_the_factor_multiplies_the_time_of_every_step(factor, times, stepwise):
    r = made(stepwise=stepwise)
    r.send(f"F {factor}\rN 3\rG\r")
    assert periods(r) == [2200 * times] * 2


# ---------------------------------------------------------------------------------------------------------------- ramps
@pytest.mark.fact("CY512-CMD-S-1", "CY512-UND-RAMP-RULE", "CY512-RAMP-4", "CY512-RAMP-1")
@pytest.mark.parametrize(
    ("rate", "slope", "steps", "ms"),
    [(255, 1, 254, 757.38), (255, 5, 51, 153.74), (255, 10, 26, 78.38), (200, 5, 40, 144.58), (200, 10, 20, 73.38)],
)
@both
def test_a_move_ramps_up_slews_and_ramps_down(rate, slope, steps, ms, stepwise):
    r = made(stepwise=stepwise, record=("slew", "motion_complete"))
    r.send(f"R {rate}\rS {slope}\rN {2 * steps + 60}\rG\r")
    first, fast = int(r.x.steps().times_ps[0]), 63400 - 240 * rate
    slews, ends = r.falls("slew")[0], r.rises("slew")[-1]
    assert slews - first == pytest.approx(ms * 10**9, rel=1e-4)
    assert ends - slews == pytest.approx(60 * fast * 10**12 / CLOCK, rel=1e-6)
    up = [63400 - 240 * each for each in range(1, rate, slope)]
    whole = [*up, *[fast] * 60, *up[::-1]]
    assert periods(r) == whole[:-1] and len(up) == steps
    assert r.falls("motion_complete")[-1] - first == pytest.approx(sum(whole) * 10**12 / CLOCK, abs=2)


@pytest.mark.fact("CY512-RAMP-1", "CY512-CON-SLOPE-GUIDE")
def test_half_the_time_of_a_ramp_is_spent_below_a_tenth_of_the_rate():
    r = made()
    r.send("S 1\rN 600\r")
    since = moving(r)
    assert r.x.velocity_at(r.bench.now_ps) < 180
    r.bench.run("379 ms")
    assert r.bench.now_ps - since < 757.38e9 / 2 + us(1000) and r.x.velocity_at(r.bench.now_ps) < 500


@pytest.mark.fact("CY512-RAMP-3", "CY512-UND-SLOWEST")
@pytest.mark.parametrize("number", [1, 50, 101])
@both
def test_a_move_without_room_for_both_ramps_is_made_at_the_slowest_rate(number, stepwise):
    r = made(stepwise=stepwise, record=("slew",))
    r.send(f"S 5\rN {number}\rG\r")
    assert periods(r) == [63160] * (number - 1) and not r.edges("slew")
    assert len(r.x.steps()) == number


@pytest.mark.fact("CY512-RAMP-3")
@pytest.mark.parametrize(("number", "slewed"), [(102, 0), (103, 1)])
@both
def test_with_room_for_both_ramps_it_is_not(number, slewed, stepwise):
    r = made(stepwise=stepwise)
    r.send(f"S 5\rN {number}\rG\r")
    up = [63400 - 240 * each for each in range(1, 255, 5)]
    assert periods(r) == [*up, *[2200] * slewed, *up[::-1]][:-1]


@pytest.mark.fact("CY512-UND-FACTOR-RAMP")
@both
def test_a_factor_after_the_slope_counts_in_the_ramp_and_is_reported(stepwise):
    r = made(stepwise=stepwise)
    r.send("S 50\rF 3\rN 20\rG\r")
    up = [3 * (63400 - 240 * each) for each in range(1, 255, 50)]
    assert periods(r) == [*up, *[6600] * 8, *up[::-1]][:-1] and "factor-in-slope" in r.codes


@pytest.mark.fact("CY512-UND-RATE-LAW")
def test_the_law_is_an_option():
    table = [5000 - 10 * rate for rate in range(256)]
    r = made(inferred={"periods": table, "ramp_start": 200})
    r.send("R 210\rS 4\rN 8\rG\r")
    assert periods(r) == [3000, 2960, 2920, 2900, 2900, 2920, 2960]
    r = made(inferred={"periods": table, "ramp_start": 200})
    r.send("R 210\rS 4\rN 5\rG\r")
    assert periods(r) == [3000] * 4


# ------------------------------------------------------------------------------------------------------------ TERMINATE
@pytest.mark.fact("CY512-RATE-2", "CY512-UND-TERMINATE", "CY512-CON-SPEED")
@pytest.mark.parametrize("rate", [1, 200, 255])
@both
def test_terminate_kept_low_outputs_almost_8000_steps_a_second(rate, stepwise):
    r = made(stepwise=stepwise, record=("pulse",))
    r.drive("terminate", 0)
    r.send(f"R {rate}\rN 9\rG\r")
    assert periods(r) == [1380] * 8 and pytest.approx(7971, abs=1) == CLOCK / 1380
    edges = [at for at, _ in r.edges("pulse")]
    assert clocks(r, edges)[:4] == [1284, 96, 1284, 96] and r.x.travel == 9


@pytest.mark.fact("CY512-PIN-4", "CY512-UND-TERMINATE")
@pytest.mark.parametrize(("low", "ends"), [(60, 125.45), (116, 125.45), (120, 128.82), (140, 148.82), (3000, 3008.82)])
@both
def test_terminate_ends_the_running_step_but_not_before_92_cycles(low, ends, stepwise):
    r = made(stepwise=stepwise, record=("pulse",))
    r.send("R 1\rN 3\r")
    first = moving(r)
    r.x.pin("terminate").drive(0, at=first + us(low))
    r.bench.run_until(lambda: len(r.x.steps()) == 2)
    r.x.pin("terminate").release()
    r.bench.run_until_idle("1 s")
    one, two = periods(r)
    assert one == pytest.approx(ends * 11, abs=1) and two == 63160
    assert r.x.clock.ticks_until(r.rises("pulse")[0]) == r.x.clock.ticks_until(first) + one - 96


@pytest.mark.fact("CY512-PIN-4")
@both
def test_terminate_that_ends_before_it_counts_and_after_pulse_has_no_effect(stepwise):
    r = made(stepwise=stepwise)
    r.send("R 200\rN 3\r")
    first = moving(r)
    terminate = r.x.pin("terminate")
    for begin, end in ((10, 110), (1395, 1399), (1401, 1450)):
        terminate.drive(0, at=first + us(begin))
        terminate.drive(1, at=first + us(end))
    r.bench.run_until_idle("1 s")
    assert periods(r) == [15400] * 2


@pytest.mark.fact("CY512-PIN-6")
def test_an_encoder_on_terminate_sets_the_pace():
    """A pulse of the shaft, 150 us behind each step, asks for the next one."""
    r = made()
    terminate = r.x.pin("terminate")

    def answer(_net: object) -> None:
        if r.x.pin("pulse").level == 0:
            terminate.drive(0, at=r.bench.now_ps + us(150))
            terminate.drive(1, at=r.bench.now_ps + us(152))

    r.x.pin("pulse").net.watch(answer)
    r.send("R 1\rN 20\rG\r")
    assert all(each == pytest.approx(158.8 * 11, abs=2) for each in periods(r)) and r.x.travel == 20


@both
def test_terminate_and_step_inhibit_together_hold_the_step(stepwise):
    r = made(stepwise=stepwise, record=("pulse",))
    r.send("R 1\rN 2\r")
    first = moving(r)
    r.drive("step_inhibit", 1)
    r.x.pin("terminate").drive(0, at=first + us(300))
    r.x.pin("step_inhibit").drive(0, at=first + us(900))
    r.bench.run_until_idle("1 s")
    (one,) = periods(r)
    assert 908 * 11 < one < 910 * 11
    assert r.rises("pulse")[0] - first < us(301)


# ------------------------------------------------------------------------------------------------------------ two stops
@pytest.mark.fact("CY512-ABORT-1", "CY512-UND-ABORT")
@pytest.mark.parametrize("release", [False, True])
@both
def test_abort_ramps_down_and_stops_whether_it_is_released_or_not(release, stepwise):
    r = made(stepwise=stepwise)
    r.send("S 50\rN 40\r")
    moving(r, steps=10)
    r.drive("abort", 0)
    if release:
        r.bench.run("3 ms")
        r.drive("abort", 1)
    r.bench.run_until_idle("1 s")
    up = [63400 - 240 * each for each in range(1, 255, 50)]
    assert periods(r) == [*up, *[2200] * 4, *up[::-1]][:-1] and r.x.position == 16
    assert r.level("motion_complete") == 0 and r.x.motions()[-1].end.why == "stopped"
    r.drive("abort", 1)
    r.send("P 0\r")
    assert r.x.position == 0


@pytest.mark.fact("CY512-UND-ABORT")
@pytest.mark.parametrize(("steps", "made_in_all"), [(1, 1), (3, 5), (6, 11), (38, 40)])
@both
def test_abort_turns_round_where_the_motion_is(steps, made_in_all, stepwise):
    r = made(stepwise=stepwise)
    r.send("S 50\rN 40\r")
    moving(r, steps=steps)
    r.drive("abort", 0)
    r.bench.run_until_idle("1 s")
    assert r.x.position == made_in_all


@pytest.mark.fact("CY512-UND-ABORT")
@pytest.mark.parametrize("setup", ["S 0\rN 40\r", "S 5\rN 40\r"])
@both
def test_without_a_ramp_abort_stops_after_the_running_step(setup, stepwise):
    r = made(stepwise=stepwise)
    r.send(setup)
    moving(r, steps=10)
    r.drive("abort", 0)
    r.bench.run_until_idle("1 s")
    assert r.x.position == 10


@pytest.mark.fact("CY512-HS-3", "CY512-HS-4", "CY512-UND-ABORT-FIRST", "CY512-ABORT-1")
@both
def test_a_host_that_leaves_io_request_low_ends_its_motion_after_the_first_step(stepwise):
    r = made(stepwise=stepwise, record=("pulse", "io_request", "motion_complete", "ready"))
    r.send("N 1000\r")
    since = r.bench.now_ps

    async def slow(port):
        from slewline.core.wires.waits import level, until

        for byte in b"G\r":
            await level(port.ready, 1)
            port.bus.drive((0xFF, byte))
            port.request.drive(0)
            await level(port.ready, 0)
            if byte == 0x0D:
                await until(r.bench.kernel, r.bench.now_ps + 10**11)
            port.request.drive(1)
            port.bus.drive(None)

    r.host.do(slow)
    r.bench.run_until_idle("1 s")
    assert len(r.x.steps(since)) == 1 and r.x.position == 1
    assert r.codes == ([] if stepwise else ["software-abort"])
    low = r.falls("io_request", since)[1]
    assert low < r.falls("pulse", since)[0] < r.falls("motion_complete", since)[-1] < r.rises("io_request", since)[1]
    r.send("P 0\r")
    assert r.x.position == 0


@pytest.mark.fact("CY512-ABORT-1", "CY512-UND-ABORT")
@both
def test_io_request_low_at_the_end_of_a_step_stops_there_without_a_ramp(stepwise):
    r = made(stepwise=stepwise)
    r.send("S 50\rN 400\r")
    first = moving(r, steps=50)
    r.drive("io_request", 0)
    r.x.pin("io_request").release(at=first + us(100))
    r.bench.run_until(lambda: len(r.x.steps()) == 60)  # it was high again at the end of the step
    r.drive("io_request", 0)
    r.bench.run("2 ms")
    assert r.x.position == 60 and r.codes.count("software-abort") == (not stepwise)
    assert not r.x.moving


def test_the_two_rules_for_ending_a_motion_can_be_exchanged():
    r = made(inferred={"abort": "stop", "request": "ramp"})
    r.send("S 50\rN 40\r")
    moving(r, steps=10)
    r.drive("abort", 0)
    r.bench.run_until_idle("1 s")
    assert r.x.position == 10
    r.drive("abort", 1)
    r.send("A\r")
    moving(r, steps=10)
    r.drive("io_request", 0)
    r.bench.run("200 ms")
    r.x.pin("io_request").release()
    r.bench.run_until_idle("1 s")
    assert r.x.position == 16


# ----------------------------------------------------------------------------------------------------------------- pins
@pytest.mark.fact("CY512-PIN-5", "CY512-UND-PULSE")
@pytest.mark.parametrize("crystal", ["11 MHz", "6 MHz"])
@both
def test_pulse_is_high_for_96_clocks_between_steps(crystal, stepwise):
    r = made(stepwise=stepwise, crystal=crystal, record=("pulse",))
    r.send("N 3\rG\r")
    assert clocks(r, [at for at, _ in r.edges("pulse")]) == [2104, 96, 2104, 96, 2104]


@pytest.mark.fact("CY512-PIN-5", "CY512-INHIB-1")
@pytest.mark.parametrize("held", [1, 0])
@both
def test_an_inhibited_step_leaves_pulse_high_and_the_phases_unchanged(held, stepwise):
    r = made(stepwise=stepwise, record=("pulse", "phase1", "phase2"), inferred={"held_pulse": held})
    r.send("N 5\r")
    first = moving(r, steps=2)
    r.drive("step_inhibit", 1)
    r.bench.run("5 ms")
    assert r.level("pulse") == held and len(r.x.steps()) == 2
    assert not [at for pin in ("phase1", "phase2") for at, _ in r.edges(pin) if at > first]
    r.drive("step_inhibit", 0)
    r.bench.run_until_idle("1 s")
    assert r.x.position == 5 and r.codes == []


@pytest.mark.fact("CY512-PROG-4", "CY512-RAMP-5", "CY512-CON-CONTINUOUS")
@both
def test_in_motion_no_position_is_read_and_no_motion_is_endless(stepwise):
    r = made(stepwise=stepwise, record=("outstrobe", "pulse"))
    r.send("H\rN 50\r")
    moving(r, steps=3)
    r.x.pin("io_select").net.drivers[0].drive(1)
    r.bench.run("5 ms")
    assert len(r.x.steps()) > 20 and not r.edges("outstrobe")
    r.x.pin("io_select").net.drivers[0].drive(0)
    r.bench.run_until_idle("1 s")
    assert r.x.travel == 50


# --------------------------------------------------------------------------------------------------------------- family
@pytest.mark.fact("CY512-FAM-1", "CY512-FAM-2", "CY512-FAM-3")
def test_features_shared_with_the_cy500():
    from slewline.chips import sheet_of
    from slewline.chips.cy500.sheet import COMMANDS, PINS

    ours = sheet_of("cy512")
    alike = {row.form for row in COMMANDS if row.form in ours.commands.by_form and row.form not in "LJOP"}
    assert len(COMMANDS) == 22 and len(alike) == 18
    shared = {pin.name for pin in PINS} & {pin.name for pin in ours.pins}
    assert len(shared) >= 33
    assert ours.role("direction") and ours.through(BusHandshake).verify_bytes and ours.commands["L"].args[0].high == 256
    names = {pin.role for pin in ours.pins}
    assert not names & {"serial_in", "serial_out", "home"} and not ours.keeps


def test_a_motion_reports_its_parameters_and_its_ideal():
    r = made()
    r.send("S 10\rR 200\rN 100\rG\r")
    (motion,) = r.x.motions()
    assert dict(motion.rates) == {"R = 200": pytest.approx(CLOCK / 15400)}
    assert motion.ideal is not None and abs(r.x.deviation(motion).position) < 2
    assert [label for _, _, label in r.x.phases()] == ["up", "slew", "down"]
    found = slewline.ramp("cy512", R=200, S=10)
    assert found.steps == 20 and found.time_ps == pytest.approx(73.38e9, rel=1e-3)
