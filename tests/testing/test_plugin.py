"""The pytest plugin, as somebody else's tests use it: found by its entry point."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np  # noqa: F401 (what a run in this process loads first is unloaded behind it, and numpy loads once)
import pytest

import slewline.testing.endpoints  # stays loaded between the runs
import slewline.testing.protocol_slewline  # noqa: F401

pytest_plugins = ["pytester"]

FEEDER = """
import pytest, serial

def feed(url, steps):
    with serial.serial_for_url(url, 9600, 7, "O", 2, timeout=60) as port:
        for line in (b"Po?\\r", b"S104\\r", b"T100u\\r", b"R507\\r", steps, b"EU\\r"):
            port.write(line)
            assert port.read_until(b"\\r") == b"YY\\r"
"""
GOOD = """
def test_one_argument_is_a_running_module(gs_c200s):
    feed(gs_c200s.url, b"+200=\\r")
    gs_c200s.until_idle()
    gs_c200s.assert_steps(200, direction=+1)

def test_another_part(gs_c200):
    gs_c200.assert_reply("Q", "END")
    assert gs_c200.chip.sheet.part == "gs-c200"

def test_several(slewline_module):
    left, right = slewline_module("gs-c200"), slewline_module("gs-c200s")
    feed(right.url, b"+5p\\r")
    right.until_idle()
    assert (left.position, right.position) == (0, 5)

@pytest.mark.slewline(on="tcp", straps={"chs": 0}, eeprom_time="20 ms")
@pytest.mark.parametrize("n", range(3))
def test_markers_say_how_it_is_set_up(gs_c200s, n):
    assert gs_c200s.url.startswith("socket://127.0.0.1:")
    with serial.serial_for_url(gs_c200s.url, timeout=60) as port:
        port.write(b"M\\r")
        assert port.read_until(b"\\r") == b"Y\\r"
    assert gs_c200s.now < 40 * 10**9
"""
BAD = """
@pytest.mark.slewline(seed=7)
def test_that_fails(gs_c200s):
    gs_c200s.faults.enable_held_low(at="70 ms")
    feed(gs_c200s.url, b"+200=\\r")
    gs_c200s.ask("F")
    gs_c200s.advance("1 s")
    gs_c200s.assert_steps(200)

@pytest.mark.slewline(on="usb")
def test_with_a_mistake(gs_c200s):
    pass
"""
REPORT = [
    ">*gs_c200s.assert_steps(200)",
    "E*AssertionError: 1 step found, expected 200",
    "*- slewline: gs-c200s on url -*",
    "gs-c200s at slewline://gs-c200s[?]name=gs_c200s_*, seed 7, time 1.0*, position 1",
    "gs_c200s: *enable*",
    "faults and findings:",
    "70 ms  faults  fault: ENABLE held low: enable=0 (seed 7)",
    "transcript (< to the module, > to the host), 16 of 16 lines:",
    "*0.001000 gs_c200s ! pySerial is connected",
    "*0.001000 gs_c200s < Po[?]\\r",
    "*0.007729 gs_c200s > YY\\r",
    "*< FV\\r",
    "*> BR\\r",
]


@pytest.fixture
def run(pytester, monkeypatch):
    """Run a test file, warnings being errors; in a process of its own, with these plugins only, if asked for."""

    def run(code, *arguments, alone=()):
        pytester.makepyfile(FEEDER + code)
        run = pytester.runpytest_subprocess if alone else pytester.runpytest_inprocess
        if alone:  # loading those that happen to be installed here takes longer than the tests
            monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
        elif os.environ.get("PYTEST_DISABLE_PLUGIN_AUTOLOAD"):  # under tools/mutations.py
            alone = ("slewline.testing.plugin",)
        plugins = (word for plugin in ("no:cacheprovider", *alone) for word in ("-p", plugin))
        return run("-W", "error", *plugins, *arguments)

    return run


@pytest.mark.system
def test_it_works_under_xdist(run):
    result = run(GOOD + BAD, "-n", "1", "--strict-markers", alone=("slewline", "xdist"))
    result.assert_outcomes(passed=6, failed=1, errors=1)
    result.stdout.fnmatch_lines(REPORT)


def test_it_works(run):
    run(GOOD, "--strict-markers").assert_outcomes(passed=6)


def test_failures_are_reported(run):
    result = run(BAD + "def test_that_passes(gs_c200s):\n    gs_c200s.ask('F')\n", "-rA")
    result.assert_outcomes(passed=1, failed=1, errors=1)
    result.stdout.fnmatch_lines(REPORT)
    result.stdout.fnmatch_lines(["E*UsageError: on='usb'; allowed url, host, tcp, pty, rfc2217"])
    assert result.stdout.str().count("- slewline: ") == 1


TWO_SIDES = """
def test_both(cy545, cy545b):
    for module in (cy545, cy545b):
        with serial.serial_for_url(module.url, timeout=2) as port:
            port.write(b"\\r\\rN 30\\r+\\rG\\r")
            module.until_idle()
            module.assert_steps(30, direction=+1)
            module.assert_reply("? P", "P=00000030")

@pytest.mark.slewline(on="tcp", fixed_baud=9600)
def test_marked(cy545b):
    assert cy545b.ask("? N") == "N=00000200"
"""


def test_fixtures_have_the_names_of_their_parts(run):
    run(TWO_SIDES, "--strict-markers").assert_outcomes(passed=2)


@pytest.mark.system
def test_a_run_that_does_not_use_it_never_loads_the_simulator(run):
    code = """
import sys

def test_it():
    ours = {name for name in sys.modules if name.startswith("slewline")}
    assert ours == {"slewline", "slewline.lazy", "slewline.version", "slewline.testing", "slewline.testing.plugin"}
    assert "numpy" not in sys.modules
"""
    run(code, alone=("slewline",)).assert_outcomes(passed=1)


@pytest.mark.system
def test_it_works_without_pyserial():
    code = "import sys; sys.modules['serial'] = None; from slewline.testing.endpoints import running; "
    code += "module = running('gs-c200s'); print(module.ask('F'), module.url)"
    ran = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout == "R slewline://gs-c200s?name=gs_c200s_1\n"


SCOPES = """
@pytest.fixture(scope="session")
def plant(slewline_for_session):
    return slewline_for_session("gs-c200s", straps={"chs": 0})

@pytest.fixture(scope="class")
def pair(slewline_for_class):
    return [slewline_for_class("gs-c200s", on=on, straps={"chs": 0}) for on in ("url", "tcp")]

class TestOne:
    def test_first(self, plant, pair):
        assert plant.ask("Po") == "Y"
        assert [module.ask("F") for module in pair] == ["R", "R"]

    def test_second(self, plant, pair):
        assert plant.ask("A1") == "Y"
        assert pair[0].now > 10**9

class TestTwo:
    def test_third(self, plant, pair):
        assert plant.ask("Px") == "Y"
        assert pair[0].now == 10**9

    def test_that_fails(self, plant):
        plant.assert_reply("Q", "END")

def test_that_fails_without_a_module(tmp_path):
    assert not tmp_path

def test_that_fails_with_one_that_it_has_closed(slewline_module):
    with slewline_module("gs-c200s", on="tcp", straps={"chs": 0}) as module:
        module.ask("V1")
    assert module is None
"""


def test_fixtures_of_a_class_and_a_session_and_who_reports_them(run):
    result = run(SCOPES)
    result.assert_outcomes(passed=3, failed=3)
    said = result.stdout.str()
    assert said.count("- slewline: ") == 2
    result.stdout.fnmatch_lines(["*test_that_fails *", "*- slewline: gs-c200s on url -*", "*> END?r"])
    result.stdout.fnmatch_lines(["*- slewline: gs-c200s on tcp -*", "*> V+0?r"])


MARKED = """
pytestmark = pytest.mark.slewline(straps={"chs": 0}, seed=3)

@pytest.mark.slewline(seed=4)
class TestMarked:
    @pytest.mark.slewline(on="tcp")
    def test_it(self, gs_c200s):
        assert (gs_c200s.seed, gs_c200s.label, gs_c200s.ask("V1")) == (4, "gs-c200s on tcp", "V+0")
        assert "< V1" in gs_c200s.report()
"""


def test_markers_of_a_test_its_class_and_its_module_add_up(run):
    run(MARKED).assert_outcomes(passed=1)
