"""The wire: check values, frames that survive every cut, and every single damage that is found."""

from __future__ import annotations

import random

import pytest

from slewline.drive.board import wire
from slewline.drive.board.wire import Answer, BoardConfig, BoardEvent, Damaged, Decoder, Frame, FrameKind, Ident
from slewline.errors import UsageError


def test_the_crc_has_the_check_value_of_the_catalogue() -> None:
    assert wire.crc(b"123456789") == 0x906E
    assert wire.crc(b"") == 0


@pytest.mark.parametrize(
    ("plain", "stuffed"),
    [("", "01"), ("00", "0101"), ("0000", "010101"), ("11220033", "0311220233"), ("11000000", "0211010101")],
)
def test_cobs_as_in_its_paper(plain: str, stuffed: str) -> None:
    assert wire.stuff(bytes.fromhex(plain)).hex() == stuffed
    assert wire.unstuff(bytes.fromhex(stuffed)) == bytes.fromhex(plain)


def test_a_block_beyond_the_end_is_invalid_cobs() -> None:
    assert wire.unstuff(b"\x03\x11") is None
    assert wire.unstuff(b"\x02\x11\x02") is None
    assert wire.unstuff(b"\x03\x11\x22") == b"\x11\x22"


def test_a_frame_byte_by_byte() -> None:
    # crc(05 06) by the bits: the division of the catalogue, done by hand with the polynomial 0x8408
    value = 0xFFFF
    for byte in (5, 6):
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0x8408 if value & 1 else 0)
    value ^= 0xFFFF
    assert wire.encode(5, FrameKind.ASK) == bytes((5, 5, 6, value & 255, value >> 8, 0))


def frames(seed: int, count: int) -> list[Frame]:
    chance = random.Random(seed)
    return [
        Frame(
            chance.randrange(256),
            chance.randrange(256),
            bytes(chance.choices((0, 0, 1, 255, 77), k=chance.randrange(66))),
        )
        for _ in range(count)
    ]


def test_frames_arrive_however_the_line_cuts_them() -> None:
    chance, sent = random.Random(1), frames(2, 300)
    line = b"".join(wire.encode(*frame) + b"\0" * chance.randrange(3) for frame in sent)
    decoder, got = Decoder(), []
    while line:
        size = chance.randrange(1, 100)
        got += decoder.feed(line[:size])
        line = line[size:]
    assert got == sent


def test_no_damage_of_one_or_two_bits_is_taken_for_a_frame() -> None:
    for frame in frames(3, 8):
        whole = wire.encode(*frame)
        bits = range(8 * (len(whole) - 1))
        for one in bits:
            for two in (one, *random.Random(one).sample(bits, 10)):
                chunk = bytearray(whole)
                chunk[one // 8] ^= 1 << one % 8
                if two != one:
                    chunk[two // 8] ^= 1 << two % 8
                assert frame not in [*Decoder().feed(bytes(chunk))]
                assert all(isinstance(each, Damaged) for each in Decoder().feed(bytes(chunk)))


def test_a_zero_more_or_less_at_the_end_is_damage() -> None:
    """A CRC that is not inverted would be right with both."""
    found = 0
    for frame in frames(4, 5000):
        data = wire.unstuff(wire.encode(*frame)[:-1])
        assert data is not None
        if data[-1] == 0:
            found += 1
            for other in (data[:-1], data + b"\0"):
                assert all(isinstance(each, Damaged) for each in Decoder().feed(wire.stuff(other) + b"\0"))
    assert found > 5


def test_the_longest_chunk_and_one_byte_more() -> None:
    fits = wire.encode(1, 2, bytes(range(1, 76)))  # 2 + 75 + 2 bytes, and one of COBS
    assert len(fits) == 81
    assert [*Decoder().feed(fits)] == [Frame(1, 2, bytes(range(1, 76)))]
    (damaged,) = Decoder().feed(wire.encode(1, 2, bytes(range(1, 77))))
    assert isinstance(damaged, Damaged) and "80" in damaged.why


def test_a_chunk_without_an_end_is_not_kept_and_the_next_frame_arrives() -> None:
    decoder = Decoder()
    for _ in range(100):
        assert [*decoder.feed(b"\x55" * 1000)] == []
    assert len(decoder._chunk) <= 81
    damaged, frame = decoder.feed(b"\0" + wire.encode(7, 6))
    assert isinstance(damaged, Damaged) and frame == Frame(7, 6, b"")


def test_too_short_chunks_are_damaged() -> None:
    (damaged,) = Decoder().feed(wire.stuff(b"\x01" + wire.crc(b"\x01").to_bytes(2, "little")) + b"\0")
    assert isinstance(damaged, Damaged) and "3 bytes" in damaged.why


def test_messages_of_the_board_are_read_as_they_were_written() -> None:
    answer = Answer(3, 200, 2, 0, 79, 1, 9, 0x3F, 0x0F, -70000, 0xFFFFFFF0)
    event = BoardEvent(255, 12, 5, 4, 1, -1, 12)
    ident = Ident(0, 1, 1, 79, 48, 128, 224, 16_000_000)
    for said, frame in (
        (answer, wire.answer_frame(answer)),
        (event, wire.event_frame(event)),
        (ident, wire.ident_frame(ident)),
    ):
        (got,) = Decoder().feed(frame)
        assert isinstance(got, Frame) and wire.read(got) == said
        assert wire.read(got._replace(payload=got.payload + b"\0")) is None
    assert wire.read(Frame(0, 0x90, b"")) is None
    late = answer._replace(tick=2**32 + 5)
    (got,) = Decoder().feed(wire.answer_frame(late))
    assert isinstance(got, Frame) and wire.read(got) == answer._replace(tick=5)


def test_sizes_of_the_payloads() -> None:
    assert {kind.name: size for kind, size in wire.SIZES.items()} == {
        "HELLO": 0, "START": 4, "STOP": 1, "CONFIG": 32, "ASK": 0, "RESET": 5, "OUTPUTS": 2, "REPEAT": 1, "CHECK": 4,
        "ANSWER": 16, "IDENT": 11, "EVENT": 12,
    }  # fmt: skip


def test_payloads_of_the_host() -> None:
    reflex, pattern = (1, 2 + 16, 3, 4, 0, 1 + 32), (1, 3, 2, 6, 4, 12, 8, 9)
    config = BoardConfig(160_000, 1_600_000, 3, 5, 63, 1, 2, 0x1234, 8, 1, 4, reflex, pattern, 7)
    assert BoardConfig.unpack(config.pack()) == config
    assert config.pack()[:9].hex() == "00710200" + "006a1800" + "03"
    assert config.pack()[9:18].hex() == "05" + "3f" + "01" + "02" + "3412" + "08" + "41" + "01"
    assert wire.start_payload(2**32 + 258).hex() == "02010000" and wire.start_tick(b"\2\1\0\0") == 258
    assert wire.tail_entries(wire.tail_payload(3, [(70_000, 2), (2**32 - 1, 65_535)])) == (
        3,
        [(70_000, 2), (2**32 - 1, 65_535)],
    )
    assert (
        wire.tail_entries(b"\0") is None
        and wire.tail_entries(bytes(8)) is None
        and wire.tail_entries(bytes(67)) is None
    )
    assert wire.reset_payload(-2).hex() == "01feffffff" and wire.reset_position(bytes.fromhex("01feffffff")) == -2
    assert wire.reset_position(wire.reset_payload(None)) is None and wire.reset_position(wire.reset_payload(0)) == 0
    assert wire.check_numbers(wire.check_payload(1000, 1600)) == (1000, 1600)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("start_stop", 2**31), ("watchdog", -1), ("watchdog", 2**31), ("driver", 4), ("enable_hold", 65_536),
        ("filter", 16),
        ("fault_output", 5), ("power_output", 5), ("polarity", 4), ("active", 64), ("enable_off", 3), ("phase", 8),
        ("reflex", (5, 0, 0, 0, 0, 0)), ("reflex", (0,) * 5), ("reflex", (49, 0, 0, 0, 0, 0)), ("pattern", (0,) * 7),
        ("reflex", (19, 0, 0, 0, 0, 0)), ("pattern", (16,) * 8),
    ],
)  # fmt: skip
def test_a_configuration_that_a_board_would_refuse_is_refused(field: str, value: object) -> None:
    with pytest.raises(UsageError, match=f"{field} .*expected"):
        BoardConfig(**{"start_stop": 1000, field: value}).pack()  # type: ignore[arg-type]
