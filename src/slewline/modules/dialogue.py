r"""A file with the dialogue between a host and a module: a header, then one JSON object per line.

    {"slewline":"dialogue 1","part":"gs-c200s","markings":"GS-C200S 9431","crystal_hz":null,"baud":9600,...}
    {"at_us":12292,"last_us":13333,"from":"host","text":"F\r"}
    {"at_us":17729,"last_us":18770,"from":"module","text":"R\r"}
    {"at_us":30000,"last_us":30000,"from":"tool","text":"parity error at character 2"}

`from` is the sender.  Times are microseconds since the file was created: `at_us` is the time of the
first character, `last_us` that of the last one, both as seen by the computer.  An entry contains
consecutive characters from one side; it ends at a carriage return, or when the other side sends.
`text` is Latin-1, one character per byte.

A line is written when it is complete, so a truncated file is valid up to its last complete line.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from os import PathLike
from pathlib import Path
from time import monotonic_ns
from typing import Any, Literal

from ..closing import Closing
from ..errors import BenchFileError, UsageError
from ..gate import BOM, LATEST_PS, from_json, lines_of, opened

KIND, VERSION = "dialogue", 1
LONGEST = 256  # characters of one entry
END = b"\r"
LATEST_US = LATEST_PS // 10**6

Speaker = Literal["host", "module", "tool"]


@dataclass(frozen=True)
class DialogueHeader:
    """The header of a dialogue: the module, and the settings of its line.

    Args:
        part: the name of the part, such as "gs-c200s".
        markings: the text printed on the module.
        crystal_hz: the clock frequency of the module (Hz); None: unknown.
        baud: the rate of the line; None: unknown.
        checksum: whether each line ended with its checksum; None: unknown.
        address: the address of the module on a shared line; 0: no address is sent.
        straps: the levels (0 or 1) of the module's straps, keyed by pin.
    """

    part: str
    markings: str = ""
    crystal_hz: int | None = None
    baud: int | None = None
    checksum: bool | None = None
    address: int = 0
    straps: Mapping[str, int] = field(default_factory=dict)


def _whole(value: Any, low: int, high: int) -> bool:
    return type(value) is int and low <= value <= high


HEADER: Mapping[str, tuple[str, Callable[[Any], bool]]] = {  # in a file: the allowed value, and the check of it
    "part": ("the name of a part", lambda value: isinstance(value, str)),
    "markings": ("text", lambda value: isinstance(value, str)),
    "crystal_hz": ("whole hertz, or null", lambda value: value is None or _whole(value, 1, LATEST_PS)),
    "baud": ("a rate, or null", lambda value: value is None or _whole(value, 1, LATEST_PS)),
    "checksum": ("true, false, null", lambda value: value is None or isinstance(value, bool)),
    "address": ("an address, 0 to 255", lambda value: _whole(value, 0, 255)),
    "straps": (
        "an object with 0 or 1 for each pin",
        lambda value: isinstance(value, dict) and all(_whole(level, 0, 1) for level in value.values()),
    ),
}


@dataclass(frozen=True, slots=True)
class DialogueEntry:
    """An entry of a dialogue: characters from one side, which end at a carriage return or earlier.

    If `speaker` is "tool", the entry is a remark by slewline.
    """

    at_us: int
    last_us: int
    speaker: Speaker
    data: bytes

    @property
    def text(self) -> str:
        """Data of the entry as text, one Latin-1 character per byte."""
        return self.data.decode("latin-1")


Entry = tuple[Speaker, int, int, bytes]  # sender, instants of the first and the last character, and all characters


class Gathered:
    """A collector that groups characters into entries.

    An entry ends at a carriage return, when the other side sends, or when it has `LONGEST` characters.
    """

    def __init__(self) -> None:
        self._open: tuple[Speaker, int, int, bytearray] | None = None  # an entry that may grow

    def take(self, speaker: Speaker, at: int, byte: int) -> list[Entry]:
        """Add a character and its instant; return the entries that are then complete: none, one or two."""
        over = self.end() if self._open is not None and self._open[0] != speaker else []
        _, since, _, data = self._open or (speaker, at, at, bytearray())
        data.append(byte)
        self._open = speaker, since, at, data
        return over + (self.end() if byte == END[0] or len(data) >= LONGEST else [])

    def end(self) -> list[Entry]:
        """End the incomplete entry; return a list that contains this entry, or is empty if there is none."""
        found, self._open = self._open, None
        return [] if found is None else [(*found[:3], bytes(found[3]))]


class DialogueFile(Closing):
    """A dialogue file that is written line by line; it must be closed at the end.

    Args:
        path: a new file.
        failed: called with a message when a write fails; the file keeps its lines, and no more are written.
        clock: returns the current instant (ns) on the clock to which all instants refer.

    Raises:
        UsageError: the file exists, or cannot be written.
    """

    def __init__(
        self,
        path: str | PathLike[str],
        header: DialogueHeader,
        failed: Callable[[str], object] = lambda _text: None,
        clock: Callable[[], int] = monotonic_ns,
    ) -> None:
        self.path, self.failed, self.clock = Path(path), failed, clock
        self.began_ns = clock()
        self.entries = 0
        self._gathered = Gathered()
        try:
            self._file = self.path.open("xb", buffering=0)
        except FileExistsError:
            raise UsageError(f"dialogue {path}: this file exists; name a new file") from None
        except OSError as error:
            raise UsageError(f"dialogue {path}: {error.strerror or error}; give a file that can be written") from None
        self._write({"slewline": f"{KIND} {VERSION}", **asdict(header)})

    def host(self, data: bytes, first_ns: int, last_ns: int | None = None) -> None:
        """Write characters sent to the module, with the instants (ns) of the first and the last character."""
        self._characters("host", data, first_ns, first_ns if last_ns is None else last_ns)

    def module(self, data: bytes, first_ns: int, last_ns: int | None = None) -> None:
        """Write characters received from the module, with the instants (ns) of the first and the last character."""
        self._characters("module", data, first_ns, first_ns if last_ns is None else last_ns)

    def note(self, text: str) -> None:
        """Write the incomplete entry, if there is one, then a remark with the current instant."""
        self.end()
        now_ns = self.clock()
        self._entry("tool", now_ns, now_ns, text.encode("latin-1", "replace"))

    def _characters(self, speaker: Speaker, data: bytes, first_ns: int, last_ns: int) -> None:
        """Add characters, assumed to be equally spaced in time from the first to the last; write completed entries."""
        for number, byte in enumerate(data):
            at_ns = first_ns + (last_ns - first_ns) * number // max(len(data) - 1, 1)
            for entry in self._gathered.take(speaker, at_ns, byte):
                self._entry(*entry)

    def end(self) -> None:
        """Write the incomplete entry, if there is one."""
        for entry in self._gathered.end():
            self._entry(*entry)

    def _entry(self, speaker: Speaker, first_ns: int, last_ns: int, data: bytes) -> None:
        at_us, last_us = ((ns - self.began_ns) // 1000 for ns in (first_ns, last_ns))
        if self._write({"at_us": at_us, "last_us": last_us, "from": speaker, "text": data.decode("latin-1")}):
            self.entries += 1

    def _write(self, entry: dict[str, Any]) -> bool:
        """Write a header or an entry as a line; return whether the whole line was written."""
        if self._file.closed:
            return False
        line = json.dumps(entry, separators=(",", ":")).encode("ascii") + b"\n"
        whole = self._file.tell()
        try:
            left = memoryview(line)
            while left:
                left = left[self._file.write(left) :]
        except OSError as error:
            with suppress(OSError):
                self._file.truncate(whole)
            self._let_go()
            kept = f"the {self.entries} lines before are kept"
            self.failed(f"dialogue {self.path}: {error.strerror or error}; it ends here, {kept}")
            return False
        return True

    def _let_go(self) -> None:
        with suppress(OSError):  # every line has been written, or has failed, already
            self._file.close()

    def _shut(self) -> None:
        """Write the incomplete entry, if there is one, and close the file."""
        self.end()
        self._let_go()


@dataclass(frozen=True)
class RecordedDialogue:
    """A recorded dialogue; `torn` is True if its file ends in a truncated line, which is left out."""

    header: DialogueHeader
    entries: tuple[DialogueEntry, ...] = ()
    torn: bool = False

    @classmethod
    def read(cls, path: str | PathLike[str]) -> RecordedDialogue:
        """Return the dialogue in a file.

        Raises:
            UsageError: the file cannot be read, is not a dialogue, or is damaged before its last line.
        """
        try:
            with opened(path) as file:
                return cls._read(path, lines_of(path, file))
        except BenchFileError as error:
            raise UsageError(f"dialogue {error}") from None

    @classmethod
    def _read(cls, path: str | PathLike[str], lines: Iterator[bytes]) -> RecordedDialogue:
        """Return the dialogue in the lines of a file; `path` names the file in messages."""
        header = _header(path, next(lines, b"").removeprefix(BOM).rstrip(b"\n"))
        entries: list[DialogueEntry] = []
        for number, line in enumerate(lines, start=2):
            if not line.endswith(b"\n"):
                return cls(header, tuple(entries), torn=True)
            line = line[:-1]
            try:
                entries.append(_entry(from_json(line)))
            except (ValueError, KeyError, TypeError) as error:
                raise UsageError(
                    f"dialogue {path}, line {number}: {line[:80]!r} is not an entry ({error}); allowed: an "
                    "object with 'at_us', 'last_us', 'from' (host, module or tool) and 'text'; remove the line, or use "
                    "the original recording"
                ) from None
        return cls(header, tuple(entries))

    def write(self, path: str | PathLike[str]) -> None:
        """Write the dialogue into a new file, without slewline's remarks.

        Raises:
            UsageError: the file exists, or cannot be written.
        """
        failures: list[str] = []
        with DialogueFile(path, self.header, failures.append, lambda: 0) as file:
            for entry in self.entries:
                if entry.speaker != "tool":
                    file.end()
                    file._entry(entry.speaker, entry.at_us * 1000, entry.last_us * 1000, entry.data)
        if failures:
            raise UsageError(failures[0])


def _header(path: str | PathLike[str], line: bytes) -> DialogueHeader:
    """Parse the first line of a file; return its header."""
    expected = f'{{"slewline":"{KIND} {VERSION}","part":...}}'
    try:
        found = from_json(line)
        kind, _, version = found["slewline"].rpartition(" ")
    except (ValueError, KeyError, TypeError, AttributeError):
        raise UsageError(
            f"dialogue {path}: begins with {line[:40]!r}; expected {expected}; name a file that slewline proxy, "
            "terminal or pull has recorded"
        ) from None
    if (kind, version) != (KIND, str(VERSION)):
        raise UsageError(f"dialogue {path} is a {found['slewline']!r}; this version of slewline reads {KIND} {VERSION}")
    if "part" not in found:
        raise UsageError(f"dialogue {path}: its first line names no part; expected {expected}")
    known = {name: value for name, value in found.items() if name in HEADER}
    for name, value in known.items():
        format, fits = HEADER[name]
        if not fits(value):
            shown = json.dumps(value)[:80]
            raise UsageError(f"dialogue {path}, line 1: {name}: found {shown}; allowed {format}; correct the line")
    return DialogueHeader(**known)


def _entry(entry: Any) -> DialogueEntry:
    """Return the dialogue entry that is represented by the JSON data of a line."""
    if not isinstance(entry, dict):
        raise TypeError("expected an object")
    at_us, speaker = entry["at_us"], entry["from"]
    last_us: Any = entry.get("last_us", at_us)
    for name, value in (("at_us", at_us), ("last_us", last_us)):
        if not _whole(value, -LATEST_US, LATEST_US):
            raise ValueError(f"{name}: expected a whole number, {-LATEST_US} to {LATEST_US}")
    if speaker not in ("host", "module", "tool"):
        raise ValueError(f"from: {speaker!r}")
    if not isinstance(entry["text"], str):
        raise TypeError("text: expected a string")
    return DialogueEntry(at_us, last_us, speaker, entry["text"].encode("latin-1"))
