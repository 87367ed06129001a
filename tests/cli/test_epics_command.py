"""slewline epics: what is wrong is told before anything is served."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from slewline.cli.main import invoke
from slewline.labs.channel_access import port_of_server
from slewline.testing.endpoints import running
from tests.ports import free_port

pytest.importorskip("caproto")
serial = pytest.importorskip("serial")

RAMP = ("S=10", "T=1000 steps/s", "R=50")
OPTIONS = ("--part", "gs-c200s", "--record", "m1")


@pytest.fixture
def module():
    """A module without checksums, and how a program speaks to it."""
    module = running("gs-c200s", straps={"chs": 0})
    yield module
    module.close()


def refused(capsys, *arguments):
    """What is said; nothing is served."""
    assert invoke(["epics", *map(str, arguments)]) in (1, 2)
    out, err = capsys.readouterr()
    assert out == ""
    return err


@pytest.mark.parametrize(
    ("name", "says"), [("lab:m1.VAL", "write lab:m1"), ("lab m1", "write lab_m1"), ("", "give one, such as lab:m1")]
)
def test_an_invalid_record_name_is_not_served(capsys, module, name, says):
    assert says in refused(capsys, module.url, "--part", "gs-c200s", "--record", name, *RAMP)


@pytest.mark.parametrize(
    ("parameters", "says"),
    [
        (("S=10", "R=50"), "no value for T (slew speed, 1..1000 (10 steps/s))"),
        ((*RAMP, "X=1"), "no parameter 'X'"),
        ((*RAMP, "S=20"), "'S=20'; expected each parameter of the ramp once, as in S=10"),
        (("S10", *RAMP), "'S10'; expected each parameter of the ramp once, as in S=10"),
        (("S=10", "T=5000", "R=50"), "T '5000'; allowed 1..1000"),
        ((*RAMP, "--resolution", "0"), "expected units per step"),
        ((*RAMP, "--every", "0 s"), "--every 0 ps; allowed 50 ms to 3600 s"),
        ((*RAMP, "--every", "2"), "'--every': time '2': expected a number and a unit"),
        ((*RAMP, "--baud", "1000"), "--baud 1000: not a rate of the GS-C200S"),
    ],
)
def test_wrong_parameters_are_reported(capsys, module, parameters, says):
    assert says in refused(capsys, module.url, *OPTIONS, *parameters)
    assert module.position == 0


def test_an_address_that_other_machines_reach_needs_an_option(capsys, module, monkeypatch):
    monkeypatch.setenv("EPICS_CAS_INTF_ADDR_LIST", "127.0.0.1 0.0.0.0")
    told = refused(capsys, module.url, *OPTIONS, *RAMP)
    assert "EPICS_CAS_INTF_ADDR_LIST 0.0.0.0: other machines could move the motor; add --allow-remote" in told
    told = refused(capsys, module.url, *OPTIONS, "--allow-remote", "S=10")
    assert "no value for T" in told


@pytest.mark.parametrize("name", ["EPICS_CA_SERVER_PORT", "EPICS_CAS_SERVER_PORT"])
@pytest.mark.parametrize("port", ["abc", "0", "65536", "-1"])
def test_an_invalid_port_variable_is_reported(capsys, module, monkeypatch, name, port):
    monkeypatch.setenv(name, port)
    told = refused(capsys, module.url, *OPTIONS, *RAMP)
    assert f"{name} '{port}' in the environment; allowed port numbers, 1 to 65535" in told


def test_the_port_of_the_server_is_that_of_either_variable(monkeypatch):
    monkeypatch.delenv("EPICS_CAS_SERVER_PORT", raising=False)
    monkeypatch.setenv("EPICS_CA_SERVER_PORT", "15071")
    assert port_of_server() == 15071
    monkeypatch.setenv("EPICS_CAS_SERVER_PORT", "15072")
    assert port_of_server() == 15072


def test_a_missing_port_is_reported(capsys):
    assert "/dev/none: No such file or directory" in refused(capsys, "/dev/none", *OPTIONS, *RAMP)


def test_a_part_without_a_serial_line_is_reported(capsys, module):
    said = refused(capsys, module.url, "--part", "cy525", "--record", "m1", *RAMP)
    assert "no serial line" in said


def test_another_program_is_not_replaced_unasked(capsys, module):
    with serial.serial_for_url(module.url, 9600, bytesize=7, parity="O", stopbits=2, timeout=2) as port:
        for line in (b"Po", b"S10", b"T100", b"R50", b"+200", b"Px"):
            port.write(line + b"\r")
            assert port.read_until(b"\r") == b"Y\r"
    said = refused(capsys, module.url, *OPTIONS, *RAMP)
    assert "its RAM contains a program of 4 lines, which moves would replace; save it with slewline pull" in said
    assert module.ask("Q").count("\r") == 4


COMMAND = "import slewline.testing; from slewline.cli.main import main; main()"  # pySerial knows slewline://
READ = "from caproto.sync.client import read; print(read('m1.EGU', timeout=20, repeater=False).data[0].decode())"


@pytest.mark.system
@pytest.mark.parametrize("name", ["EPICS_CA_SERVER_PORT", "EPICS_CAS_SERVER_PORT"])
def test_a_client_finds_the_record_at_the_port_of_either_variable(name):
    port = str(free_port())
    surroundings = {key: value for key, value in os.environ.items() if not key.startswith("EPICS_")}
    words = ["epics", "slewline://gs-c200s?chs=0", *OPTIONS, "--replace", *RAMP]
    server = subprocess.Popen(
        [sys.executable, "-c", COMMAND, *words], stdout=subprocess.PIPE, text=True, env=surroundings | {name: port}
    )
    try:
        assert server.stdout.readline() == f"m1: 127.0.0.1:{port}\n"
        own = {"EPICS_CA_SERVER_PORT": port, "EPICS_CA_ADDR_LIST": "127.0.0.1", "EPICS_CA_AUTO_ADDR_LIST": "NO"}
        asked = subprocess.run(
            [sys.executable, "-c", READ],
            env=surroundings | own,
            check=True, capture_output=True, text=True, timeout=60,
        )  # fmt: skip
        assert asked.stdout == "steps\n"
    finally:
        server.terminate()
        server.wait(60)
        server.stdout.close()
