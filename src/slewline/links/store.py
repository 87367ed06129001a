"""A memory that keeps its content without power: one small file for the EEPROM of one module.

    the line "slewline memory 1" | length, 4 bytes | CRC-32, 4 bytes | data         numbers with their high byte first

A module answers Y when its program is in the memory, so `write` returns only when a power cut can no longer undo it,
and whatever ends it before leaves the former content in place:

    write a neighbour of the file, fsync it      the content is on the disk, under another name
    read it back and compare                     a disk that keeps something else is found out in time
    rename it over the file                      old or new, never half of each
    fsync the directory                          the name is on the disk too; nothing behind this can fail
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from struct import Struct
from typing import Any
from zlib import crc32

from ..core.hook import Hook
from ..errors import StoreError

MAGIC = b"slewline memory 1\n"
HEADER = Struct(f">{len(MAGIC)}sII")
CHUNK = 1 << 16


class FileStore:
    """A memory in a file, replaced whole or not at all.

    The neighbour has a fixed name, so that a process which is killed again and again leaves one such file, not many.
    Two stores must not share a file.

    Args:
        path: the file; it need not exist, its directory must.
        system: what takes the place of the module `os`, for tests.
    """

    def __init__(self, path: str | os.PathLike[str], system: Any = os) -> None:
        self.path, self.system = Path(path), system
        self._part = self.path.with_name(f".{self.path.name}.part")
        self.on_failure: Hook[[str]] = Hook()  # a read or a write was refused, and why

    def read(self) -> bytes:
        """The content; empty when nothing was ever written.

        Raises:
            StoreError: the file cannot be read, is damaged, or is no memory of ours.
        """
        with self._refusals("read"):
            found = self._found()
            data = found[HEADER.size :]
            if found and found != packed(data):
                why = "the memory is damaged (length or checksum); remove the file to begin empty"
                raise StoreError(f"{self.path}: {why}")
        return data

    def write(self, data: bytes) -> None:
        """Replace the content, a damaged one too; returns when it is on the disk to stay.

        Raises:
            StoreError: the new content is not safely there; or the file is no memory of ours, and stays as it is.
        """
        content = packed(data)
        with self._refusals("write"), self._opened(self.path.parent, os.O_RDONLY) as directory:
            self._found()
            try:
                self._save(content)
                if self._load(self._part) != content:
                    raise StoreError(f"{self.path}: the disk returns something else than was written; use another one")
                self.system.replace(self._part, self.path)
            except BaseException:
                with suppress(OSError):
                    self.system.unlink(self._part)
                raise
            self.system.fsync(directory)

    def _found(self) -> bytes:
        """The file as it is; empty when there is none."""
        for path in (self.path, self._part):
            if path.exists() and not (path.is_file() or path.is_dir()):  # to open a FIFO is to wait for its other end
                raise StoreError(f"{path}: is no regular file; name another one, or remove it")
        try:
            found = self._load(self.path)
        except FileNotFoundError:
            return b""
        if not found.startswith(MAGIC):
            raise StoreError(f"{self.path}: is no memory of slewline; name another file, or remove this one")
        return found

    def _save(self, content: bytes) -> None:
        with self._opened(self._part, os.O_WRONLY | os.O_CREAT | os.O_TRUNC) as file:
            while content:
                content = content[self.system.write(file, content) :]
            self.system.fsync(file)

    def _load(self, path: Path) -> bytes:
        found = b""
        with self._opened(path, os.O_RDONLY) as file:
            while chunk := self.system.read(file, CHUNK):
                found += chunk
        return found

    @contextmanager
    def _opened(self, path: Path, flags: int) -> Iterator[int]:
        file = self.system.open(path, flags, 0o666)
        try:
            yield file
        finally:
            with suppress(OSError):  # fsync has told everything that matters
                self.system.close(file)

    @contextmanager
    def _refusals(self, verb: str) -> Iterator[None]:
        """Say what the system refuses as an error of ours, and tell of it."""
        try:
            yield
        except StoreError as error:
            self.on_failure(str(error))
            raise
        except OSError as error:
            why = error.strerror or error
            text = f"{self.path}: cannot {verb} the memory: {why}; give a file in a writable directory"
            self.on_failure(text)
            raise StoreError(text) from error


def packed(data: bytes) -> bytes:
    """The content of the file: header and data."""
    return HEADER.pack(MAGIC, len(data), crc32(data)) + data
