"""Settings of all tests."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

from tests import compiling, surroundings

HERE = Path(__file__).parent
MARKS = {"docs": "check", "house": "check"}  # of all tests in a folder

surroundings.clear()

# examples are the same in every run, and how long one takes says only how busy the machine is
settings.register_profile("slewline", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("slewline")

gc.disable()  # while tests are collected: whatever is made then stays, and to look through it took half of that time


PLACE = pytest.StashKey[surroundings.Place]()
LEFT: list[str] = []  # what tests have left behind, a line each


def pytest_configure(config: pytest.Config) -> None:
    """Give the run its folder for temporary files; workers have it from the process that starts them."""
    if not hasattr(config, "workerinput"):
        config.stash[PLACE] = surroundings.Place()


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile a new checkout once, not in each worker."""
    compiling.share(session)


@pytest.hookimpl(wrapper=True, trylast=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Keep processes and terminals out of tests that are not marked for them."""
    with surroundings.alone(item):
        return (yield)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fail a run that leaves processes or temporary files."""
    if not hasattr(session.config, "workeroutput"):
        LEFT.extend(session.config.stash[PLACE].leave(failed=session.testsfailed > 0))
        if LEFT and not session.testsfailed:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED
    # A worker ends its children now, because pytest waits for whoever holds a worker's pipes.
    elif left := surroundings.end_processes(child_of=os.getpid()):
        session.config.workeroutput["left"] = left


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any) -> None:
    """Take over what a worker has found."""
    LEFT.extend(getattr(node, "workeroutput", {}).get("left", ()))


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say what the tests have left."""
    for line in LEFT:
        terminalreporter.write_line(f"left by the tests: {line}")


def pytest_collection_finish(session: pytest.Session) -> None:
    """Keep what was collected, ten thousand tests, out of every collection of garbage."""
    gc.freeze()
    gc.enable()
    hush(session.config)


@pytest.hookimpl(tryfirst=True)  # before marks are asked for
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what is marked by its folder; skip what needs POSIX where there is none."""
    for item in items:
        if mark := MARKS.get(item.path.relative_to(HERE).parts[0]):
            item.add_marker(mark)
        if "browser" in getattr(item, "fixturenames", ()):
            item.add_marker("check")
    if not hasattr(os, "openpty"):
        for item in items:
            if item.get_closest_marker("posix"):
                item.add_marker(pytest.mark.skip(reason="needs POSIX"))


def hush(config: pytest.Config) -> None:
    """Let a worker of pytest-xdist say of a test that passes only that it did.

    It says six things of each test, most of which nobody shows: that it begins and ends, and how its set-up and its
    tear-down went.  To say and to hear them cost more than half of what a short test takes.  Whoever asks for a line
    about each test, for durations or for a report in a file gets all of it.
    """
    told = config.option
    if told.verbose > 0 or told.durations is not None or told.xmlpath is not None:
        return
    for worker in config.pluginmanager.get_plugins():
        if type(worker).__name__ == "WorkerInteractor":
            worker.sendevent = only_news(worker.sendevent)


def only_news(send: Callable[..., None]) -> Callable[..., None]:
    """Send what a summary needs: results of calls, and whatever went wrong."""

    def sendevent(name: str, **said: Any) -> None:
        if name == "testreport":
            report = said["data"]
            row = report.get("_report_type") == "SubTestReport"
            if report["outcome"] == "passed" and (row or report["when"] != "call"):
                return
        if name not in ("logstart", "logfinish"):
            send(name, **said)

    return sendevent


@pytest.fixture(autouse=True)
def named_modules() -> Iterator[None]:
    """Forget, at the end, the modules to which URLs have given names: they stay as long as the process."""
    yield
    if rig := sys.modules.get("slewline.testing.rig"):
        rig.NAMED.clear()
