"""The position read on the fly (s.6).  Clocks of 11 MHz."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

Make = Callable[..., Any]
SMALL = "F 10\rR 12\rS 245\rZ 10\r"  # one unit every 49,720 clocks
LOW, MID, TOP = 11_000, 10_000, 9167
UP = [LOW] * 5 + [MID] * 5
DOWN = UP[::-1]
US = 11


def longer(periods: list[int], step: int, clocks: int) -> list[int]:
    return [*periods[:step], periods[step] + clocks, *periods[step + 1 :]]


def read(x: Any, clock: int, until: int | None = None) -> None:
    """I/O SELECT high at a clock of the motion, for a good step or to another clock."""
    x.on(clock, "io_select", 1)
    x.on(clock + 11_500 if until is None else until, "io_select", 0)


@pytest.mark.fact("FLY-POS-2", "UND-FLY-POS-SAMPLE", "UND-MC-FLY", "CON-FLY-MC")
@pytest.mark.parametrize("position", [0x00FE, 0x00FF, 0xFFFE, 0xFFFF, 0x12FE])
def test_a_read_out_puts_both_bytes_of_one_position_on_the_bus(mover: Make, position: int) -> None:
    x = mover("outstrobe", "db", position=position, firstrate=10, rate=10, number=3)
    x.begin()
    read(x, 100)
    x.finish()
    b = LOW  # the second step: position + 2
    value = (position + 2) % 65536
    # high byte while MOTION COMPLETE is high, low byte while it is low, then high impedance
    assert x.changes("outstrobe") == [(b + 44, 0), (b + 55, 1), (b + 154, 0), (b + 165, 1)]
    assert x.changes("motion_complete") == [(b + 99, 0), (b + 209, 1), (3 * LOW, 0)]
    bus = [(b + 44, value >> 8), (b + 99, value & 0xFF), (b + 209, -1)]
    assert x.changes("db") == [
        edge for before, edge in zip([-1, *(level for _, level in bus)], bus, strict=False) if before != edge[1]
    ]
    assert 30 * US >= 209


@pytest.mark.fact("FLY-POS-1", "FLY-POS-6")
@pytest.mark.parametrize("straps", [{}, {"ascii_binary": 0}])
@pytest.mark.parametrize("continuous", [False, True])
def test_the_position_is_binary_in_both_modes_and_both_kinds_of_motion(
    rig: Make, straps: dict[str, int], continuous: bool
) -> None:
    x = rig(
        straps=straps, record=("outstrobe",), position=0xFFF0, number=2000, firstrate=20, rate=60, slope=250, divisor=1
    )
    x.host.send((b"H\x00G\x00" if continuous else b"G\x00") if straps else b"H\rG\r" if continuous else b"G\r")
    x.bench.run_until(x.x.pin("pulse").is_(0))
    read = [x.host.read_position() for _ in range(40)]
    strobes = x.falls("outstrobe")[::2]
    assert read == [x.x.position_at(strobe) for strobe in strobes]
    assert len(set(read)) == 40 and read[0] > 0xFFF0 and read[-1] < 0x100


@pytest.mark.fact("FLY-POS-3", "UND-FLY-POS-LATE")
def test_while_select_stays_high_every_step_is_read_out(mover: Make) -> None:
    x = mover("outstrobe", "db", number=30, firstrate=10, rate=10, position=0x1234)
    x.begin()
    read(x, 5 * LOW - 1, 15 * LOW - 1)
    x.finish()
    falls = [clock for clock, level in x.changes("outstrobe") if level == 0]
    assert falls == [k * LOW + late for k in range(5, 15) for late in (44, 154)]
    assert [level for _, level in x.changes("db") if level != -1] == [
        byte for k in range(5, 15) for byte in (0x12, 0x35 + k)
    ]


@pytest.mark.fact("FLY-POS-3")
def test_select_low_within_50_us_is_exactly_one_read_out(mover: Make) -> None:
    x = mover("outstrobe", number=30, firstrate=127, rate=127)  # steps of 103 us
    x.begin()
    read(x, 5 * 1137 - 1, 5 * 1137 + 209 + 50 * US)
    x.finish()
    assert len(x.changes("outstrobe")) == 4


@pytest.mark.fact("FLY-POS-4", "UND-FLY-POS-CRAWL", "UND-RAMP-TIME")
@pytest.mark.parametrize("crystal", ["11 MHz", "6 MHz"])
@pytest.mark.parametrize(
    ("number", "step", "clocks"),
    [
        (276, 1, 220),
        (276, 9, 220),
        (276, 10, 0),
        (276, 100, 0),
        (276, 265, 0),
        (276, 266, 220),
        (276, 275, 220),
        (70, 30, 0),
    ],
)
def test_a_read_out_lengthens_a_step_by_20_us_in_the_ramps_only(
    mover: Make, crystal: str, number: int, step: int, clocks: int
) -> None:
    # 220 clocks are 20 us at 11 MHz and 36.7 us at 6 MHz; neither slewing nor the steps at F after the ramp are ramps
    plain = UP + [TOP] * 256 + DOWN if number == 276 else UP + DOWN + [LOW] * 50
    x = mover(crystal=crystal)
    x.send(f"{SMALL}N {number}\r")
    x.begin()
    begin = sum(plain[:step])
    read(x, begin - 100, begin + 300)
    x.finish()
    assert x.periods() == longer(plain, step, clocks)  # and the 20 us are no ramp time: the rest is as it was
    if clocks:
        ps = x.x.clock.ps(x.origin + begin + clocks) - x.x.clock.ps(x.origin + begin)
        assert ps == pytest.approx(20_000_000 if crystal == "11 MHz" else 36_666_667, abs=1)


@pytest.mark.fact("FLY-POS-4", "UND-RAMP-TIME")
def test_read_outs_of_every_step_lengthen_both_ramps_and_nothing_else(mover: Make) -> None:
    x = mover(number=276)
    x.send(SMALL)
    x.begin()
    read(x, 100, 276 * LOW)
    x.finish()
    assert x.periods() == [LOW, *(period + 220 for period in UP[1:]), *[TOP] * 256, *(period + 220 for period in DOWN)]


@pytest.mark.fact("UND-FLY-POS-BOTH")
def test_a_rate_request_goes_before_a_read_out(mover: Make) -> None:
    x = mover("outstrobe", "instrobe")
    look = x.endless(SMALL) + 10 * TOP
    x.request(look - 500, 13, look + 200)
    read(x, look - 500, look + 400)
    x.till(look + 100_000)
    assert x.changes("outstrobe") == []
    assert x.changes("instrobe") == [(look, 0), (look + US, 1)]
    assert x.changes("slew")[1][0] == look
    assert x.codes.count("request-and-select") == 1


@pytest.mark.fact("UND-FLY-POS-SAMPLE")
@pytest.mark.parametrize(
    ("rises", "falls", "step"), [(-1, 0, 5), (-1, 1, 5), (0, 1, None), (0, LOW + 1, 6), (1, LOW - 1, None)]
)
def test_select_is_sampled_as_a_step_begins(mover: Make, rises: int, falls: int, step: int | None) -> None:
    x = mover("outstrobe", number=30, firstrate=10, rate=10)
    x.begin()
    x.on(5 * LOW + rises, "io_select", 1)
    x.on(5 * LOW + falls, "io_select", 0)
    x.finish()
    strobes = [clock for clock, level in x.changes("outstrobe") if level == 0]
    assert strobes == ([] if step is None else [step * LOW + 44, step * LOW + 154])


@pytest.mark.fact("UND-FLY-POS-LATE")
def test_select_still_high_when_the_motion_ends_leads_to_verify_bytes(mover: Make) -> None:
    x = mover("outstrobe", number=3, firstrate=10, rate=10)
    x.send("V 3\r")
    x.begin()
    x.on(LOW // 2, "io_select", 1)
    x.finish()
    assert len([level for _, level in x.changes("outstrobe") if level == 0]) == 4  # the second and third step
    assert x.fetch(6) == bytes([0, 3, 255, 10, 10, 1])


@pytest.mark.fact("UND-FLY-POS-IDLE")
def test_a_read_out_requested_during_a_hold_is_answered_by_the_next_step(mover: Make) -> None:
    x = mover("outstrobe", number=5, firstrate=10, rate=10)
    x.begin()
    rise = 2 * LOW - 28
    x.on(rise - 100, "step_inhibit", 1)
    x.on(rise + 50_000, "io_select", 1)
    x.till(rise + 200_000)
    assert x.changes("outstrobe") == []
    x.on(rise + 200_000, "step_inhibit", 0)
    x.on(rise + 200_000 + 2000, "io_select", 0)
    x.finish()
    third = x.begins()[2]
    assert [clock for clock, level in x.changes("outstrobe") if level == 0] == [third + 44, third + 154]


@pytest.mark.fact("UND-FLY-POS-IDLE")
def test_an_inhibited_step_is_read_out_once(mover: Make) -> None:
    x = mover("outstrobe", number=5, firstrate=10, rate=10)
    x.begin()
    x.on(LOW - 100, "io_select", 1)
    x.on(LOW + 500, "step_inhibit", 1)
    x.till(20 * LOW)
    assert [clock for clock, level in x.changes("outstrobe") if level == 0] == [LOW + 44, LOW + 154]


@pytest.mark.fact("UND-FLY-POS-IDLE")
def test_at_the_zero_rate_nothing_is_read_out(mover: Make) -> None:
    x = mover("outstrobe")
    look = x.endless(SMALL) + 10 * TOP
    x.request(look - 500, 0)
    x.till(look + 50_000)
    x.on(look + 60_000, "io_select", 1)
    x.till(look + 1_000_000)
    assert x.changes("outstrobe") == []
    x.request(look + 1_000_000, 13, look + 1_000_500)
    x.till(look + 1_005_000)
    begin = x.begins()[20]
    assert x.changes("outstrobe") == []  # the request was still low as this step began
    x.on(begin + TOP + 2000, "io_select", 0)
    x.till(look + 1_100_000)
    falls = [clock for clock, level in x.changes("outstrobe") if level == 0]
    assert falls == [begin + TOP + 44, begin + TOP + 154]
