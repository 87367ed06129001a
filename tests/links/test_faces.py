"""Modules of a fixture behind real ports: a program with pySerial in one thread, the module in another."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest
import serial

from slewline.language.lines import framed
from slewline.testing.endpoints import running

from .conftest import patient

# A pseudo-terminal is opened as 8N1: it passes 8 bits, and the line takes 7 of them.
SETTINGS = {"tcp": {}, "pty": {}, "rfc2217": {"bytesize": 7, "parity": "O", "stopbits": 2}}
DEADLINE_S = 60
pytestmark = pytest.mark.filterwarnings(
    "ignore:set.* is deprecated:DeprecationWarning"
)  # of pySerial's own RFC 2217 client


MARKS = {"pty": [pytest.mark.posix, pytest.mark.system], "rfc2217": [pytest.mark.system]}


@pytest.fixture(params=[pytest.param(on, marks=MARKS.get(on, [])) for on in SETTINGS])
def module(request):
    """A running module on each kind of port."""
    module = running("gs-c200s", on=request.param, seed=5)
    module.settings = SETTINGS[request.param]
    yield module
    module.close()
    assert not module.rig.thread.is_alive()
    assert not Path(module.rig.folder).exists()


def opened(module):
    return serial.serial_for_url(patient(module.url), timeout=DEADLINE_S, **module.settings)


def test_a_program_and_the_test_share_a_module(module):
    with opened(module) as port:
        for command in ("Po", "S10", "T100", "R50", "+200", "E"):
            port.write(framed(command))
            assert port.read_until(b"\r") == b"YY\r"
        module.until("mov=1")
        began = module.now
        module.advance("100 ms")
        assert module.now - began == 10**11
        module.assert_reply("F", "B")
        module.until_idle()
        module.assert_steps(200, direction=1)
        port.write(framed("V1"))
        assert port.read_until(b"\r") == framed("V+200")
    assert [line for line in module.report().splitlines() if "> V+200" in line]


def test_an_exchange_takes_the_same_virtual_time_on_every_face(module):
    url = running("gs-c200s")
    times = []
    for face in (url, module):
        face.ask("F")
        began = face.now
        face.ask("V1")
        times.append(face.now - began)
    url.close()
    assert times[0] == times[1]


def test_faults_and_their_failures_reach_the_test(module):
    with module.faults.power_cut(at=module.now + 10**9):
        module.advance("2 ms")
        assert not module.chip.powered
    module.assert_reply("Q", "END")
    module.faults.wrong_parity()
    module.assert_reply("F", "E1")
    with pytest.raises(ValueError, match="is in the past"):
        module.faults.power_cut(at=0)
    with pytest.raises(ZeroDivisionError):
        module.rig.do(lambda: 1 // 0)
    module.assert_reply("F", "R")


def test_modules_leave_no_threads():
    before = {*threading.enumerate()}  # those of other tests may end meanwhile
    modules = [running("gs-c200s", on="tcp") for _ in range(5)]
    assert len({*threading.enumerate()} - before) == 5
    for module in modules:
        module.close()
    assert not {*threading.enumerate()} - before
