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

from tests import compiling

HERE = Path(__file__).parent
CHECKED = ("docs", "house", "physics")  # and, wherever it is, what works a browser

# The same examples in every run, and none that fails because the machine was busy while it was drawn or tried.
settings.register_profile("same", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("same")

gc.disable()  # while tests are collected: whatever is made then stays, and to look through it took half of that time


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile a new checkout once, not in each worker."""
    compiling.share(session)


def pytest_collection_finish(session: pytest.Session) -> None:
    """Keep what was collected, ten thousand tests, out of every collection of garbage."""
    gc.freeze()
    gc.enable()
    hush(session.config)


@pytest.hookimpl(tryfirst=True)  # before marks are asked for
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what `make check` runs; skip what needs POSIX where there is none: its terminals, signals, permissions."""
    for item in items:
        if item.path.relative_to(HERE).parts[0] in CHECKED or "browser" in getattr(item, "fixturenames", ()):
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
            if report["when"] != "call" and report["outcome"] == "passed":
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
