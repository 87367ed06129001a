"""Non-volatile memory of a part: the bench gives the part a store, which the part reads and writes.

content   0 ........ 17 ........ 23            the bytes of a store, from address 0 on
write     0 ........ 17 ........ 23            replaces all bytes
append               17 ..                     replaces some bytes, or adds bytes at the end
pending   still writing                        for a store that is still writing after the call
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, Protocol, TypeVar

from ...errors import StoreError, UsageError
from ..datasheet.option import Option

T = TypeVar("T")


class Store(Protocol):
    """Non-volatile memory.  `read` and `write` raise OSError on a memory fault."""

    def read(self) -> bytes:
        """Return the content; empty if nothing was ever written."""

    def write(self, data: bytes) -> None:
        """Replace the content, completely or not at all."""


class AppendStore(Store, Protocol):
    """A store for a large memory that accepts partial writes.

    Parts that do not need partial writes accept any store.
    """

    def append(self, data: bytes, at: int | None = None) -> None:
        """Write bytes into the content, all of them or none, at a cost independent of the length of the content.

        Args:
            data: the bytes, which replace as many bytes starting at `at`; bytes beyond the end extend the
                content.
            at: address, 0 to the length of the content; by default its end.

        Raises:
            UsageError: there would be a gap before `at`; to avoid this in a new, empty memory, a part must first
                `write` the whole content.
        """


def is_pending(store: Store) -> bool:
    """Return whether a store is still writing earlier data; always False for a store without `pending`.

    Raises:
        OSError: the store could not write the data.
    """
    pending = getattr(store, "pending", None)
    return pending is not None and bool(pending())


class Memory:
    """A store that keeps its content in the model, and loses it when the model ends."""

    def __init__(self, data: bytes = b"") -> None:
        self._content = bytearray(data)

    @property
    def data(self) -> bytes:
        """The content of the memory."""
        return bytes(self._content)

    def read(self) -> bytes:
        """Return the content; empty until data is written."""
        return bytes(self._content)

    def write(self, data: bytes) -> None:
        """Replace the content."""
        self._content = bytearray(data)

    def append(self, data: bytes, at: int | None = None) -> None:
        """Write bytes into the content at address `at`, by default at the end of the content.

        Raises:
            UsageError: there would be a gap before `at`.
        """
        put(self._content, data, at)


class JournaledStore:
    """A store that reports its faults to a journal: failed calls, delays, and content other than that written.

    Calls are numbered from `begin` on; in a replay, `ReplayedStore` repeats the faults at the same calls.

    Args:
        record: a function that takes keyword arguments: `call`, the number of the call, and its fault
            (`error`, `content`, `pending`).
    """

    def __init__(self, store: Store, record: Callable[..., object]) -> None:
        self.store, self._record = store, record
        self._known = Memory()  # content of the store in a replay
        self._calls: int | None = None

    def begin(self) -> bytes:
        """Return the content, and start numbering the calls."""
        self._known.write(self.store.read())
        self._calls = 0
        if isinstance(self.store, ReplayedStore):
            self.store.begin()
        return self._known.data

    def read(self) -> bytes:
        """Return the content of the store."""
        data = self._reporting(self.store.read)
        if self._calls and data != self._known.data:
            self._record(call=self._calls, content=list(data))
        self._known.write(data)
        return data

    def write(self, data: bytes) -> None:
        """Replace the content of the store."""
        self._reporting(lambda: self.store.write(data))
        self._known.write(data)

    def append(self, data: bytes, at: int | None = None) -> None:
        """Write bytes into the content of the store; if the store has no `append`, write the whole content to it."""
        append = getattr(self.store, "append", None)
        if append is not None:
            self._reporting(lambda: append(data, at))
            self._known.append(data, at)
        else:
            whole = bytearray(self._known.data)
            put(whole, data, at)
            self.write(bytes(whole))

    def pending(self) -> bool:
        """Return whether the store is still writing; only calls that return True or fail are numbered."""
        try:
            pending = is_pending(self.store)
        except OSError as error:
            if self._calls is not None:
                self._calls += 1
                with suppress(OSError):
                    self._known.write(self.store.read())
                self._record(call=self._calls, pending=False, error=str(error), content=list(self._known.data))
            raise
        if pending and self._calls is not None:
            self._calls += 1
            self._record(call=self._calls, pending=True)
        return pending

    def detach(self, faults: Mapping[int, Mapping[str, Any]]) -> None:
        """Keep the content in the model from now on; repeat the faults of the recorded run (see `ReplayedStore`)."""
        self.store = ReplayedStore(self._known.data, faults, self._calls)

    def attach(self, store: Store) -> None:
        """Keep the content in `store` from now on; write it there only if `store` has a different content.

        Raises:
            OSError: the new store could not be written; the content remains in the present store.
        """
        if store.read() != self._known.data:
            store.write(self._known.data)
            if (wait := getattr(store, "wait", None)) is not None:
                wait()
            is_pending(store)
        self.store = store

    def _reporting(self, call: Callable[[], T]) -> T:
        if self._calls is not None:
            self._calls += 1
        try:
            return call()
        except OSError as error:
            if self._calls:
                self._record(call=self._calls, error=str(error))
            raise

    def __getattr__(self, name: str) -> Any:
        return getattr(self.store, name)


class ReplayedStore(Memory):
    """The memory of a replay, which repeats the faults of the recorded store (see `JournaledStore`).

    Args:
        faults: the fault of each call, keyed by the number of the call: its `error`, the `content` that was
            found, or `pending`.
        calls: the number of calls before the replay; None if numbering starts with `begin`.
    """

    def __init__(self, data: bytes, faults: Mapping[int, Mapping[str, Any]], calls: int | None = None) -> None:
        super().__init__(data)
        self._faults, self._calls = faults, calls

    def begin(self) -> None:
        """Start numbering the calls."""
        self._calls = 0

    def read(self) -> bytes:
        """Return the content, after repeating the fault that is recorded for this call, if any."""
        self._call()
        return super().read()

    def write(self, data: bytes) -> None:
        self._call()
        super().write(data)

    def append(self, data: bytes, at: int | None = None) -> None:
        """Write bytes into the content at an address, by default at the end of the content."""
        self._call()
        super().append(data, at)

    def pending(self) -> bool:
        """Return whether, at this call, the store of the recorded run was still writing."""
        if self._calls is None or "pending" not in (fault := self._faults.get(self._calls + 1, {})):
            return False
        self._call()
        return bool(fault["pending"])

    def _call(self) -> None:
        if self._calls is None:
            return
        self._calls += 1
        fault = self._faults.get(self._calls, {})
        if "content" in fault:
            self._content = bytearray(fault["content"])
        if "error" in fault:
            raise StoreError(fault["error"])


def put(content: bytearray, data: bytes, at: int | None = None) -> int:
    """Write bytes into the content of a memory, as `AppendStore.append` does; return the first byte's address."""
    address = len(content) if at is None else at
    if not 0 <= address <= len(content):
        raise UsageError(f"append at {at}: the memory has {len(content)} bytes; allowed 0 to {len(content)}")
    content[address : address + len(data)] = data
    return address


class BufferedStore:
    """A large memory with a write buffer: `put` changes `content`, and `flush` writes the changes to the store.

    Changed bytes that are close to each other are written as one piece, so a flush costs about as much as
    writing a few bytes.  While the store is still writing, further changes wait for the next flush.

    Args:
        store: where the memory is kept; a store without `append` is given the whole content with every flush.
        content: the first content if the store is empty; it is then written to the store immediately.

    Raises:
        OSError: the store could not be written.
    """

    CLOSE = 16  # bytes of the largest gap that is written, too; a separate piece costs as much

    def __init__(self, store: Store, content: bytes) -> None:
        found = store.read()
        self.store, self.content = store, bytearray(found or content)
        self.unsaved: set[int] = set()  # changed addresses, until the store has written them
        self._given: set[int] = set()  # the addresses that it is writing
        if not found:
            store.write(content)
            self.wait()
            is_pending(store)

    def put(self, address: int, byte: int) -> None:
        """Write a byte (0 to 255) to an address."""
        self.content[address] = byte
        self.unsaved.add(address)
        self._given.discard(address)

    def wait(self) -> None:
        """Wait until the store has written the data, or has failed."""
        if (wait := getattr(self.store, "wait", None)) is not None:
            wait()

    def flush(self) -> bool:
        """Write all unsaved changes to the store, unless it is still writing; return whether all are now written.

        Raises:
            OSError: the store could not be written; the next flush repeats all data that the store may lack.
        """
        return self._is_written() and (not self.unsaved or self._give())

    def _is_written(self) -> bool:
        """Return whether the store has written all data given to it; if so, mark these data as saved."""
        try:
            if is_pending(self.store):
                return False
        except OSError:
            self._given.clear()
            raise
        self.unsaved -= self._given
        self._given.clear()
        return True

    def _give(self) -> bool:
        append = getattr(self.store, "append", None)
        if append is None:
            self.store.write(bytes(self.content))
        else:
            for first, last in self._pieces():
                append(bytes(self.content[first : last + 1]), first)
        self._given = set(self.unsaved)
        return self._is_written()

    def _pieces(self) -> list[tuple[int, int]]:
        """Return, for each piece of the content to be written, the addresses of its first and its last byte."""
        pieces: list[tuple[int, int]] = []
        for address in sorted(self.unsaved):
            if pieces and address - pieces[-1][1] <= self.CLOSE:
                pieces[-1] = pieces[-1][0], address
            else:
                pieces.append((address, address))
        return pieces


def _missing(store: object) -> str:
    has = all(callable(getattr(store, name, None)) for name in ("read", "write"))
    return "" if has else "expected an object with read() and write(data)"


STORE = Option(
    "store",
    "object",
    None,
    "non-volatile store of the memory: an object with read() and write(data); by default it ends with the bench",
    none=True,
    check=_missing,
)
