"""The bytes between a drive and its board: which board it is, the handshake, receiving, sending, and silence."""

from __future__ import annotations

from collections.abc import Callable
from select import select
from time import sleep
from typing import TYPE_CHECKING

from ..core.time.timebase import readable
from ..errors import UsageError
from .blackbox import reopen
from .board.boards import BAUD, BOARDS, BoardModel, board_of
from .board.wire import ENABLE, BoardState, Damaged, Decoder, FrameKind, Ident, PowerFlag, encode, read
from .driven import FoundBoard
from .stopping.troubles import MOVING, signed

if TYPE_CHECKING:
    from .board.port import BoardPort
    from .driven import Driven
    from .stopping.troubles import Troubles

TURN_S, IDLE_S, POLL_S = 0.005, 0.5, 0.001
SET_UP_S, SETTLE_S, FINISH_S = 3.0, 1.0, 1.0
WAY_DOWN_S = 20.0  # of a motion whose host is gone
SAMPLES = 8  # round trips before the clock of the board is believed
SILENT_NS = 500_000_000
HELLO_NS = 250_000_000  # between attempts to identify a board: its boot loader takes 1.6 s


class Talk:
    """Bytes of a drive to its board and back.

    Args:
        wait: what waits for seconds, or until bytes have come.
    """

    def __init__(self, drive: Driven, watch: Troubles, wait: Callable[[float], object] | None) -> None:
        self.drive, self.watch, self.wait = drive, watch, wait or self._wait
        self.nap = wait or sleep  # whatever comes meanwhile
        self._since_ns = 0  # the session goes on: whatever was unanswered before is not the board's silence
        self._silent = self._gone = False  # the board; its port

    # ----------------------------------------------------------------------------------------------------- each turn
    def begin(self) -> None:
        """Note that the board has just been heard."""
        self._since_ns, self._silent = self.drive.wall(), False

    def hear(self, now: int) -> None:
        """Take what the board has said; report that it is silent, once."""
        drive = self.drive
        try:
            data = b"" if self._gone else drive.port.read()
        except OSError as error:
            self._lost(error)
            return
        if data:
            self._silent = False
            drive.link.receive(data, now)
            self.watch.heard()
        elif drive.state != "closed" and not (self._silent or self._gone) and self._unanswered(now):
            self._silent = True
            self.watch.silent(readable(SILENT_NS * 1000))

    def _unanswered(self, now: int) -> bool:
        return min(self.drive.link.unanswered_ns(now), now - self._since_ns) > SILENT_NS

    def say(self, now: int) -> None:
        """Send what is to be sent."""
        data = self.drive.link.outgoing(now)
        if data and not self._gone:
            try:
                self.drive.port.write(data)
            except OSError as error:
                self._lost(error)

    def _lost(self, error: OSError) -> None:
        self._gone = True
        self.drive.port.close()  # or the system would give it another name when the cable is put back
        self.watch.port_lost(error)

    def reopen(self) -> None:
        """Open the port again, if it is gone.

        Raises:
            UsageError: it is still gone.
        """
        if self._gone:
            reopen(self.drive.port)
            self._gone = False
            self.drive.clock.restart()  # its supply comes through the cable

    def due(self) -> float:
        """Return in how many seconds the next turn is due at the latest, if nothing comes from outside before."""
        due, most = self.drive.link.due_ns(), IDLE_S if self.drive.link.at_rest else TURN_S
        return most if due is None else min(max(due - self.drive.wall(), 0) / 10**9, most)

    def _wait(self, seconds: float) -> None:
        number = self.drive.port.fileno()
        if number is None or self._gone:
            sleep(min(seconds, POLL_S))
        else:
            select([number], [], [], seconds)

    # ------------------------------------------------------------------------------------------------------ at length
    def until(self, met: Callable[[], bool], seconds: float, what: str) -> None:
        """Talk until something is so.

        Raises:
            UsageError: it does not come.
        """
        limit = self.drive.wall() + int(seconds * 10**9)
        while not self._comes(met):
            if self.drive.wall() > limit:
                raise UsageError(f"{what} within {seconds:g} s; {_heard(self.drive.port)}")
            self.wait(POLL_S)

    def _comes(self, met: Callable[[], bool]) -> bool:
        now = self.drive.wall()
        self.hear(now)
        self.say(now)
        return met()

    def finish(self) -> None:
        """Let the board take what it has been sent, for a second at most."""
        limit = self.drive.wall() + int(FINISH_S * 10**9)
        while not (self._gone or self._comes(lambda: self.drive.link.idle)) and self.drive.wall() < limit:
            self.wait(POLL_S)

    def set_up(self, position: int | None = None, *, known: bool = False, power: bool = False) -> FoundBoard:
        """Configure the board, and return what it was; a board that has a count keeps it.

        The driver is switched on last, once the board is known to be idle, or not at all.

        Args:
            position: the travel of the model that belongs to this count; None: its travel now.
            known: the user says that the motor is where the count says.
            power: the driver may be switched on.

        Raises:
            UsageError: nothing answers as a board, or another version of it; it does not leave its halt, or does not
                switch the driver on; its count is to be kept, and is not that of the motor.
        """
        drive, link = self.drive, self.drive.link
        link.open(drive.config)
        self.until(lambda: link.is_open, SET_UP_S, "no board answers")
        if link.ident is not None:
            self._check(link.ident)
        if moving := self._state() in MOVING:  # for a host that is gone
            link.stop(1)
            self.until(lambda: self._state() not in MOVING, WAY_DOWN_S, "the board does not stop")
            link.open(drive.config)
            self.until(lambda: link.is_open, SET_UP_S, "no board answers")
        answer, travel = link.answer, drive.axis.travel if position is None else position
        counted, flags = (answer.position, answer.flags) if answer is not None else (0, 0)
        found = FoundBoard(self._state(), counted, moving, bool(flags & PowerFlag.UNSURE) and not known)
        if drive.keep_count and found.unsure:
            raise UsageError(
                f"the count of the board, {counted}, is not to be kept (--keep-count): it made steps without current, "
                "or has switched the driver off by itself, so the motor may be elsewhere; home it, or say that it is "
                "there (--homed)"
            )
        # A new board counts from 0, as its chip does; another one goes on: its count is that of the motor.
        drive.count_origin = found.counted - travel
        power = power and drive.enable
        link.reset(signed(found.counted), known=known, power=power)
        drive.counted_from = travel - drive.feeder.net
        value = sum((net.level or 0) << number for net, number in drive.nets())
        mask = sum(1 << number for _, number in drive.nets())
        link.outputs(mask, value)
        self.until(lambda: link.is_open and link.idle, SETTLE_S, "the board does not take its configuration")
        if self._state() != BoardState.IDLE:
            raise UsageError(
                "the board does not leave its halt: the input of an emergency stop is active; close its contact, then "
                "clear the drive"
            )
        if power:
            link.outputs(ENABLE, ENABLE)
            self.until(lambda: link.idle, SETTLE_S, "the board does not answer")
            if not drive.power.on:
                raise UsageError(
                    "the board does not switch the driver on: the input of an emergency stop is active; close its "
                    "contact, then begin again"
                )
        for _ in range(SAMPLES):
            link.ask()
            before = link.answer
            self.until(lambda: link.answer is not before, SETTLE_S, "the board does not answer")  # noqa: B023
        return found

    def _state(self) -> int:
        """The state of the board in its last answer."""
        answer = self.drive.link.answer
        return BoardState.BOOT if answer is None else answer.state

    def _check(self, ident: Ident) -> None:
        """Check that the board is still the one that was there when the drive was made."""
        drive, board = self.drive, board_of(ident)
        if board is not drive.board:
            raise UsageError(f"the board is an {board.title} now, and was an {drive.board.title}; make a new drive")
        drive.feeder.shortest = ident.shortest


def identified(port: BoardPort, wall: Callable[[], int], wait: Callable[[float], object] = sleep) -> BoardModel:
    """Return which board is on a port; it is not configured yet, and a motion goes on.

    Args:
        wall: returns the nanoseconds of the wall clock.
        wait: waits for a number of seconds.

    Raises:
        UsageError: no board answers, or it is not one that this version knows.
    """
    decoder, begun, hellos = Decoder(), wall(), 0
    while (passed := wall() - begun) <= SET_UP_S * 10**9:
        try:
            if passed >= hellos * HELLO_NS:
                port.write(encode(0, FrameKind.HELLO))  # 0: no number of a link
                hellos += 1
            data = port.read()
        except OSError as error:
            raise UsageError(f"the port of the board is gone: {error.strerror or error}") from None
        for frame in decoder.feed(data):
            found = None if isinstance(frame, Damaged) else read(frame)
            if isinstance(found, Ident):
                return board_of(found)
        wait(POLL_S)
    raise UsageError(f"no board answers within {SET_UP_S:g} s; {_heard(port)}")


def _heard(port: BoardPort) -> str:
    """Return what has been received, and what was expected."""
    data = bytes(getattr(port, "heard", b""))
    received = f"heard {len(data)} bytes, {data[:16].hex(' ')}" if data else "heard nothing"
    titles = " or ".join(f"an {board.title}" for board in BOARDS.values())
    return f"{received}; expected the firmware of slewline on {titles}, at {BAUD} baud"
