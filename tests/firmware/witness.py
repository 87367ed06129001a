"""The firmware without its processor: what is common to boards, compiled for this machine, with sanitizers."""

from __future__ import annotations

import subprocess
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from slewline.drive.board import wire
from slewline.drive.board.frames import decode
from slewline.drive.board.wire import Answer, BoardEvent, Happening

from .emulated import EmulatedBoard


@dataclass
class Witness:
    """What a board did that was told what another one was told, at the instants at which that one took it.

    `steps`: tick, direction by the level of DIR, and whether STEP had an edge.  `phases`, `outputs`, `enable`: tick and
    value of each change; None is no level.  `sent`: bytes for the host.
    """

    polarity: int
    steps: list[tuple[int, int, bool]] = field(default_factory=list)
    phases: list[tuple[int, int]] = field(default_factory=list)
    outputs: list[tuple[int, int]] = field(default_factory=list)
    enable: list[tuple[int, int | None]] = field(default_factory=list)
    sent: bytearray = field(default_factory=bytearray)

    def changes(self, what: str) -> list[tuple[int, int | None]]:
        """Return `phases`, `outputs` or `enable`: the last value of each tick, where that is another one."""
        return last_of_each_tick(getattr(self, what), None if what == "enable" else 0)

    def take(self, line: str) -> None:
        """Take a line that the program prints."""
        what, *numbers = line.split()
        if what == "sent":
            self.sent += bytes.fromhex(numbers[0])
        elif what == "step":
            tick, level, edge = map(int, numbers)
            self.steps.append((tick, 1 if level == self.polarity & 1 else -1, bool(edge)))
        else:
            tick, value = map(int, numbers)
            getattr(self, what).append((tick, None if value < 0 else value))


def last_of_each_tick(changes: Iterable[tuple[int, int | None]], before: int | None) -> list[tuple[int, int | None]]:
    """Return changes without those that another one of the same tick undid."""
    out = []
    for tick, value in dict(changes).items():
        if value != before:
            out.append((tick, before := value))
    return out


def told(board: EmulatedBoard, chunks: list[tuple[int, bytes]]) -> list[str]:
    """Return the script of what a board took: frames by its answers, looks and rounds by its own marks."""
    said = [wire.read(decode(frame[:-1])) for _, frame in board.frames]  # type: ignore[arg-type]
    left = [chunk for _, chunk in chunks if chunk]
    rows = [(tick, -2, f"watch {tick}") for tick in board.rounds]
    boot = 0
    for at, each in enumerate(said):
        if isinstance(each, Answer):
            rows.append((each.tick, at, f"frame {each.tick} {left.pop(0).hex()}00"))
        elif isinstance(each, BoardEvent) and each.kind == Happening.WATCHDOG:
            rows.append((each.tick, at, f"silence {each.tick}"))
        elif isinstance(each, BoardEvent) and each.kind == Happening.BOOT:
            boot = boot or each.tick
    rows += [(tick, -1, f"inputs {tick} {levels}") for tick, levels in dict(board.looks).items()]
    return [f"boot {boot} 63", *(line for _, _, line in sorted(rows)), f"run {board.now}"]


def witnessed(program: Path, board: EmulatedBoard, chunks: list[tuple[int, bytes]]) -> Witness:
    """Return what the program makes of what a board was told."""
    script = "\n".join(told(board, chunks)) + "\n"
    ran = subprocess.run([program], input=script, capture_output=True, text=True, check=False, timeout=60)
    assert ran.returncode == 0, ran.stderr
    witness = Witness(board.polarity)
    for line in ran.stdout.splitlines():
        witness.take(line)
    return witness
