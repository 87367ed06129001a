"""Spread over workers: pytest -n 2."""

import pytest
import serial
from feeder import FORMAT, Feeder

pytestmark = pytest.mark.slewline(straps={"chs": 0})


@pytest.mark.parametrize("steps", range(-100, 101, 10))
def test_a_sheet_is_fed(gs_c200s, steps):
    with serial.serial_for_url(gs_c200s.url, 9600, **FORMAT) as port:
        feeder = Feeder(port)
        if steps:
            feeder.feed(steps)
            feeder.wait()
        assert feeder.position == steps
    gs_c200s.assert_steps(abs(steps))


@pytest.mark.slewline(on="tcp")
@pytest.mark.parametrize("number", range(4))
def test_every_worker_has_ports_of_its_own(gs_c200s, number):
    with serial.serial_for_url(gs_c200s.url, timeout=60) as port:
        assert Feeder(port).ask("F") == "R"
