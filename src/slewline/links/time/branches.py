"""What is known of branches and checkpoints."""

from __future__ import annotations

import socket
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

Data = dict[str, Any]
Answer = Callable[[Data], object]


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
    silent: int = 0  # looks at it, one after the other, at which it owed an answer
    watched: bool = False
    touched: bool = False
