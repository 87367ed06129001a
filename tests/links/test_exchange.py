"""Another bench in the place of the one that is served: hosts on real ports notice nothing.

A wall clock of the test's own; a cable of 100 ms lets out what modules say.  The run in which an input was put into the
past is compared with the one in which it came at its time: what the host has got, byte for byte, and the bench.
"""

from __future__ import annotations

import json
import os
import select
import sys
from collections import deque
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import pytest

import slewline
from slewline.bench.past import driven
from slewline.errors import UsageError
from slewline.links.lines.outlet import Outlet, SentBytes
from slewline.links.lines.pace import Paced
from slewline.links.server import Server
from tests.ensembles import members

from .conftest import STRAPS, Asks, Client

MS = 10**9
CABLE = 100 * MS
posix = pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")


class Cable:
    """Calls leave a while after their instant, in order; at rest at once."""

    def __init__(self, length: int = CABLE) -> None:
        self.length, self.held = length, deque[tuple[int, Any]]()

    def send(self, call: Any, at_ps: int) -> None:
        self.held.append((at_ps + self.length, call))

    def look(self, now: int) -> None:
        while self.held and self.held[0][0] <= now:
            self.held.popleft()[1]()


class Rig:
    """A server whose wall clock stands between two turns, and a host on a port of it."""

    def __init__(self, folder: Path, part: str, port: str = "tcp", length: int = CABLE, **line: Any) -> None:
        self.clock, self.folder = 0, folder
        bench = slewline.Bench(journal=folder / "journal")
        x = bench.add(part, "x", straps=STRAPS if part.startswith("gs") else None)
        self.told: list[str] = []
        self.server = server = Server(bench, Paced(bench, clock=lambda: self.clock), report=self.told.append)
        self.line = server.line(x, **line)
        self.past = server.past
        self.past.remember()
        self.cable = Cable(length)
        self.line.gate = self.cable.send
        self.heard = bytearray()
        if port == "tcp":
            self.client = Client(server.tcp(self.line, "127.0.0.1:0").where)
            self.client.socket.setblocking(False)
        else:
            server.pty(self.line, str(folder / "pty"))
            self.fd = os.open(folder / "pty", os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            import tty

            tty.setraw(self.fd)
        self.port = port
        bench.run(0)
        server.pace.start()
        self.turn(0)

    @property
    def now(self) -> int:
        return self.server.bench.now_ps

    def send(self, data: bytes) -> None:
        """Send bytes; they are on the line at this instant."""
        taken = self.line.taken
        if self.port == "tcp":
            self.client.send(data)
        else:
            os.write(self.fd, data)
        while self.line.taken < taken + len(data):
            self.server.loop.serve(self.server.loop.sleep(0.2))

    def turn(self, ms: float = 1) -> None:
        """Let a while of the wall clock pass."""
        self.clock += int(ms * 10**6)
        while not self.server.pace.pass_time():
            pass
        self.cable.look(self.now)
        self.server.loop.serve(self.server.loop.sleep(0))
        try:
            while data := self.client.socket.recv(4096) if self.port == "tcp" else os.read(self.fd, 4096):
                self.heard += data
        except BlockingIOError:
            pass

    def hear_all(self) -> None:
        """Take what the system has not yet brought to the host."""
        while len(self.heard) < self.line.given + len(getattr(self.line, "greeting", b"")):
            self.turn(0)

    def run(self, script: list[tuple[int, bytes]], until_ms: int) -> None:
        """Let a host say what it says, by milliseconds."""
        for ms, data in script:
            while self.now < ms * MS <= until_ms * MS:
                self.turn()
            if ms <= until_ms and self.now == ms * MS:
                self.send(data)
        while self.now < until_ms * MS:
            self.turn()

    def back(self, *inputs: dict[str, Any]) -> None:
        """Put inputs into the past."""
        first = int(inputs[0]["t"])
        self.past.go_on(self.past.at(first).rerun(inputs, self.now, self.folder / "copy"), first)

    def state(self) -> tuple[Any, ...]:
        x = self.server.bench["x"]
        axes = [(a.steps().times_ps.tolist(), dict(a.registers)) for a in map(x.axis, range(1, x.sheet.axes + 1))]
        return axes, [str(found) for found in self.server.bench.findings], x.waiting

    def close(self) -> None:
        self.server.close()
        if self.port == "tcp":
            self.client.close()
        else:
            os.close(self.fd)


GSC = [
    *enumerate([b"Po\r", b"S50\r", b"T200\r", b"R90\r", b"+900\r", b"E\r"], 2),
    *[(60 + 40 * n, b"V1\r" if n % 2 else b"F\r") for n in range(20)],
]
FRAMED = [
    (2, b"A 0\rF 10\rR 120\rS 120\rZ 1\rN 4000\rG\r"),
    *[(100 + 30 * n, (b"?\r", b"?0\r", b"?1\r")[n % 3]) for n in range(20)],
]
GPIB = [
    (2, b"A 0\nF 10\nR 120\nS 120\nZ 1\nN 4000\nG\n++read_tmo_ms 20\n"),
    *[(100 + 30 * n, (b"++spoll\n", b"++read eoi\n", b"++srq\n++addr\n")[n % 3]) for n in range(20)],
]


def packets(*words: int) -> bytes:
    """Requests that write words to the registers of a board: a command, then data."""
    found = b""
    for number, word in enumerate(words):
        register = 0x12 if number == 0 else 0x10
        for byte in (word,) if number == 0 else divmod(word, 256):
            found += bytes([register, byte])
        found += b"\x24\x64"
    return found


MC = [
    (2, packets(0x10, 0, 60000) + packets(0x11, 2, 0) + packets(0x12, 0, 0x800) + packets(0x1A)),
    *[(60 + 20 * n, packets(0x1D) + bytes([0x00, 0, 0x00, 0, 0x24, 0x64] * 2)) for n in range(20)],
]
CASES: dict[str, tuple[str, str, dict[str, Any], list[tuple[int, bytes]], list[tuple[str, int]]]] = {
    "module on TCP": ("gs-c200s", "tcp", {}, GSC, [("enable", 0), ("enable", 1)]),
    "module on a pty": ("gs-c200s", "pty", {}, GSC, [("enable", 0), ("enable", 1)]),
    "lines of text": ("cy525", "tcp", {"framing": True}, FRAMED, [("abort", 0), ("abort", 1)]),
    "GPIB controller": ("cy525", "tcp", {"prologix": True}, GPIB, [("abort", 0), ("abort", 1)]),
    "registers": ("mc1451a", "tcp", {}, MC, [("poslimit1", 1), ("poslimit1", 0)]),
}


@pytest.mark.posix
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.system] * (row[1] == "pty")) for name, row in CASES.items()]
)
@members("numbers", 2, 8, at_once=3)
def test_a_host_gets_the_same_as_in_a_straight_run(name: str, numbers: range, tmp_path: Path) -> None:
    part, port, line, script, edges = CASES[name]
    differing = 0
    for number in numbers:
        chance = Random(f"{name} {number}")
        first = chance.randrange(70 * MS, 400 * MS)
        inputs = [driven(f"x.{pin}", level, first + n * 7 * MS) for n, (pin, level) in enumerate(edges)]
        present = int(inputs[-1]["t"]) // MS + chance.randrange(2, 90)

        (folder := tmp_path / f"straight{number}").mkdir()
        straight = Rig(folder, part, port, **line)
        for each in inputs:
            straight.server.bench.pin(each["pin"]).drive(each["level"], at=each["t"])
        straight.run(script, 900)

        (folder := tmp_path / f"back{number}").mkdir()
        rig = Rig(folder, part, port, **line)
        rest = first // MS - chance.randrange(1, 60)
        rig.run([row for row in script if row[0] <= rest], rest)
        assert rig.past.follow(rig.now - 1)
        rig.run([row for row in script if rest < row[0] <= present], present)
        before = rig.state()
        rig.back(*inputs)
        differing += before != rig.state()
        rig.run([row for row in script if row[0] > present], 900)
        for each in (rig, straight):
            for _ in range(200):
                each.turn()
            each.hear_all()
        assert rig.state() == straight.state()
        assert rig.heard == straight.heard
        assert len(rig.heard) > 40
        assert rig.line.outlet.waiting == 0
        rig.close()
        straight.close()
    assert differing > len(numbers) // 3


def test_bytes_that_have_left_are_not_sent_again_and_others_once() -> None:
    got: list[bytes] = []
    held: list[Any] = []
    outlet = Outlet(lambda data, _to: got.append(data))
    outlet.gate = lambda call, _ps: held.append(call)
    outlet.remember(0)
    for ps, data in ((10, b"Y"), (20, b"A"), (30, b"B"), (40, b"C")):
        outlet.send(data, ps)
    for call in held[:2]:
        call()
    assert b"".join(got) == b"YA" and outlet.waiting == 2
    outlet.forget(10)
    assert outlet.resend([SentBytes(20, b"A"), SentBytes(30, b"B"), SentBytes(35, b"D")]) == b""
    for call in held[2:]:  # the old ones are void
        call()
    assert b"".join(got) == b"YABD" and outlet.waiting == 0
    # once more: the module has said nothing of D
    assert outlet.resend([SentBytes(20, b"A"), SentBytes(30, b"B"), SentBytes(36, b"E"), SentBytes(37, b"F")]) == b"D"
    for call in held[6:]:
        call()
    assert b"".join(got) == b"YABDEF"


def test_clients_and_breakpoints_continue(tmp_path: Path) -> None:
    rig = Rig(tmp_path, "gs-c200s")
    control = Client(rig.server.control("127.0.0.1:0").where)
    ask = Asks(control)

    def answer(do: str, **more: Any) -> Any:
        request(do, **more)
        return reply()

    def request(do: str, **more: Any) -> None:
        control.send(json.dumps({"do": do} | more).encode() + b"\n")

    def reply() -> Any:
        served(lambda: select.select([control.socket], [], [], 0)[0])
        return ask.answer()

    def served(met: Callable[[], object]) -> None:
        while not met():
            rig.server.loop.serve(rig.server.loop.sleep(0.01))

    rig.run(GSC[:6], 100)
    answer("record", pins=["x.mov"])
    assert "error" not in answer("breakpoints", breakpoints=[{"chip": "x", "position": 300}])
    waits = len(rig.server.pace.waits)
    request("until", chip="x", position=200)
    served(lambda: len(rig.server.pace.waits) > waits)
    rig.past.follow(rig.now - 1)
    rig.run([], 150)
    rig.back(driven("x.enable", 0, 110 * MS), driven("x.enable", 1, 140 * MS))
    assert rig.server.bench.pin("x.enable").level == 1
    x = rig.server.bench["x"]
    while x.position < 200:
        rig.turn()
    assert reply()["met"] is True
    while not rig.server.pace.paused:
        rig.turn()
    assert x.position == 300 and answer("status")["chips"]["x"]["position"] == 300
    found = answer("window", signals=["x.mov"], start="105 ms", stop="300 ms", columns=10)
    assert "error" not in found, found
    assert answer("view")["view"]["chips"]["x"]["axes"][0]["position"] == 300
    control.close()
    rig.close()


def test_a_bench_that_does_not_fit_is_refused_and_nothing_changes(tmp_path: Path) -> None:
    rig = Rig(tmp_path, "gs-c200s")
    bench = rig.server.bench
    rig.run(GSC[:6], 60)
    with pytest.raises(UsageError, match="at 0 ps; expected the present time of the served bench, 60 ms"):
        rig.past.go_on(slewline.Bench())
    other = slewline.Bench()
    other.run_to("60 ms")
    with pytest.raises(UsageError, match="lacks x, x_line"):
        rig.past.go_on(other)
    assert rig.server.bench is bench
    rig.run(GSC[6:], 1100)
    rig.hear_all()
    assert rig.heard.count(b"\r") == 26
    rig.close()
