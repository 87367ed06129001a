"""The command line at the bottom of the screen: history, completion, and a row of help."""

from __future__ import annotations

from typing import Any, ClassVar

from textual.binding import Binding, BindingType
from textual.message import Message
from textual.suggester import Suggester
from textual.widgets import Input

from .debugger_verbs import candidates
from .session import DebugSession


class Completion(Suggester):
    """The source of the completions that the command line suggests."""

    def __init__(self, session: DebugSession) -> None:
        super().__init__(use_cache=False, case_sensitive=True)
        self.session = session

    async def get_suggestion(self, value: str) -> str | None:
        """Return the most likely completion that begins with the typed text; None if there is none."""
        found = candidates(self.session, value) if value else []
        # keep the case of the typed beginning, r as well as R
        return next((each for each in found if each.startswith(value)), None)


class CommandLine(Input):
    """A command line with history (up, down) and completion (tab, right)."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("up", "older(1)", show=False),
        Binding("down", "older(-1)", show=False),
        Binding("tab", "complete", show=False),
        Binding("escape", "leave", show=False),
    ]

    class Left(Message):
        """The message that the user has left the command line without entering a command."""

    def __init__(self, session: DebugSession, **names: Any) -> None:
        super().__init__(suggester=Completion(session), compact=True, select_on_focus=False, **names)
        self.session = session
        self.history: list[str] = []
        self.place = 0  # in the history, from its end; 0: the line itself
        self.found: list[str] = []  # completions that tab cycles through

    def put(self, text: str) -> None:
        """Replace the typed line by a text, with the cursor at its end."""
        self.value = text
        self.cursor_position = len(text)
        self.place = 0

    def keep(self, text: str) -> None:
        """Clear the command line, and add a line to the history unless it is empty or the same as the latest one."""
        if text and text not in self.history[-1:]:
            self.history.append(text)
        self.put("")

    def action_older(self, by: int) -> None:
        """Show the line that is `by` places older in the history than the present one; newer if `by` is negative."""
        place = min(max(self.place + by, 0), len(self.history))
        self.put(self.history[-place] if place else "")
        self.place = place

    def action_complete(self) -> None:
        """Complete the typed line; a repeated call replaces the completion by the next one."""
        if self.value in self.found:
            self.put(self.found[(self.found.index(self.value) + 1) % len(self.found)])
            return
        self.found = candidates(self.session, self.value)
        if self.found:
            self.put(self.found[0])

    def action_leave(self) -> None:
        """Clear the command line, and leave it."""
        self.put("")
        self.post_message(self.Left())
