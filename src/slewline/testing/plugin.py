"""The pytest plugin: one argument of a test is a running module.

    def test_it(gs_c200s): ...                                          a GS-C200S; gs_c200 is a GS-C200

    @pytest.mark.slewline(on="tcp", straps={"chs": 0}, seed=7)          on: "url" (the default), "tcp", "pty", "rfc2217"
    def test_it(gs_c200s): ...

    def test_two(slewline_module):                                      several, or of another part
        left, right = slewline_module("gs-c200"), slewline_module("gs-c200s", on="pty")

The report of a failed test gets a section for each module: seed, faults, findings and the last lines that were said.
A run without these fixtures loads nothing more than this file.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from .controller import Controller

    Make = Callable[..., Controller]

MODULES: pytest.StashKey[list[Controller]] = pytest.StashKey()


def pytest_configure(config: pytest.Config) -> None:
    """Register the marker."""
    config.addinivalue_line(
        "markers",
        "slewline(on='url', straps={}, seed=0, rate=None, store=None, **options): how the modules of the fixtures "
        "gs_c200, gs_c200s and slewline_module are set up",
    )


@pytest.fixture
def slewline_module(request: pytest.FixtureRequest) -> Iterator[Make]:
    """Return a function that makes running modules, for a test that ends them.

    Its arguments, such as `("gs-c200s", on="tcp", straps={"chs": 0})`, come before those of the marker `slewline`.
    """
    from .faces import running

    modules: list[Controller] = request.node.stash.setdefault(MODULES, [])
    marker = request.node.get_closest_marker("slewline")

    def make(part: str, **settings: Any) -> Controller:
        modules.append(running(part, **{**(marker.kwargs if marker else {}), **settings}))
        return modules[-1]

    yield make
    while modules:
        modules.pop().close()


@pytest.fixture
def gs_c200(slewline_module: Make) -> Controller:
    """Return a running GS-C200."""
    return slewline_module("gs-c200")


@pytest.fixture
def gs_c200s(slewline_module: Make) -> Controller:
    """Return a running GS-C200S."""
    return slewline_module("gs-c200s")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Add a report of its modules to a failed test."""
    report = yield
    if report.failed:
        for module in item.stash.get(MODULES, []):
            report.sections.append((f"slewline: {module.label}", module.report()))
    return report
