"""Reset of the MC1451A family, by command, by pin and by the supply: what is left behind it, and when it is over."""

from __future__ import annotations

import pytest
from mc import AXES, NS, READY, T1, US, base, each, with_encoder
from mc_motion import Mover, mover

RESET, GET_STATUS, SLICE, BUSY_CYCLES = 0x39, 0x31, 2048, 10
WORDS = {  # what everything reads behind a reset, axis by axis
    "1d > 0000 0000 001d": "target position",
    "1e > 0000 0000 001e": "target velocity",
    "37 > 0000 0000 0037": "actual position",
    "60 > 0000 0060": "position error",
    "36 > 0000 0000 0036": "captured position",
    "4a > 0000 0000 004a": "destination",
    "4b > 0000 0000 004b": "velocity",
    "4c > 0000 0000 004c": "acceleration",
    "4f > 0000 004f": "acceleration of the S-curve",
    "58 > 0000 0000 0058": "jerk",
    "59 > 0000 0000 0059": "gear ratio",
    "6b > 0000 0000 006b": "start velocity",
    "57 > 0000 0000 0057": "comparison value",
    "56 > 0000 0056": "interrupt mask",
    "48 > 0000 0048": "trapezoidal, auto update on, auto stop off, standard range",
    "6f > 0000 006f": "step ratio",
    "55 > 7fff 8054": "limit of the position error",
}


SETTINGS = (
    *("SET_POS 3", "SET_VEL 65536", "SET_ACC -1024", "SET_RATIO 7", "SET_MAX_ACC 8", "SET_JERK 9", "SET_START_VEL 10"),
    *("SET_STEP_RATIO 11", "SET_POS_ERR 12345", "SET_INTRPT_MASK 1", "SET_BRK_PNT -500", "SET_NEG_BRK"),
    *(
        "SET_OUTPUT_HIGH",
        "SET_AUTO_STOP_ON",
        "SET_AUTO_UPDATE_OFF",
        "SET_CAPT_HOME",
        "SET_PRFL_VEL",
        "SET_ACTL_POS 100",
    ),
)


def used(part: str, *record: str) -> Mover:
    """A chipset in which nothing is as behind its reset: axis 1 goes backwards, and the last one is current."""
    rig = mover(part, *record)
    axes = range(1, AXES[part] + 1)
    for axis in axes:
        rig.do(*SETTINGS, "STOP", "UPDATE", axis=axis)
        rig.next(2)
        rig.begin(axis=axis)
    rig.next(70)
    assert rig.look().vel == -65536 and rig.level("dir1") == rig.level("hostintrpt") == 0
    rig.do("LMTS_OFF", f"SET_LMT_SENSE {(1 << 2 * AXES[part]) - 1}")
    for axis in axes:
        rig.do("STOP", "SMOOTH_STOP", "SYNCH_PRFL", *(["MTR_OFF"] if axis > 1 else []), axis=axis)
    return rig


def reset(rig: Mover, way: str) -> None:
    """Reset it; ends with the rising edge of HostRdy."""
    if way == "command":
        rig.do("RESET")
    elif way == "pin":
        rig.x.reset()
    else:
        rig.x.power(False)
        rig.bench.run("1 ms")
        rig.x.power(True)
    rig.bench.run("2 us")
    rig.bench.run_until(rig.x.pin("hostrdy").is_(1))


every_way = pytest.mark.parametrize("way", ["command", "pin", "supply"])


# ------------------------------------------------------------------------------------------------- what is left behind
@each
@every_way
@pytest.mark.fact("PMD-RESET-1", "PMD-RESET-2", "PMD-RESET-3", "PMD-RESET-4", "PMD-RESET-5", "PMD-RESET-9")
@pytest.mark.fact("PMD-RESET-10", "PMD-RESET-11", "PMD-RESET-12", "PMD-RESET-14", "PMD-CMD-RESET-1")
@pytest.mark.fact("PMD-UND-POSERR-DEFAULT", "PMD-UND-AUTOSTOP-DEFAULT")
def test_every_register_of_every_axis_is_as_at_the_beginning(part: str, way: str) -> None:
    rig = used(part)
    reset(rig, way)
    rig.says("31 > 0300 0331")  # axis 1 is the current one
    for axis in range(1, AXES[part] + 1):
        status = 0x0300 | axis - 1 << 12
        rig.says(f"{axis:02x} > {status:04x} {status + axis:04x}", *WORDS)
        assert rig.x.axis(axis).position == 0
    assert rig.level("hostintrpt") == 1
    assert rig.x.registers == base(part).x.registers | {"time": rig.x.registers["time"]}


@each
@every_way
@pytest.mark.fact("PMD-RESET-6", "PMD-RESET-8", "PMD-RESET-14", "PMD-UND-BRK-RESET")
def test_nothing_that_was_armed_or_loaded_is_left(part: str, way: str) -> None:
    rig = used(part, "pulse1")
    reset(rig, way)
    since = rig.bench.now_ps
    rig.next(10_000)
    assert rig.edges("pulse1", since) == []
    assert [rig.look(axis).status & 0xFFF for axis in range(1, AXES[part] + 1)] == [0x300] * AXES[part]
    rig.begin("SET_VEL 65536", "SET_ACC 65536", "SET_POS 10")  # no stop is left, either
    rig.rest()
    assert rig.x.position == 10


@each
@every_way
@pytest.mark.fact("PMD-RESET-7", "PMD-RESET-14")
def test_limits_are_sensed_active_high(part: str, way: str) -> None:
    rig = used(part)
    reset(rig, way)
    axes = range(1, AXES[part] + 1)
    rig.next(2)
    assert [rig.status(axis) & 0xFF for axis in axes] == [0] * AXES[part]
    for axis in axes:
        rig.drive(f"poslimit{axis}", 1)
    rig.next(2)
    assert [rig.status(axis) & 0xFF for axis in axes] == [0x21] * AXES[part]
    assert rig.status(1) == 0x0321


# ---------------------------------------------------------------------------------------------------------- when, pins
@each
@pytest.mark.fact("PMD-RESET-16", "PMD-UND-READY-RESET", "PMD-UND-COMMAND-LATENCY")
def test_hostrdy_is_low_for_ten_cycles_after_the_command(part: str) -> None:
    rig = mover(part, "hostrdy")
    rig.host.write_command(RESET)
    taken = rig.falls("hostrdy")[-1]
    rig.bench.run_until(rig.x.pin("hostrdy").is_(1))
    clocks = rig.x.clock.ticks_until(rig.bench.now_ps) - rig.x.clock.ticks_until(taken)
    assert clocks == SLICE + BUSY_CYCLES * 8192
    assert (rig.falls("hostrdy")[-1], rig.rises("hostrdy")[-1]) == (taken, rig.bench.now_ps)
    assert rig.host.read_word() == 0  # there is no checksum


@each
@pytest.mark.fact("PMD-CMD-RESET-2")
def test_a_host_continues_without_a_checksum(part: str) -> None:
    rig = mover(part)
    rig.host.write_command(RESET)
    rig.says({1: "6c > 4411 447d", 2: "6c > 4c11 4c7d", 4: "6c > 5c11 5c7d"}[AXES[part]])
    assert rig.codes == []


@each
@pytest.mark.fact("PMD-RESET-16", "PMD-RESET-14", "PMD-UND-READY-RESET")
def test_hostrdy_is_low_for_ten_cycles_after_the_pin(part: str) -> None:
    rig = mover(part, "hostrdy")
    start = rig.bench.now_ps + 100 * US
    rig.drive("reset", 0, at=start)
    rig.drive("reset", 1, at=start + 1 * US)
    rig.bench.run("1 s")
    assert rig.edges("hostrdy", start) == [(start, 0), (start + 1 * US + BUSY_CYCLES * 8192 * 40 * NS, 1)]
    assert rig.codes == []


@each
def test_commands_requested_before_a_reset_are_not_done_after_it(part: str) -> None:
    rig = mover(part, "hostrdy")
    rig.host.write_command(GET_STATUS)
    start = rig.bench.now_ps + 1 * US
    rig.drive("reset", 0, at=start)
    rig.drive("reset", 1, at=start + 1 * US)
    rig.bench.run("1 s")
    assert rig.edges("hostrdy", start) == [(start + 1 * US + BUSY_CYCLES * 8192 * 40 * NS, 1)]


@each
@pytest.mark.fact("PMD-RESET-14")
def test_a_shorter_reset_is_found(part: str) -> None:
    rig = mover(part)
    rig.x.pin("reset").pulse(0, "900 ns")
    rig.bench.run("5 ms")
    assert rig.codes == ["short-reset"]


@each
@every_way
@pytest.mark.fact("PMD-RESET-13", "PMD-UND-TIME-START")
def test_the_time_is_0_in_the_first_cycle_and_counts_while_the_port_is_busy(part: str, way: str) -> None:
    rig = mover(part)
    rig.next(100)
    reset(rig, way)
    assert rig.cycle == READY
    assert rig.do("GET_TIME") == BUSY_CYCLES
    rig.bench.run_to(rig.at(0) + 10**12)
    assert rig.shows("time") == 3051  # 3051.76 cycles in a second
    rig.x.reset()
    rig.bench.run("1 us")
    for cycle in range(12):
        for tick in (0, 8191):
            rig.to(cycle, tick)
            assert rig.shows("time") == cycle
            assert rig.level("hostrdy") == (cycle >= BUSY_CYCLES)


@each
@pytest.mark.fact("PMD-RESET-18")
def test_levels_after_a_reset(part: str) -> None:
    rig = used(part)
    rig.host.write_command(0x31)
    rig.bench.run_until(rig.x.pin("hostrdy").is_(1))
    for pin, level in (("hostslct", 0), ("hostcmd", 0), ("hostread", 0)):
        rig.drive(pin, level)
    rig.bench.run("1 us")
    assert rig.x.bus.byte == rig.shows("status", AXES[part]) >> 8  # the chipset drives the bus
    rig.x.reset()
    rig.bench.run("1 us")
    for axis in range(1, AXES[part] + 1):
        assert [rig.level(f"{pin}{axis}") for pin in ("pulse", "dir", "atrest")] == [0, 1, 1]
    assert (rig.level("hostrdy"), rig.level("hostintrpt"), rig.x.bus.level) == (0, 1, None)


@each
@pytest.mark.parametrize("tick", [100, 2000, 4096 + 100, 8000])
@pytest.mark.fact("PMD-RESET-15")
def test_a_reset_in_motion_ends_all_pulses(part: str, tick: int) -> None:
    rig = mover(part, "pulse1", "dir1", "hostrdy")
    n = rig.begin("SET_PRFL_VEL", "SET_VEL 65536", "SET_ACC -1024")
    rig.to(n + 100, tick)
    before = rig.bench.now_ps
    rig.host.write_command(RESET)
    rig.bench.run("100 ms")
    acts = rig.falls("hostrdy", before)[0] + SLICE * 40 * NS
    assert [time for time in rig.falls("pulse1", before) if time > acts] == []
    assert [time for time in rig.rises("pulse1", before) if time >= acts] == []
    assert rig.rises("dir1", before) == [acts]
    assert rig.pulses(acts) == [] and rig.x.position == 0


@each
@pytest.mark.fact("PMD-RESET-15", "PMD-RESET-14")
def test_the_pin_ends_them_immediately(part: str) -> None:
    rig = mover(part, "pulse1")
    n = rig.begin(*T1)
    fall = rig.at(n + 100, 1234)
    rig.drive("reset", 0, at=fall)
    rig.to(n + 300)
    assert [edge for edge in rig.edges("pulse1", fall) if edge[0] > fall] == []
    assert rig.level("atrest1") == 1 and rig.level("pulse1") == 0
    rig.drive("reset", 1)
    rig.bench.run("1 s")
    assert [edge for edge in rig.edges("pulse1", fall) if edge[0] > fall] == [] and rig.x.position == 0


# ---------------------------------------------------------------------------------------------------------- a start-up
@pytest.mark.parametrize("part", ["mc1251a-e", "mc1451a-e"])
@pytest.mark.fact("PMD-RESET-17")
def test_the_start_up_of_drivers_passes_with_every_checksum(part: str) -> None:
    rig = mover(part)
    rig.x.reset()
    rig.bench.run("100 ms")
    rig.host.write_command(RESET)
    rig.bench.run("100 ms")
    rig.says(*(["6c > 4c11 4c7d"] if AXES[part] == 2 else ["6c > 5c11 5c7d"]), "66 0000 > 0066")
    for axis in range(1, AXES[part] + 1):
        status = 0x0300 | axis - 1 << 12
        rig.says(f"{axis:02x} > {status:04x} {status + axis:04x}", "33 > 0033", "5d > 005d")
        rig.says("68 0050 > 00b8", "29 03e8 > 0411", "45 > 0045", "48 > 0480 04c8")
    assert rig.codes == []


@with_encoder
@pytest.mark.parametrize("counts", [4, 5, 6, 7])
@pytest.mark.fact("PMD-RESET-1", "PMD-RESET-10", "PMD-ENC-2")
def test_counts_restart_with_a_reset_at_any_position_of_the_shaft(part: str, counts: int) -> None:
    rig = mover(part, quadrature={})
    rig.do("SET_STEP_RATIO 0x100")
    rig.shafts["quadrature"].push(counts)
    rig.next()
    rig.says(f"37 > 0000 {counts:04x} {0x37 + counts:04x}", f"60 > {counts:04x} {0x60 + counts:04x}")
    reset(rig, "command")
    rig.says("37 > 0000 0000 0037", "60 > 0000 0060")
    rig.shafts["quadrature"].push(3)
    rig.next()
    rig.says("37 > 0000 0003 003a", "60 > 0003 0063")
    assert rig.codes == []
