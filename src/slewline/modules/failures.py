"""Failures of a real module.  Messages name the place, the value found, the allowed values, and a remedy."""

from __future__ import annotations

from ..errors import SlewlineError


class ModuleFailure(SlewlineError, OSError):
    """A module has not executed a command, or its state is no longer known."""

    def __str__(self) -> str:  # OSError would print numbers
        return str(self.args[0]) if self.args else ""


class PortLost(ModuleFailure):
    """The port is gone: a cable was unplugged, a connection was closed."""


class NoAnswer(ModuleFailure):
    """No answer, or an incomplete one, which is `received`."""

    def __init__(self, text: str, received: bytes = b"") -> None:
        super().__init__(text)
        self.received = received


class EndlessInput(ModuleFailure):
    """Characters still arrive after the time of a complete answer; `received` are those so far."""

    def __init__(self, text: str, received: bytes) -> None:
        super().__init__(text)
        self.received = received


class DamagedAnswer(ModuleFailure):
    """An answer with a wrong checksum, with a fault in a character, or not an answer of this part at all."""


class RefusedCommand(ModuleFailure):
    """The module has refused a command.

    Args:
        code: the answer, such as "E2".
        description: the text of the data sheet for it.
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
