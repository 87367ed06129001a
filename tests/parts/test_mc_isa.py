"""The ISA board of a chipset: its addresses, its bus cycles at the pins, and its two ways to reset."""

from __future__ import annotations

from itertools import pairwise

import pytest

import slewline
from tests.rows import rows

NS, US = 10**3, 10**6  # picoseconds
CLOCK = 125 * NS
CYCLE = 6 * CLOCK
DATA, COMMAND, STATUS, RESET = 0, 2, 4, 8
PINS = ("hostslct", "hostcmd", "hostread", "hostwrite", "hostrdy", "hostdata", "reset")


class Pc:
    """A PC with the board at `base`, and a driver that looks at bit 7 of the status before every byte."""

    def __init__(self, part="mc1451a", base=0x340, record=False, **options):
        self.bench = slewline.Bench(**options)
        self.x = self.bench.add(part, name="x")
        self.isa = self.bench.part("isa", to=self.x, base=base)
        self.base = base
        if record:
            self.bench.record(*(f"x.{pin}" for pin in PINS))

    def out(self, offset, byte):
        self.isa.out(self.base + offset, byte)

    def inp(self, offset):
        return self.isa.inp(self.base + offset)

    def ready(self):
        """The driver lets its loop of polls run until the board says ready."""
        while not self.inp(STATUS) & 0x80:
            self.bench.run("5 us")

    def command(self, code, *words, reads=0):
        """A packet; the words that were read, the checksum the last."""
        self.ready()
        self.out(COMMAND, code)
        for word in words:
            for byte in word.to_bytes(2, "big"):
                self.ready()
                self.out(DATA, byte)
        return [self.word() for _ in range(reads + 1)]

    def word(self):
        data = bytearray()
        for _ in range(2):
            self.ready()
            data.append(self.inp(DATA))
        return int.from_bytes(data, "big")

    def edges(self, pin, since=0):
        times, levels = self.bench.edges(f"x.{pin}", since)
        return list(zip(times.tolist(), levels.tolist(), strict=True))


@pytest.fixture
def pc():
    return Pc()


# ---------------------------------------------------------------------------------------------------------- addresses
@pytest.mark.fact("PMD-ISA-1")
def test_commands_and_data_have_an_address_each(pc):
    pc.ready()
    pc.isa.out(0x342, 0x6C)
    pc.ready()
    assert (pc.isa.inp(0x340), pc.isa.inp(0x340)) == (0x5C, 0x11)


@pytest.mark.fact("PMD-ISA-2")
def test_bit_7_of_the_status_is_hostrdy_and_the_others_float(pc):
    pc.ready()
    assert pc.inp(STATUS) == 0xFF
    pc.out(COMMAND, 0x31)
    assert pc.inp(STATUS) == 0x7F
    pc.bench.run("82 us")
    assert pc.inp(STATUS) == 0xFF


@pytest.mark.fact("PMD-ISA-4", "PMD-UND-ISA-UNUSED")
def test_the_other_addresses_read_ff_and_take_nothing(pc):
    pc.command(0x10, 0, 100)
    pc.ready()
    for offset in (1, 3, 5, 6, 7, *range(9, 16)):
        pc.out(offset, 0x39)
        assert pc.inp(offset) == 0xFF
        assert pc.inp(STATUS) == 0xFF  # HostRdy has not fallen: the chipset saw nothing
    assert [pc.inp(COMMAND), pc.inp(RESET)] == [0xFF, 0xFF]
    pc.out(STATUS, 0x39)
    for port in (0x33F, 0x350, 0x240):
        pc.isa.out(port + COMMAND, 0x39)
        assert pc.isa.inp(port) == 0xFF
    assert pc.command(0x4A, reads=2) == [0, 100, 0x4A + 100]
    wrote = {found.text.split()[1] for found in pc.bench.findings if found.text.startswith("OUT ")}
    read = {found.text.split()[1] for found in pc.bench.findings if found.text.startswith("IN ")}
    none = [0x340 + offset for offset in (1, 3, 5, 6, 7, *range(9, 16))]
    assert wrote == {f"{port:#x}" for port in (*none, 0x344, 0x341, 0x352, 0x242)}
    assert read == {f"{port:#x}" for port in (*none, 0x342, 0x348, 0x33F, 0x350, 0x240)}
    assert {found.code for found in pc.bench.findings} == {"no-register"}
    assert len(pc.bench.findings) == len(wrote) + len(read)


@pytest.mark.fact("PMD-ISA-5", "PMD-CON-ISA-BASES")
@rows("base", [0x340, 0x350, 0x360, 0x370, 0x390, 0x300, 0x3F0])
def test_the_base_is_free(base):
    pc = Pc("mc1151a", base)
    assert pc.command(0x6C, reads=1) == [0x4411, 0x4411 + 0x6C]
    pc.ready()
    pc.isa.out(base + 0x8000 + COMMAND, 0x31)  # ten address lines are decoded
    assert pc.isa.inp(base + 0x400 + STATUS) == 0x7F


# -------------------------------------------------------------------------------------------------------------- driver
@pytest.mark.fact("PMD-ISA-6")
@pytest.mark.parametrize("packets", [200, pytest.param(1000, marks=pytest.mark.long)])
def test_a_driver_that_looks_before_every_byte_never_hangs(pc, packets):
    for number in range(packets):
        assert pc.command(0x10, number, 0xFFFF - number) == [0x10 + 0xFFFF & 0xFFFF]
    assert pc.command(0x4A, reads=2) == [packets - 1, 0x10000 - packets, 0x4A + 0xFFFF & 0xFFFF]
    assert pc.bench.findings == []


def test_the_two_bytes_of_a_word_may_follow_each_other_without_polling(pc):
    pc.ready()
    pc.out(COMMAND, 0x15)
    pc.ready()
    pc.out(DATA, 0x12)
    pc.out(DATA, 0x34)
    assert pc.word() == 0x1234 + 0x15
    assert pc.bench.findings == []


def test_a_wait_for_hostrdy_ends_with_it_or_with_its_time(pc):
    pc.ready()
    pc.out(COMMAND, 0x31)
    status = [(pc.isa.ready(limit), pc.isa.cycle(pc.base + STATUS))[1] for limit in ("80 us", "80 us", "80 us")]
    begun = pc.bench.now_ps
    pc.bench.run_until(lambda: status[-1].done)
    assert [request.result for request in status] == [0x7F, 0xFF, 0xFF]
    assert 80 * US + 3 * CYCLE < pc.bench.now_ps - begun < 82 * US + 3 * CYCLE  # the last wait is over at once


# -------------------------------------------------------------------------------------------------------- at the pins
def test_a_write_cycle_cuts_hostwrite_short_and_holds_the_data():
    pc = Pc(record=True)
    pc.ready()
    begun = pc.bench.now_ps
    pc.out(COMMAND, 0x31)
    assert pc.bench.now_ps - begun == CYCLE
    assert pc.edges("hostwrite", begun) == [(begun + 2 * CLOCK, 0), (begun + 3 * CLOCK, 1)]
    assert pc.edges("hostslct", begun) == [(begun + CLOCK // 2, 0), (begun + CYCLE, 1)]
    assert pc.edges("hostcmd", begun) == [(begun + CLOCK // 2, 1), (begun + CYCLE, 0)]
    assert pc.edges("hostdata", begun) == [(begun + CLOCK, 0x31), (begun + 5 * CLOCK, -1)]
    assert pc.edges("hostread", begun) == []


def test_a_read_cycle_takes_the_byte_at_its_end():
    pc = Pc(record=True)
    pc.ready()
    pc.out(COMMAND, 0x6C)
    pc.ready()
    begun = pc.bench.now_ps
    assert pc.inp(DATA) == 0x5C
    assert pc.edges("hostread", begun) == [(begun + CLOCK, 0), (begun + 5 * CLOCK, 1)]
    assert pc.edges("hostslct", begun) == [(begun + CLOCK // 2, 0), (begun + CYCLE, 1)]
    assert pc.edges("hostcmd", begun) == []
    driven = [time for time, level in pc.edges("hostdata", begun) if level == 0x5C]
    assert driven == [begun + CLOCK + 40 * NS]


def test_a_status_cycle_leaves_the_chipset_alone():
    pc = Pc(record=True)
    pc.ready()
    begun = pc.bench.now_ps
    pc.inp(STATUS)
    assert pc.bench.now_ps - begun == CYCLE
    assert [pc.edges(pin, begun + 1) for pin in PINS] == [[]] * len(PINS)


def test_cycles_follow_each_other_without_a_gap():
    pc = Pc(record=True)
    pc.ready()
    begun = pc.bench.now_ps
    for _ in range(3):
        pc.isa.cycle(0x340, 0x55)
    pc.bench.run_until_idle()
    assert pc.bench.now_ps - begun >= 3 * CYCLE
    falls = [time for time, level in pc.edges("hostwrite", begun) if level == 0]
    assert [then - now for now, then in pairwise(falls)] == [CYCLE, CYCLE]


# --------------------------------------------------------------------------------------------------------------- reset
def prepared(pc):
    """A chipset that is not as it is after reset."""
    pc.command(0x10, 0, 100)
    pc.command(0x02, reads=1)


def is_reset(pc):
    """Registers, current axis and time as after reset."""
    assert pc.x.pin("hostrdy").level == 0
    pc.ready()
    assert pc.command(0x31, reads=1) == [0x0300, 0x0331]
    assert pc.command(0x4A, reads=2) == [0, 0, 0x4A]
    high, low, _ = pc.command(0x3E, reads=2)
    assert high == 0 and low < 40


@pytest.mark.fact("PMD-ISA-3")
@pytest.mark.parametrize("byte", [0x00, 0xFF])
def test_a_write_of_anything_to_base_8_resets_the_chipset(byte):
    pc = Pc(record=True)
    prepared(pc)
    begun = pc.bench.now_ps
    pc.out(RESET, byte)
    pc.bench.run("5 us")
    assert pc.edges("reset", begun) == [(begun + CLOCK, 0), (begun + CLOCK + 2 * US, 1)]
    is_reset(pc)
    assert pc.bench.findings == []


@pytest.mark.fact("PMD-ISA-7")
def test_reset_of_the_bus_resets_the_chipset(pc):
    prepared(pc)
    pc.bench.pin("isa.reset_drv").pulse(1, "10 ms")
    pc.bench.run("5 ms")
    assert pc.x.pin("reset").level == 0
    pc.out(RESET, 0)  # its pulse does not end that of the bus
    pc.bench.run("1 ms")
    assert pc.x.pin("reset").level == 0
    pc.bench.run("5 ms")
    assert pc.x.pin("reset").level == 1
    is_reset(pc)


def test_a_second_write_to_base_8_lengthens_the_pulse():
    pc = Pc(record=True)
    pc.ready()
    begun = pc.bench.now_ps
    pc.out(RESET, 0)
    pc.out(RESET, 0)
    pc.bench.run("5 us")
    assert pc.edges("reset", begun) == [(begun + CLOCK, 0), (begun + CYCLE + CLOCK + 2 * US, 1)]


# ------------------------------------------------------------------------------------------------- journal and mistakes
def test_a_journal_plays_the_same_again(tmp_path):
    path = tmp_path / "run.jsonl"
    pc = Pc(journal=path, record=True)
    pc.command(0x10, 0, 100)
    pc.out(RESET, 0)
    pc.command(0x31, reads=1)
    again = slewline.replay(path, prepare=lambda bench: bench.record(*(f"x.{pin}" for pin in PINS)))
    for pin in PINS:
        one, two = pc.bench.edges(f"x.{pin}"), again.edges(f"x.{pin}")
        assert all((a == b).all() for a, b in zip(one, two, strict=True))
    assert again.now_ps == pc.bench.now_ps


@rows("base", [0xF0, 0x348, 0x400, "340"])
def test_a_base_outside_the_range_is_refused(base):
    text = "a whole number such as 0x340" if base == "340" else "0x100 to 0x3f0 in steps of 0x10"
    with pytest.raises(slewline.UsageError, match=f"isa: base {base!r}; allowed {text}"):
        slewline.Bench().part("isa", base=base)


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda isa: isa.out(0x340, 256), "256; allowed 0..0xff"),
        (lambda isa: isa.inp(0x10000), "65536; allowed 0..0xffff"),
        (lambda isa: isa.inp("340"), "'340'; allowed"),
    ],
)
def test_mistakes_of_the_user_are_reported(pc, call, text):
    with pytest.raises(slewline.UsageError) as raised:
        call(pc.isa)
    assert text in str(raised.value)
