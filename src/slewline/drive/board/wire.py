"""The messages between host and board: their fields, their payloads, and the numbers that stand for kinds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from struct import Struct
from typing import NamedTuple

from ...errors import UsageError
from .frames import Damaged, Decoder, Frame, crc, encode, stuff, unstuff

__all__ = ["Damaged", "Decoder", "Frame", "crc", "encode", "stuff", "unstuff"]  # one module for the whole wire

RECORD_BYTES, RECORDS_A_FRAME = 13, 5
ENTRIES_A_FRAME = 10  # of a tail
VERSION = 2  # of the messages: that of the firmware
INPUTS, PHASES = 6, 8
USER_OUTPUTS, ENABLE = 15, 16  # bits of the outputs
UP_IS_HIGH, ENABLE_LOW = 1, 2  # bits of the polarity
HOST = 255  # `which` of an event that no input caused
ENTRY_BYTES = 6  # of a tail


class FrameKind(IntEnum):
    """Kinds of frames: numbers below 0x80 are sent by the host, 0x80 and above by the board."""

    HELLO = 1
    PUSH = 2
    START = 3
    STOP = 4
    CONFIG = 5
    ASK = 6
    TAIL = 7
    RESET = 8
    OUTPUTS = 9
    REPEAT = 10
    CHECK = 11
    ANSWER = 0x80
    IDENT = 0x81
    EVENT = 0x82


# Taken only in order; other frames carry any number, a token that comes back with the answer.
NUMBERED = frozenset(
    (
        FrameKind.PUSH,
        FrameKind.START,
        FrameKind.CONFIG,
        FrameKind.TAIL,
        FrameKind.RESET,
        FrameKind.OUTPUTS,
        FrameKind.CHECK,
    )
)


class BoardState(IntEnum):
    """States of a board; only RESET leaves HALT, and only CONFIG leaves BOOT, the state at power-up."""

    IDLE = 0
    RUN = 1
    BRAKE = 2
    HALT = 3
    BOOT = 4


class Happening(IntEnum):
    """Kinds of events on a board."""

    REST = 1
    UNDERRUN = 2
    HALTED = 3
    STOPPED = 4
    BRAKED = 5
    MARK = 6
    INPUT = 7
    LATE = 8
    WATCHDOG = 9
    ESTOP = 10
    BOOT = 11
    CHECKED = 12


class FrameResult(IntEnum):
    """Results of a frame sent to the board; only a frame that is accepted (TAKEN) uses up its frame number."""

    TAKEN = 0
    DAMAGED = 1
    WRONG_NUMBER = 2
    NO_ROOM = 3
    WRONG_STATE = 4
    BAD_CONTENT = 5
    LATE = 6


class Reflex(IntEnum):
    """Immediate reactions of a board to an active input; STOP and BRAKE may be limited to UPWARDS or DOWNWARDS."""

    NONE = 0
    STOP = 1
    BRAKE = 2
    MARK = 3
    ESTOP = 4
    UPWARDS = 16
    DOWNWARDS = 32


class DriverFlag(IntEnum):
    """Properties of the driver."""

    ENABLE = 1  # the ENABLE input is wired, and its active level is known
    DRY = 2  # this is a dry run, without edges on STEP


class EnableOff(IntEnum):
    """Conditions under which a board switches the driver off by itself; in an emergency stop it always does so."""

    NEVER = 0
    HALT = 1
    REST = 2


class ResetFlag(IntEnum):
    """Flags of RESET."""

    POSITION = 1  # the frame sets the count
    KNOWN = 2  # the count is the motor's position
    POWER = 4  # the driver may be switched on again


class PowerFlag(IntEnum):
    """Flags of ANSWER that describe the driver."""

    ENERGISED = 1
    ESTOP = 2
    # The count may differ from the motor's position, after steps without current, a stop without a ramp, or a
    # switch-off by the board itself.
    UNSURE = 4
    LOCKED = 8  # from power-up, or a switch-off by the board, the driver cannot be switched on until a RESET unlocks it


class Answer(NamedTuple):
    """The result of a frame from the host, and the board's state when it took the frame, at `tick` (mod 2^32)."""

    wanted: int
    echo: int
    kind: int
    result: int
    free: int
    state: int
    events: int
    inputs: int
    flags: int  # PowerFlag
    position: int
    tick: int


class BoardEvent(NamedTuple):
    """An event on a board."""

    number: int  # counted from power-up
    kind: int
    which: int  # the number of the input that caused the event; 255 if no input did
    state: int
    inputs: int
    position: int
    tick: int


class Ident(NamedTuple):
    """The properties of a board."""

    wanted: int
    version: int
    board: int
    slots: int  # the number of records that its queue holds
    tail: int  # the number of entries that its stop ramp holds
    room: int  # the maximum total length of unanswered frames, in bytes
    shortest: int  # the shortest interval between steps, in ticks
    hz: int  # the number of ticks per second


_ANSWER, _EVENT, _IDENT = Struct("<BBBBBBBBiI"), Struct("<BBBBiI"), Struct("<BBBBBHI")
_START, _RESET, _OUTPUTS, _CHECK, _ENTRY = Struct("<I"), Struct("<Bi"), Struct("<BB"), Struct("<HH"), Struct("<IH")
_CONFIG = Struct("<IIBBBBBHBB6s8sB")
SIZES = {  # sizes of the payloads that have a fixed size
    FrameKind.HELLO: 0,
    FrameKind.START: _START.size,
    FrameKind.STOP: 1,
    FrameKind.CONFIG: _CONFIG.size,
    FrameKind.ASK: 0,
    FrameKind.RESET: _RESET.size,
    FrameKind.OUTPUTS: _OUTPUTS.size,
    FrameKind.REPEAT: 1,
    FrameKind.CHECK: _CHECK.size,
    FrameKind.ANSWER: _ANSWER.size,
    FrameKind.IDENT: _IDENT.size,
    FrameKind.EVENT: _EVENT.size,
}


MOST = {  # of the numbers of CONFIG
    "start_stop": 2**31 - 1,
    "watchdog": 2**31 - 1,
    "polarity": 3,
    "active": 63,
    "report": 63,
    "driver": 3,
    "enable_off": 2,
    "enable_hold": 2**16 - 1,
    "filter": 15,
    "fault_output": 4,
    "power_output": 4,
    "phase": 7,
}


@dataclass(frozen=True, slots=True)
class BoardConfig:
    """The configuration of a board; times are in its ticks.

    Attributes:
        polarity: the sum of 1 if DIR is high for upward steps, and 2 if ENABLE is active low.
        active: bit n is set if input n is active when high.
        report: bit n is set if each edge of input n is reported.
        driver: the properties of the driver, a DriverFlag.
        enable_off: the condition under which the board switches the driver off by itself, an EnableOff.
        enable_hold: how long this condition must last, in units of 65,536 ticks.
        filter: the number of samples, 4 us apart, for which an input must be unchanged before it counts; an
            emergency stop is not filtered.
        fault_output: the number + 1 of the output that shows a halt; 0 if there is none.
        power_output: the number + 1 of the output that shows the driver current; 0 if there is none.
        reflex: for each input, its `Reflex`.
        pattern: for each half-step index, the phases A to D in bits 0 to 3; all zero without phases.
        phase: the current half-step index.
    """

    start_stop: int
    watchdog: int = 0
    polarity: int = 1
    active: int = 0
    report: int = 0
    driver: int = DriverFlag.DRY
    enable_off: int = EnableOff.HALT
    enable_hold: int = 0
    filter: int = 0
    fault_output: int = 0
    power_output: int = 0
    reflex: tuple[int, ...] = (0,) * INPUTS
    pattern: tuple[int, ...] = (0,) * PHASES
    phase: int = 0

    def pack(self) -> bytes:
        """Return the payload of CONFIG.

        Raises:
            UsageError: a field is out of its range.
        """
        self.check()
        return _CONFIG.pack(
            self.start_stop,
            self.watchdog,
            self.polarity,
            self.active,
            self.report,
            self.driver,
            self.enable_off,
            self.enable_hold,
            self.filter,
            self.fault_output | self.power_output << 4,
            bytes(self.reflex),
            bytes(self.pattern),
            self.phase,
        )

    @classmethod
    def unpack(cls, payload: bytes) -> BoardConfig:
        """Return the configuration in a CONFIG payload, without checking the ranges of its fields (see `check`)."""
        *numbers, lamps, reflex, pattern, phase = _CONFIG.unpack(payload)
        return cls(*numbers, lamps & 15, lamps >> 4, tuple(reflex), tuple(pattern), phase)  # type: ignore[call-arg]

    def check(self) -> None:
        """Check that a board would accept the configuration.

        Raises:
            UsageError: a field is out of its range.
        """
        for name, most in MOST.items():
            if not 0 <= (value := getattr(self, name)) <= most:
                raise UsageError(f"CONFIG: {name} {value}; expected 0 to {most}")
        if len(self.reflex) != INPUTS or not all(map(_is_reflex, self.reflex)):
            raise UsageError(
                f"CONFIG: reflex {self.reflex}; expected {INPUTS} numbers, 0 to {Reflex.ESTOP} "
                "(to the value 1 or 2, add 16 to react only in upward motion, 32 only in downward motion)"
            )
        if len(self.pattern) != PHASES or not all(0 <= each <= 15 for each in self.pattern):
            raise UsageError(f"CONFIG: pattern {self.pattern}; expected {PHASES} numbers, 0 to 15")

    @property
    def good(self) -> bool:
        """True if a board accepts the configuration."""
        try:
            self.check()
        except UsageError:
            return False
        return True


def _is_reflex(number: int) -> bool:
    reflex, directions = number & 15, number & ~15
    return (
        not directions or (reflex in (Reflex.STOP, Reflex.BRAKE) and directions in (16, 32))
        if reflex <= Reflex.ESTOP
        else False
    )


# ------------------------------------------------------------------------------------------------------------ messages
def answer_frame(answer: Answer) -> bytes:
    """Return the ANSWER frame with an answer."""
    wanted, *rest, tick = answer
    return encode(wanted, FrameKind.ANSWER, _ANSWER.pack(*rest, tick & 0xFFFFFFFF))


def event_frame(event: BoardEvent) -> bytes:
    """Return the EVENT frame with an event."""
    number, *rest, tick = event
    return encode(number, FrameKind.EVENT, _EVENT.pack(*rest, tick & 0xFFFFFFFF))


def ident_frame(ident: Ident) -> bytes:
    """Return the IDENT frame with the properties of a board."""
    wanted, *rest = ident
    return encode(wanted, FrameKind.IDENT, _IDENT.pack(*rest))


def read(frame: Frame) -> Answer | BoardEvent | Ident | None:
    """Return the message in a frame, or None if its kind and length match no message from a board."""
    number, kind, payload = frame
    if len(payload) != SIZES.get(kind):  # type: ignore[call-overload]  # any number
        return None
    if kind == FrameKind.ANSWER:
        return Answer(number, *_ANSWER.unpack(payload))
    if kind == FrameKind.EVENT:
        return BoardEvent(number, *_EVENT.unpack(payload))
    if kind == FrameKind.IDENT:
        return Ident(number, *_IDENT.unpack(payload))
    return None


def start_payload(tick: int) -> bytes:
    """Return the payload of START for a tick, which is sent modulo 2^32."""
    return _START.pack(tick & 0xFFFFFFFF)


def start_tick(payload: bytes) -> int:
    """Return the tick in a START payload."""
    tick: int
    (tick,) = _START.unpack(payload)
    return tick


def tail_payload(first: int, entries: Sequence[tuple[int, int]]) -> bytes:
    """Return the payload of TAIL: the index of the first entry, and entries of (interval in 1/256 tick, count)."""
    return bytes((first,)) + b"".join(_ENTRY.pack(*entry) for entry in entries)


def tail_entries(payload: bytes) -> tuple[int, list[tuple[int, int]]] | None:
    """Return the index of the first entry in a TAIL payload, and a list of its entries.

    Return None if the payload does not consist of an index and 1 to 10 complete entries.
    """
    if not 1 + _ENTRY.size <= len(payload) <= 1 + ENTRIES_A_FRAME * _ENTRY.size or (len(payload) - 1) % _ENTRY.size:
        return None
    return payload[0], [(interval, count) for interval, count in _ENTRY.iter_unpack(payload[1:])]


def reset_payload(position: int | None, *, known: bool = False, power: bool = False) -> bytes:
    """Return the payload of RESET, with flags as in `ResetFlag`; without a position the board keeps its own count."""
    flags = ResetFlag.POSITION * (position is not None) | ResetFlag.KNOWN * known | ResetFlag.POWER * power
    return _RESET.pack(flags, position or 0)


def reset_position(payload: bytes) -> int | None:
    """Return the position that a RESET payload sets; None if it sets none."""
    flags, position = _RESET.unpack(payload)
    return position if flags & ResetFlag.POSITION else None


def check_payload(count: int, interval: int) -> bytes:
    """Return the payload of CHECK: the number of pulses, and the ticks between them."""
    return _CHECK.pack(count, interval)


def check_numbers(payload: bytes) -> tuple[int, int]:
    """Return the number of pulses, and the ticks between them, in a CHECK payload."""
    count, interval = _CHECK.unpack(payload)
    return count, interval
