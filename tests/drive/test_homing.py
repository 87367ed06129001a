"""A board that was reset has lost its count; a homing of the chip finds the motor again, and all agree from then on."""

from __future__ import annotations

from random import Random

import pytest

import slewline
from tests.ensembles import few

from .rig import Pulses
from .test_rewind import CASES, Driven

END, HOME = 600, 40  # the switches are closed from there on, upwards and downwards


class Machine(Driven):
    """A chip whose motor has switches at two inputs of the board, which are closed by where the motor is.

    Args:
        closed: whether each of the two is closed with the motor at a place.
    """

    def __init__(self, folder, name, seed, wiring, closed):
        super().__init__(folder, name, Random(seed), wiring=wiring)
        self.before = 0  # where the motor was when the board began to count
        self.pulses = Pulses()
        passed = self.line.pass_to

        def pass_to(ns):
            passed(ns)
            for number, is_closed in enumerate(closed(self.place)):
                if self.line.twin.inputs >> number & 1 == is_closed:
                    self.edge(1 - is_closed, number)

        self.line.pass_to = pass_to

    @property
    def place(self):
        """Where the motor is, by all pulses that it has ever got."""
        return self.before + self.pulses(self.line.twin)

    def reset_board(self, by_hand):
        """Take its supply in motion, with all that it has counted, and give it back; the motor is pushed meanwhile."""
        self.line.supplied = False
        self.drive.run("100 ms")
        self.before = self.place if by_hand is None else by_hand
        self.line.reset_board()
        self.line.supplied = True

    def say(self, *lines):
        """Let the host send lines; return what it hears."""
        host = self.bench["h"]
        heard = len(host.received)
        host.send("".join(f"{line}\r" for line in lines))
        self.drive.run("300 ms")
        return bytes(host.received[heard:])


@pytest.mark.parametrize("by_hand", few([None, HOME - 10, END + 10], 1), ids=["as it stood", "at home", "at the end"])
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in (1, 2))])
def test_after_a_reset_of_the_board_a_homing_of_the_chip_finds_the_motor(tmp_path, seed, by_hand):
    rig = Machine(
        tmp_path,
        "gs-c200s homing",
        seed,
        {"A0": "eot", "A1": "home"},
        lambda place: (place >= END, place <= HOME),
    )
    drive = rig.drive
    with drive:
        rig.bench["h"].send("Po\rS50\rT100\rR90\r+500\rPx\rE\r")
        drive.run(f"{rig.line.rnd.randrange(350, 600)} ms")
        assert rig.x.moving and 0 < rig.place < END
        rig.reset_board(by_hand)
        drive.run("600 ms")
        assert drive.state == "unknown" and not rig.x.moving and not rig.line.twin.steps
        assert [each.partition(":")[0] for each in drive.troubles] == ["board-reset"]
        stood = rig.place

        drive.clear()
        drive.run("100 ms")
        assert drive.state == "ok" and rig.place == stood
        rig.say("Po", "S50", "T100", "R90", "E")
        assert rig.x.position != rig.place, "nobody knows that yet"
        rig.say("H+")
        assert rig.x.motor.homing == 1 and (rig.place < stood) == (stood >= END)
        drive.run("4000 ms")
        assert drive._live.rewind.rewinds == 2 - (stood >= END) and drive.state == "ok" and len(drive.troubles) == 1, (
            "\n".join(drive.troubles)
        )
        assert not rig.x.moving and rig.x.motor.homing == 0
        home, counted = rig.place, drive.count
        assert HOME - 3 <= home <= HOME and rig.x.position == 0  # the switch may be seen a step late
        assert rig.say("V1").endswith(b"V+0\r")

        assert rig.say("Po", "S50", "T100", "R90", "+250", "-40", "+7", "E").endswith(b"Y\r")
        drive.run("1500 ms")
        assert rig.x.position == 217 == rig.place - home == drive.count - counted
        assert rig.say("V1").endswith(b"V+217\r")
        assert rig.line.twin.position == drive.count == rig.x.travel + drive._state.count_origin
        assert len(drive.troubles) == 1, drive.troubles
    replayed = slewline.replay(tmp_path / "journal")["x"]
    assert (replayed.position, replayed.travel) == (217, rig.x.travel)


@pytest.mark.fact("CY545-HOME-4", "CY545-HOME-6")
@pytest.mark.parametrize(("argument", "match"), [(0, 1), (16, 0)], ids=["high", "low"])
@pytest.mark.parametrize("begins", [-200, 150], ids=["no match at first", "a match at first"])
@pytest.mark.parametrize("rate", [255, pytest.param(100, marks=pytest.mark.long)])
def test_a_user_bit_that_a_cy545_seeks_stops_the_motor_immediately(
    tmp_path, monkeypatch, argument, match, begins, rate
):
    monkeypatch.setitem(CASES, "cy545 seeks", ("cy545", {}, f"F {rate}\r", "", "usrb0", 1, (0, 0)))
    rig = Machine(tmp_path, "cy545 seeks", begins, {"A0": "usrb0"}, lambda place: [(place >= 0) != bool(match)])
    rig.before = begins
    drive = rig.drive
    with drive:
        drive.run("50 ms")
        rig.bench["h"].send(f"H {argument}\r")
        drive.run("200 ms")
        assert rig.x.motor.homing == (-1 if begins > 0 else 1)
        drive.run(f"{1500 if rate == 255 else 5000} ms")
        assert drive.state == "ok" and not drive.troubles, drive.troubles
        assert rig.exchanged == 1 + (begins > 0)
        assert not rig.x.moving and rig.x.motor.homing == 0 and rig.x.motor.sought is None
        assert rig.x.position == 0 == rig.place, "it stands at the first step where they match"
        rig.bench["h"].send("+\rN 60\rG\r")
        drive.run("1500 ms")
        assert rig.x.position == 60 == rig.place
        assert rig.line.twin.position == rig.x.travel
