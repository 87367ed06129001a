"""A host that knows the packets of an MC1451A or a sister of it, right ones and wrong ones, and what each must find.

A misuse that has a name finds what its name says, and nothing else; what the host does next is right again.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from random import Random
from typing import Any

import slewline
from slewline.chips import sheet_of
from slewline.language import packets

from .mc_hands import MS, US

OF_MOTION = {  # findings about a motion or a part, which may come at any time
    "clamped", "no-start", "start-velocity", "mode-in-motion", "gear-backlog", "encoder-fast", "encoder-illegal",
    "no-encoder", "command-error",
}  # fmt: skip
ANY_TIME = {*OF_MOTION, "motion-error", "servo-command"}  # with an encoder; once, at the first of some codes
KEPT = ("POS", "VEL", "ACC", "MAX_ACC", "JERK", "RATIO", "START_VEL", "BRK_PNT", "INTRPT_MASK", "STEP_RATIO", "POS_ERR")
GET_VRSN, SET_POS = 0x6C, 0x10
MISUSES = (
    "aborted_packet", "odd_byte", "extra_word", "early_read", "illegal_command", "undocumented_command", "out_of_range",
    "busy_access",
)  # fmt: skip
OF_WIRES = (
    "short_strobe", "short_recovery", "both_strobes", "command_read", "late_release", "conflict", "unselected",
)  # fmt: skip


class Misuse:
    """A host with a hand on the port of a chipset."""

    def __init__(self, bench: slewline.Bench, chip: Any, hand: Any, rnd: Random) -> None:
        self.bench, self.chip, self.hand, self.rnd = bench, chip, hand, rnd
        self.sheet = sheet_of(chip.sheet.part)
        self.codes: Any = self.sheet.dialect
        self.rows = [row for row in self.sheet.commands if row.name != "RESET"]
        self.without_words = [row for row in self.rows if not row.args]
        self.with_words = [row for row in self.rows if row.args]
        self.version = [self.codes.version, packets.checksum(GET_VRSN, [self.codes.version])]

    @contextmanager
    def finds(self, *codes: str) -> Iterator[None]:
        """What is done within finds this, and nothing else but about the motion."""
        since = len(self.chip.findings)
        yield
        found = [finding for finding in self.chip.findings[since:] if finding.code not in ANY_TIME]
        assert [finding.code for finding in found] == list(codes), found

    def exchange(self, code: int, *words: int, reads: int = 0) -> list[int]:
        """A packet whose checksum is right: the words that are read."""
        *found, checksum = self.hand.packet(code, *words, reads=reads)
        assert checksum == packets.checksum(code, (*words, *found)), (code, words, found, checksum)
        return found

    def do(self, command: str) -> int:
        """A command, such as "SET_POS 5"; returns what it returns, if anything."""
        name, *values = command.split()
        row = self.sheet.commands[name]
        found = self.exchange(row.code, *packets.words(row, [*map(int, values)]), reads=packets.counted(row.reads))
        return packets.values(row.reads, found)[0] if found else 0

    # ---------------------------------------------------------------------------------------------- wrong packets
    def kept(self) -> tuple[Any, Any]:
        """The commands that write a register and read it."""
        name = self.rnd.choice(KEPT)
        return self.sheet.commands[f"SET_{name}"], self.sheet.commands[f"GET_{name}"]

    def any_words(self, number: int) -> list[int]:
        return [self.rnd.choice((0, 0xFFFF, self.rnd.randrange(1 << 16))) for _ in range(number)]

    def aborted_packet(self) -> None:
        """A command before all words of the last one are there, half a word perhaps: the register stays."""
        writes, reads = self.kept()
        half = self.rnd.random() < 0.5
        before = self.do(reads.name)
        self.hand.command(writes.code)
        self.hand.send(*self.any_words(self.rnd.randrange(packets.counted(writes.args))))
        if half:
            self.hand.ready()
            self.hand.write(b"\x55")
        with self.finds(*["odd-byte"] * half, "aborted-packet"):
            assert self.do(reads.name) == before

    def odd_byte(self) -> None:
        """Half a word between two packets."""
        self.do("GET_TIME")
        self.hand.ready()
        self.hand.write(self.rnd.randbytes(1))
        with self.finds("odd-byte"):
            self.do("GET_STATUS")

    def extra_word(self) -> None:
        """Words that a command does not take: they do not count."""
        row, number = self.rnd.choice(self.without_words), self.rnd.randrange(1, 4)
        with self.finds(*["extra-word"] * number):
            self.hand.command(row.code)
            self.hand.send(*self.any_words(number))
            self.answer(row)

    def answer(self, row: Any) -> None:
        """Read what a command without words has to say."""
        *found, checksum = self.hand.fetch(packets.counted(row.reads) + 1)
        assert checksum == packets.checksum(row.code, found), row.name

    def early_read(self) -> None:
        """A word is read where words are wanted: it is 0, and the command waits on."""
        writes, reads = self.kept()
        value = self.rnd.randrange(1, 100)
        words = packets.words(writes, [value])
        with self.finds("early-read"):
            self.hand.command(writes.code)
            assert self.hand.fetch() == [0]
            self.hand.send(*words)
            assert self.hand.fetch() == [packets.checksum(writes.code, words)]
            assert self.do(reads.name) == value

    def illegal_command(self) -> None:
        """All that is read is 0, whatever is written."""
        with self.finds("illegal-command"):
            self.hand.command(self.rnd.choice(sorted(self.codes.illegal)))
            self.hand.send(*self.any_words(self.rnd.randrange(3)))
            assert not any(self.hand.fetch(self.rnd.randrange(1, 4)))

    def undocumented_command(self) -> None:
        """A code that is no command here: those of sister parts and the reserved one say little."""
        known = {*self.sheet.commands.by_code, *self.codes.illegal}
        code = self.rnd.choice([code for code in range(256) if code not in known])
        sibling = self.codes.siblings.get(code)
        writes, reads = (sibling.writes, sibling.reads) if sibling else (0, 0)
        silent = sibling is not None or code in self.codes.reserved
        with self.finds(*["undocumented-command"] * (not silent)):
            assert not any(self.exchange(code, *self.any_words(writes), reads=reads))

    def out_of_range(self) -> None:
        """A value that the manual does not allow, for the most part; the checksum is that of the words as sent."""
        row = self.rnd.choice(self.with_words)
        (arg,) = row.args
        self.hand.ready()  # the mode is what the last command has made it
        size = 1 << 8 * arg.size
        value = self.rnd.choice((arg.high + 1, size // 2, size - 1, self.rnd.randrange(size))) % size
        written = arg.unpack(arg.pack(value, "big"), "big")
        backwards = row.name == "SET_ACC" and written < 0 and self.chip.state.axis.mode == 0
        with self.finds(*["out-of-range"] * (backwards or not arg.allows(written))):
            self.exchange(row.code, *(value >> 16 * n & 0xFFFF for n in reversed(range(arg.size // 2))))

    def busy_access(self) -> None:
        """The port is used while HostRdy is low: a write is lost, a read finds the byte that was read last."""
        kind = self.rnd.choice(("command", "word", "half", "read", "half read"))
        number = 2 if kind in ("word", "read") else 1
        self.do("GET_VRSN")
        row = self.rnd.choice(self.without_words)
        self.hand.command(row.code)
        with self.finds(*["busy-access"] * number):
            if "read" in kind:
                assert self.hand.read(number) == bytes([self.version[1] & 0xFF] * number)
            else:
                self.hand.write(self.rnd.randbytes(number), command=kind == "command")
            self.answer(row)

    # -------------------------------------------------------------------------------------------- reset and supply
    def short_reset(self) -> None:
        """RESET for less than 25 clocks: it resets."""
        with self.finds("short-reset"):
            self.pull_reset(self.rnd.randrange(1, self.chip.clock.ps(25)))

    def early_reset(self) -> None:
        """RESET ends too early behind the supply."""
        with self.finds("early-reset"):
            self.chip.power(False)
            self.bench.run(self.rnd.choice((0, MS)))
            self.chip.pin("reset").drive(0)
            self.bench.run(0)
            self.chip.power(True)
            self.pull_reset(self.rnd.choice((4 * US, MS, 249 * MS)))

    def pull_reset(self, ps: int) -> None:
        """RESET low for a time; then everything is as it was in the beginning."""
        self.chip.pin("reset").drive(0)
        self.bench.run(f"{ps} ps")
        self.chip.pin("reset").release()
        assert self.hand.fetch() == [0]
        assert self.do("GET_TIME") == 10

    # -------------------------------------------------------------------------------------------------- strobes
    def short_strobe(self) -> None:
        """HostWrite is low for too short a time: the byte is taken."""
        with self.finds("short-strobe"):
            self.hand.ready()
            self.hand.write(bytes([GET_VRSN]), command=True, low=self.rnd.choice((1, 20, 49)))
            assert self.hand.fetch(2) == self.version

    def short_recovery(self) -> None:
        """The strobes of a word follow too fast."""
        self.hand.command(SET_POS)
        self.hand.ready()
        with self.finds("short-recovery"):
            self.hand.write(b"\x12\x34", gap=self.rnd.choice((10, 59)))
            self.hand.send(0x5678)
            assert self.hand.fetch() == [0x1234 + 0x5678 + SET_POS]

    def both_strobes(self) -> None:
        """HostWrite and HostRead are low together: no transfer."""
        first, second = self.rnd.sample(("hostwrite", "hostread"), 2)
        with self.finds("strobes"):
            self.hand.ready()
            self.hand.bus(None)
            self.hand.hold(hostslct=0)
            self.hand.hold(**{first: 0})
            self.hand.hold(**{second: 0})
            self.hand.hold(**{self.rnd.choice((first, second)): 1})
            self.hand.rest()
            assert self.exchange(GET_VRSN, reads=1) == self.version[:1]

    def command_read(self) -> None:
        """HostRead with HostCmd high: no transfer."""
        self.hand.command(GET_VRSN)
        with self.finds("strobes"):
            self.hand.ready()
            self.hand.bus(None)
            self.hand.hold(hostslct=0, hostcmd=1, hostread=0)
            self.hand.hold(hostread=1)
            self.hand.rest()
            assert self.hand.fetch(2) == self.version

    def late_release(self) -> None:
        """HostSlct stays low for more than 2 us."""
        with self.finds("late-release"):
            self.hand.ready()
            self.hand.bus(GET_VRSN)
            self.hand.hold(hostslct=0, hostcmd=1, hostwrite=0)
            self.hand.hold(hostwrite=1)
            self.bench.run(self.rnd.choice((2, 10)) * US)
            self.hand.rest()
            assert self.hand.fetch(2) == self.version

    def conflict(self) -> None:
        """The host drives the bus while the chipset does: the low level wins.  Of two bytes it is told once."""
        self.bench.run(MS)  # without a conflict
        self.hand.command(GET_VRSN)
        self.hand.ready()
        self.hand.bus(0)
        with self.finds("conflict"):
            assert self.hand.read(let_go=False) == b"\0\0"
        assert self.hand.fetch() == self.version[1:]

    def unselected(self) -> None:
        """A strobe without HostSlct, or one that HostSlct cuts off: no transfer, and nothing wrong."""
        pin, selected = self.rnd.choice(("hostwrite", "hostread")), self.rnd.randrange(2)
        with self.finds():
            self.hand.ready()
            self.hand.bus(None)
            self.hand.hold(hostslct=1 - selected, hostcmd=int(pin == "hostwrite"))
            self.hand.hold(**{pin: 0})
            self.hand.hold(hostslct=1)
            self.hand.rest()
            assert self.exchange(GET_VRSN, reads=1) == self.version[:1]
