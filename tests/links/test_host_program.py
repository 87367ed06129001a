"""A host program that knows nothing but a serial port, in a process of its own, in real time."""

from __future__ import annotations

import subprocess
import sys

import pytest

from slewline.links.ports.pty import HINT
from tests.ensembles import in_long_runs

from .conftest import PATIENCE, patient

HOST = """
import sys, serial

def checksum(text):
    return bytes([sum(text) & 0x7F | 0x10])

def ask(port, command):
    text = command.encode()
    port.write(text + checksum(text) + b"\\r")
    answer = port.read_until(b"\\r")
    assert answer[-2:-1] == checksum(answer[:-2]), answer
    return answer[:-2].decode()

with serial.serial_for_url(sys.argv[1], 9600, bytesize=7, parity="O", stopbits=2, timeout=60) as port:
    if sys.argv[2] == "work":
        for line in ("I3", "Po", "S100", "T500", "R40", "+800", "A2", "E"):
            assert ask(port, line) == "Y", line
        while ask(port, "F") != "R":
            pass
        print(ask(port, "V1"), ask(port, "V2"), ask(port, "M"))
    else:
        print(ask(port, "X"), ask(port, "Q"), *(port.read_until(b"\\r")[:-2].decode() for _ in range(5)))
"""


def host(where, what):
    # pySerial's own client for RFC 2217 calls what newer Pythons warn of
    run = [sys.executable, "-W", "ignore", "-c", HOST, patient(str(where)), what]
    ran = subprocess.run(run, check=False, capture_output=True, text=True, timeout=PATIENCE)
    assert ran.stderr == ""
    return ran.stdout.split()


@pytest.mark.system
@pytest.mark.parametrize(
    "kind", [pytest.param("pty", marks=pytest.mark.posix), in_long_runs("tcp"), in_long_runs("rfc2217")]
)
def test_it_programs_the_module_runs_it_and_saves_the_program(serve, tmp_path, kind):
    where = {"pty": tmp_path / "controller"}.get(kind, "127.0.0.1:0")
    arguments = ("gs-c200s", f"--{kind}", where, "--state", tmp_path / "memories", "--option", "eeprom_time=50 ms")
    first = serve(*arguments)
    assert host(first.where, "work") == ["V+800", "V72", "Y"]
    assert first.kill()
    if kind == "pty":
        where.unlink()  # its terminal may be that of another program by now
    second = serve(*arguments)
    assert host(second.where, "recall") == ["Y", "S100", "T500", "R40", "+800", "A2", "END"]
    says = {"pty": HINT, "tcp": "", "rfc2217": "the line has 9600 baud, 7 data bits, odd parity, 2 stop bits"}[kind]
    status, told = second.end()
    assert (status, len(told.splitlines())) == (0, bool(says)) and says in told
