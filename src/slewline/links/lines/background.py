"""A memory in a file that a thread of its own writes: a disk that is slow makes one module wait, not a whole server.

    module     M .............................. Y         write ... pending? ... pending? ... no: it is there
    thread       [ write, fsync, read back, rename ]
    others     go on

What has been given and is not yet being written gives way to a later `write`, so no more than two contents wait.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from ...core.memory.store import Memory
from ...core.time.hook import Hook
from ...errors import StoreError
from .memory_file import FileStore

PATIENCE_S = 0.001


class BackgroundStore:
    """A store that returns before it has written; see `core.memory.store`.

    All its methods are called by one thread, that of the server; `on_failure` is called by it, too.

    Args:
        store: what writes; nothing else may use it.
        patience_s: how long `pending` waits for it, in seconds: where virtual time passes faster than that of the wall
            clock, a module must not ask again and again; None: until it has written, where time follows no clock.

    Raises:
        StoreError: it cannot be read.
    """

    def __init__(self, store: FileStore, patience_s: float | None = PATIENCE_S) -> None:
        self.store, self.patience_s = store, patience_s
        self.path = store.path
        self.on_failure: Hook[[str]] = Hook()
        self._content = Memory(store.read())
        self._todo: deque[Callable[[], None]] = deque()
        self._refusal: StoreError | None = None
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None

    # ---------------------------------------------------------------------------------------------------------- store
    def read(self) -> bytes:
        """Return the content: what is being written, or else what the file has.

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
        """Begin to make this the content; whether it is refused, `pending` says."""
        data = bytes(data)
        self._content.write(data)
        self._do(lambda: self._write(data), alone=True)

    def append(self, data: bytes, at: int | None = None) -> None:
        """Begin to put some bytes into the content; whether it is refused, `pending` says.

        Raises:
            UsageError: the address is beyond the end.
        """
        data = bytes(data)
        address = len(self._content.data) if at is None else at
        self._content.append(data, at)
        self._do(lambda: self.store.append(data, address))

    def pending(self) -> bool:
        """Return whether it is still being written.

        Raises:
            StoreError: it was refused; this is raised once.
        """
        if not self.wait(self.patience_s):
            return True
        refusal, self._refusal = self._refusal, None
        if refusal is not None:
            self.on_failure(str(refusal))
            raise refusal
        return False

    def wait(self, seconds: float | None = None) -> bool:
        """Wait until all has been written, or refused, at most so many seconds; return whether it has."""
        thread = self._thread
        if thread is not None:
            thread.join(seconds)
        return thread is None or not thread.is_alive()

    def close(self) -> None:
        """Write what is left.

        Raises:
            StoreError: it was refused.
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
            if self._thread is None:  # it ends when nothing is left: only a process of one thread keeps its past
                self._thread = threading.Thread(target=self._run, name=f"{self.path.name} is written", daemon=True)
                self._thread.start()

    def _write(self, data: bytes) -> None:
        self.store.write(data)
        self._refusal = None  # what was refused before is in it

    def _run(self) -> None:
        while (job := self._next()) is not None:
            try:
                job()
            except Exception as refusal:  # whatever it is, the module must not wait for ever
                self._refusal = StoreError(str(refusal))

    def _next(self) -> Callable[[], None] | None:
        with self._lock:
            if self._todo:
                return self._todo.popleft()
            self._thread = None
            return None
