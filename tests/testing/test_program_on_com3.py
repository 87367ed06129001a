"""A pySerial program that opens "COM3" itself, not a line of it changed, finds a module, on Windows and elsewhere.

The class that pySerial has on Windows cannot be imported elsewhere; one that stands for it takes its place here, with
ports of its own that must stay what they are.
"""

from __future__ import annotations

import runpy

import pytest
import serial
from serial.serialutil import SerialBase, SerialException

PROGRAM = """
import serial


def main(name="COM3"):
    with serial.Serial(name, 9600, bytesize=7, parity="O", stopbits=2, timeout=2) as port:
        said = []
        for line in (b"Po", b"S10", b"T100", b"R20", b"+40", b"E"):
            port.write(line + b"\\r")
            said.append(port.read_until(b"\\r"))
        return said
"""


# where tests.elsewhere has taken POSIX away, pySerial's class for it fails in another way
NOBODY = (SerialException, AttributeError)


class Win32(SerialBase):
    """What pySerial has on Windows, with a port COM1 at which somebody says x."""

    def open(self):
        if self.port != "COM1":
            raise SerialException(f"could not open port {self.port!r}: FileNotFoundError(2)")
        self.is_open = True

    def close(self):
        self.is_open = False

    def _reconfigure_port(self):
        pass

    @property
    def in_waiting(self):
        return 7

    def read(self, size=1):
        return b"x" * size

    def write(self, data):
        return len(data)

    _update_rts_state = _update_dtr_state = close

    def reset_input_buffer(self):
        pass


@pytest.fixture(params=["this system", "Windows"])
def system(request, monkeypatch):
    if request.param == "Windows":
        monkeypatch.setattr(serial, "Serial", Win32)
    return request.param


@pytest.fixture
def main(tmp_path):
    (tmp_path / "program.py").write_text(PROGRAM)
    return runpy.run_path(str(tmp_path / "program.py"))["main"]


@pytest.mark.parametrize("name", ["COM3", "com3", r"\\.\COM3"])
def test_it_finds_the_module(system, main, slewline_ports, name):
    ports = slewline_ports({"COM3": "gs-c200s"}, straps={"chs": 0})
    assert main(name) == [b"Y\r"] * 6
    ports["COM3"].until_idle()
    ports["COM3"].assert_steps(40, direction=+1)


def test_two_ports_are_two_modules_and_the_others_what_they_were(system, main, slewline_ports):
    ports = slewline_ports({"COM3": "gs-c200s", r"\\.\COM14": "gs-c200s"}, straps={"chs": 0})
    assert main("COM14") == [b"Y\r"] * 6
    ports[r"\\.\COM14"].until_idle()
    assert (ports["COM3"].position, ports[r"\\.\COM14"].position) == (0, 40)
    with pytest.raises(NOBODY):
        main("COM4")
    if system == "Windows":
        with serial.Serial("COM1") as real:
            assert (real.read(3), real.in_waiting, real.write(b"abc")) == (b"xxx", 7, 3)
            assert not hasattr(real, "_end")


def test_the_class_is_as_it_was_when_the_test_is_over(system, main, slewline_module):
    from slewline.testing.ports import named_ports

    before, cls = dict(vars(serial.Serial)), serial.Serial
    module = slewline_module("gs-c200s", straps={"chs": 0})
    with named_ports({"COM3": module}):
        assert vars(cls) != before and serial.Serial is cls
        assert main() == [b"Y\r"] * 6
    assert dict(vars(cls)) == before
    with pytest.raises(NOBODY):
        main()
