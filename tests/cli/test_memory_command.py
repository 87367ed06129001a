"""--memory and --save-memory of slewline run, and the EEPROM that slewline serve keeps with --state."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from slewline.bench.files.images import read_image, write_image

PROGRAM = b"N 5\r+\rG\r0\r"
ENTER = ("Y 0", "E", "N 5", "+", "G", "0", "Q", "Y 0", "X")


def test_a_program_is_entered_and_its_memory_is_saved(call, write) -> None:
    ran = call("run", write("p.cy545b", *ENTER), "--save-memory", "p.bin")
    assert ran.status == 0 and "position 5, 5 steps" in ran.out and "wrote p.bin" in ran.out
    image = Path("p.bin").read_bytes()
    assert image.startswith(PROGRAM) and image[len(PROGRAM) :] == b"\xff" * (65536 - len(PROGRAM))


@pytest.mark.parametrize(("name", "more"), [("p.ihx", ()), ("p.ihex", ()), ("p.any", ("--format", "image"))])
def test_a_program_that_is_assembled_as_an_image_runs_at_its_address(
    call, write, name: str, more: tuple[str, ...]
) -> None:
    ran = call("asm", write("a.cy545b", "Y 10", *ENTER[1:7]), "-o", name, *more)
    assert (ran.status, ran.err) == (0, "") and read_image(name) == b"\xff" * 10 + PROGRAM
    ran = call("run", write("x.cy545b", "Y 10", "X"), "--memory", name)
    assert ran.status == 0 and "position 5, 5 steps" in ran.out and "0 findings" in ran.out


@pytest.mark.parametrize(("name", "origin", "told"), [("p.bin", 10, True), ("p.hex", 10, True), ("p.bin", 0, False)])
def test_bytes_without_their_address_are_reported(call, write, name: str, origin: int, told: bool) -> None:
    ran = call("asm", write("a.cy545b", f"Y {origin}", *ENTER[1:7]), "-o", name)
    assert (
        ran.status == 0
        and ("the bytes belong at address 10, which is not in the file; --format image" in ran.err) is told
    )


@pytest.mark.parametrize("name", ["p.bin", "p.hex"])
def test_an_image_is_executed(call, write, name: str) -> None:
    write_image(name, PROGRAM)
    ran = call("run", write("x.cy545b", "Y 0", "X"), "--memory", name)
    assert ran.status == 0 and "position 5, 5 steps" in ran.out


@pytest.mark.parametrize("name", ["p.bin", "p.hex"])
def test_an_image_is_disassembled(call, name: str) -> None:
    write_image(name, PROGRAM)
    ran = call("dis", name, "--chip", "cy545b")
    assert ran.status == 0 and [line.split(" ;")[0].rstrip() for line in ran.out.splitlines()[1:-1]] == [
        "N 5", "+", "G", "0",
    ]  # fmt: skip


def test_a_dump_of_32k_runs_in_its_mirror_too(call, write) -> None:
    write_image("dump.hex", PROGRAM.ljust(32768, b"\xff"))
    ran = call("run", write("x.cy545b", "Y 8000H", "X"), "--memory", "dump.hex", "--save-memory", "again.bin")
    assert ran.status == 0 and "position 5, 5 steps" in ran.out
    assert len(Path("again.bin").read_bytes()) == 32768


def test_an_endless_or_empty_program_is_dumped_as_stored(call, write) -> None:
    ran = call("run", write("x.cy545b", "Y 0", "X"), "--until", "10 ms")
    assert "erased-memory" in ran.out


def test_a_replay_has_the_memory(call, write) -> None:
    write_image("p.hex", PROGRAM)
    assert call("run", write("x.cy545b", "Y 0", "X"), "--memory", "p.hex", "--journal", "j", "--quiet").status == 0
    Path("p.hex").unlink()
    ran = call("run", "--replay", "j", "--save-memory", "q.bin")
    assert "position 5, 5 steps" in ran.out and read_image("q.bin").startswith(PROGRAM)


def test_a_memory_that_is_not_there_is_missed_before_the_run(call, five) -> None:
    ran = call("run", five, "--save-memory", "q.hex")
    assert ran.status == 2 and not ran.out and "which has none; leave out --save-memory" in ran.err


CANNOT_BE = [
    (("run", "five.cy525", "--memory", "p.hex"), "memory p.hex: a cy525 has no external memory; leave out this file"),
    (("run", "five.cy525", "--save-memory", "q.hex"), "--save-memory needs exactly one memory on the bench, which has"),
    (("run", "p.cy545b", "--memory", "none.hex"), "none.hex cannot be read: No such file"),
    (("run", "p.cy545b", "--memory", "bad.hex"), "bad.hex, line 1: checksum 00, calculated BE"),
    (("run", "p.cy545b", "--memory", "bytes.hex"), "put raw bytes into a .bin file"),
    (("dis", "bad.hex", "--chip", "cy545b"), "bad.hex, line 1: checksum 00, calculated BE"),
    (("dis", "end.hex", "--chip", "cy545b"), "end.hex is empty"),
    (("run", "p.cy545b", "--memory", "p.hex", "--save-memory", "p.hex"), "p.hex: this command already uses the file"),
    (("run", "b.toml", "--memory", "p.hex"), "a bench file names its chips; leave out"),
    (("run", "--replay", "j", "--memory", "p.hex"), "--replay repeats a run unchanged; leave out --memory"),
    (("serve", "cy525", "--tcp", "127.0.0.1:0", "--memory", "p.hex"), "a cy525 has no external memory"),
    (("serve", "--bench", "b.toml", "--memory", "p.hex"), "a bench file sets its own ports and options; leave out"),
]


def test_impossible_values_are_refused(call, five, write, subtests: pytest.Subtests) -> None:
    write("p.cy545b", *ENTER)
    write("bad.hex", ":010000004100")
    write("bytes.hex", "47 0D")
    write("end.hex", ":00000001FF")
    write("b.toml", '[[chip]]\npart = "cy545b"\n[[serve]]\ntcp = "127.0.0.1:0"')
    write_image("p.hex", PROGRAM)
    before = Path("p.hex").read_bytes()
    for arguments, says in CANNOT_BE:
        with subtests.test(arguments=arguments, description=says):
            ran = call(*arguments)
            assert ran.status == 2 and says in ran.err
            assert Path("p.hex").read_bytes() == before and not Path("q.hex").exists()


# --------------------------------------------------------------------------------------------------------------- serve
class Served:
    """A server process, and a host on its serial side that has sent the two returns."""

    def __init__(self, *how: str) -> None:
        command = "from slewline.cli.main import main; main()"
        words = [sys.executable, "-c", command, "serve", "cy545b", "--tcp", "127.0.0.1:0", *how]
        self.process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        host, _, port = self.process.stdout.readline().strip().rpartition("socket://")[2].rpartition(":")
        self.socket = socket.create_connection((host, int(port)), 30)
        self.send("\r\r")

    def send(self, text: str) -> None:
        self.socket.sendall(text.encode())

    def ask(self, text: str, end: bytes) -> bytes:
        """Send, and return what comes up to an end."""
        self.send(text)
        found = b""
        while not found.endswith(end):
            found += self.socket.recv(1000)
        return found

    def end(self, how: int = signal.SIGTERM) -> int:
        """End the process; returns its status."""
        self.process.send_signal(how)
        status = self.process.wait(30)
        self.socket.close()
        self.process.stdout.close()
        self.process.stderr.close()
        return status


@contextmanager
def served(*how: str):
    server = Served(*how)
    try:
        yield server
    finally:
        if server.process.poll() is None:
            server.end(signal.SIGKILL)


@pytest.mark.system
def test_a_server_keeps_its_eeprom(folder) -> None:
    with served("--state", "state") as server:
        assert server.ask("O 0A0H\r? O\r", b"\r") == b"O=00160\r"  # CTS from now on: the EEPROM is slower than the line
        assert server.ask("E\rN 5\r+\rG\r0\rQ? Y\r", b"\r") == b"Y=00010\r"
        assert server.end() == 0  # before the flush is due, on a machine that is not too slow
    assert {path.name for path in Path("state").iterdir()} == {".lock", "memory.eeprom"}
    with served("--state", "state", "--lockstep") as server:
        assert server.ask("Y 0\r? M,4\r", b"\r0\r") == b"Y=00000\r" + PROGRAM


@pytest.mark.system
def test_an_image_replaces_the_old_content_of_the_eeprom(folder) -> None:
    write_image("p.hex", PROGRAM)
    write_image("q.bin", b"N 7\r")
    for image in ("p.hex", "q.bin"):
        with served("--state", "state", "--lockstep", "--memory", image) as server:
            assert server.ask("? Y\r", b"\r") == b"Y=00000\r"
            assert server.end() == 0
    with served("--state", "state", "--lockstep") as server:
        assert server.ask("Y 0\r? M,4\r", b"\r0\r") == b"Y=00000\rN 7\r" + PROGRAM[4:]
