"""An unchanged host program on a socket homes, moves and stops a module whose motor a board drives."""

from __future__ import annotations

from random import Random

import pytest

import slewline
from slewline.drive.board.wire import BoardState
from slewline.links.lines.pace import Paced
from slewline.links.server import Server
from tests.ensembles import few

from ..links.conftest import Client
from .families import GSC
from .rig import MS_NS, Pulses, TwinLine, drive_of

END, HOME = 260, 90  # where the switches are, in steps from where the motor stood at first


class Machine:
    """A module on a TCP port; with a board its motor moves the switches, without one the model's."""

    def __init__(self, folder, rnd, *, driven, start_stop=4000):
        self.now_ns, self.folder, self.driven = 0, folder, driven
        self.bench = slewline.Bench(journal=folder / "journal")
        self.bench.add("gs-c200s", "x", **GSC)
        self.line = TwinLine(rnd)
        self.pulses = Pulses()
        self.heard = bytearray()
        x = self.bench["x"]
        if not driven:
            self.server = Server(self.bench, Paced(self.bench, clock=lambda: self.now_ns))
            self.served = self.server.line(x)
            motor = self.bench.part("motor", "motor", to=x)
            for name, low, high in (("eot", END, None), ("home", None, HOME)):
                self.bench.part("switch", name, on=motor, low=low, high=high)
                self.bench.wire(f"{name}.out", f"x.{name}")
            self.open()
            return
        self.told = []
        self.drive = drive_of(self.bench, x, self.line, start_stop=start_stop, inputs={"A0": "eot", "A1": "home"})
        self.server = Server(self.bench, Paced(self.bench, clock=self.drive.nanoseconds), report=self.told.append)
        self.served = self.server.line(x)
        self.drive.go_back_by(self.server.past)
        self.rewind = self.drive._live.rewind
        self.server.past.remember()
        self.line.twin.inputs = 0b01  # the motor stands at 0, which is home
        self.served.gate = self.drive.gate
        wait = self.line.pass_to

        def pass_to(ns):
            wait(ns)
            self.switches()

        self.line.pass_to = pass_to
        self.drive.open()
        self.open()

    def open(self):
        self.client = Client(self.server.tcp(self.served, "127.0.0.1:0").where)
        self.client.socket.setblocking(False)
        self.server.bench.run(0)
        self.server.pace.start()
        self.turn()

    def switches(self):
        twin = self.line.twin
        at = self.pulses(twin)
        for number, level in ((0, int(at < END)), (1, int(at > HOME))):
            if (twin.inputs >> number & 1) != level:
                twin.set_input(number, level, max(self.line.tick(self.line.now), twin.now))

    def turn(self):
        if self.driven:
            self.line.wait(0.002)
        self.now_ns += 2 * MS_NS
        while not self.server.pace.pass_time():
            pass
        if self.driven:
            self.drive.turn()
        self.server.loop.serve(self.server.loop.sleep(0))
        try:
            while data := self.client.socket.recv(4096):
                self.heard += data
        except BlockingIOError:
            pass

    def ask(self, text):
        """Send a line; return the answer."""
        before, taken = self.heard.count(b"\r"), self.served.taken
        self.client.send(text.encode() + b"\r")
        while self.served.taken < taken + len(text) + 1:
            self.server.loop.serve(self.server.loop.sleep(0.2))
        for _ in range(3000):
            self.turn()
            if self.heard.count(b"\r") > before:
                return bytes(self.heard).split(b"\r")[-2].decode()
        raise AssertionError((text, bytes(self.heard), getattr(self, "drive", None) and self.drive.troubles))

    def settle(self):
        """Ask until the module is ready."""
        for _ in range(400):
            if self.ask("F") == "R":
                return
            for _ in range(10):
                self.turn()
        raise AssertionError(self.drive.troubles if self.driven else "")

    @property
    def x(self):
        return self.server.bench["x"]

    def close(self):
        if self.driven:
            self.drive.close()
        self.server.close()
        self.client.close()


def session(machine):
    """What a host does, and what it gets."""
    found = [machine.ask(text) for text in ("Po", "S50", "T100", "R50", "+150", "Px", "E")]
    machine.settle()
    found.append(machine.ask("V1"))
    found.append(machine.ask("H"))
    machine.settle()
    found.append(machine.ask("V1"))
    found += [machine.ask(text) for text in ("Po", "S50", "T300", "R50", "+100", "-40", "Px", "E")]
    machine.settle()
    found.append(machine.ask("V1"))
    found += [machine.ask(text) for text in ("Po", "S50", "T300", "R50", "-5000", "Px", "E")]
    for _ in range(300):
        machine.turn()
    found.append(machine.ask("K"))
    machine.settle()
    found.append(machine.ask("V1")[0])
    return found


@pytest.mark.posix
@pytest.mark.parametrize("seed", few(range(3), 1))
def test_the_transcript_is_that_of_a_module_that_is_served(seed, tmp_path):
    for name in ("driven", "served"):
        (tmp_path / name).mkdir()
    served = Machine(tmp_path / "served", Random(seed), driven=False)
    wanted = session(served)
    served.close()
    machine = Machine(tmp_path / "driven", Random(seed), driven=True)
    assert session(machine) == wanted
    line, x = machine.line, machine.x
    assert not machine.drive.troubles and machine.rewind.rewinds == 3  # two ends of the homing, and K
    for _ in range(200):
        machine.turn()
    assert line.twin.position == x.travel == sum(direction for _, direction, _ in line.twin.steps)
    machine.close()
    again = slewline.replay(tmp_path / "driven" / "journal")["x"]
    assert (again.travel, again.position) == (x.travel, x.position)


@pytest.mark.posix
@pytest.mark.parametrize("start_stop", [500, 4000])
def test_a_host_receives_no_stop_before_its_end_is_known(start_stop, tmp_path):
    machine = Machine(tmp_path, Random(5), driven=True, start_stop=start_stop)
    for text in ("Po", "S50", "T300", "R950", "-90000", "Px", "E"):
        assert machine.ask(text) == "Y"
    for _ in range(500):
        machine.turn()
    assert machine.ask("Z") == "Y"
    if start_stop == 500:  # a way down of some 500 ms, five horizons; else the board stands at once
        assert machine.line.twin.state == BoardState.BRAKE
        assert machine.ask("F") == "B"
    machine.settle()
    line, x = machine.line, machine.x
    assert int(machine.ask("V1")[1:]) == line.twin.position == x.position == -len(line.twin.steps)
    assert machine.rewind.rewinds == 1 and all("taken-over" in each for each in machine.drive.troubles)
    assert not [each for each in machine.told if "taken back" in each]
    machine.close()
