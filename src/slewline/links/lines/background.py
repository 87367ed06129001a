"""A memory file written by a separate thread, so that a slow disk delays one module, not the whole server.

    module     M .............................. Y         write ... pending? ... pending? ... no: it is written
    thread       [ write, fsync, read back, rename ]
    others     continue

In this example, a GS-C200 stores its program (command M) and then answers Y.  A later `write`
replaces content whose writing has not begun, so at most two versions of the content are pending.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from ...core.memory.store import Memory
from ...core.time.hook import Hook
from ...errors import StoreError
from .memory_file import FileStore

WRITE_TIMEOUT_S = 0.001


class BackgroundStore:
    """A store whose writes return before the data has been written; see `core.memory.store`.

    All its methods are called in one thread, the server's; `on_failure` is called in that thread, too.

    Args:
        store: the store that writes; it must have no other user.
        timeout_s: the time in seconds for which `pending` waits for the write, so that a module need not
            poll again and again when virtual time passes faster than the wall clock.  None if virtual time
            does not follow the wall clock: then `pending` waits until the data is written.

    Raises:
        StoreError: the store cannot be read.
    """

    def __init__(self, store: FileStore, timeout_s: float | None = WRITE_TIMEOUT_S) -> None:
        self.store, self.timeout_s = store, timeout_s
        self.path = store.path
        self.on_failure: Hook[[str]] = Hook()
        self._content = Memory(store.read())
        self._todo: deque[Callable[[], None]] = deque()
        self._refusal: StoreError | None = None
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None

    # ---------------------------------------------------------------------------------------------------------- store
    def read(self) -> bytes:
        """Return the content that is being written; if no write is in progress, return the content of the file.

        Raises:
            StoreError: as for `FileStore.read`.
        """
        if self._is_at_work():
            return self._content.read()
        try:
            self._content.write(self.store.read())
        except StoreError as refusal:
            self.on_failure(str(refusal))
            raise
        return self._content.read()

    def write(self, data: bytes) -> None:
        """Start replacing the content with `data`; `pending` reports a failure."""
        data = bytes(data)
        self._content.write(data)
        self._do(lambda: self._write(data), alone=True)

    def append(self, data: bytes, at: int | None = None) -> None:
        """Start writing bytes into the content, by default at its end; `pending` reports a failure.

        Raises:
            UsageError: the address is beyond the end.
        """
        data = bytes(data)
        address = len(self._content.data) if at is None else at
        self._content.append(data, at)
        self._do(lambda: self.store.append(data, address))

    def pending(self) -> bool:
        """Return whether the content is still being written.

        Raises:
            StoreError: the write has failed; only the first call after the failure raises this.
        """
        if not self.wait(self.timeout_s):
            return True
        refusal, self._refusal = self._refusal, None
        if refusal is not None:
            self.on_failure(str(refusal))
            raise refusal
        return False

    def wait(self, seconds: float | None = None) -> bool:
        """Wait until no write is in progress, for at most `seconds` if given; return whether all writes have ended."""
        thread = self._thread
        if thread is not None:
            thread.join(seconds)
        return thread is None or not thread.is_alive()

    def close(self) -> None:
        """Wait until the remaining content has been written.

        Raises:
            StoreError: the write has failed.
        """
        self.wait()
        self.pending()

    # --------------------------------------------------------------------------------------------------------- thread
    def _is_at_work(self) -> bool:
        with self._lock:
            return self._thread is not None

    def _do(self, job: Callable[[], None], alone: bool = False) -> None:
        with self._lock:
            if alone:
                self._todo.clear()
            self._todo.append(job)
            if self._thread is None:  # it ends when its work is done: only a process with one thread can be forked
                self._thread = threading.Thread(target=self._run, name=f"{self.path.name} is written", daemon=True)
                self._thread.start()

    def _write(self, data: bytes) -> None:
        self.store.write(data)
        self._refusal = None  # it includes the content that failed before

    def _run(self) -> None:
        while (job := self._next()) is not None:
            try:
                job()
            except Exception as refusal:  # whatever the cause, the module must not wait forever
                self._refusal = StoreError(str(refusal))

    def _next(self) -> Callable[[], None] | None:
        with self._lock:
            if self._todo:
                return self._todo.popleft()
            self._thread = None
            return None
