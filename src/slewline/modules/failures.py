"""Failures of a real module.  Messages name the place, the value found, the allowed values, and a remedy."""

from __future__ import annotations

from ..errors import SlewlineError


class ModuleFailure(SlewlineError, OSError):
    """A module has not executed a command, or its state is no longer known."""

    def __str__(self) -> str:  # OSError would print numbers
        return str(self.args[0]) if self.args else ""


class PortLost(ModuleFailure):
    """The port is gone: for example, a cable was unplugged or a connection was closed."""


class NoAnswer(ModuleFailure):
    """No answer, or an incomplete one, available as `received`."""

    def __init__(self, text: str, received: bytes = b"") -> None:
        super().__init__(text)
        self.received = received


class EndlessInput(ModuleFailure):
    """Characters still arrive when a complete answer would be over; `received` contains the characters so far."""

    def __init__(self, text: str, received: bytes) -> None:
        super().__init__(text)
        self.received = received


class DamagedAnswer(ModuleFailure):
    """An answer with a wrong checksum or a faulty character, or one that is not an answer of this part at all."""


class RefusedCommand(ModuleFailure):
    """The module has refused a command.

    Args:
        code: the answer, such as "E2".
        description: the data sheet's text for the answer.
    """

    def __init__(self, text: str, code: str, description: str) -> None:
        super().__init__(text)
        self.code, self.description = code, description


class MotionRefused(ModuleFailure):
    """A command was not sent, because it may step the motor."""


class ReplacementRefused(ModuleFailure):
    """A dialogue was not played, because it would replace the program of the module."""


class ListingDiffers(ModuleFailure):
    """The listing of a module differs from the program sent to it, or from its own second listing."""
