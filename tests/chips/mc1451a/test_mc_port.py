"""The host port of the MC1451A family at its pins: strobes by hand, HostRdy, who drives the bus, what comes too early.

A chipset here has no host: the test drives the wires, and time passes by nanoseconds.
"""

from __future__ import annotations

from random import Random

import pytest
from mc import AXES, MS, NS, US, V1, Rig, base, each

import slewline
from tests.ensembles import few

TICK = 40 * NS
SLICE, CYCLE = 2048 * TICK, 8192 * TICK
MOVE_AT_ONCE = ((0x11, 1, 0), (0x12, 1, 0), (0x10, 0, 5))  # SET_VEL, SET_ACC: a step per cycle; SET_POS 5
UPDATE, GET_STATUS = 0x1A, 0x31
FLOATING = -1  # of a recorded bus


class Hand:
    """A chipset x, and a hand on the wires of its port."""

    def __init__(self, part: str = "mc1251a", **options: object) -> None:
        self.bench = slewline.Bench()
        self.x = self.bench.add(part, name="x", **options)
        self.bench.record("x.hostrdy", "x.hostdata", "x.atrest1")
        self.bench.run_until(self.x.pin("hostrdy").is_(1))
        self.begun = self.bench.now_ps
        self.strobed: list[int] = []  # when strobes have ended

    # ------------------------------------------------------------------------------------------------------------ wires
    def put(self, **levels: int) -> None:
        for pin, level in levels.items():
            self.x.pin(pin).drive(level)

    def bus(self, byte: int | None) -> None:
        for bit in range(8):
            pin = self.x.pin(f"hostdata{bit}")
            pin.release() if byte is None else pin.drive(byte >> bit & 1)

    def ns(self, time: int) -> None:
        self.bench.run(time * NS)

    # ---------------------------------------------------------------------------------------------------------- strobes
    def write(self, byte: int, command: int = 0, low: int = 50, slct: int = 0) -> None:
        """Strobe a byte in, with the shortest times of the data sheet."""
        self.put(hostslct=slct, hostcmd=command)
        self.bus(byte)
        self.ns(10)
        self.put(hostwrite=0)
        self.ns(low)
        self.put(hostwrite=1)
        self.strobed.append(self.bench.now_ps)
        self.ns(30)
        self.bus(None)
        self.put(hostslct=1, hostcmd=0)
        self.ns(20)

    def read(self, low: int = 50, command: int = 0, slct: int = 0) -> int | None:
        """Strobe a byte out; None if nobody drives the bus."""
        self.put(hostslct=slct, hostcmd=command)
        self.ns(20)
        self.put(hostread=0)
        self.ns(low)
        level = self.x.bus.level
        byte = self.x.bus.byte
        self.put(hostread=1)
        self.strobed.append(self.bench.now_ps)
        self.ns(50)
        self.put(hostslct=1, hostcmd=0)
        return None if level is None else byte

    def ready(self) -> None:
        self.bench.run_until(self.x.pin("hostrdy").is_(1), timeout="1 ms")

    # ---------------------------------------------------------------------------------------------------------- packets
    def command(self, byte: int) -> None:
        self.ready()
        self.write(byte, command=1)

    def word(self, word: int) -> None:
        self.ready()
        self.write(word >> 8)
        self.write(word & 0xFF)

    def read_word(self) -> int:
        self.ready()
        high, low = self.read(), self.read()
        assert high is not None and low is not None
        return high << 8 | low

    def packet(self, code: int, *words: int, reads: int = 0) -> list[int]:
        """A packet; returns what is read behind it, the checksum last."""
        self.command(code)
        for word in words:
            self.word(word)
        return [self.read_word() for _ in range(reads + 1)]

    # -------------------------------------------------------------------------------------------------------- questions
    def edges(self, pin: str) -> list[tuple[int, object]]:
        times, levels = self.bench.edges(f"x.{pin}")
        return [(int(time), level) for time, level in zip(times, levels.tolist(), strict=True) if time > self.begun]

    @property
    def busy(self) -> list[tuple[int, int]]:
        """When HostRdy fell, and how long it was low."""
        times = [time for time, _ in self.edges("hostrdy")]
        return [(fall, rise - fall) for fall, rise in zip(times[::2], times[1::2], strict=False)]

    @property
    def codes(self) -> list[str]:
        return [found.code for found in self.x.findings]


# ------------------------------------------------------------------------------------------------- the three operations
@each
@pytest.mark.fact("PMD-HOST-1", "PMD-HOST-12", "PMD-UND-BUSY-TIME", "PMD-CON-BUSY", "PMD-CON-HOSTCMD-BAR")
def test_a_packet_is_seven_strobes_and_does_what_a_host_does(part: str) -> None:
    hand = Hand(part)
    assert hand.packet(0x10, 0x0234, 0x5678) == [0x58BC]
    assert len(hand.strobed) == 1 + 2 + 2 + 2
    assert hand.packet(0x4A, reads=2) == [0x0234, 0x5678, 0x58F6]
    assert hand.x.registers["pos"] == 0x02345678 and hand.codes == []
    rig = base(part)
    rig.host.command("SET_POS", 0x02345678)
    assert rig.host.received == [0x58BC] and rig.shows("pos") == 0x02345678


@pytest.mark.fact("PMD-HOST-2", "PMD-CON-HOSTCMD-BAR")
def test_a_byte_is_a_command_while_hostcmd_is_high_and_half_a_word_while_it_is_low() -> None:
    hand = Hand()
    hand.command(GET_STATUS)
    assert [hand.read_word(), hand.read_word()] == [0x0300, 0x0331]
    hand = Hand()
    hand.write(GET_STATUS)
    assert hand.edges("hostrdy") == []  # half a word
    hand.write(GET_STATUS)
    hand.ready()
    assert len(hand.busy) == 1 and hand.codes == []  # nobody waited for it, but it was a word
    assert hand.read_word() == 0


@pytest.mark.fact("PMD-HOST-3", "PMD-HOST-4")
def test_the_high_byte_goes_first() -> None:
    hand = Hand("mc1451a")
    hand.command(0x11)
    for byte in (0x00, 0x02, 0xC0, 0x00):
        hand.ready()
        hand.write(byte)
    assert hand.packet(0x4B, reads=2) == [0x0002, 0xC000, 0xC04D]
    hand.command(0x6C)
    hand.ready()
    assert (hand.read(), hand.read()) == (0x5C, 0x11)


# -------------------------------------------------------------------------------------------------------------- HostRdy
@pytest.mark.fact("PMD-HOST-5", "PMD-HOST-6", "PMD-HOST-7", "PMD-HOST-8", "PMD-TIME-4", "PMD-UND-BUSY-TIME")
def test_hostrdy_falls_with_the_last_strobe_of_an_operation_for_a_slice() -> None:
    hand = Hand()
    hand.packet(0x11, 0x0002, 0xC000)
    hand.packet(0x4B, reads=2)
    hand.ready()
    command, _, high, _, low, _, checksum = hand.strobed[:7]
    ends = [command, high, low, checksum]  # of the two strobes of a word, the second
    ends[1:] = hand.strobed[2:7:2]
    again = hand.strobed[7:]
    ends += [again[0], *again[2::2]]
    assert [fall for fall, _ in hand.busy] == ends
    clock = hand.x.clock
    for fall, low_ps in hand.busy:  # up to the clock that ends the slice
        assert fall + low_ps == clock.ps(clock.ticks_from(fall) + 2048)
        assert SLICE <= low_ps < SLICE + TICK
    assert hand.codes == []


@pytest.mark.fact("PMD-HOST-7", "PMD-UND-BUSY-TIME")
def test_a_slice_is_a_slice_while_four_axes_move() -> None:
    rig = base("mc1451a-e", "hostrdy")
    for axis in range(1, 5):
        rig.do(*V1, axis=axis)
    rig.do("MULTI_UPDATE 15")
    rig.next(3)
    since = rig.bench.now_ps
    rig.do("GET_TRGT_POS", "SET_POS 5", "SET_2", "UPDATE")
    rig.to(rig.cycle + 1)
    clock = rig.x.clock
    falls, rises = rig.falls("hostrdy", since), rig.rises("hostrdy", since)
    assert len(falls) == 4 + 4 + 3 + 2
    assert rises == [clock.ps(clock.ticks_from(fall) + 2048) for fall in falls]


@pytest.mark.fact("PMD-HOST-13")
def test_a_packet_is_a_slice_for_its_command_and_one_for_each_word() -> None:
    for send, slices in (
        (lambda hand: hand.command(UPDATE), 1),
        (lambda hand: (hand.command(0x15), hand.word(7)), 2),
        (lambda hand: hand.packet(UPDATE), 2),
        (lambda hand: (hand.command(0x10), hand.word(0), hand.word(7)), 3),
        (lambda hand: hand.packet(0x10, 0, 7), 4),
    ):
        hand = Hand()
        send(hand)
        hand.ready()
        assert len(hand.busy) == slices
        lasts = hand.bench.now_ps - (hand.strobed[0] - 50 * NS)
        assert slices * SLICE < lasts < slices * SLICE + US


@pytest.mark.fact("PMD-UND-COMMAND-LATENCY", "PMD-CON-UPDATE-WHEN")
@pytest.mark.parametrize(("early", "begins"), [(1, 0), (0, 1), (-1, 1)])
def test_an_update_that_is_ready_at_the_start_of_a_cycle_waits_for_the_next_one(early: int, begins: int) -> None:
    hand = Hand()
    clock, origin = hand.x.clock, hand.x._cycle_clock.origin
    for code, high, low in MOVE_AT_ONCE:
        hand.packet(code, high, low)
    hand.ready()
    cycle = (clock.ticks_until(hand.bench.now_ps) - origin) // 8192 + 2
    tick = origin + 8192 * cycle
    hand.bench.run_to(clock.ps(tick - early - 2048) - 60 * NS)
    hand.write(UPDATE, command=1)
    hand.bench.run("10 ms")
    assert hand.busy[-1][0] == clock.ps(tick - early - 2048)
    assert hand.edges("atrest1")[0] == (clock.ps(tick + 8192 * begins), 0)


@pytest.mark.fact("PMD-UND-COMMAND-LATENCY")
def test_a_command_acts_in_the_instant_in_which_hostrdy_rises_and_read_values_are_frozen_then() -> None:
    hand = Hand()
    hand.packet(0x10, 0, 1)
    hand.command(0x10)
    hand.word(0)
    hand.word(2)
    ready = hand.strobed[-1] + SLICE
    hand.bench.run_to(ready - TICK)
    assert hand.x.registers["pos"] == 1
    hand.ready()
    assert hand.x.registers["pos"] == 2
    hand.command(0x3E)
    hand.ready()
    time = hand.x.registers["time"]
    hand.bench.run("1 s")
    assert [hand.read_word(), hand.read_word()] == [0, time]
    assert hand.x.registers["time"] > time + 3000


@pytest.mark.fact("PMD-HOST-14")
def test_both_words_of_a_number_come_from_one_cycle() -> None:
    rig = base("mc1151a-e")
    rig.do("SET_OUTPUT_HIGH", "SET_PRFL_VEL", "SET_VEL 0x2000000", "SET_ACC 0x2000000")
    begun = rig.begin()
    carried = 0
    for _ in range(100):
        rig.host.write_command(0x1D)
        rig.bench.run_until(rig.x.pin("hostrdy").is_(1))
        position = 512 * (rig.cycle - begun)
        high = rig.host.read_word()
        rig.bench.run("10 ms")
        assert (high << 16 | rig.host.read_word()) == position
        carried += rig.shows("trgt_pos") >> 16 != high
    assert carried > 10  # in so many pauses the high word has become another one


@pytest.mark.fact("PMD-UND-READY-RESET")
@each
def test_the_port_is_ready_at_the_start_of_cycle_10_and_the_first_word_is_0(part: str) -> None:
    hand = Hand(part)
    assert hand.begun == US + 10 * CYCLE  # behind the power-up reset
    assert (hand.read_word(), hand.read_word(), hand.codes) == (0, 0, [])
    hand.packet(GET_STATUS, reads=1)
    hand.put(reset=0)
    hand.ns(2000)
    hand.put(reset=1)
    ends = hand.bench.now_ps
    assert hand.x.pin("hostrdy").level == 0
    hand.bench.run_until(hand.x.pin("hostrdy").is_(1))
    assert hand.bench.now_ps == ends + 10 * CYCLE
    assert hand.read_word() == 0


# ------------------------------------------------------------------------------------------------ selection and the bus
@each
@pytest.mark.fact("PMD-HOST-9")
def test_while_hostslct_is_high_nothing_is_taken_and_nothing_driven(part: str) -> None:
    hand = Hand(part)
    for code, high, low in MOVE_AT_ONCE:
        hand.packet(code, high, low)
    hand.ready()
    before = len(hand.edges("hostrdy")), len(hand.edges("hostdata"))
    hand.write(UPDATE, command=1, slct=1)
    assert hand.read(low=200, slct=1) is None
    hand.bench.run("5 ms")
    assert len(hand.edges("hostrdy")) == before[0]
    assert {level for _, level in hand.edges("hostdata")[before[1] :]} <= {UPDATE, FLOATING}
    assert hand.edges("atrest1") == [] and hand.codes == []
    hand.packet(UPDATE)
    hand.bench.run("1 ms")
    assert hand.edges("atrest1")[0][1] == 0


@pytest.mark.fact("PMD-HOST-9")
def test_a_strobe_that_is_selected_after_its_start_does_not_count() -> None:
    hand = Hand()
    hand.put(hostcmd=1)
    hand.bus(UPDATE)
    hand.put(hostwrite=0)
    hand.ns(50)
    hand.put(hostslct=0)
    hand.ns(50)
    hand.put(hostwrite=1)
    hand.ns(100)
    assert hand.edges("hostrdy") == []


@pytest.mark.fact("PMD-HOST-9", "PMD-HOST-10")
def test_a_read_that_is_deselected_before_its_end_does_not_count() -> None:
    hand = Hand()
    hand.packet(0x11, 0x1234, 0x5678)
    hand.command(0x4B)
    hand.ready()
    before = len(hand.edges("hostdata"))
    began = hand.bench.now_ps
    hand.put(hostslct=0, hostread=0)
    hand.ns(100)
    hand.put(hostslct=1)
    hand.ns(100)
    hand.put(hostread=1)
    hand.bench.run("1 us")
    assert hand.edges("hostdata")[before:] == [(began + TICK, 0x12), (began + 100 * NS + TICK, FLOATING)]
    assert [hand.read_word(), hand.read_word()] == [0x1234, 0x5678]


@pytest.mark.fact("PMD-HOST-10")
@pytest.mark.parametrize("low", [50, 1000])
def test_the_bus_is_driven_from_40_ns_after_the_start_of_a_read_to_40_ns_after_its_end(low: int) -> None:
    hand = Hand()
    hand.packet(0x11, 0x1234, 0x5678)
    hand.command(0x4B)
    hand.ready()
    before = len(hand.edges("hostdata"))
    began = hand.bench.now_ps
    hand.read(low)
    ended = hand.strobed[-1]
    hand.bench.run("1 us")
    assert hand.edges("hostdata")[before:] == [(began + 20 * NS + TICK, 0x12), (ended + TICK, FLOATING)]
    assert hand.x.bus.level is None


@pytest.mark.fact("PMD-HOST-18")
@pytest.mark.parametrize("between", ["hostslct", "hostcmd"])
def test_hostslct_and_hostcmd_may_change_between_the_bytes_of_a_word(between: str) -> None:
    hand = Hand()
    hand.command(0x15)
    hand.ready()
    hand.write(0x12)
    hand.put(**{between: 1})
    hand.bench.run("3 us")
    hand.put(**{between: 0})
    hand.write(0x34)
    assert hand.read_word() == 0x1249
    hand.command(0x4F)
    hand.ready()
    high = hand.read()
    hand.put(**{between: 1})
    hand.bench.run("3 us")
    hand.put(**{between: 0})
    assert (high, hand.read(), hand.codes) == (0x12, 0x34, [])


# -------------------------------------------------------------------------------------------------------- short strobes
@pytest.mark.fact("PMD-HOST-11")
def test_strobes_that_are_too_short_or_too_close_are_found_and_taken_all_the_same() -> None:
    def word(low: int, recovery: int) -> list[str]:
        hand = Hand()
        hand.command(0x11)
        hand.word(0)
        hand.ready()
        hand.write(0x12, low=low)
        hand.ns(recovery - 60)  # 20 ns before a strobe, 30 + 20 behind it, and 10 more
        hand.write(0x34, low=low)
        assert hand.packet(0x4B, reads=2)[:2] == [0, 0x1234]
        return hand.codes

    assert word(50, 60) == word(50, 200) == word(500, 60) == []
    assert word(49, 60) == ["short-strobe"] * 2
    assert word(50, 60) == []


@pytest.mark.fact("PMD-HOST-11")
@pytest.mark.parametrize(("recovery", "codes"), [(60, []), (59, ["short-recovery"])])
def test_two_strobes_are_60_ns_apart(recovery: int, codes: list[str]) -> None:
    hand = Hand()
    hand.command(0x6C)
    hand.ready()
    hand.put(hostslct=0)
    found = []
    for _ in range(2):
        hand.put(hostread=0)
        hand.ns(50)
        found.append(hand.x.bus.byte)
        hand.put(hostread=1)
        hand.ns(recovery)
    assert (found, hand.codes) == ([0x4C, 0x11], codes)


# ---------------------------------------------------------------------------------------------------- against the rules
@pytest.mark.fact("PMD-HOST-15", "PMD-UND-BUSY-ACCESS")
def test_words_sent_while_hostrdy_is_low_are_lost_and_the_packet_continues() -> None:
    hand = Hand()
    for code, high, low in MOVE_AT_ONCE:
        hand.packet(code, high, low)
    hand.command(0x11)
    hand.ready()
    hand.word(0x0001)
    hand.write(UPDATE, command=1)  # at once: the word is being worked
    hand.write(0x55)
    assert hand.x.pin("hostrdy").level == 0
    hand.word(0x0000)
    assert hand.read_word() == 0x0012
    hand.bench.run("2 ms")
    assert hand.codes == ["busy-access"] * 2
    assert hand.edges("atrest1") == [] and hand.x.registers["vel"] == 0x10000


@pytest.mark.fact("PMD-UND-BUSY-ACCESS")
def test_a_read_while_hostrdy_is_low_finds_the_byte_that_was_read_last() -> None:
    hand = Hand()
    hand.command(0x6C)
    hand.ready()
    assert (hand.read(), hand.read()) == (0x4C, 0x11)
    assert (hand.read(), hand.read(), hand.read()) == (0x11, 0x11, 0x11)  # busy
    assert hand.codes == ["busy-access"] * 3
    assert hand.read_word() == 0x4C7D  # the checksum, whole


@pytest.mark.fact("PMD-UND-STROBES")
def test_both_strobes_together_transfer_nothing() -> None:
    hand = Hand()
    hand.command(0x6C)
    hand.ready()
    before = len(hand.busy), len(hand.edges("hostdata"))
    hand.put(hostslct=0, hostread=0)
    hand.ns(10)
    hand.put(hostwrite=0)
    hand.ns(50)
    hand.put(hostwrite=1)
    hand.put(hostread=1)
    hand.put(hostslct=1)
    hand.ns(100)
    hand.put(hostslct=0, hostwrite=0)
    hand.ns(10)
    hand.put(hostread=0)
    hand.ns(100)
    assert hand.x.bus.level is None
    hand.put(hostread=1)
    hand.put(hostwrite=1)
    hand.put(hostslct=1)
    hand.bench.run("1 ms")
    assert hand.codes == ["strobes"] * 2 and len(hand.busy) == before[0]


@pytest.mark.fact("PMD-UND-STROBES")
def test_a_read_with_hostcmd_high_transfers_nothing() -> None:
    hand = Hand()
    hand.command(0x6C)
    hand.ready()
    assert hand.read(command=1) is None
    assert hand.codes == ["strobes"]
    assert [hand.read_word(), hand.read_word()] == [0x4C11, 0x4C7D]


@pytest.mark.fact("PMD-UND-RELEASE-2US", "PMD-UND-DIAGNOSTICS")
@pytest.mark.parametrize(("late", "codes"), [(2000, []), (2001, ["late-release"])])
def test_hostslct_may_stay_low_for_2_us_after_a_transfer(late: int, codes: list[str]) -> None:
    hand = Hand()
    hand.put(hostslct=0, hostcmd=1)
    hand.bus(GET_STATUS)
    hand.put(hostwrite=0)
    hand.ns(50)
    hand.put(hostwrite=1)
    hand.ns(30)
    hand.bus(None)
    hand.put(hostcmd=0)
    hand.ns(late - 30)
    hand.put(hostslct=1)
    assert hand.codes == codes
    assert [hand.read_word(), hand.read_word()] == [0x0300, 0x0331]


# ------------------------------------------------------------------------------------------------------- whenever it is
def setting(random: Random) -> tuple[str, str, int]:
    """A command that changes nothing in motion before an update, the one that reads it, and a number."""
    name = random.choice(("POS", "VEL", "JERK", "START_VEL", "BRK_PNT", "MAX_ACC", "STEP_RATIO"))
    return f"SET_{name}", f"GET_{name}", random.randrange(32768 if name in ("MAX_ACC", "STEP_RATIO") else 1 << 29)


@pytest.mark.fact("PMD-HOST-16")
@pytest.mark.parametrize("part", few(["mc1451a", "mc1251a", "mc1151a"], 1))
def test_the_port_works_the_same_while_axes_move_and_disturbs_none_of_them(part: str) -> None:
    def moving(talks: int) -> Rig:
        random, rig, axes = Random(16), base(part), AXES[part]
        for axis in range(1, axes + 1):
            rig.do(f"SET_POS {10_000 * axis}", f"SET_VEL {0x5000 * axis}", "SET_ACC 0x123", axis=axis)
        rig.do(f"MULTI_UPDATE {2**axes - 1}")
        rig.to(100)
        rig.do("MTR_OFF", axis=axes)  # one of them is off on the way
        rig.to(150)
        for _ in range(talks):
            written, read, value = setting(random)
            axis = random.randrange(1, axes + 1)
            rig.do(f"{written} {value}", axis=axis)
            assert rig.do(read, axis=axis) == value
        rig.to(2000)
        return rig

    talkative, quiet = moving(200), moving(0)
    assert {found.code for found in talkative.x.findings} <= {"no-encoder", "start-velocity"}
    for axis in range(1, AXES[part] + 1):
        assert talkative.pulses(axis=axis) == quiet.pulses(axis=axis)
    assert len(quiet.pulses()) > (0 if AXES[part] == 1 else 500)


@pytest.mark.fact("PMD-HOST-17")
def test_a_host_may_take_ten_seconds_between_the_parts_of_a_packet() -> None:
    rig = base("mc1151a")
    rig.host.write_command(0x11)
    for half in (0x00, 0x02, 0xC0, 0x00):
        rig.bench.run("10 s")
        rig.host.write_byte(half)
    rig.bench.run("10 s")
    assert (rig.host.read_word(), rig.shows("vel"), rig.codes) == (0xC013, 0x2C000, [])


@pytest.mark.fact("PMD-UND-DIAGNOSTICS")
def test_findings_change_nothing_that_a_host_sees() -> None:
    def told(*mistakes: tuple[int, ...]) -> tuple[list[int], dict[str, int]]:
        hand = Hand()
        for code, *words in mistakes:
            hand.packet(code, *words)
        assert bool(hand.codes) == bool(mistakes)
        hand.bench.run_to(100 * MS)
        words = [word for code in (GET_STATUS, 0x48, 0x4A, 0x37) for word in hand.packet(code, reads=2)]
        return words, hand.x.registers

    assert told((0x10, 1), (0x00,), (0x0D,), (0x33, 7), (0x80, 5)) == told()
