"""Who does the work: this process, a pool of processes, or a cluster of Dask that is there already."""

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
from ..lifeline import end_of_parent, follow, held_back, obey_termination
from ..version import __version__

PATIENCE = "10 s"  # for a scheduler that does not answer
AHEAD = 2  # runs in flight for each that can be computed at once
MOST_JOBS = 256


class Workers(NamedTuple):
    """An executor, how many runs are kept in flight, and what to say when it fails."""

    executor: Executor
    window: int
    remedy: str


class Inline(Executor):
    """Computes at once, in this thread."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Return the result of a call, which is there already."""
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


INLINE = Workers(Inline(), 1, "")


class Worker(SpawnProcess):
    """A process of the pool, which ends with the one that has started it."""

    def start(self) -> None:
        """Begin."""
        with held_back():
            super().start()

    def run(self) -> None:
        """Compute what it is given."""
        signal(SIGINT, SIG_IGN)  # Windows holds nothing back
        obey_termination()  # by which a pool whose worker has died ends the others
        follow(end_of_parent)
        super().run()


class WorkerContext(SpawnContext):
    """Makes workers, and can end them."""

    def __init__(self) -> None:
        super().__init__()
        self.made: list[Worker] = []

    def Process(self, *args: Any, **kwargs: Any) -> Worker:  # type: ignore[override]
        """Return a new worker."""
        self.made.append(Worker(*args, **kwargs))
        return self.made[-1]

    def kill(self) -> None:
        """End all workers, whatever they are doing."""
        for worker in self.made:
            if worker.pid is not None:
                worker.kill()


@contextmanager
def cancelled_quietly() -> Iterator[None]:
    """Keep the thread of a pool whose workers are killed quiet: it fails at a task that has been cancelled before."""
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
    """Yield a pool of processes of this machine; with one job nothing is started.

    Raises:
        UsageError: no number of processes.
    """
    from concurrent.futures import ProcessPoolExecutor

    number = whole(jobs)
    if number is None or not 1 <= number <= MOST_JOBS:
        raise UsageError(f"jobs {jobs!r}; allowed 1..{MOST_JOBS} processes")
    if number == 1:
        yield INLINE
        return
    context = WorkerContext()
    with held_back():  # a process of Python's own is started, too, which cleans up
        pool = ProcessPoolExecutor(number, mp_context=context)
    with pool:
        try:
            yield Workers(pool, AHEAD * number, "a process of the pool has died; try fewer jobs")
        except BaseException:  # nobody waits for what is being computed
            with cancelled_quietly():
                context.kill()
                pool.shutdown()
            raise


@contextmanager
def dask(address: str) -> Iterator[Workers]:
    """Yield the executor of a cluster of Dask.

    A cluster runs whatever is sent to it, as pickles do: use your own ones only.

    Raises:
        UsageError: no Dask, no cluster at this address, one without workers, or with another version of slewline.
    """
    try:
        make: Any = import_module("distributed").Client  # typed in some of its versions only
    except ImportError as error:
        raise UsageError(needs("--dask needs", "dask")) from error
    where = f"Dask cluster {address!r}"
    remedy = "allowed the address of a running scheduler, such as tcp://127.0.0.1:8786; start one: dask scheduler"
    try:
        client = make(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise UsageError(f"{where}: {_first_line(error)}; {remedy}") from None
    silent = [(logger, logger.level) for logger in map(getLogger, ("distributed", "tornado"))]
    for logger, _ in silent:
        logger.setLevel(CRITICAL)  # of a cluster that is gone one message is enough: ours
    try:
        threads = sum(client.nthreads().values())
        if not threads:
            raise UsageError(f"{where}: has no workers; start one with: dask worker {address}")
        _check_versions(client, where)
        yield Workers(client.get_executor(pure=False), AHEAD * threads, f"{where} is gone; {remedy}, and a worker")
    finally:
        client.close(timeout=1)
        for logger, level in silent:
            logger.setLevel(level)


def version_here() -> str:
    """Return the version of slewline: what a worker is asked for."""
    return __version__


def _check_versions(client: Any, where: str) -> None:
    """Refuse workers with another slewline, whose verdicts may be others."""
    for worker, found in sorted(client.run(version_here, on_error="return").items()):
        if found != __version__:
            has = f"slewline {found}" if isinstance(found, str) else f"no slewline ({_first_line(found)})"
            raise UsageError(
                f"{where}: the worker {worker} has {has}, this computer {__version__}; "
                f"install {__version__} for its workers, and start them again"
            )


def _first_line(error: BaseException) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
