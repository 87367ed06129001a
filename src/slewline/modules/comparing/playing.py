"""Playback of a dialogue to a module: the same commands with the same pauses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ..failures import DamagedAnswer, MotionRefused, NoAnswer, ReplacementRefused
from ..module import Module
from ..spoken import Speech
from .exchanges import RecordedExchange, commands

LONGEST_PAUSE_S = 60.0


REPLACING = ("enter", "erase", "recall", "store")  # the former content is lost, in RAM or in the EEPROM


class Hazards(NamedTuple):
    """The commands of a dialogue that may step the motor, and the commands that replace the program of a module."""

    moving: list[str]
    replacing: list[str]


def hazards(exchanges: Sequence[RecordedExchange], speech: Speech) -> Hazards:
    """Return the hazardous commands of a dialogue; a move certain to be stored in a program is harmless."""
    found, entering = Hazards([], []), False
    for exchange in exchanges:
        for command in commands(speech, exchange.sent):
            row = speech.row(command)
            role = "" if row is None else row.role
            stored = entering and speech.shows_entry and row is not None and row.stored
            if speech.moves(command) and not stored and command not in found.moving:
                found.moving.append(command)
            if role in REPLACING and command not in found.replacing:
                found.replacing.append(command)
            if role in ("enter", "leave"):
                entering = role == "enter"
    return found


def play(exchanges: Sequence[RecordedExchange], module: Module, may_replace: bool = False, wait_s: float = 0.0) -> None:
    """Send the commands of a dialogue to a module, whose transcript records the answers.

    Args:
        may_replace: whether the program of the module may be lost.
        wait_s: the minimum time to wait for an answer.

    Raises:
        MotionRefused: a command may step the motor, but motion is not allowed; no command has been sent.
        ReplacementRefused: a command replaces the program, but `may_replace` is False; no command was sent.
        NoAnswer: sent characters come back: the line echoes, but the port was opened without `echo`.
        PortLost: the port is gone.
    """
    found = hazards(exchanges, module.speech)
    if found.moving and not module.may_move:
        raise MotionRefused(
            f"{module.name}: {', '.join(found.moving)} may step the motor; no command was sent; allow motion with "
            "--move, or record a dialogue without motion"
        )
    if found.replacing and not may_replace:
        raise ReplacementRefused(
            f"{module.name}: {', '.join(found.replacing)} would replace the module's program; no command was "
            "sent; save that program with slewline pull, then allow its replacement with --replace"
        )
    before_us: int | float | None = None
    for exchange in exchanges:
        if before_us is not None:
            module.port.pause(min(max(exchange.at_us - before_us, 0) / 1e6, LONGEST_PAUSE_S))
        for command in commands(module.speech, exchange.sent):
            try:
                module.once(command, wait_s=wait_s)
            except (NoAnswer, DamagedAnswer) as failure:
                module.transcript.note(str(failure))
            module.port.check_echo()
        before_us = exchange.over_us if exchange.last_us is None else exchange.last_us
