"""Figures of real motors, measured on the emulated board, as one table: python -m tests.firmware.figures [FILE]

Time of the host is that of its processor, in `Drive.turn` (records, frames, events) and in the model; the emulator is
not in it.  Load of the board: what the rounds of its main loop show, beside those of one that moves slowly
and hears nothing.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import thread_time
from typing import Any, NamedTuple

import numpy as np

from slewline.drive.board.frames import encode
from slewline.drive.board.records import Record
from slewline.drive.board.wire import BoardConfig, FrameKind, reset_payload, start_payload
from slewline.drive.motor_drive import Drive
from tests.drive.families import furnished
from tools.firmware import FLASH, RAM, Firmware, build

from .chain import HZ, EmulatedLine, drive_of, off
from .emulated import EmulatedBoard, Emulator
from .needs import missing

HERE = Path(__file__).resolve().parent
WINDOW_S = 0.05
FAMILIES = {  # title by the name of a stream
    "cy525 top": "CY525, R 127 S 255",
    "cy525 long ramp": "CY525, R 120 S 40 (long ramp)",
    "gs-c200s to 10 k": "GS-C200S, S100 T1000 R255",
    "cy545 to 27 k": "CY545, 27 k table, S 250",
    "mc1451a to 45 k": "MC1451A, 45 k steps/s",
}


class Figures(NamedTuple):
    """What is measured of one stream."""

    title: str
    steps: int
    fastest: float  # steps/s
    records: int
    records_s: int  # worst second
    records_50_ms: int
    down_s: float  # bytes a second of motion, to the board
    up_s: float
    worst_ticks: float
    drive_ms: float  # of the processor, a second of motion
    model_ms: float
    interrupts: float  # share of the board's cycles
    load: float
    load_50_ms: float  # of the worst 50 ms
    unused: int  # bytes of RAM that were never touched


def worst(times: list[float], length: float) -> int:
    """Return the most instants within a length of time."""
    at = np.sort(np.array(times))
    return int((np.searchsorted(at, at + length) - np.arange(len(at))).max()) if len(at) else 0


class Taken:
    """Seconds of the processor in a call."""

    def __init__(self, call: Callable[..., Any]) -> None:
        self.call, self.seconds, self.on = call, 0.0, False

    def __call__(self, *given: Any) -> Any:
        begun = thread_time()
        try:
            return self.call(*given)
        finally:
            if self.on:
                self.seconds += thread_time() - begun


class Profile:
    """An emulator that counts where the cycles of the board go."""

    def __init__(self, firmware: Firmware) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self.file = Path(self._folder.name) / "profile.json"
        listed = subprocess.run(
            ["avr-nm", "-S", "--defined-only", firmware.path.parent / "parts" / "uno.elf"],
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        symbols = {row[3]: row for row in map(str.split, listed.splitlines()) if len(row) == 4}
        begin, size = (int(word, 16) // 2 for word in symbols["round_once"][:2])
        before = dict(os.environ)
        os.environ |= {
            "NODE_OPTIONS": f"-r {HERE / 'profile.js'}",
            "SLEWLINE_PROFILE": str(self.file),
            "SLEWLINE_MAIN": f"{begin},{begin + size}",
        }
        try:
            self.emulator = Emulator(firmware)
        finally:
            os.environ.clear()
            os.environ.update(before)

    def end(self) -> list[dict[str, Any]]:
        """Return the windows of the last board; whole ones."""
        self.emulator.close()
        windows: list[dict[str, Any]] = json.loads(self.file.read_text())
        self._folder.cleanup()
        return windows[:-1]


def rounds_of_a_slow_board(firmware: Firmware) -> tuple[int, float]:
    """Return which instruction of the main loop is run once a round, and how often it is in a window.

    The board makes 100 steps/s meanwhile, of one record, and nobody talks to it: in motion a round is longer.
    """
    profile = Profile(firmware)
    board = EmulatedBoard(profile.emulator)
    for frame in (
        encode(0, FrameKind.HELLO),
        encode(0, FrameKind.CONFIG, BoardConfig(HZ // 500, HZ).pack()),
        encode(1, FrameKind.RESET, reset_payload(0)),
        encode(2, FrameKind.PUSH, Record(0, 1000, HZ // 100, 0, 0).pack()),
        encode(3, FrameKind.START, start_payload(HZ // 10)),
    ):
        board.receive(frame, board.now)
        board.run(board.now + HZ // 100)
    board.run(HZ * 6 // 10)
    assert len(board.rises) > 30
    counts = np.array([window["main"] for window in profile.end()])[4:]
    head = int(counts.sum(0).argmax())
    return head, float(counts[:, head].max())


def measured(name: str, firmware: Firmware, head: int, rounds: float) -> Figures:
    """Return what a stream costs."""
    profile = Profile(firmware)
    bench, x, _, seconds = furnished(name)
    line = EmulatedLine(profile.emulator, 1)
    drive: Drive = drive_of(bench, x, line)
    laid: list[float] = []  # s of the model at which each record is due at the board
    push = drive._path.link.push

    def pushed(records: Any) -> None:
        laid.extend([line.now / 1e9] * len(records))
        push(records)

    drive._path.link.push = pushed  # type: ignore[method-assign]
    live, kernel = drive._live, drive._state.kernel
    turn, model = Taken(live.turn), Taken(kernel.run)
    live.turn, kernel.run = turn, model  # type: ignore[method-assign]
    with drive:
        before = list(line.carried)
        turn.on = model.on = True
        drive.run(f"{int(seconds * 1000) + 150} ms")
        turn.on = model.on = False
        after = list(line.carried)
        rises = np.array(line.board.rises)
        length = (rises[-1] - rises[0]) / HZ
        worst_ticks = float(np.abs(off(drive, line)).max())
        unused = int(line.board.run(line.board.now, end=firmware.end)["unused"])
        records = drive._path.feeder.records
    windows = profile.end()
    busy = [
        (window["interrupts"] / window["cycles"], 1 - window["main"][head] / rounds)
        for window in windows
        if rises[0] <= window["at"] and window["at"] + WINDOW_S * HZ <= rises[-1]
    ]
    shares = np.array(busy)
    return Figures(
        FAMILIES[name],
        len(rises),
        HZ / np.diff(rises).min(),
        records,
        worst(laid, 1),
        worst(laid, 0.05),
        (after[0] - before[0]) / length,
        (after[1] - before[1]) / length,
        worst_ticks,
        turn.seconds * 1000 / length,
        model.seconds * 1000 / length,
        *(float(share) for share in (shares[:, 0].mean(), shares[:, 1].mean(), shares[:, 1].max())),
        unused,
    )


def table(firmware: Firmware, rows: list[Figures]) -> str:
    """Return the figures as a table of a page."""
    out = [
        f"Firmware of the Uno: {firmware.flash:,} of {FLASH:,} bytes of flash, {firmware.ram:,} of {RAM:,} of RAM; "
        f"{min(row.unused for row in rows)} bytes beyond stack and data were never touched.",
        "",
        "| stream | steps | steps/s | records, of them in the worst second, 50 ms | bytes/s to the board, to the host |"
        " worst edge | host: drive, model (ms a second) | board: interrupts, load, worst 50 ms |",
        "|---|---|---|---|---|---|---|---|",
    ]
    out += [
        f"| {row.title} | {row.steps:,} | {row.fastest:,.0f} | {row.records}, {row.records_s}, {row.records_50_ms} | "
        f"{row.down_s:,.0f}, {row.up_s:,.0f} | {row.worst_ticks / 16:.2f} us | "
        f"{row.drive_ms:.0f}, {row.model_ms:.1f} | {row.interrupts:.0%}, {row.load:.0%}, {row.load_50_ms:.0%} |"
        for row in rows
    ]
    return "\n".join(out)


def main(words: list[str]) -> int:
    """Measure, and print or write the table."""
    if gone := missing():
        print(f"figures: {', '.join(gone)}: not installed; this does it:  make boards", file=sys.stderr)
        return 1
    with tempfile.TemporaryDirectory() as folder:
        firmware = build(Path(folder))
        head, rounds = rounds_of_a_slow_board(firmware)
        text = table(firmware, [measured(name, firmware, head, rounds) for name in FAMILIES])
    if words:
        Path(words[0]).write_text(text + "\n")
    else:
        print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
