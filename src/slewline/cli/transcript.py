"""The transcript: one line per event, printed while the bench runs.

It observes findings, hosts, pins that have a meaning in the sheet, and the axes, which report the start
and the end of each motion; it changes nothing.  Single steps are not observed, so they add no cost.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import partial

from ..bench import Bench
from ..core.chip import Chip
from ..core.component import Finding
from ..core.datasheet.table import Pin
from ..core.messages.whole import counted
from ..core.motion.motions import MotionEnd, MotionStart
from ..core.motion.one_axis import OneAxis
from ..core.time.kernel import Task
from ..core.time.timebase import PS_PER_S, readable
from ..core.wires.net import Net
from ..core.wires.waits import level
from ..parts.front_panel.displays import HpDisplay, Lcd
from ..parts.hosts.host import Host

STAYS_PS = 20 * 10**9  # a display must be unchanged for this time
MOST = 100  # maximum number of lines about a pin; the report of an endless program would never end

Emit = Callable[[int, str, str, str], object]  # picoseconds, source, kind of event, text


def seconds(ps: int) -> str:
    """Return an instant as text for a column: seconds, with six decimals."""
    return f"{ps // PS_PER_S}.{ps % PS_PER_S // 10**6:06d}"


class Transcript:
    """An observer that reports the events of a bench to `emit`; attach it to a complete bench, before it runs."""

    def __init__(self, bench: Bench, emit: Emit) -> None:
        self.bench, self.emit = bench, emit
        self.lines: Counter[str] = Counter()

    def attach(self) -> None:
        """Report the findings so far, and start to observe the bench."""
        for found in self.bench.findings:
            self.finding(found)
        self.bench.on_finding.add(self.finding)
        for part in self.bench.parts.values():
            if isinstance(part, Host):
                part.on_event.add(partial(self.report, part.name, "host"))
            if isinstance(part, HpDisplay | Lcd):
                part.on_change.add(DisplayReports(self, part).changed)
        for chip in self.bench.chips.values():
            for row in chip.sheet.pins:
                if row.transcript is not None:
                    self.watch(chip, row, row.transcript)
            for number in range(1, chip.sheet.axes + 1):
                MotionReports(self, chip, number).attach()

    @property
    def now(self) -> int:
        """Virtual time in picoseconds."""
        return self.bench.now_ps

    def report(self, who: str, kind: str, text: str) -> None:
        """Report an event that occurs at this instant."""
        self.emit(self.now, who, kind, text)

    def finding(self, found: Finding) -> None:
        """Report a finding, with the time of the finding itself."""
        self.emit(found.time_ps, found.source, "finding", f"{found.code}: {found.text}")

    def watch(self, chip: Chip, row: Pin, meanings: tuple[str, str]) -> None:
        """Start to report the changes of a pin; `meanings` are the meanings of its levels 0 and 1."""
        pin = row.name
        name = spoken(row)

        def changed(net: Net) -> None:
            if net.level is None:
                text = f"{name} floats"
            else:
                meaning = meanings[net.level]
                text = f"{name} {'high' if net.level else 'low'}{': ' if meaning else ''}{meaning}"
            if not chip.idle and f"{pin}=" in chip.waiting:
                text += f" ({chip.waiting.removeprefix(f'{chip.name}: ')})"
            self.seldom(chip.name, "pin", text, f"{chip.name}.{pin}")

        chip.pins[pin].net.watch(changed)

    def seldom(self, who: str, kind: str, text: str, about: str) -> None:
        """Report an event about a pin, display or axis (`about`), but only the first 100 events about each one."""
        self.lines[about] += 1
        if self.lines[about] <= MOST:
            self.report(who, kind, text)
        elif self.lines[about] == MOST + 1:
            self.report(who, kind, f"{about} continues like this; further lines are not shown")


class DisplayReports:
    """Reports of the text of a display, each made when no character has been written for 20 ms."""

    def __init__(self, transcript: Transcript, display: HpDisplay | Lcd) -> None:
        self.transcript, self.display, self.kernel = transcript, display, display.kernel
        self.since = 0  # last change
        self.waits = False

    def changed(self) -> None:
        """Schedule a report for 20 ms after a change of the text; a further change postpones the report."""
        self.since = self.kernel.now
        if not self.waits:
            self.waits = True
            self.kernel.call_at(self.since + STAYS_PS, self.report)

    def report(self) -> None:
        """Print the text of the display if it has been unchanged for 20 ms; otherwise postpone the report."""
        if self.kernel.now < self.since + STAYS_PS:
            self.kernel.call_at(self.since + STAYS_PS, self.report)
            return
        self.waits = False
        name = self.display.name
        self.transcript.seldom(name, "display", self.display.said, f"{name}, the display,")


class MotionReports:
    """Reports of the start and the end of each motion of an axis.

    If the part has a pin that indicates motion, a motion starts when this pin becomes active; otherwise it
    starts with its first step.  If one motion replaces another without a stop in between, the two are
    reported as one.
    """

    def __init__(self, transcript: Transcript, chip: Chip, number: int) -> None:
        self.transcript, self.chip = transcript, chip
        self.axis: OneAxis = chip.axis(number)
        self.who = f"axis {number} " if chip.sheet.axes > 1 else ""
        self.about = f"{self.axis.name}, motions"
        complete = chip.sheet.role("motion_complete", number)
        self.over = "at rest" if complete is None else spoken(complete)
        self.step = None if chip.sheet.role("moving", number) else chip.sheet.role("step", number)
        self.first: Task | None = None  # waits for the first step
        self.begun: int | None = None  # start of the motion; None: at rest
        self.steps = 0  # steps of the motions replaced so far

    def attach(self) -> None:
        """Start to observe the axis."""
        self.axis.on_motion_begin.add(self.begin)
        self.axis.on_motion_end.add(self.end)

    def begin(self, motion: MotionStart) -> None:
        """Report the start of a motion, immediately or when its first step begins.

        The report waits for the first step if the part has no pin that indicates motion, and if a step begins
        with an edge of its step pin.
        """
        if self.begun is not None:
            return
        if self.step is None or self.step.sense is None:  # no edge marks the start of the first step
            self.moves("moves", motion)
        else:
            net = self.chip.pins[self.step.name].net
            self.first = self.chip.kernel.spawn(
                self.first_step, motion, net, self.step.sense, name=f"transcript of {self.chip.name}"
            )

    async def first_step(self, motion: MotionStart, net: Net, begins: int) -> None:
        """Wait until the step pin has the level `begins`, with which a step begins; then report the motion."""
        await level(net, begins)
        self.moves("steps", motion)

    def moves(self, verb: str, motion: MotionStart) -> None:
        """Report that the axis is moving, with its direction and its start position."""
        self.begun, self.steps = self.transcript.now, 0
        self.report(f"{verb}{direction_text(motion.direction)} from {motion.position}")

    def end(self, motion: MotionEnd) -> None:
        """Report that a motion has ended, unless another motion replaces it."""
        if self.first is not None:
            self.first.kill()
            self.first = None
        self.steps += motion.steps
        if motion.why == "changed" or self.begun is None:
            return
        taken = readable(motion.time_ps - self.begun)
        self.begun = None
        ended = "cut off" if motion.why == "cut" else self.over
        steps = counted(abs(self.steps), "step") + (direction_text(self.steps) if self.step is not None else "")
        self.report(f"{ended} at {motion.position}: {steps} in {taken}")

    def report(self, text: str) -> None:
        """Report an event of the axis at this instant."""
        self.transcript.seldom(self.chip.name, "motion", self.who + text, self.about)


def spoken(row: Pin) -> str:
    """Return the name of a pin as the manuals write it."""
    return row.name.upper().replace("_", " ")


def direction_text(direction: int) -> str:
    """Return a direction as a word preceded by a space: cw if positive, ccw if negative; empty for 0."""
    return "" if not direction else " cw" if direction > 0 else " ccw"
