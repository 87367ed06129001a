"""In another order in every run: pytest-randomly."""

import pytest
import serial
from feeder import FORMAT, Feeder


@pytest.fixture(scope="session")
def line(slewline_for_session):
    """One module for the whole run; each test finds it wherever the others have left it."""
    return slewline_for_session("gs-c200s", straps={"chs": 0})


@pytest.fixture
def feeder(line):
    with serial.serial_for_url(line.url, 9600, **FORMAT) as port:
        yield Feeder(port)


@pytest.mark.parametrize("steps", [1, -1, 20, -30, 400])
def test_a_sheet_is_fed(feeder, line, steps):
    before, since = feeder.position, line.now
    feeder.feed(steps)
    feeder.wait()
    assert feeder.position == before + steps
    line.assert_steps(abs(steps), since=since)


def test_a_new_module_is_at_zero(gs_c200s):
    assert gs_c200s.position == 0


@pytest.mark.slewline(seed=5, straps={"chs": 0})
@pytest.mark.parametrize("number", range(3))
def test_chance_comes_from_the_seed_alone(gs_c200s, number):
    gs_c200s.faults.garbled_byte()
    assert gs_c200s.ask("F") == "E4"
    assert "has become 0x62" in gs_c200s.report() or "seed 5" in gs_c200s.report()
