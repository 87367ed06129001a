"""What a GS-C module holds: straps, counter, speeds, program memory, EEPROM, and the names of its pins."""

from __future__ import annotations

from functools import partial
from typing import Any

from ...core.axis import Axis
from ...core.kernel import Kernel, Task
from ...core.net import Driver
from ...core.outside import from_outside
from ...core.program import ProgramRow
from ...core.serial import Straps
from ...core.store import Memory, Store
from ...core.table import Row
from ...core.timebase import picoseconds
from ...core.train import OPEN
from ...errors import UsageError
from ...language.lines import KEPT
from ..line import LineChip
from . import sheet
from .ideal import Made
from .profile import LAWS, Law

TIMES = {name: time.ticks for name, time in sheet.TIMES.items()}
OR_SINCE = (2, 2)  # GS-C200 firmware that sets a bit of every checksum
PULL_DOWN = "txpd"  # the name of its driver on a line


class State(LineChip):
    """Registers, memories and pins; what they do is in the chapters built on this one."""

    wraps: bool  # past its ends the position counter wraps; else a motion that would leave it is E5

    def __init__(self, kernel: Kernel, name: str, /, crystal_hz: int | None = None, **given: Any) -> None:
        super().__init__(kernel, name, crystal_hz, **given)
        self.store: Store = self.options.store if self.options.store is not None else Memory()
        self.eeprom_fails: bool = self.options.eeprom_fault
        self.spoiled = ""  # why the last write failed: until one succeeds, the EEPROM is not valid
        self.saving: tuple[bytes, int] | None = None  # what is being written, since when
        self.axis1 = Axis(kernel, sheet.POSITIONS[self.sheet.part], 0)
        self.axes = (self.axis1,)
        self._take_options()
        self._name_pins()
        self.pull_down = Driver(self.pins["txpd"].net, PULL_DOWN)  # drives nothing, but shows where the pull-down is
        if not self.bare and self.strapped_address() == 0:
            self._tie_pull_down()
        self.powered = False
        self.tasks: list[Task] = []
        self.program_task: Task | None = None
        self.rows: dict[int, Row] = self.sheet.commands.by_code
        self.forget()

    def _take_options(self) -> None:
        options = self.options
        self.lenient = options.lenient
        self.turnround_ps = picoseconds(options.turnround)
        self.instruction_ps = picoseconds(options.instruction_time)
        self.dir_setup_ps = picoseconds(options.dir_setup)
        self.eeprom_ps = picoseconds(options.eeprom_time)
        self.clock_ps, self.reset_ps, self.release_ps = TIMES["clock"], TIMES["reset"], TIMES["release"]
        self.law: Law = options.law if callable(options.law) else LAWS[options.law]
        early = tuple(map(int, options.firmware.split("."))) < OR_SINCE
        if early and self.sheet is not sheet.GS_C200:
            raise UsageError(
                f"{self.name}: firmware {options.firmware!r}; every {self.sheet.part.upper()} sets bit 0x10 of its "
                "checksums, as a GS-C200 does from 2.2 on: leave the option out"
            )
        self.straps = Straps(
            self.port,
            self.pins,
            kept=0 if early else KEPT,
            address=options.address,
            backwards=options.pin_order,
        )

    def _name_pins(self) -> None:
        pins, drivers = self.pins, self.drivers
        self.enable, self.eot, self.home = pins["enable"].net, pins["eot"].net, pins["home"].net
        self.inputs = tuple(pins[f"ui{n}"].net for n in (1, 2, 3))
        self.mov, self.ramp, self.dir = drivers["mov"], drivers["ramp"], drivers["dir"]
        self.clock_pin, self.reset_pin, self.rdy = drivers["clock"], drivers["reset"], drivers["rdy"]
        self.outputs = tuple(drivers[f"uo{n}"] for n in (1, 2, 3))

    def _tie_pull_down(self) -> None:
        """The standard wiring of a module on a line of its own: TXPD to TXD."""
        self.pins["txd"].net.join(self.pins["txpd"].net)

    def check_wiring(self) -> None:
        """The first run begins: report what is not wired as the sheet wants it."""
        super().check_wiring()
        if self.pins["test"].level != 0:
            self.finding("test-pin", "pin 10 (test) is not low; wire it to pin 8")
        pull_downs = [driver for driver in self.pins["txd"].net.drivers if driver.name == PULL_DOWN]
        if not pull_downs:
            self.finding("no-pull-down", "no module has its txpd on this txd: the idle line floats")
        elif len(pull_downs) > 1:
            self.finding("pull-downs", f"{len(pull_downs)} modules have their txpd on this txd; one is enough")
        self._check_supply()

    def _check_supply(self) -> None:
        low, high = sheet.SUPPLY_VOLTS
        if not low <= self.options.supply <= high:
            self.finding("supply", f"{self.options.supply:g} V; the module wants {low} to {high} V")
        for pins, limit in sheet.LOADS_MA.items():
            drawn = sum(self.options.load[pin] for pin in pins)
            if drawn > limit:
                self.finding("load", f"{drawn:g} mA from {' and '.join(pins)}; allowed {limit} mA")

    # ------------------------------------------------------------------------------------------------------ memories
    @property
    def eeprom_fault(self) -> bool:
        """Does programming the EEPROM fail?  Settable, for tests."""
        return self.eeprom_fails

    @eeprom_fault.setter
    def eeprom_fault(self, on: bool) -> None:
        self.fail_eeprom(on)

    @from_outside
    def fail_eeprom(self, on: bool = True) -> None:
        """Let programming the EEPROM fail (E6), or no more; an input, which a journal repeats.

        Raises:
            UsageError: `on` is no bool.
        """
        if not isinstance(on, bool):
            raise UsageError(f"{self.name}: eeprom_fault {on!r}; allowed True, False")
        self.input("fail_eeprom", on)
        self.eeprom_fails = on

    def forget(self) -> None:
        """What power-off takes away."""
        self.memory = bytearray()  # the program
        self.speeds = {"start_stop": 0, "top_speed": 0, "ramp": 0}
        self.entering = False  # programming mode
        self.overflow = False  # E5 is to be reported
        self.failed = False  # E6 is to be reported (option early_y)
        self.writing = False  # the EEPROM is being written
        self.saving = None
        self.ending = False  # Z: the program ends when the motion has come to rest
        self.address = 0
        self.running = False
        self.heading = 0  # the direction of an endless motion
        self.homing = False  # a homing runs: its steps are not counted
        self.pc = 0  # location of the next instruction
        self.at: int | None = None  # of the one in work; None: no program runs
        self.other_work = ""  # a homing, a write, an instruction without a program

    @property
    def program(self) -> bytes:
        """The program memory in use; the codes are the model's own, since the sheet gives none."""
        return bytes(self.memory)

    @property
    def program_counter(self) -> int | None:
        """The location at which the instruction in work begins."""
        return self.at

    def program_rows(self) -> list[ProgramRow]:
        """Return the program memory, an instruction a row: location, bytes (codes of the model) and text."""
        from ...language.disassemble import program_rows

        return program_rows(bytes(self.memory), self.sheet)

    def listing(self) -> str:
        """The stored program as text, with addresses."""
        return "\n".join(f"{row.address:3}  {row.text}" for row in self.program_rows())

    @property
    def under_way(self) -> str:
        from ...language.disassemble import text_at

        return self.other_work if self.at is None else text_at(bytes(self.memory), self.at, self.sheet)

    def works_on(self, text: str) -> None:
        """Something has begun that is no instruction of the program; or, empty, is over."""
        self.other_work = text
        self.on_command(text)

    @property
    def registers(self) -> dict[str, int]:
        """start_stop, top_speed (units of 10 steps/s), ramp (steps): 0 where never set; position; user_inputs and
        user_outputs as V2 reads them."""
        return {
            **self.speeds,
            "position": self.position,
            "user_inputs": self.read_inputs(),
            "user_outputs": self.read_outputs(),
        }

    def speeds_in_force(self) -> tuple[int, int, int]:
        """S, T and R."""
        return self.speeds["start_stop"], self.speeds["top_speed"], self.speeds["ramp"]

    def begins(self, text: str, direction: int, *, homing: int = 0, endless: bool = False) -> None:
        """A motion begins in a direction; with a speed, a homing."""
        self.heading = direction if endless else 0
        self.made = Made(homing, 0, 0, self.law) if homing else Made(*self.speeds_in_force(), self.law)
        self.axis1.log.begin(text, self.made.homing if homing else self.made.parameters, direction)

    def first_step(self, sign: int, number: int | None, limit: int = OPEN) -> None:
        """The first step of a motion begins."""
        if not self.homing:
            ideal = partial(self.made.ideal, self.kernel.now, self.position, sign, number, limit)
            self.axis1.log.expect(ideal)

    def room(self, steps: int) -> int:
        """Steps to the end of the counter in a direction; without end where it wraps."""
        if self.wraps:
            return OPEN
        return self.axis1.positions[-1] - self.position if steps > 0 else self.position

    def full(self, direction: int, stopped: bool) -> bool:
        """Has an endless motion come to the end of the counter, and not been stopped there?"""
        return self.room(direction) == 0 and not stopped

    def motion_over(self, stopped: bool) -> None:
        """The last pulse of a motion is over; `stopped`: it has come to rest as it was told to."""
        self.axis1.log.end("limit" if self.heading and self.full(self.heading, stopped) else None)

    def departs(self, kind: str = "", text: str = "") -> None:
        """The motion becomes another one than it was to be."""
        self.axis1.log.depart()
        if kind:
            self.axis1.log.mark(kind, text)

    def read_inputs(self) -> int:
        """UI1 + 2 UI2 + 4 UI3; an open input reads 1."""
        return sum((net.level != 0) << n for n, net in enumerate(self.inputs))

    def read_outputs(self) -> int:
        """UO1 + 2 UO2 + 4 UO3."""
        return sum((driver.net.level == 1) << n for n, driver in enumerate(self.outputs))
