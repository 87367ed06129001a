"""Random motions of a CY500, CY512 or CY525, each of which a command over the two-line handshake starts, disturbed."""

from __future__ import annotations

from random import Random
from typing import Any

from slewline.core.wires.waits import edge

from .exchange_handshakes import LINES, PARTS, Disturbed, Strobed, disturbed
from .exchanges import MS, US, Dialogue

SETTINGS = {"cy500": "R 200\rF 20\rS 200\r", "cy512": "R 200\rF 20\rS 200\r", "cy525": "F 60\rR 100\rS 100\rZ 2\r"}
SAID = ("N 3\r", "N 9\r", "N 1\r", "G\r", "G\r", "G\r", "+\r", "-\r", "R 90\r", "A 7\r")


class Moving(Strobed):
    """A chip whose MOTION COMPLETE, if it has one, is compared as well; half of them record it."""

    def furnish(self) -> None:
        super().furnish()
        self.complete = "x.motion_complete" if "motion_complete" in self.chip.pins else "x.pulse"
        if self.dialogue.seed % 8 < 4:
            self.bench.record(self.complete)

    def state(self) -> dict[str, Any]:
        found = super().state()
        if self.dialogue.seed % 8 < 4:
            found["complete"] = self.recorded(self.complete, 0)
        return found

    def wait(self, name: str, number: int) -> None:
        """A task waits for edges of a wire, and notes them."""
        net = self.pins[name].net

        async def waiting() -> None:
            for _ in range(number):
                await edge(net)
                self.noted.append((self.bench.now_ps, "waited", name))

        self.bench.kernel.spawn(waiting, name=f"{name} is waited for")


class Awaited(Disturbed):
    """What happens to it."""

    def more(self, what: str, at: int) -> None:
        rnd = self.rnd
        if rnd.random() < 0.5:
            super().more(what, at)
        else:
            lines = [f"x.{name}" for name in LINES]
            self.act(at, "wait", rnd.choice(lines), rnd.choice((1, 2, 5)), within=False)  # else it depends on the round


def base(seed: int) -> Dialogue:
    """A dialogue that nothing disturbs."""
    rnd = Random(f"exchange motions {seed}")
    part = rnd.choice(PARTS)
    said = [rnd.choice(SAID) for _ in range(rnd.choice((3, 5, 8)))]
    options = {
        "crystal": rnd.choice(("11 MHz", "6 MHz", "3.579545 MHz") if part == "cy525" else ("6 MHz", "3.579545 MHz")),
        "text": 1,
        "other": rnd.choice((None, None, None, "cy525")),
        "delay": rnd.choice((0, 0, 0, 0, 0, 100 * US)),
    }
    return Dialogue(seed, part, f"{SETTINGS[part]}N 5\rG\r{''.join(said)}", options, 100 * MS)


def dialogues(seed: int, number: int) -> list[Dialogue]:
    """So many dialogues that say the same, disturbed each in another way."""
    return disturbed(base(seed), number, Random(f"exchange motions {seed} disturbed"), Awaited)
