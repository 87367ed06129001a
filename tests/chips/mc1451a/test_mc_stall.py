"""The -E parts of the MC1451A family: position error, stall detection, auto stop, recovery; and parts without.

error     actual position less target, in counts; the target counts step ratio / 256 counts a step
"""

from __future__ import annotations

import pytest
from mc import ONE, S1, T1, T1_CYCLES, TRAPEZOID, V1, with_encoder
from mc_motion import Mover, mover, without_encoder

RATIO, LIMIT = "SET_STEP_RATIO 256", "SET_POS_ERR 100"  # a count per step
FAST = ("SET_OUTPUT_HIGH", f"SET_VEL {512 * ONE}", f"SET_ACC {64 * ONE}")
ONE_BY_ONE = ("SET_VEL 0x10000", "SET_ACC 0x10000")  # a step in every cycle

modes = pytest.mark.parametrize("setup", [T1, V1, S1], ids=["trapezoid", "velocity", "s-curve"])


def stalled(*more: str, setup: tuple[str, ...] = T1, follows: int = 0) -> Mover:
    """An axis whose shaft has followed for some steps and then stood still, in the cycle of its motion error."""
    rig = mover("mc1151a-e", encoder={"counts": 400, "steps": 400})
    shaft = rig.shafts["encoder"]
    if not follows:
        shaft.block()
    rig.begin(RATIO, LIMIT, *more, *setup)
    while not rig.shows("status") & 16:
        if rig.x.position >= follows:
            shaft.block()
        rig.next()
    return rig


# ----------------------------------------------------------------------------------------------------- the error itself
@pytest.mark.fact("PMD-STALL-7")
def test_the_error_is_in_counts() -> None:
    rig = mover("mc1151a-e")
    rig.begin("SET_STEP_RATIO 0x50", *ONE_BY_ONE, "SET_POS 320")
    rig.rest()
    rig.says("60 > ff9c fffc")
    rig.begin("SET_POS -320")
    rig.rest()
    rig.says("60 > 0064 00c4")


@pytest.mark.fact("PMD-UND-ERR-SIGN")
def test_it_is_the_actual_position_less_the_target() -> None:
    rig = mover("mc1151a-e", quadrature={})
    rig.shafts["quadrature"].push(5)
    rig.begin(RATIO, *ONE_BY_ONE, "SET_POS 12")
    rig.rest()
    assert rig.do("GET_ACTL_POS") == 5 and rig.do("GET_ACTL_POS_ERR") == -7


@pytest.mark.fact("PMD-UND-ERR-ROUND")
@pytest.mark.parametrize(("way", "errors"), [(1, [0, -1, -1, -1, -2, -2, -2, -3]), (-1, [0, 0, 0, 0, 1, 1, 1, 2])])
def test_fractions_of_a_count_are_kept_and_the_error_rounded_down(way: int, errors: list[int]) -> None:
    rig = mover("mc1151a-e")
    rig.begin("SET_STEP_RATIO 80", "SET_POS_ERR 1", *ONE_BY_ONE, f"SET_POS {32 * way}")
    found, status = [], []
    for _ in range(8):
        found.append(rig.shows("actl_pos_err"))
        status.append(rig.shows("status") & 16)
        rig.next()
    assert found == errors
    assert status.index(16) == [abs(error) > 1 for error in errors].index(True)  # what is read is what is compared
    rig.rest()
    assert rig.shows("actl_pos_err") == -10 * way  # 32 * 80 / 256, exactly


@pytest.mark.fact("PMD-STALL-13", "PMD-UND-ERR-SATURATE")
def test_read_values_end_with_16_bits_and_the_error_itself_does_not() -> None:
    rig = mover("mc1151a-e")
    rig.begin(RATIO, *FAST, "SET_POS 100000")
    rig.rest()
    rig.says("60 > 8000 8060")
    rig.begin("SET_POS -100000")
    rig.rest()
    rig.says("60 > 7fff 805f")
    rig.begin("SET_POS 7")
    rig.rest()
    rig.says("60 > fff9 0059")


@pytest.mark.fact("PMD-UND-RATIO-CHANGE")
def test_another_ratio_counts_for_later_steps() -> None:
    rig = mover("mc1151a-e")
    rig.begin(RATIO, *ONE_BY_ONE, "SET_POS 10")
    rig.rest()
    rig.do("SET_STEP_RATIO 512")
    rig.next(2)
    assert rig.do("GET_ACTL_POS_ERR") == -10
    rig.begin("SET_POS 15")
    rig.rest()
    assert rig.do("GET_ACTL_POS_ERR") == -20


@pytest.mark.fact("PMD-STALL-11")
def test_a_position_that_is_set_has_no_error() -> None:
    rig = mover("mc1151a-e")
    rig.begin(RATIO, *ONE_BY_ONE, "SET_POS 100")
    rig.rest()
    assert rig.do("GET_ACTL_POS_ERR") == -100
    rig.do("SET_ACTL_POS 0")
    assert [rig.do(f"GET_{name}") for name in ("ACTL_POS_ERR", "TRGT_POS", "ACTL_POS")] == [0, 0, 0]
    rig.next(10)
    assert rig.do("GET_ACTL_POS_ERR") == 0


@pytest.mark.fact("PMD-STALL-15")
def test_with_a_shaft_that_follows_the_actual_position_keeps_up() -> None:
    rig = mover("mc1151a-e", encoder={"counts": 400, "steps": 400})
    begun = rig.begin(RATIO, "SET_POS_ERR 2", *T1)
    behind = {rig.do("GET_TRGT_POS") - rig.do("GET_ACTL_POS") for _ in range(100)}
    rig.to(begun + 1000)
    for _ in range(80):
        rig.next()
        assert rig.shows("trgt_pos") - rig.shows("actl_pos") in (0, 1, 2)
    assert behind <= {-2, -1, 0, 1, 2}  # the second word is read 2 cycles later
    assert rig.status() == 0x301 and rig.do("GET_ACTL_POS") == 1000


@pytest.mark.fact("PMD-UND-WRAP-ACTUAL")
def test_the_actual_position_wraps_around_silently() -> None:
    rig = mover("mc1151a-e", quadrature={})
    top = (1 << 30) - 1
    rig.do(f"SET_ACTL_POS {top}")
    rig.shafts["quadrature"].push(3)
    rig.next(2)
    assert rig.do("GET_ACTL_POS") == -top + 1 and rig.status() == 0x300 and rig.do("GET_TRGT_POS") == top
    rig.shafts["quadrature"].push(-3)
    rig.next(2)
    assert rig.do("GET_ACTL_POS") == top and rig.status() == 0x300


@pytest.mark.fact("PMD-ENC-9")
@pytest.mark.parametrize("how", ["SET_PRFL_TRAP", "SET_PRFL_VEL", "SET_PRFL_S_CRV", "SET_PRFL_GEAR", "MTR_OFF"])
def test_counts_are_counted_in_every_mode_and_with_the_motor_off(how: str) -> None:
    rig = mover("mc1151a-e", quadrature={})
    rig.do(how)
    rig.shafts["quadrature"].run(100_000)
    rig.bench.run("10 ms")
    rig.shafts["quadrature"].run(0)
    rig.next(2)
    assert rig.do("GET_ACTL_POS") == 1000


# ------------------------------------------------------------------------------------------------------ stall detection
@pytest.mark.fact("PMD-STALL-3", "PMD-STALL-4", "PMD-UND-CYCLE-ORDER")
def test_an_error_beyond_the_limit_sets_its_bit_in_the_same_cycle_and_nothing_else() -> None:
    rig = mover("mc1151a-e")
    begun = rig.begin(RATIO, LIMIT, *T1)
    looks = rig.trace(200)
    assert [bool(look.status & 16) for look in looks] == [look.pos > 100 for look in looks]
    rig.rest()
    assert rig.moves() == [1000] and rig.status() == 0x311 and rig.lows("atrest1") == [(begun, T1_CYCLES)]


@pytest.mark.fact("PMD-STALL-3")
@pytest.mark.parametrize("counts", [100, -100])
def test_an_error_equal_to_the_limit_is_allowed(counts: int) -> None:
    rig = mover("mc1151a-e", quadrature={})
    rig.do(RATIO, LIMIT)
    rig.shafts["quadrature"].push(counts)
    rig.next(5)
    assert rig.do("GET_ACTL_POS_ERR") == counts and rig.status() == 0x300
    rig.shafts["quadrature"].push(counts // 100)
    rig.next(2)
    assert rig.status() == 0x310


@modes
@pytest.mark.fact("PMD-STALL-5", "PMD-STAT-24", "PMD-UND-AUTO-STOP-CYCLE")
def test_auto_stop_switches_the_motor_off(setup: tuple[str, ...]) -> None:
    rig = mover("mc1151a-e")
    rig.begin(RATIO, LIMIT, "SET_AUTO_STOP_ON", *setup)
    looks = rig.trace(200)
    trip = next(n for n, look in enumerate(looks) if look.pos == 101)
    assert {look.status for look in looks[:trip]} == {0x700}
    assert looks[trip].status == 0x610 and {look.status for look in looks[trip + 1 :]} == {0x210}
    assert {look[:2] for look in looks[trip + 1 :]} == {(looks[trip + 1].pos, 0)}
    assert rig.moves() == [looks[trip + 1].pos]  # those of the cycle of the trip, and no more


@with_encoder
@pytest.mark.fact("PMD-STALL-6")
def test_at_rest_the_error_is_watched_too(part: str) -> None:
    rig = mover(part)
    axis = len(rig.x.axes)
    rig.do(f"SET_{axis}", RATIO, LIMIT)
    begun = rig.next()
    rig.turn(101, apart=40, axis=axis)  # in this cycle
    assert rig.shows("status", axis) & 0xFFF == 0x300
    rig.to(begun + 1)
    assert rig.shows("status", axis) & 0xFFF == 0x310 and rig.shows("actl_pos_err", axis) == 101


@pytest.mark.fact("PMD-STALL-8")
def test_another_limit_acts_immediately() -> None:
    rig = mover("mc1151a-e")
    rig.begin(RATIO, LIMIT, *ONE_BY_ONE, "SET_POS 50")
    rig.rest()
    assert rig.do("GET_ACTL_POS_ERR") == -50 and rig.status() == 0x301
    rig.heeds(rig.cycle + 2, "SET_POS_ERR 40")
    assert rig.shows("status") == 0x311


@pytest.mark.fact("PMD-STALL-12", "PMD-UND-RATIO-ZERO")
def test_with_ratio_0_no_stall_is_detected_and_the_error_can_be_read() -> None:
    rig = mover("mc1151a-e", quadrature={})
    rig.do("SET_POS_ERR 0", "SET_AUTO_STOP_ON")
    shaft = rig.shafts["quadrature"]
    shaft.push(5)
    rig.next(3)
    assert rig.do("GET_ACTL_POS_ERR") == 5
    shaft.run(500_000)
    rig.bench.run("80 ms")
    shaft.run(0)
    rig.next(2)
    assert rig.do("GET_ACTL_POS") == 40_005 and rig.status() == 0x300 and rig.do("GET_ACTL_POS_ERR") == 32767


@pytest.mark.fact("PMD-STALL-14", "PMD-UND-POSERR-DEFAULT")
@pytest.mark.parametrize(("place", "status"), [(32_767, 0x301), (-40_000, 0x301), (40_000, 0x311)])
def test_after_a_reset_the_limit_is_the_greatest_one(place: int, status: int) -> None:
    rig = mover("mc1151a-e")
    rig.says("55 > 7fff 8054")
    rig.begin(RATIO, *FAST, f"SET_POS {place}")
    rig.rest()
    assert rig.status() == status  # -32768 alone exceeds it


@pytest.mark.fact("PMD-UND-AUTOSTOP-DEFAULT")
def test_after_a_reset_auto_stop_is_off() -> None:
    rig = mover("mc1151a-e")
    assert rig.do("GET_MODE") == 0
    rig.begin(RATIO, LIMIT, *T1)
    rig.rest()
    assert rig.status() == 0x311 and rig.moves() == [1000]


@pytest.mark.fact("PMD-STAT-25")
def test_motion_complete_is_about_the_trajectory() -> None:
    rig = mover("mc1151a-e")
    begun = rig.begin(RATIO, *T1)
    rig.to(begun + T1_CYCLES - 1)
    assert rig.shows("status") == 0x700 and rig.shows("actl_pos") == 0
    rig.next()
    assert rig.shows("status") == 0x301


# ------------------------------------------------------------------------------------------------------------- recovery
@pytest.mark.fact("PMD-STALL-9", "PMD-CON-SYNCH-DIR")
def test_synch_prfl_update_and_motor_on_recover_from_a_stall() -> None:
    rig = stalled("SET_AUTO_STOP_ON", follows=30)
    rig.next()
    assert rig.status() == 0x210 and rig.do("GET_ACTL_POS") == 30
    steps = rig.x.travel
    rig.says("47 > 0047", "1a > 001a", "43 > 0043", "1d > 0000 001e 003b", "60 > 0000 0060")
    rig.do("CLR_STATUS")
    rig.next(1000)
    assert rig.status() == 0x300 and rig.x.travel == steps and rig.x.position == 30


@pytest.mark.fact("PMD-STALL-10", "PMD-UND-UPDATE-ORDER")
def test_the_update_of_the_next_move_may_carry_out_the_synch_prfl() -> None:
    rig = stalled("SET_AUTO_STOP_ON", follows=30)
    rig.next()
    steps = rig.x.travel
    rig.shafts["encoder"].free()
    rig.do("CLR_STATUS", "SYNCH_PRFL", "MTR_ON", "SET_POS 500")
    begun = rig.begin()
    assert rig.look().pos == 30 and rig.look().vel > 0
    rig.rest()
    rig.next()
    assert rig.shows("trgt_pos") == 500 == rig.shows("actl_pos") and rig.x.travel == steps + 470
    assert rig.moves(begun) == [470] and rig.do("GET_ACTL_POS_ERR") == 0


@pytest.mark.fact("PMD-STALL-16", "PMD-UND-MTR-ON-STALL")
def test_the_motor_stays_on_while_the_error_persists_and_a_new_one_switches_it_off() -> None:
    rig = stalled("SET_AUTO_STOP_ON")
    rig.next()
    steps = rig.x.travel
    rig.do("MTR_ON")
    for _ in range(10):
        rig.next(100)
        assert rig.status() == 0x310
    assert rig.x.travel == steps
    rig.do(f"SET_ACTL_POS {steps}", "CLR_STATUS")
    assert rig.status() == 0x300
    rig.begin()
    rig.rest()
    assert rig.status() == 0x210


@pytest.mark.fact("PMD-UND-STALL-CLEAR")
@pytest.mark.parametrize(
    ("code", "words", "at_once"),
    [(0x1A, (), False), (0x29, (30_000,), False), (0x4D, (0, 7), True)],
    ids=["SYNCH_PRFL, UPDATE", "SET_POS_ERR", "SET_ACTL_POS"],
)
def test_a_motion_error_can_be_cleared_after_the_cycle_that_finds_none(
    code: int, words: tuple[int, ...], at_once: bool
) -> None:
    rig = stalled("SET_AUTO_STOP_ON")
    rig.do("SYNCH_PRFL" if code == 0x1A else "SET_BRK_OFF")
    rig.to(rig.cycle + 1, 8192 - 2048 * len(words))
    rig.host.packet(code, *words, checksum=False)
    ended = rig.cycle
    rig.host.packet(0x33, checksum=False)  # CLR_STATUS in the same cycle
    assert rig.cycle == ended and rig.shows("status") == (0x200 if at_once else 0x210)
    rig.to(ended + 1)
    assert rig.shows("status") == (0x200 if at_once else 0x210)  # nothing but the host clears it
    rig.do("CLR_STATUS")
    assert rig.status() == 0x200


# ----------------------------------------------------------------------------------------------------------- SYNCH_PRFL
@pytest.mark.fact("PMD-CMD-SYNCH_PRFL-2")
@pytest.mark.parametrize("mode", ["SET_PRFL_TRAP", "SET_PRFL_VEL", "SET_PRFL_S_CRV", "SET_PRFL_GEAR"])
def test_synch_prfl_works_in_every_mode(mode: str) -> None:
    rig = mover("mc1151a-e", quadrature={})
    rig.shafts["quadrature"].push(37)
    rig.next(2)
    rig.begin(mode, RATIO, *ONE_BY_ONE, "SYNCH_PRFL", "STOP")
    assert rig.shows("trgt_pos") == 37 == rig.shows("actl_pos") and rig.shows("actl_pos_err") == 0
    rig.next(50)
    assert not rig.ticks() and rig.shows("trgt_pos") == 37 == rig.x.position


@pytest.mark.fact("PMD-CMD-SYNCH_PRFL-3", "PMD-UND-SYNCH-MOTION", "PMD-UND-UPDATE-ORDER")
@pytest.mark.parametrize("stop", [True, False])
def test_at_rest_a_destination_elsewhere_starts_a_move_unless_there_is_a_stop(stop: bool) -> None:
    rig = mover("mc1151a-e", quadrature={})
    rig.shafts["quadrature"].push(37)
    rig.begin(*ONE_BY_ONE, "SET_POS 1000", "SYNCH_PRFL", *(["STOP"] if stop else []))
    assert rig.look()[:3] == ((37, 0, 0x301) if stop else (37, ONE, 0x700))
    rig.rest()
    assert rig.moves() == ([] if stop else [963]) and rig.shows("trgt_pos") == (37 if stop else 1000)


@pytest.mark.fact("PMD-UND-SYNCH-UNITS")
def test_the_count_becomes_the_step_number_unchanged() -> None:
    rig = mover("mc1151a-e", quadrature={})
    rig.shafts["quadrature"].push(50)
    rig.begin("SET_STEP_RATIO 0x500", *ONE_BY_ONE, "SYNCH_PRFL", "STOP")
    assert rig.shows("trgt_pos") == 50 and rig.shows("actl_pos_err") == 0
    rig.begin("SET_POS 51")
    rig.rest()
    assert rig.shows("actl_pos_err") == -5  # 1280 / 256 counts a step


@pytest.mark.fact("PMD-UND-SYNCH-MOTION")
def test_in_motion_the_target_jumps_and_the_speed_stays() -> None:
    rig = mover("mc1151a-e", quadrature={})
    rig.shafts["quadrature"].push(7)
    begun = rig.begin(*TRAPEZOID, "SET_POS 1000")
    rig.to(begun + 490)
    rig.heeds(begun + 500, "SYNCH_PRFL", "UPDATE")  # at 468.5
    assert rig.look() == (7, ONE, 0x700, 0) and rig.x.position == 7
    rig.rest()
    assert rig.x.travel == 468 + 993 and rig.shows("trgt_pos") == 1000 == rig.x.position


# --------------------------------------------------------------------------------------------- parts without an encoder
@without_encoder
@pytest.mark.fact("PMD-ENC-7", "PMD-UND-ENC-ABSENT")
def test_a_part_without_encoder_takes_its_commands_and_reads_0(part: str) -> None:
    rig = mover(part)
    rig.do("SET_ACTL_POS 55")
    rig.says("37 > 0000 0000 0037", "60 > 0000 0060", "36 > 0000 0000 0036", "45 > 0045", "44 > 0044")
    rig.says("29 03e8 > 0411", "55 > 03e8 043d", "68 0050 > 00b8", "6f > 0050 00bf", "64 > 0064", "65 > 0065")
    rig.says("14 0001 8000 > 8015", "59 > 0001 8000 805a", "1b > 001b", "6d > 006d", "1c > 001c", "47 > 0047")


@without_encoder
@pytest.mark.fact("PMD-CON-STALL-PARTS")
def test_a_part_without_encoder_detects_no_stall(part: str) -> None:
    rig = mover(part)
    begun = rig.begin(RATIO, "SET_POS_ERR 0", "SET_AUTO_STOP_ON", *T1)
    rig.rest()
    assert rig.status() == 0x301 and rig.lows("atrest1") == [(begun, T1_CYCLES)]
    assert rig.do("GET_ACTL_POS_ERR") == 0


@without_encoder
@pytest.mark.fact("PMD-ENC-8")
def test_an_encoder_changes_what_the_encoder_does_and_nothing_else(part: str) -> None:
    found = []
    for name in (part, f"{part}-e"):
        rig = mover(name)
        begun = rig.begin(*T1)
        rig.rest()
        found.append((rig.do("GET_VRSN"), rig.ticks(begun), rig.x.registers, rig.lows("atrest1")))
    assert found[0] == found[1]
