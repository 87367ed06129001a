"""Inputs of the board: the motor stops where the chip would have stopped it, and the count is that of the pulses."""

from __future__ import annotations

from random import Random
from typing import NamedTuple

import numpy as np
import pytest

import slewline
from slewline.drive.board.records import Record
from slewline.drive.board.wire import BoardConfig, BoardState, FrameKind, Happening, Reflex, encode
from tests.drive.families import GSC
from tests.ensembles import members

from .chain import HZ, WITHIN_TICKS, EmulatedLine, drive_of, events, off, said, wanted
from .talk import Talk

pytestmark = pytest.mark.system

FEW, MANY = 1, 100
WAY_DOWN_WITHIN = 3000  # ticks that a step of a ramp may be off whose levels share 40 entries
NO_ENABLE = 0  # `driver` of a board that makes steps and does not switch the current
STAMP_WITHIN = 1400  # ticks from an edge to the instant that the board tells


class InputCase(NamedTuple):
    """A motion, and an edge that comes somewhere in it.

    `pin`: of the chip, whose law is the right one; "" if it is the board's own.  `level`: the one at which it acts.
    `span`: ms of the model, from the beginning.
    """

    part: str
    options: dict
    text: str
    pin: str
    level: int
    reflex: int
    span: tuple[int, int]
    happening: int = Happening.STOPPED
    later: str = ""  # what the host sends at 200 ms


AT_45_K = "SET_VEL 45000 steps/s\nSET_ACC 400000 steps/s2\nSET_POS 60000\nUPDATE"
CASES = {
    "limit of a cy545": InputCase(
        "cy545", {}, "F 50\rR 150\rS 150\r+\rN 2000\rG\r", "cw_limit", 0, Reflex.STOP, (60, 400)
    ),
    "limit of a cy545 at 27 k": InputCase(
        "cy545",
        {"rate_table": "27k", "fixed_baud": 9600},
        "+\rF 10\rR 255\rS 250\rN 30000\rG\r",
        "cw_limit",
        0,
        Reflex.STOP,
        (500, 800),
    ),
    "limit of an mc1451a": InputCase(
        "mc1451a",
        {},
        "SET_VEL 1000 steps/s\nSET_ACC 10000 steps/s2\nSET_POS 2000\nUPDATE",
        "poslimit1",
        1,
        Reflex.STOP | Reflex.UPWARDS,
        (60, 500),
    ),
    "e-stop at 10 k": InputCase(
        "gs-c200s", GSC, "I3\rPo\rS100\rT1000\rR255\r+8000\rPx\rE\r", "", 1, Reflex.ESTOP, (100, 700), Happening.ESTOP
    ),
    "e-stop at 45 k": InputCase("mc1451a", {}, AT_45_K, "", 1, Reflex.ESTOP, (60, 500), Happening.ESTOP),
    "abort of a cy525": InputCase(
        "cy525", {}, "A 0\rF 10\rR 120\rS 200\rZ 1\rN 9000\rG\r", "abort", 0, Reflex.BRAKE, (280, 850), Happening.BRAKED
    ),
    "abort of a cy525 in all phases": InputCase(
        "cy525", {}, "A 0\rF 10\rR 120\rS 200\rZ 1\rN 6000\rG\r", "abort", 0, Reflex.BRAKE, (1, 888), Happening.BRAKED
    ),
    "abort of a cy545 in all phases": InputCase(
        "cy545", {}, "F 50\rR 150\rS 150\r+\rN 1200\rG\r", "inhibit_abort", 0, Reflex.BRAKE, (1, 625), Happening.BRAKED
    ),
    "homing of a gs-c200s": InputCase(
        "gs-c200s", GSC, "I3\rPo\rS50\rT300\rR90\rPx\rE\r", "eot", 0, Reflex.STOP, (250, 700), later="H\r"
    ),
    "homing of a cy545": InputCase(
        "cy545", {"rate_table": "27k", "fixed_baud": 9600}, "F 200\rH 0\r", "usrb0", 1, Reflex.STOP, (60, 500)
    ),
}


class DrivenInput:
    """A chip that an emulated board follows; input 0 of the board is the pin of a case."""

    def __init__(self, emulator, case, seed):
        self.case = case
        self.bench = slewline.Bench()
        self.x, _ = chip_of(self.bench, case)
        self.line = EmulatedLine(emulator, seed)
        self.line.board.set_input(0, 1 - case.level, 0)
        self.line.stop_host(1)
        reflexes = (int(case.reflex), 0, 0, 0, 0, 0)
        config = BoardConfig(HZ // 500, HZ // 5, active=case.level, report=1, driver=NO_ENABLE, reflex=reflexes)
        self.drive = drive_of(self.bench, self.x, self.line, config=config)
        self.random = Random(f"{case.part} {case.pin} {seed}")

    def edge(self, level, tick=None):
        """Let an edge come at input 0, some ticks from now; return its tick."""
        board = self.line.board
        tick = board.now + self.random.randrange(40, 4000) if tick is None else tick
        board.set_input(0, level, tick)
        return tick

    def run_to(self, ms):
        """Run to somewhere in a millisecond of the model."""
        self.drive.run(ms * 10**9 + self.random.randrange(10**9) - self.bench.now_ps)

    def instant(self, tick):
        """The instant of the model that belongs to a tick of the board (ps)."""
        return self.drive._path.ticks.ps(tick - self.drive._state.horizon)


def chip_of(bench, case):
    """The chip of a case, and its host, which has queued its text."""
    x = bench.add(case.part, name="x", **case.options)
    host = bench.host(x, over="serial") if case.part == "cy545" else bench.host(x)
    if case.pin:
        x.pin(case.pin).drive(1 - case.level)
    host.send(case.text)
    if case.later:
        bench.at("200 ms", lambda: host.send(case.later))
    return x, host


def lawful(case, edges, until_ms):
    """How far the chip goes by itself if its pin has edges at some instants (ps, level)."""
    bench = slewline.Bench()
    x, _ = chip_of(bench, case)
    for ps, level in edges:
        x.pin(case.pin).drive(level, at=ps)
    bench.run_to(f"{until_ms} ms")
    return x


each_phase = members("seeds", FEW, MANY)


@each_phase
@pytest.mark.parametrize("name", CASES)
def test_the_motor_stops_where_the_chip_would_have(emulator, name, seeds):
    case = CASES[name]
    found = []
    for seed in seeds:
        rig = DrivenInput(emulator, case, seed)
        drive, line = rig.drive, rig.line
        with drive:
            rig.run_to(rig.random.randrange(*case.span))
            drive.run("110 ms")
            tick = rig.edge(case.level)
            instant = rig.instant(tick)
            moving_ms = 130 if case.happening != Happening.BRAKED else 700
            due, _directions = wanted(drive)
            drive.run(f"{moving_ms} ms")
            made = np.array(line.board.rises)
            stop, *rest = [each for each in events(line) if each.kind == case.happening]
            assert not rest and stop.which == 0 and tick <= stop.tick < tick + STAMP_WITHIN
            last = said(line)
            assert last.state == BoardState.HALT
            assert last.position == sum(way for _, way in line.board.steps)  # exact, in all
            if case.happening != Happening.BRAKED:
                assert made[-1] <= stop.tick and stop.position == last.position
                assert (made > tick).sum() <= 1 + (stop.tick - tick) * len(made) / made[-1]
            before = made[made <= tick]
            assert (np.abs(before - due[: len(before)]) <= WITHIN_TICKS).all()
            if case.pin:
                x = lawful(case, [(instant, case.level)], int(instant / 1e9) + moving_ms)
                # Where the edge came just before a step, the board has seen it behind that step, as a chip would at its
                # stamp: in a ramp, at the border of two levels, the way down is then longer by what a level has.
                seen = lawful(case, [(rig.instant(stop.tick), case.level)], int(instant / 1e9) + moving_ms)
                x = min(x, seen, key=lambda each: abs(last.position - farthest(each)))
                found.append(last.position - farthest(x))
                if case.happening == Happening.BRAKED and not found[-1]:
                    lawfully = drive._path.ticks.many(x.steps().times_ps) / 65536 + drive._state.horizon
                    assert np.abs(made - lawfully).max() < WAY_DOWN_WITHIN
            else:
                found.append(int((made > tick).sum()))
            assert rig.drive.state == "halted"
    print(name, "steps off the law:", {n: found.count(n) for n in sorted(set(found))})
    assert max(found) <= 1 and min(found) >= -1, found


def farthest(x):
    """How far a chip has gone that may have turned back then."""
    way = np.cumsum(x.steps().directions)
    if not len(way):
        return 0
    return int(way[np.abs(way).argmax()])


@each_phase
def test_a_mark_has_the_position_of_its_edge(emulator, seeds):
    case = InputCase("mc1451a", {}, AT_45_K, "home1", 0, Reflex.MARK, (60, 600), Happening.MARK)
    found = []
    for seed in seeds:
        rig = DrivenInput(emulator, case, seed)
        drive, line = rig.drive, rig.line
        with drive:
            rig.run_to(rig.random.randrange(*case.span))
            drive.run("110 ms")
            tick = rig.edge(0)
            drive.run("40 ms")
            (mark,) = [each for each in events(line) if each.kind == Happening.MARK]
            made = np.array(line.board.rises)
            assert Happening.LATE not in [each.kind for each in events(line)]
            assert np.abs(off(drive, line)).max() <= WITHIN_TICKS
            assert 0 <= mark.tick - tick < STAMP_WITHIN
            assert mark.position == (made <= mark.tick).sum()
            found.append(mark.position - int((made <= tick).sum()))
            assert drive.state == "ok"
    print("marks:", {n: found.count(n) for n in sorted(set(found))})
    assert max(found) <= 1 and min(found) >= 0, found


def test_no_byte_is_lost_while_inputs_stop_the_motor(emulator):
    asks = b"".join(encode(number, FrameKind.ASK) for number in range(16))
    for phase in range(0, 2_000, 80):
        talk = Talk(emulator, report=63, reflex=(Reflex.STOP, 0, Reflex.MARK, 0, Reflex.STOP, 0))
        talk.play([Record(0, 1_000, 700)])
        talk.board.run(talk.board.now + 30_000)
        before, now = len(talk.answers), talk.board.now
        talk.board.receive(asks, now)
        for number in range(6):
            talk.board.set_input(number, 1, now + 10_000 + phase)
        talk.board.run(now + 250_000)
        assert not talk.board.lost and len(talk.answers) == before + 16
        assert talk.answers[-1].state == BoardState.HALT
