"""The serial port of a board, over a pseudo-terminal."""

from __future__ import annotations

import os
import select
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress

import pytest

serial = pytest.importorskip("serial")

from slewline.drive.board.board_port import BoardSerial  # noqa: E402
from slewline.errors import UsageError  # noqa: E402

from ..links.conftest import PATIENCE  # noqa: E402

pytestmark = pytest.mark.posix


@pytest.fixture
def pty():
    ours, theirs = os.openpty()
    name = os.ttyname(theirs)
    yield ours, name
    for each in (ours, theirs):
        with suppress(OSError):
            os.close(each)


def come(port):
    """Return what comes next on a port."""
    assert select.select([port.fileno()], [], [], PATIENCE)[0]
    return port.read()


@pytest.mark.system
def test_bytes_flow_in_both_directions_and_nothing_waits(pty):
    ours, name = pty
    port = BoardSerial(name)
    assert port.read() == b"" and port.fileno() is not None and port.name == name
    assert port.write(b"\x01\x02\x00\x11\x13") == 5
    assert os.read(ours, 100) == b"\x01\x02\x00\x11\x13"
    os.write(ours, b"\x00\x0d\x0a\x03\x1a")
    assert come(port) == b"\x00\x0d\x0a\x03\x1a" == bytes(port.received)
    assert port.read() == b""
    port.close()
    assert port.fileno() is None


@pytest.mark.system
def test_many_bytes_come_in_order_however_late_they_are_read(pty):
    ours, name = pty
    port = BoardSerial(name)
    sent = bytes(range(256)) * 2000  # more than a pipe holds
    with ThreadPoolExecutor() as pool:
        sending = pool.submit(lambda: [os.write(ours, sent[at : at + 64]) for at in range(0, len(sent), 64)])
        time.sleep(0.2)
        found = b""
        while len(found) < len(sent):
            found += come(port)
        sending.result()
    assert found == sent
    port.close()


@pytest.mark.system
def test_a_port_that_is_gone_fails_after_its_last_byte(pty):
    ours, name = pty
    port = BoardSerial(name)
    os.write(ours, b"\x01")
    assert come(port) == b"\x01"
    os.close(ours)
    with pytest.raises(OSError, match=r"Input/output error|was closed"):
        come(port)
    with pytest.raises(OSError, match=r"Input/output error|was closed"):
        port.read()
    port.close()
    port.close()


def held():
    """The threads and descriptors of this process; what a test before has left may end meanwhile."""
    return {*threading.enumerate()}, {*os.listdir("/dev/fd")}


@pytest.mark.system
@pytest.mark.parametrize("full", [False, True])
def test_a_port_leaves_no_trace(pty, full):
    ours, name = pty
    threads, files = held()
    port = BoardSerial(name)
    assert len(held()[0] - threads) == 1
    if full:
        os.set_blocking(ours, False)
        with suppress(BlockingIOError):
            while select.select([], [ours], [], 0.2)[1]:
                os.write(ours, bytes(1000))
    port.close()
    now = held()
    assert (now[0] - threads, now[1] - files) == (set(), set())


@pytest.mark.system
def test_dtr_stays_up_when_the_port_is_closed(pty):
    import termios

    _, name = pty
    other = os.open(name, os.O_RDWR | os.O_NOCTTY)
    settings = termios.tcgetattr(other)
    settings[2] |= termios.HUPCL  # as a serial port has it; a pseudo-terminal begins without
    termios.tcsetattr(other, termios.TCSANOW, settings)
    BoardSerial(name).close()
    assert not termios.tcgetattr(other)[2] & termios.HUPCL
    os.close(other)


@pytest.mark.system
def test_a_port_is_for_one_program_alone(pty):
    _, name = pty
    port = BoardSerial(name)
    with pytest.raises(UsageError, match=f"{name}: another program uses this port; close it"):
        BoardSerial(name)
    port.close()


def test_a_missing_port_is_refused():
    with pytest.raises(UsageError, match="/dev/ttyNONE: no such port; name the port of the board"):
        BoardSerial("/dev/ttyNONE")


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="root may open everything")
def test_a_port_without_permission_to_open(tmp_path):
    path = tmp_path / "port"
    path.touch(0o000)
    with pytest.raises(UsageError, match="no permission to open this port"):
        BoardSerial(str(path))


def test_the_refusals_of_a_system_have_a_remedy():
    from slewline.drive.board.board_port import _refused

    assert "dialout" in _refused(PermissionError(13, "Permission denied"))
    assert "no such port" in _refused(FileNotFoundError(2, "No such file"))
    assert "another program" in _refused(OSError(16, "Device or resource busy"))
    assert "list_ports" in _refused(OSError(25, "Inappropriate ioctl for device"))
    assert _refused(OSError("Could not configure port: (25, 'Inappropriate ioctl for device')")).startswith(
        "not a serial port; "
    )


def test_bytes_that_the_line_does_not_take_immediately_follow():
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
    port.received, port._unsent, port._port, port._reader = bytearray(), b"", Narrow(), None
    assert port.write(b"1234567") == 7 and port._port.got == b"123"
    assert port.write(b"89") == 2
    port.read()
    assert port._port.got == b"123456789"
