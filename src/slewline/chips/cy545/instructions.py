"""Effects of commands: one method for each command of the sheet, named after it (do_loop for LOOP)."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable, Mapping
from typing import TYPE_CHECKING

from ...core.wires.waits import first_of
from ...language.text.written_values import query_meant
from ..cy5xx import instructions
from . import sheet

if TYPE_CHECKING:
    from ...core.context import ChipContext
    from ..cy5xx.program_buffer import Moves
    from .external_program import Program
    from .interfaces.display import Display
    from .interfaces.local_bus import LocalBus
    from .interfaces.user_bits import UserBits
    from .registers import Registers
    from .stepping.home import Home
    from .twin import Homewise


class Instructions(instructions.ParameterHandlers):
    """The command handlers.  Handlers of commands with text also receive the characters after the numbers.

    Args:
        begin: a function that restores the reset state, for command I.
    """

    registers: Registers

    def __init__(
        self,
        chip: ChipContext,
        ticks: Mapping[str, int],
        registers: Registers,
        outputs: instructions.DirectionOutput,
        motion: Moves,
        home: Home | Homewise,
        bits: UserBits,
        display: Display,
        local_bus: LocalBus,
        program: Program,
        begin: Callable[[], None],
    ) -> None:
        super().__init__(chip, ticks, registers, outputs, motion)
        self.home, self.bits, self.display, self.local_bus = home, bits, display, local_bus
        self.program, self.restart = program, begin

    # ----------------------------------------------------------------------------------------------------- parameters
    def do_atposition(self, position: int) -> None:
        """A: set the position, 0 to 16,777,215 steps, without a motion."""
        self.declare(position, f"A {position}")

    def do_firstrate(self, rate: int) -> None:
        """F: load the rate parameter of the first step."""
        self.registers.load("firstrate", rate)

    def do_continuous(self) -> None:
        """C: make the next motion continuous."""
        self.registers.continuous = True

    def do_mode(self, mode: int) -> None:
        """O: load the mode register and update the pins that depend on it; report a finding for bits of unknown use."""
        self.registers.load("mode", mode)
        self.bits.show()
        unknown = mode & (sheet.MB_6 | sheet.MB_3)
        if unknown:
            self.finding_once(
                "mode-bits",
                f"O {mode}: the effect of MB6 and MB3 is not documented; they are stored and have no effect",
            )

    def do_pointer(self, address: int) -> None:
        """Y: load the pointer into the external memory."""
        self.registers.pointer = address

    # ----------------------------------------------------------------------------------------------------------- bits
    def do_bit(self, argument: int) -> None:
        """B: set, clear, write, AND or OR user bits, or set or clear a data bus bit; report a bit already in use."""
        one = argument & 0xC0 == 0
        if one and argument & sheet.DATA_BUS and self.program.running:
            self.chip.finding(
                "bus-bit", f"B {argument}: the data bus is in use; the bit keeps its level until the next bus cycle"
            )
        if one and argument & 0x0F == 6 and self.bits.shared:
            self.chip.finding("shared-bit", f"B {argument}: USRB6 is {self.bits.shared}; only the latch changes")
        self.bits.act(argument)

    async def do_wait(self, argument: int) -> None:
        """W: wait until the bits match the argument; they are sampled at a fixed interval."""
        chip, poll = self.chip, self.ticks["wait_poll"]
        origin = chip.tick
        chip.waits(f"waiting until bits match (W {argument})")
        while not self.bits.matches(argument):
            nets = self.bits.nets(argument)
            await first_of(chip.kernel, None, *((net, None) for net in nets))
            passed = chip.clock.ticks_until(chip.kernel.now) - origin
            await chip.at_tick(origin + (passed // poll + 1) * poll)

    # -------------------------------------------------------------------------------------------------------- motions
    def do_go(self) -> Awaitable[None]:
        """G: return an awaitable that makes the motion of N steps in the present direction."""
        if not self.registers.directed:
            direction, count = ("clockwise", "up") if self.registers.clockwise else ("counter-clockwise", "down")
            after = f"after reset the direction is {direction} (inferred), and the position counts {count}"
            self.finding_once("direction-inferred", f"G without + or - before it: {after}; send + or - first")
        return super().do_go()

    async def do_home(self, argument: int) -> None:
        """H: seek the edge of the home sensor that is connected to the bit in the argument."""
        await self.home.seek(argument)

    async def do_delay(self, delay: int) -> None:
        """D: pause for a number of milliseconds (at 12 MHz)."""
        await self.pause("D", delay)

    async def do_initialize(self) -> None:
        """I: restore the state after power-up, and end the running program, if any."""
        self.chip.waits("I in progress")
        await self.chip.ticks(self.ticks["initialize"])
        self.restart()

    def odd(self) -> Iterable[tuple[bool, str, str]]:
        values = self.registers.values
        low, high = values["firstrate"], values["rate"]
        yield high < low, "rate-below-firstrate", f"R {high} is below F {low}: the whole motion is made at F"

    # -------------------------------------------------------------------------------------------------------- program
    def do_enter(self) -> None:
        """E: report a finding if a program runs, because E has no effect in a program."""
        if self.program.running:
            self.program.finding_once("enter-while-running", "E has no effect in a program")

    def do_quit(self) -> None:
        """Q: report a finding, because no program is being entered."""
        self.chip.finding("quit-outside-entry", "Q has no effect outside program entry")

    def do_execute(self) -> None:
        """X: run the program at the pointer, unless one is running."""
        if not self.program.running:
            self.program.begin()

    def do_stop(self) -> None:
        """0: end the running program."""
        if self.program.running:
            self.program.end()

    def do_jump(self, target: int) -> None:
        """J: continue at a byte of the present page; as a host command, start the program there."""
        self.program.go_to(target)
        if self.program.direct:
            self.program.begin()

    def do_loop(self, count: int, target: int) -> None:
        """L: branch to a byte of the present page while passes are left (at most 256 passes)."""
        self.loop("L", count, target, 1 << 8)

    def do_longloop(self, count: int, target: int) -> None:
        """Z: branch to a byte of the present page while passes are left (at most 65,536 passes)."""
        self.loop("Z", count, target, 1 << 16)

    def loop(self, letter: str, count: int, target: int, whole: int) -> None:
        """L, Z: branch while passes are left; report a host's L or Z, which starts the program if `count` != 1."""
        if self.program.direct:
            self.branch_as_command(letter, count != 1, target)
        elif self.program.passes_left(letter, count, whole):
            self.program.go_to(target)

    def do_til(self, argument: int, target: int) -> None:
        """T: branch unless the bits match the argument; report a host's T, whose branch starts the program."""
        away = not self.bits.matches(argument)
        if self.program.direct:
            self.branch_as_command("T", away, target)
        elif away:
            self.program.go_to(target)

    def branch_as_command(self, letter: str, away: bool, target: int) -> None:
        """Report a host's branch command, which belongs in a program; if `away`, start the program at the target."""
        became = f"the program starts at the target of {letter}" if away else "it has no effect"
        code = "til-command" if letter == "T" else "loop-command"
        self.chip.finding(code, f"{letter} as a host command: {became}")
        if away:
            self.do_jump(target)

    # -------------------------------------------------------------------------------------------------------- display
    async def do_query(self, *given: int, data: bytes) -> None:
        """?: send a parameter or a listing to the display device; report a finding for an unknown letter."""
        letter = data.decode("latin-1")
        if letter == sheet.LISTING and given:
            await self.display.listing(given[0])
        elif letter in sheet.QUERIES:
            await self.display.reply(letter, self.parameter(letter))
        else:
            asked, meant = ", ".join(sheet.QUERIES), query_meant(letter, (*sheet.QUERIES, sheet.LISTING))
            text = f"? {letter} is not answered; allowed {asked} and {sheet.LISTING},n"
            self.chip.finding("unknown-query", f"{text}; {meant}" if meant else text)

    def parameter(self, letter: str) -> int:
        """Return the value that answers the query with the given letter."""
        if letter == "P":
            return self.axis.position
        if letter == "B":
            return self.bits.word
        name = next(row.name for row in self.chip.sheet.registers if row.letter == letter)
        return self.registers.values[name]

    async def do_string(self, data: bytes) -> None:
        """Send the characters of a string to the display device, for the command that begins with a quotation mark."""
        await self.display.put(data)

    async def do_display(self, address: int, _count: int, data: bytes) -> None:
        """[: write values to the HP display on the local bus, at ascending addresses from the given one."""
        await self.local_bus.show(address, data)
