"""Mistakes that come naturally in tests with the fixtures: each is answered, and none with our inside."""

from __future__ import annotations

import re

import numpy as np  # noqa: F401 (what a run in this process loads first is unloaded behind it, and numpy loads once)
import pytest

import slewline.testing.endpoints
import slewline.testing.ports  # noqa: F401 (stays loaded between the runs)

pytest_plugins = ["pytester"]

MISTAKES = [  # arguments, what the test does or the marker says, the end of the answer
    ("gs_c200s", "gs_c200s.sleep(1)", 'write gs_c200s.advance("10 ms")'),
    ("gs_c200s", "gs_c200s.run('1 s')", 'write gs_c200s.advance("10 ms")'),
    ("gs_c200s", "gs_c200s.run_until_idle()", "write gs_c200s.until_idle()"),
    ("gs_c200s", "gs_c200s.findings", "write gs_c200s.chip.findings"),
    ("gs_c200s", "gs_c200s.query('V1')", "gs_c200s.ask(...), or the calls of gs_c200s.host, where there is one"),
    ("gs_c200s", "gs_c200s.advance(1)", "write its unit, such as '1 ms' or '1 ps'"),
    (
        "gs_c200s",
        "gs_c200s.advance(0.5)",
        "expected text such as '0.5 s', bench.now, or an integer number of picoseconds",
    ),
    ("gs_c200s", "gs_c200s.until('mov')", "expected a pin and its level, such as 'mov=0'"),
    ("gs_c200s", "gs_c200s.until('moving=0')", "gs_c200s (gs-c200s) has no pin 'moving'"),
    ("gs_c200s", "gs_c200s.until('mov=1', timeout=5)", "write its unit, such as '5 ms' or '5 ps'"),
    ("gs_c200s", "gs_c200s.until('mov=1', '1 ms')", "waited 1 ms for gs_c200s.mov=1"),
    ("gs_c200s", "gs_c200s.pin('slew')", "has no pin 'slew'; its pins: sel0"),
    ("gs_c200s", "gs_c200s.pin('ui1').drive('low')", "level 'low'; allowed 0, 1"),
    ("gs_c200s", "gs_c200s.pin('ui1').level = 0", "write pin.drive(0)"),
    (
        "gs_c200s",
        "gs_c200s.assert_steps('200')",
        "expected the number of steps, their instants, or the steps of another run",
    ),
    ("gs_c200s", "gs_c200s.assert_steps(0, since=0.5)", "a float would be rounded"),
    ("gs_c200s", "gs_c200s.assert_steps(0, axis=2)", "has no axis 2; its only axis is 1"),
    ("gs_c200s", "gs_c200s.assert_steps(0, direction='cw')", "allowed +1 (clockwise), -1, or None for either"),
    ("gs_c200s", "gs_c200s.assert_edges('slew', [])", "has no pin 'slew'"),
    ("gs_c200s", "gs_c200s.assert_edges('mov', ['10 ms'])", 'then the level from that instant on: ("10 ms", 1)'),
    ("gs_c200s", "gs_c200s.assert_edges('mov', [('10 ms', 'high')])", "then the level from that instant on"),
    ("cy525", "cy525.host.send('A 0'); cy525.assert_steps(3)", "0 steps found, expected 3; host: sending to cy525"),
    ("cy525", "cy525.url", "cy525 (cy525) has no url, because no program can reach it"),
    ("cy525", "cy525.ask('A 0')", "'A 0' has no answer; ask() is for 'V 0'"),
    ("cy525", "cy525.host.query('V 0')", "host has no 'query'; write host.ask(...)"),
    ("slewline_module", "slewline_module('gs-c20')", "did you mean gs-c200?"),
    ("slewline_module", "slewline_module('gs-c200s', on='usb')", "on='usb'; allowed url, host, tcp, pty, rfc2217"),
    ("slewline_module", "slewline_module('gs-c200s', baud=9600)", "no option 'baud'"),
    (
        "slewline_module",
        "slewline_module('gs-c200s', straps={'chs': 2})",
        "strap chs=2; a strap sets an input to 0 or 1",
    ),
    ("gs_c200s", "gs_c200s.faults.drop_byte()", "faults has no 'drop_byte'; write faults.lost_byte()"),
    ("slewline_ports", "slewline_ports({'COM3': 'gs-c200s'})['COM4']", "no port 'COM4'; available: COM3"),
    ("slewline_ports", "slewline_ports(['COM3'])", 'expected modules, keyed by port, such as {"COM3": "gs-c200s"}'),
    ("slewline_ports", "slewline_ports({'COM3': 'cy525'})", "only parts with a serial line, and only with on='url'"),
]
FIXED = [  # what a marker says, the end of the answer: the fixture itself fails
    ('on="usb"', "on='usb'; allowed url, host, tcp, pty, rfc2217"),
    ('straps={"ch": 0}', "did you mean chs?"),
    ("eeprom_tme=3", "did you mean eeprom_time?"),
    ('{"chs": 0}', "allowed only keyword arguments, such as @pytest.mark.slewline(straps={...})"),
]


@pytest.fixture(autouse=True)
def loaded(monkeypatch):
    """Load the plugin as pytest does for users, even where this run was told not to."""
    monkeypatch.delenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", raising=False)


def test_mistakes_in_tests_are_answered_in_a_line(pytester):
    """All of them in one run, which takes less than a run for each."""
    code = "import pytest\n"
    for number, (argument, line, _) in enumerate(MISTAKES):
        code += f"def test_{number}({argument}):\n    {line}\n"
    for number, (marker, _) in enumerate(FIXED, len(MISTAKES)):
        code += f"@pytest.mark.slewline({marker})\ndef test_{number}(gs_c200s):\n    pass\n"
    pytester.makepyfile(code)
    output = pytester.runpytest_inprocess("-p", "no:randomly").stdout.str()
    sections = dict(
        re.findall(r"^_+ (?:ERROR at setup of )?test_(\d+) _+\n(.*?)(?=^_{5,} |^={5,} )", output, re.S | re.M)
    )
    assert len(sections) == len(MISTAKES) + len(FIXED)
    for number, (*_, says) in enumerate([*MISTAKES, *FIXED]):
        error = [line for line in sections[str(number)].splitlines() if line.startswith("E ")]
        shown = sections[str(number)].partition("- slewline: ")[0].splitlines()
        assert says in " ".join(error), f"{number}: {error}"
        assert len(shown) < 12 and "slewline/testing/" not in "".join(shown), sections[str(number)]


def test_the_full_trace_shows_our_inside(pytester):
    pytester.makepyfile("def test_it(gs_c200s):\n    gs_c200s.advance(1)\n")
    shown = pytester.runpytest_inprocess("--full-trace").stdout.str()
    assert "slewline/testing/controller.py" in shown and "bare number is picoseconds" in shown
