"""Packets of the MC1451A family over the port: words and checksums, and what becomes of packets that are not whole.

C 10  W 0234 5678  K 58bc        the checksum is the sum of code and words, in 16 bits
"""

from __future__ import annotations

from random import Random

import pytest
from mc import AXES, READY, T1, Rig, base, each, with_encoder

from tests.ensembles import few

GET_POS, GET_VEL = (0x4A, 2), (0x4B, 2)


def seen(rig: Rig) -> dict[str, dict[str, int]]:
    """All registers of all axes, but for the time."""
    axes = range(1, AXES[rig.x.sheet.part] + 1)
    return {f"axis {axis}": rig.x.registers_of(axis) | {"time": 0} for axis in axes}


# ------------------------------------------------------------------------------------------------------------ checksums
@each
@pytest.mark.fact("PMD-PKT-1", "PMD-PKT-2", "PMD-PKT-8")
def test_every_command_takes_and_returns_its_words_and_then_their_sum(part: str) -> None:
    random, rig = Random(part), base(part)
    for row in rig.x.sheet.commands:
        if row.name == "RESET":
            continue
        words = tuple(random.randrange(0x10000) for arg in row.args for _ in range(arg.size // 2))
        if row.name == "MULTI_UPDATE":
            words = (0,)
        reads = sum(arg.size for arg in row.reads) // 2
        *read, checksum = rig.packet(row.code, *words, reads=reads)
        assert checksum == (row.code + sum(words) + sum(read)) % 0x10000, row.name
        assert rig.host.read_word() == 0, row.name  # nothing is left
        wrong = {
            code for code in rig.codes if code not in ("out-of-range", "mode-in-motion", "gear-backlog", "no-encoder")
        }
        assert not wrong, row.name
        rig.x.findings.clear()


@pytest.mark.parametrize(
    "packet",
    [
        pytest.param("11 fedc ba98 > b985", marks=pytest.mark.fact("PMD-PKT-3")),
        pytest.param("6c > 5c11 5c7d", marks=pytest.mark.fact("PMD-PKT-4")),
        pytest.param("1a > 001a", marks=pytest.mark.fact("PMD-PKT-6")),
        pytest.param("33 > 0033", marks=pytest.mark.fact("PMD-PKT-6")),
        pytest.param("46 > 0046", marks=pytest.mark.fact("PMD-PKT-6")),
        pytest.param("01 > 0300 0301", marks=pytest.mark.fact("PMD-PKT-7")),
        pytest.param("10 ffff ffff > 000e", marks=pytest.mark.fact("PMD-PKT-8")),
        pytest.param("14 fff4 9c29 > 9c31", marks=pytest.mark.fact("PMD-PKT-13")),
        pytest.param("10 0012 d687 > d6a9", marks=pytest.mark.fact("PMD-PKT-13")),
    ],
)
def test_a_checksum(packet: str) -> None:
    base("mc1451a").says(packet)


@pytest.mark.fact("PMD-PKT-7")
def test_the_status_word_of_a_moving_axis_counts_in_the_checksum() -> None:
    rig = base("mc1251a")
    rig.begin(*T1)
    rig.says("01 > 0700 0701")


@pytest.mark.fact("PMD-PKT-13")
def test_numbers_with_a_sign_come_back_with_it() -> None:
    rig = base("mc1451a-e")
    for value, words in ((-746455, "fff4 9c29"), (1234567, "0012 d687"), (-1, "ffff ffff")):
        rig.do(f"SET_RATIO {value}")
        total = sum(int(word, 16) for word in words.split())
        rig.says(f"59 > {words} {(0x59 + total) % 0x10000:04x}")
        assert rig.shows("ratio") == value


@pytest.mark.fact("PMD-PKT-5", "PMD-UND-PACKET-ABORT")
@pytest.mark.parametrize("seed", few(range(5, 9), 1))
def test_checksums_need_not_be_read(seed: int) -> None:
    random, rig = Random(seed), base("mc1151a")
    for _ in range(25):
        values = [random.randrange(1 << 30) for _ in range(9)]
        for code, value in zip((0x10, 0x11, 0x12, 0x13, 0x14, 0x16, 0x6A), values, strict=False):
            rig.host.packet(code, value >> 16, value & 0xFFFF, checksum=False)
        for code, value in ((0x15, values[7] & 0x7FFF), (0x68, values[8] & 0x7FFF)):
            rig.host.packet(code, value, checksum=False)
        rig.host.packet(0x33, checksum=False)
        names = ("pos", "vel", "acc", "jerk", "ratio", "brk_pnt", "start_vel", "max_acc", "step_ratio")
        values[0] -= values[0] >> 29 << 30  # to be inside the range: 30 bits with sign
        found = [rig.shows(name) for name in names]
        assert found[1:] == [*values[1:7], values[7] & 0x7FFF, values[8] & 0x7FFF]
        assert found[0] % (1 << 30) == values[0] % (1 << 30)
    assert set(rig.codes) == {"no-encoder"}  # words that were not read are no mistake
    rig.says("31 > 0300 0331")


# ---------------------------------------------------------------------------------------------------- packets in pieces
@pytest.mark.parametrize("part", ["mc1251a", "mc1451a", "mc1251a-e", "mc1451a-e"])
@pytest.mark.fact("PMD-PKT-9")
def test_the_next_command_drops_what_was_not_read(part: str) -> None:
    rig = base(part)
    rig.host.write_command(0x02)
    rig.says("31 > 1300 1331")
    rig.host.write_command(0x1D)
    rig.host.read_word()
    rig.says("31 > 1300 1331")
    rig.host.write_command(0x1D)
    rig.host.read_byte()
    rig.says("31 > 1300 1331")
    assert rig.codes == []


@pytest.mark.fact("PMD-PKT-10", "PMD-UND-PACKET-ABORT")
def test_a_command_ends_a_packet_that_is_half_written() -> None:
    rig = base("mc1151a")
    rig.do("SET_POS 100")
    rig.host.write_command(0x10)
    rig.host.write_word(0x0000)
    rig.says("4a > 0000 0064 00ae")
    assert rig.codes == ["aborted-packet"]
    rig.host.write_command(0x10)
    rig.says("4a > 0000 0064 00ae", "10 0000 0065 > 0075", "4a > 0000 0065 00af")
    assert rig.codes == ["aborted-packet"] * 2


@pytest.mark.fact("PMD-PKT-11", "PMD-UND-ODD-BYTE")
def test_half_a_word_before_a_command_is_dropped() -> None:
    rig = base("mc1151a")
    rig.do("SET_VEL 0x23456")
    rig.host.write_command(0x11)
    rig.host.write_byte(0x12)
    rig.says("4b > 0002 3456 34a3")
    assert rig.codes == ["odd-byte", "aborted-packet"]
    rig.host.write_byte(0x55)
    rig.says("15 0012 > 0027", "4f > 0012 0061")  # and does not shift what follows
    assert rig.codes[2:] == ["odd-byte"]


@pytest.mark.fact("PMD-PKT-12", "PMD-UND-READ-BEYOND")
def test_after_the_checksum_there_are_zeros() -> None:
    rig = base("mc1151a", "hostrdy")
    for code, reads in ((0x1A, 0), (0x6C, 1), (0x4A, 2)):
        rig.packet(code, reads=reads)
        rig.next(2)
        since = rig.bench.now_ps
        assert (rig.host.read_word(), rig.host.read_word()) == (0, 0)
        rig.next()
        assert len(rig.falls("hostrdy", since)) == len(rig.rises("hostrdy", since)) == 2
    assert rig.codes == []


@pytest.mark.fact("PMD-PKT-16", "PMD-UND-WRITE-BEYOND")
def test_words_that_a_command_does_not_take_are_dropped() -> None:
    rig = base("mc1151a")
    rig.says("10 0000 0001 ffff > 0011", "4a > 0000 0001 004b", "1a 1234 > 001a", "15 0007 0008 > 001c")
    assert [code for code in rig.codes if code != "no-start"] == ["extra-word"] * 3
    assert (rig.shows("pos"), rig.shows("max_acc")) == (1, 7)


@pytest.mark.fact("PMD-UND-EARLY-READ")
def test_a_read_before_all_words_are_there_finds_0_and_the_packet_continues() -> None:
    rig = base("mc1151a")
    rig.host.write_command(0x10)
    assert rig.host.read_word() == 0
    rig.host.write_word(0x0012)
    assert rig.host.read_word() == 0
    rig.host.write_word(0x3456)
    assert (rig.host.read_word(), rig.shows("pos")) == (0x3478, 0x123456)
    assert rig.codes == ["early-read"] * 2


@pytest.mark.fact("PMD-UND-EARLY-WRITE")
def test_a_word_written_where_one_is_to_be_read_is_dropped_and_the_other_stays() -> None:
    rig = base("mc1151a")
    rig.do("SET_POS 0x123456")
    rig.host.write_command(0x4A)
    rig.host.write_word(0x7777)
    assert rig.host.read_word() == 0x0012
    rig.host.write_word(0x7777)
    assert (rig.host.read_word(), rig.host.read_word()) == (0x3456, 0x34B2)
    assert rig.codes == ["extra-word"] * 2


@with_encoder
@pytest.mark.fact("PMD-PKT-14", "PMD-UND-COMMAND-LATENCY")
def test_a_command_acts_though_its_checksum_is_never_read(part: str) -> None:
    rig = base(part)
    rig.do("SET_STEP_RATIO 256", *T1, "SET_POS 10", "UPDATE")
    rig.rest()
    assert rig.shows("actl_pos_err") == -10
    cycle = rig.next()
    rig.host.packet(0x29, 5, checksum=False)  # SET_POS_ERR
    assert rig.cycle == cycle
    rig.to(cycle + 1, -1)
    assert rig.shows("status") == 0x0301
    rig.to(cycle + 1)
    assert rig.shows("status") == 0x0311


@each
@pytest.mark.fact("PMD-PKT-15")
def test_a_repeated_packet_has_the_effect_of_one_good_packet(part: str) -> None:
    random, once, twice = Random(15), base(part), base(part)
    for rig in (once, twice):
        rig.do("LMTS_OFF")  # a garbled sense word would trip them
    for row in once.x.sheet.commands:
        if not row.args or row.name in ("MULTI_UPDATE", "RST_INTRPT", "RST_STATUS"):
            continue
        size = sum(arg.size for arg in row.args) // 2
        garbled, good = ([random.randrange(0x4000) for _ in range(size)] for _ in range(2))
        once.packet(row.code, *good)
        twice.packet(row.code, *garbled)
        twice.packet(row.code, *good)
        assert seen(once) == seen(twice), row.name


# --------------------------------------------------------------------------------------------------- what is no command
@each
@pytest.mark.fact("PMD-ERRC-1", "PMD-ERRC-2", "PMD-ERRC-11")
def test_illegal_codes_have_the_checksum_0_and_no_effect(part: str) -> None:
    rig = base(part)
    rig.do("SET_POS 5", "SET_INTRPT_MASK 0xFF")
    before = seen(rig)
    for code in (0x00, 0x22, *range(0x80, 0x100)):
        assert rig.packet(code) == (0,), f"{code:02x}"
    assert rig.codes == ["illegal-command"] * 130
    assert seen(rig) == before and rig.level("hostintrpt") == 1
    assert rig.status() & 0x80 == 0


@pytest.mark.fact("PMD-ERRC-3", "PMD-UND-ILLEGAL-DATA")
def test_words_after_an_illegal_code_are_dropped_and_all_reads_return_0() -> None:
    rig = base("mc1151a")
    rig.says("80 1234 5678 > 0000", "22 ffff > 0000", "ff > 0000 0000 0000 0000")
    assert rig.codes == ["illegal-command"] * 3  # its words are not told of besides


@pytest.mark.fact("PMD-ERRC-4")
def test_the_command_after_an_illegal_code_is_taken() -> None:
    rig = base("mc1151a")
    rig.says("ff > 0000", "31 > 0300 0331", "80 1234 > 0000", "10 0000 0007 > 0017", "4a > 0000 0007 0051")


@pytest.mark.parametrize(
    ("part", "packets"),
    [
        pytest.param(
            "mc1151a",
            ("02 > 0000", "03 > 0000", "04 > 0000", "31 > 0300 0331"),
            marks=pytest.mark.fact("PMD-ERRC-6", "PMD-UND-AXIS-ABSENT", "PMD-CON-ILLEGAL-34"),
        ),
        pytest.param(
            "mc1251a",
            ("02 > 1300 1302", "03 > 0000", "04 > 0000", "31 > 1300 1331"),
            marks=pytest.mark.fact("PMD-ERRC-5", "PMD-UND-AXIS-ABSENT", "PMD-CON-ILLEGAL-34"),
        ),
        pytest.param(
            "mc1451a",
            ("02 > 1300 1302", "03 > 2300 2303", "04 > 3300 3304", "31 > 3300 3331"),
            marks=pytest.mark.fact("PMD-ERRC-7", "PMD-CON-ILLEGAL-34"),
        ),
    ],
)
@pytest.mark.parametrize("encoder", ["", "-e"])
def test_axes_that_a_part_lacks_cannot_be_selected(part: str, packets: tuple[str, ...], encoder: str) -> None:
    base(part + encoder).says(*packets)


@each
@pytest.mark.fact("PMD-ERRC-8", "PMD-CON-RESERVED-4E")
def test_the_reserved_code_is_answered_and_does_nothing(part: str) -> None:
    rig = base(part)
    before = seen(rig)
    rig.says("49 > 0049")
    assert (seen(rig), rig.codes) == (before, [])


@each
@pytest.mark.fact("PMD-ERRC-9", "PMD-UND-CODES")
def test_codes_without_a_meaning_are_answered_do_nothing_and_are_reported(part: str) -> None:
    rig = base(part)
    before = seen(rig)
    codes = (*(0x0D, 0x0E, 0x1F, 0x20, 0x21, 0x23, 0x24, 0x2A, 0x2C, 0x3D, 0x3F, 0x5A, 0x5F, 0x63), *range(0x72, 0x80))
    for code in codes:
        rig.says(f"{code:02x} > {code:04x}")
    assert seen(rig) == before and rig.codes == ["undocumented-command"] * len(codes)


@each
@pytest.mark.fact("PMD-ERRC-10", "PMD-STAT-9", "PMD-UND-CODES")
def test_switching_an_axis_on_and_off_is_accepted_and_the_motion_continues(part: str) -> None:
    rig = base(part)
    begun = rig.begin(*T1)
    rig.says("41 > 0041", "40 > 0040")
    assert rig.status() == 0x0700
    rig.to(begun + 1062)
    assert rig.status() == 0x0700
    rig.rest()
    assert (rig.status(), rig.x.position, rig.codes) == (0x0301, 1000, [])


@pytest.mark.fact("PMD-ERRC-21")
@each
def test_a_command_error_lasts_until_it_is_cleared_and_can_interrupt(part: str) -> None:
    rig = base(part, "hostintrpt")
    rig.do("SET_INTRPT_MASK 0x80")
    begun = rig.begin(*T1)
    rig.to(begun + 500)
    refused = rig.update("SET_ACC 0x800")
    rig.to(refused, -1)
    assert rig.level("hostintrpt") == 1
    rig.to(refused)
    assert (rig.level("hostintrpt"), rig.status()) == (0, 0x0780)
    rig.rest()
    assert rig.status() == 0x0381
    rig.says("32 007f > 00b1")
    rig.next(2)
    assert (rig.level("hostintrpt"), rig.status()) == (1, 0x0301)
    assert [level for _, level in rig.edges("hostintrpt", rig.at(READY))] == [0, 1]
