"""Memories on a bus: what they latch, take and show, how an EEPROM writes, and what it keeps without power."""

from __future__ import annotations

from random import Random

import pytest

import slewline
from slewline.core.memory.image import SIZES
from slewline.core.memory.store import BufferedStore, Memory
from slewline.errors import BenchFileError, StoreError, UsageError
from slewline.links.lines.memory_file import FileStore
from tests.parts.bus_master import BusMaster
from tests.rows import rows

every_kind = rows("kind", ["ram", "eeprom", "eprom"])
IMAGE = Random(1).randbytes(300)


# --------------------------------------------------------------------------------------------------------------- cycles
@every_kind
def test_a_memory_is_read_at_the_address_in_its_latches(kind: str) -> None:
    bus = BusMaster(kind, image=IMAGE)
    assert [bus.read(address) for address in (0, 1, 255, 256, 299)] == [IMAGE[n] for n in (0, 1, 255, 256, 299)]
    assert bus.read(300) == 0xFF and bus.floats


@every_kind
def test_the_bus_is_driven_while_selected_and_rd_is_low_only(kind: str) -> None:
    bus = BusMaster(kind, image=IMAGE)
    bus.put("rd", 0)
    bus.pass_time()
    assert bus.floats  # not selected
    bus.put("rd", 1)
    bus.address(7)
    bus.on_bus(None)
    assert bus.floats  # no rd
    bus.put("rd", 0)
    bus.pass_time()
    assert not bus.floats
    bus.put("select", 1)
    bus.pass_time()
    assert bus.floats


def test_a_byte_is_taken_at_the_rise_of_wr() -> None:
    bus = BusMaster("ram")
    bus.address(0x1234)
    bus.on_bus(0x11)
    bus.put("wr", 0)
    bus.pass_time()
    assert bus.part.content[0x1234] == 0xFF
    bus.on_bus(0x22)
    bus.pass_time()
    bus.put("wr", 1)
    bus.pass_time()
    assert bus.part.content[0x1234] == 0x22 and bus.part.content.count(0xFF) == 65535


def test_a_deselected_memory_takes_nothing() -> None:
    bus = BusMaster("ram")
    bus.write(5, 0x33)
    bus.put("select", 1)
    bus.on_bus(0x44)
    bus.put("wr", 0)
    bus.pass_time()
    bus.put("wr", 1)
    bus.pass_time()
    assert bus.part.content[:8] == b"\xff" * 5 + b"\x33" + b"\xff" * 2


def test_a_memory_is_one_of_many_bytes() -> None:
    bus, chance, held = BusMaster("ram"), Random(2), {}
    for _ in range(300):
        address, byte = chance.randrange(65536), chance.randrange(256)
        bus.write(address, byte)
        held[address] = byte
    assert all(bus.part.content[address] == byte for address, byte in held.items())
    assert all(bus.read(address) == byte for address, byte in held.items())


# --------------------------------------------------------------------------------------------------------------- mirror
@every_kind
@rows("size", SIZES)
def test_a_dump_of_a_smaller_part_is_mirrored(kind: str, size: int) -> None:
    dump = Random(size).randbytes(size)
    bus = BusMaster(kind, image=dump)
    assert bus.part.size == size and bus.part.content == dump
    for address in (5, size - 1, size % 65536, 65535, 65536 - size):
        assert bus.read(address) == dump[address % size]


def test_a_write_into_the_mirror_lands_in_the_part() -> None:
    bus = BusMaster("ram", size=32768)
    bus.write(0x8005, 0x5A)
    assert bus.part.content[5] == 0x5A and bus.read(5) == 0x5A


def test_an_image_that_does_not_fit_is_refused() -> None:
    with pytest.raises(UsageError, match="p: 3000 bytes at address 0 do not fit; the part has 2048 bytes"):
        BusMaster("ram", size=2048, image=bytes(3000))
    with pytest.raises(UsageError, match=r"p: size 1000; allowed 2048, 4096, 8192, 16384, 32768, 65536, None"):
        BusMaster("ram", size=1000)
    ram = BusMaster("ram").part
    with pytest.raises(UsageError, match="p: 2 bytes at address 65535 do not fit; the part has 65536 bytes"):
        ram.load(b"ab", 65535)
    with pytest.raises(UsageError, match="p: 1 bytes at address -1 do not fit"):
        ram.load(b"a", -1)


# --------------------------------------------------------------------------------------------------------------- EPROM
def test_an_eprom_takes_nothing_and_reports_it_once() -> None:
    bus = BusMaster("eprom", image=b"N 1\r")
    bus.write(0x0001, 0x41)
    bus.write(0x0002, 0x41)
    assert bus.part.content[:4] == b"N 1\r"
    assert [found.code for found in bus.part.findings] == ["read-only"]
    assert "41 was written to address 0001 of an EPROM" in bus.part.findings[0].text
    bus.part.load(b"N 2\r")  # out of its socket, a programmer writes it
    assert bus.read(2) == ord("2")


# -------------------------------------------------------------------------------------------------------------- EEPROM
def test_an_eeprom_shows_bit_7_inverted_until_the_byte_is_written() -> None:
    bus = BusMaster("eeprom", write_time="5 ms")
    bus.write(0x1234, 0x41)
    assert bus.read(0x1234) == 0xC1 and not bus.part.idle
    bus.pass_time("4.9 ms")
    assert bus.read(0x1234) == 0xC1 and bus.part.content[0x1234] == 0xFF
    bus.pass_time("0.1 ms")
    assert bus.read(0x1234) == 0x41 and bus.part.content[0x1234] == 0x41 and bus.part.idle


def test_a_read_that_lasts_sees_the_end_of_the_write() -> None:
    bus = BusMaster("eeprom")
    bus.write(9, 0x41)
    assert bus.read(9, ends=False) == 0xC1
    bus.pass_time("5 ms")
    assert bus.part.pin("db").net.byte == 0x41


def test_a_byte_that_comes_while_another_is_written_is_lost_and_reported() -> None:
    bus = BusMaster("eeprom")
    bus.write(1, 0x41)
    bus.write(2, 0x42)
    bus.pass_time("20 ms")
    assert bus.part.content[:3] == b"\xff\x41\xff"
    assert [str(found).split("  ", 2)[2] for found in bus.part.findings] == [
        "memory-busy: 42 for address 0002 arrived while address 0001 was being written, and is lost"
    ]


def test_a_programmer_ends_the_current_write() -> None:
    bus = BusMaster("eeprom")
    bus.write(1, 0x41)
    bus.part.load(b"xyz")
    bus.write(2, 0x44)
    bus.pass_time("3 ms")  # when the first one would have ended, the second is not over
    assert bus.part.content[:3] == b"xyz"
    bus.pass_time("3 ms")
    assert bus.part.content[:3] == b"xy\x44"


# --------------------------------------------------------------------------------------------------------------- stores
class Watched(Memory):
    """A store that notes what is done to it, and may refuse."""

    def __init__(self, data: bytes = b"") -> None:
        super().__init__(data)
        self.calls: list[tuple[object, ...]] = []
        self.refuses = False

    def write(self, data: bytes) -> None:
        self._called("write", len(data))
        super().write(data)

    def append(self, data: bytes, at: int | None = None) -> None:
        self._called("append", data, at)
        super().append(data, at)

    def _called(self, *call: object) -> None:
        if self.refuses:
            raise StoreError("the disk is full")
        self.calls.append(call)


def test_written_bytes_are_in_the_store_a_flush_time_later() -> None:
    store = Watched()
    bus = BusMaster("eeprom", store=store, flush="200 ms")
    for n, byte in enumerate(b"N 100\r"):
        bus.write(0x500 + n, byte)
        bus.pass_time("6 ms")
    assert store.calls == [("write", 65536)] and bus.part.unsaved == 6  # the new part, before anything is written
    bus.pass_time("160 ms")
    assert bus.part.unsaved == 6
    bus.pass_time("20 ms")  # 200 ms behind the first one
    assert store.calls[1:] == [("append", b"N 100\r", 0x500)] and bus.part.unsaved == 0
    assert store.data == bus.part.content and store.data[0x500:0x506] == b"N 100\r"
    for address, byte in ((3, 1), (4, 2), (0x7000, 3)):
        bus.write(address, byte)
        bus.pass_time("6 ms")
    bus.pass_time("300 ms")
    assert store.calls[2:] == [("append", b"\x01\x02", 3), ("append", b"\x03", 0x7000)]
    assert store.data == bus.part.content
    bus.pass_time("10 s")
    assert len(store.calls) == 4  # nothing new, nothing flushed


def test_a_memory_comes_back_from_its_store_and_the_image_is_for_an_empty_one() -> None:
    store = Memory()
    bus = BusMaster("eeprom", store=store, image=b"image")
    bus.write(0, 0x41)
    bus.pass_time("1 s")
    again = BusMaster("eeprom", store=store, image=b"other")
    assert again.part.content[:6] == b"Amage\xff"


def test_a_store_of_another_size_is_refused() -> None:
    assert BusMaster("eeprom", store=Memory(bytes(32768))).part.size == 32768
    with pytest.raises(UsageError, match="p: the store holds 5 bytes, the part 65536; use a store of the same size"):
        BusMaster("eeprom", store=Memory(b"hello"))


def test_a_store_that_refuses_is_reported_and_gets_everything_with_the_next_flush() -> None:
    store = Watched(bytes(2048))
    bus = BusMaster("eeprom", store=store)
    store.refuses = True
    bus.write(1, 0x41)
    bus.pass_time("1 s")
    assert [found.code for found in bus.part.findings] == ["not-kept"]
    assert "1 bytes of the memory could not be saved: the disk is full" in bus.part.findings[0].text
    store.refuses = False
    bus.write(9, 0x42)
    bus.pass_time("1 s")
    assert store.data == bus.part.content and store.data[:10] == b"\0\x41" + bytes(7) + b"\x42"


def test_a_bench_that_is_closed_flushes() -> None:
    store = Watched(bytes(2048))
    bus = BusMaster("eeprom", store=store)
    bus.write(1, 0x41)
    bus.pass_time("6 ms")
    bus.part.leave()
    assert store.data[1] == 0x41
    bus.part.leave()
    assert len(store.calls) == 1


def test_pieces_that_stand_close_together_go_as_one() -> None:
    store = Watched(bytes(100))
    gathered = BufferedStore(store, b"")
    for address in (50, 2, 3, 19, 36, 99):
        gathered.put(address, address)
    gathered.flush()
    assert [(at, len(data)) for _, data, at in store.calls] == [(2, 18), (36, 15), (99, 1)]
    assert store.data == bytes(gathered.content)
    gathered.flush()
    assert len(store.calls) == 3


def test_a_store_that_cannot_append_gets_all_of_it() -> None:
    class Plain:
        data = bytes(10)

        def read(self) -> bytes:
            return self.data

        def write(self, data: bytes) -> None:
            self.data = data

    gathered = BufferedStore(store := Plain(), b"")
    gathered.put(3, 7)
    gathered.flush()
    assert store.data == bytes(3) + b"\x07" + bytes(6)


# ---------------------------------------------------------------------------------------------------------- the bench
def test_a_bench_with_stores_keeps_its_eeproms_by_name_and_a_journal_brings_them_back(tmp_path) -> None:
    def bench() -> slewline.Bench:
        stores = {}
        made = slewline.Bench(
            stores=lambda name: stores.setdefault(name, FileStore(tmp_path / f"{name}.eeprom")),
            journal=tmp_path / "run.jsonl",
        )
        made.part("ram", name="work")
        made.part("eeprom", name="kept", size=2048)
        return made

    first = bench()
    first["kept"].load(b"P 100\r")
    first.run("1 s")
    first.journal.close()
    assert [path.name for path in tmp_path.glob("*.eeprom")] == ["kept.eeprom"]
    second = bench()
    second["kept"].load(b"P 2", 0)
    second.run("1 s")
    second.journal.close()
    (tmp_path / "kept.eeprom").unlink()
    again = slewline.replay(tmp_path / "run.jsonl")
    assert again["kept"].content == second["kept"].content == b"P 200\r".ljust(2048, b"\xff")
    assert not (tmp_path / "kept.eeprom").exists()


BENCH = """
[[part]]
kind = "eprom"
file = "{file}"
{more}
"""


def test_a_bench_file_names_a_file_with_the_image(tmp_path) -> None:
    (tmp_path / "dump.hex").write_text(":0400100041424344E2\n:00000001FF\n")
    path = tmp_path / "b.toml"
    path.write_text(BENCH.format(file="dump.hex", more=""))
    assert slewline.load(path)["eprom"].content[0x0F:0x15] == b"\xffABCD\xff"


@pytest.mark.parametrize(
    ("file", "more", "says"),
    [
        ("none.bin", "", r"b.toml, line 2: \[\[part\]\] 1: .*none.bin cannot be read: No such file"),
        ("../dump.bin", "", "found '../dump.bin', outside the folder of the bench file"),
        ("b.toml", 'image = "x"', "file: given together with image; give one of the two"),
        ("long.bin", "", "an image of 70000 bytes; allowed up to 65536"),
    ],
)
def test_mistakes_in_its_file_are_reported_with_their_place(file: str, more: str, says: str, tmp_path) -> None:
    path = tmp_path / "b.toml"
    (tmp_path / "long.bin").write_bytes(bytes(70000))
    path.write_text(BENCH.format(file=file, more=more))
    with pytest.raises(BenchFileError, match=says):
        slewline.load(path)
