"""The serial port of a board, over a pseudo-terminal."""

from __future__ import annotations

import os
from contextlib import suppress

import pytest

serial = pytest.importorskip("serial")

from slewline.drive.board.port import BoardSerial  # noqa: E402
from slewline.errors import UsageError  # noqa: E402

pytestmark = pytest.mark.posix


@pytest.fixture
def pty():
    ours, theirs = os.openpty()
    name = os.ttyname(theirs)
    yield ours, name
    for each in (ours, theirs):
        with suppress(OSError):
            os.close(each)


def test_bytes_go_both_ways_and_nothing_waits(pty):
    ours, name = pty
    port = BoardSerial(name, 500_000)
    assert port.read() == b"" and port.fileno() is not None and port.name == name
    assert port.write(b"\x01\x02\x00\x11\x13") == 5
    assert os.read(ours, 100) == b"\x01\x02\x00\x11\x13"
    os.write(ours, b"\x00\x0d\x0a\x03\x1a")
    assert port.read() == b"\x00\x0d\x0a\x03\x1a" == bytes(port.heard)
    port.close()


def test_dtr_stays_up_when_the_port_is_closed(pty):
    import termios

    _, name = pty
    port = BoardSerial(name, 500_000)
    assert not termios.tcgetattr(port.fileno())[2] & termios.HUPCL
    port.close()


def test_a_port_is_for_one_program_alone(pty):
    _, name = pty
    port = BoardSerial(name, 500_000)
    with pytest.raises(UsageError, match=f"{name}: another program uses this port; close that one"):
        BoardSerial(name, 500_000)
    port.close()


def test_what_is_no_port():
    with pytest.raises(UsageError, match="/dev/ttyNONE: no such port; name the port of the board"):
        BoardSerial("/dev/ttyNONE", 500_000)


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="root may open everything")
def test_a_port_that_one_may_not_open(tmp_path):
    path = tmp_path / "port"
    path.touch(0o000)
    with pytest.raises(UsageError, match="you may not open this port"):
        BoardSerial(str(path), 500_000)


def test_the_refusals_of_a_system_say_what_to_do():
    from slewline.drive.board.port import _refused

    assert "dialout" in _refused(PermissionError(13, "Permission denied"))
    assert "no such port" in _refused(FileNotFoundError(2, "No such file"))
    assert "another program" in _refused(OSError(16, "Device or resource busy"))
    assert "list_ports" in _refused(OSError(25, "Inappropriate ioctl for device"))


def test_what_the_line_does_not_take_at_once_follows():
    class Narrow:
        """Takes three bytes a call."""

        def __init__(self):
            self.got = b""

        def write(self, data):
            self.got += data[:3]
            return min(len(data), 3)

        def read(self, _most):
            return b""

    port = BoardSerial.__new__(BoardSerial)
    port.heard, port._unsent, port._port = bytearray(), b"", Narrow()
    assert port.write(b"1234567") == 7 and port._port.got == b"123"
    assert port.write(b"89") == 2
    port.read()
    assert port._port.got == b"123456789"
