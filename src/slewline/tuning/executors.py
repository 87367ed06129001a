"""Executors of runs: this process, a pool of processes, or an existing Dask cluster."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from importlib import import_module
from logging import CRITICAL, getLogger
from multiprocessing.context import SpawnContext, SpawnProcess
from signal import SIG_IGN, SIGINT, signal
from typing import Any, NamedTuple

from ..core.messages.whole import whole
from ..errors import UsageError
from ..extras import needs
from ..lifeline import end_of_parent, follow, obey_termination, termination_deferred
from ..version import __version__

ANSWER_TIMEOUT = "10 s"  # for a scheduler that does not answer
AHEAD = 2  # runs in flight per concurrent run
MOST_JOBS = 256


class Workers(NamedTuple):
    """An executor, the number of runs kept in flight, and the message shown if the executor fails."""

    executor: Executor
    window: int
    remedy: str


class Inline(Executor):
    """An executor that makes calls immediately, in this thread."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Return a completed future with the result of a call."""
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


INLINE = Workers(Inline(), 1, "")


class Worker(SpawnProcess):
    """A process of the pool; it ends when its parent process ends."""

    def start(self) -> None:
        """Start the process."""
        with termination_deferred():
            super().start()

    def run(self) -> None:
        """Execute the pool's tasks."""
        signal(SIGINT, SIG_IGN)  # Windows does not delay signals
        obey_termination()  # used by a pool whose worker has died to end the others
        follow(end_of_parent)
        super().run()


class WorkerContext(SpawnContext):
    """A context that creates workers, and can kill them."""

    def __init__(self) -> None:
        super().__init__()
        self.made: list[Worker] = []

    def Process(self, *args: Any, **kwargs: Any) -> Worker:  # type: ignore[override]
        """Return a new worker."""
        self.made.append(Worker(*args, **kwargs))
        return self.made[-1]

    def kill(self) -> None:
        """Kill all workers, even in the middle of a task."""
        for worker in self.made:
            if worker.pid is not None:
                worker.kill()


@contextmanager
def cancelled_quietly() -> Iterator[None]:
    """Hide the error that a pool's internal thread raises for a cancelled task when the workers are killed."""
    from concurrent.futures import InvalidStateError

    before = threading.excepthook

    def hook(found: threading.ExceptHookArgs) -> None:
        if found.exc_type is not InvalidStateError:
            before(found)

    threading.excepthook = hook
    try:
        yield
    finally:
        threading.excepthook = before


@contextmanager
def processes(jobs: int) -> Iterator[Workers]:
    """Yield a pool of `jobs` processes on this machine; with one job, this process makes the runs itself.

    Raises:
        UsageError: the number of processes is not allowed.
    """
    from concurrent.futures import ProcessPoolExecutor

    number = whole(jobs)
    if number is None or not 1 <= number <= MOST_JOBS:
        raise UsageError(f"jobs {jobs!r}; allowed 1..{MOST_JOBS} processes")
    if number == 1:
        yield INLINE
        return
    context = WorkerContext()
    with termination_deferred():  # a process of Python's own is started, too, which cleans up
        pool = ProcessPoolExecutor(number, mp_context=context)
    with pool:
        try:
            yield Workers(pool, AHEAD * number, "a process of the pool has died; try fewer jobs")
        except BaseException:  # the running tasks are not awaited
            with cancelled_quietly():
                context.kill()
                pool.shutdown()
            raise


@contextmanager
def dask(address: str) -> Iterator[Workers]:
    """Yield the executor of a Dask cluster.

    A cluster runs any code sent to it as pickles, so use only your own cluster.

    Raises:
        UsageError: Dask is not installed, the cluster is not found or has no workers, or a worker's version
            of slewline differs from that of this process.
    """
    try:
        make: Any = import_module("distributed").Client  # typed only in some versions
    except ImportError as error:
        raise UsageError(needs("--dask needs", "dask")) from error
    where = f"Dask cluster {address!r}"
    remedy = "expected the address of a running scheduler, such as tcp://127.0.0.1:8786; start one with: dask scheduler"
    try:
        client = make(address, timeout=ANSWER_TIMEOUT, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise UsageError(f"{where}: {_first_line(error)}; {remedy}") from None
    silent = [(logger, logger.level) for logger in map(getLogger, ("distributed", "tornado"))]
    for logger, _ in silent:
        logger.setLevel(CRITICAL)  # our own message is enough for a lost cluster
    try:
        threads = sum(client.nthreads().values())
        if not threads:
            raise UsageError(f"{where} has no workers; start one with: dask worker {address}")
        _check_versions(client, where)
        remedy = f"{where} is gone; start a scheduler and a worker again"
        yield Workers(client.get_executor(pure=False), AHEAD * threads, remedy)
    finally:
        client.close(timeout=1)
        for logger, level in silent:
            logger.setLevel(level)


def version_here() -> str:
    """Return the version of slewline in this process, which the workers must have as well."""
    return __version__


def _check_versions(client: Any, where: str) -> None:
    """Refuse workers whose version of slewline differs from that of this process, since verdicts may differ."""
    for worker, found in sorted(client.run(version_here, on_error="return").items()):
        if found != __version__:
            has = f"slewline {found}" if isinstance(found, str) else f"no slewline ({_first_line(found)})"
            raise UsageError(
                f"{where}: the worker {worker} has {has}, this computer has {__version__}; "
                f"install {__version__} on the workers, and restart them"
            )


def _first_line(error: BaseException) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
