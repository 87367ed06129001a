"""An instrument driver on PyVISA: with the backend of slewline, and with PyVISA-py on a socket."""

import pytest
import pyvisa

LINE = {
    "data_bits": 7,
    "parity": pyvisa.constants.Parity.odd,
    "stop_bits": pyvisa.constants.StopBits.two,
    "read_termination": "\r",
    "write_termination": "\r",
}
ENDS = {"read_termination": "\r", "write_termination": "\r"}


@pytest.fixture
def manager():
    manager = pyvisa.ResourceManager("@slewline")
    yield manager
    manager.close()


@pytest.mark.slewline(straps={"chs": 0})
def test_a_session_with_a_module_of_a_fixture(gs_c200s, manager):
    with manager.open_resource(f"ASRL{gs_c200s.url}::INSTR", **LINE) as session:
        assert [session.query(line) for line in ("Po", "S10", "T100", "R50", "+40", "E")] == ["Y"] * 6
        while session.query("F") == "B":
            pass
        assert session.query("V1") == "V+40"
    gs_c200s.assert_steps(40)


@pytest.mark.slewline(on="tcp", straps={"chs": 0})
def test_a_socket_with_pyvisa_py(gs_c200s):
    host, port = gs_c200s.url.removeprefix("socket://").split(":")
    manager = pyvisa.ResourceManager("@py")
    with manager.open_resource(f"TCPIP::{host}::{port}::SOCKET", timeout=60_000, **ENDS) as session:
        assert session.query("F") == "R"
    manager.close()


def test_the_defaults_of_visa_time_out_and_say_why(manager):
    says = r"VI_ERROR_TMO.*slewline: format: line is set to 9600 8N1"
    session = manager.open_resource("ASRLslewline://gs-c200s?chs=0::INSTR")
    with pytest.raises(pyvisa.VisaIOError, match=says):
        session.query("F")
