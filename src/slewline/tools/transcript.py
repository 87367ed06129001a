"""The transcript: what happened when, a line an event, while it happens.

It looks at a bench from outside, as a logic analyser does, and changes nothing: pins are watched, a motion begins with
the first low of PULSE and is over when READY is high again.  Steps in between cost nothing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import partial

from ..bench import Bench
from ..core.chip import Chip, Finding
from ..core.net import Net
from ..core.timebase import PS_PER_S, readable
from ..core.waits import level
from ..parts.host import Host

MOST = 100  # lines about the same pin; an endless program would never come to an end
WATCHED = {  # pin: what it means when it is (low, high)
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
INPUTS = ("wait", "abort", "step_inhibit", "dowhile")  # what the chip waited for is worth a word when they change

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
        self.bench.on_finding = self.finding
        for part in self.bench.parts.values():
            if isinstance(part, Host):
                part.on_event = partial(self.tell, part.name, "host")
        for chip in self.bench.chips.values():
            for pin in WATCHED:
                if pin in chip.pins:
                    self.watch(chip, pin)
            if "pulse" in chip.pins and "ready" in chip.pins:
                self.bench.kernel.spawn(self.motions(chip), f"transcript of {chip.name}")

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

    def watch(self, chip: Chip, pin: str) -> None:
        """Tell the changes of a pin."""
        name = pin.upper().replace("_", " ")

        def changed(net: Net) -> None:
            if net.level is None:
                text = f"{name} floats"
            else:
                meaning = WATCHED[pin][net.level]
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
        pulse, ready = chip.pins["pulse"].net, chip.pins["ready"].net
        axis = chip.axes[0]
        about = f"{chip.name}, motions"
        while True:
            before = chip.travel
            await level(pulse, 0)
            steps = chip.travel - before
            if steps:
                begun, way = self.now, "cw" if steps > 0 else "ccw"
                self.seldom(chip.name, "motion", f"steps {way} from {(chip.position - steps) % axis.modulus}", about)
                await level(ready, 1)
                complete = chip.pins["motion_complete"].net
                ended, over = ("MOTION COMPLETE", complete.changed_at) if complete.level == 0 else ("cut off", self.now)
                taken = f"{counted(abs(chip.travel - before), 'step')} {way} in {readable(over - begun)}"
                self.seldom(chip.name, "motion", f"{ended} at {chip.position}: {taken}", about)
            await level(pulse, 1)


def counted(number: int, noun: str) -> str:
    """1 step, 2 steps."""
    return f"{number} {noun}{'' if number == 1 else 's'}"
