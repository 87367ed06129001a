"""Conditions for breakpoints and for requests that run time: steps, edges, commands, registers, findings."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...core.time.timebase import readable
from ...core.wires.pin import Condition, Terminal
from ...errors import UsageError
from ...parts.base.part import Part

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.chip import Chip
    from ...core.component import Finding
    from ...core.motion.one_axis import OneAxis
    from ...core.time.kernel import Kernel

ASKED_PS = 1_000_000_000  # polling interval of parts that report findings only on demand
LEVELS = {"rises": (1,), "falls": (0,), "any": (0, 1, None)}  # after the edge


class InstantCondition(Condition):
    """The condition that an instant (ps) is reached."""

    def __init__(self, kernel: Kernel, at: int) -> None:
        self.kernel, self.at, self.text = kernel, at, readable(at)

    def met(self) -> bool:
        """Return whether the instant is reached."""
        return self.kernel.now >= self.at

    def when(self) -> int | None:
        """Return the instant (ps)."""
        return self.at


class StepCondition(Condition):
    """The condition that a motor takes its next step."""

    def __init__(self, of: OneAxis) -> None:
        self.motor, self.text = of.motor, f"a step of {of.name}"

    def begin(self) -> None:
        """Start to count steps."""
        self.made = self.motor.made

    def met(self) -> bool:
        """Return whether the motor has taken a step."""
        return self.motor.made != self.made

    def when(self) -> int | None:
        """Return the instant (ps) of the next step, as the motor now predicts it; None if it predicts no step."""
        positions = self.motor.positions
        at = positions.index(self.motor.position)
        beside = {positions[at - 1], positions[(at + 1) % len(positions)]}
        return min((ps for position in beside if (ps := self.motor.arrives(position)) is not None), default=None)


class PinCondition(Condition):
    """The condition that a pin changes, to a given level or to any level."""

    def __init__(self, pin: Terminal, edge: str) -> None:
        if edge not in LEVELS:
            raise UsageError(f"edge {edge!r}; allowed {', '.join(LEVELS)}")
        self.pin, self.levels, self.nets = pin, LEVELS[edge], (pin.net,)
        self.text = f"{pin.name} {'changes' if edge == 'any' else edge}"

    def begin(self) -> None:
        """Start to watch the pin for changes."""
        self.changes, self.hit = self.pin.net.changes, False

    def met(self) -> bool:
        """Return whether the last change of the pin since `begin` was to a wanted level; may be called repeatedly."""
        if self.pin.net.changes != self.changes:
            self.changes = self.pin.net.changes
            self.hit = self.pin.level in self.levels
        return self.hit


class CommandCondition(Condition):
    """The condition that a chip begins to execute a command."""

    def __init__(self, chip: Chip) -> None:
        self.chip, self.hit, self.text = chip, False, f"a command of {chip.name}"

    def begin(self) -> None:
        """Start to watch for commands."""
        self.hit = False
        if self.begun not in self.chip.on_command.listeners:
            self.chip.on_command.add(self.begun)

    def begun(self, text: str) -> None:
        """Record the start of a command; "" marks the end of a command."""
        if text:
            self.hit = True
            self.chip.on_command.remove(self.begun)

    def met(self) -> bool:
        """Return whether the chip has begun a command."""
        return self.hit


class FindingCondition(Condition):
    """The condition that a finding is reported by a given chip or part, or by any chip or part."""

    def __init__(self, bench: Bench, source: str) -> None:
        if source:
            bench[source]  # it must exist
        self.bench, self.source, self.hit = bench, source, False
        self.text = f"a finding of {source}" if source else "a finding"

    def begin(self) -> None:
        """Start to watch for findings."""
        self.hit = False
        if self.found not in self.bench.on_finding.listeners:
            self.bench.on_finding.add(self.found)

    def found(self, finding: Finding) -> None:
        """Record a finding, if it is from the chip or part sought."""
        if self.source in ("", finding.source):
            self.hit = True
            self.text = f"{finding.source}: {finding.code}"
            self.bench.on_finding.remove(self.found)

    @property
    def lazy(self) -> list[Part]:
        """Parts that report findings only when they are polled."""
        parts = (part for name, part in self.bench.parts.items() if self.source in ("", name))
        return [part for part in parts if type(part).catch_up is not Part.catch_up]

    def met(self) -> bool:
        """Return whether such a finding has been reported since `begin`, after polling the parts in `lazy`."""
        for part in self.lazy:
            part.be_caught_up()
        return self.hit

    def when(self) -> int | None:
        """Return the next instant (ps) to poll the parts in `lazy`; None if there are no such parts."""
        return self.bench.now_ps + ASKED_PS if self.lazy else None


class RegisterCondition(Condition):
    """The condition that a register changes, to a given value or to any value."""

    def __init__(self, of: OneAxis, name: str, value: int | None) -> None:
        self.of, self.name, self.value = of, name, value
        self.before = of.registers[name]  # an unknown name is reported
        self.text = f"{of.name}: {name} {'changes' if value is None else f'becomes {value}'}"

    def begin(self) -> None:
        """Start to watch the register."""
        self.before = self.of.registers[self.name]

    def met(self) -> bool:
        """Return whether the register has changed since the last call (or `begin`), to the given value if any."""
        before, self.before = self.before, self.of.registers[self.name]
        return self.before != before and self.value in (None, self.before)


class ArrivalCondition(Condition):
    """The condition that an axis arrives at a position; if it is there already, it must leave first."""

    def __init__(self, of: OneAxis, position: int) -> None:
        self.reaches, self.text = of.reaches(position), f"{of.name} at position {position}"
        self.left = False

    def begin(self) -> None:
        """Start to watch the axis."""
        self.left = not self.reaches.met()

    def met(self) -> bool:
        """Return whether the axis has arrived."""
        there = self.reaches.met()
        if not there:
            self.left = True
        return there and self.left

    def when(self) -> int | None:
        """Return the instant (ps) of arrival, as the axis now predicts it; None if it predicts no arrival."""
        return self.reaches.when()
