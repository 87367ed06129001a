"""A serial port of the machine: one end of a pseudo-terminal takes its place, the other one is the host."""

from __future__ import annotations

import io
import os
import select
import threading

import pytest
import serial

from slewline.errors import UsageError

from .conftest import PATIENCE, Threaded, until


class Cable:
    """A device under a name that stays, with the far end in our hands."""

    def __init__(self, path):
        self.path = path
        self.plug()

    def plug(self):
        import tty

        self.far, near = os.openpty()
        tty.setraw(near)
        self.path.unlink(missing_ok=True)
        self.path.symlink_to(os.ttyname(near))
        self.near = near

    def unplug(self):
        os.close(self.near)
        os.close(self.far)

    def ask(self, data):
        os.write(self.far, data)
        found = b""
        while not found.endswith(b"\r"):
            assert select.select([self.far], [], [], PATIENCE)[0]
            found += os.read(self.far, 100)
        return found


pytestmark = pytest.mark.posix


@pytest.fixture(params=["a descriptor", "threads"])
def cable(tmp_path, request, monkeypatch):
    """A cable whose near end the loop can wait for, and one at which it cannot, such as a COM port."""
    if request.param == "threads":

        def none(_port):
            raise io.UnsupportedOperation("fileno")

        monkeypatch.setattr(serial.Serial, "fileno", none)
    yield Cable(tmp_path / "ttyUSB0")
    until(lambda: not [thread for thread in threading.enumerate() if thread.name.startswith("cable")])


@pytest.mark.system
def test_a_module_at_the_end_of_a_cable(lockstep, cable):
    server, line = lockstep()
    port = server.serial(line, str(cable.path))
    assert port.where == str(cable.path)
    with Threaded(server):
        assert cable.ask(b"F\r") == b"R\r"
        assert cable.ask(b"V1\r") == b"V+0\r"
    cable.unplug()


@pytest.mark.system
def test_the_device_goes_and_comes_back(lockstep, cable):
    server, line = lockstep()
    told = []
    server.report = told.append
    server.serial(line, str(cable.path))
    assert "7 data bits, odd parity, 2 stop bits; a host that sets another format" in told.pop()
    with Threaded(server) as running:
        assert cable.ask(b"F\r") == b"R\r"
        cable.unplug()
        running.until(lambda: line.host is None)
        assert [text.partition(" (")[0] for text in told] == [f"{cable.path}: gone"]
        cable.plug()
        running.until(lambda: line.host is not None)
        assert told[1:] == [f"{cable.path}: back"]
        assert cable.ask(b"V1\r") == b"V+0\r"
    cable.unplug()


def test_a_device_that_is_missing_at_the_beginning_is_reported(lockstep, tmp_path):
    server, line = lockstep()
    with pytest.raises(UsageError, match="ttyUSB7"):
        server.serial(line, str(tmp_path / "ttyUSB7"))
    server.close()


@pytest.mark.system
def test_a_server_that_ends_while_the_device_is_away(lockstep, cable):
    server, line = lockstep()
    server.serial(line, str(cable.path))
    with Threaded(server) as running:
        cable.unplug()
        running.until(lambda: line.host is None)


@pytest.mark.system
def test_a_large_write_arrives_complete_and_in_order(lockstep, cable):
    server, line = lockstep()
    server.serial(line, str(cable.path))
    with Threaded(server):
        os.write(cable.far, b"F\r" * 500)
        found = b""
        while len(found) < 1000:
            assert select.select([cable.far], [], [], PATIENCE)[0]
            found += os.read(cable.far, 100)
        assert found == b"R\r" * 500
    cable.unplug()


@pytest.mark.system
def test_a_file_other_than_a_serial_port_is_reported(lockstep, tmp_path):
    server, line = lockstep()
    (tmp_path / "file").touch()
    for name in ("/dev/null", str(tmp_path / "file")):
        with pytest.raises(UsageError, match=f"^{name}: not a serial port; name a serial port that exists"):
            server.serial(line, name)
    server.close()
