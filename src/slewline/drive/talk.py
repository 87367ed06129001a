"""The communication between a drive and its board: identification, handshake, receiving, sending, and silence."""

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
from .drive_state import FoundBoard
from .stopping.findings import signed
from .stopping.troubles import MOVING

if TYPE_CHECKING:
    from .board.board_port import BoardPort
    from .drive_state import DrivePath, DriveState
    from .power import Power
    from .stopping.troubles import Troubles

TURN_S, IDLE_S, POLL_S = 0.005, 0.5, 0.001
SET_UP_S, SETTLE_S, FINISH_S = 3.0, 1.0, 1.0
UNANSWERED = "; check the port, and the firmware of the board (make boards builds it, avrdude writes it)"
RAMP_DOWN_S = 20.0  # time allowed for a motion whose host is gone
SAMPLES = 8  # round trips before the clock of the board is trusted
SILENT_NS = 500_000_000
HELLO_NS = 250_000_000  # time between attempts to identify a board: its boot loader takes 1.6 s


class Talk:
    """The exchange of bytes between a drive and its board.

    Args:
        wait: waits for a number of seconds, or until bytes have arrived.
    """

    def __init__(
        self,
        state: DriveState,
        path: DrivePath,
        port: BoardPort,
        power: Power,
        watch: Troubles,
        wait: Callable[[float], object] | None,
    ) -> None:
        self.state, self.port, self.power, self.watch, self.wait = state, port, power, watch, wait or self._wait
        self.wall, self.clock, self.link, self.feeder = path.wall, path.clock, path.link, path.feeder
        self.nap = wait or sleep  # whatever comes meanwhile
        self._since_ns = 0  # start of the session: earlier unanswered frames do not count as silence
        self._silent = self._gone = False  # the board; its port

    # ----------------------------------------------------------------------------------------------------- each turn
    def begin(self) -> None:
        """Record that the board has just answered."""
        self._since_ns, self._silent = self.wall(), False

    def receive(self, now: int) -> None:
        """Receive bytes from the board; report once if the board is silent."""
        try:
            data = b"" if self._gone else self.port.read()
        except OSError as error:
            self._lost(error)
            return
        if data:
            self._silent = False
            self.link.receive(data, now)
            self.watch.note_message()
        elif self.state.phase != "closed" and not (self._silent or self._gone) and self._unanswered(now):
            self._silent = True
            self.watch.silent(readable(SILENT_NS * 1000))

    def _unanswered(self, now: int) -> bool:
        return min(self.link.unanswered_ns(now), now - self._since_ns) > SILENT_NS

    def send(self, now: int) -> None:
        """Send pending bytes."""
        data = self.link.outgoing(now)
        if data and not self._gone:
            try:
                self.port.write(data)
            except OSError as error:
                self._lost(error)

    def _lost(self, error: OSError) -> None:
        self._gone = True
        self.port.close()  # or the system would assign another name when the cable is reconnected
        self.watch.port_lost(error)

    def reopen(self) -> None:
        """Reopen the port if it is gone.

        Raises:
            UsageError: the port is still gone.
        """
        if self._gone:
            reopen(self.port)
            self._gone = False
            self.clock.restart()  # the cable supplies the board

    def due(self) -> float:
        """Return the number of seconds until the next turn is due, unless an external input comes first."""
        due, most = self.link.due_ns(), IDLE_S if self.link.at_rest else TURN_S
        return most if due is None else min(max(due - self.wall(), 0) / 10**9, most)

    def _wait(self, seconds: float) -> None:
        number = self.port.fileno()
        if number is None or self._gone:
            sleep(min(seconds, POLL_S))
        else:
            select([number], [], [], seconds)

    # ------------------------------------------------------------------------------------------------------ at length
    def until(self, met: Callable[[], bool], seconds: float, what: str, remedy: str = "") -> None:
        """Send and receive until `met` returns True.

        Raises:
            UsageError: `met` does not return True within `seconds`; `what` begins the message, `remedy` ends it.
        """
        limit = self.wall() + int(seconds * 10**9)
        while not self._comes(met):
            if self.wall() > limit:
                raise UsageError(f"{what} within {seconds:g} s; {_received_text(self.port)}{remedy}")
            self.wait(POLL_S)

    def _comes(self, met: Callable[[], bool]) -> bool:
        now = self.wall()
        self.receive(now)
        self.send(now)
        return met()

    def finish(self) -> None:
        """Let the board take all pending commands, for at most a second."""
        limit = self.wall() + int(FINISH_S * 10**9)
        while not (self._gone or self._comes(lambda: self.link.idle)) and self.wall() < limit:
            self.wait(POLL_S)

    def set_up(self, position: int | None = None, *, known: bool = False, power: bool = False) -> FoundBoard:
        """Configure the board, and return its former state; a board that has a count keeps it.

        The driver is switched on last, once the board is known to be idle, or not at all.

        Args:
            position: the model's travel that corresponds to the board's count; None: the model's present travel.
            known: the user confirms that the count is the position of the motor.
            power: the driver may be switched on.

        Raises:
            UsageError: no board answers, or the board has another version or model than expected; it remains
                halted, or does not switch the driver on; its count is to be kept, but the motor's position is
                uncertain.
        """
        found = self._shake_hands(known)
        if self.state.keep_count and found.unsure:
            raise UsageError(
                f"the count of the board, {found.counted}, cannot be kept (--keep-count): steps were output without "
                "current, or the board has switched the driver off by itself, so the position is uncertain; home "
                "the motor, or confirm the count with --homed"
            )
        # A new board counts from 0, as its chip does; another one continues: its count is that of the motor.
        travel = self.state.axis.travel if position is None else position
        self.state.count_from(found.counted, travel, self.feeder.net)
        power = power and self.state.enable
        self._leave_halt(found.counted, known=known, power=power)
        if power:
            self._switch_on()
        self._synchronise()
        return found

    def _shake_hands(self, known: bool) -> FoundBoard:
        """Send the configuration to a board, and return its former state; stop a motion that an earlier host began."""
        link = self.link
        self._open()
        if link.ident is not None:
            self._check(link.ident)
        if moving := self._state() in MOVING:
            link.stop(1)
            self.until(lambda: self._state() not in MOVING, RAMP_DOWN_S, "the board does not stop")
            self._open()
        counted, flags = (0, 0) if link.answer is None else (link.answer.position, link.answer.flags)
        return FoundBoard(self._state(), counted, moving, bool(flags & PowerFlag.UNSURE) and not known)

    def _open(self) -> None:
        self.link.open(self.state.config)
        self.until(lambda: self.link.is_open, SET_UP_S, "no board answers", UNANSWERED)

    def _leave_halt(self, counted: int, *, known: bool, power: bool) -> None:
        """Make the board leave its halted state and continue counting from `counted`, and set its outputs."""
        link, nets = self.link, self.state.nets()
        link.reset(signed(counted), known=known, power=power)
        value = sum((net.level or 0) << number for net, number in nets)
        link.outputs(sum(1 << number for _, number in nets), value)
        self.until(lambda: link.is_open and link.idle, SETTLE_S, "the board does not accept its configuration")
        if self._state() != BoardState.IDLE:
            raise UsageError(
                "the board remains halted: an emergency stop is active; close its contact, then clear the drive"
            )

    def _switch_on(self) -> None:
        """Switch the driver on."""
        self.link.outputs(ENABLE, ENABLE)
        self.until(lambda: self.link.idle, SETTLE_S, "the board does not answer")
        if not self.power.on:
            raise UsageError(
                "the board does not switch the driver on: an emergency stop is active; close its "
                "contact, then start again"
            )

    def _synchronise(self) -> None:
        """Measure a few round trips, to synchronise with the board's clock."""
        link = self.link
        for _ in range(SAMPLES):
            link.ask()
            before = link.answer
            self.until(lambda: link.answer is not before, SETTLE_S, "the board does not answer")  # noqa: B023

    def _state(self) -> int:
        """Return the state that the board reported in its last answer."""
        answer = self.link.answer
        return BoardState.BOOT if answer is None else answer.state

    def _check(self, ident: Ident) -> None:
        """Check that the board is still of the model for which the drive was created."""
        board, was = board_of(ident), self.state.board
        if board is not was:
            raise UsageError(f"the board is now an {board.title}, but was an {was.title}; make a new drive")
        self.feeder.shortest = ident.shortest


def identified(port: BoardPort, wall: Callable[[], int], wait: Callable[[float], object] = sleep) -> BoardModel:
    """Return the model of the board on a port, without configuring the board or stopping a motion in progress.

    Args:
        wall: returns the wall-clock time in nanoseconds.
        wait: waits for a number of seconds.

    Raises:
        UsageError: no board answers, or this version does not support the board.
    """
    decoder, begun, hellos = Decoder(), wall(), 0
    while (passed := wall() - begun) <= SET_UP_S * 10**9:
        try:
            if passed >= hellos * HELLO_NS:
                port.write(encode(0, FrameKind.HELLO))  # 0 is not a number of a link
                hellos += 1
            data = port.read()
        except OSError as error:
            raise UsageError(f"the port of the board is gone: {error.strerror or error}") from None
        for frame in decoder.feed(data):
            found = None if isinstance(frame, Damaged) else read(frame)
            if isinstance(found, Ident):
                return board_of(found)
        wait(POLL_S)
    raise UsageError(f"no board answers within {SET_UP_S:g} s; {_received_text(port)}{UNANSWERED}")


def _received_text(port: BoardPort) -> str:
    """Return a text that states the bytes received, and the firmware and boards expected."""
    data = bytes(getattr(port, "received", b""))
    received = f"received {len(data)} bytes, {data[:16].hex(' ')}" if data else "received nothing"
    titles = " or ".join(f"an {board.title}" for board in BOARDS.values())
    return f"{received}; expected the firmware of slewline on {titles}, at {BAUD} baud"
