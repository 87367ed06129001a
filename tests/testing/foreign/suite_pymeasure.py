"""An instrument of PyMeasure, through its VISA adapter."""

import pytest
from pymeasure.adapters import VISAAdapter
from pymeasure.instruments import Instrument
from pyvisa.constants import Parity, StopBits

LINE = {"data_bits": 7, "parity": Parity.odd, "stop_bits": StopBits.two}
pytestmark = pytest.mark.slewline(straps={"chs": 0})


class Controller(Instrument):
    """A GS-C200S."""

    position = Instrument.measurement("V1", "The position, in steps.", preprocess_reply=lambda text: text[1:], cast=int)
    state = Instrument.measurement("F", "R: ready; B: busy.", cast=str)

    def move(self, steps):
        for line in ("Po", "S10", "T100", "R50", f"{steps:+d}", "E"):
            assert self.ask(line).strip() == "Y", line


@pytest.fixture
def instrument(gs_c200s):
    ends = {"read_termination": "\r", "write_termination": "\r"}
    adapter = VISAAdapter(f"ASRL{gs_c200s.url}::INSTR", visa_library="@slewline", **ends, **LINE)
    yield Controller(adapter, "GS-C200S", includeSCPI=False)
    adapter.close()


def test_it_moves(instrument, gs_c200s):
    instrument.move(250)
    while instrument.state == "B":
        pass
    assert instrument.position == 250
    gs_c200s.assert_steps(250, direction=+1)


def test_it_is_ready(instrument):
    assert instrument.state == "R"
