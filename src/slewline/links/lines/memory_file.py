"""A file for the non-volatile memory of one chip.

    the line "slewline memory 1" | length, 4 bytes | CRC-32, 4 bytes | data
    the line "slewline memory 2" | length, 4 bytes | CRC-32, 4 bytes | data | record | record ...

    record    address, 4 bytes | length, 4 bytes | CRC-32 of address, length and data, 4 bytes | data

Numbers have their high byte first.  A module answers Y when its program is in the memory, so `write`
and `append` return only when a power cut can no longer undo them; if they are interrupted, the former
content stays in place.

    write                                        append
    write a temporary file, fsync it             add a record after the last one, fsync it
    read it back and compare                     read it back and compare
    rename it over the file
    fsync the directory

An append rewrites the whole file instead if it is the first append in a process or after a `write`, if
the previous append failed, or if the records would become much longer than the rest of the file.

New content is on the disk under another name before it gets its final name, so a disk that stores
wrong data is detected in time.  After the last step, nothing can fail.  A power failure during an
append leaves an incomplete record at the end, which is dropped.  If a complete record follows a broken
one, the broken one was damaged after it had been written: this is reported as damage.
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
    """The content of a memory, in a file; a `write` or `append` takes effect completely or not at all.

    For a large memory, `append` writes only the changes.  The temporary file has a fixed name, so that
    repeatedly killed processes leave one such file, not many.  Two stores must not share a file.  Symbolic
    links are not followed: a link with the name of the temporary file is removed; a link in place of
    the memory file is refused.

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
        """Return the content of the memory; empty if the file does not exist.

        Raises:
            StoreError: the file cannot be read, is damaged, or is not a slewline memory.
        """
        with self._refusals("read"):
            return bytes(self._unpacked(self._found()))

    def write(self, data: bytes) -> None:
        """Replace the content, even if it is damaged; return when the new content is safely on the disk.

        Raises:
            StoreError: the new content is not safely on the disk; or the file is not a slewline memory, and is
                left unchanged.
        """
        self._content, self._end = None, 0
        with self._refusals("write"):
            self._replace(packed(data))

    def append(self, data: bytes, at: int | None = None) -> None:
        """Write bytes at the address `at`, or at the end if it is None; return when they are safely on the disk.

        Raises:
            StoreError: the bytes are not safely on the disk; or the file is damaged, or not a slewline memory.
            UsageError: the address is beyond the end of the content.
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
        """Append a record to the file, or rewrite the file with `content`, which already includes the change.

        `data` are the changed bytes; `place` is their address and length, as packed in the record.
        """
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
        """Append a record and return True; if the file is missing or is not `end` bytes long, only return False."""
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
            raise StoreError(f"{self.path} is a symbolic link; name the file itself")
        if self.path.exists() and not (self.path.is_file() or self.path.is_dir()):  # opening a FIFO would block
            raise StoreError(f"{self.path} is not a regular file; name another file")
        try:
            found = self._load(self.path)
        except FileNotFoundError:
            return b""
        if not found.startswith((MAGIC, JOURNAL)):
            raise StoreError(f"{self.path} is not a slewline memory; name another file")
        return found

    def _unpacked(self, found: bytes) -> bytearray:
        """Return the content of the memory, given all bytes of its file; raise StoreError if they are damaged."""
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
        """Convert operating-system errors in the block into StoreError; report every StoreError to `on_failure`."""
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
    """Return the bytes of a memory file that has no records: the header and the data."""
    return HEADER.pack(magic, len(data), crc32(data)) + data


def repeated(content: bytearray, found: bytes, at: int) -> bool:
    """Apply the records in the file's bytes `found` to `content`; return False if a record is damaged.

    The first record is at index `at` of `found`.  A last record that is merely incomplete is ignored.
    """
    while (place := record_at(found, at)) is not None:
        address, length = place
        if address > len(content):
            return False
        put(content, found[at + RECORD.size : at + RECORD.size + length], address)
        at += RECORD.size + length
    return all(record_at(found, later) is None for later in range(at + 1, len(found) - RECORD.size))


def record_at(found: bytes, at: int) -> tuple[int, int] | None:
    """Return the address and length of the data in the record at `at`.

    Return None if the record is incomplete, damaged or empty.
    """
    if at + RECORD.size >= len(found):
        return None
    address, length, check = RECORD.unpack_from(found, at)
    end = at + RECORD.size + length
    if not length or end > len(found) or crc32(found[at : at + PLACE.size] + found[at + RECORD.size : end]) != check:
        return None
    return address, length
