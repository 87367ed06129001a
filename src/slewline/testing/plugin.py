r"""The pytest plugin: one argument of a test is a running module.

    def test_it(gs_c200s): ...                                          a GS-C200S; each part has such a name
    def test_it(cy525): cy525.host.send("A 0\r")                        a part without a serial line: a host on its bus

    @pytest.mark.slewline(on="tcp", straps={"chs": 0}, seed=7)          on: "url", "host", "tcp", "pty", "rfc2217"
    def test_it(gs_c200s): ...

    def test_main(slewline_ports):                                      a program that opens "COM3" itself
        ports = slewline_ports({"COM3": "gs-c200s"})

    def test_two(slewline_module):                                      several modules, or other parts
        left, right = slewline_module("gs-c200"), slewline_module("gs-c200s", on="pty")
        custom = slewline_module("my_lab.mx10:Mx10")

    @pytest.fixture(scope="session")                                    a module for several tests: slewline_for_class,
    def feeder(slewline_for_session):                                   slewline_for_module or slewline_for_session
        return slewline_for_session("gs-c200s")

The report of a failed test contains a section for each module: seed, faults, findings and the last lines of the
transcript.  A run without these fixtures loads only this file.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from ..core.chip import Chip
    from .controller import Controller
    from .ports import Ports, Usb

    Make = Callable[..., Controller]

OURS = Path(__file__).resolve().parent.parent  # the package
REPORTED = 4  # modules that a test has closed, still included in its report
MODULES: pytest.StashKey[list[Controller]] = pytest.StashKey()


def pytest_configure(config: pytest.Config) -> None:
    """Register the marker."""
    config.addinivalue_line(
        "markers",
        "slewline(on=None, straps={}, seed=0, rate=None, store=None, memory=None, **options): how the modules of the "
        "fixtures slewline_module, slewline_ports and of each part are set up",
    )


def _maker(request: pytest.FixtureRequest) -> Iterator[Make]:
    """Yield a function that creates running modules, which are closed at the end of the fixture's scope.

    The scope is a test, a class ...  The function's arguments, such as `("gs-c200s", on="tcp", straps={"chs": 0})`,
    override those of the marker `slewline`; a marker on a test overrides those on its class and its test module.
    """
    from .endpoints import running

    modules: list[Controller] = request.node.stash.setdefault(MODULES, [])
    marked: dict[str, Any] = {}
    for marker in request.node.iter_markers("slewline"):  # the closest marker first
        if marker.args:
            from ..errors import UsageError

            given = ", ".join(map(repr, marker.args))
            raise UsageError(
                f"marker slewline({given}): allowed only keyword arguments, such as "
                "@pytest.mark.slewline(straps={...})"
            )
        marked = {**marker.kwargs, **marked}
    kept = REPORTED if request.scope == "function" else 1

    def make(part: str | type[Chip], **settings: Any) -> Controller:
        made = running(part, **{**marked, **settings})
        for old in [module for module in modules if module.closed][:-kept]:  # closed modules that a report includes
            modules.remove(old)
        modules.append(made)
        return made

    yield make
    while modules:
        modules.pop().close()


slewline_module = pytest.fixture(name="slewline_module")(_maker)
slewline_for_class = pytest.fixture(scope="class", name="slewline_for_class")(_maker)
slewline_for_module = pytest.fixture(scope="module", name="slewline_for_module")(_maker)
slewline_for_session = pytest.fixture(scope="session", name="slewline_for_session")(_maker)


@pytest.fixture
def slewline_ports(slewline_module: Make) -> Iterator[Callable[..., Ports]]:
    """Yield a function that assigns modules to port names for one test: {"/dev/ttyUSB0": "gs-c200s"}.

    A program that opens such a name with pySerial or serialx finds the module.  A value may also be a module that
    `slewline_module` has created.  `usb` contains the adapters' entries in the port list:
    {"/dev/ttyUSB0": {"vid": 0x0403, "pid": 0x6001, "serial_number": "A50285BI"}}; all other arguments are passed to
    `slewline_module`.
    """
    from .ports import check_modules, named_ports

    with ExitStack() as stack:

        def put(ports: Mapping[str, Any], usb: Mapping[str, Usb] | None = None, **settings: Any) -> Ports:
            if not isinstance(ports, Mapping):
                from ..errors import UsageError

                raise UsageError(
                    f'slewline_ports({ports!r}): expected modules, keyed by port, such as {{"COM3": "gs-c200s"}}'
                )
            made = {
                name: slewline_module(module, **settings) if isinstance(module, str | type) else module
                for name, module in ports.items()
            }
            check_modules(made)
            return stack.enter_context(named_ports(made, usb))

        yield put


def _module(part: str) -> Any:
    def make(slewline_module: Make) -> Controller:
        return slewline_module(part)

    make.__doc__ = f"Return a running {part.upper()}."
    return pytest.fixture(name=part.replace("-", "_"))(make)


cy500 = _module("cy500")
cy512 = _module("cy512")
cy525 = _module("cy525")
cy545 = _module("cy545")
cy545b = _module("cy545b")
gs_c200 = _module("gs-c200")
gs_c200s = _module("gs-c200s")
mc1151a = _module("mc1151a")
mc1251a = _module("mc1251a")
mc1451a = _module("mc1451a")
mc1151a_e = _module("mc1151a-e")
mc1251a_e = _module("mc1251a-e")
mc1451a_e = _module("mc1451a-e")


def hidden(excinfo: pytest.ExceptionInfo[BaseException]) -> bool:
    """Return whether to hide slewline's frames in a traceback: true for a user error, explained by its message."""
    errors = sys.modules.get("slewline.errors")
    return errors is not None and excinfo.errisinstance(errors.SlewlineError)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Add the modules to the report of a failed test; hide slewline's frames in tracebacks of user errors."""
    if call.excinfo is not None:
        for entry in call.excinfo.traceback:
            if OURS in Path(entry.path).parents:
                entry.frame.f_globals.setdefault("__tracebackhide__", hidden)
    report = yield
    if report.failed:
        used = getattr(item, "fixturenames", ())
        nodes = [item, *(node for node in item.listchain() if f"slewline_for_{type(node).__name__.lower()}" in used)]
        for module in (module for node in nodes for module in node.stash.get(MODULES, [])):
            report.sections.append((f"slewline: {module.label}", module.report()))
    return report
