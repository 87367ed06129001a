"""Deliberate faults around a module, selected by name and repeatable with the same seed.

    with gs_c200s.faults.stuck_switch("ui1", 0):             while the block lasts
    gs_c200s.faults.power_cut(at="1.5 s", lasting="20 ms")   at an instant, for a time
    gs_c200s.faults.garbled_byte(to="host")                  starting now; here, only the next character

Every effect of a fault is a finding of the part "faults", so that the report of a failed test lists it.
A fault drives a pin from outside, as a test does; the level last driven on the pin applies.
"""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from types import TracebackType
from typing import TYPE_CHECKING, Any

from ..core.datasheet.roles import ROLES
from ..core.datasheet.table import Pin
from ..core.messages.instead import missing
from ..core.time.timebase import Time, picoseconds, readable
from ..errors import UsageError
from ..language.dialect import dialect_of
from ..links.lines.served_line import ConnectorLine
from ..parts.base.part import Part
from ..parts.lines.noise import LINKED, Noise

if TYPE_CHECKING:
    from ..core.chip import Chip

RECEIVERS = ("module", "host")
FAULTS = {"parity": "its parity is wrong", "framing": "its stop bit is wrong", "late": "it is late"}


class Fault:
    """A fault that begins immediately or at a given instant, and ends when `end` is called or after a given time.

    As a context manager, it ends when the `with` block ends.
    """

    def __init__(self, owner: Faults, name: str, begin: Callable[[], str], end: Callable[[], object]) -> None:
        self.owner, self.name, self._begin, self._end = owner, name, begin, end
        self.active = self.over = False

    def begin(self) -> None:
        """Start the fault."""
        if not self.over:
            self.active = True
            self.owner.report(f"{self.name}: {self._begin()}")

    def end(self) -> None:
        """End the fault; a fault that has not begun will never begin."""
        self.over = True
        if self.active:
            self.active = False
            self._end()
            self.owner.report(f"{self.name}: over")

    def __enter__(self) -> Fault:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.owner.do(self.end)
        self.owner.do(lambda: None)


class Faults(Part):
    """The faults that can be injected around a module.

    Each method takes `at`, the instant at which the fault begins (by default now), and `lasting`, the time
    after which it ends (by default never).

    Args:
        do: a function that calls a given function while no time passes; needed because a server has its own
            thread.
        seed: the seed for all random choices.
        unplug: a function that takes the port away from programs; its argument is the reason.
        plug: a function that makes the port available again.
    """

    def __init__(
        self,
        chip: Chip,
        line: object,
        do: Callable[[Callable[[], Any]], Any],
        seed: int,
        unplug: Callable[[str], object] = lambda _why: None,
        plug: Callable[[], object] = lambda: None,
    ) -> None:
        super().__init__(chip.kernel, "faults")
        self.chip, self.do, self.seed, self.line = chip, do, seed, line
        self._unplug, self._plug = unplug, plug
        self.random = Random(seed)
        spared = dialect_of(chip.sheet).constant_bit
        self.noises: dict[str, ReportedNoise] = {}
        if isinstance(line, ConnectorLine):
            self.noises = {
                receiver: ReportedNoise(line.port.word.bits, receiver, self.report, spared) for receiver in RECEIVERS
            }
            line.to_chip, line.to_host = self.noises["module"], self.noises["host"]

    def report(self, what: str) -> None:
        """Record an effect of a fault as a finding."""
        self.finding("fault", f"{what} (seed {self.seed})")

    def _scheduled(
        self, name: str, begin: Callable[[], str], end: Callable[[], object], at: Time | None, lasting: Time | None
    ) -> Fault:
        fault = Fault(self, name, begin, end)
        self.do(lambda: self._schedule(fault, at, lasting))
        self.do(lambda: None)  # a server executes some of them in its next turn
        return fault

    def _schedule(self, fault: Fault, at: Time | None, lasting: Time | None) -> None:
        now = self.kernel.now
        start = now if at is None else picoseconds(at)
        if start < now:
            raise UsageError(f"{fault.name}: {readable(start)} is in the past; the time is {readable(now)}")
        if at is None:
            fault.begin()
        else:
            self.kernel.call_at(start, fault.begin)
        if lasting is not None:
            self.kernel.call_at(start + picoseconds(lasting), fault.end)

    # ------------------------------------------------------------------------------------------------------- the port
    def unplugged(self, at: Time | None = None, lasting: Time | None = None) -> Fault:
        """Remove the port, as when an adapter is unplugged: a program that has it open, or opens it, gets errors.

        When the port is back, the program must open it again.  The module stays powered throughout.

        Raises:
            UsageError: the module has no port.
        """
        if self.line is None:
            raise UsageError(f"unplugged: {self.chip.name}, a {self.chip.sheet.part}, has no port; it is on a bus")

        def begin() -> str:
            self._unplug("unplugged")
            return "the port is gone"

        return self._scheduled("unplugged", begin, self._plug, at, lasting)

    # ----------------------------------------------------------------------------------------------------- characters
    def lost_byte(
        self, to: str = "module", count: int = 1, at: Time | None = None, lasting: Time | None = None
    ) -> Fault:
        """Drop the next `count` characters to the module or, with to="host", to the host."""
        return self._noisy("lost byte", "lost", to, count, at, lasting)

    def garbled_byte(
        self, to: str = "module", count: int = 1, at: Time | None = None, lasting: Time | None = None
    ) -> Fault:
        """Invert a data bit and the parity bit of the next `count` characters: only a checksum shows the error.

        The data bit is never bit 4 (0x10), which the checksum does not cover.  With several characters, the
        errors may cancel out in the checksum; and a changed carriage return does not end a line.
        """
        return self._noisy("garbled byte", "garbled", to, count, at, lasting)

    def late_byte(
        self, to: str = "module", count: int = 1, at: Time | None = None, lasting: Time | None = None
    ) -> Fault:
        """Delay each of the next `count` characters by 100 ms; all characters after a delayed one wait for it."""
        return self._noisy("late byte", "late", to, count, at, lasting)

    def wrong_parity(
        self, to: str = "module", count: int = 1, at: Time | None = None, lasting: Time | None = None
    ) -> Fault:
        """Invert the parity bit of each of the next `count` characters."""
        return self._noisy("wrong parity", "parity", to, count, at, lasting)

    def _noisy(self, name: str, kind: str, to: str, count: int, at: Time | None, lasting: Time | None) -> Fault:
        if to not in RECEIVERS:
            raise UsageError(f"{name}: to={to!r}; allowed {', '.join(RECEIVERS)}")
        if not self.noises:
            raise UsageError(f"{name}: {self.chip.name}, a {self.chip.sheet.part}, has no serial line")
        noise, planned = self.noises[to], []

        def begin() -> str:
            noise.plan(kind, count, seed=self.random.getrandbits(32))
            planned.append(noise.plans[-1])
            return f"the next {f'{count} characters' if count > 1 else 'character'} to the {to}"

        def end() -> None:
            noise.plans = [plan for plan in noise.plans if plan not in planned]

        return self._scheduled(name, begin, end, at, lasting)

    # ----------------------------------------------------------------------------------------------------------- pins
    def stuck_switch(self, pin: str, level: int, at: Time | None = None, lasting: Time | None = None) -> Fault:
        """Hold an input at a level, regardless of what else drives it.

        Raises:
            UsageError: there is no such level, or the pin is an output.
        """
        row = next((row for row in self.chip.sheet.pins if row.name == pin), None)
        if row is not None and row.in_out == "out":
            inputs = ", ".join(row.name for row in self.chip.sheet.pins if row.in_out in ("in", "both"))
            raise UsageError(f"stuck switch: {pin} is an output of {self.chip.name}; allowed {inputs}")
        return self._stuck("stuck switch", pin, level, at, lasting)

    def enable_held_low(self, at: Time | None = None, lasting: Time | None = None) -> Fault:
        """Hold ENABLE low (or high, if high stops the part): the next step waits until ENABLE changes back."""
        row = self._row("enable")
        level = 1 - (row.sense or 0)
        return self._stuck(f"{row.name.upper()} held {'high' if level else 'low'}", row.name, level, at, lasting)

    def _row(self, *roles: str) -> Pin:
        """Return the pin with the first of these roles that any pin of the chip has."""
        sheet = self.chip.sheet
        for role in roles:
            if row := sheet.role(role):
                return row
        raise UsageError(f"{self.chip.name}, a {sheet.part}, has no pin that {ROLES[roles[0]]}")

    def _stuck(self, name: str, pin: str, level: int, at: Time | None, lasting: Time | None) -> Fault:
        terminal = self.chip.pin(pin)

        def begin() -> str:
            terminal.drive(level)
            return f"{pin}={level}"

        return self._scheduled(name, begin, terminal.release, at, lasting)

    def bouncing_limit(
        self,
        pin: str | None = None,
        level: int | None = None,
        bounces: int = 5,
        within: Time = "2 ms",
        at: Time | None = None,
        lasting: Time | None = None,
    ) -> Fault:
        """Close a contact, reopen it several times at random instants determined by the seed, and leave it closed.

        Args:
            pin: the pin, by default the input for an end-of-travel switch.
            level: the level of the closed contact; by default the active level.
            bounces: the number of times that the contact reopens.
            within: the time within which all bounces happen.
            at: the instant at which the fault begins, by default now.
            lasting: the duration of the fault, by default forever.
        """
        row = self._row("end", "end_plus") if pin is None else self.chip.pin(pin).row
        closed = (row.sense or 0) if level is None else level
        terminal = self.chip.pin(row.name)

        def begin() -> str:
            now = self.kernel.now
            times = sorted(self.random.sample(range(1, picoseconds(within)), 2 * bounces))
            terminal.drive(closed)
            for n, time in enumerate(times):
                terminal.drive(closed if n % 2 else 1 - closed, at=now + time)
            return f"{row.name}={closed}, bounces at {', '.join(readable(now + time) for time in times[::2])}"

        return self._scheduled("bouncing limit", begin, terminal.release, at, lasting)

    def eeprom_fault(self, at: Time | None = None, lasting: Time | None = None) -> Fault:
        """Make EEPROM programming fail: the module answers the M command with E6.

        It also answers X with E6 until a later write to the EEPROM succeeds.
        """
        fail = getattr(self.chip, "fail_eeprom", None)
        if fail is None:
            raise UsageError(f"EEPROM fault: {self.chip.name}, a {self.chip.sheet.part}, has no EEPROM")

        def begin() -> str:
            fail(True)
            return "programming the EEPROM fails"

        return self._scheduled("EEPROM fault", begin, lambda: fail(False), at, lasting)

    def power_cut(self, at: Time | None = None, lasting: Time | None = None) -> Fault:
        """Switch off the supply of the module until the fault ends."""

        def begin() -> str:
            self.chip.power(False)
            return "the supply is off"

        return self._scheduled("power cut", begin, lambda: self.chip.power(True), at, lasting)


missing(
    Faults,
    **dict.fromkeys(("drop_byte", "drop", "lose_byte", "lost"), "{it}.lost_byte()"),
    **dict.fromkeys(("corrupt_byte", "corrupt", "garble", "flip_bit", "noise"), "{it}.garbled_byte()"),
    **dict.fromkeys(("delay_byte", "delay", "late"), "{it}.late_byte(...)"),
    **dict.fromkeys(("parity", "parity_error", "bad_parity"), "{it}.wrong_parity()"),
    **dict.fromkeys(("unplug", "disconnect", "hot_unplug", "port_lost"), "{it}.unplugged()"),
    **dict.fromkeys(("power_off", "power_fail", "brownout"), "{it}.power_cut()"),
    **dict.fromkeys(("stuck_pin", "stuck", "stick"), "{it}.stuck_switch(pin, level)"),
    **dict.fromkeys(("bounce", "bouncing"), "{it}.bouncing_limit(...)"),
)


class ReportedNoise(Noise):
    """Line noise that reports its effect on each character."""

    def __init__(self, bits: int, receiver: str, report: Callable[[str], object], spared: int | None) -> None:
        super().__init__(bits, LINKED, spared)
        self.receiver, self.report = receiver, report

    def hit(self, byte: int) -> tuple[int | None, str]:
        """Return the received byte (None if lost) and the fault of its frame ("" if none); report any effect."""
        passed, fault = super().hit(byte)
        if passed is None:
            self.report(f"{byte:#04x} to the {self.receiver} is lost")
        elif fault:
            self.report(f"{byte:#04x} to the {self.receiver}: {FAULTS[fault]}")
        elif passed != byte:
            self.report(f"{byte:#04x} to the {self.receiver} has become {passed:#04x}")
        return passed, fault
