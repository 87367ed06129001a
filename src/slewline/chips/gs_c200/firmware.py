"""A GS-C module: it owns the objects, starts and ends what runs, takes and answers lines, and is what a user sees.

A line is first looked at here: how was it received (E1), is it for this module?  What it says
is for immediate_commands.py.
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
    _wraps: bool  # past its ends the position counter wraps; else a motion that would leave it is E5
    _homing_erases: bool  # a homing sent by the host erases the program

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
        self._address = 0  # as the straps were when it started
        self._late_checked = False  # the answer that comes later carries a checksum
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
        self._pull_down = Driver(self.pins["txpd"].net, PULL_DOWN)  # drives nothing, but shows where the pull-down is
        if not self.bare and self.strapped_address() == 0:
            self.pins["txd"].net.join(self.pins["txpd"].net)  # the standard wiring of a module on a line of its own
        if options.cold:
            self.idle = True
        else:
            self.power(True)

    def _moves(self, times_ps: Mapping[str, int]) -> Moves:
        """Make what moves the motor: the fast way, or its slow twin."""
        if self.options.stepwise:
            from .twin import Stepwise

            return Stepwise(self, times_ps, self._step_lines, self._counter)
        return Motion(self, times_ps, self._step_lines, self._counter)

    def _times_ps(self) -> dict[str, int]:
        """Return the times of the sheet by name, those among them that are options as they were given; picoseconds."""
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
        """Return what reads the straps; a GS-C200S has no old firmware (UsageError)."""
        options = self.options
        early = tuple(map(int, options.firmware.split("."))) < OR_SINCE
        if early and self.sheet is not GS_C200:
            raise UsageError(
                f"{self.name}: firmware {options.firmware!r}; every {self.sheet.part.upper()} sets bit 0x10 of its "
                "checksums, as a GS-C200 does from 2.2 on: leave the option out"
            )
        kept = 0 if early else KEPT
        return Straps(port, self.pins, kept=kept, address=options.address, backwards=options.pin_order)

    def check_wiring(self) -> None:
        """Report as findings what is not wired as the sheet wants it.  Called before time passes."""
        super().check_wiring()
        if self.pins["test"].level != 0:
            self.finding("test-pin", "pin 10 (test) is not low; wire it to pin 8")
        pull_downs = [driver for driver in self.pins["txd"].net.drivers if driver.name == PULL_DOWN]
        if not pull_downs:
            self.finding("no-pull-down", "no module has its txpd on this txd: the idle line floats; connect one")
        elif len(pull_downs) > 1:
            self.finding("pull-downs", f"{len(pull_downs)} modules have their txpd on this txd; connect one only")
        self._supply.check()

    # --------------------------------------------------------------------------------------------- power and the start
    def power(self, on: bool) -> None:
        """Switch the supply: program memory, speeds, counter and outputs are lost without it; the EEPROM stays.

        Raises:
            UsageError: `on` is neither True nor False.
        """
        self._check_switch(on)
        self._supply.switch(on)

    def reset(self) -> None:
        """The module has no reset input.

        Raises:
            UsageError: always; `power` switches the supply.
        """
        raise UsageError(f"{self.name}: RESET of the {self.sheet.part} is an output; use power(False) and power(True)")

    def _powered_up(self) -> None:
        """Start again, with nothing in program memory, registers and counter."""
        self.up_ps, self.idle = self.kernel.now, False
        self._counter.clear()
        self.start()

    def _powered_off(self) -> None:
        """End everything, and let go of every output."""
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
        """Run the firmware from power-up on: RESET pulse, straps, and what is to be done without a host."""
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
        """The stand-alone start: recall the program, home at its start-stop speed, run it."""
        program = self._stored
        failed = self._eeprom.recall()
        if failed:
            self.finding("E6", failed)
        if failed or not program.memory:
            return
        missing = program.unset_before_motion()
        if program.memory[0] != ord("S") or missing:
            self.finding(
                "no-autorun", f"the recalled program is not run, because it lacks {missing or 'S at its head'}"
            )
            return
        direction = -1 if self.pins["rxd"].level == 1 else 1

        async def home_and_run() -> None:
            await self._interpreter.home(direction, program.homing_speed)
            await self._interpreter.execute()

        self._interpreter.run(home_and_run)

    # ----------------------------------------------------------------------------------------------------------- lines
    def busy(self, on: bool) -> None:
        """Begin or end the work on a line: RDY is low meanwhile."""
        if on:
            self._activity.begin(LINE)
        else:
            self._activity.end(LINE)

    @property
    def answering(self) -> bool:
        """Is a line in progress, or its answer on its way?  That to M comes when the EEPROM is written."""
        return self.line.answering or (self._eeprom.writing and not self.options.early_y)

    def refresh_idle(self) -> None:
        """Note whether the module has nothing to do."""
        self.idle = not (self.answering or self._activity.kinds)

    async def obey(self, line: Line) -> Sequence[bytes]:
        """Check how a line was received, and do what it says; return the answers as they go over the line."""
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
        """Return what a line says to this module, without address and checksum; None: nothing, or it is for another."""
        text = line.text
        if not text:
            return None
        if self._address and (line.first_faulty or text[:1] != b"%d" % self._address or len(text) == 1):
            return None
        return text[bool(self._address) : len(text) - line.checked]

    def _framed(self, answer: str, checked: bool) -> list[bytes]:
        """Answers as they go over the line, each with its checksum if there is one; none for an empty text."""
        lines = [line.encode("ascii") for line in answer.split("\r") if line]
        return [line + bytes([checksum(line, self.straps.kept)]) if checked else line for line in lines]

    def _answer_later(self, answer: str) -> None:
        """Send the answer to a line that has got none so far."""
        self.line.take(self._framed(answer, self._late_checked)[0])

    # ------------------------------------------------------------------------------------------------ public properties
    @property
    def powered(self) -> bool:
        """Is the supply on?"""
        return self._supply.powered

    @property
    def _running(self) -> bool:
        """Does a program run, or a homing?"""
        return self._interpreter.running

    @property
    def _entering(self) -> bool:
        """Does the module take instructions of a program?"""
        return self._stored.entering

    def left_over(self) -> list[tuple[str, str]]:
        """Return what a host has begun: a line, and a program that it has neither ended nor kept."""
        found = super().left_over()
        if self._entering and not self._stored.kept:
            code, text = self._open_entry()
            found.append((code, f"{text}, and E runs the program"))
        return found

    @property
    def under_way(self) -> str:
        """What the module works on besides a line of the host."""
        return self._interpreter.under_way

    @property
    def eeprom_fault(self) -> bool:
        """True while programming the EEPROM fails; it can be set, for tests: as `fail_eeprom`."""
        return self._eeprom.fails

    @eeprom_fault.setter
    def eeprom_fault(self, on: bool) -> None:
        self.fail_eeprom(on)

    @from_outside
    def fail_eeprom(self, on: bool = True) -> None:
        """Make programming the EEPROM fail with the answer E6 (True), or succeed again (False).

        It is an input from outside, which a journal keeps.

        Raises:
            UsageError: `on` is neither True nor False.
        """
        if not isinstance(on, bool):
            raise UsageError(f"{self.name}: eeprom_fault {on!r}; allowed True, False")
        self.input("fail_eeprom", on)
        self._eeprom.fails = on

    @from_outside
    def kill(self) -> None:
        """End program and motion immediately, as command K does, without a line of a host and without an answer.

        It is an input from outside, which a journal keeps.  Registers and program remain.
        """
        self.input("kill")
        if self._interpreter.running:
            self.kernel.spawn(self._interpreter.kill, "K", name=f"{self.name} is killed")

    @property
    def program(self) -> bytes:
        """The program memory in use; the codes are the model's own, since the sheet gives none."""
        return bytes(self._stored.memory)

    @property
    def program_counter(self) -> int | None:
        """The location at which the instruction in progress begins."""
        return self._stored.at

    def program_rows(self) -> list[ProgramRow]:
        """Return the program memory, an instruction a row: location, bytes (codes of the model) and text."""
        return self._stored.rows()

    def listing(self) -> str:
        """Return the stored program as text, with addresses."""
        return "\n".join(f"{row.address:3}  {row.text}" for row in self.program_rows())

    @property
    def registers(self) -> dict[str, int]:
        """The registers by their names.

        start_stop, top_speed (units of 10 steps/s), ramp (steps): 0 where never set; position; user_inputs and
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
    """A GS-C200: counter from 0 to 9999999, which overflows (E5)."""

    sheet: Sheet = GS_C200
    _wraps, _homing_erases = False, True


class GsC200S(GsC):
    """A GS-C200S: signed counter that wraps, jumps, preset of the counter."""

    sheet: Sheet = GS_C200S
    _wraps, _homing_erases = True, False
