"""What the GS-C modules do: power-up, lines of a host, programming, immediate commands.

Checks of a line, in this order: how it was received (E1), is it a command (E4), its argument (E2), does a program run
(B), may it come now (E4), does it fit into the memory (E3).  Where the sheet is silent see quirks.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...core.kernel import Kernel
from ...core.table import Sheet
from ...core.waits import until
from ...errors import UsageError
from ...language.dialect import Command
from ...language.lines import checksum, parse
from ..line import Line
from . import sheet
from .instructions import Instructions
from .motion import Motion

INVALID = b"\xff"  # no opcode; the first byte that a failed write leaves


class GsC(Instructions):
    """A GS-C module on a bench."""

    homing_erases: bool  # a homing sent by the host erases the program
    answer_checked = False  # the answer to the line in work carries a checksum

    def __init__(self, kernel: Kernel, name: str, /, crystal_hz: int | None = None, **given: Any) -> None:
        super().__init__(kernel, name, crystal_hz, **given)
        if self.options.stepwise:
            from .twin import Stepwise

            self.motion = Stepwise(self, self.times_ps, self.lines, self.counter)
        else:
            self.motion = Motion(self, self.times_ps, self.lines, self.counter)
        self.handlers = {row.form: getattr(self, row.handler) for row in self.sheet.commands}
        if self.options.cold:
            self.idle = True
        else:
            self.power(True)

    # --------------------------------------------------------------------------------------------------------- power
    def power(self, on: bool) -> None:
        """Switch the supply: program memory, speeds, counter and outputs are lost without it; the EEPROM stays."""
        self.check_switch(on)
        if on == self.powered:
            return
        self.switched(on)
        self.powered = on
        # what else belongs to this instant is done first, its steps among it
        self.kernel.call_at(self.kernel.now, self._power_up if on else self._power_off)
        self.kernel.settle()

    def _power_up(self) -> None:
        self.up_ps, self.idle = self.kernel.now, False
        self.forget()
        self.counter.clear()
        self.start()

    def _power_off(self) -> None:
        self.hang_up()
        for task in self.tasks:
            task.kill()
        self.tasks.clear()
        self.motion.cut()
        self.tear()
        self.stop()
        self.on_command("")
        for driver in self.drivers.values():
            driver.drive(None)
        self.forget()
        self.idle = True
        self.waits("its supply")

    def reset(self) -> None:
        """The module has no reset input.

        Raises:
            UsageError: always; `power` switches the supply.
        """
        raise UsageError(f"{self.name}: RESET of the {self.sheet.part} is an output; use power(False) and power(True)")

    async def run(self) -> None:
        """From power-up on: RESET pulse, straps, and what is to be done without a host."""
        self.waits("the end of the RESET pulse")
        self.outputs_reset()
        self.rdy.drive(0)
        await self.pulse_reset()
        self.address = self.strapped_address()
        self.rdy.drive(None)
        self.listen()
        self.waits("a command")
        if self.pins["rec"].level == 0:
            self.recall_and_run()

    def recall_and_run(self) -> None:
        """The stand-alone start: recall the program, home at its start-stop speed, run it."""
        if self.recall() != "Y" or not self.memory:
            return
        missing = self.unset_before_motion()
        if self.memory[0] != ord("S") or missing:
            lacks = missing or "S at its head"
            self.finding("no-autorun", f"the recalled program is not run, for it lacks {lacks}")
            return
        rxd = self.pins["rxd"].level
        self.run_program(self._home_and_run(-1 if rxd == 1 else 1, self.first_speed()))

    async def _home_and_run(self, direction: int, speed: int) -> None:
        await self._home(direction, speed)
        await self._execute()

    # --------------------------------------------------------------------------------------------------------- lines
    def busy(self, on: bool) -> None:
        self.in_work = on
        self.rdy.drive(0 if on or self.running or self.writing else None)

    @property
    def answering(self) -> bool:
        """Is a line in work, or its answer on its way?  That to M comes when the EEPROM is written."""
        return super().answering or (self.writing and not self.options.early_y)

    def refresh_idle(self) -> None:
        self.idle = not (self.answering or self.running or self.writing)

    async def obey(self, line: Line) -> Sequence[bytes]:
        """Check a line and do what it says; returns the answers as they go over the line."""
        text, checked = line.text, line.checked
        body = self.meant(line)
        if body is None:
            return ()
        fault = self._reception_fault(line)
        if fault:
            return self.spoken(self.mistake("E1", f"{text!r}: {fault}"), checked)
        self.answer_checked = checked
        return self.spoken(await self.answer(body.decode("ascii")), checked)

    def meant(self, line: Line) -> bytes | None:
        text = line.text
        if not text:
            return None
        if self.address and (line.first_faulty or text[:1] != b"%d" % self.address or len(text) == 1):
            return None
        return text[bool(self.address) : len(text) - line.checked]

    def _reception_fault(self, line: Line) -> str:
        if line.faulty:
            return "a parity or framing fault"
        if line.too_long:
            return f"more than {self.longest} characters"
        if line.checked and line.text[-1] != checksum(line.text[:-1], self.kept):
            return f"checksum {line.text[-1]:#04x}, expected {checksum(line.text[:-1], self.kept):#04x}"
        return ""

    def spoken(self, answer: str, checked: bool) -> list[bytes]:
        """Answers as they go over the line, each with its checksum if there is one; none for an empty text."""
        lines = [line.encode("ascii") for line in answer.split("\r") if line]
        return [line + bytes([checksum(line, self.kept)]) if checked else line for line in lines]

    async def answer(self, text: str) -> str:
        """The answer to a line that came well: Y, B, R, E2 to E6, or V with data; lines of Q with CR between them."""
        command = parse(self.sheet, "Po" if self.options.lenient and text == "P0" else text)
        if self.writing:
            return "B"
        if self.running:
            if isinstance(command, Command) and "r" in command.row.when:
                return await self.perform(command)
            return "B"
        if not isinstance(command, Command):
            if command.code == "unknown":
                return self.mistake("E4", command.text)
            return self.mistake("E2", command.text)
        if ("p" if self.entering else "i") in command.row.when:
            return await self.perform(command)
        if self.entering and command.row.stored:
            return self.enter(command)
        if self.options.direct and command.row.stored:
            return self._run_directly(command)
        state = "while programming" if self.entering else "outside a program"
        return self.mistake("E4", f"{text}: not allowed {state}")

    def mistake(self, code: str, text: str) -> str:
        """The host has made a mistake, or the EEPROM fails: the answer, and a finding with the same code."""
        self.finding(code, text)
        return code

    async def perform(self, command: Command) -> str:
        """An immediate command; most answer Y."""
        answer = await self.handlers[command.row.form](*command.values)
        return "Y" if answer is None else answer

    def enter(self, command: Command) -> str:
        """Programming: store an instruction, if it fits."""
        if len(self.memory) + command.row.size > self.sheet.buffer_bytes:
            room = f"{len(self.memory)} of {self.sheet.buffer_bytes} locations are taken"
            return self.mistake("E3", f"{command.text} does not fit: {room}")
        self.memory += command.stored
        return "Y"

    def _run_directly(self, command: Command) -> str:
        async def once() -> None:
            self.begin_run()
            self.works_on(command.text)
            await self.handlers[command.row.form](*command.values)

        self.run_program(once())
        return "Y"

    # -------------------------------------------------------------------------------------------- immediate commands
    async def do_program(self) -> None:
        self.entering = True
        self.memory.clear()

    async def do_program_end(self) -> None:
        self.entering = False

    async def do_execute(self) -> str:
        self.entering = False
        missing = self.unset_before_motion()
        if not self.memory or missing:
            return self.mistake("E4", f"E with {f'{missing} never set' if missing else 'an empty program'}")
        self.state.overflow = False
        self.run_program()
        return "Y"

    async def do_feedback(self) -> str:
        if self.running:
            return "B"
        for flag, answer in (("overflow", "E5"), ("failed", "E6")):
            if getattr(self.state, flag):
                setattr(self.state, flag, False)
                return answer
        return "R"

    async def do_kill(self) -> None:
        if self.running:
            self._ends("K")
            await self.end_now()

    def _ends(self, letter: str) -> None:
        """A command ends a motion."""
        if self.motion.moving:
            self.counter.log.mark("command", letter)

    async def do_zero_speed(self) -> None:
        self._ends("Z")
        if self.motion.moving and not self.counter.homing:
            self.counter.log.stop()
            self.ending = True
            self.motion.come_to_rest()
        elif self.running:
            await self.end_now()

    async def do_query(self) -> str:
        return "\r".join([*(row.text for row in self.program_rows()), "END"])

    async def do_verify(self, what: int) -> str:
        if what == 2:
            return f"V{self.read_inputs()}{self.read_outputs()}"
        if self.wraps:
            return f"V{self.position:+d}"
        return f"V{self.position:0{7 if self.options.pad7 else 1}d}"

    async def do_home(self, direction: int) -> str:
        speed = self.first_speed()
        if not speed:
            return self.mistake("E4", "H without a start-stop speed")
        self.run_program(self._home_for_host(direction, speed))
        return "Y"

    def first_speed(self) -> int:
        """The speed of a homing: that of the S at the head of the program, else the one in force."""
        if self.memory and self.memory[0] == ord("S"):
            return self._fetch(bytes(self.memory), 0)[1][0]
        return self.state.start_stop

    async def _home_for_host(self, direction: int, speed: int) -> None:
        await self._home(direction, speed)
        if self.homing_erases:
            self.memory.clear()

    async def _home(self, direction: int, speed: int) -> None:
        """The counter is not kept on the way, and cleared at the end."""
        text = "H+" if direction > 0 else "H-"
        self.works_on(text)
        self.counter.set_out(text, direction, homing=speed)
        await self.motion.home(direction, text)
        self.counter.homed()
        self.works_on("")

    # --------------------------------------------------------------------------------------------------------- EEPROM
    async def do_memorize(self) -> str:
        self.writing = True
        task = self.kernel.spawn(self._write(bytes(self.memory), self.answer_checked), f"{self.name} writes")
        self.tasks.append(task)
        return "Y" if self.options.early_y else ""

    async def _write(self, program: bytes, checked: bool) -> None:
        """Write byte after byte, a check byte behind them, and answer when all of it is verified."""
        self.waits("the EEPROM")
        self.works_on("M")
        self.saving = program, self.kernel.now
        await until(self.kernel, self.kernel.now + self.eeprom_ps * (len(program) + 1) // sheet.WRITTEN)
        self.spoiled = self._programmed(program)
        good = not self.spoiled
        if not good:
            self.finding("E6", f"the EEPROM was not written: {self.spoiled}")
        self.writing, self.saving = False, None
        self.works_on("")
        self.busy(self.in_work)
        self.waits("a command")
        if self.options.early_y:
            self.state.failed = not good
        else:
            self.take(self.spoken("Y" if good else "E6", checked)[0])
        self.refresh_idle()

    def _programmed(self, program: bytes) -> str:
        """Keep a program; return why that failed, empty if it did not."""
        try:
            self.store.write(INVALID if self.eeprom_fails else program)
            return "" if self.store.read() == program else "it does not hold the program"
        except OSError as error:
            return str(error)

    def tear(self) -> None:
        """Leave the EEPROM half written, as the supply fails during M: what has been written is new, the rest as
        before, and the check byte fits neither."""
        if self.saving is None:
            return
        program, since = self.saving
        done = (self.kernel.now - since) * sheet.WRITTEN // self.eeprom_ps
        try:
            before = self.store.read()
            torn = program[:done] + before.removeprefix(INVALID)[done:]
            if torn != before:
                self.store.write(INVALID + torn)
        except OSError as error:
            self.spoiled = str(error)

    async def do_exchange(self) -> str:
        return self.recall()

    def recall(self) -> str:
        """EEPROM to program memory; a content that is not valid leaves it as it was."""
        try:
            data = self.store.read()
        except OSError as error:
            return self.mistake("E6", f"the EEPROM cannot be read: {error}")
        if self.spoiled or not self._is_program(data):
            why = f": the last write failed ({self.spoiled})" if self.spoiled else ""
            return self.mistake("E6", f"the EEPROM holds no valid program{why}")
        self.memory = bytearray(data)
        return "Y"

    def _is_program(self, data: bytes) -> bool:
        at = 0
        while at < len(data) and data[at] in self.rows:
            at += self.rows[data[at]].size
        return at == len(data) <= self.sheet.buffer_bytes


class GsC200(GsC):
    """A GS-C200: counter from 0 to 9999999, which overflows (E5)."""

    sheet: Sheet = sheet.GS_C200
    wraps, homing_erases = False, True


class GsC200S(GsC):
    """A GS-C200S: signed counter that wraps, jumps, preset of the counter."""

    sheet: Sheet = sheet.GS_C200S
    wraps, homing_erases = True, False
