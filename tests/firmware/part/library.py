"""The core as a shared library: built by the compiler of the system, given what came in at the pins of a module.

events ----> tests/firmware/part/replay.c and firmware/part/gs_c200 ----> Outcome
"""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parents[3]
CORE = ROOT / "firmware" / "part" / "gs_c200"
HERE = Path(__file__).parent
FLAGS = ("-std=c11", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-ffp-contract=off")
COMPILER = os.environ.get("CC", "cc")
MOST = 1 << 21  # steps, characters, edges that are kept
PINS = ("rdy", "mov", "ramp", "dir", "reset", "uo1", "uo2", "uo3", "talk")  # as gsc200.h numbers them
INPUTS = (
    *("sel0", "sel1", "sel2", "br0", "br1", "br2", "chs", "rec"),
    *("rxd", "enable", "home", "eot", "ui1", "ui2", "ui3"),
)
ON, OFF, INPUTS_NOW, INPUTS_AFTER, CHARACTER, FAULT, END = range(7)
PARITY, FRAMING = 1, 2
KIND = {  # of what is written down
    **dict.fromkeys(("step_times", "directions", "positions"), "step"),
    **dict.fromkeys(("pin_times", "pins"), "pin"),
    **dict.fromkeys(("character_times", "characters"), "character"),
}
EVENT = np.dtype([("at", np.int64), ("end", np.int64), ("kind", np.int32), ("value", np.int32)])


class Event(NamedTuple):
    """What comes in at an instant (ps); `end` is that of a character."""

    at: int
    kind: int
    value: int = 0
    end: int = 0
    kept: bytes = b""


class Out(ctypes.Structure):
    """As in tests/firmware/part/replay.c."""

    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("step_times", "pin_times", "character_times")),
        *((name, ctypes.c_void_p) for name in ("positions", "pins", "characters", "directions")),
        *((name, ctypes.c_int64) for name in ("most", "steps", "pin_count", "character_count", "baud", "wrong")),
    )


@dataclass(frozen=True)
class Outcome:
    """What goes out of a module.

    Attributes:
        times, directions, positions: of the steps: int64 ps, 1 or -1, the position counter after the step.
        characters: instants of their start bits (ps), and the codes.
        edges: by the name of the output: instants (ps) and levels, -1 without supply.
        end: of what is known, ps.
        kept: what the EEPROM holds.
        baud: at which it listens at the end; 0: it does not.
        wrong: how often a step was foreseen wrongly, or a level reported that an output had already.
    """

    times: NDArray[np.int64]
    directions: NDArray[np.int8]
    positions: NDArray[np.int32]
    characters: list[tuple[int, int]]
    edges: dict[str, list[tuple[int, int]]]
    end: int = 0
    kept: bytes = b""
    baud: int = 0
    wrong: int = 0


def sources() -> list[Path]:
    """Return the files of the core."""
    return sorted(CORE.glob("*.c"))


def need() -> None:
    """Skip the test where there is no compiler; in CI (`CI` is set) that is a failure."""
    if shutil.which(COMPILER) is not None:
        return
    if os.environ.get("CI"):
        pytest.fail(f"{COMPILER}: not installed; this test must not be skipped in CI")
    pytest.skip(f"{COMPILER}: not installed")


def build(into: Path, core: Path = CORE, flags: Sequence[str] = ("-O2", *FLAGS)) -> Path:
    """Build the library of a copy of the core into a folder; return its path.

    Raises:
        subprocess.CalledProcessError: the compiler refuses a file.
    """
    made = into / "part.so"
    command = [COMPILER, *flags, "-shared", "-fPIC", "-Wl,-Bsymbolic", f"-I{core}", *map(str, sorted(core.glob("*.c")))]
    subprocess.run(
        [*command, str(HERE / "replay.c"), "-lm", "-o", str(made)], check=True, capture_output=True, text=True
    )
    return made


class Library:
    """A built core."""

    def __init__(self, path: Path) -> None:
        made = ctypes.CDLL(str(path))
        self.replay, self.keep, self.kept_now = made.replay, made.keep, made.kept
        self.replay.argtypes = [ctypes.c_void_p, ctypes.c_int64, ctypes.c_int32, ctypes.c_uint64, ctypes.c_void_p]
        self.keep.argtypes = [ctypes.c_char_p, ctypes.c_int32, ctypes.c_int32]
        self.kept_now.argtypes = [ctypes.c_char_p]
        wide = {name: np.zeros(MOST, np.int64) for name in ("step_times", "pin_times", "character_times")}
        narrow = {name: np.zeros(MOST, np.int32) for name in ("positions", "pins", "characters")}
        self.kept = wide | narrow | {"directions": np.zeros(MOST, np.int8)}
        self.out = Out(most=MOST, **{name: array.ctypes.data for name, array in self.kept.items()})

    def replayed(
        self, part: str, given: NDArray[Any], since: int = 0, kept: bytes = b"", looks: int = 0
    ) -> dict[str, NDArray[Any]]:
        """Return what is written down in a replay, by its kind; the next replay changes it.

        Args:
            part: "gs-c200" or "gs-c200s".
            given: of the type EVENT, ascending in time; the last one ends the replay.
            since: the instant of the core at which the time of the events is 0, modulo 2**64 ps.
            kept: what its EEPROM holds at first.
            looks: how often that is found busy when a write should be over.
        """
        out = self.out
        self.keep(kept, len(kept), looks)
        self.replay(given.ctypes.data, len(given), part == "gs-c200s", since, ctypes.addressof(out))
        content = ctypes.create_string_buffer(256)
        length = self.kept_now(content)
        assert max(out.pin_count, out.character_count) <= MOST
        count = {"step": min(out.steps, MOST), "pin": out.pin_count, "character": out.character_count}
        written = {name: array[: count[KIND[name]]] for name, array in self.kept.items()}
        written["counts"] = np.array([out.steps, out.pin_count, out.character_count, out.baud, out.wrong])
        return written | {"content": np.frombuffer(content.raw[:length], np.uint8)}

    def play(self, part: str, events: Sequence[Event], since: int = 0, kept: bytes = b"", looks: int = 0) -> Outcome:
        """Return what a module does with some events, of which the last one ends the replay; see `replayed`."""
        return outcome_of(self.replayed(part, as_array(events), since, kept, looks), events[-1].at)


def as_array(events: Sequence[Event]) -> NDArray[Any]:
    """Return events as the core takes them."""
    return np.array([(event.at, event.end, event.kind, event.value) for event in events], EVENT)


def outcome_of(written: Mapping[str, NDArray[Any]], end: int) -> Outcome:
    """Return what was written down in a replay up to its end (ps), in a form to compare."""
    edges: dict[str, list[tuple[int, int]]] = {name: [] for name in PINS}
    for at, change in zip(written["pin_times"].tolist(), written["pins"].tolist(), strict=True):
        edges[PINS[change // 4]].append((at, change % 4 - 1))
    return Outcome(
        written["step_times"].copy(),
        written["directions"].copy(),
        written["positions"].copy(),
        list(zip(written["character_times"].tolist(), written["characters"].tolist(), strict=True)),
        {name: settled(each) for name, each in edges.items()},
        end,
        written["content"].tobytes(),
        *map(int, written["counts"][-2:]),
    )


def settled(changes: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return changes of a level as edges: the last one of each instant, if it is a real one."""
    found: list[tuple[int, int]] = []
    before: int | None = None
    for at, level in dict(changes).items():
        if level != before:
            found.append((at, level))
        before = level
    return found
