"""The black box of a drive: the journal of its bench, and every byte between host and board, timed on both clocks.

    <folder>/journal.jsonl                    inputs of the bench: `slewline run --replay` makes the same steps again
    <folder>/line.0.jsonl, line.1.jsonl       each read or write: {"ns": ..., "tick": ..., "way": ">", "data": "..."}
    <folder>/made-by-slewline                 marks a folder made by `new_folder`, which may remove it

The two line files are written alternately: when one is full, the other is overwritten.  So the last few
megabytes are always available, but no more.  `ns` is the host time in nanoseconds since the drive was
opened, `tick` is the board time as estimated by the host; ">" marks bytes sent to the board.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import suppress
from os import PathLike
from pathlib import Path
from time import strftime
from typing import TYPE_CHECKING, TextIO, cast

from ..errors import UsageError
from ..folders import state_folder
from ..gate import from_json, lines_of, opened, read_file

if TYPE_CHECKING:
    from .board.board_port import BoardPort

MOST_BYTES = 8 << 20  # size of each line file
KEPT_SESSIONS = 20
JOURNAL = "journal.jsonl"
LINES = ("line.0.jsonl", "line.1.jsonl")
MARK, MARK_TEXT = (
    "made-by-slewline",
    b"A session of slewline drive. Only the newest ones are kept: copy what is worth it.\n",
)
FILES = frozenset({JOURNAL, *LINES, MARK})
_in_json = json.JSONEncoder(separators=(",", ":")).encode


def new_folder(inside: str | PathLike[str] | None = None) -> Path:
    """Make a folder for a session, in a given folder or in the state directory of this system.

    Only the newest 20 session folders are kept, and older ones are removed; all other files are left alone.

    Raises:
        UsageError: the folder cannot be made.
    """
    try:
        place = state_folder() / "drive" if inside is None else Path(inside)
    except UsageError as error:
        raise UsageError(f"black box: {error}, or give a folder (--black-box DIR)") from None
    stem = strftime("%Y-%m-%d-%H%M%S")
    try:
        place.mkdir(parents=True, exist_ok=True)
        for number in range(1000):
            folder = place / (stem if not number else f"{stem}-{number}")
            if not folder.exists():
                folder.mkdir()
                (folder / MARK).write_bytes(MARK_TEXT)
                break
        for old in sorted(each for each in place.glob("20??-??-??-??????*") if _is_ours(each))[:-KEPT_SESSIONS]:
            _remove(old)
    except OSError as error:
        raise UsageError(f"black box {place}: {error.strerror or error}; give a folder that can be written") from None
    return folder


def _is_ours(folder: Path) -> bool:
    """Return whether a folder was made by `new_folder`, and contains only files of a session."""
    with suppress(OSError):
        return not folder.is_symlink() and {each.name for each in folder.iterdir()} <= FILES and _is_marked(folder)
    return False


def _is_marked(folder: Path) -> bool:
    mark = folder / MARK
    return not mark.is_symlink() and mark.is_file() and read_file(mark) == MARK_TEXT


def _remove(folder: Path) -> None:
    """Remove the files of a session, and then its empty folder."""
    with suppress(OSError):
        for name in sorted(FILES - {MARK}):
            (folder / name).unlink(missing_ok=True)
        (folder / MARK).unlink()
        folder.rmdir()


def reopen(port: BoardPort) -> None:
    """Reopen a port whose cable was unplugged; do nothing if this kind of port has no cable.

    Raises:
        UsageError: the port does not exist, or is in use by another program.
    """
    call = getattr(port, "reopen", None)
    if call is not None:
        call()


class BlackBox:
    """The port of a board, with a record of all bytes that pass through it.

    Args:
        port: the port of the board.
        folder: an existing folder, for this session only.
        clock: a function that returns the wall-clock time in nanoseconds.
        tick: a function that returns the board tick at a given time of that clock.
        most: the size limit of each of the two files, in bytes.
    """

    def __init__(
        self,
        port: BoardPort,
        folder: str | PathLike[str],
        clock: Callable[[], int],
        tick: Callable[[int], int],
        most: int = MOST_BYTES,
    ) -> None:
        self.port, self.folder, self.most = port, Path(folder), most
        self.failure = ""  # reason why the recording has ended
        self._clock, self._tick = clock, tick
        self._began_ns = clock()
        self._number = 0
        self._file: TextIO | None = None
        self._written = 0
        self._begin()

    @property
    def name(self) -> str:
        """The name of the port."""
        return getattr(self.port, "name", "board")

    @property
    def received(self) -> bytes:
        """The last bytes received, as many as the port keeps; empty if it keeps none."""
        return bytes(getattr(self.port, "received", b""))

    def _begin(self, mode: str = "w") -> None:
        self._let_go()
        try:
            path = self.folder / LINES[self._number]
            self._file = cast("TextIO", path.open(mode, encoding="ascii", buffering=1))
        except OSError as error:
            self._fail(error)
        self._written = self._written if mode == "a" else 0

    def _fail(self, error: OSError) -> None:
        self.failure = f"black box {self.folder}: {error.strerror or error}; the record ends here"
        self._let_go()

    def _let_go(self) -> None:
        file, self._file = self._file, None
        if file is not None:
            try:
                file.close()
            except OSError as error:
                self.failure = (
                    self.failure or f"black box {self.folder}: {error.strerror or error}; the record ends here"
                )

    def _note(self, direction: str, data: bytes) -> None:
        if self._file is None:
            return
        now = self._clock()
        entry = {"ns": now - self._began_ns, "tick": self._tick(now), "way": direction, "data": data.hex()}
        line = _in_json(entry) + "\n"
        try:
            self._file.write(line)
        except OSError as error:
            self._fail(error)
            return
        self._written += len(line)
        if self._written >= self.most:
            self._number ^= 1
            self._begin()

    def read(self) -> bytes:
        """Return the bytes received since the last call."""
        data = self.port.read()
        if data:
            self._note("<", data)
        return data

    def write(self, data: bytes) -> int:
        """Send bytes; return the number that the port has accepted."""
        self._note(">", data)
        return self.port.write(data)

    def fileno(self) -> int | None:
        """Return a descriptor on which a loop can wait; None if the port has none."""
        return self.port.fileno()

    def reopen(self) -> None:
        """Reopen the port, if it is of a kind that can be reopened; the record continues."""
        reopen(self.port)
        if self._file is None and not self.failure:
            self._begin("a")

    def close(self) -> None:
        """Close the port, and end the record, whose files remain."""
        self.port.close()
        self._let_go()


def recorded(
    port: BoardPort, folder: str | PathLike[str] | bool, clock: Callable[[], int], tick: Callable[[int], int]
) -> BoardPort:
    """Return a port that forwards all calls to `port`, and records all bytes in a folder.

    Args:
        folder: the folder; True: a new folder; False: `port` itself is returned, without a record.
    """
    if folder is False:
        return port
    place = new_folder() if folder is True else Path(folder)
    place.mkdir(parents=True, exist_ok=True)
    return BlackBox(port, place, clock, tick)


def read_line(folder: str | PathLike[str]) -> list[tuple[int, int, str, bytes]]:
    """Return the recorded transfers: ns, tick, direction (">" to the board) and bytes, in chronological order.

    Raises:
        UsageError: there is no black box, or a line of one of its files is damaged.
        BenchFileError: one of its files cannot be read.
    """
    found: list[tuple[int, int, str, bytes]] = []
    paths = [path for name in LINES if (path := Path(folder) / name).exists()]
    if not paths:
        raise UsageError(f"{folder} has no black box (line.0.jsonl); name the folder of a session")
    for path in paths:
        with opened(path) as file:
            for number, line in enumerate(lines_of(path, file), 1):
                if not line.endswith(b"\n"):
                    break  # the last line of a session that was killed
                found.append(_exchanged(path, number, line))
    return sorted(found, key=lambda entry: entry[0])


def _exchanged(path: Path, number: int, line: bytes) -> tuple[int, int, str, bytes]:
    """Return one recorded transfer: ns, tick, direction and bytes."""
    try:
        entry = from_json(line)
        ns, tick, direction, data = (entry[name] for name in ("ns", "tick", "way", "data"))
        if type(ns) is int and type(tick) is int and direction in (">", "<"):
            return ns, tick, direction, bytes.fromhex(data)
    except (ValueError, KeyError, TypeError):
        pass
    raise UsageError(
        f"{path}, line {number}: found {line[:80]!r}; allowed 'ns' and 'tick' (whole numbers), 'way' (> or <) "
        "and 'data' (hexadecimal digits); remove the line"
    )
