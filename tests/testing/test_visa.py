"""A program of PyVISA that opens modules by the backend @slewline, in virtual time."""

from __future__ import annotations

import pickle
from time import perf_counter

import pytest

from slewline.errors import Timeout, UsageError
from slewline.testing.endpoints import running
from slewline.testing.ports import named_ports

pyvisa = pytest.importorskip("pyvisa")
pytest.importorskip("pyvisa_py")
pytest.importorskip("serial")

LINE = {
    "data_bits": 7,
    "parity": pyvisa.constants.Parity.odd,
    "stop_bits": pyvisa.constants.StopBits.two,
    "read_termination": "\r",
    "write_termination": "\r",
}
ADAPTIVE = {"read_termination": "\r", "write_termination": "\r"}
MODULE = "ASRLslewline://gs-c200s?chs=0::INSTR"


@pytest.fixture
def manager():
    """A resource manager; its sessions are closed at the end."""
    manager = pyvisa.ResourceManager("@slewline")
    yield manager
    manager.close()


def port_of(session):
    """The port of a session, as pySerial has it."""
    return session.visalib.sessions[session.session].interface


def test_a_program_is_entered_run_and_polled(manager):
    with manager.open_resource(MODULE, **LINE) as session:
        assert [session.query(line) for line in ("Po", "S10", "T100", "R50", "+1200", "E")] == ["Y"] * 6
        polls = 0
        while session.query("F") == "B":
            polls += 1
        assert polls > 20
        assert session.query("V1") == "V+1200"
        port = port_of(session)
        assert len(port.chip.steps()) == 1200
        assert port.bench.findings == []
        assert port.bench.now_ps > 10**12  # more than a second
    assert not port.is_open


def test_a_chip_that_finds_the_rate_is_queried(manager):
    with manager.open_resource("ASRLslewline://cy545::INSTR", baud_rate=19200, **ADAPTIVE) as session:
        session.write_raw(b"\r\r")
        session.write("+")
        session.write("N 400")
        assert session.query("? N") == "N=00000400"
        session.write("G")
        port_of(session).sleep(5)
        assert session.query("? P") == "P=00000400"
        assert port_of(session).bench.findings == []


def test_a_timeout_is_virtual(manager):
    began = perf_counter()
    with manager.open_resource(MODULE, timeout=60_000, **LINE) as session:
        with pytest.raises(pyvisa.VisaIOError) as caught:
            session.read()
        assert caught.value.error_code == pyvisa.constants.StatusCode.error_timeout
        assert 60 * 10**12 <= port_of(session).bench.now_ps < 61 * 10**12
        assert session.query("V1") == "V+0"
    assert perf_counter() - began < 30


def test_a_timeout_is_that_of_the_whole_message(manager):
    with manager.open_resource("ASRLslewline://cy545::INSTR", **ADAPTIVE) as session:
        session.write_raw(b"\r\r? N\r")
        port_of(session).flush()
        session.timeout = 6  # the first character comes within it, all eleven of them do not
        with pytest.raises(pyvisa.VisaIOError):
            session.read()
        session.timeout = 1000
        assert session.read().endswith("00")  # the rest


def test_a_timeout_of_0_polls(manager):
    with manager.open_resource(MODULE, timeout=0, **LINE) as session:
        with pytest.raises(pyvisa.VisaIOError):
            session.read()
        assert port_of(session).bench.now_ps < 10 * 10**9


def test_no_timeout_raises_where_nothing_can_come(manager):
    with manager.open_resource(MODULE, timeout=None, **LINE) as session, pytest.raises(Timeout, match="no more can"):
        session.read()


def test_the_given_number_of_bytes_is_read(manager):
    with manager.open_resource(MODULE, **LINE) as session:
        session.write("V1")
        assert session.read_bytes(2) == b"V+"
        assert session.bytes_in_buffer in (0, 1, 2)
        assert session.read() == "0"


def test_a_module_under_a_name_is_listed_and_found_again(manager):
    module = running("gs-c200s", straps={"chs": 0})
    name = f"ASRL{module.url}::INSTR"
    listed = manager.list_resources()
    assert name in listed
    assert "ASRLslewline://cy545::INSTR" in listed
    assert not [each for each in listed if "cy525" in each]  # it has a bus
    assert manager.list_resources("?*cy545b?*") == ("ASRLslewline://cy545b::INSTR",)
    with manager.open_resource(name, **LINE) as session:
        assert [session.query(line) for line in ("Po", "S10", "T100", "R50", "+200", "E")] == ["Y"] * 6
    module.until_idle()
    with manager.open_resource(name, **LINE) as session:
        assert session.query("V1") == "V+200"
    module.close()


def test_a_program_that_opens_its_port_by_name_finds_the_module(manager):
    name, module = "/dev/ttyUSB0", running("gs-c200s", straps={"chs": 0})
    with named_ports({name: module}), manager.open_resource(f"ASRL{name}::INSTR", timeout=60_000, **LINE) as session:
        assert session.query("V1") == "V+0"
        began = perf_counter()
        with pytest.raises(pyvisa.VisaIOError):
            session.read()
        assert perf_counter() - began < 30


def test_a_served_module_is_opened_as_a_socket(manager):
    module = running("gs-c200s", on="tcp", straps={"chs": 0})
    host, port = module.url.removeprefix("socket://").split(":")
    with manager.open_resource(f"TCPIP::{host}::{port}::SOCKET", timeout=60_000, **ADAPTIVE) as session:
        assert session.query("V1") == "V+0"
    module.close()


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("ASRLslewline://gs-c2000::INSTR", "did you mean gs-c200"),
        ("ASRLslewline://cy525::INSTR", "has no serial line"),
        ("ASRLslewline://gs-c200s?chs=2::INSTR", "a strap sets an input to 0 or 1"),
    ],
)
def test_a_name_that_means_no_module_is_refused(manager, name, says):
    with pytest.raises(UsageError, match=says):
        manager.open_resource(name)


def test_a_name_that_means_nothing_is_refused_as_always(manager):
    with pytest.raises(pyvisa.VisaIOError, match="INV_RSRC_NAME"):
        manager.open_resource("nothing::INSTR::at::all")


@pytest.mark.parametrize(
    ("settings", "why"),
    [
        ({}, "line-end: the host ends its lines with CR LF"),  # of PyVISA: CR LF
        ({"write_termination": ""}, "unfinished: "),
        ({"baud_rate": 4800}, "format: line is set to 4800 7O2, and gs_c200s to 9600 7O2"),
        ({"read_termination": "\r\n"}, r"received b'R\\r' without b'\\n', the termination character"),
        (
            {"read_termination": "\r\n", "parity": pyvisa.constants.Parity.even},
            r"format: line is set to 9600 7E2.*; E1: .*; received b'E1\\r' without b'\\n'",
        ),
        (
            {"read_termination": None, "end_input": pyvisa.constants.SerialTermination.none},
            r"received b'R\\r', and noth",
        ),
    ],
    ids=["line end", "no line end", "rate", "read end", "read end and parity", "no read end"],
)
def test_a_timeout_reports_the_reason_known_to_the_module(manager, settings, why):
    usual = {key: value for key, value in LINE.items() if settings or not key.endswith("termination")}
    with manager.open_resource(MODULE, timeout=500, **{**usual, **settings}) as session:
        for _ in range(2):
            with pytest.raises(pyvisa.VisaIOError, match=f"^VI_ERROR_TMO .* slewline: {why}") as raised:
                session.query("F")
        assert raised.value.error_code == pyvisa.constants.StatusCode.error_timeout
        assert str(pickle.loads(pickle.dumps(raised.value))) == str(raised.value)  # as xdist does


def test_a_timeout_after_an_answer_reports_the_state_of_the_module(manager):
    with manager.open_resource(MODULE, timeout=100, **{**LINE}) as session:
        assert session.query("?") == "E4"
        assert session.query("F") == "R"
        with pytest.raises(pyvisa.VisaIOError, match="slewline: gs_c200s: waiting for a command"):
            session.read()
