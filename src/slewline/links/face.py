"""The interfaces of a server and of its clients, as types for the modules that use them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from pathlib import Path

    from ..bench import Bench
    from ..core.chip import Chip
    from ..core.component import Finding
    from ..core.wires.pin import Condition
    from .control.control import Control
    from .lines.line_transcript import TranscriptFile
    from .lines.pace import Pace
    from .lines.served_line import HostLine
    from .ports.adapters import Adapters
    from .sockets.loop import Loop
    from .sockets.stream import SocketStream
    from .time.branches import Branches
    from .time.breakpoints import Breakpoints
    from .time.server_past import ServedPast
    from .views.dialogue_view import Dialogue
    from .views.panel_views import Views
    from .views.reports import FindingReports
    from .views.scope import Scope


Data = dict[str, Any]


class OpenPort(Protocol):
    """A port of any kind."""

    @property
    def where(self) -> str:
        """Address of the port."""

    def close(self) -> None:
        """Close the port."""


class ClientFace(Protocol):
    """A client of the control port, as seen by the request handlers and by the relays to branches."""

    server: ServerFace
    stream: SocketStream
    waiting: bool
    every_s: float

    @property
    def token(self) -> str | None:
        """Token that a client must send with its first request; None if no token is required."""

    def perform(self, request: Data) -> Data | None:
        """Execute a request on this server and return its reply; None if the reply comes later."""

    def wait(
        self, request: Data, reply: Callable[[bool], Data], condition: Condition, limit_ps: int, pushes: bool
    ) -> None:
        """Send `reply(met)` when a condition is met, or at `limit_ps`.

        If `pushes`, virtual time runs until then even while it is paused.
        """

    def answer_later(self, request: Data) -> Callable[[Data], object]:
        """Return a function that later sends the reply to a request."""

    def reply(self, request: Data, found: Data) -> None:
        """Send the reply to a request."""

    def failed(self, request: Data, error: Exception) -> Data:
        """Return the reply to a request that has caused an error."""

    def subscribe(self, every_s: float) -> Data:
        """Start sending events, at least `every_s` seconds apart; 0 stops them.  Return the current view."""

    def watch(self, every_s: float) -> None:
        """Start checking every `every_s` seconds for changes, which are sent as events; 0 stops the checks."""

    def event(self, found: Data) -> None:
        """Send an event, if the client has subscribed."""

    def go_on(self) -> None:
        """Answer received requests that had to wait, then resume reading."""


class ServerFace(Protocol):
    """A server, as seen by lines, views, the control port and time travel; `Server` describes the attributes."""

    bench: Bench
    pace: Pace
    loop: Loop
    log: TranscriptFile
    lines: dict[str, HostLine]
    ports: list[OpenPort]
    allow_remote: bool
    report: Callable[[str], object]
    found: int
    notes: list[Callable[[], str]]
    troubles: list[str]
    branch: int
    breakpoints: Breakpoints
    reports: FindingReports
    past: ServedPast
    branches: Branches
    views: Views
    adapters: Adapters

    @property
    def scope(self) -> Scope:
        """History of signals."""

    @property
    def dialogue(self) -> Dialogue:
        """Record of the data sent by hosts and chips."""

    def controls(self) -> Sequence[Control]:
        """Return the control ports."""

    def control(self, address: str | Path, token: str | None = None) -> OpenPort:
        """Open a control port."""

    def tcp(self, line: HostLine, address: str | Path) -> OpenPort:
        """Serve a line on a TCP socket."""

    def furnish(self, bench: Bench) -> None:
        """Start observing the findings, the journal, the dialogue and the signals of a bench."""

    def finding(self, found: Finding) -> None:
        """Report a finding."""

    def say(self, line: str, text: str) -> None:
        """Record a line's event in the transcript; report it to the user, unless the transcript is on the terminal."""

    def steps_of(self, chip: Chip) -> int:
        """Return the number of steps of a chip since the beginning, on all axes."""

    def catch_up(self) -> None:
        """Execute the requests that register hosts have already sent, so that they precede any later request."""

    def serve(self, done: Callable[[], bool]) -> None:
        """Let time run and answer clients, until `done` returns True."""

    def stop(self) -> None:
        """End the server."""
