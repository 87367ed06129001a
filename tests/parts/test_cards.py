"""Interface boards with their registers elsewhere: a host program of one card on that card, and on another one."""

from __future__ import annotations

import pytest

import slewline
from slewline.parts.boards.register_layouts import CARDS, layout_of
from tests.rows import rows

OWN = "data=4,command=6,status=7,reset=5,base=0x300"
MOVE = (0x39, 0x01, 0x33, 0x41, 0x43, 0x45, 0x09, (0x12, 0, 0x1000), (0x11, 8, 0), (0x10, 0, 1000), 0x1A)


class Program:
    """A host program that was written for a card: it knows the addresses of that one."""

    def __init__(self, bench, written_for, card=None, function=None):
        self.bench, self.x = bench, bench.add("mc1451a", name="x")
        self.isa = bench.part("isa", name="card", to=self.x, card=card or written_for)
        self.layout = layout_of(written_for)
        if function is not None:
            self.isa.out(self.layout.base + self.layout.offset("function"), function)

    def address(self, register):
        return self.layout.base + self.layout.offset(register)

    def ready(self, most=10_000):
        for _ in range(most):
            if self.isa.inp(self.address("status")) & 0x80:
                return
        raise AssertionError("HostRdy stays low")

    def send(self, code, *words):
        self.ready()
        self.isa.out(self.address("command"), code)
        for byte in b"".join(word.to_bytes(2, "big") for word in words):
            self.ready()
            self.isa.out(self.address("data"), byte)

    def word(self):
        found = 0
        for _ in range(2):
            self.ready()
            found = found << 8 | self.isa.inp(self.address("data"))
        return found

    def move(self):
        for packet in MOVE:
            self.send(*((packet,) if isinstance(packet, int) else packet))
        self.bench.run("50 ms")
        while True:
            self.send(0x31)
            if not self.word() & 0x400:
                return
            self.bench.run("10 ms")


@rows("card", [*CARDS, OWN, "data=0,command=1,status=1"])
def test_a_program_of_a_card_works_on_that_card(card):
    program = Program(slewline.Bench(), card, function=0x0F if card == "pi-c842" else None)
    program.send(0x6C)
    assert program.word() == 0x5C11
    program.move()
    assert program.x.axes[0].position == 1000
    assert [found for found in program.bench.findings if found.code == "no-register"] == []
    assert program.isa.base == program.layout.base


@rows(
    ("written_for", "card", "reads", "writes"),
    [
        ("pi-c842", "pmd", {0x211}, {0x211}),  # +2 is its command register
        ("pmd", "pi-c842", {0x344}, {0x342, 0x348}),
    ],
)
def test_a_program_of_another_card_is_a_finding_with_the_address(written_for, card, reads, writes):
    """Bit 7 of what floats is 1, which is "ready": nothing but the findings shows it."""
    program = Program(slewline.Bench(), written_for)
    base = program.layout.base
    wrong = slewline.Bench()
    program = Program(wrong, written_for, card=f"{spelled(card)},base={base:#x}")
    if "function" in program.layout.writes.values():
        program.isa.out(base + 2, 0x0F)
    if "reset" in program.layout.writes.values():
        program.isa.out(base + 8, 0)
    program.send(0x10, 0, 1000)
    program.send(0x1A)
    wrong.run("50 ms")
    assert program.x.axes[0].position == 0
    found = [one for one in wrong.findings if one.code == "no-register"]
    assert {int(one.text.split()[1], 16) for one in found if one.text.startswith("IN")} == reads
    assert {int(one.text.split()[1], 16) for one in found if one.text.startswith("OUT")} == writes
    assert len(found) == len(reads) + len(writes)  # once for each address, however often it was polled
    assert all(f"card at {base:#x} " in one.text and "card=" in one.text for one in found)


def spelled(card):
    """The offsets of a card as text."""
    layout = CARDS[card]
    return ",".join(
        f"{name}={at}" for name in ("data", "command", "status", "reset") if (at := layout.offset(name)) is not None
    )


def test_an_address_of_no_board_names_where_the_board_is():
    program = Program(slewline.Bench(), "pi-c842")
    assert program.isa.inp(0x344) == 0xFF
    (found,) = program.bench.findings
    assert found.text == "IN 0x344 reads FF: no board has this address; card has the addresses from 0x210 on"


@rows(
    ("card", "says"),
    [
        ("pi-c843", "not known; allowed pmd, pi-c842, or offsets such as .*; did you mean pi-c842"),
        ("data=0,command=1", "status missing; expected text such as"),
        ("data=0,command=1,status=1,size=3", "'size' is not known; allowed data, command, status, reset, base"),
        ("data=0,command=1,status=1,data=3", "'data' is given twice"),
        ("data=0,command=1,status=16", "status: found '16'; allowed 0 to 15"),
        ("data=0,command=1,status=x", "status: found 'x'; allowed 0 to 15"),
        ("data=0,command=1,status=1,base=0x305", "base: found '0x305'; allowed 0x100 to 0x3f0 in steps of 0x10"),
        ("data=0,command=0,status=4", "two registers have the same address; only command and status may share"),
        ("data=0,command=2,status=0", "two registers have the same address"),
        ("data=0,command=2,status=4,reset=2", "two registers have the same address"),
    ],
)
def test_a_card_that_cannot_be_is_refused(card, says):
    with pytest.raises(slewline.UsageError, match=says):
        slewline.Bench().part("isa", card=card)


def test_a_run_on_a_card_is_replayed(tmp_path):
    journal = tmp_path / "run.journal"
    program = Program(slewline.Bench(journal=str(journal)), "pi-c842", function=0x0F)
    program.move()
    program.bench.journal.close()
    again = slewline.replay(str(journal))
    assert again["x"].axes[0].position == 1000 and again["card"].base == 0x210


@rows("pause_ps", [0, 1, 62_500, 125_000, 777_777])
def test_an_access_without_a_register_is_found_in_the_first_clock_of_its_cycle(pause_ps):
    """However the request came: two hosts that ask the same have the same findings."""
    bench = slewline.Bench()
    isa = bench.part("isa", name="card", to=bench.add("mc1451a", name="x"))
    bench.run(10**9 + pause_ps)
    begun = bench.now_ps
    isa.out(isa.base + 4, 0)
    begun_again = bench.now_ps
    isa.inp(isa.base + 5)
    found = [each.time_ps for each in bench.findings if each.code == "no-register"]
    assert found == [begun + 125_000, begun_again + 125_000]
