"""Views and what is said, as clients get them: the changes make the whole, and nothing is lost or comes twice."""

from __future__ import annotations

import json
import random
from time import monotonic

import pytest

import slewline
from slewline.links.clients.control_client import merged
from slewline.links.control import control
from slewline.links.lines.pace import Lockstep, Paced
from slewline.links.server import Server
from slewline.links.views.dialogue_view import Dialogue
from tests.ensembles import few

from .conftest import PATIENCE, Asks, Threaded


def without_nothing(view):
    """A view without what is no longer there, which a change tells as None."""
    if isinstance(view, dict):
        return {key: without_nothing(value) for key, value in view.items() if value is not None}
    return [without_nothing(value) for value in view] if isinstance(view, list) else view


class Watching:
    """A client that has subscribed."""

    def __init__(self, ask):
        self.ask, self.number = ask, 0
        self.view = ask("subscribe", every="5 ms")["view"]
        self.said = {}

    def __call__(self, do, **more):
        """Send a request; take in the events up to its reply."""
        self.number += 1
        self.ask.client.send(json.dumps({"do": do, "id": self.number} | more).encode() + b"\n")
        while (found := self.ask.answer()).get("id") != self.number:
            self.take(found)
        return found

    def take(self, event):
        if event["event"] == "view":
            self.view = merged(self.view, event["view"])
        elif event["event"] == "said":
            for entry in event["entries"]:
                old = self.said.get(entry["number"])
                assert old is None or (entry["text"].startswith(old["text"]) and entry != old)
                self.said[entry["number"]] = entry


@pytest.fixture
def stand(client):
    """A CY545 with a display, wheels and a jog switch, and a module, on lines."""
    bench = slewline.Bench()
    x, y = (
        bench.add("cy545b", name="x"),
        bench.add("gs-c200s", name="y", straps={"chs": 0, "br0": 0, "br1": 0, "br2": 0}),
    )
    bench.part("jog_switch", name="jog", to=x)
    bench.part("hp_display", name="display", to=x)
    server = Server(bench, Lockstep(bench))
    ports = [server.tcp(server.line(x, over="serial"), "127.0.0.1:0"), server.tcp(server.line(y), "127.0.0.1:0")]
    control = server.control("127.0.0.1:0")
    with Threaded(server):
        yield [client(port.where) for port in ports], lambda: Asks(client(control.where))


LINES = (
    (b"\r\r", b"O 95H\r", b"N 30\r", b"R 200\r", b"+\r", b"G\r", b"? P\r", b"HEL", b"LO\r"),
    (b"V1\r", b"Po\r", b"S50\r", b"+30\r", b"Px\r", b"E\r", b"F\r", b"HE", b"LLO\r", b"Z\r"),
)


@pytest.mark.parametrize("seed", few(range(3), 1))
def test_the_changes_make_the_view_at_every_stop(stand, seed):
    hosts, another = stand
    chance = random.Random(seed)
    watching, plain = Watching(another()), another()
    for _ in range(60):
        kind = chance.random()
        if kind < 0.6:
            number = chance.randrange(2)
            hosts[number].send(chance.choice(LINES[number]))
        elif kind < 0.8:
            pin = chance.choice(("x.cw_limit", "y.ui1", "y.enable"))
            plain("drive", pin=pin, level=chance.randrange(2)) if chance.random() < 0.6 else plain("release", pin=pin)
        elif kind < 0.9:
            plain("act", part="jog", verb=chance.choice(("cw", "ccw", "off")))
        plain("advance", time=chance.randrange(1, 10**11))
        if chance.random() < 0.3:
            settled(watching, plain)
    settled(watching, plain)
    entries = plain("said")["entries"]
    assert [watching.said[number] for number in sorted(watching.said)] == entries
    assert len(entries) > 20


def settled(watching, plain):
    """Wait until a client has been told everything."""
    end = monotonic() + PATIENCE
    while monotonic() < end:
        watching("read", pins=[])
        view, entries = plain("view")["view"], plain("said")["entries"]
        said = [watching.said[number] for number in sorted(watching.said)]
        if without_nothing(watching.view) == without_nothing(view) and said == entries:
            return
    assert without_nothing(watching.view) == without_nothing(view)
    assert said == entries


@pytest.mark.parametrize("clients", few([12, 50], 1))
def test_many_clients_receive_the_same(stand, clients):
    hosts, another = stand
    plain, many = another(), [Watching(another()) for _ in range(clients)]
    hosts[1].send(b"V1\r")
    plain("advance", time="100 ms")
    for watching in many:
        settled(watching, plain)
        watching("subscribe", every=0)
    hosts[1].send(b"F\r")
    plain("advance", time="100 ms")
    for watching in many[:5]:
        before = dict(watching.said)
        watching("read", pins=[])
        assert watching.said == before


def test_an_entry_that_grows_after_many_others_is_reported():
    bench = slewline.Bench()
    dialogue = Dialogue(bench, {})
    dialogue._grow("a", "sent", ord("A"))
    for _ in range(200):
        dialogue.add("b", "got", "x")
    touched, number = dialogue.touched, dialogue.number
    assert [*dialogue.changed(touched, number)] == []
    dialogue._grow("a", "sent", ord("\r"))
    dialogue._grow("a", "sent", ord("B"))
    found = [(entry["number"], entry["text"]) for entry in dialogue.changed(touched, number)]
    assert found == [(201, "B"), (0, "A\\r")]
    assert [*dialogue.changed(dialogue.touched, dialogue.number)] == []


def test_no_view_after_a_stop_is_older_than_it(client, monkeypatch):
    """A view is compared in several turns of the loop, and time may pause between two of them.

    What has been found by then is sent before the stop; the rest is compared again, together with the pause.
    """
    monkeypatch.setattr(control, "GATHER_S", -1.0)  # one piece of the view in each turn
    bench = slewline.Bench()
    bench.add("cy525", name="x")
    server = Server(bench, Paced(bench))
    port = server.control("127.0.0.1:0")
    with Threaded(server) as threaded:
        ask = Asks(client(port.where))
        threaded.do(server.pace.pause_time)
        assert ask("subscribe", every="1000 s")["view"]["pace"]["paused"]

        def stop():
            (one,) = port.clients
            server.pace.go()
            one.notify(one.watching)
            bench.chips["x"].pin("abort").drive(0)
            server.pace.pause_time()
            server.breakpoints.stopped("a breakpoint")

        threaded.do(stop)
        older, stopped = ask.answer(), ask.answer()
        assert older["event"] == "view" and older["view"]["pace"]["paused"] is False
        assert (stopped["event"], stopped["why"]) == ("stopped", "a breakpoint")
        threaded.do(lambda: [one.notify(one.watching) for one in port.clients])
        later = ask.answer()
        assert later["event"] == "view" and later["view"]["chips"]["x"]["levels"]["abort"] == 0
        assert later["view"]["pace"]["paused"] is True


@pytest.mark.parametrize("event", ["stopped", "branch"])
def test_no_dialogue_before_a_stop_or_a_branch_is_lost(client, event):
    """The dialogue is checked at intervals; a stop or a switch to a branch between two of them sends it first."""
    bench = slewline.Bench()
    bench.add("cy525", name="x")
    server = Server(bench, Paced(bench))
    port = server.control("127.0.0.1:0")
    with Threaded(server) as threaded:
        ask = Asks(client(port.where))
        ask("subscribe", every="1000 s")

        def leave():
            bench.chips["x"].finding("parity", "one bit is wrong")
            if event == "stopped":
                server.breakpoints.stopped("a breakpoint")
            for one in port.clients:
                one.divert("", {"event": "branch", "branch": 0})

        threaded.do(leave)
        said, later = ask.answer(), ask.answer()
        assert said["event"] == "said" and [entry["kind"] for entry in said["entries"]] == ["finding"]
        assert later["event"] == event
