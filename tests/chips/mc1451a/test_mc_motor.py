"""What an update may start is decided by the motor as it is commanded, in whichever cycle it is worked.

motor     ‾‾‾\\_________________/‾‾‾‾‾‾‾‾‾‾      off by MTR_OFF or by a stall
commands            UPDATE                       starts nothing, even if the motor is on again in the next cycle
cycles    |              |              |
"""

from __future__ import annotations

from collections.abc import Callable

import pytest
from mc import ONE, Rig
from mc_motion import mover

from slewline.bench.scripts.script import run_script
from tests.ensembles import few

PHASES = 100
FAST = ("SET_OUTPUT_HIGH", f"SET_VEL {4 * ONE}", f"SET_ACC {4 * ONE}")  # four steps in a cycle, from the first on
RECOVERY = ("SYNCH_PRFL", "UPDATE", "MTR_ON")
CODES = {"SYNCH_PRFL": 0x47, "UPDATE": 0x1A, "MTR_ON": 0x43, "MTR_OFF": 0x42, "SET_PRFL_GEAR": 0x0C}

Way = Callable[[Rig, tuple[str, ...]], object]


def calls(rig: Rig, commands: tuple[str, ...]) -> None:
    """One after the other, checksums read."""
    rig.do(*commands)


def unread(rig: Rig, commands: tuple[str, ...]) -> None:
    """As fast as HostRdy lets them: four in a cycle."""
    for command in commands:
        if command.startswith("MULTI"):
            rig.host.packet(0x5B, 1, checksum=False)
        else:
            rig.host.packet(CODES[command], checksum=False)


def script(rig: Rig, commands: tuple[str, ...]) -> None:
    """Played by the host."""
    run_script(rig.bench, rig.host, "\n".join(commands))
    rig.bench.run("1200 us")


ways = pytest.mark.parametrize("way", [calls, unread, script])
both = pytest.mark.parametrize("stepwise", [False, True], ids=["fast", "stepwise"])


def at_rest(rig: Rig, cycles: int = 4) -> bool:
    """Is the axis at rest now, and does it stay there?"""
    rig.next(3)
    before = rig.x.travel
    rig.next(cycles)
    return rig.x.travel == before and not rig.shows("status") & 0x400 and rig.shows("trgt_vel") == 0


def phases(number: int = PHASES) -> list[int]:
    """Clocks in a cycle at which a host may begin."""
    return [8192 * n // number for n in range(number)]


@both
@ways
@pytest.mark.parametrize("number", few([25, 100], 1))
@pytest.mark.fact("PMD-STALL-9", "PMD-PULSE-10", "PMD-UND-MTR-OFF-UPDATE")
def test_the_recovery_from_a_stall_leaves_the_axis_at_rest_whenever_it_begins(
    way: Way, stepwise: bool, number: int
) -> None:
    rig = mover("mc1151a-e", options={"stepwise": stepwise})
    rig.do("SET_STEP_RATIO 256", "SET_POS_ERR 8", "SET_AUTO_STOP_ON", *FAST, "SET_POS 100000")
    for phase in phases(number):
        rig.begin()  # nothing turns the encoder: three cycles later the motor is off
        rig.next(4)
        assert rig.shows("status") & 0x510 == 0x010 and rig.shows("actl_pos_err") < -8
        rig.to(rig.cycle + 1, phase)
        way(rig, RECOVERY)
        assert at_rest(rig), f"begun {phase} clocks into a cycle"
        assert rig.shows("actl_pos_err") == 0 and rig.shows("trgt_pos") == 0 and rig.shows("status") & 0x100
        rig.do("CLR_STATUS")


@pytest.mark.fact("PMD-STALL-9", "PMD-UND-STALL-CLEAR")
def test_with_checksums_read_a_packet_between_update_and_clr_status_is_enough() -> None:
    rig = mover("mc1151a-e")
    rig.do("SET_STEP_RATIO 256", "SET_POS_ERR 8", "SET_AUTO_STOP_ON", *FAST, "SET_POS 100000")
    for phase in phases():
        rig.begin()
        rig.next(4)
        rig.to(rig.cycle + 1, phase)
        rig.do(*RECOVERY, "CLR_STATUS")
        assert rig.status() == 0x300, f"begun {phase} clocks into a cycle"


@both
@ways
@pytest.mark.fact("PMD-PULSE-10", "PMD-UND-MTR-OFF-UPDATE")
@pytest.mark.parametrize(
    "commands",
    [
        ("MTR_OFF", "UPDATE", "MTR_ON"),
        ("MTR_OFF", "MULTI_UPDATE 1", "MTR_ON"),
        ("UPDATE", "MTR_OFF", "MTR_ON"),
        ("MULTI_UPDATE 1", "MTR_OFF", "MTR_ON"),
    ],
    ids=" ".join,
)
def test_an_update_in_front_of_motor_on_starts_nothing(way: Way, stepwise: bool, commands: tuple[str, ...]) -> None:
    rig = mover("mc1151a", options={"stepwise": stepwise})
    rig.do(*FAST, "SET_POS 100000")
    for phase in phases(25):
        rig.to(rig.cycle + 1, phase)
        way(rig, commands)
        assert at_rest(rig), f"begun {phase} clocks into a cycle"
        assert rig.shows("status") == 0x300


@both
@pytest.mark.fact("PMD-PULSE-10", "PMD-UND-MTR-OFF-UPDATE")
def test_an_update_after_motor_on_starts_the_move_in_whichever_cycle(stepwise: bool) -> None:
    rig = mover("mc1151a", options={"stepwise": stepwise})
    rig.do(*FAST)
    for n, phase in enumerate(phases(25)):
        rig.do(f"SET_POS {20 * (n + 1)}")
        rig.to(rig.cycle + 1, phase)
        unread(rig, ("MTR_OFF", "UPDATE", "MTR_ON", "UPDATE"))
        rig.rest()
        assert rig.shows("trgt_pos") == 20 * (n + 1), f"begun {phase} clocks into a cycle"


@both
@pytest.mark.fact("PMD-UND-MTR-OFF-UPDATE")
@pytest.mark.parametrize(("on", "moves"), [(5, False), (8, True)])
def test_a_breakpoint_that_is_met_while_the_motor_is_off_starts_nothing(stepwise: bool, on: int, moves: bool) -> None:
    rig = mover("mc1151a", options={"stepwise": stepwise})
    met = rig.cycle + 30  # its update is worked a cycle later
    rig.do(*FAST, "SET_POS 20", f"SET_BRK_PNT {met}", "SET_TIME_BRK")
    rig.to(met - 3 if moves else met - 1)
    rig.do("MTR_OFF")
    rig.heeds(met - 1 if moves else met + 1, "MTR_ON")
    rig.next(on)
    rig.rest()
    assert rig.shows("trgt_pos") == (20 if moves else 0) and rig.status() & 4


@both
@pytest.mark.fact("PMD-UND-MTR-OFF-UPDATE", "PMD-UND-GEAR-ENTRY")
@pytest.mark.parametrize(
    "commands",
    [
        ("MTR_OFF", "SET_PRFL_GEAR", "MTR_ON"),
        ("SET_PRFL_GEAR", "MTR_OFF", "MTR_ON"),
        ("MTR_OFF", "MTR_ON", "SET_PRFL_GEAR"),
        ("MTR_OFF", "UPDATE", "MTR_ON", "SET_PRFL_GEAR"),
    ],
    ids=" ".join,
)
def test_a_gear_follows_after_motor_on_with_an_update(stepwise: bool, commands: tuple[str, ...]) -> None:
    rig = mover("mc1151a-e", options={"stepwise": stepwise}, quadrature={})
    shaft = rig.shafts["quadrature"]
    rig.begin("SET_OUTPUT_HIGH", f"SET_RATIO {ONE}")
    for phase in phases(10):
        rig.to(rig.cycle + 1, phase)
        unread(rig, commands)
        rig.next(2)
        before = rig.x.travel
        shaft.push(3)
        rig.next(4)
        assert rig.x.travel == before, f"begun {phase} clocks into a cycle"
        rig.begin()
        shaft.push(3)
        rig.next(4)
        assert rig.x.travel == before + 3
        rig.do("SET_PRFL_TRAP", f"SET_POS {rig.shows('trgt_pos')}")
        rig.next()
