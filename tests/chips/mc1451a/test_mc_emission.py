"""What the MC1451A family puts out at PULSE and DIR of what its trajectories do, and how fast it can.

PULSE rises half a step behind the last step and falls, which is the next step, where the target passes a whole one; the
target moves evenly within a cycle of 8192 clocks.
"""

from __future__ import annotations

from random import Random

import pytest
from mc import ONE, each
from mc_motion import Mover, mover

from tests.ensembles import few


def pulsed(speeds: list[int]) -> list[tuple[int, int]]:
    """Edges of PULSE, in clocks, for the displacements of successive cycles, from 0 and low on."""
    edges, place, made, high = [], 0, 0, False
    for cycle, speed in enumerate(speeds):
        way = 1 if speed > 0 else -1
        while speed:
            missing = way * (made - place) + (ONE if high else ONE // 2)
            if missing > abs(speed):
                break
            if high:
                made += way * ONE
            high = not high
            edges.append((cycle * 8192 - (-max(missing, 0) * 8192 // abs(speed)), int(high)))
        place += speed
    return edges


def ticks(rig: Mover, pin: str, cycle: int) -> list[tuple[int, int]]:
    """Edges of a recorded pin, in clocks since a cycle began."""
    clock, begun = rig.x.clock, rig.x._cycle_clock.origin + 8192 * cycle
    return [(clock.ticks_until(time) - begun, level) for time, level in rig.edges(pin, rig.at(cycle) + 1)]


# ------------------------------------------------------------------------------------------------------------ the edges
@pytest.mark.fact("PMD-UND-PULSE-PHASE")
@pytest.mark.parametrize("speed", [0x10000, 0x5555, 0x4001, 0x2C000, 0xFFFFF, 16 * ONE])
def test_at_any_speed_the_edges_of_pulse_are_where_half_and_whole_steps_are_passed(speed: int) -> None:
    rig = mover("mc1151a", "pulse1")
    begun = rig.begin("SET_PRFL_VEL", f"SET_VEL {speed}", f"SET_ACC {speed}")
    rig.to(begun + 40)
    assert ticks(rig, "pulse1", begun) == pulsed([speed] * 40)


@pytest.mark.fact("PMD-UND-PULSE-PHASE", "PMD-UND-DIR-TIMING", "PMD-UND-FRACTION")
@pytest.mark.parametrize("seed", range(5))
def test_pulse_and_direction_follow_the_target_through_stops_and_turns(seed: int) -> None:
    rnd = Random(seed)
    rig = mover("mc1151a", "pulse1", "dir1")
    first = rig.begin("SET_PRFL_VEL", "SET_VEL 0x10000", "SET_ACC 0x3000")
    for _ in range(25):
        changes = ("SET_ACC 0x2345", "SET_ACC -0x3000", "SET_ACC -0x1001", "STOP", "SET_VEL 0x18000")
        rig.heeds(rig.cycle + rnd.randrange(3, 10), rnd.choice(changes), "UPDATE")
    speeds = rig.x.axis(1).cycles(rig.at(first)).velocities[:-1].tolist()
    assert ticks(rig, "pulse1", first) == pulsed(speeds)
    turns, way = [], 1
    for cycle, speed in enumerate(speeds):
        if speed * way < 0:
            way = -way
            turns.append((cycle * 8192, int(way > 0)))
    assert ticks(rig, "dir1", first) == turns and turns


@each
@pytest.mark.fact("PMD-UND-PULSE-IDLE", "PMD-UND-DIR-IDLE")
def test_after_a_reset_pulse_is_low_and_dir_high_and_both_keep_their_levels_at_rest(part: str) -> None:
    rig = mover(part)
    for axis in range(1, len(rig.x.axes) + 1):
        pins = f"pulse{axis}", f"dir{axis}"
        assert [rig.level(pin) for pin in pins] == [0, 1]
        rig.do(f"SET_{axis}")
        for place, way in ((3, 1), (-3, 0), (-2, 1), (-4, 0)):
            rig.begin("SET_VEL 0x10000", "SET_ACC 0x10000", f"SET_POS {place}")
            rig.next(20)
            assert [rig.level(pin) for pin in pins] == [0, way]
    rig.x.reset()
    rig.next(20)
    assert [rig.level(pin) for pin in ("pulse1", "dir1")] == [0, 1]


@pytest.mark.fact("PMD-PULSE-4")
@pytest.mark.parametrize("seed", few(range(4), 2))
def test_steps_are_the_change_of_the_target(seed: int) -> None:
    rnd = Random(seed)
    rig = mover("mc1151a", "pulse1", "dir1")
    rig.do("SET_VEL 0x28000", "SET_ACC 0x9000", "SET_MAX_ACC 0x7000", "SET_JERK 0x40000000")
    for _ in range(50):
        place = rnd.randrange(-30, 31)
        rig.begin(rnd.choice(("SET_PRFL_TRAP", "SET_PRFL_S_CRV")), f"SET_POS {place}")
        if rnd.random() < 0.5:
            rig.next(rnd.randrange(8))
            rig.begin(rnd.choice(("STOP", "SMOOTH_STOP")))
            assert abs(rig.x.position - rig.shows("trgt_pos")) <= 1
            rig.rest()
            rig.begin()
        rig.rest()
        assert rig.x.position == rig.shows("trgt_pos") == place
    made, way = 0, 1
    edges = [(time, name, level) for name in ("dir1", "pulse1") for time, level in rig.edges(name)]
    for _, pin, level in sorted(edges):
        if pin == "dir1":
            way = 1 if level else -1
        elif level == 0:
            made += way
    assert made == place


# ------------------------------------------------------------------------------------------------------ the pulse range
@pytest.mark.fact("PMD-PULSE-8", "PMD-UND-PULSE-CLAMP")
@pytest.mark.parametrize(
    "setup",
    [
        ("SET_PRFL_TRAP", "SET_ACC 0x8000"),
        ("SET_PRFL_S_CRV", "SET_MAX_ACC 0x7fff", "SET_JERK 0x10000000"),
    ],
)
@pytest.mark.parametrize(("output", "range_"), [("SET_OUTPUT_STNDRD", 16), ("SET_OUTPUT_HIGH", 512)])
def test_a_velocity_above_the_pulse_range_is_limited_there_and_reported(
    setup: tuple[str, ...], output: str, range_: int
) -> None:
    rig = mover("mc1151a")
    distance = 10_000 if range_ == 16 else 800_000
    begun = rig.begin(output, *setup, f"SET_VEL {range_ * 2 * ONE}", f"SET_POS {distance}")
    rig.rest()
    assert max(rig.counts(begun)) == range_ and rig.moves() == [distance] and rig.status() == 0x301
    assert rig.codes == ["clamped"] and rig.do("GET_VEL") == range_ * 2 * ONE


@pytest.mark.fact("PMD-UND-PULSE-CLAMP")
def test_velocity_contouring_ends_at_the_pulse_range_and_every_update_reports_it() -> None:
    rig = mover("mc1151a")
    rig.begin("SET_PRFL_VEL", f"SET_VEL {17 * ONE}", f"SET_ACC {5 * ONE}")
    assert [look.vel // ONE for look in rig.trace(6)] == [5, 10, 15, 16, 16, 16]
    assert rig.codes == ["clamped"]
    rig.begin()
    assert rig.look().vel == 16 * ONE and rig.codes == ["clamped", "clamped"]


@pytest.mark.fact("PMD-UND-PULSE-RANGE-MOVE")
def test_a_range_changed_in_motion_counts_from_the_next_cycle() -> None:
    rig = mover("mc1151a")
    begun = rig.begin("SET_OUTPUT_HIGH", f"SET_VEL {20 * ONE}", f"SET_ACC {ONE}", "SET_POS 2000")
    rig.heeds(begun + 30, "SET_OUTPUT_STNDRD")
    assert [look.vel // ONE for look in rig.trace(6)] == [19, 18, 17, 16, 16, 16]
    assert rig.codes == ["clamped"]
    rig.heeds(begun + 40, "SET_OUTPUT_HIGH")
    assert [look.vel // ONE for look in rig.trace(6)] == [17, 18, 19, 20, 20, 20]
    rig.rest()
    assert rig.moves() == [2000]


# ------------------------------------------------------------------------------------------------------------- polarity
@pytest.mark.fact("PMD-PULSE-13")
@each
@pytest.mark.parametrize("word", [0x0000, 0xFFFF])
def test_no_command_inverts_the_polarity_of_pulse_or_dir(part: str, word: int) -> None:
    rig = mover(part, "pulse1", "dir1")
    for row in rig.x.sheet.commands:
        if row.name not in ("UPDATE", "MULTI_UPDATE", "RESET"):
            words = sum(arg.size for arg in row.args) // 2
            rig.packet(row.code, *[word] * words, reads=sum(arg.size for arg in row.reads) // 2)
        assert (rig.level("pulse1"), rig.level("dir1")) == (0, 1)
    rig.do("SET_1", "LMTS_OFF", "MTR_ON", "SET_PRFL_TRAP", "SET_ACTL_POS 0", "SET_BRK_OFF", "SET_START_VEL 0", "STOP")
    rig.begin("SET_VEL 0x10000", "SET_ACC 0x10000")
    begun = rig.begin("SET_POS 2")
    rig.rest()
    assert ticks(rig, "pulse1", begun) == [(4096, 1), (8192, 0), (12_288, 1), (16_384, 0)] and rig.level("dir1") == 1
