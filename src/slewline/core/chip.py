"""The base of every chip: a sheet, nets on its pins, a crystal, registers, findings, and one firmware task.

Reset acts through a net: when the level of this net changes, the firmware is killed after all timed work
of that instant; later it starts again, from the beginning of `run()`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from types import SimpleNamespace
from typing import Any, ClassVar

from ..errors import UnknownName, UsageError
from .component import Component
from .datasheet.option import checked
from .datasheet.packages import SIGNALS
from .datasheet.table import Sheet
from .messages.instead import OF_CHIPS, OURS, face, missing
from .messages.known import Known, NameHelp
from .messages.whole import whole
from .motion.axis import Axis
from .motion.one_axis import OneAxis
from .program import InstructionCondition, ProgramRow
from .time.hook import CommandHook, Hook
from .time.inputs import from_outside
from .time.kernel import Kernel, Task
from .time.timebase import Clock, readable
from .wires.net import Bus, Driver, Net
from .wires.pin import Condition, Terminal
from .wires.waits import first_of, until

RETURN = "carriage return"
TO_DRIVE = 'it is a pin: {it}.pin("PIN").drive(0), or drive(1)'
TO_LOAD = "it is a register; a host sends the command that loads it: bench.host({it}).send(...)"
CONFLICT_HOLDOFF_PS = 10**9  # without a conflict: the next one on that wire is reported again


@face
class AxisOfChip(OneAxis):
    """An axis of a chip with several axes."""

    def __init__(self, chip: Chip, number: int) -> None:
        self.chip, self.number, self.kernel = chip, number, chip.kernel
        self.name = f"{chip.name} axis {number}"

    @property
    def motor(self) -> Axis:
        """The `Axis` with the position of this axis's motor, now and in the past."""
        return self.chip.axes[self.number - 1]

    @property
    def registers(self) -> dict[str, int]:
        """The registers that the manual defines for this axis, by name in lower case."""
        return self.chip.registers_of(self.number)

    def __repr__(self) -> str:
        return f"<{self.name}: {repr(self.motor)[len('<Axis: ') : -1]}>"


class Chip(Component, OneAxis):
    """A chip on a bench, as `Bench.add` returns it.  Subclasses provide a sheet and `run()`, the firmware.

    Attributes:
        name: its name on the bench, such as "x".
        sheet: its data sheet.
        options: the checked values of all options in the sheet, as attributes.
        crystal_hz: the frequency of its crystal, Hz.
        pins: the pins, keyed by the manual's names in lower case.
        axes: an `Axis` for each motor: its position, now and in the past; axis 1 comes first.
        idle: True while the chip waits for a command and has nothing left to do.
        on_finding: hook, called with each `Finding` of this chip.
        on_power: hook, called with the chip and True or False when its supply is switched on or off.
        on_instruction: hook, called with the address of each program instruction when it begins, before it takes
            effect.
        on_command: hook, called with the text of the command or program instruction that the chip begins to execute,
            and with "" when it has finished.
    """

    _for_users: ClassVar[tuple[str, ...]] = (
        *(
            "pin",
            "pins",
            "axis",
            "axes",
            "sheet",
            "options",
            "crystal_hz",
            "idle",
            "moving",
            "waiting",
            "power",
            "reset",
        ),
        *("findings", "program", "listing", "program_rows", "program_counter", "at_instruction"),
        *("on_instruction", "on_command", "on_finding", "on_power"),
    )
    _to_set: ClassVar[Mapping[str, str]] = {
        **OneAxis._to_set,
        "program": "a host sends it, instruction after instruction: bench.host({it}).send(...)",
        "program_counter": "a host starts the program: bench.host({it}).send(...)",
    }
    sheet: Sheet
    axes: tuple[Axis, ...]
    clock: Clock

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        if isinstance(sheet := vars(cls).get("sheet"), Sheet):
            # built-in chips have no attribute with such a name; a custom chip may
            to_drive, to_load, same = (TO_DRIVE, TO_LOAD, "") if cls.__module__.startswith(OURS) else (None,) * 3
            missing(cls, same, **OF_CHIPS)
            for row in sheet.pins:
                if row.in_out not in ("power", "none"):
                    drive = to_drive and to_drive.replace("PIN", row.name)
                    missing(cls, drive, **{row.name: f'it is a pin: {{it}}.pin("{row.name}")'})
            missing(
                cls,
                to_load,
                **{row.name: f'it is a register: {{it}}.registers["{row.name}"]' for row in sheet.registers},
            )

    def __init__(
        self,
        kernel: Kernel,
        name: str,
        /,
        crystal_hz: int | None = None,
        *,
        bare: bool = False,
        straps: Mapping[str, int] | None = None,
        **options: Any,
    ) -> None:
        super().__init__(kernel, name)
        self.bare = bare
        self.options = SimpleNamespace(
            **checked(name, self.sheet.options, options, self._beside(), self.sheet.elsewhere)
        )
        self.crystal_hz = crystal_hz or self.sheet.crystal_hz
        self.clock = Clock(self.crystal_hz)
        self.tick = 0  # the chip's own count; every sleep adds to it, so it does not drift
        self.on_power: Hook[[Chip, bool]] = Hook()  # the supply is being switched
        self.on_instruction: Hook[[int]] = Hook()  # an instruction of the program begins: its address
        self.on_command: Hook[[str]] = CommandHook()  # another command or instruction begins; "" if none is in progress
        self.task: Task | None = None
        self.idle = False
        self._waiting: tuple[str, int] = ("nothing yet", 0)
        self._left: list[tuple[str, str]] = []  # the result of the last `conclude`
        self._unended = ""  # the unfinished line that has been reported
        self._build_pins(straps or {})

    @property
    def _strap(self) -> str:
        """The name of an input, used in messages as an example of a strap."""
        inputs = (row.name for row in self.sheet.pins if row.in_out == "in")
        return next(iter([*self.sheet.plain, *self.sheet.fastest]), next(inputs, "pin"))

    @classmethod
    def _beside(cls) -> str:
        """Return text that lists the arguments that a chip takes besides its options."""
        crystal = "crystal, " if cls.sheet.crystal_high_hz else ""
        return f"; also {crystal}straps, bare and name"

    def __repr__(self) -> str:
        state = "in motion" if self.moving else "idle" if self.idle else self._does()[0]
        where = ", ".join(str(axis.position) for axis in self.axes)
        what = f"position{'s' * (len(self.axes) > 1)} {where}, {state}, {readable(self.kernel.now)}"
        return f"<{self.sheet.part.upper()} {self.name}: {what}>"

    def _repr_html_(self) -> str:
        """Return the notebook view of the chip: package with pin levels, registers, program, and latest findings."""
        from .notebook.chip_card import ChipCard

        several = len(self.axes) > 1
        return ChipCard(
            repr(self)[1:-1],
            self.sheet,
            {name: pin.level for name, pin in self.pins.items() if pin.row.in_out in SIGNALS},
            [self.registers_of(n) for n in range(1, len(self.axes) + 1)] if several else [self.registers],
            self.program_rows(),
            self.program_counter,
            [str(finding) for finding in self.findings],
        ).markup()

    @property
    def _of_part(self) -> str:
        """The name of the chip, followed by its part number in brackets."""
        return f"{self.name} ({self.sheet.part})"

    def _pin_help(self, _pins: object) -> NameHelp:
        names = [row.name for row in self.sheet.pins if row.in_out not in ("power", "none")]
        to_drive = f'a pin is driven: {self.name}.pin("{self._strap}").drive(0)'
        roles = {row.role: row.name for row in reversed(self.sheet.pins) if row.role and row.role not in self.pins}
        return NameHelp(self._of_part, "pin", to_drive, names, roles)

    def _known(self, registers: Mapping[str, int], axis: int = 0) -> Known[int]:
        """Return a read-only view, for users, of `registers`: those of an axis, or of the chip if `axis` is 0."""
        found = Known(registers)
        found.name_help = partial(self._register_help, axis=axis) if axis else self._register_help
        return found

    def _register_help(self, registers: Mapping[str, int], axis: int = 0) -> NameHelp:
        to_load = f"a host sends the command that loads one: bench.host({self.name}).send(...)"
        return NameHelp(self._of_part + (f" axis {axis}" if axis else ""), "register", to_load, list(registers))

    def _build_pins(self, straps: Mapping[str, int]) -> None:
        pins: dict[str, Terminal] = {}
        prefix, report = self.sheet.bus, self._conflict
        self.bus = Bus(self.kernel, f"{self.name}.{prefix}")
        self.bus.report_conflict = report
        self.bus_driver = Driver(self.bus, self.name)
        for row in self.sheet.pins:
            line = row.name.removeprefix(prefix)
            if line != row.name and line.isdigit():
                terminal = Terminal(self.name, row, self.bus)
                terminal.bit = int(line)
            else:
                open_input = (
                    row.in_out == "in" and row.pull is None
                )  # an input without pull-up reads low when left open
                pull, tie = 0 if open_input else row.pull, None if self.bare else row.tie
                net = Net(self.kernel, f"{self.name}.{row.name}", pull, tie, row.active)
                net.report_conflict = report
                terminal = Terminal(self.name, row, net)
                if row.in_out in ("out", "both"):
                    self.drivers[row.name] = Driver(net, self.name)
            pins[row.name] = terminal
        self.pins = Known(pins)
        self.pins.name_help = self._pin_help
        if not isinstance(straps, Mapping):
            like = f'{{"{self._strap}": 0}}'
            raise UsageError(f"{self.name}: straps {straps!r}; expected pins with levels, such as {like}")
        for strap, strap_level in straps.items():
            terminal = self.pin(strap)
            if strap_level not in (0, 1) or terminal.row.in_out not in ("in", "both"):
                raise UsageError(f"{self.name}: strap {strap}={strap_level!r}; a strap sets an input to 0 or 1")
            terminal.net.tie = strap_level
            terminal.net.rest()

    # ------------------------------------------------------------------------------------------------- public face
    def pin(self, name: str) -> Terminal:
        """Return a pin by its name in the manual, in lower case.

        Raises:
            UnknownName: the chip has no such pin; the message lists its pins.
        """
        try:
            return self.pins[name]
        except TypeError:  # a list, for example
            return self.pins.__missing__(name)

    @property
    def moving(self) -> bool:
        """True while any of its motors is moving."""
        return any(axis.moving for axis in self.axes)

    @property
    def answering(self) -> bool:
        """True while a command from a host, or the answer to one, is being transferred."""
        return False

    @property
    def awaits_host(self) -> bool:
        """True while the chip, in the middle of a transfer, waits for one of its hosts; the other hosts must wait."""
        return False

    @property
    def armed(self) -> bool:
        """True while the chip is at rest, but an input may make it continue."""
        return False

    @property
    def motor(self) -> Axis:
        """The `Axis` with the position of motor 1, now and in the past."""
        return self.axes[0]

    def axis(self, number: int) -> OneAxis:
        """Return an axis by its number, counted from 1; a chip with one motor is its own axis 1.

        Raises:
            UnknownName: the chip has no such axis; the message lists its axes.
        """
        axis = whole(number)
        if axis is None or not 1 <= axis <= len(self.axes):
            has = "its only axis is 1" if len(self.axes) == 1 else f"its axes are 1 to {len(self.axes)}"
            raise UnknownName(f"{self._of_part} has no axis {number!r}; {has}")
        return self if len(self.axes) == 1 else AxisOfChip(self, axis)

    def registers_of(self, number: int) -> dict[str, int]:
        """Return the registers of one axis, counted from 1, on a chip with several axes."""
        raise NotImplementedError

    @property
    def program(self) -> bytes:
        """The bytes of the program memory that are in use."""
        return b""

    @property
    def program_counter(self) -> int | None:
        """The address of the instruction in progress, or of the next one; None while no program runs."""
        return None

    def at_instruction(self, address: int | None = None) -> Condition:
        """Return a condition that is met when the instruction at `address` (None: any instruction) next begins.

        Raises:
            UsageError: `address` is not a whole number, 0 or more, or is outside the program memory.
        """
        return InstructionCondition(self, address, self.sheet.buffer_bytes)

    def program_rows(self) -> list[ProgramRow]:
        """Return the stored program, one row for each instruction: address, bytes and text."""
        return []

    def listing(self) -> str:
        """Return the stored program as text with addresses, one instruction per line."""
        return ""

    def power(self, on: bool) -> None:
        """Switch the supply on (True) or off (False).

        Raises:
            UsageError: `on` is neither True nor False.
        """
        raise NotImplementedError

    def _check_switch(self, on: object) -> None:
        """Check that the argument of `power` is True or False.

        Raises:
            UsageError: any other value, such as "off", which would count as true.
        """
        if not isinstance(on, bool):
            raise UsageError(f"{self.name}: power({on!r}); allowed True, False")

    def reset(self) -> None:
        """Pulse the reset pin, starting now, for as long as the part needs; the call itself takes no virtual time."""
        raise NotImplementedError

    def check_wiring(self) -> None:
        """Report, as findings, undriven inputs that have no pull-up and so read low; called before time passes."""
        for row in self.sheet.pins:
            net = self.pins[row.name].net
            if row.in_out == "in" and row.pull is None and net.tie is None and not net.drivers:
                self.finding("open-pin", f"pin {row.number} ({row.name}) is open and has no pull-up: it reads low")

    @property
    def waiting(self) -> str:
        """Text about the current activity or wait of the chip, and when it began."""
        text, since = self._does()
        rest = f"; {self.unfinished!r} has arrived without its {self._lacking}" if self.unfinished else ""
        return f"{self.name}: {text} since {readable(since)}{rest}"

    def _does(self) -> tuple[str, int]:
        """Return the current activity or wait of the chip, and when it began (ps)."""
        return self._waiting

    @property
    def unfinished(self) -> str:
        """The incomplete line received so far, on parts whose lines end with a carriage return."""
        return ""

    @property
    def _lacking(self) -> str:
        """The name of the character that would end or continue the line received so far."""
        return RETURN

    @property
    def _how_to_end(self) -> str:
        """The remedy for a line that was received without its terminator."""
        if self._lacking != RETURN:
            return f"send the {self._lacking} that ends it"
        instead = ", not a line feed (\\n)" if "\n" in self.unfinished else ""
        return f"end each command with a carriage return (\\r, 0x0D){instead}"

    def left_over(self) -> list[tuple[str, str]]:
        """Return the commands and program entries left incomplete by a host, as codes and texts of findings.

        It is called when everything is at rest, or a run is over, and must not change the state of the chip.
        """
        text = self.unfinished
        if not text.strip("\n"):  # a line feed has its own finding
            self._unended = ""
            return []
        if not (self._unended and text.startswith(self._unended)):
            self._unended = text  # reported once, though it may grow
        ends = f"{self._unended!r} has arrived without its {self._lacking}, and the {self.sheet.part} is waiting for it"
        return [("unfinished", f"{ends}: {self._how_to_end}")]

    def _open_entry(self) -> tuple[str, str]:
        """Return the code and text of a finding: a host has begun program entry, but has not yet ended it."""
        enter = self.sheet.enter.form if self.sheet.enter is not None else ""
        text = f"program entry has been open since {enter}: commands are stored, not executed"
        return "unfinished", f"{text}; {' or '.join(row.form for row in self.sheet.leave)} ends it"

    def conclude(self) -> bool:
        """Report as findings the incomplete commands and program entries that the previous call did not report.

        Return whether the list of incomplete commands and program entries has changed since the previous call.
        """
        before, self._left = self._left, self.left_over()
        for code, text in self._left:
            if (code, text) not in before:
                self.finding(code, text)
        return self._left != before

    def phase_patterns(self) -> Sequence[Sequence[int]]:
        """Return rows of phase levels, phase 1 first, one row per step of the cycle; () for a part without phases."""
        return ()

    @from_outside
    def motor_report(self, code: str, text: str, axis: int = 1, position: int | None = None) -> None:
        """Report, as a finding, an event of a real motor that follows the steps of an axis.

        This is an external input: it is recorded in the journal, so that a replay reaches the same position as the
        motor.

        Args:
            code, text: the code and the text of the finding.
            axis: the number of the axis, counted from 1.
            position: the position of the motor, to be loaded into the position register; None leaves the register
                unchanged.
        """
        self.input("motor_report", code, text, axis, position)
        if position is not None:
            self.axis(axis).motor.load(position)
        self.finding(code, text)

    def switched(self, on: bool) -> None:
        """Record that the supply is switched on (True) or off (False), and call the hook `on_power`."""
        self.kernel.outside.record("power", chip=self.name, on=on)
        self.on_power(self, on)

    def _conflict(self, net: Net) -> None:
        """Report a conflict on a net, unless the net's previous conflict was less than CONFLICT_HOLDOFF_PS ago."""
        now, last = self.kernel.now, net.last_conflict_ps
        net.last_conflict_ps = now
        if last is not None and now - last < CONFLICT_HOLDOFF_PS:
            return
        if not self.findings or self.findings[-1].code != "conflict" or self.findings[-1].time_ps != now:
            self.finding("conflict", f"two outputs disagree on {net.name}; the low one wins")

    # ------------------------------------------------------------------------------------------- waits of a firmware
    def sync(self) -> None:
        """Set the tick count to the first clock tick at or after the present instant of the kernel."""
        self.tick = self.clock.ticks_from(self.kernel.now)

    def sync_forward(self) -> None:
        """Set the tick count as `sync` does, but leave it unchanged if it is already ahead of the present instant."""
        self.tick = max(self.tick, self.clock.ticks_from(self.kernel.now))

    async def ticks(self, number: int) -> None:
        """Wait for `number` crystal clocks."""
        self.tick += number
        await until(self.kernel, self.clock.ps(self.tick))

    async def at_tick(self, tick: int) -> None:
        """Wait until the tick count is `tick`; return immediately if the tick count is already that high."""
        if tick > self.tick:
            self.tick = tick
            await until(self.kernel, self.clock.ps(tick))

    async def polled(self, net: Net, wanted: int, every: int, *others: tuple[Net, int]) -> Net:
        """Sample a net periodically, starting now, until its level is `wanted`; return the net.

        The period is `every` clocks.  `others` are further nets, each with a level that also ends the wait; the
        net that ends it is returned.  The sampling instants are computed, not stepped through; a level that does
        not last until the next instant is missed.
        """
        pairs = ((net, wanted), *others)
        origin = self.tick
        while True:
            for candidate, value in pairs:
                if candidate.level == value:
                    return candidate
            await first_of(self.kernel, None, *pairs)
            passed = self.clock.ticks_until(self.kernel.now) - origin
            self.tick = origin + (passed // every + 1) * every
            await until(self.kernel, self.clock.ps(self.tick))

    def outputs_reset(self) -> None:
        """Drive every output to its level after reset, as given in the sheet."""
        for row in self.sheet.pins:
            if row.reset is not None and row.name in self.drivers:
                self.drivers[row.name].drive(row.reset)

    def waits(self, text: str, since: int | None = None) -> None:
        """Record, for `waiting`, a text about the firmware's activity, which began at `since` (ps; None: now)."""
        self._waiting = (text, self.kernel.now if since is None else since)

    # -------------------------------------------------------------------------------------------------- firmware task
    async def run(self) -> None:
        """Run the firmware, beginning at reset; each chip class has its own firmware."""
        raise NotImplementedError

    def start(self) -> None:
        """Start the firmware at this instant.

        Raises:
            UsageError: the firmware is running already, or the chip has none.
        """
        if type(self).run is Chip.run:
            raise UsageError(
                f"{self.name}: a {type(self).__name__} has no firmware to start; give the class a run() method"
            )
        if self.task is not None:
            raise UsageError(f"{self.name}: the firmware is running already; call stop() before start()")
        self.sync()
        self.task = self.kernel.spawn(self.run, name=self.name)

    def stop(self) -> None:
        """Kill the firmware."""
        if self.task is not None:
            self.task.kill()
            self.task = None
        self.idle = False


def step_nets(chip: Chip) -> list[Net]:
    """Return the nets of all pins of a chip with the role "step", each of which shows every step of a motor."""
    return [chip.pins[row.name].net for row in chip.sheet.pins if row.role == "step"]
