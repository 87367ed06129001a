"""Sessions on an emulated board in virtual time, and the facts that its pins show of them."""

from __future__ import annotations

from random import Random
from typing import TYPE_CHECKING, Any

import slewline
from slewline.drive.board import frames, wire
from slewline.drive.board.wire import ENABLE, FrameKind
from slewline.drive.step_drivers import STEP_DRIVERS

from .chain import HZ, MS_NS, EmulatedLine, drive_of, said
from .emulated import DIR

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from slewline.core.chip import Chip
    from slewline.drive.motor_drive import Drive

    from .emulated import EmulatedBoard, Emulator

OVERFLOW = 65_536  # ticks
ESTOP, HOLD = 5, 0  # inputs
AT_ONCE_TICKS = 1_600  # 100 us: from an edge of an emergency stop to D11
GSC = {"straps": {"chs": 0, "br0": 0, "br1": 0, "br2": 0}}


class HazardLine(EmulatedLine):
    """A line whose host may be interrupted, may sleep, and whose machine has switches that the motor moves.

    `switches` is called with the place of the motor, by STEP and the level of DIR (high: +), and returns the levels of
    inputs by number.
    """

    def __init__(self, emulator: Emulator, seed: int = 0, ppm: int = 300) -> None:
        super().__init__(emulator, seed, ppm)
        self.interrupt_at: int | None = None
        self.switches: Callable[[int], dict[int, int]] | None = None
        self.levels: dict[int, int] = {}
        self.place = self._counted = 0

    def wait(self, seconds: float) -> None:
        """Wait, or be interrupted as by SIGINT."""
        super().wait(seconds)
        if self.interrupt_at is not None and self.now >= self.interrupt_at:
            self.interrupt_at = None
            raise KeyboardInterrupt

    def pass_to(self, ns: int) -> None:
        """Let everything happen up to an instant of the host; switches follow within 200 us."""
        if self.switches is None:
            super().pass_to(ns)
            return
        while self.now < ns:
            super().pass_to(min(ns, self.now + MS_NS // 5))
            made, self._counted = len(self.board.rises) - self._counted, len(self.board.rises)
            self.place += made if self.board.ports and self.board.ports[-1][1] & DIR else -made
            for number, level in self.switches(self.place).items():
                self.set_input(number, level)

    def set_input(self, number: int, level: int, later: int = 50) -> int:
        """Set an input some ticks from now, if it has another level; return that tick."""
        tick = self.board.now + later
        if self.levels.get(number, 1) != level:
            self.levels[number] = level
            self.board.set_input(number, level, tick)
        return tick

    def leap(self, overflows: int) -> None:
        """Let host and board be so many times 65,536 ticks later; the processor does nothing meanwhile."""
        self.board.skip(overflows)
        self.now = self.ns(self.board.now) + 1000

    def sleep(self, seconds: float, emulated: float = 0.0) -> None:
        """Let the board alone live for some time: the host's clock does not run.

        Of that time so much is emulated; the rest is whole overflows of the timer, with 5 ms emulated in each minute.
        """
        end = self.board.now + int(seconds * HZ)
        self.board.run(self.board.now + int(emulated * HZ))
        while (left := (end - self.board.now) // OVERFLOW) > 0:
            self.board.skip(min(left, 60 * HZ // OVERFLOW))
            self.board.run(self.board.now + HZ // 200)
        self.began = self.now - (self.board.now * 10**9 * 1_000_000) // (HZ * (1_000_000 + self.ppm))
        self._collect()


class Trial:
    """A chip on a bench, its drive, and the board; not open yet.

    Args:
        part: of the chip; with options and what its host sends first.
        folder: for a journal, without which the drive cannot go back.
        line: that of a session before.
        options: of the drive.
    """

    def __init__(
        self,
        emulator: Emulator,
        part: str,
        chip: dict[str, Any],
        text: str,
        *,
        seed: int = 0,
        folder: Path | None = None,
        line: HazardLine | None = None,
        **options: Any,
    ) -> None:
        self.random = Random(f"{part} {seed}")
        self.bench = slewline.Bench(**({} if folder is None else {"journal": folder / "journal"}))
        x = self.bench.add(part, "x", **chip)
        self.bench.host(x, name="h", **({"over": "serial"} if part == "cy545" else {})).send(text)
        self.line = HazardLine(emulator, seed) if line is None else line
        if line is None and "estop" in options.get("inputs", {}).values():
            self.line.set_input(ESTOP, 0)
            self.line.stop_host(1)
        self.drive: Drive = drive_of(self.bench, x, self.line, **options)

    @property
    def x(self) -> Chip:
        """The chip of the present bench."""
        return self.drive.chip

    @property
    def board(self) -> EmulatedBoard:
        """The board."""
        return self.line.board

    def say(self, text: str, wait: str = "") -> bytes:
        """Let the host send a line; return what it receives within a time."""
        host = self.drive.bench["h"]
        before = len(host.received)
        host.send(text)
        if wait:
            self.drive.run(wait)
        return bytes(self.drive.bench["h"].received[before:])


def net(board: EmulatedBoard) -> int:
    """Return the place of the motor by STEP and DIR."""
    return sum(sign for _, sign in board.steps)


def enabling(driver: str) -> int:
    """Return the level of ENABLE at which a driver drives its motor, by its data sheet."""
    return next(row.enabled for row in STEP_DRIVERS.values() if row.name == driver)


def is_on(board: EmulatedBoard, driver: str) -> bool:
    """Return whether D11 drives the motor now."""
    return bool(board.enable) and board.enable[-1][1] == enabling(driver)


def powered(board: EmulatedBoard, driver: str) -> Iterator[tuple[int, int]]:
    """Yield the stretches in which D11 drives the motor: first and last tick."""
    since = None
    for tick, level in board.enable:
        if level == enabling(driver):
            since = tick if since is None else since
        elif since is not None:
            yield since, tick
            since = None
    if since is not None:
        yield since, 1 << 62


def edges_after_off(board: EmulatedBoard, driver: str) -> int:
    """Return how many edges STEP has had after D11 went off for the last time."""
    *_, (_, off) = powered(board, driver)
    return sum(tick > off for tick in board.rises)


def count(line: EmulatedLine) -> int:
    """Return the count of the board, as it was last on the line."""
    return said(line).position


def raw(line: EmulatedLine, kind: FrameKind, payload: bytes = b"") -> None:
    """Send a frame past the host, with the number that the board wants."""
    told = (wire.read(frames.decode(frame[:-1])) for _, frame in reversed(line.board.frames))  # type: ignore[arg-type]
    wanted = next((each.wanted for each in told if isinstance(each, wire.Answer)), 0)
    line.board.receive(wire.encode(wanted, kind, payload), line.board.now)
    line.stop_host(4)


def force_power(line: EmulatedLine) -> None:
    """Do all that a host can to switch the driver on: unlock, and ask for current."""
    raw(line, FrameKind.RESET, wire.reset_payload(None, known=True, power=True))
    raw(line, FrameKind.OUTPUTS, bytes((ENABLE, ENABLE)))
