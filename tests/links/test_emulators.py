"""A host program of 1990 in an emulated PC, and programs that join ports, on a module that the command serves.

The programs are assembled here, and speak to the registers of a UART at 3F8h, or of a card at 340h; in DOSBox as a DOS
program, in QEMU as the boot sector of a bare PC.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import time
from pathlib import Path

import pytest
import serial

from slewline.links.clients.chipset_port import ChipsetPort

from .conftest import PATIENCE, until
from .gdb_ports import GdbStub, run

pytestmark = pytest.mark.system
PACKAGES = {"qemu-system-i386": "qemu-system-x86"}
SOURCE, PORTS = (Path(__file__).with_name(name) for name in ("host.asm", "ports.asm"))
SERVED = ("gs-c200s", "--strap", "chs=0", "--log")
LINES = ("Po", "S10", "T100", "R50", "+1200", "E", "V1")  # as in host.asm
ANSWERS = b"Y\r\n" * 6 + b"B\r\n"  # the motor is under way when it is asked where it is
DOSBOX = """
[sdl]
output=surface
[cpu]
core=normal
cycles=3000
[mixer]
nosound=true
[midi]
mididevice=none
[serial]
serial1={port}
serial2=disabled
[autoexec]
mount c .
c:
talk.bat
"""
BATCH = b"@echo off\r\nhost.com > answers.txt\r\nexit\r\n"
MACHINE = "-display none -nodefaults -no-user-config -no-reboot -machine pc,accel=tcg -debugcon file:answers.txt"
ENDS = "-device isa-debug-exit,iobase=0xf4,iosize=4"  # what lets a guest end it: status 1


def find(program):
    """The path of a program; where it is missing, the test is skipped."""
    path = shutil.which(program)
    if path is None:
        pytest.skip(f"{program} is not installed; on Debian:  apt install {PACKAGES.get(program, program)}")
    return path


def place(where):
    """Host and port of a URL."""
    return where.rpartition("//")[2].rsplit(":", 1)


def assembled(kind, path, source=SOURCE):
    subprocess.run([find("nasm"), "-f", "bin", f"-D{kind}", source, "-o", path], check=True)


def dosbox(folder, port, source=SOURCE):
    """Run the program from a batch file, with COM1 on a port as DOSBox names it; returns what it wrote."""
    assembled("DOS", folder / "host.com", source)
    (folder / "talk.bat").write_bytes(BATCH)
    (folder / "dosbox.conf").write_text(DOSBOX.format(port=port))
    quiet = {"SDL_VIDEODRIVER": "dummy", "SDL_AUDIODRIVER": "dummy", "HOME": str(folder)}
    command = [find("dosbox"), "-conf", "dosbox.conf"]
    ran = subprocess.run(
        command, check=False, cwd=folder, env=os.environ | quiet, capture_output=True, timeout=PATIENCE
    )
    assert ran.returncode == 0, ran.stdout
    return (folder / "ANSWERS.TXT").read_bytes()


def qemu(folder, *port):
    """Boot the program, with COM1 on a port as QEMU names it; returns what it wrote to the debug port."""
    assembled("BOOT", folder / "boot.img")
    disk = "-drive file=boot.img,format=raw,if=floppy"
    command = [find("qemu-system-i386"), *f"{MACHINE} {ENDS} {disk}".split(), *port]
    ran = subprocess.run(command, check=False, cwd=folder, capture_output=True, timeout=PATIENCE)
    assert ran.returncode == 1, ran.stderr
    return (folder / "answers.txt").read_bytes()


def said(log):
    """What the host has said and what it was answered, according to the transcript."""
    words = [line.split(maxsplit=2) for line in log.read_text().splitlines()]
    told = [word[2] for word in words if word[2][0] in "<>"]
    return [(one[2:], other[2:]) for one, other in zip(told[::2], told[1::2], strict=True)]


EXPECTED = [(rf"{line}\r", r"B\r" if line == "V1" else r"Y\r") for line in LINES]


def test_a_dos_program_in_dosbox_finds_the_module_at_the_end_of_a_null_modem(serve, tmp_path):
    where = serve(*SERVED, tmp_path / "log", "--tcp", "127.0.0.1:0").where
    host, port = place(where)
    assert dosbox(tmp_path, f"nullmodem server:{host} port:{port} transparent:1") == ANSWERS
    assert said(tmp_path / "log") == EXPECTED


@pytest.mark.posix
def test_a_dos_program_in_dosbox_finds_it_on_a_device_file(serve, tmp_path):
    """DOSBox looks for it below /dev."""
    where = serve(*SERVED, tmp_path / "log", "--pty", tmp_path / "controller").where
    device = os.path.realpath(where)  # DOSBox takes no blank in a name
    assert dosbox(tmp_path, f"directserial realport:{os.path.relpath(device, '/dev')}") == ANSWERS
    assert said(tmp_path / "log") == EXPECTED


def test_a_boot_sector_in_qemu_finds_the_module_on_com1(serve, tmp_path):
    where = serve(*SERVED, tmp_path / "log", "--tcp", "127.0.0.1:0").where
    assert qemu(tmp_path, "-serial", "tcp:{}:{}".format(*place(where))) == ANSWERS
    assert said(tmp_path / "log") == EXPECTED


@pytest.mark.posix
def test_a_boot_sector_in_qemu_finds_it_on_a_device_file(serve, tmp_path):
    where = serve(*SERVED, tmp_path / "log", "--pty", tmp_path / "controller").where
    assert qemu(tmp_path, "-chardev", f"serial,path={where},id=com1", "-serial", "chardev:com1") == ANSWERS
    assert said(tmp_path / "log") == EXPECTED


# --------------------------------------------------------------------------------------------------- port I/O of a card
def test_a_program_for_a_card_finds_nobody_in_dosbox_and_takes_it_for_ready(tmp_path):
    """What floats is FF, and bit 7 of it says that the chipset is ready: no emulator has the card."""
    assert dosbox(tmp_path, "disabled", PORTS) == b"ffff"


def booted(folder, *more):
    """Start QEMU with the program for a card as its boot sector."""
    assembled("BOOT", folder / "boot.img", PORTS)
    disk = "-drive file=boot.img,format=raw,if=floppy"
    command = [find("qemu-system-i386"), *f"{MACHINE} {ENDS} {disk}".split(), *more]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def test_nor_does_it_in_qemu(tmp_path):
    assert booted(tmp_path).wait(PATIENCE) == 1
    assert (tmp_path / "answers.txt").read_bytes() == b"ffff"


@pytest.mark.posix
def test_breakpoints_of_qemu_bring_its_accesses_to_a_served_chipset(serve, tmp_path, monkeypatch):
    where = serve("mc1451a", "--tcp", "127.0.0.1:0").where
    monkeypatch.chdir(tmp_path)  # the whole name may be too long for a socket
    link = Path("gdb")
    machine = booted(tmp_path, "-S", "-chardev", "socket,path=gdb,server=on,wait=off,id=gdb", "-gdb", "chardev:gdb")
    try:
        until(link.exists)
        host, port = place(where)
        with ChipsetPort(host, int(port)) as card, GdbStub(str(link), PATIENCE) as stub:
            done = run(stub, (tmp_path / "boot.img").read_bytes(), 0x7C00, range(0x340, 0x350), card)
        assert machine.wait(PATIENCE) == 1
    finally:
        machine.kill()
        machine.wait()
    assert (tmp_path / "answers.txt").read_bytes() == b"5c11"  # GET_VRSN
    assert done >= 6  # three looks at the status at least, a command, two bytes


# --------------------------------------------------------------------------------------------- programs that join ports
@pytest.fixture
def socat(tmp_path):
    """Start socat with two addresses; returns when the files that they make are there."""
    made = []

    def start(*addresses, files):
        made.append(subprocess.Popen([find("socat"), *addresses], stderr=subprocess.PIPE))
        end = time.monotonic() + PATIENCE
        while not all(path.exists() for path in files):
            assert made[-1].poll() is None and time.monotonic() < end, made[-1].stderr.read()
            time.sleep(0.01)

    yield start
    for process in made:
        process.terminate()
        process.communicate(timeout=PATIENCE)


def ask(device):
    with serial.Serial(str(device), 9600, timeout=PATIENCE) as port:
        port.write(b"V1\r")
        return port.read_until(b"\r")


@pytest.mark.posix
def test_socat_makes_a_device_file_of_a_socket(serve, socat, tmp_path):
    host, port = place(serve(*SERVED, tmp_path / "log", "--tcp", "127.0.0.1:0").where)
    device = tmp_path / "ttyS9"
    socat(f"pty,link={device},raw,echo=0", f"tcp:{host}:{port}", files=[device])
    assert ask(device) == b"V+0\r"


@pytest.mark.posix
def test_a_module_sits_on_one_end_of_a_pair_and_the_program_on_the_other(serve, socat, tmp_path):
    left, right = tmp_path / "left", tmp_path / "right"
    socat(f"pty,link={left},raw,echo=0", f"pty,link={right},raw,echo=0", files=[left, right])
    serve(*SERVED, tmp_path / "log", "--serial", left)
    assert ask(right) == b"V+0\r"
