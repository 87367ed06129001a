"""Numbers of the MC1451A family: ends, smallest units, what is beyond; and that all parts and axes are alike."""

from __future__ import annotations

import pytest
from mc import AXES, ONE, S1, T1, T1_CYCLES, TRAPEZOID, V1, base, each, gaps, with_encoder
from mc_motion import Mover, mover

FULL = (f"SET_VEL {ONE}", f"SET_ACC {ONE}")  # a step per cycle from the first cycle on
FAST = ("SET_OUTPUT_HIGH", f"SET_VEL {512 * ONE}", f"SET_ACC {512 * ONE}")
TOP, BOTTOM = (1 << 30) - 1, -(1 << 30)
WRAPPED = 2  # bit 1 of the status word


# ---------------------------------------------------------------------------------------------------------------- ends
@each
@pytest.mark.parametrize(
    ("start", "acceleration", "reads"),
    [(0x3FFFFFF0, ONE, "1d > c000 0010 c02d"), (BOTTOM + 15, -ONE, "1d > 3fff ffef 400b")],
    ids=["up", "down"],
)
@pytest.mark.fact("PMD-RANGE-2", "PMD-RANGE-3", "PMD-UND-TRGT-ROUND")
def test_beyond_an_end_the_position_continues_at_the_other(
    part: str, start: int, acceleration: int, reads: str
) -> None:
    rig = mover(part)
    n = rig.begin(f"SET_ACTL_POS {start}", "SET_PRFL_VEL", f"SET_VEL {ONE}", f"SET_ACC {acceleration}")
    looks = rig.trace(32)
    assert [bool(look.status & WRAPPED) for look in looks] == [k >= 16 for k in range(32)]
    rig.says(reads)
    assert [looks[k].pos for k in (15, 16)] == ([TOP, BOTTOM] if acceleration > 0 else [BOTTOM, TOP])
    assert gaps(rig.ticks(n)) == [8192] * (len(rig.ticks(n)) - 1)
    assert len(rig.ticks(n)) >= 32 and rig.codes == []


@each
@pytest.mark.fact("PMD-UND-WRAP-MOVE", "PMD-RANGE-1", "PMD-CMD-SET_POS-2")
def test_a_move_never_wraps_around_an_end(part: str) -> None:
    rig = mover(part)
    rig.begin(*FAST, f"SET_ACTL_POS {TOP}", f"SET_POS {BOTTOM}")
    rig.next(10)
    assert rig.look()[:3] == (TOP - 5120, -512 * ONE, 0x0700) and rig.level("dir1") == 0


@with_encoder
@pytest.mark.fact("PMD-UND-WRAP-ACTUAL")
def test_the_actual_position_passes_the_ends_silently(part: str) -> None:
    rig = mover(part, quadrature={})
    rig.do(f"SET_ACTL_POS {TOP}")
    for counts, reads in ((1, "37 > c000 0000 c037"), (-1, "37 > 3fff ffff 4035")):
        rig.shafts["quadrature"].push(counts)
        rig.next()
        rig.says(reads, "31 > 0300 0331")


@with_encoder
@pytest.mark.parametrize("stepwise", [False, True])
def test_the_position_error_counts_on_where_the_target_comes_round(part: str, stepwise: bool) -> None:
    rig = mover(part, options={"stepwise": stepwise})
    rig.begin("SET_STEP_RATIO 256", f"SET_ACTL_POS {TOP - 10}", "SET_PRFL_VEL", *FULL)
    for cycles in (5, 15):
        rig.next(cycles)
        rig.look()
    rig.do("UPDATE")  # another run begins beyond the end
    rig.next(3)
    target, error = (rig.x.registers[name] for name in ("trgt_pos", "actl_pos_err"))
    assert target < BOTTOM + 100 and error == -(target - BOTTOM + 11)


# -------------------------------------------------------------------------------------------------------------- units
@each
@pytest.mark.fact("PMD-RANGE-4")
def test_the_smallest_velocity_is_a_step_in_65536_cycles(part: str) -> None:
    rig = mover(part)
    n = rig.begin("SET_PRFL_VEL", "SET_VEL 1", "SET_ACC 1")
    rig.to(n + 2 * ONE)
    assert rig.ticks(n) == [ONE * 8192, 2 * ONE * 8192]


@each
@pytest.mark.fact("PMD-RANGE-5")
def test_the_smallest_acceleration(part: str) -> None:
    rig = mover(part)
    rig.begin("SET_PRFL_VEL", f"SET_VEL {ONE}", "SET_ACC 1")
    assert [look.vel for look in rig.trace(256)] == [*range(1, 257)]


@each
@pytest.mark.fact("PMD-RANGE-5")
def test_the_smallest_jerk(part: str) -> None:
    rig = mover(part)
    rig.begin("SET_PRFL_S_CRV", f"SET_VEL {ONE}", "SET_MAX_ACC 0x7FFF", "SET_JERK 1", "SET_POS 100000")
    found = [look.vel for look in rig.trace(800)]
    assert found == [((k + 1) ** 3 - k**3) // (6 << 16) for k in range(800)]  # the mean velocities of k^3 / 6
    assert 359 <= found.index(1) + 1 <= 365


# -------------------------------------------------------------------------------------------------------------- beyond
BEYOND = {  # what is written, and what has become of it
    "10 4000 0000 > 4010": "4a > c000 0000 c04a",
    "10 bfff ffff > c00e": "4a > 3fff ffff 4048",
    "11 8001 0000 > 8012": "4b > 0001 0000 004c",
    "13 8000 0001 > 8014": "58 > 0000 0001 0059",
    "15 ffff > 0014": "4f > 7fff 804e",
    "6a 8000 4000 > c06a": "6b > 0000 4000 406b",
    "29 83e8 > 8411": "55 > 03e8 043d",
    "68 8100 > 8168": "6f > 0100 016f",
    "2f ff71 > ffa0": "56 > 0071 00c7",
    "4d 4000 0000 > 404d": "1d > c000 0000 c01d",
    "11 4000 0000 > 4011": "4b > 4000 0000 404b",  # kept as it is, the register having room
    "12 4000 0000 > 4012": "4c > 4000 0000 404c",
    "14 8000 0000 > 8014": "59 > 8000 0000 8059",
    "66 ff00 > ff66": "31 > 0300 0331",
    "5b fff0 > 004b": "31 > 0300 0331",
}


@each
@pytest.mark.fact("PMD-RANGE-8", "PMD-UND-RANGE-VALUES", "PMD-UND-DIAGNOSTICS", "PMD-CON-MAXACC-RANGE")
def test_a_value_beyond_its_range_is_folded_into_it_and_found(part: str) -> None:
    rig = base(part)
    for number, (written, kept) in enumerate(BEYOND.items(), 1):
        rig.says(written)
        rig.next()
        rig.says(kept)
        assert [code for code in rig.codes if code != "no-encoder"] == ["out-of-range"] * number, written


@each
@pytest.mark.fact("PMD-UND-RANGE-VALUES")
def test_a_trapezoid_takes_the_magnitude_of_a_negative_acceleration(part: str) -> None:
    rig = mover(part)
    rig.do("SET_VEL 0x10000", "SET_POS 1000")
    rig.says("12 ffff fc00 > fc11")
    n = rig.begin()
    rig.rest()
    assert rig.lows("atrest1") == [(n, T1_CYCLES)] and rig.x.position == 1000
    assert rig.codes == ["out-of-range"]
    rig.do("SET_PRFL_VEL", "SET_ACC -1024")
    assert rig.codes == ["out-of-range"]  # there it has a meaning


@each
@pytest.mark.fact("PMD-UND-RANGE-VALUES")
def test_upper_bytes_of_clearing_masks_are_free(part: str) -> None:
    rig = base(part)
    rig.says("34 fffb > 002f", "34 00de > 0112", "32 ff00 > ff32", "16 8000 0000 > 8016", "57 > 8000 0000 8057")
    assert rig.codes == []


# --------------------------------------------------------------------------------------------------- parts, and axes
def played(part: str, axis: int) -> list[list[int]]:
    """The steps of an axis in a trapezoid, an S-curve, and velocity contouring that is stopped; clocks."""
    rig, found = mover(part), []
    for move in ((*T1, "SET_POS 100"), (*S1, "SET_POS 250"), ("CLR_STATUS", *V1)):
        n = rig.begin(*move, axis=axis)
        rig.to(n + 250)
        if move[-1] == V1[-1]:
            rig.begin("SMOOTH_STOP", axis=axis)
        rig.rest()
        found.append(rig.ticks(n, axis))
    assert {other for other in range(1, AXES[part] + 1) if rig.ticks(0, other)} == {axis}
    return found


@each
@pytest.mark.fact("PMD-RANGE-7")
def test_all_axes_of_all_parts_move_alike(part: str) -> None:
    alike = played("mc1151a", 1)
    assert [len(steps) for steps in alike[:2]] == [100, 150] and len(alike[2]) > 200
    for axis in range(1, AXES[part] + 1):
        assert played(part, axis) == alike


FOUR = (
    (*TRAPEZOID, "SET_POS 300"),
    (*S1, "SET_POS -200"),
    ("SET_PRFL_VEL", "SET_VEL 0x6000", "SET_ACC -100"),
    ("SET_PRFL_GEAR", "SET_RATIO 0x18000"),
)


def together(*axes: int) -> list[list[int]]:
    """The steps of all axes, if these move: each in another mode; clocks."""
    rig: Mover = mover("mc1451a-e", quadrature={"axis": 4})
    for axis in axes:
        rig.do(*FOUR[axis - 1], axis=axis)
    rig.heeds(100, f"MULTI_UPDATE {sum(1 << axis - 1 for axis in axes)}")
    rig.shafts["quadrature"].run(2000)
    rig.to(600)
    return [rig.ticks(100, axis) for axis in range(1, 5)]


@pytest.mark.fact("PMD-RANGE-9")
def test_axes_in_four_modes_do_not_affect_one_another() -> None:
    all_four = together(1, 2, 3, 4)
    assert len(all_four[0]) == 300 and all(all_four)
    for axis in range(1, 5):
        alone = [all_four[axis - 1] if other == axis else [] for other in range(1, 5)]
        assert together(axis) == alone
