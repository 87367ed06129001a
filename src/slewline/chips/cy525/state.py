"""What a CY525 is made of: pins by name, registers, the program buffer, flags.

The firmware is one program in chapters, each a class that knows those before it:

    state.py         pins, registers, flags                      (this file)
    supply.py        power, RESET
    port.py          a byte in, a verify byte out                (fig. 7.3, 7.1)
    instructions.py  what each command does, one method a row of the sheet
    firmware.py      commands, the stored program, live commands

and motion.py plays what profile.py plans.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ...core.axis import Axis
from ...core.chip import Chip
from ...core.kernel import Kernel
from ...core.net import Net
from ...core.step_views import PulseView
from ...core.train import OPEN, Playing, StepTrain
from ...language.letters import Decoder
from . import sheet
from .ideal import Made

if TYPE_CHECKING:
    from ...core.program import ProgramRow
    from .motion import Motion
    from .profile import Law
    from .stepwise import Stepwise

T = {name: time.ticks for name, time in sheet.TIMES.items()}
TICKS_PER_US = sheet.REFERENCE_HZ // 1_000_000


class State(Chip):
    """Pins, registers and flags of a CY525."""

    sheet = sheet.SHEET
    motion: Motion | Stepwise
    law: Law  # of the ramps

    def __init__(self, kernel: Kernel, name: str, /, crystal_hz: int | None = None, **given: Any) -> None:
        super().__init__(kernel, name, crystal_hz, **given)
        self.defaults: dict[str, int] = {row.name: getattr(self.options, row.name) for row in sheet.REGISTERS}
        self.reg = dict(self.defaults)
        self.axis1 = Axis(kernel, range(1 << 16), self.reg.pop("position"))
        self.axes = (self.axis1,)
        self.unset = set(self.defaults)  # registers that no command has loaded since power-up
        self.said: set[str] = set()  # findings that are reported once
        self.decoder = Decoder(sheet.SHEET)
        self.accepted = self.ended_wait = -1  # changes of I/O REQUEST: with the last byte, when it ended U or W
        self.unanswered = -1  # the same, when it fell in a running program
        self.requested = self.busy_from = self.busy_ps = 0  # of the byte in work: its request, READY low
        self.run_fell = 0  # tick at which RUN fell
        self.at = self.following = 0  # addresses of the running instruction and of the one behind it
        self.pc: int | None = None  # address of the next instruction; None: no program runs
        self.ascii = True  # pin 36, as it was with the command letter
        self._name_pins()
        self.reset_registers()

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
        self.phase_pins = tuple(drivers[f"phase{n}"] for n in (1, 2, 3, 4))

    def end_run(self) -> None:
        """The program, if one runs, is over."""
        if self.pc is not None:
            self.pc = None
            self.on_command("")
            self.run_pin.drive(1)
            self.request.observers.remove(self.on_request)

    def on_request(self, net: Net) -> None:
        """A running program does not see a request; only its edge can tell (watched while a program runs)."""
        if net.level == 0 and self.prog_in.level == 1 and not (self.live or self.motion.moving or self.waiting_pin):
            self.unanswered = self.request.changes
            self.finding(
                "request-while-running", "I/O REQUEST lowered in a running program without PROG/LIVE: not answered"
            )

    def watch_inputs(self) -> None:
        """Put on the observers that an input needs besides the looks of the firmware."""
        self.request.latched = True

    def reset_registers(self) -> None:
        """What power-up, RESET and I have in common: flags and pointers, not the parameters (s.4)."""
        self.buffer = bytearray()
        self.labels: dict[str, int] = {}
        self.overflowed = False
        self.continuous = False
        self.clockwise = True
        self.phase = 0
        self.loop: tuple[int, int] | None = None  # (address of the L that counts, what is left)
        self.pc = None
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

    def made(self, number: int) -> Made:
        """The parameters of a motion of so many steps that begins now."""
        reg = self.reg
        return Made(self.crystal_hz, reg["firstrate"], reg["rate"], reg["slope"], reg["divisor"], number, self.law)

    @property
    def program(self) -> bytes:
        """The program buffer in use, as stored."""
        return bytes(self.buffer)

    @property
    def program_counter(self) -> int | None:
        """The byte of the buffer at which the instruction in work begins, or the next one while live commands come."""
        return self.pc if self.pc is None or self.live else self.at

    def program_rows(self) -> list[ProgramRow]:
        """Return the program buffer, an instruction a row: address, bytes and text."""
        from ...language.disassemble import program_rows

        return program_rows(bytes(self.buffer), self.sheet)

    def listing(self) -> str:
        """The stored program as text, with addresses."""
        from ...language.disassemble import listing

        return listing(bytes(self.buffer), self.sheet)

    def instruction_begins(self) -> None:
        """Tell of the instruction that is in work from now on."""
        if self.on_instruction:
            self.on_instruction(self.at)
        if self.on_command:
            from ...language.disassemble import text_at

            self.on_command(text_at(bytes(self.buffer), self.at, self.sheet))

    def in_program(self) -> bool:
        """Is the running instruction one of the program (not a command of the host)?"""
        return self.pc is not None and not self.live

    def renew_outputs(self) -> None:
        """The bound of the train has moved: whoever watches PULSE or a phase must hear of it."""
        self.pulse.renew()
        for driver in self.phase_pins:
            driver.renew()
