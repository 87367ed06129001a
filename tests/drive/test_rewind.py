"""Inputs of the board that stop the motor: chip, host and board agree on where it stands, whatever the phase."""

from __future__ import annotations

from random import Random

import pytest

import slewline
from slewline.bench.rewinding import Past, take_over
from slewline.drive.drive import Drive
from slewline.drive.reflexes import configured, inputs_of
from slewline.drive.rewind import Rewind
from slewline.drive.wire import BoardConfig, Reflex
from slewline.errors import UsageError

from .families import GSC
from .rig import HZ, TwinLine, drive_of

MS = 10**9
SET_UP = "I3\rPo\rS50\rT300\rR90\r%sPx\rE\r"
CASES = {  # part, options, text, text at 200 ms, pin, level, ms
    "cy500 abort": ("cy500", {}, "R 200\rF 10\rN 900\rG\r", "", "abort", 0, (100, 600)),
    "cy525 abort": ("cy525", {}, "A 0\rF 10\rR 120\rS 120\rZ 1\rN 6000\rG\r", "", "abort", 0, (100, 900)),
    "cy545 limit": ("cy545", {}, "F 50\rR 150\rS 150\r+\rN 2000\rG\r", "", "cw_limit", 0, (100, 700)),
    "cy545 stop": ("cy545", {}, "F 50\rR 150\rS 150\r+\rN 2000\rG\r", "", "inhibit_abort", 0, (100, 700)),
    "gs-c200s homing": ("gs-c200s", GSC, SET_UP % "", "H\r", "eot", 0, (300, 700)),
}


class Driven:
    """A chip that a board follows, with an input of the board on a pin."""

    def __init__(self, folder, name, rnd, *, wiring=None, edge_ms=None):
        part, options, text, later, self.pin, self.level, self.span = CASES[name]
        self.bench = slewline.Bench(journal=folder / "journal")
        x = self.bench.add(part, "x", **options)
        self.host = self.bench.host(x, name="h")
        self.host.send(text)
        if later:
            self.bench.at("200 ms", lambda: self.host.send(later))
        self.line = TwinLine(rnd)
        self.drive: Drive = drive_of(self.bench, x, self.line, start_stop=30000)
        self.past = Past(folder / "journal", shadows=3)
        self.wired = inputs_of(x, wiring or {"A0": self.pin})
        self.rewind = Rewind(self.drive, self.past, self.exchange, self.wired, folder / "copy")
        for number, each in enumerate(self.wired):
            self.line.twin.inputs |= (1 - each.acts ^ each.inverted) << number
        self.exchanged = 0
        turn = self.drive.turn

        def both():
            self.rewind.before_turn()
            turn()

        self.drive.turn = both  # type: ignore[method-assign]

    def exchange(self, bench, _since_ps):
        take_over(bench, self.bench)
        self.bench, self.exchanged = bench, self.exchanged + 1

    @property
    def x(self):
        return self.bench["x"]

    def edge(self, level, number=0):
        """An edge at an input of the board, now."""
        line = self.line
        line.twin.set_input(number, level, max(line.tick(line.now), line.twin.now))


def signature(bench, stop):
    x = bench["x"]
    return x.steps(0, stop).positions.tolist(), dict(x.registers)


@pytest.mark.parametrize("name", CASES)
def test_the_chip_stops_where_the_board_has(name, tmp_path):
    rnd = Random(name)
    off = []
    for number in range(25):
        (folder := tmp_path / str(number)).mkdir()
        rig = Driven(folder, name, rnd)
        drive, line = rig.drive, rig.line
        with drive:
            drive.run(f"{rnd.randrange(*rig.span) * 1000 + rnd.randrange(1000)} us")
            rig.edge(rig.level)
            tick = line.twin.now
            instant = drive.ticks.ps(tick - drive.horizon)
            drive.run("400 ms")
            assert rig.exchanged == 1, (number, drive.troubles, rig.rewind.tail, line.twin.steps[-3:])
            assert drive.state == "ok" and not drive.troubles, drive.troubles
            if "homing" in name:
                assert rig.x.moving  # on its way back
                rig.x.pin("home").drive(0)
                drive.run("300 ms")
                continue
            drive.run("200 ms")
            assert line.twin.position == rig.x.travel == len(line.twin.steps)
            # the law of the chip, without any board
            straight = slewline.Bench()
            part, options, text, *_ = CASES[name]
            x = straight.add(part, "x", **options)
            straight.host(x).send(text)
            straight.pin(f"x.{rig.pin}").drive(rig.level, at=instant)
            straight.run_to("3 s")
            off.append(rig.x.travel - x.travel)
    assert all(abs(each) <= 1 for each in off), off
    print(name, off)
