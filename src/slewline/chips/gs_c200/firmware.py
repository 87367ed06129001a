"""A GS-C module: it owns its parts, starts and ends their work, answers lines and has public properties.

A line is first checked here: it must be for this module, and received without faults (otherwise E1).
Then immediate_commands.py executes its command.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ...core.chip import Chip
from ...core.datasheet.channel import SerialLine
from ...core.datasheet.table import Sheet
from ...core.memory.store import Memory, Store
from ...core.motion.axis import Axis
from ...core.time.inputs import from_outside
from ...core.time.kernel import Kernel
from ...core.time.timebase import picoseconds
from ...core.wires.net import Driver
from ...core.wires.serial import Straps
from ...errors import UsageError
from ...language.dialect import spoken_as
from ...language.lines import KEPT, Lines, checksum
from ..line import InLines, Line, LineInterface, serial_line
from .activity import LINE, START, Activity
from .dialogue.immediate_commands import HostDialogue
from .dialogue.instructions import Instructions, Moves
from .dialogue.interpreter import Interpreter
from .dialogue.program_memory import Program
from .dialogue.reception import fault
from .eeprom import ProgramEeprom
from .profile import LAWS
from .registers import Registers
from .sheet import GS_C200, GS_C200S, LOADS_MA, POSITIONS, SUPPLY_VOLTS
from .stepping.driver_lines import StepLines, UserLines
from .stepping.motion import Motion
from .stepping.position_counter import PositionCounter
from .supply import Supplied, Supply

if TYPE_CHECKING:
    from ...core.program import ProgramRow

OR_SINCE = (2, 2)  # GS-C200 firmware that sets a bit of every checksum
PULL_DOWN = "txpd"  # the name of its driver on a line


class GsC(InLines, Chip):
    """A GS-C module on a bench."""

    _for_users = ("powered", "eeprom_fault", "fail_eeprom", "kill")
    straps: Straps
    _wraps: bool  # the position counter wraps at its ends; otherwise a motion beyond them is E5
    _homing_erases: bool  # a homing run commanded by the host erases the program

    def __init__(self, kernel: Kernel, name: str, /, crystal_hz: int | None = None, **given: Any) -> None:
        super().__init__(kernel, name, crystal_hz, **given)
        options, times_ps = self.options, self._times_ps()
        port = serial_line(self.sheet)
        self.straps = self._strapped(port)
        longest = spoken_as(self.sheet, Lines).longest
        self.line = LineInterface(
            self, port, self.straps, longest=longest, turnround_ps=times_ps["turnround"], lenient=options.lenient
        )
        self.up_ps = 0  # when the supply was switched on
        self._address = 0  # the straps at the start
        self._late_checked = False  # the late answer carries a checksum
        self.store: Store = options.store if options.store is not None else Memory()
        self.axes = (Axis(kernel, POSITIONS[self.sheet.part], 0),)
        self.state = Registers()
        self._activity = Activity(self)
        self._user, self._step_lines = UserLines(self), StepLines(self, times_ps)
        law = options.law if callable(options.law) else LAWS[options.law]
        self._counter = PositionCounter(self.axes[0], self.state, law, self._wraps)
        motion = self._moves(times_ps)
        self._stored = Program(self.sheet, self.state)
        instructions = Instructions(
            self, times_ps, self.state, self._step_lines, self._user, self._counter, self._stored, motion
        )
        self._interpreter = Interpreter(
            self, self.refresh_idle, times_ps, self._activity, self._counter, self._stored, motion, instructions
        )
        self._eeprom = ProgramEeprom(
            self, self.refresh_idle, self._activity, self._stored, self.store, times_ps["eeprom"], options.eeprom_fault
        )
        self._commands = HostDialogue(
            self, self.state, self._user, self._interpreter, self._eeprom, self._answer_later, self._homing_erases
        )
        self._supply = Supply(self, Supplied(self._powered_up, self._powered_off), SUPPLY_VOLTS, LOADS_MA)
        self._pull_down = Driver(
            self.pins["txpd"].net, PULL_DOWN
        )  # drives no level, but shows the place of the pull-down
        if not self.bare and self.strapped_address() == 0:
            self.pins["txd"].net.join(self.pins["txpd"].net)  # the standard wiring of a single module on a line
        if options.cold:
            self.idle = True
        else:
            self.power(True)

    def _moves(self, times_ps: Mapping[str, int]) -> Moves:
        """Create the object that moves the motor: the fast one, or its slow twin."""
        if self.options.stepwise:
            from .twin import Stepwise

            return Stepwise(self, times_ps, self._step_lines, self._counter)
        return Motion(self, times_ps, self._step_lines, self._counter)

    def _times_ps(self) -> dict[str, int]:
        """Return the sheet's times by name, in picoseconds; options may replace some of them."""
        options = self.options
        given = {
            "turnround": options.turnround,
            "instruction": options.instruction_time,
            "dir_setup": options.dir_setup,
            "eeprom": options.eeprom_time,
        }
        times = {name: time.ticks for name, time in self.sheet.times.items()}
        return times | {name: picoseconds(time) for name, time in given.items()}

    def _strapped(self, port: SerialLine) -> Straps:
        """Return the reader of the straps; raise UsageError if a GS-C200S is given an early firmware version."""
        options = self.options
        early = tuple(map(int, options.firmware.split("."))) < OR_SINCE
        if early and self.sheet is not GS_C200:
            raise UsageError(
                f"{self.name}: firmware {options.firmware!r}; every {self.sheet.part.upper()} sets bit 0x10 of its "
                "checksums, as a GS-C200 does from version 2.2 on: leave the option out"
            )
        kept = 0 if early else KEPT
        return Straps(port, self.pins, kept=kept, address=options.address, backwards=options.pin_order)

    def check_wiring(self) -> None:
        """Report wiring that violates the sheet, as findings.  This is called at the start, before time passes."""
        super().check_wiring()
        if self.pins["test"].level != 0:
            self.finding("test-pin", "pin 10 (test) is not low; wire it to pin 8")
        pull_downs = [driver for driver in self.pins["txd"].net.drivers if driver.name == PULL_DOWN]
        if not pull_downs:
            self.finding("no-pull-down", "no txpd is connected to this txd: the idle line floats; connect one txpd")
        elif len(pull_downs) > 1:
            self.finding("pull-downs", f"{len(pull_downs)} txpd pins are connected to this txd; connect only one")
        self._supply.check()

    # --------------------------------------------------------------------------------------------- power and the start
    def power(self, on: bool) -> None:
        """Switch the supply; without it, program memory, speeds, counter and outputs are lost; the EEPROM is kept.

        Raises:
            UsageError: `on` is neither True nor False.
        """
        self._check_switch(on)
        self._supply.switch(on)

    def reset(self) -> None:
        """Raise an error, because the module has no reset input.

        Raises:
            UsageError: always; `power` switches the supply.
        """
        raise UsageError(f"{self.name}: RESET of the {self.sheet.part} is an output; use power(False) and power(True)")

    def _powered_up(self) -> None:
        """Start the module, with the program memory, registers and counter cleared."""
        self.up_ps, self.idle = self.kernel.now, False
        self._counter.clear()
        self.start()

    def _powered_off(self) -> None:
        """End all work, and release every output."""
        self.line.hang_up()
        self._interpreter.cut()
        self._eeprom.cut()
        self.stop()
        self.on_command("")
        for driver in self.drivers.values():
            driver.drive(None)
        self._stored.clear()
        self.state.clear()
        self._activity.clear()
        self._address = 0
        self.idle = True
        self.waits("waiting for its supply")

    async def run(self) -> None:
        """Run the firmware from power-up: the RESET pulse, the straps, then stand-alone operation if REC is low."""
        self.waits("waiting for the end of the RESET pulse")
        self.outputs_reset()
        self._activity.begin(START)
        await self._step_lines.pulse_reset()
        self._address = self.strapped_address()
        self._activity.end(START)
        self.line.listen()
        self.waits("waiting for a command")
        if self.pins["rec"].net.is_active:
            self._recall_and_run()

    def _recall_and_run(self) -> None:
        """Start stand-alone operation: load the program, home at its start-stop speed, and run it."""
        program = self._stored
        failed = self._eeprom.recall()
        if failed:
            self.finding("E6", failed)
        if failed or not program.memory:
            return
        missing = program.unset_before_motion()
        if program.memory[0] != ord("S") or missing:
            self.finding(
                "no-autorun", f"the recalled program is not run, because it lacks {missing or 'S at its start'}"
            )
            return
        direction = -1 if self.pins["rxd"].level == 1 else 1

        async def home_and_run() -> None:
            await self._interpreter.home(direction, program.homing_speed)
            await self._interpreter.execute()

        self._interpreter.run(home_and_run)

    # ----------------------------------------------------------------------------------------------------------- lines
    def busy(self, on: bool) -> None:
        """Begin (True) or end (False) the work on a line; RDY is low during this work."""
        if on:
            self._activity.begin(LINE)
        else:
            self._activity.end(LINE)

    @property
    def answering(self) -> bool:
        """True while a line is in progress, its answer is being sent, or an EEPROM write delays the answer to M."""
        return self.line.answering or (self._eeprom.writing and not self.options.early_y)

    def refresh_idle(self) -> None:
        """Record whether the module is idle."""
        self.idle = not (self.answering or self._activity.kinds)

    async def obey(self, line: Line) -> Sequence[bytes]:
        """Check that a line was received without faults, and execute it; return the answers in the form to send."""
        body = self.meant(line)
        if body is None:
            return ()
        command = line.text[bool(self._address) :].decode("latin-1")
        if wrong := fault(line, command, self.sheet, self.straps, self.line.longest):
            return self._framed(self._commands.mistake("E1", f"{line.text!r}: {wrong}"), line.checked)
        answer = await self._commands.answer(body.decode("ascii"))
        if not answer:
            self._late_checked = line.checked
        return self._framed(answer, line.checked)

    def meant(self, line: Line) -> bytes | None:
        """Return the command in a line, without address and checksum; None if there is none for this module."""
        text = line.text
        if not text:
            return None
        if self._address and (line.first_faulty or text[:1] != b"%d" % self._address or len(text) == 1):
            return None
        return text[bool(self._address) : len(text) - line.checked]

    def _framed(self, answer: str, checked: bool) -> list[bytes]:
        """Return the lines of an answer as bytes to send, with checksums if `checked`; no lines for an empty text."""
        lines = answer.encode("ascii").split(b"\r")
        return [line + bytes([checksum(line, self.straps.kept)]) if checked else line for line in lines if line]

    def _answer_later(self, answer: str) -> None:
        """Send an answer that an EEPROM write has delayed."""
        self.line.take(self._framed(answer, self._late_checked)[0])

    # ------------------------------------------------------------------------------------------------ public properties
    @property
    def powered(self) -> bool:
        """True while the supply is on."""
        return self._supply.powered

    @property
    def _running(self) -> bool:
        """True while a program, a homing run or an instruction outside a program is in progress."""
        return self._interpreter.running

    @property
    def _entering(self) -> bool:
        """True while the module accepts program instructions."""
        return self._stored.entering

    def left_over(self) -> list[tuple[str, str]]:
        """Return the host's unfinished input (code, text): a line, and a program that was neither ended nor saved."""
        found = super().left_over()
        if self._entering and not self._stored.kept:
            code, text = self._open_entry()
            found.append((code, f"{text}, and E runs the program"))
        return found

    @property
    def under_way(self) -> str:
        """Work in progress other than a line from the host, as text; "" for none."""
        return self._interpreter.under_way

    @property
    def eeprom_fault(self) -> bool:
        """True while programming the EEPROM fails, as set by an option, by `fail_eeprom` or by a test."""
        return self._eeprom.fails

    @eeprom_fault.setter
    def eeprom_fault(self, on: bool) -> None:
        self.fail_eeprom(on)

    @from_outside
    def fail_eeprom(self, on: bool = True) -> None:
        """Set whether programming the EEPROM fails, with the answer E6 (True), or succeeds (False).

        This is an external input, which a journal records.

        Raises:
            UsageError: `on` is neither True nor False.
        """
        if not isinstance(on, bool):
            raise UsageError(f"{self.name}: eeprom_fault {on!r}; allowed True, False")
        self.input("fail_eeprom", on)
        self._eeprom.fails = on

    @from_outside
    def kill(self) -> None:
        """End the program and the motion immediately, like command K, but with no line from a host and no answer.

        This is an external input, which a journal records.  The registers and the program are kept.
        """
        self.input("kill")
        if self._interpreter.running:
            self.kernel.spawn(self._interpreter.kill, "K", name=f"{self.name} is killed")

    @property
    def program(self) -> bytes:
        """The program memory in use; the codes are the model's own, because the sheet states none."""
        return bytes(self._stored.memory)

    @property
    def program_counter(self) -> int | None:
        """The location of the instruction in progress; None while no program runs."""
        return self._stored.at

    def program_rows(self) -> list[ProgramRow]:
        """Return the program memory, one instruction per row: location, bytes (in the model's codes) and text."""
        return self._stored.rows()

    def listing(self) -> str:
        """Return the stored program as text, with locations."""
        return "\n".join(f"{row.address:3}  {row.text}" for row in self.program_rows())

    @property
    def registers(self) -> dict[str, int]:
        """The registers by name.

        start_stop, top_speed (units of 10 steps/s), ramp (steps): 0 if never set; position; user_inputs and
        user_outputs as V2 reads them.
        """
        state = self.state
        return self._known(
            {
                "start_stop": state.start_stop,
                "top_speed": state.top_speed,
                "ramp": state.ramp,
                "position": self.position,
                "user_inputs": self._user.read_inputs(),
                "user_outputs": self._user.read_outputs(),
            }
        )


class GsC200(GsC):
    """A GS-C200: its counter ranges from 0 to 9999999, and overflows (E5)."""

    sheet: Sheet = GS_C200
    _wraps, _homing_erases = False, True


class GsC200S(GsC):
    """A GS-C200S: it has jump instructions, and a signed counter that wraps and can be preset."""

    sheet: Sheet = GS_C200S
    _wraps, _homing_erases = True, False
