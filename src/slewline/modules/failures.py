"""What can go wrong with a real module.  Messages name the place, what was found, what is allowed, and a remedy."""

from __future__ import annotations

from ..errors import SlewlineError


class ModuleFailure(SlewlineError, OSError):
    """A module does not do what is asked of it, or nothing is known of it any more."""

    def __str__(self) -> str:  # OSError would print numbers
        return str(self.args[0]) if self.args else ""


class PortLost(ModuleFailure):
    """The port is gone: a cable was unplugged, a connection was closed."""


class NoAnswer(ModuleFailure):
    """Nothing came, or not all of it; `received` is what did."""

    def __init__(self, text: str, received: bytes = b"") -> None:
        super().__init__(text)
        self.received = received


class EndlessInput(ModuleFailure):
    """Characters still come after the time that all of an answer takes; `received` are those so far."""

    def __init__(self, text: str, received: bytes) -> None:
        super().__init__(text)
        self.received = received


class DamagedAnswer(ModuleFailure):
    """An answer came with a wrong checksum, with a fault in a character, or is no answer of the part at all."""


class RefusedCommand(ModuleFailure):
    """The module has answered that it does not do what was asked.

    Args:
        code: the answer, such as "E2".
        says: what the data sheet says of it.
    """

    def __init__(self, text: str, code: str, says: str) -> None:
        super().__init__(text)
        self.code, self.says = code, says


class MotionRefused(ModuleFailure):
    """A command was not sent, since it may make the motor step."""


class ReplacementRefused(ModuleFailure):
    """A dialogue was not played, since it would replace the program of the module."""


class ListingDiffers(ModuleFailure):
    """What the module lists is not what it was sent, or not the same twice."""
