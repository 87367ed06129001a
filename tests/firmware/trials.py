"""What trials of a real motor are made of: chips in motion on an emulated board, whose pins are the witness."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from random import Random
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import slewline
from slewline.drive.board import frames, wire
from slewline.drive.board.boards import UNO
from slewline.drive.board.wire import FrameKind
from slewline.drive.step_drivers import STEP_DRIVERS
from slewline.errors import UsageError
from tests.drive.families import GSC

from .chain import EmulatedLine, drive_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from slewline.drive.motor_drive import Drive

    from .emulated import EmulatedBoard, Emulator

HZ = UNO.hz
DRIVERS = ("A4988", "DM542", "L297")
SET_UP = 320  # ticks: 20 us, for which DIR is there before an edge of STEP
OFF_WITHIN = 1_600  # ticks from the edge of an emergency stop to ENABLE: 100 us


class Family(NamedTuple):
    """A motion of a part that goes on for some time.

    `first`: what is sent before the first move; `move`: returns the text of a move by a number of steps, which begins
    where the moves before have ended; `long`: a long motion; `span`: when it is in motion for certain, ms.
    """

    part: str
    options: dict[str, Any]
    first: str
    move: Callable[[int, int], str]
    long: str
    span: tuple[int, int]


def signed_move(steps: int, _at: int) -> str:
    """Return a move of a part that takes direction, number and GO."""
    return f"{'+' if steps > 0 else '-'}\rN {abs(steps)}\rG\r"


FAMILIES = {
    "gs-c200s": Family(
        "gs-c200s",
        GSC,
        "I3\rPo\rS50\rT300\rR90\rPx\rE\r",
        lambda steps, _: f"Po\r{steps:+d}\rPx\rE\r",
        "Po\rS100\rT1000\rR255\r+8000\rPx\rE\r",
        (300, 900),
    ),
    "cy525": Family(
        "cy525",
        {},
        "A 0\rF 40\rR 90\rS 200\rZ 1\r",
        signed_move,
        "A 0\rF 10\rR 120\rS 120\rZ 1\rN 9000\rG\r",
        (300, 900),
    ),
    "cy512": Family("cy512", {}, "A\rF 1\rR 200\rS 40\r", signed_move, "A\rF 1\rR 200\rS 40\rN 3000\rG\r", (300, 700)),
    "cy545": Family(
        "cy545", {}, "F 100\rR 150\rS 150\r", signed_move, "F 50\rR 150\rS 150\r+\rN 4000\rG\r", (300, 900)
    ),
    "mc1451a": Family(
        "mc1451a",
        {},
        "SET_VEL 1000 steps/s\nSET_ACC 20000 steps/s2\nUPDATE\n",
        lambda steps, at: f"SET_POS {at + steps}\nUPDATE\n",
        "SET_VEL 30000 steps/s\nSET_ACC 60000 steps/s2\nSET_POS 90000\nUPDATE\n",
        (300, 900),
    ),
    "cy500": Family("cy500", {}, "A\rR 240\rF 1\r", signed_move, "A\rR 240\rF 1\rN 900\rG\r", (250, 600)),
}


@dataclass
class Trial:
    """A chip, its drive, and an emulated board whose six inputs are pulled up or, as emergency stops, closed."""

    bench: slewline.Bench
    line: EmulatedLine
    drive: Drive
    family: Family
    driver: str | None

    @property
    def board(self) -> EmulatedBoard:
        """The board."""
        return self.line.board

    @property
    def x(self) -> Any:
        """The chip, of whichever bench is the present one."""
        return self.drive.chip

    @property
    def on(self) -> int:
        """The level of D11 that enables the driver."""
        assert self.driver
        return STEP_DRIVERS[self.driver].enabled

    @property
    def edges(self) -> int:
        """How far the edges of STEP have brought the motor."""
        return sum(self.drive_way(level) for level in levels_at_edges(self.board))

    def drive_way(self, level: int) -> int:
        """The direction that a level of DIR means."""
        return 1 if level == self.line.polarity & 1 else -1

    def send(self, text: str) -> None:
        """Let the host say something."""
        self.drive.bench["h"].send(text)

    def set_input(self, number: int, level: int, later: int = 40) -> int:
        """Change an input of the board in so many ticks; return the tick."""
        tick = self.board.now + later
        self.board.set_input(number, level, tick)
        return tick

    def is_on(self) -> bool:
        """Whether the driver has current, by D11."""
        return bool(self.board.enable) and self.board.enable[-1][1] == self.on


def prepared(
    emulator: Emulator,
    name: str,
    seed: int = 0,
    *,
    driver: str | None = "A4988",
    text: str | None = None,
    closed: tuple[int, ...] = (),
    journal: Any = None,
    on: EmulatedLine | None = None,
    **options: Any,
) -> Trial:
    """Return a trial of a family, whose host sends a text at the beginning; None: that of its long motion.

    `closed`: inputs that are closed to ground; `on`: a line to a board that has been used before.
    """
    family = FAMILIES[name]
    bench = slewline.Bench(**({} if journal is None else {"journal": journal}))
    x = bench.add(family.part, "x", **family.options)
    over = {"over": "serial"} if family.part == "cy545" else {}
    bench.host(x, name="h", **over).send(family.long if text is None else text)
    line = on or EmulatedLine(emulator, seed)
    if on is None:
        for number in closed:
            line.board.set_input(number, 0, 0)
        line.stop_host(1)
    if driver is not None and "enable" not in options:
        options["enable"] = True
    return Trial(bench, line, drive_of(bench, x, line, driver=driver, **options), family, driver)


# ------------------------------------------------------------------------------------------------------------- the pins
def levels_at_edges(board: EmulatedBoard) -> list[int]:
    """Return the level of DIR at each edge of STEP."""
    changes, out, at, level = board.directions, [], 0, 0
    for tick in board.rises:
        while at < len(changes) and changes[at][0] <= tick:
            level, at = changes[at][1], at + 1
        out.append(level)
    return out


def least_set_up(board: EmulatedBoard) -> int:
    """Return for how many ticks, at least, DIR has had its level when STEP rose."""
    changes = np.array([tick for tick, _ in board.directions])
    rises = np.array(board.rises)
    before = np.searchsorted(changes, rises, side="right") - 1
    return int((rises - changes[np.maximum(before, 0)])[before >= 0].min(initial=1 << 40))


def edges_after(board: EmulatedBoard, tick: int) -> int:
    """Return how many edges of STEP came after a tick."""
    return len(board.rises) - int(np.searchsorted(np.array(board.rises), tick, side="right"))


def spans_on(board: EmulatedBoard, on: int) -> list[tuple[int, int]]:
    """Return from when to when D11 had the level that enables."""
    changes = [*board.enable, (board.now, None)]
    return [(since, until) for (since, level), (until, _) in pairwise(changes) if level == on]


class Followed:
    """What a pin of a chip has shown, by the time of the model."""

    def __init__(self, bench: slewline.Bench, pin: Any) -> None:
        self.bench, self.net = bench, pin.net
        self.shown: list[tuple[int, int]] = [(-1, self.net.level or 0)]
        self.net.watch(lambda net: self.shown.append((bench.now_ps, net.level or 0)))

    def at(self, times: Any) -> list[int]:
        """Return the levels at instants of the model (ps)."""
        since = np.array([ps for ps, _ in self.shown])
        return [self.shown[at][1] for at in np.searchsorted(since, np.asarray(times), side="right") - 1]


def moves(rnd: Random, count: int) -> list[int]:
    """Return signed numbers of steps, with turns."""
    return [rnd.choice((-1, 1)) * rnd.randrange(1, 25) for _ in range(count)]


# ----------------------------------------------------------------------------------------------------- past the session
def past_the_host(line: EmulatedLine, kind: FrameKind, payload: bytes = b"") -> None:
    """Send a frame of which the session knows nothing, with the number that the board takes next."""
    number = 0
    for _, frame in line.board.frames:
        answer = wire.read(frames.decode(frame[:-1]))  # type: ignore[arg-type]
        if isinstance(answer, wire.Answer):
            number = answer.wanted
    line.write(wire.encode(number, kind, payload))


class Sessions:
    """A user who does this and that, session after session, at a board whose emergency stop opens and closes.

    Attributes:
        opened: ticks from when to when the contact was open.
        begun, refused: how many sessions began, and how often something was refused.
    """

    ESTOP = 5
    DEEDS = (
        "contact", "contact", "clear", "clear homed", "clear homing", "start", "start", "home", "stop", "close",
        "outputs", "frames", "frames", "wait",
    )  # fmt: skip

    def __init__(self, emulator: Emulator, seed: int) -> None:
        self.emulator, self.random = emulator, Random(f"sessions {seed}")
        self.name = self.random.choice(["gs-c200s", "cy525", "cy545", "mc1451a"])
        self.driver, self.policy = self.random.choice(DRIVERS), self.random.choice(["halt", "never", "rest"])
        self.line = EmulatedLine(emulator, seed)
        self.is_open = self.random.random() < 0.2
        self.line.board.set_input(self.ESTOP, int(self.is_open), 0)
        self.line.stop_host(1)
        self.opened: list[list[int]] = [[0, 1 << 60]] if self.is_open else []
        self.trial: Trial | None = None
        self.begun = self.refused = 0

    def live(self, count: int) -> None:
        """Do so many things, one after the other."""
        for _ in range(count):
            try:
                if self.trial is None:
                    self._begin()
                else:
                    self._do(self.random.choice(self.DEEDS))
            except UsageError:
                self.refused += 1
                if self.trial is not None and self.trial.drive.state == "closed":
                    self.trial = None
            if self.trial is None:
                self.line.stop_host(self.random.randrange(1, 40))
        if self.trial is not None:
            self.trial.drive.close()
        self.line.stop_host(1_500)  # the board itself switches off, if frames of others have confused the session

    def _begin(self) -> None:
        rnd = self.random
        self.trial = prepared(
            self.emulator, self.name, driver=self.driver, text=FAMILIES[self.name].first, on=self.line,
            enable_off=self.policy, enable_hold="300 ms", inputs={f"A{self.ESTOP}": "estop"},
            homed=rnd.random() < 0.5, filter=rnd.choice((0, 15)),
        )  # fmt: skip
        self.trial.drive.open()
        self.begun += 1

    def _do(self, deed: str) -> None:
        trial, rnd = self.trial, self.random
        assert trial is not None
        drive = trial.drive
        if deed == "contact":
            self.is_open = not self.is_open
            later = rnd.randrange(40, 60_000)
            if self.opened:  # one after the other
                before = max(tick for tick in self.opened[-1] if tick < 1 << 60)
                later = max(later, before + 4_000 - trial.board.now)
            tick = trial.set_input(self.ESTOP, int(self.is_open), later)
            if self.is_open:
                self.opened.append([tick, 1 << 60])
            else:
                self.opened[-1][1] = tick
        elif deed.startswith("clear"):
            drive.clear(homed="homed" in deed, homing="homing" in deed)
        elif deed == "start":
            trial.send(trial.family.move(rnd.choice((-300, -3, 5, 400)), 0))
        elif deed == "home":
            trial.send("Px\rE\rH+\r" if self.name == "gs-c200s" else "")
        elif deed == "stop":
            drive.stop(at_once=rnd.random() < 0.5)
        elif deed == "close":
            drive.close()
            self.trial = None
            return
        elif deed == "outputs":
            drive._path.link.outputs(wire.ENABLE, wire.ENABLE)
        elif deed == "frames":
            known, power = rnd.random() < 0.5, rnd.random() < 0.5
            if rnd.random() < 0.5:
                past_the_host(self.line, FrameKind.RESET, wire.reset_payload(None, known=known, power=power))
                drive.run("5 ms")
            past_the_host(self.line, FrameKind.OUTPUTS, bytes((wire.ENABLE, wire.ENABLE)))
        drive.run(f"{rnd.randrange(1, 150)} ms")
