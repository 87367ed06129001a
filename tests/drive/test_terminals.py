"""What is wired to a board: drivers, rates, outputs; and which horizon a machine needs."""

from __future__ import annotations

from random import Random

import pytest

import slewline
from slewline.drive.board.boards import UNO
from slewline.drive.check import recommended_ms
from slewline.drive.terminals import ENABLE_OFF, driver_polarity, hold_of, outputs_of, steps_a_second
from slewline.errors import UnknownName, UsageError
from tests.ensembles import few

from .families import GSC
from .rig import TwinLine, check_of, drive_of

MOVERS = {  # part, options, text, and what makes it move 900 steps
    "cy525": ("cy525", {}, "A 0\rF 10\rR 120\rS 120\rZ 1\rN 900\r", "G\r"),
    "gs-c200s": ("gs-c200s", GSC, "I3\rPo\rS50\rT900\rR90\r+900\rPx\r", "E\r"),
    "cy545": ("cy545", {"rate_table": "27k", "fixed_baud": 9600}, "+\rF 10\rR 255\rS 200\rN 900\r", "G\r"),
    "mc1451a": ("mc1451a", {}, "SET_VEL 40000 steps/s\nSET_ACC 200000 steps/s2", "SET_POS %d\nUPDATE"),
}


def test_a_rate_is_in_steps_and_another_unit_is_named():
    assert steps_a_second("500 steps/s") == steps_a_second(500) == 500
    for rate, says in {
        "150 rpm": "rpm needs the motor's steps per revolution, which are not known here: write the rate in steps/s; ",
        "5 Nm": "Nm is a unit of torque; ",
        "500": "500 has no unit; ",
        "0 steps/s": "",
    }.items():
        with pytest.raises(UsageError) as error:
            steps_a_second(rate)
        assert str(error.value) == (
            f"rate {rate!r}: {says}expected steps per second with their unit, such as '500 steps/s'"
        )


def test_another_driver_is_not_offered_for_an_unknown_one():
    for name in ("TMC2208", "TMC2130", "DM556", "A4983"):
        with pytest.raises(UnknownName) as error:
            driver_polarity(UNO, name)
        assert "did you mean" not in str(error.value) and "for any other driver, leave it out" in str(error.value)


def test_a_driver_describes_how_it_is_enabled_and_its_required_pulses():
    assert driver_polarity(UNO, "DM542") == driver_polarity(UNO, "a4988") == 2  # ENABLE is active low
    assert driver_polarity(UNO, "L297") == driver_polarity(UNO, None) == 0
    with pytest.raises(UnknownName, match="did you mean DM542"):
        driver_polarity(UNO, "DM524")
    for short in ("high", "low", "setup", "hold"):  # 1 us, and a DM542 needs 2.5 and 5
        with pytest.raises(UsageError, match=r"driver DM542: .* for at least 1 µs, but the driver needs"):
            driver_polarity(UNO._replace(**{short: 16}), "DM542")


@pytest.mark.parametrize("enabled", ["halt", "rest", "never"])
def test_the_board_is_notified_when_the_driver_goes_off(enabled):
    bench = slewline.Bench()
    drive = drive_of(bench, bench.add("cy525", "x"), TwinLine(), enable_off=enabled, enable_hold="2 s")
    config = drive._state.config
    assert config.enable_off == ENABLE_OFF[enabled] and config.enable_hold == 488  # of 4.096 ms


@pytest.mark.parametrize(("hold", "counted"), [("0 s", 0), ("268 s", 65429), ("4096 us", 1), ("4095 us", 0)])
def test_a_hold_is_counted_in_65536_ticks(hold, counted):
    assert hold_of(UNO, hold) == counted


def test_requests_beyond_every_board_are_refused():
    bench = slewline.Bench()
    x = bench.add("cy525", "x")
    for options, told in (
        ({"enable_off": "always"}, "enable_off 'always'; allowed rest, halt, never"),
        ({"enable_hold": "269 s"}, "enable_hold '269 s'; allowed 0 s to 268 s"),
        ({"filter": 16}, "filter 16; expected 0 to 15"),
        ({"outputs": {"D2": "fault", "D3": "fault"}}, "D3: fault is assigned to output D2 already; leave one out"),
    ):
        with pytest.raises(UsageError, match=told):
            drive_of(bench, x, TwinLine(), **options)


def test_outputs_are_those_set_by_programs_or_wired():
    x = slewline.Bench().add("gs-c200s", "x")
    assert outputs_of(UNO, x, None) == {0: "uo1", 1: "uo2", 2: "uo3"}
    assert outputs_of(UNO, x, {"d12": "mov"}) == {3: "mov"}
    assert outputs_of(UNO, x, {"d12": "fault", "D8": "energised"}) == {3: "fault", 2: "energised"}
    with pytest.raises(UsageError, match="allowed D2, D3, D8, D12"):
        outputs_of(UNO, x, {"D4": "uo1"})


def test_a_horizon_is_three_times_the_lateness_and_twice_what_a_start_takes():
    assert [recommended_ms(late, 4) for late in (1, 10, 20, 60, 300)] == [20, 50, 100, 250, 1000]
    assert [recommended_ms(0, load) for load in (10, 10.1, 200, 201)] == [20, 50, 500, None]
    assert recommended_ms(700, 10) is None


@pytest.mark.parametrize("round_trip_ms", few([1, 5, 16, 31, 60], 3))
@pytest.mark.parametrize("moves", few([10, 100], 1))
@pytest.mark.parametrize("name", MOVERS)
def test_with_the_horizon_that_a_check_recommends_moves_are_made(name, round_trip_ms, moves):
    part, options, text, go = MOVERS[name]
    way = round_trip_ms * 10**6 // 2
    line = TwinLine(Random(round_trip_ms), latency_ns=(way * 9 // 10, way * 11 // 10))
    bench = slewline.Bench()
    x = bench.add(part, "x", **options)
    host = bench.host(x)
    host.send(text)
    with drive_of(bench, x, line, horizon="2 s") as drive:
        load_ms = check_of(drive).under_load()
        assert not line.twin.steps and line.twin.position == 0
    horizon = recommended_ms(0, load_ms)
    if round_trip_ms == 60:
        assert horizon is None, "such a link carries too little"
        return
    assert horizon <= 20 * round_trip_ms + 30
    bench = slewline.Bench()
    x = bench.add(part, "x", **options)
    host = bench.host(x)
    host.send(text)
    line = TwinLine(Random(round_trip_ms), latency_ns=(way * 9 // 10, way * 11 // 10))
    with drive_of(bench, x, line, horizon=f"{horizon} ms") as drive:
        drive.run("300 ms")
        for number in range(1, moves + 1):
            host.send(go % (900 * number) if "%" in go else go)
            drive.run("30 ms")  # characters take their time
            drive.run_until_rest("10 s")
        assert not drive.troubles and len(line.twin.steps) == 900 * moves == x.travel


def test_a_jog_is_ten_steps_up_and_ten_back_with_current():
    bench = slewline.Bench()
    line = TwinLine()
    with drive_of(bench, bench.add("cy525", "x"), line, enable=True, driver="A4988") as drive:
        assert check_of(drive).jog()
        assert [way for _, way, _ in line.twin.steps] == [1] * 10 + [-1] * 10 and line.twin.output & 16
        drive.run("100 ms")
        assert drive.state == "ok" and not drive.troubles and line.twin.position == 0
