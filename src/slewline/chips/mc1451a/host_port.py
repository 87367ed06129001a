r"""The host port, which assembles a host's strobes into packets; HostRdy paces the strobes.

    HostCmd    ____/‾‾‾‾\______________________________________________      a command byte, then words
    HostWrite  ‾‾‾‾‾\_/‾‾‾‾‾‾‾‾‾‾‾‾\_/‾\_/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾
    HostRead   ‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾\_/‾\_/‾‾‾‾‾‾‾‾‾‾‾      the checksum
    HostRdy    ‾‾‾‾‾‾‾\_________/‾‾‾‾‾‾‾‾\_________/‾‾‾‾‾‾\_________/‾‾      low for a slice of 81.92 µs

A byte or a word takes effect at the end of its slice.  A command without data is executed at the end of
the command byte's slice, a command with data at the end of the slice of its last word; the words that
the host will read are computed at that moment, and do not change afterwards.  A command byte begins a
new packet, even if the old one is incomplete.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from functools import partial

from ...core.context import ChipContext
from ...core.datasheet.command_rows import PacketRow
from ...core.wires.net import Net, Wave
from ...language.dialect import spoken_as
from ...language.packets import Packets, checksum
from .activity import Activity
from .instructions import Instructions, Moves
from .omissions import servo
from .sheet import SERVO
from .supply import Supply

NS = 1000  # picoseconds: the times of strobes and bus do not depend on the crystal
SHORTEST_PS, RECOVERY_PS, RELEASE_PS = 50 * NS, 60 * NS, 2000 * NS


class Port:
    """HostSlct, HostCmd, HostWrite, HostRead, HostRdy and the host bus."""

    def __init__(
        self,
        chip: ChipContext,
        activity: Activity,
        supply: Supply,
        motion: Moves,
        instructions: Instructions,
        busy_ticks: int,
    ) -> None:
        self.chip, self.kernel, self.clock, self.busy_ticks = chip, chip.kernel, chip.clock, busy_ticks
        self.activity, self.supply, self.motion, self.instructions = activity, supply, motion, instructions
        self.rows = chip.sheet.rows(PacketRow).by_code
        self.codes = spoken_as(chip.sheet, Packets)
        times = chip.sheet.times
        self.access_ps, self.let_go_ps = (int(times[name].us * 1000) * NS for name in ("read_access", "read_release"))
        self.ready_driver, self.bus, self.bus_driver = chip.drivers["hostrdy"], chip.bus, chip.bus_driver
        names = ("hostslct", "hostcmd", "hostwrite", "hostread")
        self.slct, self.cmd, self.writes, self.reads = (chip.pins[name].net for name in names)
        self.reported: set[str] = set()  # reported: commands without their encoder, a program for a servo
        self.watches = ((self.writes, self._write), (self.reads, self._read), (self.slct, self._select))
        for net, callback in self.watches:
            net.watch(callback)
        self.slct.ends = (self,)
        self.begin()

    def begin(self) -> None:
        """Handle a reset: set HostRdy to not ready, and discard the packet."""
        if self.slct.exchange is not None:
            self.slct.exchange.withdraw()
        self.chip.on_command("")
        self.ready = False
        self.bytes: list[int] = []  # first byte of a word being written
        self.row: PacketRow | None = None  # the command that waits for words, or is complete
        self.wanted = 0  # the number of words it waits for
        self.words: list[int] = []
        self.code = 0
        self.silent = True  # every read returns 0: no packet yet, or an illegal command
        self.answer: deque[int] = deque([0])  # words to be read
        self.shown = 0  # the byte that the host read last
        self.half = False  # the first byte of a word has been read
        self.fell_at = 0  # HostWrite
        self.rose_at = -RECOVERY_PS
        self.legal = False  # the strobe in progress had a valid start
        self.strobed_at: int | None = None  # the end of the last strobe of an operation

    # --------------------------------------------------------------------------------------------------------- strobes
    @property
    def _selected(self) -> bool:
        return self.supply.powered and self.slct.is_active

    def _strobe(self, name: str, other: str, net: Net) -> bool:
        """Return whether the strobe `name`, which begins now, is valid; report violations as findings.

        The strobe is invalid if the other strobe is low.  `other` is the name of that strobe, `net` its net.
        """
        now = self.kernel.now
        if net.is_active:
            self.chip.finding("strobes", f"{name} and {other} are low together: no transfer")
            self._show(None, self.let_go_ps)
            return False
        if now - self.rose_at < RECOVERY_PS:
            text = f"{(now - self.rose_at) // NS} ns between two strobes; required at least 60 ns"
            self.chip.finding("short-recovery", text)
        return True

    def _write(self, net: Net) -> None:
        """Read a byte from the bus at the rising edge of HostWrite."""
        if not self._selected:
            self.legal = False
            return
        if net.value == net.active_level:
            self.fell_at = self.kernel.now
            self.legal = self._strobe("hostwrite", "hostread", self.reads)
            return
        legal, self.legal = self.legal and not self.reads.is_active, False
        if not legal:
            return
        width = self.kernel.now - self.fell_at
        if width < SHORTEST_PS:
            self.chip.finding("short-strobe", f"hostwrite low for {width // NS} ns; required at least 50 ns")
        self.rose_at = self.kernel.now
        if self.cmd.level == 1:
            self.command(self.bus.byte)
        else:
            self.data(self.bus.byte)

    def _read(self, net: Net) -> None:
        """Output a byte on the bus while HostRead is low."""
        if net.value == net.active_level:
            self.legal = self._selected and self._strobe("hostread", "hostwrite", self.writes)
            if self.legal and self.cmd.level == 1:
                self.chip.finding("strobes", "hostread with hostcmd high: no transfer")
                self.legal = False
            if self.legal:
                self._show((0xFF, self.read()), self.access_ps)
        elif self.legal:
            self.legal = False
            self._show(None, self.let_go_ps)
            if self._selected:
                self.rose_at = self.kernel.now
                self.read_on()

    def _show(self, level: tuple[int, int] | None, delay_ps: int) -> None:
        """Output a byte on the bus after a delay; if `level` is None, release the bus after the delay."""
        now, driver = self.kernel.now, self.bus_driver
        driver.play(Wave(driver.at(now), (now + delay_ps,), (level,)))

    def _select(self, net: Net) -> None:
        """Report a finding if HostSlct rises later than 2 µs after the last strobe.

        If HostSlct rises during a strobe, invalidate that strobe.
        """
        released = net.value == net.when_inactive[1]
        if released and self.legal:
            self.legal = False
            self._show(None, self.let_go_ps)
        now, since = self.kernel.now, self.strobed_at
        if released and since is not None:
            self.strobed_at = None
            if now - since > RELEASE_PS and self.supply.powered:
                text = f"hostslct stays low for {(now - since) / NS / 1000:g} µs after a transfer; allowed at most 2 µs"
                self.chip.finding("late-release", text)

    # ------------------------------------------------------------- operations as values (parts/base/operation.py)
    def takes(self, number: int, reading: bool, ps: int) -> bool:
        """Return whether the port is ready for an operation whose first strobe begins at an instant (ps).

        The operation transfers `number` bytes; it is a read operation if `reading`.
        """
        awaited = self.ready and (number == 1 or not (self.bytes or self.half)) and not (reading and self.wanted)
        return self.supply.powered and awaited and ps - self.rose_at >= RECOVERY_PS

    def shows(self, number: int) -> bytes:
        """Return the next bytes for the host to read: at most `number`, and none beyond the present word."""
        word = (self.answer[0] if self.answer else 0).to_bytes(2, "big")
        return word[self.half :][:number]

    def operated(self, number: int, data: bytes | None, command: bool) -> None:
        """Process an operation whose last strobe ends now.

        Args:
            number: the number of bytes of the operation.
            data: the bytes written; None for a read operation.
            command: True if the byte written is a command.
        """
        self.rose_at = self.kernel.now
        if data is None and number == 2:  # a whole word, as `takes` has checked
            self.shown = self.answer[0] & 0xFF if self.answer else 0
            self._busy(self._next)
        elif data is None:
            self.read()
            self.read_on()
        elif command:
            self.command(data[0])
        else:
            for byte in data:
                self.data(byte)
        self.strobed_at = None  # HostSlct rises in time

    def resume(self, falls: Sequence[int], rises: Sequence[int], data: bytes | None, over: bool) -> None:
        """Take over an operation in progress: from now on, follow the pins edge by edge.

        Args:
            falls, rises: the edges of the operation's strobes so far (ps).
            data: the bytes written; None for a read operation.
            over: True if the operation has already been processed.
        """
        if over:
            self.strobed_at = None if self.ready else self.rose_at
            return
        if rises:
            self.rose_at = rises[-1]
            if data is None:
                self.read()
                self.read_on()
            else:
                self.data(data[0])  # with the other byte of a word the operation is over
        if len(falls) > len(rises):
            self.fell_at, self.legal = falls[-1], True
            if data is None:
                self.read()

    # -------------------------------------------------------------------------------------------------------- transfers
    def command(self, byte: int) -> None:
        """Process a command byte from the host."""
        if not self.ready:
            self._early(f"command {byte:02x} written")
            return
        if self.chip.on_command:
            self.chip.on_command(self.rows[byte].name if byte in self.rows else f"{byte:02X}")
        self._busy(lambda: self._begin_packet(byte))

    def data(self, byte: int) -> None:
        """Process a byte of a word from the host; the high byte comes first."""
        if not self.ready:
            self._early(f"data {byte:02x} written")
            return
        self.bytes.append(byte)
        if len(self.bytes) == 2:
            word = self.bytes[0] << 8 | self.bytes[1]
            self.bytes = []
            self._busy(lambda: self._take(word))

    def read(self) -> int:
        """Return the byte that the host reads; the high byte of a word comes first."""
        if not self.ready:
            self._early("data read")
            return self.shown
        if self.wanted and not self.half:
            self.chip.finding("early-read", f"{self._name} expects data, but the host reads a word: 0000 is returned")
        word = 0 if self.wanted or not self.answer else self.answer[0]
        self.shown = word & 0xFF if self.half else word >> 8
        return self.shown

    def read_on(self) -> None:
        """Advance to the next byte after one has been read; if it was the second byte of a word, lower HostRdy."""
        if not self.ready:
            return
        self.half = not self.half
        if not self.half:
            self._busy(self._next)

    def _next(self) -> None:
        if self.answer and not self.wanted:
            self.answer.popleft()

    def _early(self, what: str) -> None:
        self.chip.finding("busy-access", f"{what} while HostRdy is low: it has no effect")

    def _busy(self, then: Callable[[], None]) -> None:
        """Lower HostRdy for a slice, then call a function and raise HostRdy, unless a reset occurs first."""
        starts = self.supply.starts
        self.ready = False
        self.ready_driver.put(self.ready_driver.inactive_level)
        self.strobed_at = self.kernel.now
        self.activity.serve()

        tick = self.clock.ticks_from(self.kernel.now) + self.busy_ticks
        self.kernel.call_at(self.clock.ps(tick), partial(self._serve, starts, then))

    def _serve(self, starts: int, then: Callable[[], None]) -> None:
        """Call a function and raise HostRdy at the end of the slice; do nothing if a reset has occurred meanwhile.

        `starts` is the number of the start during which the slice began.  After the command RESET,
        HostRdy stays low; `supply` raises it ten cycles later.
        """
        if starts != self.supply.starts:
            return
        self.motion.catch_up()
        self.ready = True
        then()
        if not self.wanted:
            self.chip.on_command("")
        if not self.supply.restarted():
            self.ready_driver.put(self.ready_driver.active_level)
            self.activity.served()

    def open(self) -> None:
        """Raise HostRdy after reset."""
        self.ready = True
        self.ready_driver.activate()
        self.activity.begin()

    # ---------------------------------------------------------------------------------------------------------- packets
    @property
    def _name(self) -> str:
        return "a packet" if self.row is None else self.row.name

    def _begin_packet(self, code: int) -> None:
        """Begin a packet with a command byte."""
        if self.bytes:
            self.chip.finding(
                "odd-byte", f"half a word, byte {self.bytes[0]:02x}, arrived before command {code:02x} and is dropped"
            )
            self.bytes = []
        if self.wanted:
            text = f"command {code:02x} while {self._name} is waiting for words: {self._name} is dropped"
            self.chip.finding("aborted-packet", text)
        self.half, self.words, self.wanted, self.code = False, [], 0, code
        self.answer, self.silent = deque(), False
        self.row = row = self.rows.get(code)
        if row is None:
            self._without_row(code)
            return
        self.wanted = sum(arg.size for arg in row.args) // 2
        if not self.wanted:
            self._perform(row)

    def _without_row(self, code: int) -> None:
        """Process a command byte that is not a command of this part."""
        if code in self.codes.illegal:
            self.chip.finding(
                "illegal-command",
                f"{code:02x} is not a command of the {self.chip.sheet.part}: it is answered with a checksum of 0",
            )
            self.silent, self.answer = True, deque([0])
            return
        if code not in self.codes.reserved and code not in self.codes.siblings:
            self.chip.finding("undocumented-command", f"{code:02x} is not in the manual: it has no effect")
        sibling = self.codes.siblings.get(code)
        self.wanted = sibling.writes if sibling is not None else 0
        if SERVO not in self.reported and (text := servo(self.chip.sheet, code)):
            self.reported.add(SERVO)  # the others are not reported
            self.chip.finding("servo-command", text)
        if not self.wanted:
            self._answer([0] * (sibling.reads if sibling is not None else 0))

    def _take(self, word: int) -> None:
        """Process a word from the host; if it completes the packet, execute the command."""
        if not self.wanted:
            if not self.silent:
                self.chip.finding(
                    "extra-word", f"word {word:04x} after {self._name}, which needs no more words, is dropped"
                )
            return
        self.words.append(word)
        self.wanted -= 1
        if self.wanted:
            return
        if self.row is None:
            self._answer([])
        else:
            self._perform(self.row)

    def _perform(self, row: PacketRow) -> None:
        """Execute the command of a complete packet."""
        chip = self.chip
        if row.encoder and not chip.sheet.encoder and row.name not in self.reported:
            self.reported.add(row.name)
            part = chip.sheet.part
            chip.finding(
                "no-encoder",
                f"{row.name} needs an encoder: the {part} accepts the command, but ignores it; use the {part}-e",
            )
        data = b"".join(word.to_bytes(2, "big") for word in self.words)
        found = self.instructions.perform(row, int.from_bytes(data, "big"))
        if found is None:
            self._answer([])
            return
        size = row.reads[0].size
        value = found % (1 << 8 * size)
        self._answer([value >> 16, value & 0xFFFF] if size == 4 else [value])

    def _answer(self, words: list[int]) -> None:
        """Prepare the words that the host will read, followed by the checksum."""
        self.answer = deque([*words, checksum(self.code, [*self.words, *words])])
