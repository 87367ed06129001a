"""Names of ports that are modules for one test: what programs do with them beside opening and reading."""

from __future__ import annotations

import asyncio
import io
import sys
from types import ModuleType
from unittest.mock import Mock

import pytest
import serial
import serialx
from serial.tools import list_ports
from serialx import Serial as SerialOfSerialx

from slewline.errors import UsageError
from slewline.testing import aio

SETTINGS = {"baudrate": 9600, "bytesize": 7, "parity": "O", "stopbits": 2, "timeout": 1}
NAME = "/dev/ttyUSB0"
NOBODY = (OSError, AttributeError)  # the latter where tests.elsewhere has taken POSIX away


@pytest.fixture
def ports(slewline_ports):
    return slewline_ports({NAME: "gs-c200s"}, straps={"chs": 0})


def ask(port, command=b"V1"):
    port.write(command + b"\r")
    return port.read_until(b"\r")


def test_text_is_refused_as_a_real_port_does(ports):
    with serial.Serial(NAME, **SETTINGS) as port, pytest.raises(TypeError, match="please encode to bytes: 'V1"):
        port.write("V1\r")


def test_every_form_of_opening_it(ports):
    with serial.Serial(NAME, **SETTINGS) as port:
        assert ask(port) == b"V+0\r" and isinstance(port, serial.Serial)
    with serial.serial_for_url(NAME, **SETTINGS) as port:
        assert ask(port) == b"V+0\r"
    port = serial.serial_for_url(NAME, do_not_open=True, **SETTINGS)
    port.open()
    assert ask(port) == b"V+0\r"
    port.close()
    assert not port.is_open
    port = serial.Serial(**SETTINGS)
    port.port = NAME
    port.open()
    assert ask(port) == b"V+0\r"
    with pytest.raises(serial.SerialException, match="it is open in another program"):
        serial.Serial(NAME, **SETTINGS)
    port.port = NAME  # closes and opens it
    assert ask(port) == b"V+0\r"
    port.close()


def test_settings_lines_breaks_and_buffers_are_those_of_the_module(ports):
    with serial.Serial(NAME, **SETTINGS) as port:
        port.parity = "E"
        assert ask(port, b"F") == b"E1\r"
        port.parity = "O"
        port.rts = False
        assert (port.cts, port.dsr, port.ri) == (False, True, False)
        port.write(b"V1\r")
        while port.in_waiting < 4:
            pass
        port.reset_input_buffer()
        assert port.read(1) == b""
        port.send_break(0.05)
        assert ask(port, b"") == b"E1\r"
        assert port.bench is ports[NAME].bench
        with pytest.raises(io.UnsupportedOperation, match=r'on="pty"'):
            port.fileno()


def test_attributes_of_ports_of_another_system(ports):
    """A program for Windows sets the size of buffers; for other ports of this system that stays an error."""
    with serial.Serial(NAME) as port:
        port.set_buffer_size(rx_size=65536)
        port.set_low_latency_mode(True)
    other = "set_low_latency_mode" if sys.platform == "win32" else "set_buffer_size"
    with pytest.raises(AttributeError, match=f"'Serial' object has no attribute '{other}'"):
        getattr(serial.Serial(), other)(True)


@pytest.mark.parametrize("library", [serial, serialx], ids=["serial", "serialx"])
@pytest.mark.parametrize("other", [Mock(), lambda *a, **k: None, dict], ids=["mock", "function", "class"])
def test_a_suite_that_has_replaced_the_class_of_ports_gets_an_error(slewline_ports, monkeypatch, library, other):
    """The module would be found by nobody, and a program would open what the suite has put there, or nothing."""
    monkeypatch.setattr(library, "Serial", other)
    with pytest.raises(
        UsageError, match=rf"^{library.__name__}\.Serial is .*: a test or a conftest.py has replaced it"
    ):
        slewline_ports({NAME: "gs-c200s"})
    monkeypatch.undo()
    with pytest.raises(NOBODY):
        serial.Serial(NAME + "?")


def test_a_class_of_ports_that_a_suite_has_derived_finds_the_module(slewline_ports, monkeypatch):
    class Noted(serial.Serial):
        pass

    monkeypatch.setattr(serial, "Serial", Noted)
    slewline_ports({NAME: "gs-c200s"}, straps={"chs": 0})
    with serial.Serial(NAME, **SETTINGS) as port:
        assert isinstance(port, Noted) and ask(port) == b"V+0\r"


def test_it_is_in_the_list_of_ports(ports):
    assert NAME in [found.device for found in list_ports.comports()]


@pytest.mark.system
@pytest.mark.posix
def test_a_port_that_is_open_already_stays_what_it_is(slewline_module, tmp_path):
    """Its file descriptor is one of the system, whatever its name means meanwhile."""
    from slewline.testing.ports import named_ports

    served = slewline_module("gs-c200s", on="pty", straps={"chs": 0})
    other = slewline_module("gs-c200s", straps={"chs": 0})
    with serial.Serial(served.url, 9600, timeout=60) as real, named_ports({served.url: other}):
        assert ask(real) == b"V+0\r" and real.fileno() > 0
        assert other.now == 10**9  # nobody has spoken to it


def test_time_sleeps_for_all_of_them(slewline_ports):
    ports = slewline_ports({"COM3": "gs-c200s", "COM4": "gs-c200"})
    before = [module.now for module in ports.values()]
    ports.sleep(0.5)
    ports.advance("1 ms")
    assert [module.now - then for module, then in zip(ports.values(), before, strict=True)] == [501 * 10**9] * 2


@pytest.mark.parametrize(("part", "face"), [("cy525", "host"), ("gs-c200s", "tcp"), ("mc1451a", "host")])
def test_a_module_without_a_line_in_this_process_is_refused(slewline_ports, slewline_module, part, face):
    says = rf"^COM3: {part} on {face}; allowed only parts with a serial line, and only with on='url'$"
    with pytest.raises(UsageError, match=says):
        slewline_ports({"COM3": slewline_module(part, on=face)})


def test_serialx_finds_it_by_every_method(ports):
    settings = {"baudrate": 9600, "byte_size": 7, "parity": "O", "stopbits": 2}
    for make in (SerialOfSerialx, serialx.Serial, serialx.serial_for_url):
        with make(NAME, read_timeout=1, **settings) as port:
            assert ask(port) == b"V+0\r" and isinstance(port, serialx.Serial)
    with pytest.raises(NOBODY):
        SerialOfSerialx("/dev/ttyUSB77").open()

    async def main():
        reader, writer = await serialx.open_serial_connection(NAME, **settings)
        writer.write(b"V1\r")
        assert await reader.readuntil(b"\r") == b"V+0\r"
        writer.close()
        await writer.wait_closed()
        async with serialx.async_serial_for_url(NAME, **settings) as port:
            await port.write(b"F\r")
            assert await port.readuntil(b"\r") == b"R\r"
        with pytest.raises(NOBODY):
            await serialx.open_serial_connection("/dev/ttyUSB77", **settings)

    aio.run(main())
    asyncio.run(main())
    assert ports[NAME].rig.line.host is None


def test_serialx_is_not_touched_afterwards():
    assert "_found" not in vars(serialx.Serial)
    with pytest.raises(NOBODY):
        SerialOfSerialx(NAME).open()
    with pytest.raises(NOBODY):
        serialx.serial_for_url(NAME).open()


@pytest.mark.parametrize("make", [serial.Serial, SerialOfSerialx])
def test_ports_left_open_by_a_program_are_closed_at_the_end(slewline_module, make):
    from slewline.testing.ports import named_ports

    module = slewline_module("gs-c200s", straps={"chs": 0})
    with named_ports({NAME: module}):
        left = make(NAME)
        if not left.is_open:
            left.open()
        assert module.rig.line.host is not None
    assert module.rig.line.host is None and not left.is_open
    left.close()


FTDI = {"vid": 0x0403, "pid": 0x6001, "serial_number": "A50285BI", "product": "FT232R", "manufacturer": "FTDI"}


def test_a_program_finds_its_adapter_in_the_list_of_ports(slewline_ports):
    ports = slewline_ports({"COM3": "gs-c200s", "COM4": "gs-c200"}, usb={"COM3": FTDI}, straps={"chs": 0})
    (found,) = list_ports.grep("0403:6001")
    assert (found.device, found.serial_number, found.product) == ("COM3", "A50285BI", "FT232R")
    assert found.hwid == "USB VID:PID=0403:6001 SER=A50285BI"
    (of_serialx,) = [info for info in serialx.list_serial_ports() if info.vid == 0x0403]
    assert (of_serialx.device, of_serialx.pid, of_serialx.serial_number) == ("COM3", 0x6001, "A50285BI")
    assert asyncio.run(serialx.async_list_serial_ports())[0] == of_serialx
    with serial.serial_for_url("hwgrep://A50285BI", **SETTINGS) as port:
        assert ask(port) == b"V+0\r"
    with ports["COM3"].faults.unplugged():
        assert [info.device for info in list_ports.comports() if info.device.startswith("COM")] == ["COM4"]
    assert len([*list_ports.grep("0403:6001")]) == 1


@pytest.mark.parametrize(
    ("usb", "says"),
    [
        ({"COM7": {}}, "usb: no port 'COM7'; available: COM3"),
        ({"COM3": {"serial": "A5"}}, "usb of COM3: no key 'serial'; allowed vid, pid, serial_number"),
        ({"COM3": {"vid": "0403"}}, "usb of COM3: vid '0403'; allowed 0 to 0xFFFF"),
        ({"COM3": {"pid": 1 << 16}}, "usb of COM3: pid 65536; allowed 0 to 0xFFFF"),
        ({"COM3": {"product": 5}}, "usb of COM3: product 5; allowed text"),
    ],
)
def test_an_adapter_that_cannot_be_is_refused(slewline_ports, usb, says):
    with pytest.raises(UsageError, match=f"^{says}"):
        slewline_ports({"COM3": "gs-c200s"}, usb=usb)


def test_a_library_that_would_wait_for_ever_is_refused_when_it_opens(slewline_ports):
    """What fails in pyserial-asyncio is a callback, after which the program waits for good."""
    slewline_ports({"COM3": "gs-c200s"})
    library = ModuleType("serial_asyncio")
    exec("import serial\ndef opened(url): return serial.serial_for_url(url)", vars(library))
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "serial_asyncio", library)
        for url in ("slewline://gs-c200s", "COM3"):
            with pytest.raises(serial.SerialException, match=r'on="tcp".*on="pty"'):
                library.opened(url)
            serial.serial_for_url(url).close()  # somebody else's call
