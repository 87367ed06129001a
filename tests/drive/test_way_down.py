"""A brake in every phase of a motion: the board goes down by the law of the chip, to the step."""

from __future__ import annotations

from random import Random
from typing import NamedTuple

import pytest

import slewline
from tests.ensembles import few, members

from . import test_rewind
from .test_rewind import Driven

FEW, MANY = 1, 101


class BrakeCase(NamedTuple):
    """A chip, its motion, and the pin that ends it."""

    part: str
    text: str
    pin: str
    options: dict[str, object] = {}  # noqa: RUF012  # of the part
    level: int = 0
    off: int = 1  # steps by which the board may stop elsewhere; 2 where levels change too fast for a record each

    def alone(self, *edges):
        """The chip without a board."""
        bench = slewline.Bench()
        x = bench.add(self.part, "x", **self.options)
        bench.host(x).send(self.text)
        for at in edges:
            bench.pin(f"x.{self.pin}").drive(self.level, at=at)
        bench.run_to("4 s")
        return x


CASES = {
    "cy500": BrakeCase("cy500", "R 200\rF 10\rN 60\rG\r", "abort"),
    "cy525": BrakeCase("cy525", "A 0\rF 40\rR 75\rS 200\rZ 1\rN 1200\rG\r", "abort"),
    "cy525 long ramp": BrakeCase("cy525", "A 0\rF 10\rR 120\rS 120\rZ 1\rN 6000\rG\r", "abort"),
    "cy525 fast": BrakeCase("cy525", "A 0\rF 20\rR 127\rS 255\rZ 1\rN 5000\rG\r", "abort", off=2),
    "cy545": BrakeCase("cy545", "F 50\rR 150\rS 150\r+\rN 2000\rG\r", "inhibit_abort"),
    "cy545 to 27 k": BrakeCase(
        "cy545", "+\rF 10\rR 255\rS 250\rN 30000\rG\r", "inhibit_abort", {"rate_table": "27k", "fixed_baud": 9600}
    ),
    "cy545 slew": BrakeCase("cy545", "F 60\rR 120\rS 200\r+\rN 2500\rG\r", "inhibit_abort"),
}


each_phase = members("phases", FEW, MANY)


@each_phase
@pytest.mark.parametrize("name", few(CASES, 4))
def test_the_board_stops_within_a_step_of_the_chip_in_all_phases(name, phases, tmp_path, monkeypatch):
    case = CASES[name]
    monkeypatch.setitem(test_rewind.CASES, name, (case.part, case.options, case.text, "", case.pin, case.level, (0, 0)))
    steps = case.alone().steps()
    first, last = int(steps.times_ps[1]), int(steps.times_ps[-1])
    for phase in phases:
        rnd = Random(f"{name} {phase}")
        # Phases follow one another by the golden ratio, so those of all cases lie in all parts of the motion.
        share = (phase + list(CASES).index(name)) * 0.618034 % 1
        ps = first + int((last - first) * share) + rnd.randrange(10**8)
        (folder := tmp_path / str(phase)).mkdir()
        rig = Driven(folder, name, rnd)
        drive, line = rig.drive, rig.line
        with drive:
            drive.run(f"{ps + drive._state.horizon_ps} ps")
            rig.edge(case.level)
            instant = drive._path.ticks.ps(line.twin.now - drive._state.horizon)
            drive.run("2 s")
            straight = case.alone(instant)
            off = len(line.twin.steps) - len(straight.steps())
            assert abs(off) <= case.off, (phase, share, off)
            assert drive.state == "ok", drive.troubles
            assert all("taken-over" in each for each in drive.troubles), drive.troubles
            count = len(line.twin.steps)
            if case.part == "cy500":
                continue  # it powers up with any position
            assert line.twin.position == rig.x.position == count
            # On a way up a step more is two more in all: there are counts at which the chip ends at no instant, and
            # there its register has taken over that of the board.
            assert abs(rig.x.travel - count) <= case.off * len(drive.troubles)
