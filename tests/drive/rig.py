"""A host, a line and a board in virtual time: the host's clock is moved by the test, and the board's crystal is off."""

from __future__ import annotations

from heapq import heappop, heappush
from itertools import count
from random import Random

import numpy as np

from slewline.drive.board.boards import UNO
from slewline.drive.board.twin_board import BoardTwin
from slewline.drive.check import Check
from slewline.drive.motor_drive import Drive

HZ = 16_000_000
MS_NS = 1_000_000
BYTE_NS = 20_000  # of 500 kbaud
WITHIN = 9  # ticks: a tolerance of 8, and what is rounded down


class TwinLine:
    """The port of a board: bytes take their time on the line, and the adapter collects them for a while.

    Args:
        rnd: for the time that adapter and main loop take.
        ppm: how much faster the crystal of the board is than the clock of the host.
    """

    name = "twin"

    def __init__(self, rnd=None, ppm=300, latency_ns=(200_000, 3 * MS_NS), model=UNO):
        self.now = 5_000_000_000  # of the host
        self.rnd, self.ppm, self.latency_ns = rnd or Random(1), ppm, latency_ns
        self.model = model
        self.twin = BoardTwin(model)
        self.began = self.now
        self.order, self.coming = count(), []  # what happens at the board: ns, order, bytes
        self.back = []  # on their way to the host: ns, bytes
        self.free_down = self.free_up = 0  # when the line has carried what it has, each way
        self.supplied, self.damage = True, lambda data: data
        self.closed = False
        self.lost_at = None

    # ----------------------------------------------------------------------------------------------------------- time
    def wall(self):
        return self.now

    def tick(self, ns):
        """The tick of the board at an instant of the host."""
        return (ns - self.began) * HZ * (1_000_000 + self.ppm) // (10**9 * 1_000_000)

    def wait(self, seconds):
        """Wait for bytes of the board, for so long at most."""
        until = self.now + max(int(seconds * 10**9), 1000)
        while self.now < until and not (self.back and self.back[0][0] <= self.now):
            soon = min(until, self.now // MS_NS * MS_NS + MS_NS)  # when the board looks, and may say something
            if self.coming:
                soon = min(soon, max(self.coming[0][0], self.now + 1))
            self.pass_to(min(soon, self.back[0][0]) if self.back else soon)

    def pass_to(self, ns):
        """Let everything happen up to an instant of the host; the board's loop looks for silence each ms."""
        while True:
            at = min(ns, self.now // MS_NS * MS_NS + MS_NS)
            if self.coming and self.coming[0][0] <= at:
                at, _, data = heappop(self.coming)
                self.now = max(self.now, at)
                if self.supplied:
                    self.twin.receive(data, max(self.tick(self.now), self.twin.now))
            else:
                self.now = max(self.now, at)
                if self.supplied:
                    self.twin.look_for_silence(max(self.tick(self.now), self.twin.now))
            self._collect()
            if self.now >= ns:
                return

    def _collect(self):
        data = self.twin.take()
        if data and self.supplied:
            self.free_up = max(self.free_up, self.now) + len(data) * BYTE_NS
            at = self.free_up + self.rnd.randrange(*self.latency_ns)
            if self.back:
                at = max(at, self.back[-1][0])
            self.back.append((at, self.damage(data)))

    # ----------------------------------------------------------------------------------------------------------- port
    def read(self):
        self.pass_to(self.now + 1)
        data = b""
        while self.back and self.back[0][0] <= self.now:
            data += self.back.pop(0)[1]
        return data

    def write(self, data):
        self.free_down = max(self.free_down, self.now + self.rnd.randrange(*self.latency_ns))
        for chunk in self.damage(data).split(b"\0")[:-1]:
            self.free_down += (len(chunk) + 1) * BYTE_NS
            heappush(self.coming, (self.free_down + self.rnd.randrange(5_000, 60_000), next(self.order), chunk + b"\0"))
            self.free_down = max([self.free_down, *(at for at, *_ in self.coming)])
        return len(data)

    def fileno(self):
        return None

    def close(self):
        self.closed = True

    # ---------------------------------------------------------------------------------------------------------- faults
    def reset_board(self):
        """A reset, or the supply off and on again: the board begins anew."""
        self.steps_before = list(self.twin.steps)
        self.coming.clear()
        inputs = self.twin.inputs
        self.twin = BoardTwin(self.model)
        self.twin.inputs = inputs
        self.began = self.now


class Pulses:
    """Where the pulses of a board have brought a motor, kept up from call to call."""

    def __init__(self):
        self.steps, self.counted, self.sum = None, 0, 0

    def __call__(self, twin):
        """Return the sum of the directions of all steps; a board that was reset begins at 0."""
        if twin.steps is not self.steps:
            self.steps, self.counted, self.sum = twin.steps, 0, 0
        while self.counted < len(self.steps):
            self.sum += self.steps[self.counted][1]
            self.counted += 1
        return self.sum


def drive_of(bench, x, line, **options):
    """A drive on a line."""
    options.setdefault("black_box", False)
    options.setdefault("pulses", True)
    return Drive(bench, x, line, clock=line.wall, wait=line.wait, **options)


def check_of(drive):
    """A check of a drive that is open, without an emergency stop."""
    return Check(drive._state, drive._path, drive._talk, drive.on_event, drive.turn, estop=False)


def check_steps(drive, line, missing=0):
    """Every step of the model that was due has been made, no other one, at its instant and in its direction."""
    steps = drive.chip.steps()
    wanted = (drive._path.ticks.many(steps.times_ps) >> 16) + drive._state.horizon
    made = np.array(line.twin.steps).reshape(-1, 3)
    count = len(made)
    assert int((wanted < line.twin.now - WITHIN).sum()) - missing <= count <= len(steps)
    assert count
    worst = np.abs(made[:, 0] - wanted[:count]).max()
    assert worst <= WITHIN, worst
    assert (made[:, 1] == steps.directions[:count]).all()
    return steps, made
