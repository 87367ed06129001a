"""Failures of a real module.  Messages name the place, the value found, the allowed values, and a remedy."""

from __future__ import annotations

from ..errors import SlewlineError


class ModuleFailure(SlewlineError, OSError):
    """A failure: a module has not executed a command, or the state of the module is no longer known."""

    def __str__(self) -> str:  # OSError would print numbers
        return str(self.args[0]) if self.args else ""


class PortLost(ModuleFailure):
    """The loss of a port: for example, a cable was unplugged or a connection was closed."""


class NoAnswer(ModuleFailure):
    """The absence of an answer, or an incomplete answer; `received` contains the characters received."""

    def __init__(self, text: str, received: bytes = b"") -> None:
        super().__init__(text)
        self.received = received


class EndlessInput(ModuleFailure):
    """An answer that continues beyond the length of a complete one; `received` contains the characters so far."""

    def __init__(self, text: str, received: bytes) -> None:
        super().__init__(text)
        self.received = received


class DamagedAnswer(ModuleFailure):
    """An answer with a wrong checksum or a faulty character, or received data that is not an answer of this part."""


class RefusedCommand(ModuleFailure):
    """A command that the module has refused.

    Args:
        code: the answer, such as "E2".
        description: the data sheet's text for the answer.
    """

    def __init__(self, text: str, code: str, description: str) -> None:
        super().__init__(text)
        self.code, self.description = code, description


class MotionRefused(ModuleFailure):
    """A command that was not sent, because it may step the motor and motion is not allowed."""


class ReplacementRefused(ModuleFailure):
    """A dialogue that was not sent to a module, because it would replace the program of the module."""


class ListingDiffers(ModuleFailure):
    """A listing or a value that was not read back correctly from a module.

    Either it differs from the data sent, or it was read several times, and no two readings agree.
    """
