"""The whole chain in virtual time: a chip on a bench, its drive, a line, and the firmware in an emulator."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import TYPE_CHECKING, Any

import numpy as np

from slewline.drive.board import frames, wire
from slewline.drive.board.boards import UNO
from slewline.drive.motor_drive import Drive

from .emulated import EmulatedBoard, Emulator

if TYPE_CHECKING:
    from slewline import Bench
    from slewline.core.chip import Chip

HZ = UNO.hz
MS_NS = 1_000_000
ONE_WAY_NS = (1 * MS_NS, 2_500_000)  # so a round trip is 2 to 5 ms, and the bytes on the line
TICKS_A_US = HZ / 1e6
WITHIN_TICKS = 9.6  # 0.6 us
Damage = Callable[[bytes], bytes]


def unharmed(data: bytes) -> bytes:
    """Return what a line carries that is in order."""
    return data


class EmulatedLine:
    """The port of an emulated board; the clock of its host stands unless somebody waits.

    Args:
        emulator: for the board.
        seed: of latencies and pauses.
        ppm: how much faster the crystal of the board is than the clock of the host.
        pauses: the probability that a wait of the host becomes a pause, and the longest one, in ms.
    """

    name = "emulated"

    def __init__(
        self,
        emulator: Emulator,
        seed: int = 0,
        ppm: int = 300,
        pauses: tuple[float, float] = (0, 0),
    ) -> None:
        self.random, self.ppm, self.pauses = Random(seed), ppm, pauses
        self.board, self.polarity = EmulatedBoard(emulator), 0
        self.now = self.began = 5_000_000_000  # ns of the host; of the board's power-up
        self.back: list[tuple[int, bytes]] = []  # on their way to the host: ns, bytes
        self.down_at = 0  # when the last bytes for the board arrive
        self.supplied, self.closed = True, False
        self.damage: Damage = unharmed
        self.carried = [0, 0]  # bytes, to the board and to the host
        self.lives: list[dict[str, Any]] = []  # what boards showed before their reset
        self.outside_s = 0.0

    # ----------------------------------------------------------------------------------------------------------- time
    def wall(self) -> int:
        """Return the nanoseconds of the host."""
        return self.now

    def tick(self, ns: int) -> int:
        """Return the tick of the board at an instant of the host."""
        return (ns - self.began) * HZ * (1_000_000 + self.ppm) // (10**9 * 1_000_000)

    def ns(self, tick: int) -> int:
        """Return the instant of the host at a tick of the board."""
        return self.began + tick * 10**9 * 1_000_000 // (HZ * (1_000_000 + self.ppm))

    def pass_to(self, ns: int) -> None:
        """Let everything happen up to an instant of the host."""
        if ns <= self.now:
            return
        self.now = ns
        if self.supplied and self.tick(ns) > self.board.now:
            self.board.run(self.tick(ns))
            self._collect()

    def _collect(self) -> None:
        new = self.board.frames[self.board._taken :]
        self.board.take()
        for tick, frame in new:
            self.carried[1] += len(frame)
            at = self.ns(tick) + self.random.randrange(*ONE_WAY_NS)
            self.back.append((max([at, *(at for at, _ in self.back[-1:])]), self.damage(frame)))

    def wait(self, seconds: float) -> None:
        """Wait for bytes of the board, for so long at most; or longer, if the host pauses."""
        until = self.now + max(int(seconds * 10**9), 1000)
        chance, most = self.pauses
        if chance and self.random.random() < chance:
            until += int(self.random.random() * most * MS_NS)
            self.pass_to(until)
        while self.now < until and not (self.back and self.back[0][0] <= self.now):
            self.pass_to(min([until, self.now + ONE_WAY_NS[0], *(at for at, _ in self.back[:1])]))

    def stop_host(self, milliseconds: float) -> None:
        """Let time pass while the host does nothing."""
        self.pass_to(self.now + int(milliseconds * MS_NS))

    # ----------------------------------------------------------------------------------------------------------- port
    def read(self) -> bytes:
        """Return what has come."""
        data = b""
        while self.back and self.back[0][0] <= self.now:
            data += self.back.pop(0)[1]
        return data

    def write(self, data: bytes) -> int:
        """Send bytes; they are on the line some time later."""
        self.down_at = max(self.down_at, self.now + self.random.randrange(*ONE_WAY_NS))
        self.carried[0] += len(data)
        if self.supplied:
            self.board.receive(self.damage(data), max(self.tick(self.down_at), self.board.now))
        return len(data)

    def fileno(self) -> None:
        """Return that nothing can be waited for."""

    def close(self) -> None:
        """Close it."""
        self.closed = True

    # ---------------------------------------------------------------------------------------------------------- faults
    def pull(self) -> None:
        """Take the supply away: the board and what is on the lines are gone."""
        self.supplied = False
        board = self.board
        self.lives.append({"rises": board.rises, "frames": board.frames})

    def supply(self) -> None:
        """Give it back: the board begins anew."""
        self.board.power_up()
        self.began, self.supplied = self.now, True

    def reset(self, loader_ms: float = 0) -> None:
        """Reset the board; a boot loader has it for some time."""
        self.pull()
        self.stop_host(loader_ms)
        self.supply()


def drive_of(bench: Bench, x: Chip, line: EmulatedLine, **options: Any) -> Drive:
    """A drive on a line; STEP has edges, unless an option says otherwise."""
    options = {"black_box": False, "self_start": True, "pulses": True, **options}
    drive = Drive(bench, x, line, clock=line.wall, wait=line.wait, **options)
    line.polarity = line.board.polarity = drive._state.config.polarity
    return drive


def wanted(drive: Drive) -> tuple[np.ndarray, np.ndarray]:
    """Return when the steps of the model are due at the board, in ticks and parts of them, and their directions."""
    steps = drive.chip.steps()
    return drive._path.ticks.many(steps.times_ps) / 65536 + drive._state.horizon, np.asarray(steps.directions)


def off(drive: Drive, line: EmulatedLine, missing: int = 0) -> np.ndarray:
    """Return by how many ticks each edge of STEP is off, once each step that is due was made, in its direction.

    `missing`: so many may be due and not made.
    """
    due, ways = wanted(drive)
    board = line.board
    made = np.array(board.rises)
    assert int((due < board.now - WITHIN_TICKS).sum()) - missing <= len(made) <= len(due)
    assert len(made)
    assert [way for _, way in board.steps] == ways[: len(made)].tolist()
    return made - due[: len(made)]


def dir_times(board: EmulatedBoard) -> tuple[int, int]:
    """Return the least set-up and hold time of DIR, in ticks: from a change to a step, and from a step to a change."""
    rises = np.array(board.rises)
    changes = np.array([tick for tick, _ in board.directions if rises[0] < tick < rises[-1]])
    if not len(changes):
        return 1 << 30, 1 << 30
    after = np.searchsorted(rises, changes)
    return int((rises[after] - changes).min()), int((changes - rises[after - 1]).min())


def pulse_widths(board: EmulatedBoard) -> tuple[int, int]:
    """Return the least and the greatest width of a STEP pulse, in ticks."""
    count = min(len(board.rises), len(board.falls))
    widths = np.array(board.falls[:count]) - np.array(board.rises[:count])
    return int(widths.min()), int(widths.max())


def low_time(board: EmulatedBoard) -> int:
    """Return the least time for which STEP is low between two pulses, in ticks."""
    return int((np.array(board.rises[1:]) - np.array(board.falls[: len(board.rises) - 1])).min())


def said(line: EmulatedLine) -> wire.Answer | wire.BoardEvent:
    """Return the last answer or event of a board, as it went out."""
    for _, frame in reversed(line.board.frames):
        last = wire.read(frames.decode(frame[:-1]))  # type: ignore[arg-type]
        if isinstance(last, wire.Answer | wire.BoardEvent):
            return last
    raise AssertionError("the board has said nothing")


def events(line: EmulatedLine) -> list[wire.BoardEvent]:
    """Return the events of a board, as they went out."""
    told = [wire.read(frames.decode(frame[:-1])) for _, frame in line.board.frames]  # type: ignore[arg-type]
    return [each for each in told if isinstance(each, wire.BoardEvent)]


def phase_lags(board: EmulatedBoard) -> tuple[np.ndarray, list[int]]:
    """Return how long after each step the phases have changed, in ticks, and what they are then.

    Raises:
        AssertionError: a step has no change of its own.
    """
    changes = [(tick, value) for tick, value in board.phases if tick > board.rises[0]]
    rises = np.array(board.rises)
    assert len(changes) == len(rises), (len(changes), len(rises))
    return np.array([tick for tick, _ in changes]) - rises, [value for _, value in changes]
