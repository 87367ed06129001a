"""The gate: all user files are read here, and the names in them are allowed or refused here.

A bench file, journal, dialogue, log, black box, backup or memory image may come from anyone.  Each name
in it is of one of three classes, and the code that reads the file checks the name with a `FileGate`:

    of the folder    a file that is, once all links are followed, in the folder of the file that names
                     it, or below; a link for a pty in this folder or below, if its path contains no
                     other link and no tool runs files with such a name; a serial device of this system
    elsewhere        any other file, link, device; only with `anywhere` (--anywhere)
    code             a chip or part as module:Class, whose import runs the module's code; only with
                     `allow_code` (--allow-code)

A name given on the command line or in Python is trusted.  Trusted or not, every file must be a regular
file; files and lines have a maximum length; JSON has a maximum depth and number of values, and only
finite numbers.
"""

from __future__ import annotations

import json
import os
import re
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import repeat
from math import isfinite
from os import PathLike
from pathlib import Path, PurePath
from typing import Any, BinaryIO, NamedTuple, TypeVar

from .errors import BenchFileError, SlewlineError

T = TypeVar("T")

MAX_BYTES = 10_000_000  # of a file that is read whole
MAX_LINE = 1 << 20  # bytes of a line of a log
MAX_VALUES = 1 << 20  # of JSON in one line; our longest list is a 64K memory
UTF16_BOMS = (b"\xff\xfe", b"\xfe\xff")
UTF16 = "text in UTF-16; save it as UTF-8 (Notepad: Save as, Encoding UTF-8; PowerShell: Set-Content -Encoding utf8)"
NUL = "contains NUL bytes, so it is not text; name the right file"
BOM = b"\xef\xbb\xbf"  # which editors and tools put before UTF-8 text
LATEST_PS = 1 << 63  # instants are less: plots and records have 64 bits

ERRNO = re.compile(r"\(([0-9]+), '")  # as pySerial writes it, twice or as a tuple
KINDS = {  # what may be found instead of a file
    stat.S_IFDIR: "a directory",
    stat.S_IFIFO: "a FIFO",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}
LINK_NAME = re.compile(r"(?P<stem>[A-Za-z0-9][\w+-]*)(?:\.(?:pty|tty|port|serial))?", re.ASCII)
RUN = re.compile(r".*file|configure|sconstruct|sconscript|build|workspace", re.IGNORECASE)  # by make, docker, scons ...
RUN_IN = ("bin", "sbin", "scripts", "hooks")  # folders in which a file of any name is a program
FILE_THERE = "copy it there, or allow files anywhere (--anywhere, load(path, anywhere=True))"
LINK_THERE = "name a link in that folder or below, or allow links anywhere (--anywhere, load(path, anywhere=True))"
SERIAL = re.compile(  # of Linux, of macOS and the BSDs, of Windows
    r"/dev/(?:tty[A-Za-z]+[0-9]+|rfcomm[0-9]+|(?:tty|cu)\..+|cuaU?[0-9.]+)|(?:\\\\\.\\)?(?i:com)[0-9]+:?"
)


# -------------------------------------------------------------------------------------------------- the names in a file
class LinkPlace(NamedTuple):
    """The path of a link for a pty, as named in a file.

    `folder` may be reached via links; in the folders `below` it, no links are followed.
    """

    folder: Path
    below: tuple[str, ...]
    name: str

    def __str__(self) -> str:
        return str(self.folder.joinpath(*self.below, self.name))


class FileGate:
    """The checker of the names in a file.

    Args:
        path: the file; the names in it are relative to its folder.
        anywhere: allow the file to name files, links and devices outside its folder.
        allow_code: allow the file to name chips and parts as module:Class, whose import runs code.
    """

    def __init__(self, path: str | PathLike[str], anywhere: bool = False, allow_code: bool = False) -> None:
        self.folder, self.anywhere, self.allow_code = Path(path).parent, anywhere, allow_code

    def file(self, name: Any) -> Path:
        """Return the path of a file to read.

        Raises:
            SlewlineError: the file, once all links are followed, is outside the folder of the naming file, and
                `anywhere` is False.
            OSError, ValueError: the name is not a path.
        """
        path = self.folder / self._text(name)
        if not self.anywhere and not Path(os.path.realpath(path)).is_relative_to(os.path.realpath(self.folder)):
            raise self._outside(name, FILE_THERE)
        return path

    def link(self, name: Any) -> LinkPlace:
        """Return the path of a link for a pty, which `links.ports.symbolic_link` creates without following links.

        Raises:
            SlewlineError: the path is outside the folder of the naming file, or tools may run files with such a
                name.
        """
        path = PurePath(self._text(name))
        if self.anywhere:
            whole = self.folder / path
            return LinkPlace(whole.parent, (), whole.name)
        if path.is_absolute():
            roots = (os.path.abspath(self.folder), os.path.realpath(self.folder))
            own_root = next((root for root in roots if path.is_relative_to(root)), None)
            if own_root is None:
                raise self._outside(name, LINK_THERE)
            path = path.relative_to(own_root)
        if ".." in path.parts or path.is_absolute() or path.drive:
            raise self._outside(name, LINK_THERE)
        *below, own = path.parts or ("",)
        named = LINK_NAME.fullmatch(own)
        if named is None or RUN.fullmatch(named["stem"]):
            raise SlewlineError(
                f"found {name!r}, the name of a file that a tool may run or read; allowed letters, digits, - and _, "
                "with or without .pty, .tty, .port or .serial, but no Makefile or the like; or allow any name "
                "(--anywhere)"
            )
        if refused := next((each for each in below if each.startswith(".") or each.lower() in RUN_IN), None):
            raise SlewlineError(
                f"found {name!r}: files in a folder named {refused!r} may be executed; name a link in another folder, "
                "or allow links anywhere (--anywhere)"
            )
        return LinkPlace(self.folder, tuple(below), own)

    def device(self, name: Any) -> str:
        """Return the name of a serial port of this machine.

        Raises:
            SlewlineError: it is not a serial device; opening any other device may have side effects.
        """
        device = self._text(name)
        if not self.anywhere and not SERIAL.fullmatch(device if os.name == "nt" else os.path.realpath(device)):
            raise SlewlineError(
                f"found {name!r}, which is not a serial port; allowed names such as /dev/ttyUSB0 or COM3; "
                "or allow any device (--anywhere)"
            )
        return device

    def code(self, find: Callable[..., type[T]], name: Any) -> type[T]:
        """Return the class of a chip or part; module:Class is imported only if code is allowed.

        Args:
            find: the function that finds the class: `chip_class` or `part_class`.

        Raises:
            UnknownName: there is no such class.
            UsageError: the name denotes code, but `allow_code` is False; or the name does not denote a class.
        """
        return find(self._text(name), allow_code=self.allow_code)

    def _text(self, name: Any) -> str:
        if not isinstance(name, str):
            raise SlewlineError(f"found {name!r}; allowed text")
        return name

    def _outside(self, name: Any, remedy: str) -> SlewlineError:
        return SlewlineError(f"found {name!r}, outside the folder of the bench file; {remedy}")


# -------------------------------------------------------------------------------------------------------- reading files
def read_file(path: str | PathLike[str]) -> bytes:
    """Return the bytes of a regular file.

    Raises:
        BenchFileError: the file does not exist, is not a regular file, or is too long.
    """
    with refusals(path), opened(path) as file:
        return _bounded(path, file.read(MAX_BYTES + 1))


def read_text(path: str | PathLike[str], data: bytes | None = None) -> str:
    """Return the text of a file.

    Args:
        data: the content of the file, if it has already been read.

    Raises:
        BenchFileError: the file does not exist, is not a regular file, is too long, or is not text.
    """
    data = read_file(path) if data is None else _bounded(path, data)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        if _is_utf16(data):
            raise BenchFileError(f"{path}: {UTF16}") from None
        line = data.count(b"\n", 0, error.start) + 1
        found = f"byte {data[error.start]:02X} in line {line} is not UTF-8 text"
        raise BenchFileError(f"{path}: {found}; save it as UTF-8, or name the right file") from None
    if "\0" in text:
        raise BenchFileError(f"{path}: {UTF16 if _is_utf16(data) else NUL}")
    return text


def _is_utf16(data: bytes) -> bool:
    """Return whether bytes are UTF-16 text: they begin with its byte order mark, or every second byte is 0."""
    return data.startswith(UTF16_BOMS) or (len(data) > 1 and not (any(data[1::2]) and any(data[::2])))


def _bounded(path: str | PathLike[str], data: bytes) -> bytes:
    if len(data) > MAX_BYTES:
        raise BenchFileError(f"{path}: more than {MAX_BYTES} bytes; check that it is the right file")
    return data


def opened(path: str | PathLike[str]) -> BinaryIO:
    """Open a regular file to read bytes; refuse any other file.

    Opening a FIFO would block, and opening a device may have side effects.

    Raises:
        BenchFileError: the file does not exist, or is not a regular file.
    """
    with refusals(path):
        kind = stat.S_IFMT(os.stat(path).st_mode)
        if kind != stat.S_IFREG:
            raise BenchFileError(f"{path} is {KINDS.get(kind, 'not a file')}; give a regular file")
        return open(path, "rb")


def lines_of(path: str | PathLike[str], file: BinaryIO) -> Iterator[bytes]:
    """Yield the lines of an open file, each with its line feed; a truncated last line has none.

    Blank lines at the end of the file are left out.

    Args:
        path: the path of the file, for messages.

    Raises:
        BenchFileError: a line is too long, or cannot be read.
    """
    number = blank = 0
    with refusals(path):
        while line := file.readline(MAX_LINE):
            number += 1
            if len(line) == MAX_LINE and not line.endswith(b"\n"):
                raise BenchFileError(
                    f"{path}, line {number}: more than {MAX_LINE} bytes; check that it is the right file"
                )
            if line.strip():
                yield from repeat(b"\n", blank)
                yield line
            blank = 0 if line.strip() else blank + 1


@contextmanager
def refusals(path: str | PathLike[str]) -> Iterator[None]:
    """Replace any OSError or ValueError in the `with` block by a BenchFileError, which names the file."""
    try:
        yield
    except BenchFileError:
        raise
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise BenchFileError(f"{path} cannot be read: {why}; name a file that can be read") from None


# ----------------------------------------------------------------------------------------------------------------- JSON
def from_json(line: bytes) -> Any:
    """Return the value that a line of JSON in UTF-8 represents.

    Raises:
        ValueError: the line is not JSON, is nested too deeply, or has too many values, a number that is not
            finite, or one half of a surrogate pair.
    """
    if len(line) > MAX_VALUES and sum(_BARE.sub(b"", line).count(mark) for mark in (b",", b"[", b"{")) > MAX_VALUES:
        raise ValueError(f"more than {MAX_VALUES} values")
    try:
        found = json.loads(line.decode(), parse_constant=_finite, parse_float=_finite)
    except RecursionError:
        raise ValueError("nested too deeply") from None
    if b"\\u" in line:
        json.dumps(found, ensure_ascii=False).encode()  # UnicodeEncodeError is a ValueError
    return found


def error_number(error: Exception) -> int | None:
    """Return an error's errno, or else the errno in its text, as pySerial writes it; None if it has neither."""
    inside = ERRNO.search(str(error))
    return getattr(error, "errno", None) or (int(inside[1]) if inside else None)


_BARE = re.compile(rb'"(?:[^"\\]|\\.)*+"')


def _finite(text: str) -> float:
    """Return the number in a text, or raise ValueError if it is not finite."""
    value = float(text)
    if not isfinite(value):
        raise ValueError(f"{text} is not a finite number")
    return value
