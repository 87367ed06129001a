"""Commercial boards: their limits, and the purpose of each pin.

A board reports in its IDENT which row of `BOARDS` describes it.  Besides the messages of wire.py, the
host needs only this row.  The firmware has further requirements on the pins: STEP is OC1A, the output
of timer 1; `loop` is T0, the input of timer 0; the inputs are bits 0 to 5 of one port, all on one pin
change interrupt; the phases are the high half of one port; IN, OUT and SBIS can address the ports of
STEP and of the phases.

tests/firmware measures the limits of the Uno, in processor cycles.  They hold for every board with the
same timers, clock and instruction times; for a board whose interrupts or calls take longer, they must be
measured.
"""

from __future__ import annotations

from typing import NamedTuple

from ...errors import UsageError
from .wire import VERSION, Ident

BAUD = 500_000  # common to all boards: the port is opened before the board is known

FAST_TICKS = 640  # between steps: faster ones leave a board no time to brake at the next one
SOONEST_TICKS = 1200  # from an edge, or a pause, to a step: time for all the work that may come first
START_LEAD_TICKS, START_MOST_TICKS = 1600, 2**28  # from START to the first step; greatest distance of a start
LEAST_CHECK = 256  # ticks between the pulses of a self-test


class BoardPin(NamedTuple):
    """A board pin: the name printed next to it on the board, and its port and bit on the microcontroller."""

    printed: str
    port: str


class BoardModel(NamedTuple):
    """A kind of board with slewline firmware: its limits, and its pins by purpose.

    Values that a board reports itself (IDENT) take precedence.

    Attributes:
        number: the value of the board field in the board's IDENT.
        hz: the number of ticks per second.
        slots: the number of records that the queue holds.
        shortest: the minimum number of ticks between two steps.
        high, low: the minimum number of ticks for which STEP is high and low, at rates up to 45,000 steps/s.
        setup, hold: the minimum number of ticks for which DIR is stable before and after STEP rises.
    """

    number: int
    name: str
    title: str
    hz: int
    slots: int
    tail: int
    room: int
    shortest: int
    high: int
    low: int
    setup: int
    hold: int
    step: BoardPin
    dir: BoardPin
    enable: BoardPin
    phases: tuple[BoardPin, ...]
    outputs: tuple[BoardPin, ...]
    inputs: tuple[BoardPin, ...]
    led: BoardPin
    loop: BoardPin  # counts the pulses of a STEP that is wired to it, for the self-test

    def pin(self, printed: str) -> str | None:
        """Return the purpose of a pin ("step", "input 0"), given its printed name in upper or lower case.

        Return None if the pin has no purpose, or there is no such pin.
        """
        wanted = printed.upper()
        for purpose in ("step", "dir", "enable", "led"):
            if getattr(self, purpose).printed == wanted:
                return purpose
        for purpose in ("phases", "outputs", "inputs"):
            for number, pin in enumerate(getattr(self, purpose)):
                if pin.printed == wanted:
                    return f"phase {'ABCD'[number]}" if purpose == "phases" else f"{purpose[:-1]} {number}"
        return None


def _pins(*names: str) -> tuple[BoardPin, ...]:
    return tuple(BoardPin(*name.split("/")) for name in names)


UNO = BoardModel(  # a Nano has the same processor, pins and firmware
    number=1,
    name="uno",
    title="Arduino Uno (ATmega328P, 16 MHz)",
    hz=16_000_000,
    slots=64,
    tail=40,
    room=127,
    shortest=224,
    high=85,
    low=80,
    setup=320,
    hold=320,
    step=BoardPin("D9", "PB1"),
    dir=BoardPin("D10", "PB2"),
    enable=BoardPin("D11", "PB3"),
    phases=_pins("D4/PD4", "D5/PD5", "D6/PD6", "D7/PD7"),
    outputs=_pins("D2/PD2", "D3/PD3", "D8/PB0", "D12/PB4"),
    inputs=_pins("A0/PC0", "A1/PC1", "A2/PC2", "A3/PC3", "A4/PC4", "A5/PC5"),
    led=BoardPin("D13", "PB5"),
    loop=BoardPin("D4", "PD4"),
)


def by_number(*boards: BoardModel) -> dict[int, BoardModel]:
    """Return boards, keyed by number.

    Raises:
        ValueError: two boards have the same number.
    """
    found: dict[int, BoardModel] = {}
    for board in boards:
        other = found.setdefault(board.number, board)
        if other is not board:
            raise ValueError(
                f"boards {other.name} and {board.name}: both have number {board.number}; give each a different one"
            )
    return found


BOARDS = by_number(UNO)


def board_of(ident: Ident) -> BoardModel:
    """Return the row that describes a board, found by the board's IDENT.

    Raises:
        UsageError: the firmware does not have the version that this slewline needs, the board is unknown, or
            its clock differs from the one in its row.
    """
    if ident.version != VERSION:
        raise UsageError(
            f"the board has version {ident.version} of the firmware, but this slewline needs {VERSION}; write the "
            "firmware that came with this slewline to the board"
        )
    board = BOARDS.get(ident.board)
    if board is None:
        known = ", ".join(f"{number} ({each.title})" for number, each in BOARDS.items())
        raise UsageError(
            f"the board reports that it is board {ident.board}; known: {known}; write the firmware that came with this "
            "slewline to a board that is listed, or use the slewline that came with this firmware"
        )
    if ident.hz != board.hz:
        raise UsageError(f"the board has {ident.hz} ticks per second; expected {board.hz}, as for a {board.name}")
    return board
