"""A non-volatile memory: one file for the memory of one chip.

    the line "slewline memory 1" | length, 4 bytes | CRC-32, 4 bytes | data         numbers with their high byte first
    the line "slewline memory 2" | length, 4 bytes | CRC-32, 4 bytes | data | record | record ...

    record    address, 4 bytes | length, 4 bytes | CRC-32 of address, length and data, 4 bytes | data

A module answers Y when its program is in the memory, so `write` and `append` return only when a power cut can no longer
undo them; if they are interrupted, the former content stays in place.

    write                                        append
    write a temporary file, fsync it             add a record after the last one, fsync it
    read it back and compare                     read it back and compare
    rename it over the file
    fsync the directory

The first append ever, an append after a failure, and an append that would make the records much longer
than the rest of the file write the whole file instead.

New content is on the disk under another name before it gets its final name, so a disk that stores
wrong data is detected in time.  After the last step, nothing can fail.  A power failure during an
append leaves an incomplete record at the end, which is dropped.  If a complete record follows a broken
one, the broken one was damaged later: this is reported as damage.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from struct import Struct
from typing import Any
from zlib import crc32

from ...core.memory.store import put
from ...core.time.hook import Hook
from ...errors import StoreError
from ..sockets.system import BINARY, NO_LINK, directory

MAGIC, JOURNAL = b"slewline memory 1\n", b"slewline memory 2\n"
HEADER = Struct(f">{len(MAGIC)}sII")
RECORD, PLACE, CHECK = Struct(">III"), Struct(">II"), Struct(">I")
GARBLED = "the disk does not return the data written; use another one"
CHUNK = 1 << 16
MIN_JOURNAL, MAX_TIMES = 1 << 14, 4  # bytes; factor of the content
LARGEST = 1 << 24  # bytes of a file: fifty times a 64K memory with its records


class FileStore:
    """A memory in a file, replaced completely or not at all; changes to a large memory are appended.

    The temporary file has a fixed name, so that a process killed repeatedly leaves one such file, not many.  Two stores
    must not share a file.  Symbolic links are not followed: one with the name of the temporary file is removed, never
    opened, and one in place of the file is refused.

    Args:
        path: the file, which need not exist; its directory must.
        system: a replacement for the module `os`, for tests.
    """

    def __init__(self, path: str | os.PathLike[str], system: Any = os) -> None:
        self.path, self.system = Path(path), system
        self._part = self.path.with_name(f".{self.path.name}.part")
        self._content: bytearray | None = None  # as on the disk, after an append
        self._base = self._end = 0  # lengths of the file, without its records and with them; 0: unknown
        self.on_failure: Hook[[str]] = Hook()  # error of a failed read or write

    def read(self) -> bytes:
        """Return the content; empty if nothing was ever written.

        Raises:
            StoreError: the file cannot be read, is damaged, or is not a slewline memory.
        """
        with self._refusals("read"):
            return bytes(self._unpacked(self._found()))

    def write(self, data: bytes) -> None:
        """Replace the content, even if it is damaged; return when the new content is safely on the disk.

        Raises:
            StoreError: the new content is not safely on the disk; or the file, unchanged, is not a slewline memory.
        """
        self._content, self._end = None, 0
        with self._refusals("write"):
            self._replace(packed(data))

    def append(self, data: bytes, at: int | None = None) -> None:
        """Write bytes into the content, at an address or at its end; return when they are safely on the disk.

        Raises:
            StoreError: the bytes are not safely on the disk; or the file is damaged, or not a slewline memory.
            UsageError: the address is beyond the end.
        """
        with self._refusals("write"):
            if self._content is None:
                self._content, self._end = self._unpacked(self._found()), 0
            address = put(self._content, data, at)
            if not data:
                return
            try:
                self._keep(self._content, PLACE.pack(address, len(data)), data)
            except BaseException:
                self._content = None  # the file must be read again
                raise

    def _keep(self, content: bytearray, place: bytes, data: bytes) -> None:
        """Append a record, or rewrite the whole file with all of the content."""
        record = place + CHECK.pack(crc32(place + data)) + data
        longest = min(self._base + max(MIN_JOURNAL, MAX_TIMES * len(content)), LARGEST)
        end, self._end = self._end, 0
        if end and end + len(record) <= longest and self._appended(record, end):
            self._end = end + len(record)
        else:
            whole = packed(content, JOURNAL)
            self._replace(whole)
            self._base = self._end = len(whole)

    def _appended(self, record: bytes, end: int) -> bool:
        """Append a record to the file; return False if the file does not exist, or is not `end` bytes long."""
        try:
            with self._opened(self.path, os.O_RDWR) as file:
                if self.system.lseek(file, 0, os.SEEK_END) != end:
                    return False
                try:
                    self._put(file, record)
                    self.system.lseek(file, end, os.SEEK_SET)
                    if self._rest(file) != record:
                        raise StoreError(f"{self.path}: {GARBLED}")
                except BaseException:
                    with suppress(OSError):
                        self.system.ftruncate(file, end)
                    raise
        except FileNotFoundError:
            return False
        return True

    def _replace(self, content: bytes) -> None:
        """Replace the file with a new one that contains `content`."""
        with directory(self.path.parent, self.system) as made_safe:
            self._found()
            try:
                with suppress(FileNotFoundError):
                    self.system.unlink(self._part)
                with self._opened(self._part, os.O_WRONLY | os.O_CREAT | os.O_EXCL) as file:
                    self._put(file, content)
                if self._load(self._part) != content:
                    raise StoreError(f"{self.path}: {GARBLED}")
                self.system.replace(self._part, self.path)
            except BaseException:
                with suppress(OSError):
                    self.system.unlink(self._part)
                raise
            made_safe()

    def _found(self) -> bytes:
        """Return all bytes of the file; empty if there is no file."""
        if self.path.is_symlink():
            raise StoreError(f"{self.path}: is a symbolic link; name the file itself")
        if self.path.exists() and not (self.path.is_file() or self.path.is_dir()):  # opening a FIFO would block
            raise StoreError(f"{self.path}: is not a regular file; name another file")
        try:
            found = self._load(self.path)
        except FileNotFoundError:
            return b""
        if not found.startswith((MAGIC, JOURNAL)):
            raise StoreError(f"{self.path}: is not a slewline memory; name another file")
        return found

    def _unpacked(self, found: bytes) -> bytearray:
        """Return the content of the memory, from all bytes of its file."""
        if not found:
            return bytearray()
        if len(found) >= HEADER.size:
            magic, length, _ = HEADER.unpack_from(found)
            end = HEADER.size + length
            content = bytearray(found[HEADER.size : end])
            whole = found[:end] == packed(content, magic)
            if whole and end == len(found):
                return content
            if whole and magic == JOURNAL and repeated(content, found, end):
                return content
        why = "the memory is damaged (length or checksum); move the file away to start with an empty memory"
        raise StoreError(f"{self.path}: {why}")

    def _put(self, file: int, content: bytes) -> None:
        while content:
            content = content[self.system.write(file, content) :]
        self.system.fsync(file)

    def _load(self, path: Path) -> bytes:
        with self._opened(path, os.O_RDONLY) as file:
            return self._rest(file)

    def _rest(self, file: int) -> bytes:
        found = bytearray()
        while chunk := self.system.read(file, CHUNK):
            found += chunk
            if len(found) > LARGEST:
                why = f"more than {LARGEST} bytes, which no memory has; name another file"
                raise StoreError(f"{self.path}: {why}")
        return bytes(found)

    @contextmanager
    def _opened(self, path: Path, flags: int) -> Iterator[int]:
        file = self.system.open(path, flags | BINARY | NO_LINK, 0o666)
        try:
            yield file
        finally:
            with suppress(OSError):  # fsync has reported all relevant errors
                self.system.close(file)

    @contextmanager
    def _refusals(self, verb: str) -> Iterator[None]:
        """Raise operating-system errors as StoreError, and report them."""
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


def packed(data: bytes | bytearray, magic: bytes = MAGIC) -> bytes:
    """Return all bytes of a file without records: the header and the data."""
    return HEADER.pack(magic, len(data), crc32(data)) + data


def repeated(content: bytearray, found: bytes, at: int) -> bool:
    """Apply the records from a position in a file on; return whether at most an incomplete record follows them."""
    while (place := record_at(found, at)) is not None:
        address, length = place
        if address > len(content):
            return False
        put(content, found[at + RECORD.size : at + RECORD.size + length], address)
        at += RECORD.size + length
    return all(record_at(found, later) is None for later in range(at + 1, len(found) - RECORD.size))


def record_at(found: bytes, at: int) -> tuple[int, int] | None:
    """Return the address and length of the record at `at`; None if it is incomplete, damaged, or has no data."""
    if at + RECORD.size >= len(found):
        return None
    address, length, check = RECORD.unpack_from(found, at)
    end = at + RECORD.size + length
    if not length or end > len(found) or crc32(found[at : at + PLACE.size] + found[at + RECORD.size : end]) != check:
        return None
    return address, length
