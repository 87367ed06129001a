"""What a part keeps without power: a store is handed in by the bench, and the part sees nothing else of it.

content   0 ........ 17 ........ 23            a store holds bytes from address 0 on
          write: all of them again
append:             |new| at 17                some of them, or more after the last one
pending             is it still being written?    where a store returns before it has written
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
        """Return the content; empty when nothing was ever written."""

    def write(self, data: bytes) -> None:
        """Make this the content, all of it or nothing of it."""


class AppendStore(Store, Protocol):
    """A store that a large memory is kept in: what changes is appended.  Parts that do not append take any store."""

    def append(self, data: bytes, at: int | None = None) -> None:
        """Put some bytes into the content, all of them or none, at a cost that does not depend on its length.

        Args:
            data: replace as many bytes from `at` on; what reaches beyond the end makes the content longer.
            at: address, 0 to the length of the content; by default its end.

        Raises:
            UsageError: there would be a hole before `at`: what a new memory holds is for the part to write.
        """


def is_pending(store: Store) -> bool:
    """Return whether a store is still writing what it was given last; one without `pending` has written it.

    Raises:
        OSError: it has refused that.
    """
    pending = getattr(store, "pending", None)
    return pending is not None and bool(pending())


class Memory:
    """Non-volatile memory that lives as long as the model."""

    def __init__(self, data: bytes = b"") -> None:
        self._content = bytearray(data)

    @property
    def data(self) -> bytes:
        """The content."""
        return bytes(self._content)

    def read(self) -> bytes:
        """Return the content; empty when nothing was ever written."""
        return bytes(self._content)

    def write(self, data: bytes) -> None:
        """Make this the content."""
        self._content = bytearray(data)

    def append(self, data: bytes, at: int | None = None) -> None:
        """Put some bytes into the content from `at` on, by default after its end.

        Raises:
            UsageError: there would be a hole before `at`.
        """
        put(self._content, data, at)


class JournaledStore:
    """A store whose faults a journal gets: calls that it refuses, delays, and another content than it was given.

    Calls are numbered from `begin` on; in a replay `ReplayedStore` does at the same calls what this one did.

    Args:
        tell: called with the number of a call, and the text of its error or the content found.
    """

    def __init__(self, store: Store, tell: Callable[..., object]) -> None:
        self.store, self._tell = store, tell
        self._known = Memory()  # what the store of a replay holds
        self._calls: int | None = None

    def begin(self) -> bytes:
        """Return the content, and begin to number the calls."""
        self._known.write(self.store.read())
        self._calls = 0
        if isinstance(self.store, ReplayedStore):
            self.store.begin()
        return self._known.data

    def read(self) -> bytes:
        """Return the content, as the store does."""
        data = self._told(self.store.read)
        if self._calls and data != self._known.data:
            self._tell(call=self._calls, content=list(data))
        self._known.write(data)
        return data

    def write(self, data: bytes) -> None:
        """Make this the content, as the store does."""
        self._told(lambda: self.store.write(data))
        self._known.write(data)

    def append(self, data: bytes, at: int | None = None) -> None:
        """Put some bytes into the content, as the store does; one that cannot gets all of it."""
        append = getattr(self.store, "append", None)
        if append is not None:
            self._told(lambda: append(data, at))
            self._known.append(data, at)
        else:
            whole = bytearray(self._known.data)
            put(whole, data, at)
            self.write(bytes(whole))

    def pending(self) -> bool:
        """Return whether the store is still writing; a call of its own if it is, or has refused what it was given."""
        try:
            pending = is_pending(self.store)
        except OSError as error:
            if self._calls is not None:
                self._calls += 1
                with suppress(OSError):
                    self._known.write(self.store.read())
                self._tell(call=self._calls, pending=False, error=str(error), content=list(self._known.data))
            raise
        if pending and self._calls is not None:
            self._calls += 1
            self._tell(call=self._calls, pending=True)
        return pending

    def detach(self, faults: Mapping[int, Mapping[str, Any]]) -> None:
        """Keep the content in the model from now on, with the faults of a replay (see `ReplayedStore`)."""
        self.store = ReplayedStore(self._known.data, faults, self._calls)

    def attach(self, store: Store) -> None:
        """Keep the content in another store from now on; one that holds something else gets it, others are not written.

        Raises:
            OSError: it has refused; the content stays where it is.
        """
        if store.read() != self._known.data:
            store.write(self._known.data)
            if (wait := getattr(store, "wait", None)) is not None:
                wait()
            is_pending(store)
        self.store = store

    def _told(self, call: Callable[[], T]) -> T:
        if self._calls is not None:
            self._calls += 1
        try:
            return call()
        except OSError as error:
            if self._calls:
                self._tell(call=self._calls, error=str(error))
            raise

    def __getattr__(self, name: str) -> Any:
        return getattr(self.store, name)


class ReplayedStore(Memory):
    """The memory of a replay, with the faults of the store that it stands for (see `JournaledStore`).

    Args:
        faults: by the number of the call: its `error`, or the `content` that was found.
        calls: how many there were before; None: they are numbered from `begin` on.
    """

    def __init__(self, data: bytes, faults: Mapping[int, Mapping[str, Any]], calls: int | None = None) -> None:
        super().__init__(data)
        self._faults, self._calls = faults, calls

    def begin(self) -> None:
        """Begin to number the calls."""
        self._calls = 0

    def read(self) -> bytes:
        """Return the content."""
        self._call()
        return super().read()

    def write(self, data: bytes) -> None:
        self._call()
        super().write(data)

    def append(self, data: bytes, at: int | None = None) -> None:
        """Put some bytes into the content from `at` on, by default after its end."""
        self._call()
        super().append(data, at)

    def pending(self) -> bool:
        """Return whether the store of the recorded run was still writing."""
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
    """Put some bytes into a content, as `AppendStore.append` says; return the address."""
    address = len(content) if at is None else at
    if not 0 <= address <= len(content):
        raise UsageError(f"append at {at}: the memory has {len(content)} bytes; allowed 0 to {len(content)}")
    content[address : address + len(data)] = data
    return address


class BufferedStore:
    """A large memory on its way to a store: what is put is there at once, and `flush` brings it to the store.

    Bytes that stand close together go as one piece, so a flush costs as much as a few bytes do.  While the store is
    still writing, what is put waits for the next flush.

    Args:
        store: where the memory is kept; one without `append` gets all of it with every flush.
        content: what the memory holds if the store is empty, which then gets it at once.

    Raises:
        OSError: the store has refused.
    """

    CLOSE = 16  # bytes between two that go together; a piece of its own costs as much

    def __init__(self, store: Store, content: bytes) -> None:
        found = store.read()
        self.store, self.content = store, bytearray(found or content)
        self.unsaved: set[int] = set()  # addresses that have been put, until the store has written them
        self._given: set[int] = set()  # those of them that it is writing
        if not found:
            store.write(content)
            self.wait()
            is_pending(store)

    def put(self, address: int, byte: int) -> None:
        """Put a byte, 0 to 255, at an address."""
        self.content[address] = byte
        self.unsaved.add(address)
        self._given.discard(address)

    def wait(self) -> None:
        """Wait until the store has written, or refused, what it was given."""
        if (wait := getattr(self.store, "wait", None)) is not None:
            wait()

    def flush(self) -> bool:
        """Bring to the store what has been put since the last flush; return whether it has all of it now.

        Raises:
            OSError: the store has refused; everything that it may lack goes with the next flush.
        """
        return self._is_written() and (not self.unsaved or self._give())

    def _is_written(self) -> bool:
        """Return whether the store has what it was given."""
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
        """The first and the last address of each piece that is to be kept."""
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
    "what keeps the memory without power: an object with read() and write(data); gone with the bench by default",
    none=True,
    check=_missing,
)
