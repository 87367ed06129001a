"""What each command of the CY525 does: one method a row of the sheet, found by its name (do_loop for LOOP)."""

from __future__ import annotations

from collections.abc import Awaitable

from ...core.timebase import readable
from . import sheet
from .port import Port
from .state import T

PARAMETERS = {"N": "number", "S": "slope", "R": "rate", "F": "firstrate", "Z": "divisor"}


class Instructions(Port):
    """The handlers, in the order of Table V, and what several of them need."""

    def load(self, letter: str, value: int) -> None:
        """A parameter register takes a value."""
        name = PARAMETERS[letter]
        self.reg[name] = value
        self.unset.discard(name)

    def do_absolute(self, position: int) -> None:
        self.axis1.load(position)
        self.axis1.log.mark("command", f"A {position}")
        self.unset.discard("position")

    def do_bitset(self) -> None:
        self.programmable_output.drive(1)

    def do_clearbit(self) -> None:
        self.programmable_output.drive(0)

    async def do_delay(self, delay: int) -> None:
        self.waits(f"D {delay} ({readable(self.clock.ps(delay * T['millisecond']))})")
        await self.ticks(delay * T["millisecond"])

    def do_enter(self) -> None:
        if self.pc is not None:
            self.finding("enter-while-running", "E in a running program: " + ("refused" if self.live else "skipped"))
            return
        self.buffer = bytearray()
        self.labels = {}
        self.overflowed = False
        self.entering = True
        self.prog.drive(0)

    def do_quit(self) -> None:
        if not self.entering:
            self.finding("quit-outside-entry", "Q outside program entry: no action")
        self.entering = False
        self.prog.drive(None)

    def do_firstrate(self, rate: int) -> None:
        self.load("F", rate)

    def do_go(self) -> Awaitable[None]:
        self.check_registers("G")
        return self.motion.move(self.reg["number"], 1 if self.clockwise else -1, "G")

    def do_haltmode(self) -> None:
        self.continuous = True

    def do_initialize(self) -> None:
        self.end_run()
        self.reset_registers()
        self.set_direction(True)
        for driver in self.phase_pins:
            driver.drive(1)
        self.prog.drive(None)

    def do_jump(self, target: int) -> None:
        self.begin_run(self.resolved(target))

    def do_loop(self, count: int, target: int) -> None:
        target = self.resolved(target)
        if not self.in_program():
            if count != 1:
                self.finding("loop-command", "L given as a command starts the program at its target")
                self.begin_run(target)
            return
        if self.loop is None:
            if count == 0:
                self.finding("loop-zero", "L 0: an 8-bit counter runs through, 256 passes")
            self.loop = (self.at, count or 256)
        elif self.loop[0] != self.at and "nested-loop" not in self.said:
            self.said.add("nested-loop")
            self.finding(
                "nested-loop",
                f"L at byte {self.at} while the L at byte {self.loop[0]} is counting: it takes over its count",
            )
        left = self.loop[1] - 1
        self.loop = (self.loop[0], left) if left else None
        if left:
            self.pc = target

    def do_number(self, steps: int) -> None:
        self.load("N", steps)

    async def do_offset(self, offset: int) -> None:
        if offset > 3:
            if offset > 127:
                self.pulse.drive(0)
                await self.ticks(T["phase_pulse"])
                self.pulse.drive(1)
            levels = (1, 1, 1, 1)
        else:
            self.phase = offset
            levels = sheet.PHASES[offset]
        for driver, phase_level in zip(self.phase_pins, levels, strict=True):
            driver.drive(phase_level)

    async def do_position(self, position: int) -> None:
        self.check_registers(f"P {position}")
        here = self.position
        clockwise = position >= here
        number = position - here if clockwise else here - position
        await self.motion.move(number, 1 if clockwise else -1, f"P {position}")

    def do_rate(self, rate: int) -> None:
        self.load("R", rate)

    def do_slope(self, slope: int) -> None:
        self.load("S", slope)

    def do_til(self, target: int) -> None:
        target = self.resolved(target)
        if self.dowhile.level == 0:
            if self.in_program():
                self.pc = target
            else:
                self.finding("til-command", "T given as a command starts the program at its target")
                self.begin_run(target)

    async def do_until(self) -> None:
        await self.wait_for("U", 0)

    def do_verify(self, group: int) -> None:
        if group not in sheet.VERIFY_BYTES:
            self.finding("verify-group", f"V {group}: there are groups 0 to 3; the pointer stays")
            return
        if self.in_program():
            self.finding("verify-in-program", "V in a program: it only sets the pointer")
            self.ascii = self.mode.level == 1
        self.group = (group, self.ascii)
        self.output, self.fetched = None, 0

    async def do_wait(self) -> None:
        await self.wait_for("W", 1)

    def do_execute(self) -> None:
        self.begin_run(0)

    def do_divisor(self, divisor: int) -> None:
        self.load("Z", divisor)

    def do_cw(self) -> None:
        self.set_direction(True)

    def do_ccw(self) -> None:
        self.set_direction(False)

    def do_command(self) -> None:
        self.end_run()

    # ------------------------------------------------------------------------------------- what several of them need
    def begin_run(self, target: int) -> None:
        """Start the program, or send it elsewhere."""
        if self.pc is None or self.live:
            self.loop = None
        if self.pc is None:
            self.run_fell, self.at = self.tick, target
            self.run_pin.drive(0)
            self.request.watch(self.on_request)
        self.pc, self.following = target, 0

    def check_registers(self, text: str) -> None:
        """Parameters that the manual does not allow, or that nobody has set."""
        reg = self.reg
        used = {"slope", "rate", "firstrate", "divisor", "number" if text == "G" else "position"}
        for name in sorted(used & self.unset):
            self.unset.discard(name)
            self.finding("uninitialised", f"{text} uses the {name} register, which nobody has set since power-up")
        for bad, code, what in (
            (reg["rate"] < reg["firstrate"], "rate-below-firstrate", "R is below F: the whole move runs at F"),
            (
                min(reg["rate"], reg["firstrate"]) <= 2,
                "slow-rate",
                "rates 0, 1 and 2 are not fixed by the manual: 275, 283, 292 steps/s",
            ),
            (reg["slope"] == 0, "range", "S 0 is outside 1 to 255: a little slower than S 1"),
            (reg["divisor"] == 0, "range", "Z 0 is outside 1 to 255: it divides by 256"),
        ):
            if bad and what not in self.said:
                self.said.add(what)
                self.finding(code, what)

    def set_direction(self, clockwise: bool) -> None:
        self.clockwise = clockwise
        self.direction.drive(1 if clockwise else 0)

    def resolved(self, target: int) -> int:
        """A branch target: a label gives way to its address, in the buffer too, when it is first executed (s.3)."""
        if target < sheet.BUFFER_BYTES or chr(target) not in sheet.LABELS:
            return target
        address = self.labels.get(chr(target))
        if address is None:
            self.finding("missing-label", f"label {chr(target)} was never defined")
            return target
        if self.in_program():
            assert self.pc is not None
            self.buffer[self.pc - 1] = address
        return address

    async def wait_for(self, letter: str, wanted: int) -> None:
        """U and W: look at WAIT every 8 us; a new low of I/O REQUEST ends the wait too (s.3 item 8)."""
        self.waiting_pin = True
        self.waits(f"{letter}: wait={wanted}")
        try:
            if not self.in_program() and self.request.changes == self.accepted:
                ended = await self.polled(self.wait, wanted, T["wait_poll"], (self.request, 1))
                if ended is self.wait:
                    return  # else the request of the terminator has gone away, and a new one counts
            before = self.request.changes
            ended = await self.polled(self.wait, wanted, T["wait_poll"], (self.request, 0))
            if ended is self.request and self.request.changes > before:
                self.ended_wait = self.request.changes
                if not self.in_program():
                    self.accepted = self.ended_wait  # READY waits for its end
        finally:
            self.waiting_pin = False
