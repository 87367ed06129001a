"""What is known of branches and checkpoints, and what a server must have that travels in time."""

from __future__ import annotations

import socket
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from ...bench import Bench
    from ..lines.line import HostLine
    from ..lines.log import TranscriptFile
    from ..lines.pace import Pace
    from ..sockets.loop import Loop
    from ..views.reports import FindingReports
    from .breakpoints import Breakpoints

Data = dict[str, Any]
Answer = Callable[[Data], object]


class Diverted(Protocol):
    """A client of a control port."""

    def divert(self, where: str, event: Data) -> None:
        """Let requests go to the control port of a branch from now on; "": they are answered here again."""


class Entrance(Protocol):
    """A control port."""

    token: str | None

    @property
    def where(self) -> str:
        """HOST:PORT."""

    @property
    def clients(self) -> Sequence[Diverted]:
        """Who is connected."""


class Travels(Protocol):
    """A server whose past is kept."""

    bench: Bench
    pace: Pace
    loop: Loop
    lines: dict[str, HostLine]
    breakpoints: Breakpoints
    reports: FindingReports
    log: TranscriptFile
    tell: Callable[[str], object]
    ports: list[Any]
    travel: Any
    branch: int

    def controls(self) -> Sequence[Entrance]:
        """Return the control ports."""

    def control(self, address: str, token: str | None = None) -> Any:
        """Open a control port."""

    def tcp(self, line: HostLine, address: str) -> Any:
        """Serve a line on a TCP socket."""

    def serve(self, done: Callable[[], bool]) -> None:
        """Let time pass and answer, until something is done."""


@dataclass
class Checkpoint:
    """A copy of the server that waits."""

    time_ps: int
    length: int  # of the journal, in bytes
    work_s: float  # that the server had done
    process: int
    orders: socket.socket
    waiting: dict[int, Answer] = field(default_factory=dict)  # for its worlds, by the number of the branch
    rest: bytes = b""


@dataclass
class Branch:
    """A run that begins at an instant of another one."""

    number: int
    parent: int | None
    from_ps: int
    now_ps: int  # when it was last left
    journal: Path
    shared: int  # bytes at the beginning of its journal that the first one has as well
    shared_ps: int  # the instant up to which it is the first run
    control: str = ""
    lines: dict[str, str] = field(default_factory=dict)
    process: int = 0
    leash: socket.socket | None = None  # the world ends when it is closed
    rest: bytes = b""  # of what has come on the leash
    waiting: list[Callable[[], object]] = field(default_factory=list)  # for its time, in order
    touched: bool = False
