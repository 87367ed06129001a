"""Where a run of cycles must be thought over before it is over: what the fast path may not pass by."""

from __future__ import annotations

import pytest

import slewline

TOP = (1 << 30) - 1


def driven(stepwise: bool = False, **encoder):
    bench = slewline.Bench()
    x = bench.add("mc1151a-e", name="x", stepwise=stepwise)
    if encoder:
        bench.part("encoder", name="shaft", to=x, **encoder)
    bench.record("x.pulse1")
    return bench, x, bench.host(x)


def wrapped(stepwise: bool):
    """A move whose target is put to the upper end on the way, so that it wraps before it has turned back."""
    bench, x, host = driven(stepwise)
    for name, value in (("SET_VEL", 65535), ("SET_ACC", 5461), ("SET_POS", 84)):
        host.command(name, value)
    host.command("UPDATE")
    bench.run("8 ms")
    host.command("SET_ACTL_POS", TOP)
    bench.run("20 ms")
    return x.position, bench.edges("x.pulse1")[0].tolist(), x.pin("dir1").level


def test_a_target_that_wraps_is_on_the_other_side_of_its_destination():
    position, edges, direction = wrapped(stepwise=False)
    assert (position, edges, direction) == wrapped(stepwise=True)
    assert (
        -TOP - 1 <= position < -TOP + 100 and direction == 1 and len(edges) > 40
    )  # it goes on upwards, behind the end


@pytest.mark.fact("PMD-HOME-1")
@pytest.mark.parametrize("phase", range(0, 330, 30))
def test_a_stop_that_is_loaded_after_an_update_waits_for_the_next(phase):
    """The homing of the manual, from a host that reads no checksum, wherever in a cycle it begins."""
    bench, x, host = driven()
    for name, value in (("SET_POS", 12345), ("SET_VEL", 65536), ("SET_ACC", 345)):
        host.command(name, value)
    bench.run(f"{phase} us")
    for code in (0x1A, 0x5E, 0x46):  # update, set_ext_brk, stop
        host.packet(code, checksum=False)
    bench.run("100 ms")
    assert x.registers["trgt_vel"] == 65536
    x.pin("home1").drive(0)
    bench.run_until_idle()
    assert x.registers["status"] & 0x405 == 0x005 and 0 < x.position < 12345


@pytest.mark.fact("PMD-BUF-3")
@pytest.mark.parametrize("phase", range(0, 330, 30))
def test_registers_written_after_an_update_wait_for_the_next(phase):
    bench, x, host = driven()
    for name, value in (("SET_POS", 100), ("SET_VEL", 65536), ("SET_ACC", 65536)):
        host.command(name, value)
    bench.run(f"{phase} us")
    host.packet(0x1A, checksum=False)
    host.packet(0x10, 0, 500, checksum=False)
    bench.run_until_idle()
    assert (x.position, x.registers["pos"]) == (100, 500)


@pytest.mark.fact("PMD-CMD-SYNCH_PRFL-1", "PMD-UND-SYNCH-UNITS")
@pytest.mark.parametrize("stop", [False, True])
def test_a_synchronisation_in_motion_leaves_no_error(stop):
    bench, x, host = driven(counts=400, steps=400)
    host.command("SET_STEP_RATIO", 256)
    for name, value in (("SET_POS", 5000), ("SET_VEL", 15 * 65536), ("SET_ACC", 65536)):
        host.command(name, value)
    host.command("UPDATE")
    bench.run("30 ms")
    host.command("SYNCH_PRFL")
    if stop:
        host.command("STOP")
    host.command("UPDATE")
    bench.run_until_idle()
    bench.run("2 ms")
    assert abs(host.query("GET_ACTL_POS_ERR")) <= 1  # a step that has begun when the counts are read
    assert abs(x.registers["actl_pos"] - x.registers["trgt_pos"]) <= 1


def test_a_motion_that_is_certain_to_come_is_waited_for():
    bench, x, host = driven()
    for name, value in (("SET_POS", 100), ("SET_VEL", 65536), ("SET_ACC", 65536), ("SET_BRK_PNT", 1000)):
        host.command(name, value)
    host.command("SET_TIME_BRK")
    assert x.waiting.startswith("x: waiting for time 1000, the breakpoint of axis 1 since ")
    bench.run_until_idle()
    assert x.position == 100
    host.command("SET_POS", 30)
    host.command("SET_MTN_CMPLT_BRK")
    bench.run_until_idle()
    assert x.position == 30
