"""What the NEW-NAME does: a method for each command, found by the name of its row."""

from __future__ import annotations

from typing import Any

from slewline.build import Axis, LineChip, Playing, StepTrain, StrobeView

from .sheet import SHEET

SECOND = 10**12  # virtual time is counted in picoseconds
PULSE = 2 * 10**6


def runs(speed: int, steps: int) -> list[tuple[int, int]]:
    """Return a move as runs of equal intervals, picoseconds and count each.  A ramp is a run for every speed."""
    return [(SECOND // speed, steps)]


class NewName(LineChip):
    """The NEW-NAME: constant speed, stops at once."""

    sheet = SHEET

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.axes = (Axis(self.kernel, range(-(1 << 31), 1 << 31), 0),)
        self.speed = 100
        self.rest_ps = 0  # when the motor stops
        self.playing = Playing(StepTrain(self.clock, 0, []))
        self.start()

    async def run(self) -> None:
        """Work from power-up on."""
        self.outputs_reset()
        self.listen()

    def refresh_idle(self) -> None:
        """Set whether there is nothing to do: a run until idle waits for the end of a move."""
        self.idle = not self.answering and self.kernel.now >= self.rest_ps

    def do_speed(self, speed: int) -> None:
        """Set the speed of the next move."""
        self.speed = speed

    def do_move(self, steps: int) -> str | None:
        """Begin a move.  Its steps are a train, not an event each: a long move costs no more than a short one."""
        if self.kernel.now < self.rest_ps:
            self.finding("busy", "M during a move: the manual does not say what it does; it is refused")
            return self.refused.decode()
        train = StepTrain(self.clock, self.tick, runs(self.speed, abs(steps)))
        self.playing = Playing(train)
        self.drivers["dir"].drive(int(steps > 0))
        self.axes[0].follow(self.playing, 1 if steps > 0 else -1)
        self.drivers["step"].play(StrobeView(self.playing, PULSE))
        self.rest_ps = self.clock.ps(train.origin + train.length)
        self.kernel.call_at(self.rest_ps, self.refresh_idle)
        return None

    def do_stop(self) -> None:
        """Take no step after this one."""
        self.playing.until = self.rest_ps = self.kernel.now + 1

    def do_position(self) -> int:
        """Return where the motor is, in steps."""
        return self.position
