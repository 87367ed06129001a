"""What the CY525 does, as one program, in the order in which a logic analyser would show it.

A byte comes in (fig. 7.3; times at 11 MHz):

    I/O REQUEST  ‾‾‾\\______________________/‾‾‾‾‾‾‾‾‾‾‾‾‾‾
    INSTROBE     ‾‾‾‾‾‾‾‾‾‾\\_/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾
    READY        ‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾\\___________________/‾‾‾
                    |15 us   |1|10 us|   decoding, effect  |   READY waits for I/O REQUEST high, however long

The bus is read at the rising edge of INSTROBE.  The effect of a command shows shortly before READY returns; motions,
delays and waits begin where READY would return.  Where the manual is silent see quirks.py.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping

from ...core.chip import Axis, Chip
from ...core.kernel import Kernel
from ...core.net import Driver, Net, Wave
from ...core.timebase import readable
from ...core.train import OPEN, Playing, PulseView, StepTrain
from ...core.waits import level, until
from ...errors import UsageError
from ...language.dialects import Command, Decoder, Label
from . import sheet
from .motion import Motion
from .readout import group_bytes

T = {name: time.ticks for name, time in sheet.TIMES.items()}
STROBE, BUSY, LETTER = T["instrobe_delay"], T["busy_delay"], T["letter"]
SAMPLE = STROBE + T["strobe_width"]  # the bus is read at the rising edge of INSTROBE
TICKS_PER_US = sheet.REFERENCE_HZ // 1_000_000
LETTERS = {row.code: row for row in sheet.COMMANDS if row.stored}
PARAMETERS = {"N": "number", "S": "slope", "R": "rate", "F": "firstrate", "Z": "divisor"}


class Cy525(Chip):
    """A CY525 on a bench.

    Args:
        stepwise: play every motion step by step instead of whole; slow, and the same to the last edge.
        position, number, slope, rate, firstrate, divisor: what the registers hold at power-up (random in the real part).
        cold: begin without supply; `power(True)` and RESET low for 10 ms bring the chip up.
    """

    sheet = sheet.SHEET

    def __init__(
        self,
        kernel: Kernel,
        name: str,
        crystal_hz: int | None = None,
        *,
        bare: bool = False,
        straps: Mapping[str, int] | None = None,
        stepwise: bool = False,
        cold: bool = False,
        **registers: int,
    ) -> None:
        super().__init__(kernel, name, crystal_hz, bare=bare, straps=straps)
        self.defaults = {register.name: register.default for register in sheet.REGISTERS}
        for key, value in registers.items():
            if key not in self.defaults:
                raise UsageError(f"{name}: no option or register {key!r}; registers: {', '.join(self.defaults)}")
            top = next((1 << row.bits) - 1 for row in sheet.REGISTERS if row.name == key)
            if not isinstance(value, int) or not 0 <= value <= top:
                raise UsageError(f"{name}: {key} {value!r}; allowed 0..{top}")
            self.defaults[key] = value
        self.reg = dict(self.defaults)
        self.axis_ = Axis(kernel, 16, self.reg.pop("position"))
        self.axes = (self.axis_,)
        self.unset = set(self.defaults)  # registers that no command has loaded since power-up
        self.said: set[str] = set()  # findings that are reported once
        self.decoder = Decoder(sheet.SHEET)
        self.handlers: dict[int, Callable[..., Awaitable[None] | None]] = {
            row.code: getattr(self, row.handler) for row in sheet.COMMANDS if row.stored
        }
        self._name_pins()
        if stepwise:
            from .stepwise import Stepwise

            self.motion: Motion = Stepwise(self)
        else:
            self.motion = Motion(self)
        self.powered, self.cold = not cold, cold
        self.reset_valid = False
        self.reset_fell = self.powered_at = 0
        self.inner_reset = Driver(Net(kernel, f"{name}.(reset seen)"), name)
        self.inner_reset.drive(0 if cold else 1)
        kernel.settle()
        self.inner_reset.net.watch(self._on_inner_reset)
        self.accepted = self.ended_wait = -1  # changes of I/O REQUEST: with the last byte, when it ended U or W
        self.run_fell = self.busy_from = self.busy_ps = self.requested = self.at = self.following = 0
        self.ascii = True
        self.reset_registers()
        if self.powered:
            self.outputs_high()
            self.clock_runs()
        self._watch_inputs()
        if not 1_000_000 <= self.crystal_hz <= 11_000_000:
            self.finding("crystal", f"{self.crystal_hz / 1e6:g} MHz is outside the 1 to 11 MHz of Table VIII; times scale all the same")
        if cold:
            self.waits("power")
        else:
            self.start()

    # -------------------------------------------------------------------------------------------------------- wiring
    def _name_pins(self) -> None:
        net: Callable[[str], Net] = lambda name: self.pins[name].net  # noqa: E731
        self.request, self.select, self.abort = net("io_request"), net("io_select"), net("abort")
        self.inhibit, self.wait, self.dowhile = net("step_inhibit"), net("wait"), net("dowhile")
        self.prog_in, self.mode, self.reset_net = net("prog"), net("ascii_binary"), net("reset")
        drivers = self.drivers
        self.ready, self.instrobe, self.outstrobe = drivers["ready"], drivers["instrobe"], drivers["outstrobe"]
        self.slew, self.run_pin, self.prog = drivers["slew"], drivers["run"], drivers["prog"]
        self.direction, self.pulse = drivers["direction"], drivers["pulse"]
        self.programmable_output, self.motion_complete = drivers["programmable_output"], drivers["motion_complete"]
        self.phases = tuple(drivers[f"phase{n}"] for n in (1, 2, 3, 4))

    def rewired(self) -> None:
        """Pins have been joined with others: take their nets anew (called by the bench before the first run)."""
        self._name_pins()
        self._watch_inputs()

    def _watch_inputs(self) -> None:
        self.request.latched = True
        for net, observer in ((self.reset_net, self._on_reset), (self.select, self._on_select)):
            if observer not in net.observers:
                net.watch(observer)

    def _on_request(self, net: Net) -> None:
        """A running program does not see a request; only its edge can tell (watched while a program runs)."""
        if net.level == 0 and self.prog_in.level == 1 and not (self.live or self.motion.moving or self.waiting_pin):
            self.finding("request-while-running", "I/O REQUEST lowered in a running program without PROG/LIVE: not answered")

    def _on_select(self, _net: Net) -> None:
        if self.task is not None and self.ready.net.level == 0 and not self.motion.moving:
            self.finding("select-while-busy", "I/O SELECT changed while READY is low: it counts at the next READY")

    # --------------------------------------------------------------------------------------------------------- state
    def reset_registers(self) -> None:
        """What power-up, RESET and I have in common: flags and pointers, not the parameters (s.4)."""
        self.buffer = bytearray()
        self.labels: dict[str, int] = {}
        self.overflowed = False
        self.continuous = False
        self.clockwise = True
        self.phase = 0
        self.loop: tuple[int, int] | None = None  # (address of the L that counts, what is left)
        self.pc: int | None = None  # None: no program runs
        self.entering = False
        self.live = False
        self.label: str | None = None
        self.group: tuple[int, bool] | None = None  # V: group, and whether V was given in ASCII
        self.output: bytes | None = None  # the group as captured at its first fetch
        self.fetched = 0
        self.waiting_pin = False

    def outputs_high(self) -> None:
        """Every output to 1 (s.13)."""
        for row in self.sheet.pins:
            if row.way == "out" and row.reset == 1:
                self.drivers[row.name].drive(1)
        self.prog.drive(None)
        self.bus_driver.drive(None)

    def outputs_off(self) -> None:
        """Without supply no output drives its pin."""
        for driver in (*self.drivers.values(), self.bus_driver):
            driver.drive(None)

    def clock_runs(self) -> None:
        """CLK/15 runs from power-up on, whatever else happens (s.13)."""
        clock = Playing(StepTrain(self.clock, self.clock.ticks_from(self.kernel.now), ((15, OPEN),)))
        self.drivers["clk15"].play(PulseView(clock, 10))  # 5 of 15 clocks low: 0.45 us at 11 MHz

    @property
    def registers(self) -> dict[str, int]:
        """The manual's registers: number, slope, rate, firstrate, divisor, position."""
        return {**self.reg, "position": self.position}

    def parameters(self) -> tuple[dict[str, float], dict[str, object]]:
        """What a plot names: the rates of F and R in steps/s at this crystal, and S, Z, N."""
        rates = {
            f"{letter} = {self.reg[name]}": self.crystal_hz / sheet.STEP_TICKS[min(self.reg[name], sheet.RATE_TOP)]
            for letter, name in (("F", "firstrate"), ("R", "rate"))
        }
        return rates, {"S": self.reg["slope"], "Z": self.reg["divisor"], "N": self.reg["number"]}

    @property
    def program(self) -> bytes:
        """The program buffer in use, as stored."""
        return bytes(self.buffer)

    def listing(self) -> str:
        """The stored program as text, with addresses."""
        from ...language.disassemble import listing

        return listing(bytes(self.buffer), self.sheet)

    # ------------------------------------------------------------------------------------------------ reset and power
    def power(self, on: bool) -> None:
        """Switch the supply.  After power-up the registers hold their power-up values, and RESET must be low for 10 ms;
        when nobody drives RESET, the capacitor of fig. 9.1 does it."""
        if on == self.powered:
            return
        if self.on_power is not None:
            self.on_power(self, on)
        self.powered, self.cold, self.reset_valid = on, True, False
        self.inner_reset.drive(0)
        if on:
            self.reg = {name: value for name, value in self.defaults.items() if name != "position"}
            self.axis_.load(self.defaults["position"])
            self.unset = set(self.defaults)
            self.outputs_high()
            self.clock_runs()
            self._power_up_reset()
        else:
            self.outputs_off()
            self.waits("power")
        self.kernel.settle()

    def _power_up_reset(self) -> None:
        """The supply has come: who holds RESET low for 10 ms?"""
        on = self.powered_at = self.kernel.now
        if all(driver.at(self.kernel.seen) is None for driver in self.reset_net.drivers):
            charged = on + sheet.POWER_UP_RC_PS
            self.waits(f"the capacitor at RESET, charged at {readable(charged)}")
            self.kernel.call_at(charged, lambda: self._capacitor_charged(on))
            return
        self.waits("RESET low for 10 ms")
        if self.reset_net.level == 0:
            self._on_reset(self.reset_net)
        else:
            self.finding("no-power-up-reset", "RESET is high at power-up: the chip stays inert until a valid reset")

    def _capacitor_charged(self, on: int) -> None:
        """RESET rises by itself, unless somebody holds it low by now."""
        if self.powered and self.cold and self.powered_at == on:
            if self.reset_net.level == 0:
                self.reset_valid = True
            else:
                self.cold = False
                self.inner_reset.drive(1)

    def reset(self) -> None:
        """Pulse RESET low for 20 us at 6 MHz from now on."""
        self.pin("reset").pulse(0, self.clock.ps(120) + 1)

    def _on_reset(self, net: Net) -> None:
        if not self.powered:
            return
        if net.level == 0:
            fell = self.reset_fell = self.kernel.now
            warm = self.clock.ps(self.clock.ticks_until(fell) + T["reset_pulse"])
            self.kernel.call_at(fell + sheet.POWER_UP_RESET_PS if self.cold else warm, lambda: self._reset_seen(fell))
        elif self.reset_valid:
            self.reset_valid = self.cold = False
            self.inner_reset.drive(1)
        elif self.cold:
            self.finding("reset-short", "RESET low for less than 10 ms after power-up: the chip stays inert")
        else:
            self.finding("reset-short", "RESET low for less than 15 us at 6 MHz: not seen")

    def _reset_seen(self, fell: int) -> None:
        """RESET has been low for long enough; the inner net makes the kill the last thing of the instant."""
        if self.powered and self.reset_net.level == 0 and self.reset_fell == fell:
            self.reset_valid = True
            if self.cold:
                self.waits("RESET high")
            self.inner_reset.drive(0)

    def _on_inner_reset(self, net: Net) -> None:
        self.stop()
        if net.level == 1:
            self.start()
            return
        if self.pc is not None:
            self.request.observers.remove(self._on_request)
        self.motion.killed()
        self.accepted = self.ended_wait = -1
        self.decoder.reset()
        self.reset_registers()
        if self.powered:
            self.outputs_high()
            self.waits("RESET high")
        else:
            self.outputs_off()
            self.waits("power")

    # ---------------------------------------------------------------------------------------------------- the program
    async def run(self) -> None:
        """The firmware from reset on: commands as they come, a program when one is started."""
        while True:
            command = await self.next_command()
            await self.execute(command)
            if self.pc is not None:
                await self.run_program()

    # -------------------------------------------------------------------------------------------------- bytes (fig. 7.3)
    async def next_byte(self) -> int:
        """Take the next byte from the bus; verify bytes are handed out meanwhile.

        I/O REQUEST and I/O SELECT are watched nets, so `value` is what a look sees.
        """
        request, kernel, ps = self.request, self.kernel, self.clock.ps
        while True:
            if request.value != 0:
                self.idle = self.pc is None
                text = "the rest of a command" if not self.decoder.at_letter else "a live command" if self.live else "a command"
                self._waiting = (text, kernel.now)
                await level(request, 0)
                request = self.request  # before the first run, wiring may have made it another net
                self.idle = False
            elif request.changes == self.ended_wait and not self.live:
                self.waits("io_request=1, which ended a wait")
                await level(request, 1)  # it has had its effect; it brings no byte
                continue
            elif self.accepted >= 0 and not self.live:
                self.finding("early-request", "I/O REQUEST was lowered while READY was low: it is served now")
            self.requested = self.tick = tick = self.clock.ticks_from(kernel.now)
            if self.select.value == 1:
                await self.output_byte()
                continue
            self.tick = sampled = tick + SAMPLE
            at = ps(sampled)
            self.instrobe.wave(1, (ps(tick + STROBE), at), (0, 1))
            await until(kernel, at)
            if request.value == 1:
                self.finding("short-request", "I/O REQUEST rose before INSTROBE ended: the byte is lost")
                continue
            self.accepted = request.changes
            byte: int = self.bus.byte
            if self.decoder.at_letter:
                self.ascii = self.mode.level == 1
            self.tick = self.busy_from = sampled + BUSY
            self.busy_ps = busy = ps(sampled + BUSY)
            self._waiting = ("a byte in work", kernel.now)
            if self.motion_complete.net.value != 1:
                self.motion_complete.drive(1)
            await until(kernel, busy)
            self.ready.drive(0)
            return byte

    async def finish(self, tick: int) -> None:
        """End the handshake: READY returns at a tick, but not before I/O REQUEST has been high (s.7)."""
        if tick > self.tick:
            self.tick = tick
            await until(self.kernel, self.clock.ps(tick))
        request = self.request
        if request.changes > self.accepted:
            if request.changed_at < self.busy_ps:
                self.finding("short-request", "I/O REQUEST rose before READY fell; the byte counts")
        elif request.value == 0:
            self.waits("io_request=1 before READY returns")
            await level(request, 1)
            self.sync()
        self.ready.drive(1)

    async def output_byte(self) -> None:
        """Put the next byte of the verify group on the bus until I/O REQUEST rises (fig. 7.1)."""
        ps = self.clock.ps
        byte = self.next_output()
        self.accepted = self.request.changes
        strobe = self.tick + T["instrobe_delay"]
        width = T["strobe_width"]
        self.bus_driver.play(Wave(None, (ps(strobe - width),), ((0xFF, byte),)))
        self.outstrobe.play(Wave(1, (ps(strobe), ps(strobe + width)), (0, 1)))
        self.busy_from = strobe + width + T["busy_delay"]
        self.busy_ps = ps(self.busy_from)
        self.ready.wave(1, (self.busy_ps,), (0,))
        self.motion_complete.drive(1)
        self.waits("io_request=1 after a verify byte")
        await self.at_tick(self.busy_from + width)
        self.bus.resolve(self.kernel.seen)  # a host that drives the bus as well is found, whether anybody looks or not
        if self.request.changes > self.accepted and self.request.changed_at < ps(self.busy_from):
            self.finding("short-request", "I/O REQUEST rose before READY fell; the byte was on the bus all the same")
        if self.request.changes == self.accepted:
            await level(self.request, 1)
            self.sync()
        strobe = self.tick + T["instrobe_delay"]
        self.outstrobe.play(Wave(1, (ps(strobe), ps(strobe + width)), (0, 1)))
        self.bus_driver.play(Wave((0xFF, byte), (ps(strobe + width),), (None,)))
        await self.at_tick(strobe + width + T["busy_delay"])
        self.bus_driver.drive(None)
        self.ready.drive(1)

    def next_output(self) -> int:
        """The next byte of the group that V points at; FF where there is none."""
        if self.group is None:
            self.finding("verify-without-v", "a read-out without any V before: FF")
            return 0xFF
        if self.output is None:
            self.output = group_bytes(self, *self.group)
        if self.fetched >= len(self.output):
            self.finding("verify-overrun", f"group {self.group[0]} has {len(self.output)} bytes: FF")
            return 0xFF
        if self.group[0] == 1 and self.fetched == sheet.VERIFY_BYTES[1]:
            self.finding("verify-48", "the manual guarantees the first 48 bytes of the program")
        self.fetched += 1
        return self.output[self.fetched - 1]

    # ------------------------------------------------------------------------------------------------------- commands
    async def next_command(self) -> Command:
        """The next command that is to be executed; in program entry commands are stored instead, until Q."""
        while True:
            byte = await self.next_byte()
            decoder = self.decoder
            found = decoder.feed(byte, self.ascii, self.entering)
            if decoder.notes:
                for note in decoder.take_notes():
                    self.finding(note.code, note.text)
            if type(found) is Command:
                if not self.entering or found.row.form == "Q":
                    return found
                self.store(found)
                await self.finish(self.busy_from + T["store"] + found.digits * T["digit"])
                continue
            if type(found) is Label:
                self.mark(found.letter)
            await self.finish(self.requested + LETTER)

    async def execute(self, command: Command) -> None:
        """Perform a command given by the host, and end its handshake."""
        row = command.row
        end = self.busy_from + row.time_us * TICKS_PER_US + command.digits * T["digit"]
        self.waits(f"{command.text} in work")
        if row.form == "Q":
            await self.at_tick(end - T["effect_lead"])
            self.do_quit()
        elif row.form in "GPDUW":  # these go on for as long as they take
            await self.at_tick(end)
            work = self.handlers[row.code](*command.values)
            if work is not None:
                await work
            end = self.tick
        else:
            await self.at_tick(end - T["effect_lead"])
            work = self.handlers[row.code](*command.values)
            if work is not None:
                await work
        await self.finish(end)

    def store(self, command: Command) -> None:
        """Program entry: keep the command; what does not fit is dropped."""
        self.buffer += command.stored
        if len(self.buffer) > sheet.BUFFER_BYTES:
            del self.buffer[sheet.BUFFER_BYTES :]
            if not self.overflowed:
                self.finding("overflow", f"{command.text} does not fit into the {sheet.BUFFER_BYTES} bytes of the program buffer")
            self.overflowed = True

    def mark(self, letter: str) -> None:
        """`A$`: name the next instruction of the program."""
        if not self.entering:
            self.finding("label-outside-program", f"{letter}$ outside program entry: ignored")
            return
        if letter in self.labels:
            self.finding("label-twice", f"{letter}$ again: the last one counts")
        self.labels[letter] = len(self.buffer)

    # ------------------------------------------------------------------------------------------------ program execution
    async def run_program(self) -> None:
        """Fetch and perform instructions until 0, I or reset; between two of them PROG/LIVE is looked at (s.7)."""
        due = self.run_fell + T["first_instruction"]
        self.sync()
        while self.pc is not None:
            if self.prog_in.level == 0:
                await self.live_commands()
                due = self.tick
                continue
            if not 0 <= self.pc < len(self.buffer):
                self._no_instruction()
                await self.polled(self.prog_in, 0, T["wait_poll"])
                continue
            await self.instruction(due)
            due = self.tick

    def _no_instruction(self) -> None:
        assert self.pc is not None
        if self.pc >= sheet.BUFFER_BYTES and self.pc != self.following:
            self.finding("bad-target", f"byte {self.pc} is outside the program buffer (0 to 59): run mode, nothing to execute")
        else:
            self.finding("end-of-program", f"no instruction at byte {self.pc}: run mode, nothing to execute")
        self.waits("run mode with nothing to execute: a live 0 or RESET")

    async def instruction(self, due: int) -> None:
        """One instruction: its time passes first, then it acts.  The first one acts 60 us after RUN fell."""
        assert self.pc is not None
        at = self.pc
        code = self.buffer[at]
        row = LETTERS.get(code)
        first = due > self.tick
        if row is None:
            self.finding("unknown-opcode", f"byte {at} of the program, {code:02X}: skipped")
            self.pc = self.following = at + 1
            self.waits(f"byte {at}, {code:02X}, is skipped")
            await self.ticks(40 * TICKS_PER_US)
            return
        values = row.unpack(bytes(self.buffer[at + 1 : at + row.size]))
        self.pc = self.following = at + row.size
        self.at = at
        self.waits(f"{row.form} at byte {at} in work")
        await self.at_tick(due if first else self.tick + row.program_us * TICKS_PER_US)
        work = self.handlers[code](*values)
        if work is not None:
            await work

    async def live_commands(self) -> None:
        """PROG/LIVE is low: take commands from the host until it is high after one of them."""
        self.live = True
        try:
            while self.pc is not None:
                command = await self.next_command()
                await self.execute(command)
                if self.prog_in.level == 1:
                    break
        finally:
            self.live = False
        self.sync()

    def begin_run(self, target: int) -> None:
        """Start the program, or send it elsewhere."""
        if self.pc is None or self.live:
            self.loop = None
        if self.pc is None:
            self.run_fell = self.tick
            self.run_pin.drive(0)
            self.request.watch(self._on_request)
        self.pc, self.following = target, 0

    def in_program(self) -> bool:
        """Is the running instruction one of the program (not a command of the host)?"""
        return self.pc is not None and not self.live

    # ------------------------------------------------------------------------------------------- handlers, one per row
    def load(self, letter: str, value: int) -> None:
        """A parameter register takes a value."""
        name = PARAMETERS[letter]
        self.reg[name] = value
        self.unset.discard(name)

    def do_absolute(self, position: int) -> None:
        self.axis_.load(position)
        self.unset.discard("position")

    def do_bitset(self) -> None:
        self.programmable_output.drive(1)

    def do_clearbit(self) -> None:
        self.programmable_output.drive(0)

    async def do_delay(self, delay: int) -> None:
        if delay == 0:
            self.finding("range", "D 0: no delay")
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
        return self.motion.move(self.reg["number"], 1 if self.clockwise else -1, "G")

    def do_haltmode(self) -> None:
        self.continuous = True

    def do_initialize(self) -> None:
        if self.pc is not None:
            self.do_command()
        self.reset_registers()
        self.set_direction(True)
        for driver in self.phases:
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
            self.finding("nested-loop", f"L at byte {self.at} while the L at byte {self.loop[0]} is counting: it takes over its count")
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
        for driver, phase_level in zip(self.phases, levels, strict=True):
            driver.drive(phase_level)

    async def do_position(self, position: int) -> None:
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
        if self.pc is not None:
            self.pc = None
            self.run_pin.drive(1)
            self.request.observers.remove(self._on_request)

    # --------------------------------------------------------------------------------------------------------- helpers
    def set_direction(self, clockwise: bool) -> None:
        self.clockwise = clockwise
        self.direction.drive(1 if clockwise else 0)

    def resolved(self, target: int) -> int:
        """A branch target: a label letter is replaced by its address, in the buffer too, when it is first executed (s.3)."""
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
            if not self.in_program() and self.request.changes == self.accepted:  # the terminator's own request goes first
                if await self.polled(self.wait, wanted, T["wait_poll"], (self.request, 1)) is self.wait:
                    return
            before = self.request.changes
            ended = await self.polled(self.wait, wanted, T["wait_poll"], (self.request, 0))
            if ended is self.request and self.request.changes > before:
                self.ended_wait = self.request.changes
                if not self.in_program():
                    self.accepted = self.ended_wait  # READY waits for its end
        finally:
            self.waiting_pin = False

    def renew_outputs(self) -> None:
        """The bound of the train has moved: whoever watches PULSE or a phase must hear of it."""
        self.pulse.renew()
        for driver in self.phases:
            driver.renew()
