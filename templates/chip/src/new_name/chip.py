"""The model of the NEW-NAME: a method for each command, found by the name of its row."""

from __future__ import annotations

from typing import Any

from slewline.build import Axis, LineChip, Playing, StepTrain, StrobeView

from .sheet import SHEET

SECOND = 10**12  # virtual time is counted in picoseconds
PULSE = 2 * 10**6


def runs(speed: int, steps: int) -> list[tuple[int, int]]:
    """Return a move as runs of equal intervals (interval in ps, number).  A ramp has a run for every speed."""
    return [(SECOND // speed, steps)]


class NewName(LineChip):
    """The NEW-NAME, which moves at constant speed and stops immediately."""

    sheet = SHEET

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.axes = (Axis(self.kernel, range(-(1 << 31), 1 << 31), 0),)
        self.speed = 100
        self.rest_ps = 0  # instant at which the motor stops
        self.playing = Playing(StepTrain(self.clock, 0, []))
        self.start()

    async def run(self) -> None:
        """Run the firmware from power-up on."""
        self.outputs_reset()
        self.listen()

    def refresh_idle(self) -> None:
        """Set whether the chip is idle: a run until idle waits for the end of a move."""
        self.idle = not self.answering and self.kernel.now >= self.rest_ps

    def do_speed(self, speed: int) -> None:
        """Set the speed of the next move."""
        self.speed = speed

    def do_move(self, steps: int) -> str | None:
        """Begin a move.  Its steps are a train, not single events: long moves compute as fast as short ones."""
        if self.kernel.now < self.rest_ps:
            self.finding("busy", "M during a move is refused: the manual does not define its effect")
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
        """Stop after the present step."""
        self.playing.until = self.rest_ps = self.kernel.now + 1

    def do_position(self) -> int:
        """Return the position of the motor, in steps."""
        return self.position
