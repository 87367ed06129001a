"""A dialogue once more, with a module: the same commands, with the pauses that they had."""

from __future__ import annotations

from collections.abc import Sequence

from .exchanges import Exchange, commands
from .failures import DamagedAnswer, MotionRefused, NoAnswer
from .module import Module
from .speech import Speech

LONGEST_PAUSE_S = 60.0


def moving(exchanges: Sequence[Exchange], speech: Speech) -> list[str]:
    """Return the commands of a dialogue that may make a step: not those that it enters into a program."""
    found, entering = [], False
    for exchange in exchanges:
        for command in commands(speech, exchange.sent):
            row = speech.row(command)
            stored = entering and row is not None and row.stored
            if speech.moves(command) and not stored:
                found.append(command)
            if row is not None and row.role in ("enter", "leave"):
                entering = row.role == "enter"
    return found


def play(exchanges: Sequence[Exchange], module: Module) -> None:
    """Send the commands of a dialogue to a module, whose transcript takes down what it answers.

    Raises:
        MotionRefused: one of them may make a step, and the module may not; nothing has been sent.
        PortLost: the port is gone.
    """
    steps = moving(exchanges, module.speech)
    if steps and not module.may_move:
        listed = ", ".join(dict.fromkeys(steps))
        raise MotionRefused(
            f"{module.name}: {listed} may make the motor step; nothing was sent; allow motion with --move, or record a "
            "dialogue without"
        )
    before_us: int | float | None = None
    for exchange in exchanges:
        if before_us is not None:
            module.port.pause(min(max(exchange.at_us - before_us, 0) / 1e6, LONGEST_PAUSE_S))
        for command in commands(module.speech, exchange.sent):
            try:
                module.once(command, module.speech.framed(command))
            except (NoAnswer, DamagedAnswer) as failure:
                module.transcript.note(str(failure))
        before_us = exchange.over_us if exchange.last_us is None else exchange.last_us
