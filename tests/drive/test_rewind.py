"""Inputs of the board that stop the motor: chip, host and board agree on where it stands, whatever the phase."""

from __future__ import annotations

from random import Random

import pytest

import slewline
from slewline.bench.past import Past
from slewline.drive.board.boards import UNO
from slewline.drive.board.wire import BoardConfig, Reflex
from slewline.drive.motor_drive import Drive
from slewline.drive.stopping.reflexes import Homing, configured, inputs_of
from slewline.errors import UsageError
from tests.ensembles import members

from .families import GSC
from .rig import HZ, TwinLine, check_steps, drive_of

MS = 10**9
SET_UP = "I3\rPo\rS50\rT300\rR90\r%sPx\rE\r"
CASES = {  # part, options, text, text at 200 ms, pin, level, ms
    "cy500 abort": ("cy500", {}, "R 200\rF 10\rN 900\rG\r", "", "abort", 0, (150, 600)),
    "cy525 abort": ("cy525", {}, "A 0\rF 40\rR 75\rS 200\rZ 1\rN 1200\rG\r", "", "abort", 0, (150, 330)),
    "cy525 long ramp": ("cy525", {}, "A 0\rF 10\rR 120\rS 120\rZ 1\rN 6000\rG\r", "", "abort", 0, (150, 900)),
    "cy545 limit": ("cy545", {}, "F 50\rR 150\rS 150\r+\rN 2000\rG\r", "", "cw_limit", 0, (150, 700)),
    "cy545 stop": ("cy545", {}, "F 50\rR 150\rS 150\r+\rN 2000\rG\r", "", "inhibit_abort", 0, (150, 700)),
    "mc1451a mark": (
        "mc1451a",
        {},
        "SET_POS 9000\nSET_VEL 10000 steps/s\nSET_ACC 40000 steps/s2\nUPDATE%s",
        "",
        "home1",
        0,
        (300, 700),
    ),
    "gs-c200s hold": ("gs-c200s", GSC, SET_UP % "+900\r", "", "enable", 0, (220, 420)),
    "cy525 hold": ("cy525", {}, "A 0\rF 40\rR 75\rS 200\rZ 1\rN 1200\rG\r", "", "step_inhibit", 1, (150, 330)),
    "cy500 hold": ("cy500", {}, "R 200\rF 10\rN 900\rG\r", "", "trigger", 1, (150, 600)),
    "gs-c200s homing": ("gs-c200s", GSC, SET_UP % "", "H\r", "eot", 0, (300, 700)),
}


RAMPS = ("cy525 abort", "cy525 long ramp", "cy545 stop")


class Driven:
    """A chip that a board follows, with an input of the board on a pin."""

    def __init__(self, folder, name, rnd, *, wiring=None, edge_ms=None):
        part, options, text, later, self.pin, self.level, self.span = CASES[name]
        bench = slewline.Bench(journal=folder / "journal")
        x = bench.add(part, "x", **options)
        self.host = bench.host(x, name="h")
        self.host.send(text)
        if later:
            bench.at("200 ms", lambda: self.host.send(later))
        self.line = TwinLine(rnd)
        wired = wiring or {"A0": self.pin}
        self.wired = inputs_of(UNO, x, wired)
        dead = any(word in self.wired[0].reflex for word in ("stop", "hold"))
        self.drive: Drive = drive_of(bench, x, self.line, inputs=wired, start_stop=30000 if dead else None)
        self.drive.go_back_by(Past(bench))
        self.rewind = self.drive._live.rewind
        for number, each in enumerate(self.wired):
            at_rest = (1 - each.acts) ^ each.inverted
            self.line.twin.inputs = self.line.twin.inputs & ~(1 << number) | at_rest << number

    @property
    def bench(self):
        return self.drive.bench

    @property
    def exchanged(self):
        return self.rewind.rewinds

    @property
    def x(self):
        return self.drive.chip

    def edge(self, level, number=0):
        """An edge at an input of the board, now."""
        line = self.line
        line.twin.set_input(number, level, max(line.tick(line.now), line.twin.now))


def signature(bench, stop):
    x = bench["x"]
    return x.steps(0, stop).positions.tolist(), dict(x.registers)


@members("numbers", 1, 21)
@pytest.mark.parametrize("name", [name for name in CASES if "mark" not in name])
def test_the_chip_stops_where_the_board_has(name, numbers, tmp_path):
    off, differing = [], 0
    for number in numbers:
        rnd = Random(f"{name} {number}")
        (folder := tmp_path / str(number)).mkdir()
        rig = Driven(folder, name, rnd)
        drive, line = rig.drive, rig.line
        with drive:
            drive.run(f"{rnd.randrange(*rig.span) * 1000 + rnd.randrange(1000)} us")
            rig.edge(rig.level)
            tick = line.twin.now
            instant = drive._path.ticks.ps(tick - drive._state.horizon)
            drive.run("900 ms")
            assert rig.exchanged == 1, (number, drive.troubles, drive.stop_ramps.tail, line.twin.steps[-3:])
            assert drive.state == "ok" and all("taken-over" in each for each in drive.troubles), drive.troubles
            if "homing" in name:
                assert rig.x.moving  # on its way back
                rig.x.pin("home").drive(0)
                drive.run("300 ms")
                continue
            drive.run("200 ms")
            nearly = bool(drive.troubles)  # the law has no instant at which the count is that of the board
            assert line.twin.position == (rig.x.motor.position if nearly else rig.x.travel)  # the board counts
            assert len(line.twin.steps) == rig.x.position or rig.x.sheet.part == "cy500"
            differing += nearly
            # the law of the chip, without any board
            straight = slewline.Bench()
            part, options, text, *_ = CASES[name]
            x = straight.add(part, "x", **options)
            straight.host(x).send(text)
            straight.pin(f"x.{rig.pin}").drive(rig.level, at=instant)
            straight.run_to("3 s")
            off.append(rig.x.travel - x.travel)
    assert differing <= 2 * (name in RAMPS) and all(abs(each) <= 1 for each in off), off


@pytest.mark.parametrize("off", [-3, 2])
def test_the_count_at_rest_wins_over_that_at_the_stop(off, tmp_path, monkeypatch):
    rig = Driven(tmp_path, "cy545 limit", Random(1))
    drive, rewind = rig.drive, rig.rewind
    stopped = rewind.stopped
    monkeypatch.setattr(rewind, "stopped", lambda event: stopped(event._replace(position=event.position + off)))
    with drive:
        drive.run("400 ms")
        rig.edge(rig.level)
        drive.run("900 ms")
        assert rig.exchanged == 1
        assert (drive.state, drive.troubles) == ("ok", [])  # nothing had to be taken over: the law stops there
        assert rig.line.twin.position == rig.x.travel == len(rig.line.twin.steps)


@members("numbers", 2, 10)
def test_an_immediate_command_stops_the_motor_immediately(numbers, tmp_path):
    for number in numbers:
        command, rate, rnd = "KZ"[number % 2], 50, Random(f"K {number}")
        (folder := tmp_path / str(number)).mkdir()
        rig = Driven(folder, "gs-c200s homing", rnd)
        rig.host.send(f"Po\rS50\rT{rate}\rR90\r+5000\rPx\rE\r")
        drive, line = rig.drive, rig.line
        with drive:
            drive.run(f"{rnd.randrange(700, 900)} ms")
            assert rig.x.moving
            rig.host.send(command + "\r")
            before = line.now
            drive.run("300 ms")
            assert rig.exchanged == 1 and not rig.x.moving, drive.troubles
            assert drive.state == "ok" and not drive.troubles
            assert line.twin.position == rig.x.travel == len(line.twin.steps)
            assert line.twin.steps[-1][0] < line.tick(before) + 25 * HZ // 1000  # and not a horizon later
            rig.bench["h"].send("V1\r")
            drive.run("200 ms")
            assert rig.bench["h"].received.endswith(b"V%+d\r" % rig.x.position)
        assert slewline.replay(folder / "journal")["x"].travel == rig.x.travel


@pytest.mark.parametrize("command", ["K", "Z"])
def test_a_command_that_comes_as_the_motor_stops_is_forgotten_and_the_next_one_acts(tmp_path, command):
    rig = Driven(tmp_path, "gs-c200s homing", Random(command))
    drive, line = rig.drive, rig.line
    ordered = []
    motor = drive._motor
    stop, motor.stop = motor.stop, lambda at_once: (ordered.append(rig.x.position), stop(at_once))
    with drive:
        drive.run("150 ms")
        for number in range(12):
            rewinds, orders = rig.exchanged, len(ordered)
            way = rig.line.twin.position
            rig.bench["h"].send("Po\rS50\rT50\rR90\r+40\rPx\rE\r")
            while line.twin.position < way + 40 - number // 3:
                drive.run("200 us")
            rig.bench["h"].send(command + "\r")  # two characters of 1 ms, and up to 3 ms on the line of the board
            drive.run("300 ms")
            assert drive.state == "ok" and not drive.troubles and rig.rewind.command is None
            assert line.twin.position == rig.x.travel
            if len(ordered) > orders and rig.exchanged == rewinds:
                break
        else:
            pytest.fail("none came as the motor had stopped, and the board had not said so")
        rig.bench["h"].send("Po\rS50\rT50\rR90\r+5000\rPx\rE\r")
        drive.run("500 ms")
        rewinds = rig.exchanged
        rig.bench["h"].send(command + "\r")
        before = line.now
        drive.run("300 ms")
        assert rig.exchanged == rewinds + 1 and not rig.x.moving and not drive.troubles
        assert line.twin.steps[-1][0] < line.tick(before) + 25 * HZ // 1000  # and not a horizon later


def test_inputs_too_old_to_go_back_to_are_applied_at_the_present(tmp_path):
    rig = Driven(tmp_path, "cy545 limit", Random(3))
    rig.rewind.allowed_s = 0
    with rig.drive as drive:
        drive.run("500 ms")
        rig.edge(0)
        drive.run("500 ms")
        assert drive.state == "halted" and not rig.exchanged
        assert drive.troubles[0].startswith("late-input: ") and "allowed 0.000 s" in drive.troubles[0]
        assert rig.x.position == rig.line.twin.position == len(rig.line.twin.steps)


def test_a_board_that_is_reset_during_deceleration_stops_the_chip_too(tmp_path):
    rig = Driven(tmp_path, "cy525 long ramp", Random(8))
    with rig.drive as drive:
        drive.run("700 ms")
        rig.edge(rig.level)
        drive.run("15 ms")
        assert rig.rewind.stop is not None and rig.x.moving
        rig.line.reset_board()
        rig.edge(1 - rig.level)
        drive.run("1 s")
        assert drive.state == "unknown" and not rig.x.moving
        drive.clear()
        drive.run("100 ms")
        assert drive.state == "ok" and rig.rewind.stop is None and not rig.line.twin.steps
        rig.bench["h"].send("A 0\rN 40\rG\r")
        drive.run("800 ms")
        assert rig.x.position == 40 == rig.line.twin.position


def test_an_emergency_stop_does_not_belong_to_the_chip(tmp_path):
    rig = Driven(tmp_path, "cy545 limit", Random(4), wiring={"A0": "cw_limit", "A5": "estop"})
    rig.line.twin.inputs = 0b000001  # the contact of the emergency stop is closed to ground
    with rig.drive as drive:
        drive.run("500 ms")
        rig.edge(1, 5)
        drive.run("500 ms")
        assert drive.state == "halted" and not rig.exchanged
        assert any(each.startswith("e-stop") for each in drive.troubles)


@pytest.mark.parametrize("held_ms", [3, 150, 3000])
def test_while_an_input_stops_the_motor_its_host_receives_its_position(tmp_path, held_ms):
    rig = Driven(tmp_path, "gs-c200s hold", Random(held_ms))
    drive, line = rig.drive, rig.line

    def say(text):
        heard = len(rig.bench["h"].received)
        rig.bench["h"].send(text + "\r")
        drive.run("30 ms")
        return bytes(rig.bench["h"].received[heard:])

    with drive:
        drive.run("350 ms")
        rig.edge(0)
        stood = line.twin.position
        drive.run(f"{held_ms} ms")
        if held_ms > 100:
            assert line.twin.position == stood == rig.x.travel and 0 < stood < 900
            assert say("F") == b"B\r" and say("V1") == b"B\r"
            assert rig.x.position == stood
        rig.edge(1)
        drive.run("1900 ms")
        assert drive.state == "ok" and not drive.troubles and 1 <= rig.exchanged <= 2
        assert line.twin.position == rig.x.travel == len(line.twin.steps) == 900
        assert say("F") == b"R\r" and say("V1") == b"V+900\r"
    assert slewline.replay(tmp_path / "journal")["x"].travel == 900


def test_a_motor_is_paused_repeatedly_and_takes_all_its_steps(tmp_path, monkeypatch):
    rnd = Random(7)
    part, options, text, *rest = CASES["cy525 hold"]
    monkeypatch.setitem(CASES, "cy525 hold", (part, options, text.replace("N 1200", "N 6000"), *rest))
    rig = Driven(tmp_path, "cy525 hold", rnd)
    with rig.drive as drive:
        drive.run("200 ms")
        while rig.x.moving and rig.exchanged < 12:
            rig.edge(1)
            drive.run(f"{rnd.randrange(1, 400)} ms")
            rig.edge(0)
            drive.run(f"{rnd.randrange(1, 200)} ms")
        drive.run("4 s")
        assert rig.exchanged >= 4 and drive.state == "ok"
        assert all("taken-over" in each for each in drive.troubles), drive.troubles
        assert rig.line.twin.position == len(rig.line.twin.steps)
        assert abs(rig.x.travel - 6000) <= len(drive.troubles) and not rig.x.moving


def test_a_mark_is_seen_at_the_position_of_the_motor_and_the_motor_continues(tmp_path, monkeypatch):
    for number, more in enumerate(("", "\nSET_AUTO_UPDATE_ON\nSTOP\nSET_EXT_BRK")):
        (folder := tmp_path / str(number)).mkdir()
        part, options, text, *rest = CASES["mc1451a mark"]
        monkeypatch.setitem(CASES, "marked", (part, options, text % more, *rest))
        rig = Driven(folder, "marked", Random(6))
        with rig.drive as drive:
            drive.run("500 ms")
            rig.edge(0)
            at = drive._path.ticks.ps(rig.line.twin.now - drive._state.horizon)
            drive.run("60 ms")
            events = rig.x.registers.get("status")
            if not more:
                assert rig.exchanged == 1 and not drive.troubles
                assert rig.rewind.commanded in rig.x.on_command.listeners  # of the new bench
                entries = [entry for _, entry in rig.rewind.past.entries()]
                (edge,) = [entry for entry in entries if entry["do"] == "drive" and entry["t"] > MS]
                assert edge["pin"] == "x.home1" and abs(edge["t"] - at) < MS
                drive.run("1 s")
                check_steps(drive, rig.line)
                assert len(rig.line.twin.steps) == rig.x.travel == 9000
            else:  # the chip would have stopped, and the board did not know that
                assert not rig.exchanged and drive.troubles[0].startswith("late-input: home1 changed at"), events
                drive.run("1 s")
                assert len(rig.line.twin.steps) == rig.x.travel < 9000


def test_inputs_that_are_wired_wrongly_are_refused():
    x = slewline.Bench().add("cy525", "x")
    for wiring, says in (
        ({"A6": "abort"}, "allowed A0, A1, "),
        ({"A0": "abrot"}, "did you mean abort"),
        ({"A0": "pulse"}, "pulse is an output of x"),
        ({"A0": "abort", "A1": "!abort"}, "another input already"),
    ):
        with pytest.raises(UsageError, match=says):
            inputs_of(UNO, x, wiring)
    inputs = inputs_of(UNO, x, {"A1": "!abort", "A0": "step_inhibit", "A5": "estop", "A2": "wait"})
    config = configured(BoardConfig(1000), inputs)
    assert config.reflex == (Reflex.STOP, Reflex.BRAKE, 0, 0, 0, Reflex.ESTOP)
    assert config.active & 0b100011 == 0b100011 and config.report == 0b100111
    g = inputs_of(UNO, slewline.Bench().add("gs-c200s", "x"), {"A0": "eot", "A1": "home"})
    assert configured(BoardConfig(1000), g).reflex[:2] == (0, 0)
    assert configured(BoardConfig(1000), g, Homing(-1)).reflex[:2] == (Reflex.STOP | 32, Reflex.STOP | 16)
