"""The transcript: what happened when, a line an event, while it happens.

It looks at a bench from outside, as a logic analyser does, and changes nothing: pins are watched, a motion begins with
the first low of PULSE and is over when MOTION COMPLETE falls while PULSE is high, or it lasts as long as MOV is high.
Steps in between cost nothing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import partial

from ..bench import Bench
from ..bench.stage import Computer
from ..core.chip import Chip, Finding
from ..core.net import Net
from ..core.timebase import PS_PER_S, readable
from ..core.waits import first_of, level

MOST = 100  # lines about the same pin; an endless program would never come to an end
ON_BUS = {  # pin: what it means when it is (low, high)
    "reset": ("the chip is held in reset", "the chip starts anew"),
    "prog": ("program entry, or live commands", ""),
    "run": ("the program runs", "the program has ended"),
    "slew": ("at a steady rate", ""),
    "programmable_output": ("", ""),
    "wait": ("", ""),
    "dowhile": ("", ""),
    "abort": ("stop the motion", ""),
    "step_inhibit": ("", "no further step"),
    "ascii_binary": ("binary commands", "ASCII commands"),
}
ON_LINE = {
    "reset": ("the driver is reset", ""),
    "enable": ("no further step", ""),
    "home": ("at the home position", ""),
    "eot": ("at the end of travel", ""),
    **dict.fromkeys((f"u{way}{n}" for way in "io" for n in (1, 2, 3)), ("", "")),
}
IN_PACKETS = {
    "reset": ("the chipset is held in reset", "the chipset starts anew"),
    "hostintrpt": ("an axis has an event for the host", ""),
    **{f"home{n}": (f"axis {n} at its home position", "") for n in range(1, 5)},
    **{f"{way}limit{n}": ("", "") for n in range(1, 5) for way in ("pos", "neg")},
}
# when one of these changes, what the chip waited for is worth a word
INPUTS = ("wait", "abort", "step_inhibit", "dowhile", "enable", "ui1", "ui2", "ui3")

Say = Callable[[int, str, str, str], object]  # picoseconds, who, what kind of event, text


def seconds(ps: int) -> str:
    """An instant for a column: seconds, down to the microsecond."""
    return f"{ps // PS_PER_S}.{ps % PS_PER_S // 10**6:06d}"


class Transcript:
    """Tells `say` what happens on a bench; attach it when the bench is furnished, before time passes."""

    def __init__(self, bench: Bench, say: Say) -> None:
        self.bench, self.say = bench, say
        self.lines: Counter[str] = Counter()

    def attach(self) -> None:
        """Watch everything from now on."""
        for found in self.bench.findings:
            self.finding(found)
        self.bench.on_finding.add(self.finding)
        for part in self.bench.parts.values():
            if isinstance(part, Computer):
                part.on_event.add(partial(self.tell, part.name, "host"))
        for chip in self.bench.chips.values():
            told = ON_LINE if chip.sheet.in_lines else IN_PACKETS if chip.sheet.in_packets else ON_BUS
            for pin, meanings in told.items():
                if pin in chip.pins:
                    self.watch(chip, pin, meanings)
            if "pulse" in chip.pins and "ready" in chip.pins:
                self.bench.kernel.spawn(self.motions(chip), f"transcript of {chip.name}")
            if "mov" in chip.pins:
                self.bench.kernel.spawn(self.movements(chip, "mov", 1), f"transcript of {chip.name}")
            for number in range(1, 1 + chip.sheet.axes if chip.sheet.in_packets else 1):
                self.bench.kernel.spawn(
                    self.movements(chip, f"atrest{number}", 0, number), f"transcript of {chip.name}"
                )

    @property
    def now(self) -> int:
        """Virtual time, picoseconds."""
        return self.bench.now_ps

    def tell(self, who: str, kind: str, text: str) -> None:
        """An event of this instant."""
        self.say(self.now, who, kind, text)

    def finding(self, found: Finding) -> None:
        """Something that a host did wrong."""
        self.say(found.time_ps, found.source, "finding", f"{found.code}: {found.text}")

    def watch(self, chip: Chip, pin: str, meanings: tuple[str, str]) -> None:
        """Tell the changes of a pin."""
        name = pin.upper().replace("_", " ")

        def changed(net: Net) -> None:
            if net.level is None:
                text = f"{name} floats"
            else:
                meaning = meanings[net.level]
                text = f"{name} {'high' if net.level else 'low'}{': ' if meaning else ''}{meaning}"
            if pin in INPUTS and not chip.idle and f"{pin}=" in chip.waiting:
                text += f" ({chip.waiting.removeprefix(f'{chip.name}: ')})"
            self.seldom(chip.name, "pin", text, f"{chip.name}.{pin}")

        chip.pins[pin].net.watch(changed)

    def seldom(self, who: str, kind: str, text: str, about: str) -> None:
        """Tell an event, but not for ever."""
        self.lines[about] += 1
        if self.lines[about] <= MOST:
            self.tell(who, kind, text)
        elif self.lines[about] == MOST + 1:
            self.tell(who, kind, f"{about} goes on like this; no more of it is shown")

    async def motions(self, chip: Chip) -> None:
        """Tell the begin and the end of every motion."""
        pulse, ready, complete = (chip.pins[name].net for name in ("pulse", "ready", "motion_complete"))
        kernel, axis = self.bench.kernel, chip.axes[0]
        about = f"{chip.name}, motions"
        while True:
            before = chip.travel
            await level(pulse, 0)
            steps = chip.travel - before
            if steps:
                begun, way = self.now, "cw" if steps > 0 else "ccw"
                self.seldom(chip.name, "motion", f"steps {way} from {(chip.position - steps) % axis.modulus}", about)
                while await first_of(kernel, None, (ready, 1), (complete, 0)) is complete and pulse.level == 0:
                    await level(complete, 1)  # a read-out on the fly
                ended = "MOTION COMPLETE" if complete.level == 0 else "cut off"
                taken = f"{counted(abs(chip.travel - before), 'step')} {way} in {readable(self.now - begun)}"
                self.seldom(chip.name, "motion", f"{ended} at {chip.position}: {taken}", about)
            await level(pulse, 1)

    async def movements(self, chip: Chip, pin: str, moving: int, number: int = 1) -> None:
        """Tell when a pin says that an axis begins to move, and when it is at rest again."""
        net, axis = chip.pins[pin].net, chip.axes[number - 1]
        who, about = f"axis {number} " if len(chip.axes) > 1 else "", f"{chip.name}.{pin}, motions"
        while True:
            await level(net, moving)
            before, begun = axis.travel, self.now
            way = f" {'cw' if chip.pins['dir'].level else 'ccw'}" if "dir" in chip.pins else ""
            self.seldom(chip.name, "motion", f"{who}moves{way} from {axis.position}", about)
            await level(net, 1 - moving)
            taken = f"{counted(abs(axis.travel - before), 'step')} in {readable(self.now - begun)}"
            self.seldom(chip.name, "motion", f"{who}at rest at {axis.position}: {taken}", about)


def counted(number: int, noun: str) -> str:
    """1 step, 2 steps."""
    return f"{number} {noun}{'' if number == 1 else 's'}"
