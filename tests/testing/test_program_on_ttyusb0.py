"""A pySerial program that opens "/dev/ttyUSB0" itself, not a line of it changed, finds a module on Linux."""

from __future__ import annotations

import os
import runpy
import subprocess
import sys
import time

import pytest

PROGRAM = '''
import sys
import time
from serial import EIGHTBITS, PARITY_ODD, SEVENBITS, STOPBITS_TWO, Serial

DEVICE = "/dev/ttyUSB0"


class Feeder(Serial):
    """As such a program would have it: a class of its own, settings one by one, text in and out."""

    def __init__(self, device):
        super().__init__()
        self.port, self.baudrate, self.timeout = device, 9600, 30
        self.bytesize, self.parity, self.stopbits = FORMAT
        self.open()
        self.reset_input_buffer()

    def say(self, line):
        self.write(line.encode("ascii") + b"\\r")
        self.flush()
        return self.read_until(b"\\r").decode("ascii").strip()

    def feed(self, steps):
        for line in ("Po", "S10", "T100", "R50", f"+{steps}", "E"):
            assert self.say(line) == "Y", line
        while self.say("F") == "B":
            time.sleep(0.2)
        return self.say("V1")


FORMAT = SEVENBITS, PARITY_ODD, STOPBITS_TWO
if len(sys.argv) > 1:
    DEVICE, FORMAT = sys.argv[1], (EIGHTBITS, "N", 1)


def main():
    with Feeder(DEVICE) as feeder:
        return feeder.feed(1200)


if __name__ == "__main__":
    print(main())
'''


@pytest.fixture
def program(tmp_path, monkeypatch):
    monkeypatch.setattr("sys.argv", ["feeder.py"])
    path = tmp_path / "feeder.py"
    path.write_text(PROGRAM)
    return path


def test_it_finds_the_module_in_the_process_of_the_test(program, slewline_ports, monkeypatch):
    """It was imported before; it sleeps in virtual time, because the test says so."""
    main = runpy.run_path(str(program))["main"]
    ports = slewline_ports({"/dev/ttyUSB0": "gs-c200s"}, straps={"chs": 0})
    monkeypatch.setattr("time.sleep", ports.sleep)
    module = ports["/dev/ttyUSB0"]
    assert main() == "V+1200"
    module.assert_steps(1200, direction=+1)
    polls = [line for line in module.report().splitlines() if line.endswith(r"< F\r")]
    assert 5 < len(polls) < 10  # 1.2 s of motion, five a second
    assert main() == "V+2400"  # the port was closed meanwhile: it is the same module


@pytest.mark.posix
def test_without_the_fixture_it_finds_nothing(program, slewline_ports):
    if os.path.exists("/dev/ttyUSB0"):
        pytest.skip("there is one here")
    with pytest.raises(OSError, match="/dev/ttyUSB0"):
        runpy.run_path(str(program), run_name="__main__")
    slewline_ports({"/dev/ttyUSB1": "gs-c200s"})
    with pytest.raises(OSError, match="/dev/ttyUSB0"):
        runpy.run_path(str(program), run_name="__main__")


@pytest.mark.system
@pytest.mark.posix
@pytest.mark.slewline(on="pty", straps={"chs": 0}, rate=20)
def test_in_a_process_of_its_own_it_opens_a_device_file(program, gs_c200s):
    """There the module has a real file, and the program is told its name, as on the day it was installed."""
    run = [sys.executable, str(program), gs_c200s.url]
    began = time.monotonic()
    ran = subprocess.run(run, check=False, capture_output=True, text=True, timeout=60)
    assert (ran.stdout, ran.stderr) == ("V+1200\n", "")
    assert time.monotonic() - began < 60
    gs_c200s.assert_steps(1200)
