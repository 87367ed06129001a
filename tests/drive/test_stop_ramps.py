"""Ways down that records say: the rules of the board, and what a host says of a plan, by numbers worked out by hand."""

from __future__ import annotations

from itertools import pairwise

import pytest

import slewline
from slewline.core.motion.plan import plan
from slewline.drive.board import wire
from slewline.drive.board.records import DOWN, PAUSE, RAMP_LEFT, Record, fit, pack, unpack
from slewline.drive.board.wire import FrameKind
from slewline.drive.stopping.stop_ramps import BACK, LEVELS, law_of, ramp_pieces, spread, too_short

from .rig import TwinLine, check_steps, drive_of
from .test_twin import END, Rig

TABLE = [(1500 << 8, 3), (2000 << 8, 2), (3000 << 8, 4)]


def braked(record, tick, *behind, table=TABLE, start_stop=2500, how=b"\1"):
    """The ticks of a rig that a brake stops; its steps come at 11,000, 12,000 ... if they are 1000 apart."""
    rig = Rig(start_stop=start_stop).ready()
    if table:
        assert rig.tell(FrameKind.TAIL, wire.tail_payload(0, table), 500).result == 0
    rig.play(record, *behind, END)
    if tick:
        rig.tell(FrameKind.STOP, how, tick)
    rig.twin.run(200_000)
    assert rig.events()[-1][:3] == ("HALTED", 255, "HALT")
    return rig.ticks()


@pytest.mark.parametrize(
    ("way", "tail"),
    [
        (0, []),
        (1, [3000]),
        (4, [3000] * 4),
        (5, [2000] + [3000] * 4),
        (7, [1500] + [2000] * 2 + [3000] * 4),
        (9, [1500] * 3 + [2000] * 2 + [3000] * 4),
        (99, [1500] * 3 + [2000] * 2 + [3000] * 4),
    ],
)
def test_a_brake_plays_the_last_steps_of_the_table_by_the_number_in_the_record(way, tail):
    ticks = braked(Record(0, 20, 1000).with_ramp_left(way, 0), 13_500)
    assert ticks[:4] == [11_000, 12_000, 13_000, 14_000]
    assert [b - a for a, b in pairwise(ticks[3:])] == tail


@pytest.mark.parametrize(("slope", "at", "steps"), [(1, 13_500, 5), (1, 16_500, 8), (-1, 12_500, 0), (0, 16_500, 2)])
def test_the_stop_ramp_changes_with_each_step(slope, at, steps):
    # the scheduled step is number 3, 6 or 2 of the record, counted from 0
    record = Record(0, 20 if slope >= 0 else 3, 1000).with_ramp_left(2, slope)
    made = at // 1000 - 9  # with the one that is scheduled
    assert len(braked(record, at)) == made + steps


def test_an_underrun_counts_from_the_last_step():
    rig = Rig(start_stop=2500).ready()
    rig.tell(FrameKind.TAIL, wire.tail_payload(0, TABLE), 500)
    rig.play(Record(0, 4, 1000).with_ramp_left(7, -1))
    rig.twin.run(100_000)
    assert rig.ticks()[4:] == [17_000, 20_000, 23_000, 26_000]  # 7 - 3 steps, each 3000


def test_the_stop_ramp_is_played_at_the_start_stop_rate_too():
    assert len(braked(Record(0, 20, 1000).with_ramp_left(4, 0), 13_500, start_stop=900)) == 4 + 4
    assert len(braked(Record(0, 20, 1000), 13_500, start_stop=900)) == 4  # by the pace: the motor may stand


def test_after_the_first_step_there_is_no_stop_ramp():
    assert braked(Record(0, 20, 1000).with_ramp_left(4, 0), 10_500) == [11_000]


def test_without_a_table_the_pace_decides_but_a_stop_ramp_of_no_step_is_none():
    assert braked(Record(0, 20, 1000).with_ramp_left(4, 0), 12_500, table=[], start_stop=1100)[3:] == [14_062]
    assert braked(Record(0, 20, 1000).with_ramp_left(0, 0), 12_500, table=[], start_stop=1100)[3:] == []


def test_a_brake_does_not_make_the_motor_faster():
    ticks = braked(Record(0, 20, 2500).with_ramp_left(9, 0), 20_500)  # steps at 12,500, 15,000 ... 22,500
    assert [b - a for a, b in pairwise(ticks[4:])] == [2500] * 5 + [3000] * 4


def test_fast_steps_are_followed_by_one_more_and_by_an_interval_that_is_an_eighth_longer():
    fast = Record(0, 50, 600).with_ramp_left(6, 0)  # steps at 10,600 + 600 n
    table = [(610 << 8, 4), (700 << 8, 4)]
    ticks = braked(fast, 11_900, table=table)
    # 12,400 is scheduled; 13,000 is one more; then 675 instead of 610
    assert ticks[3:] == [12_400, 13_000, 13_675, 14_350, 15_050, 15_750, 16_450, 17_150]


def test_the_one_more_step_may_be_of_the_next_record_and_its_stop_ramp_counts():
    table = [(700 << 8, 9)]
    first, second = Record(0, 3, 600).with_ramp_left(6, 0), Record(0, 9, 600).with_ramp_left(2, 0)
    assert braked(first, 11_500, second, table=table) == [10_600, 11_200, 11_800, 12_400, 13_100, 13_800]
    other_way = Record(DOWN, 9, 1300)
    assert len(braked(first, 11_500, other_way, table=table)) == 3 + 6  # there it would have time enough
    assert len(braked(first, 11_500, Record(0, 9, 640), table=table)) == 3 + 6


def test_allowed_stop_ramps_of_a_record():
    rig = Rig().ready()

    def push(record):
        return rig.tell(FrameKind.PUSH, pack([record]), 500).result

    assert push(Record(0, 10, 1000).with_ramp_left(65_535, 0)) == 0
    assert push(Record(0, 10, 1000).with_ramp_left(65_526, 1)) == 0
    assert push(Record(0, 10, 1000).with_ramp_left(65_527, 1)) == 5
    assert push(Record(0, 10, 1000).with_ramp_left(9, -1)) == 0
    assert push(Record(0, 10, 1000).with_ramp_left(8, -1)) == 5
    assert push(Record(0, 10, 1000).with_ramp_left(8, 2)) == 5
    assert push(Record(PAUSE | RAMP_LEFT, 0, 1000)) == 5
    record = Record(DOWN, 10, 1000, 5).with_ramp_left(300, -1)
    assert unpack(pack([record])) == [record]
    assert record.ramp_left(0) == 300 and record.ramp_left(9) == 291
    assert record.growth == 0 and record.length == 10 * ((1000 << 16) + 5)


def test_a_table_has_65535_steps_at_most():
    rig = Rig().ready()
    for last, result in ((65_533, 5), (65_532, 0)):
        entries = [(1000 << 8, 1), (1000 << 8, 2), (2000 << 8, last)]
        assert rig.tell(FrameKind.TAIL, wire.tail_payload(0, entries), 500).result == result
    assert rig.tell(FrameKind.TAIL, wire.tail_payload(3, [(2000 << 8, 1)]), 500).result == 5


# ---------------------------------------------------------------------------------------------------- what a host says
UP = ((10, 3), (8, 2), (6, 2))


def ways(law, *legs, steps):
    """The way down from each step of a plan."""
    pieces = ramp_pieces(plan(*legs), law)
    return [way + (j - first) * slope for j in range(steps) for first, end, way, slope in pieces if first <= j < end]


def test_down_by_levels():
    # over is the step before: in the way up those below its level, less the step that is scheduled
    found = ways(LEVELS, ("up", UP), ("slew", ((5, 4),)), ("down", UP[::-1]), steps=18)
    assert found == [0, 0, 0, 0, 2, 2, 4, 4, 6, 6, 6, 6, 5, 4, 3, 2, 1, 0]


def test_back_to_the_first_rate():
    found = ways(BACK, ("up", UP), ("slew", ((5, 4),)), ("down", UP[::-1]), steps=18)
    assert found == [0, 0, 0, 0, 1, 2, 3, 4, 4, 4, 4, 4, 3, 2, 1, 0, 0, 0]


def test_a_plan_without_a_ramp_has_no_stop_ramp():
    for law in (LEVELS, BACK):
        assert ways(law, ("slew", ((5, 9),)), steps=9) == [0] * 9


def test_the_law_of_each_chip():
    bench = slewline.Bench()
    laws = {part: law_of(bench.add(part)) for part in ("cy500", "cy525", "cy545", "gs-c200s", "mc1451a")}
    assert laws == {"cy500": "", "cy525": LEVELS, "cy545": BACK, "gs-c200s": "", "mc1451a": ""}


def test_even_records_have_one_interval():
    ticks = [1000 << 16, 2000 << 16, 3010 << 16, 4020 << 16, 5000 << 16]
    records = fit(ticks, 0, even=True)
    assert all(record.add == 0 for record in records) and sum(record.count for record in records) == 5


def test_a_stop_ramp_from_any_rate():
    entries = spread(224, 16_000, 40)
    assert len(entries) == 40 and entries[-1][0] == 16_000 << 8
    assert too_short(entries) is None and entries == sorted(entries)
    assert all(b[0] <= 1.2 * a[0] for a, b in pairwise(entries))
    assert spread(224, 300, 40) == [(68_782, 3)]
    assert too_short([(600 << 8, 2), (700 << 8, 1)]) == 0


def test_a_board_has_the_table_of_the_motion_that_it_plays():
    bench = slewline.Bench()
    x = bench.add("cy525", "x")
    bench.host(x).send("A 0\rF 40\rR 75\rS 200\rZ 1\rN 1200\rG\rR 50\rS 100\rN 60\rG\r")
    line = TwinLine()

    def steps():
        return sum(count for _, count in line.twin.table)

    with drive_of(bench, x, line) as drive:
        drive.run("300 ms")
        assert x.travel > 1200 and len(line.twin.steps) < 1100  # the chip is in its second motion, the motor is not
        assert steps() == 393  # the 394 of its way down, but the last interval leads to no step
        drive.run("400 ms")
        assert 0 < steps() < 60
        check_steps(drive, line)
        assert not drive.troubles
