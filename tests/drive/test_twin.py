"""The twin of the board: each rule by numbers that are worked out by hand."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from slewline.drive.board import wire
from slewline.drive.board.boards import UNO
from slewline.drive.board.records import DOWN, HALF, OUT, PAUSE, REST, Record, pack
from slewline.drive.board.twin_board import BoardTwin
from slewline.drive.board.wire import (
    Answer,
    BoardConfig,
    BoardEvent,
    BoardState,
    Decoder,
    DriverFlag,
    Frame,
    FrameKind,
    Happening,
    Ident,
    PowerFlag,
)

STOP, BRAKE, MARK, ESTOP = range(1, 5)
UPWARDS, DOWNWARDS = 16, 32
FULL = (0b0101, 0b0100, 0b0110, 0b0010, 0b1010, 0b1000, 0b1001, 0b0001)


class Rig:
    """A twin, and a host that numbers its frames."""

    def __init__(
        self, start_stop: int = 10_000, *, reflex: Sequence[int] = (), active: int = 63, **more: object
    ) -> None:
        self.twin, self.number = BoardTwin(), 0
        self.twin.inputs = 0
        self.heard: list[Answer | BoardEvent | Ident] = []
        reflex = (*reflex, *(0,) * (6 - len(reflex)))
        more = {"driver": DriverFlag.ENABLE, **more}
        self.config = BoardConfig(start_stop, reflex=reflex, active=active, **more)  # type: ignore[arg-type]

    def ready(self, tick: int = 100) -> Rig:
        """Configured and reset."""
        assert self.tell(FrameKind.CONFIG, self.config.pack(), tick).result == 0
        assert self.tell(FrameKind.RESET, wire.reset_payload(0, known=True), tick).result == 0
        self.heard.clear()
        return self

    def listen(self) -> list[Answer | BoardEvent | Ident]:
        got = []
        for frame in Decoder().feed(self.twin.take()):
            assert isinstance(frame, Frame)
            said = wire.read(frame)
            assert said is not None
            got.append(said)
        self.heard += got
        return got

    def tell(self, kind: int, payload: bytes = b"", tick: int = 0, number: int | None = None) -> Answer:
        """Send a frame; return its answer."""
        self.listen()
        own = self.number if number is None else number
        self.twin.receive(wire.encode(own, kind, payload), tick)
        (answer,) = (said for said in self.listen() if isinstance(said, Answer))
        assert (answer.echo, answer.kind, answer.tick) == (own, kind, tick % 2**32)
        if answer.result == 0 and kind in wire.NUMBERED:
            self.number += 1
        return answer

    def play(self, *records: Record, start: int = 10_000, tick: int = 1000) -> Answer:
        for at in range(0, len(records), 5):
            assert self.tell(FrameKind.PUSH, pack(records[at : at + 5]), tick).result == 0
        return self.tell(FrameKind.START, wire.start_payload(start), tick)

    def events(self) -> list[tuple[str, int, str, int, int]]:
        """Kind, which, state, position and tick of all that happened."""
        self.listen()
        return [
            (Happening(said.kind).name, said.which, BoardState(said.state).name, said.position, said.tick)
            for said in self.heard
            if isinstance(said, BoardEvent)
        ]

    def ticks(self) -> list[int]:
        return [tick for tick, _, _ in self.twin.steps]


END = Record(PAUSE | REST, 0, 5000)


# -------------------------------------------------------------------------------------------------------------- frames
def test_power_up_reports_itself_and_takes_little() -> None:
    rig = Rig()
    assert rig.events() == [("BOOT", 255, "BOOT", 0, 0)]
    for kind in (FrameKind.PUSH, FrameKind.START, FrameKind.TAIL, FrameKind.RESET, FrameKind.OUTPUTS, FrameKind.CHECK):
        assert rig.tell(kind, bytes(13), 50).result == 4
    for kind, payload in ((FrameKind.ASK, b""), (FrameKind.STOP, b"\0"), (FrameKind.REPEAT, b"\0")):
        assert rig.tell(kind, payload, 60, number=99).result == 0
    assert rig.tell(FrameKind.CONFIG, rig.config.pack(), 70).state == BoardState.HALT
    assert [name for name, *_ in rig.events()] == ["BOOT", "BOOT"]  # told again by REPEAT


def test_hello_is_answered_after_an_ident_and_numbers_begin_again() -> None:
    rig = Rig().ready()
    answer = rig.tell(FrameKind.HELLO, tick=500, number=77)
    ident = rig.heard[-2]
    assert ident == Ident(0, 2, 1, UNO.slots, UNO.tail, UNO.room, 224, 16_000_000)
    assert answer == Answer(0, 77, 1, 0, UNO.slots, 0, 1, 0, 0, 0, 500)
    assert rig.tell(FrameKind.PUSH, pack([END]), 600, number=0).result == 0
    assert rig.tell(FrameKind.HELLO, b"x", 700).result == 5


def test_results_in_their_order_and_only_what_is_taken_uses_up_its_number() -> None:
    rig = Rig().ready()
    good, bad = Record(0, 1, 1000), Record(0, 1, 223)
    assert rig.tell(77, b"", 1000).result == 5
    assert rig.tell(FrameKind.ANSWER, bytes(15), 1000).result == 5
    assert rig.tell(FrameKind.PUSH, pack([bad]), 1000, number=9).result == 2
    assert rig.tell(FrameKind.START, bytes(4), 1000).result == 4  # empty queue
    assert rig.tell(FrameKind.PUSH, pack([good, bad]), 1000)[4:5] == (UNO.slots,)
    assert rig.tell(FrameKind.PUSH, pack([good, bad]), 1000).result == 5
    assert rig.tell(FrameKind.PUSH, b"", 1000).result == 5
    assert rig.tell(FrameKind.PUSH, bytes(12), 1000).result == 5
    for _ in range(UNO.slots - 1):
        answer = rig.tell(FrameKind.PUSH, pack([good]), 1000)
    assert (answer.free, answer.result) == (1, 0)
    full = rig.tell(FrameKind.PUSH, pack([good, good]), 1000)
    assert (full.free, full.result, full.wanted) == (1, 3, rig.number)
    assert rig.tell(FrameKind.PUSH, pack([good]), 1000).free == 0
    assert rig.tell(FrameKind.START, wire.start_payload(1599), 1000).result == 6  # the first step would be at 2599
    assert rig.tell(FrameKind.START, wire.start_payload(1600), 1000)[3:6] == (0, 1, 1)
    assert rig.tell(FrameKind.CONFIG, rig.config.pack(), 1000).result == 4
    assert rig.tell(FrameKind.RESET, wire.reset_payload(0), 1000).result == 4
    rig.twin.run(2599)
    assert rig.ticks() == []
    rig.twin.run(2600)
    assert rig.ticks() == [2600]


@pytest.mark.parametrize(
    ("ahead", "interval", "result"),
    [
        (2**28, 1_000, 0),
        (2**28, 2**31 - 1, 0),
        (2**28 + 1, 1_000, 6),
        (2**31 - 1, 1_000, 6),
        (2**31, 2**31 - 1, 6),  # the same as 2^31 ago
        (-(2**28), 2**28 + 1_600, 0),
        (-(2**28), 2**28 + 1_599, 6),
        (-(2**28) - 1, 2**29, 6),
    ],
)
def test_a_start_from_another_time_is_too_late(ahead: int, interval: int, result: int) -> None:
    now = 2**32 + 1_000
    rig = Rig().ready()
    assert rig.tell(FrameKind.PUSH, Record(0, 1, interval).pack(), now).result == 0
    assert rig.tell(FrameKind.START, wire.start_payload(now + ahead), now).result == result
    rig.twin.run(now + 2**33)
    assert rig.ticks() == ([now + ahead + interval] if not result else [])


def test_damaged_chunks_are_answered_and_empty_ones_are_not() -> None:
    rig = Rig().ready()
    rig.listen()
    rig.twin.receive(b"\0\0\0", 300)
    assert rig.listen() == []
    rig.twin.receive(b"\1\2\3\0" + b"\x22" * 81 + b"\0", 300)
    assert rig.listen() == [Answer(2, 0, 0, 1, UNO.slots, 0, 1, 0, 0, 0, 300)] * 2


def test_start_near_the_wrap_of_ticks_and_a_start_in_the_past() -> None:
    rig = Rig().ready()
    now = 2**32 - 1000
    rig.twin.run(now)
    assert rig.play(Record(0, 2, 5000), END, start=2**32 + 100, tick=now).result == 0
    rig.twin.run(now + 20_000)
    assert rig.ticks() == [2**32 + 5100, 2**32 + 10_100]
    assert rig.events()[-1] == ("REST", 255, "IDLE", 2, 15_100)
    assert rig.play(Record(0, 1, 50_000), END, start=now - 20_000, tick=now + 25_000).result == 0
    rig.twin.run(now + 60_000)
    assert rig.ticks()[2:] == [now + 30_000]


def test_reset_keeps_or_sets_the_position_and_forgets_the_queue() -> None:
    rig = Rig().ready()
    rig.tell(FrameKind.PUSH, pack([END, END]), 200)
    assert rig.tell(FrameKind.RESET, wire.reset_payload(-5), 300)[4:10] == (UNO.slots, 0, 1, 0, 0, -5)
    assert rig.tell(FrameKind.RESET, wire.reset_payload(None), 300).position == -5
    assert rig.tell(FrameKind.RESET, b"\x08\0\0\0\0", 300).result == 5


def test_an_event_that_was_never_there_is_not_repeated() -> None:
    rig = Rig()
    for number in (1, 255, 250):
        rig.tell(FrameKind.REPEAT, bytes((number,)), 50)
    assert len(rig.events()) == 1


def test_events_are_repeated_unchanged_while_they_are_among_the_last_eight() -> None:
    rig = Rig(reflex=[MARK]).ready()
    for at in range(10):
        rig.twin.set_input(0, 1, 1000 * at + 1000)
        rig.twin.set_input(0, 0, 1000 * at + 1500)
    rig.listen()
    told = [said for said in rig.heard if isinstance(said, BoardEvent)]
    assert [said.number for said in told] == [*range(1, 11)]
    rig.heard.clear()
    for number in (3, 10, 2, 11):
        rig.tell(FrameKind.REPEAT, bytes((number,)), 20_000, number=number)
    assert [said for said in rig.heard if isinstance(said, BoardEvent)] == [told[2], told[9]]
    assert [type(said) for said in rig.heard] == [Answer, BoardEvent, Answer, BoardEvent, Answer, Answer]


# -------------------------------------------------------------------------------------------------------------- motion
def test_steps_fall_at_the_computed_times_and_fractions_are_kept() -> None:
    rig = Rig().ready()
    rig.play(Record(0, 3, 1000, 0x8000, 0x4000), Record(DOWN, 2, 500, 0x4000), END)
    rig.twin.run(30_000)
    # 11000.5, +1000.75 = 12001.25, +1001 = 13002.25; +500.25 = 13502.5, +500.25 = 14002.75
    assert rig.twin.steps == [(11_000, 1, 1), (12_001, 1, 2), (13_002, 1, 3), (13_502, -1, 2), (14_002, -1, 1)]
    assert rig.events() == [("REST", 255, "IDLE", 1, 19_002)]
    assert rig.twin.next_time() is None


def test_a_slot_is_free_when_its_record_is_loaded() -> None:
    rig = Rig().ready()
    assert rig.play(Record(0, 2, 1000), Record(0, 1, 1000), END).free == UNO.slots - 2
    assert rig.tell(FrameKind.ASK, tick=11_999).free == UNO.slots - 2
    assert rig.tell(FrameKind.ASK, tick=12_000)[4:10] == (UNO.slots - 1, 1, 1, 0, PowerFlag.UNSURE, 2)


def test_phases_go_by_half_steps_or_by_full_steps() -> None:
    rig = Rig(pattern=FULL, phase=7).ready()
    rig.play(Record(0, 2, 1000), Record(HALF, 2, 1000), Record(DOWN | HALF, 1, 1000), Record(DOWN, 2, 1000), END)
    rig.twin.run(30_000)
    indices = [7, 1, 3, 4, 5, 4, 2, 0]
    assert [value for _, value in rig.twin.phases] == [FULL[index] for index in indices]
    assert [tick for tick, _ in rig.twin.phases] == [100, *range(11_000, 18_000, 1000)]


def test_outputs_are_set_by_frames_and_at_the_end_of_pauses() -> None:
    rig = Rig().ready()
    assert rig.tell(FrameKind.OUTPUTS, bytes((0b10011, 0b10001)), 200).result == 0
    assert rig.tell(FrameKind.OUTPUTS, bytes((32, 0)), 200).result == 5
    rig.play(Record(PAUSE | OUT, 0b11 << 8 | 0b10, 300), END)
    rig.twin.run(30_000)
    assert rig.twin.outputs == [(200, 0b10001), (10_300, 0b10010)]


def test_an_underrun_at_or_below_the_start_stop_rate_halts_at_the_last_step() -> None:
    rig = Rig(start_stop=1000).ready()
    rig.play(Record(0, 3, 1000))
    rig.twin.run(30_000)
    assert rig.ticks() == [11_000, 12_000, 13_000]
    assert rig.events() == [("UNDERRUN", 255, "HALT", 3, 13_000)]


def test_an_underrun_without_a_table_makes_each_interval_a_sixteenth_longer() -> None:
    rig = Rig(start_stop=1300).ready()
    rig.play(Record(0, 2, 1000), Record(DOWN, 3, 1000))
    rig.twin.run(30_000)
    # 1000 + 62 = 1062, + 66 = 1128, + 70 = 1198, + 74 = 1272, + 79 = 1351: beyond
    assert rig.ticks()[5:] == [16_062, 17_190, 18_388, 19_660]
    assert rig.events() == [("UNDERRUN", 255, "BRAKE", -1, 15_000), ("HALTED", 255, "HALT", -5, 19_660)]
    assert rig.tell(FrameKind.PUSH, pack([END]), 31_000).result == 4  # only RESET leaves HALT


def test_an_underrun_plays_the_table_from_the_first_slower_entry_on() -> None:
    rig = Rig(start_stop=5000).ready()
    entries = [(900 << 8, 7), (1000 << 8, 5), ((1000 << 8) + 128, 3), (3000 << 8, 1)]
    assert rig.tell(FrameKind.TAIL, wire.tail_payload(0, entries), 500).result == 0
    rig.play(Record(0, 2, 1000))
    rig.twin.run(30_000)
    assert rig.ticks()[2:] == [13_000, 14_001, 15_001, 18_001]
    assert rig.events()[-1] == ("HALTED", 255, "HALT", 6, 18_001)


@pytest.mark.parametrize(("start_stop", "steps"), [(1000, 2), (1061, 2), (1062, 3), (1001, 2)])
def test_where_a_tail_ends(start_stop: int, steps: int) -> None:
    rig = Rig(start_stop=start_stop).ready()
    rig.play(Record(0, 2, 1000))
    rig.twin.run(30_000)
    assert len(rig.ticks()) == steps


@pytest.mark.parametrize(("start_stop", "steps"), [(1000, 2), (1001, 3)])
def test_at_the_start_stop_rate_the_table_is_not_played(start_stop: int, steps: int) -> None:
    rig = Rig(start_stop=start_stop).ready()
    rig.tell(FrameKind.TAIL, wire.tail_payload(0, [(2000 << 8, 1)]), 500)
    rig.play(Record(0, 2, 1000))
    rig.twin.run(30_000)
    assert len(rig.ticks()) == steps


def test_rules_of_the_table() -> None:
    rig = Rig().ready()

    def tail(first: int, *entries: tuple[int, int]) -> int:
        return rig.tell(FrameKind.TAIL, wire.tail_payload(first, entries), 500).result

    low = 224 << 8
    assert tail(1, (low, 1)) == 5
    assert tail(0, (low - 1, 1)) == 5
    assert tail(0, (low, 0)) == 5
    assert tail(0, (low + 1, 1), (low, 1)) == 5
    assert tail(0, (low + 1, 1), (low + 1, 1)) == 0
    assert tail(2, (low, 1)) == 5  # less than the one before
    for first in range(2, 32, 10):
        assert tail(first, *[(low + 2, 1)] * 10) == 0
    assert len(rig.twin.table) == 32
    assert tail(31, *[(low + 2, 1)] * 9) == 0 and tail(31, *[(low + 2, 1)] * 10) == 3
    assert tail(5, (low + 3, 2)) == 0 and len(rig.twin.table) == 6
    assert tail(0, (low, 2)) == 0 and rig.twin.table == [(low, 2)]


def test_an_underrun_after_a_pause_brakes_from_the_last_step_but_not_immediately() -> None:
    rig = Rig(start_stop=12_000).ready()
    rig.play(Record(0, 3, 10_000), Record(PAUSE, 0, 9900))
    rig.twin.run(90_000)
    # from 40000: 50625, 61914, 73908; not before 49900 + 1200 = 51100: moved by 475
    assert rig.ticks()[3:] == [51_100, 62_389, 74_383]
    rig = Rig(start_stop=12_000).ready()
    rig.play(Record(0, 3, 10_000), Record(PAUSE, 0, 9000))
    rig.twin.run(90_000)
    assert rig.ticks()[3:] == [50_625, 61_914, 73_908]


@pytest.mark.parametrize(("lengths", "tail"), [((600, 599), 1), ((600, 600), 0), ((1200,), 0), ((1199,), 1)])
def test_pauses_after_which_a_motor_is_stopped_have_no_tail(lengths: tuple[int, ...], tail: int) -> None:
    rig = Rig(start_stop=1200).ready()
    rig.play(Record(0, 3, 1000), *(Record(PAUSE, 0, each) for each in lengths))
    rig.twin.run(30_000)
    assert len(rig.ticks()) == 3 + 3 * tail
    assert rig.events()[0] == ("UNDERRUN", 255, "BRAKE" if tail else "HALT", 3, 13_000 + sum(lengths))


def test_the_pace_is_that_of_the_last_two_steps_of_this_run() -> None:
    rig = Rig(start_stop=5000).ready()
    rig.play(Record(0, 1, 1000))
    rig.twin.run(30_000)
    assert rig.ticks() == [11_000] and rig.events() == [("UNDERRUN", 255, "HALT", 1, 11_000)]
    rig = Rig(start_stop=3000).ready()
    rig.play(Record(0, 2, 1000), Record(PAUSE, 0, 1000), Record(0, 1, 1800))
    rig.twin.run(30_000)
    assert rig.ticks()[2:] == [14_800, 14_800 + 2975]  # pace 2800; 2800 + 175


# ------------------------------------------------------------------------------------------------------------ commands
def test_stop_immediately_and_by_the_tail() -> None:
    rig = Rig(start_stop=1100).ready()
    rig.play(Record(0, 100, 1000), END)
    answer = rig.tell(FrameKind.STOP, b"\0", 12_000, number=200)
    assert answer[3:] == (0, UNO.slots, BoardState.HALT, 2, 0, PowerFlag.UNSURE, 2, 12_000)
    assert rig.events() == [("STOPPED", 255, "HALT", 2, 12_000)]
    assert isinstance(rig.heard[-2], BoardEvent)  # the answer counts the event, and comes behind it
    rig.twin.run(50_000)
    assert len(rig.ticks()) == 2
    rig.tell(FrameKind.RESET, wire.reset_payload(None), 50_000)
    rig.heard.clear()
    rig.play(Record(0, 100, 1000), END, start=60_000, tick=51_000)
    assert rig.tell(FrameKind.STOP, b"\1", 62_500).state == BoardState.BRAKE
    assert rig.tell(FrameKind.STOP, b"\1", 62_600).result == 0  # nothing more
    assert rig.tell(FrameKind.STOP, b"\2", 62_600).result == 5
    rig.twin.run(70_000)
    assert rig.ticks()[2:] == [61_000, 62_000, 63_000, 64_062]  # the one that was scheduled, then 1062
    assert rig.events() == [("BRAKED", 255, "BRAKE", 4, 62_500), ("HALTED", 255, "HALT", 6, 64_062)]
    assert rig.tell(FrameKind.STOP, b"\0", 80_000).result == 0 and len(rig.events()) == 2


def test_a_brake_before_there_is_a_pace_ends_with_the_step_that_is_scheduled() -> None:
    rig = Rig().ready()
    rig.play(Record(0, 100, 1000), END)
    rig.tell(FrameKind.STOP, b"\1", 10_500)
    rig.twin.run(70_000)
    assert rig.ticks() == [11_000]
    assert rig.events() == [("BRAKED", 255, "BRAKE", 0, 10_500), ("HALTED", 255, "HALT", 1, 11_000)]


def test_a_brake_in_a_pause() -> None:
    rig = Rig(start_stop=2000).ready()
    rig.play(Record(0, 3, 1500), Record(PAUSE, 0, 1900), END)
    rig.tell(FrameKind.STOP, b"\1", 14_800)  # last step at 14500; 1593 more; 1692, 1797, 1909
    rig.twin.run(70_000)
    assert rig.ticks()[3:] == [16_093, 17_785, 19_582, 21_491]
    rig = Rig(start_stop=1600).ready()
    rig.play(Record(0, 3, 1500), Record(PAUSE, 0, 1599), END)
    rig.tell(FrameKind.STOP, b"\1", 16_000)
    rig.twin.run(70_000)
    assert rig.ticks()[3:] == [17_200]
    rig = Rig(start_stop=1592).ready()
    rig.play(Record(0, 3, 1500), Record(PAUSE, 0, 1500), END)
    rig.tell(FrameKind.STOP, b"\1", 15_000)
    assert rig.events() == [("BRAKED", 255, "HALT", 3, 15_000)]


def test_the_watchdog_counts_from_the_last_frame_that_was_not_damaged() -> None:
    rig = Rig(start_stop=500, watchdog=5000).ready()
    rig.play(Record(0, 100, 1000), END)
    rig.tell(77, b"", 12_000)  # refused, but a frame
    rig.twin.receive(b"\1\2\3\0", 16_000)
    rig.twin.look_for_silence(16_999)
    assert rig.events() == []
    rig.twin.look_for_silence(17_000)
    rig.twin.run(60_000)
    assert rig.events() == [("WATCHDOG", 255, "BRAKE", 7, 17_000), ("HALTED", 255, "HALT", 8, 18_000)]
    rig.twin.look_for_silence(90_000)
    assert len(rig.events()) == 2


def test_check_counts_in_addition_to_the_position() -> None:
    rig = Rig().ready()
    assert rig.tell(FrameKind.CHECK, wire.check_payload(0, 1000), 500).result == 5
    assert rig.tell(FrameKind.CHECK, wire.check_payload(9, 255), 500).result == 5
    assert rig.tell(FrameKind.CHECK, wire.check_payload(9, 256), 500).result == 0
    rig.twin.checked(8, False, 9000)
    assert rig.events() == [("CHECKED", 1, "IDLE", 8, 9000)] and rig.twin.position == 0


# -------------------------------------------------------------------------------------------------------------- inputs
def test_stop_halts_without_a_further_step_in_its_direction() -> None:
    rig = Rig(reflex=[STOP + UPWARDS, STOP + DOWNWARDS]).ready()
    rig.play(Record(DOWN, 100, 1000), END)
    rig.twin.set_input(0, 1, 11_500)
    assert rig.twin.state == BoardState.RUN and rig.events() == []
    rig.twin.set_input(1, 1, 13_000)
    rig.twin.run(90_000)
    assert len(rig.ticks()) == 3 and rig.events() == [("STOPPED", 1, "HALT", -3, 13_000)]


def test_stop_in_the_tail() -> None:
    rig = Rig(reflex=[STOP]).ready()
    rig.play(Record(0, 3, 1000))
    rig.twin.set_input(0, 1, 15_000)
    rig.twin.run(90_000)
    assert rig.ticks()[3:] == [14_062] and rig.events()[1:] == [("STOPPED", 0, "HALT", 4, 15_000)]


def test_a_blocked_direction_is_not_started() -> None:
    rig = Rig(reflex=[STOP + DOWNWARDS]).ready()
    rig.twin.set_input(0, 1, 500)
    rig.play(Record(0, 2, 1000), Record(DOWN, 100, 1000), END)
    rig.twin.run(90_000)
    assert rig.ticks() == [11_000, 12_000] and rig.events() == [("STOPPED", 0, "HALT", 2, 12_000)]


def test_at_start_the_inputs_that_are_active_act_at_the_tick_of_start() -> None:
    rig = Rig(reflex=[MARK, STOP + UPWARDS]).ready()
    rig.twin.set_input(1, 1, 500)
    rig.twin.set_input(0, 1, 500)
    rig.heard.clear()
    rig.twin.take()
    answer = rig.play(Record(0, 2, 1000), END)
    assert answer.result == 0 and answer.state == BoardState.HALT
    assert rig.events() == [("STOPPED", 1, "HALT", 0, 10_000)]


def test_mark_reports_the_count_and_changes_nothing() -> None:
    rig = Rig(reflex=[MARK], report=1).ready()
    rig.play(Record(0, 3, 1000), END)
    rig.twin.set_input(0, 1, 12_000)
    rig.twin.set_input(0, 0, 12_001)
    rig.twin.run(90_000)
    assert rig.ticks() == [11_000, 12_000, 13_000]
    assert rig.events()[:2] == [("MARK", 0, "RUN", 2, 12_000), ("INPUT", 0, "RUN", 2, 12_001)]


def test_an_emergency_stop_halts_from_everywhere_and_is_not_reset_while_it_is_active() -> None:
    rig = Rig(reflex=[ESTOP]).ready()
    rig.tell(FrameKind.OUTPUTS, b"\x10\x10", 200)
    rig.play(Record(0, 3, 1000), END)
    rig.twin.set_input(0, 1, 11_500)
    assert rig.twin.outputs[-1] == (11_500, 0)  # ENABLE
    assert rig.tell(FrameKind.RESET, wire.reset_payload(None), 12_000).result == 4
    rig.twin.set_input(0, 0, 12_500)
    assert rig.twin.state == BoardState.HALT  # to release it starts nothing
    assert rig.tell(FrameKind.RESET, wire.reset_payload(None), 13_000).result == 0
    rig.twin.set_input(0, 1, 14_000)
    assert rig.events() == [("ESTOP", 0, "HALT", 1, 11_500), ("ESTOP", 0, "HALT", 1, 14_000)]
    assert rig.twin.state == BoardState.HALT


@pytest.mark.parametrize("off", [0, 1, 2])
def test_when_enable_goes_off(off: int) -> None:
    for number, expected in ((0, 0), (1, 16)):  # an emergency stop, and what halts
        rig = Rig(reflex=[ESTOP, STOP], enable_off=off, enable_hold=3).ready()
        assert rig.tell(FrameKind.OUTPUTS, b"\x10\x10", 200).flags == PowerFlag.ENERGISED
        rig.play(Record(0, 3, 1000), END)
        rig.twin.set_input(number, 1, 11_500)
        assert rig.twin.output == expected
        rig.twin.look_for_silence(3 * 65_536 - 1)
        assert rig.twin.output == expected
        rig.twin.look_for_silence(3 * 65_536)
        assert rig.twin.output == (expected if off == 0 else 0)


def test_an_edge_without_other_effect_is_reported_if_requested() -> None:
    rig = Rig(reflex=[STOP, STOP, BRAKE], report=0b111, active=0b1110).ready()
    rig.twin.set_input(1, 1, 500)  # in IDLE
    rig.twin.set_input(1, 1, 600)  # no edge
    rig.twin.set_input(1, 0, 700)
    rig.twin.set_input(5, 1, 800)  # not reported
    assert rig.events() == [("INPUT", 1, "IDLE", 0, 500), ("INPUT", 1, "IDLE", 0, 700)]
    assert rig.heard[0] == BoardEvent(1, 7, 1, 0, 0b10, 0, 500)


def test_in_boot_nothing_is_reported() -> None:
    rig = Rig()
    rig.events()
    rig.twin.set_input(0, 1, 50)
    assert rig.twin.take() == b""
