"""The cable: what goes out while something is under way comes out a horizon later, in order."""

from __future__ import annotations

import pytest

from slewline.drive.cable import Cable


class Line:
    """A cable of 100 ticks, and what has left it."""

    def __init__(self):
        self.now, self.moves, self.left = 0, False, []
        self.cable = Cable(100, lambda: self.now, lambda: self.moves)

    def send(self, what, at):
        self.now = at
        self.cable.send(lambda: self.left.append(what))


@pytest.fixture
def line():
    return Line()


def test_at_rest_a_call_leaves_immediately(line):
    line.send("a", 5)
    assert line.left == ["a"] and not line.cable.in_progress and line.cable.due() is None


def test_while_the_motor_moves_a_call_leaves_a_horizon_later(line):
    line.moves = True
    line.send("a", 5)
    line.send("b", 6)
    line.cable.turn(104)
    assert not line.left and line.cable.due() == 105
    line.cable.turn(105)
    assert line.left == ["a"]
    line.cable.turn(200)
    assert line.left == ["a", "b"]


def test_messages_sent_at_rest_wait_for_those_in_flight(line):
    line.moves = True
    line.send("a", 5)
    line.moves = False
    line.send("b", 50)
    assert not line.left and line.cable.in_progress
    line.cable.turn(149)
    assert line.left == ["a"] and line.cable.in_progress
    line.cable.turn(150)
    assert line.left == ["a", "b"] and not line.cable.in_progress
    line.send("c", 150)
    assert line.left == ["a", "b", "c"]


def test_messages_sent_by_a_call_follow_it(line):
    line.moves = True
    line.now = 10
    line.cable.send(lambda: (line.left.append("a"), line.send("b", 110)))
    line.cable.turn(110)
    assert line.left == ["a"] and line.cable.due() == 210


def test_a_call_with_an_instant_of_its_own_takes_its_place(line):
    line.moves = True
    line.send("a", 5)
    line.send("c", 30)
    line.cable.send_at(120, lambda: line.left.append("b"))
    line.cable.send_at(90, lambda: line.left.append("first"))
    line.cable.turn(200)
    assert line.left == ["first", "a", "b", "c"]


def test_calls_can_be_withdrawn_and_made_now(line):
    line.moves = True
    for name, at in (("a", 5), ("b", 6), ("c", 7)):
        line.send(name, at)
    assert line.cable.withdraw(106) == 1
    line.cable.turn(105)
    assert line.left == ["a"]
    line.cable.flush()
    assert line.left == ["a", "b"] and not len(line.cable)
