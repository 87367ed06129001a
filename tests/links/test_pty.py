"""Pseudo-terminals: the link, and host programs that open it as 7O2 again and again."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

import pytest
import serial

import slewline
from slewline.errors import UsageError
from slewline.links.lines.pace import Lockstep
from slewline.links.ports.pty import HINT, PLAIN
from slewline.links.server import Server
from slewline.links.serving import NOT_RECEIVING
from slewline.links.sockets import system

from .conftest import PATIENCE, Threaded

HOST = """
import serial, sys
for number in range(20):
    for bits, parity, stop in FORMATS:
        with serial.Serial(sys.argv[1], 9600, bytesize=bits, parity=parity, stopbits=stop, timeout=60) as port:
            port.write(b"V1\\r")
            assert port.read_until(b"\\r") == b"V+0\\r"
print("well")
"""
FORMATS = [(7, "O", 2)], [(8, "O", 1)], [(7, "O", 1), (8, "N", 1), (7, "E", 1), (8, "O", 1)]
IN_C = """
#include <fcntl.h>
#include <stdio.h>
#include <termios.h>
#include <unistd.h>
int main(int n, char **name) {
    struct termios t;
    char answer[8];
    for (int again = 0; again < 20; again++) {
        int port = open(name[1], O_RDWR | O_NOCTTY), got = 0;
        tcgetattr(port, &t);
        cfmakeraw(&t);
        t.c_cflag = (t.c_cflag & ~CSIZE) | CS7 | PARENB | PARODD | CSTOPB | CLOCAL | CREAD;
        cfsetspeed(&t, B9600);
        if (tcsetattr(port, TCSANOW, &t)) return perror("tcsetattr"), 1;
        write(port, "V1\\r", 3);
        while (got < 4) got += read(port, answer + got, 4 - got);
        printf("%.3s\\n", answer);
        close(port);
    }
}
"""


pytestmark = pytest.mark.posix


@pytest.fixture
def link(tmp_path):
    return tmp_path / "x"


@pytest.mark.system
@pytest.mark.parametrize("formats", FORMATS, ids=["7O2", "8O1", "in turns"])
def test_a_host_program_opens_it_with_parity_again_and_again(serve, link, formats):
    """The C library refuses an open that changes nothing: without the cure, the second one fails."""
    serve("gs-c200s", "--pty", link, "--strap", "chs=0", "--lockstep")
    host = [sys.executable, "-c", HOST.replace("FORMATS", repr(formats)), str(link)]
    ran = subprocess.run(host, check=False, capture_output=True, text=True, timeout=PATIENCE)
    assert (ran.stdout, ran.stderr) == ("well\n", "")


@pytest.mark.system
def test_so_does_a_program_in_c(serve, link, tmp_path):
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("needs a C compiler")
    (tmp_path / "host.c").write_text(IN_C)
    subprocess.run([compiler, "-o", tmp_path / "host", tmp_path / "host.c"], check=True)
    serve("gs-c200s", "--pty", link, "--strap", "chs=0", "--lockstep")
    ran = subprocess.run([tmp_path / "host", link], check=False, capture_output=True, text=True, timeout=PATIENCE)
    assert (ran.stdout, ran.stderr) == ("V+0\n" * 20, "")


@pytest.mark.system
def test_of_a_program_at_another_rate_only_the_rate_is_reported(lockstep, link):
    """A pty shows neither data bits nor parity, so nothing says that they are right."""
    server, line = lockstep()
    server.pty(line, str(link))
    with Threaded(server) as running, serial.Serial(str(link), 19200, timeout=PATIENCE) as port:
        port.write(b"F\r")
        assert port.read_until(b"\r") == b"R\r"
        running.until(lambda: server.bench.findings)
    (found,) = [found.text for found in server.bench.findings if found.code == "format"]
    assert found.startswith("the program is set to 19200 baud, and x to 9600 7O2 (")
    assert "would work on a cable" in found and "19200 7O2" not in found


@pytest.mark.real("pty")
def test_settings_may_change_while_the_port_is_open(lockstep, link):
    server, line = lockstep()
    server.pty(line, str(link))
    with Threaded(server), serial.Serial(str(link), 9600, bytesize=7, parity="O", stopbits=2, timeout=PATIENCE) as port:
        for timeout in (20, 25, 30):
            port.write(b"F\r")
            assert port.read_until(b"\r") == b"R\r"
            port.timeout = timeout  # pySerial sets everything again


@pytest.mark.system
def test_a_host_without_parity_is_understood(lockstep, link):
    server, line = lockstep()
    server.pty(line, str(link))
    with Threaded(server), open(link, "r+b", buffering=0) as port:
        port.write(bytes(byte | 0x80 for byte in b"F\r"))  # as if it had 8 bits, the highest at 1
        assert port.read(1) + port.read(1) == b"R\r"


@pytest.mark.system
def test_the_link_goes_with_the_server(lockstep, link):
    server, line = lockstep()
    port = server.pty(line, str(link))
    assert port.where == str(link)
    assert os.readlink(link) == port.name
    server.close()
    assert not os.path.lexists(link)


@pytest.mark.system
def test_a_link_remade_by_another_program_stays(lockstep, link):
    server, line = lockstep()
    server.pty(line, str(link))
    link.unlink()
    link.symlink_to("/dev/null")
    server.close()
    assert os.readlink(link) == "/dev/null"


@pytest.mark.system
def test_an_old_link_of_a_server_that_was_killed_is_replaced(lockstep, link):
    link.symlink_to("/dev/pts/99999")
    server, line = lockstep()
    port = server.pty(line, str(link))
    assert os.readlink(link) == port.name
    server.close()


def as_made(link):
    """What a name is, but for when it was read last."""
    found = os.lstat(link)
    return found.st_mode, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns


ELSEWHERE = ["/dev/null", "/nowhere", "/dev/pts/../../nowhere", "/dev/pts/99999/x", "/dev/pts/", "/dev/pts/99999\n"]


@pytest.mark.system
@pytest.mark.parametrize("kind", ["file", "directory", "terminal", *ELSEWHERE])
def test_a_file_other_than_our_old_link_stays(lockstep, link, kind):
    if kind == "file":
        link.write_text("precious")
    elif kind == "directory":
        link.mkdir()
    elif kind == "terminal":
        other = os.openpty()
        link.symlink_to(os.ttyname(other[1]))
    else:
        link.symlink_to(kind)
    server, line = lockstep()
    before = as_made(link)
    with pytest.raises(
        UsageError, match="a terminal that is in use" if kind == "terminal" else "not an old link made by"
    ) as refused:
        server.pty(line, str(link))
    assert "remove" not in str(refused.value)
    assert as_made(link) == before
    server.close()
    if kind == "terminal":
        for end in other:
            os.close(end)


def test_a_link_needs_a_name(lockstep):
    server, line = lockstep()
    with pytest.raises(UsageError, match="a pty needs a link"):
        server.pty(line, "")
    server.close()


@pytest.mark.system
def test_a_port_at_seven_bits_reports_its_limits(lockstep, link, tmp_path):
    server, line = lockstep(log=tmp_path / "log")
    told = []
    server.report = told.append
    server.pty(line, str(link))
    server.close()
    assert told == [f"{link}: {HINT}"]
    shown = str(link).encode("ascii", "backslashreplace").decode()  # a log is plain text
    assert f"x ! {shown}: {HINT}\n" in (tmp_path / "log").read_text()
    assert all(way in HINT for way in ("EINVAL", "8N1", "socket://", "rfc2217://"))


@pytest.mark.system
def test_a_chip_with_eight_bits_needs_no_hint(link):
    told = []
    bench = slewline.Bench()
    server = Server(bench, Lockstep(bench), report=told.append)
    server.pty(server.line(bench.add("cy525")), str(link))
    server.close()
    assert told == [NOT_RECEIVING.format(chip="cy525")]  # and nothing of 7 bits


@pytest.mark.system
def test_a_link_needs_a_directory(lockstep, tmp_path):
    server, line = lockstep()
    with pytest.raises(UsageError, match="a writable directory"):
        server.pty(line, str(tmp_path / "nowhere" / "x"))
    server.close()


@pytest.mark.system
def test_a_host_that_never_reads_does_not_stop_the_server(lockstep, link):
    server, line = lockstep()
    server.pty(line, str(link))
    with Threaded(server) as running, open(link, "r+b", buffering=0):
        running.do(lambda: [line.give(bytes(1000)) for _ in range(1000)])
        running.until(lambda: line.dropped > 0 and line.given + line.dropped == 1_000_000)


@pytest.mark.system
def test_without_packet_mode_it_takes_8n1_and_reports_it(lockstep, link, monkeypatch):
    """As on macOS."""
    monkeypatch.setattr(system, "EXTPROC", None)
    server, line = lockstep()
    told = []
    server.report = told.append
    server.pty(line, str(link))
    assert told == [f"x: {link}: {PLAIN}"] or told == [f"{link}: {PLAIN}"]
    with Threaded(server):
        for _ in range(3):
            with serial.Serial(str(link), 9600, timeout=PATIENCE) as host:
                host.write(b"V1\r")
                assert host.read_until(b"\r") == b"V+0\r"


def test_a_system_without_pseudo_terminals_names_alternatives(lockstep, link, monkeypatch):
    monkeypatch.delattr(os, "openpty")
    server, line = lockstep()
    with pytest.raises(UsageError, match=r"--pty needs Linux or macOS: .*; serve with --tcp or --rfc2217 instead"):
        server.pty(line, str(link))
    server.close()
