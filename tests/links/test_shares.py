"""One who floods a port has a share of each turn of the loop, and no more; the others have theirs."""

from __future__ import annotations

import json
from itertools import pairwise
from time import monotonic

import pytest

import slewline
from slewline.links.lines.framing import SHARE as FRAMING
from slewline.links.lines.pace import Lockstep
from slewline.links.ports.prologix import SHARE as PROLOGIX
from slewline.links.ports.register_port import SHARE as REGISTERS
from slewline.links.ports.rfc2217 import SHARE as SETTINGS
from slewline.links.server import Server
from slewline.links.sockets.loop import Loop

from .conftest import PATIENCE, STRAPS, Client

RATE = b"\xff\xfa\x2c\x01\x00\x00\x25\x80\xff\xf0"  # 9600 baud, as RFC 2217 says it


class Turns:
    """A server whose turns are made here."""

    def __init__(self):
        self.bench = slewline.Bench()
        self.server = Server(self.bench, Lockstep(self.bench))
        self.clients = []

    def port(self, part, kind="tcp", straps=None, **more):
        line = self.server.line(self.bench.add(part, straps=straps or {}), **more)
        port = getattr(self.server, kind)(line, "127.0.0.1:0")
        self.server.pace.start()
        return line, port

    def client(self, port, data):
        self.clients.append(Client(port.where))
        self.clients[-1].send(data)
        return self.clients[-1]

    def turn(self):
        self.server.pace.pass_time()
        self.server.loop.serve(self.server.loop.sleep(0))

    def close(self):
        self.server.close()
        for client in self.clients:
            client.close()


@pytest.fixture
def turns():
    one = Turns()
    yield one
    one.close()


@pytest.mark.parametrize(
    ("part", "more", "request_", "share"),
    [
        ("mc1451a", {}, b"\x04\x00", REGISTERS),
        ("cy545", {"over": "parallel"}, b"\x04\x00", REGISTERS),
        ("cy525", {"framing": True}, b"?\r", FRAMING),
        ("cy525", {"prologix": True}, b"++srq\n", PROLOGIX),
    ],
)
def test_a_flood_of_a_line_has_its_share_of_a_turn(turns, part, more, request_, share):
    line, port = turns.port(part, **more)
    flood = request_ * 1000
    turns.client(port, flood)
    taken, end = [0], monotonic() + PATIENCE
    while taken[-1] < len(flood):
        turns.turn()
        taken.append(line.taken)
        assert monotonic() < end
    assert max(after - before for before, after in pairwise(taken)) == share


def test_a_flood_of_settings_has_its_share_of_a_turn(turns):
    _, port = turns.port("gs-c200s", "rfc2217", STRAPS)
    turns.client(port, RATE * 100)
    while port.session is None:
        turns.turn()
    receive, pieces = port.session.receive, []
    port.session.receive = lambda data: (pieces.append(len(data)), receive(data))
    while sum(pieces) < 100 * len(RATE):
        before = len(pieces)
        turns.turn()
        assert len(pieces) - before <= 1
    assert max(pieces) == SETTINGS


def test_a_flood_of_the_control_port_has_its_share_of_a_turn_and_every_answer(turns, monkeypatch):
    """Here a share is over as soon as it has begun."""
    monkeypatch.setattr("slewline.links.control.control.SHARE_S", 0.0)
    answered = []
    monkeypatch.setattr(
        "slewline.links.control.control.Requests.do_read", lambda _, request: answered.append(request) or {}
    )
    control = turns.server.control("127.0.0.1:0")
    requests = [{"do": "read", "pins": [], "id": number} for number in range(50)]
    client = turns.client(control, b"".join(json.dumps(one).encode() + b"\n" for one in requests))
    while len(answered) < len(requests):
        before = len(answered)
        turns.turn()
        assert len(answered) - before <= 1
    turns.turn()
    assert [json.loads(client.read(b"\n"))["id"] for _ in requests] == list(range(50))


def test_a_task_that_requests_another_call_gets_it_in_the_next_turn():
    loop, calls = Loop(), []

    def again():
        calls.append(1)
        loop.ask(again)

    loop.ask(again)
    for turn in range(1, 6):
        loop.serve(loop.sleep(0))
        assert len(calls) == turn
    loop.close()
