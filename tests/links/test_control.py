"""The control port, as a program in any language uses it."""

from __future__ import annotations

import json
import random
import re
import socket

import pytest

from slewline.links import control
from slewline.links.control import KEYS

from .conftest import Asks, Threaded

PROGRAM = ("Po", "S50", "T200", "R20", "+400", "E")


@pytest.fixture
def stand(lockstep, client):
    """A module on a TCP port: the running server, a host, and a client of the control port."""
    server, line = lockstep()
    port, control = server.tcp(line, "127.0.0.1:0"), server.control("127.0.0.1:0")
    with Threaded(server) as running:
        yield running, client(port.where), Asks(client(control.where))


def test_every_request_is_documented_with_an_example_that_is_understood():
    examples = [
        control.read(found.encode()) for found in re.findall(r'^    (\{"do".*?\})  ', control.__doc__ + "  ", re.M)
    ]
    assert {example["do"] for example in examples} == set(KEYS)
    assert '{"do": "fault", "line": "x", "to": "chip", "kind": "parity", "count": 3' in control.__doc__


def test_pins_are_driven_released_pulsed_and_read(stand):
    _, _, ask = stand
    assert ask("read", pins=["x.ui1", "x.mov", "x.rdy"])["levels"] == {"x.ui1": 1, "x.mov": 0, "x.rdy": 1}
    assert set(ask("drive", pin="x.ui1", level=0)) == {"time_ps"}
    assert ask("read", pins=["x.ui1"])["levels"] == {"x.ui1": 0}
    ask("release", pin="x.ui1")
    assert ask("read", pins=["x.ui1"])["levels"] == {"x.ui1": 1}
    ask("pulse", pin="x.ui1", level=0, width="20 us")
    assert ask("read", pins=["x.ui1"])["levels"] == {"x.ui1": 0}
    ask("advance", time="19999 ns")
    assert ask("read", pins=["x.ui1"])["levels"] == {"x.ui1": 0}
    ask("advance", time="1 ns")
    assert ask("read", pins=["x.ui1"])["levels"] == {"x.ui1": 1}


def test_time_advances_as_far_as_it_is_told(stand):
    _, _, ask = stand
    before = ask("status")["time_ps"]
    assert ask("advance", time="250 ms")["time_ps"] == before + 250 * 10**9
    assert ask("advance", time="1 ps")["time_ps"] == before + 250 * 10**9 + 1


def test_a_program_runs_as_far_as_time_does(stand):
    running, host, ask = stand
    for line in PROGRAM:
        assert host.ask(line.encode() + b"\r") == b"Y\r"
    assert ask("until", chip="x", position=123) | {"time_ps": 0} == {"met": True, "time_ps": 0}
    assert running.do(lambda: running.bench["x"].position) == 123
    assert ask("until", pin="x.rdy", level=1, timeout="5 s")["met"]
    found = ask("status")["chips"]["x"]
    assert (found["position"], found["steps"], found["idle"], found["moving"]) == (400, 400, True, False)
    steps = ask("steps", chip="x")
    assert steps["positions"] == list(range(1, 401))
    assert steps["directions"] == [1] * 400
    assert steps["times_ps"] == sorted(set(steps["times_ps"]))
    window = ask("steps", chip="x", start=steps["times_ps"][10], stop=steps["times_ps"][19])
    assert window["positions"] == list(range(11, 21))


def test_what_does_not_come_about_is_told_at_the_time_limit(stand):
    _, _, ask = stand
    before = ask("status")["time_ps"]
    assert ask("until", pin="x.mov", level=1, timeout="3 s") == {"met": False, "time_ps": before + 3 * 10**12}


def test_requests_that_come_while_one_waits_are_answered_in_order(stand):
    _, _, ask = stand
    lines = [
        {"do": "advance", "time": "1 s", "id": 1},
        {"do": "status", "id": 2},
        {"do": "advance", "time": "1 s", "id": 3},
    ]
    ask.client.send("".join(json.dumps(line) + "\n" for line in lines).encode())
    answers = [ask.answer() for _ in lines]
    assert [answer["id"] for answer in answers] == [1, 2, 3]
    assert answers[2]["time_ps"] == answers[0]["time_ps"] + 10**12


def test_a_client_that_says_no_more_gets_every_reply(stand):
    _, _, ask = stand
    lines = [{"do": "advance", "time": "1 s"}, {"do": "until", "pin": "x.mov", "level": 1, "timeout": "1 s"}]
    lines += [{"do": "status"}] * 3  # the last one without a line feed
    ask.client.send("\n\n".join(json.dumps(line) for line in lines).encode())
    ask.client.socket.shutdown(socket.SHUT_WR)
    replies = [json.loads(line) for line in ask.client.read(end=b"").splitlines()]
    assert [sorted(set(reply) & {"met", "pace"}) for reply in replies] == [[], ["met"], ["pace"], ["pace"], ["pace"]]


def test_clients_do_not_disturb_each_other(stand, client):
    running, _, ask = stand
    port = running.server.ports[1].where
    other = Asks(client(port))
    ask.client.send(b'{"do": "st')
    assert "chips" in other("status")
    ask.client.send(b'atus"}\n')
    assert "chips" in ask.answer()
    other.client.close()
    assert "chips" in ask("status")


def test_a_module_without_power_says_nothing(stand):
    _, host, ask = stand
    ask("power", chip="x", on=False)
    host.send(b"F\r")
    ask("advance", time="100 ms")
    ask("power", chip="x", on=True)
    ask("advance", time="1 ms")
    assert host.ask(b"V1\r") == b"V+0\r"


@pytest.mark.parametrize(
    ("to", "kind", "answer"),
    [("chip", "parity", b"E1\r"), ("chip", "framing", b"E1\r"), ("host", "parity", b"\0\r"), ("host", "lost", b"\r")],
)
def test_faults_hit_the_next_characters(stand, to, kind, answer):
    _, host, ask = stand
    ask("fault", line="x", to=to, kind=kind)
    assert host.ask(b"F\r") == answer
    assert host.ask(b"F\r") == b"R\r"
    assert ask("clear", line="x")["hits"][to][kind] == 1


def test_faults_by_chance_go_on_until_they_are_cleared(stand):
    _, host, ask = stand
    ask("fault", line="x", to="chip", kind="parity", count=1000, chance=0.5, seed=3)
    answers = [host.ask(b"F\r") for _ in range(40)]
    assert {b"E1\r", b"R\r"} == set(answers)
    ask("clear", line="x")
    assert {host.ask(b"F\r") for _ in range(20)} == {b"R\r"}


def test_what_is_garbled_is_never_the_bit_to_which_a_checksum_is_blind(stand):
    running, _, ask = stand
    ask("fault", line="x", to="chip", kind="garbled", count=400, seed=4)
    ask("fault", line="x", to="host", kind="garbled", count=400, seed=4)
    line = running.server.lines["x"]
    for noise in (line.to_chip, line.to_host):
        assert {byte ^ noise.hit(byte)[0] for byte in range(128) for _ in range(3)} == {1, 2, 4, 8, 32, 64}


def test_the_eeprom_fails_until_it_is_cleared(stand):
    _, host, ask = stand
    assert set(ask("fault", chip="x", kind="eeprom")) == {"time_ps"}
    assert [host.ask(line) for line in (b"M\r", b"X\r")] == [b"E6\r", b"E6\r"]
    ask("clear", chip="x")
    assert host.ask(b"X\r") == b"E6\r"
    assert [host.ask(line) for line in (b"M\r", b"X\r")] == [b"Y\r", b"Y\r"]


def test_the_status_says_what_has_passed(stand):
    _, host, ask = stand
    host.ask(b"F\r")
    found = ask("status")
    line = found["lines"]["x"]
    assert (line["taken"], line["given"], line["dropped"]) == (2, 2, 0)
    assert (line["baud"], line["format"], line["chips"]) == (9600, "7O2", ["x"])
    assert line["host"] == "{}:{}".format(*host.socket.getsockname())
    assert found["pace"] == {"lockstep": True}
    assert found["chips"]["x"]["part"] == "gs-c200s"


@pytest.mark.parametrize(
    ("request_", "says"),
    [
        ("nonsense", "not JSON"),
        ("[" * 60_000, "not JSON"),  # deeper than Python goes
        ("[1]", "allowed drive, release"),
        ('{"do": "dance"}', "do 'dance'; allowed drive, release"),
        ('{"do": []}', "allowed drive, release"),
        ('{"do": "drive", "pin": "x.ui1"}', "level is missing"),
        ('{"do": "drive", "pin": "x.ui1", "level": 2}', "allowed 0, 1"),
        ('{"do": "drive", "pin": 7, "level": 1}', "expected text"),
        ('{"do": "drive", "pin": "ui1", "level": 1}', "give owner and pin"),
        ('{"do": "drive", "pin": "x.ui9", "level": 1}', "has no pin 'ui9'"),
        ('{"do": "drive", "pin": "x.ui1", "level": 1, "at": 3}', "at is unknown; allowed pin, level"),
        ('{"do": "read", "pins": "x.ui1"}', "expected a list"),
        ('{"do": "read", "pins": [7]}', "expected a list"),
        ('{"do": "advance", "time": 0.5}', "a float would be rounded"),
        ('{"do": "advance", "time": "-1 s"}', "does not run backwards"),
        ('{"do": "until", "pin": "x.ui1"}', "give pin and level, or chip and position"),
        ('{"do": "until", "pin": "x.ui1", "level": 1, "chip": "x", "position": 1}', "give pin and level, or"),
        ('{"do": "until", "chip": "x", "position": "far"}', "expected a whole number"),
        ('{"do": "fault", "line": "y", "to": "chip", "kind": "lost"}', "no serial line 'y'; there are: x"),
        ('{"do": "fault", "line": "x", "to": "me", "kind": "lost"}', "allowed chip, host"),
        ('{"do": "fault", "line": "x", "to": "chip", "kind": "loud"}', "allowed lost, garbled"),
        ('{"do": "fault", "line": "x", "to": "chip", "kind": "lost", "count": 0}', "allowed 1 and more"),
        ('{"do": "fault", "line": "x", "kind": "lost"}', "needs line, to and kind, or chip and the kind eeprom"),
        ('{"do": "fault", "line": "x", "to": "chip", "kind": "eeprom"}', "allowed lost, garbled"),
        ('{"do": "fault", "chip": "x", "kind": "lost"}', "a chip has the kind eeprom alone"),
        ('{"do": "fault", "chip": "x", "kind": "eeprom", "count": 2}', "a chip has the kind eeprom alone"),
        ('{"do": "fault", "chip": "y", "kind": "eeprom"}', "no chip 'y'; there are: x"),
        ('{"do": "clear"}', "clear: needs line or chip"),
        ('{"do": "fault", "line": "x", "to": "chip", "kind": "lost", "seed": {}}', "seed"),
        ('{"do": "power", "chip": "y", "on": true}', "no chip 'y'; there are: x"),
        ('{"do": "power", "chip": "x", "on": 1}', "allowed true, false"),
        ('{"do": "steps", "chip": "x", "start": "soon"}', "expected a number and a unit"),
    ],
)
def test_what_is_wrong_is_told_and_the_server_goes_on(stand, request_, says):
    _, host, ask = stand
    ask.client.send(request_.encode() + b"\n")
    assert says in ask.answer()["error"]
    assert host.ask(b"F\r") == b"R\r"


def test_a_request_without_end_costs_no_memory(stand):
    running, host, ask = stand
    ask.client.send(b"x" * (3 * control.LONGEST))
    assert host.ask(b"F\r") == b"R\r"
    assert running.do(lambda: len(running.server.ports[1].clients[0].incoming)) <= control.LONGEST
    ask.client.send(b"\n")
    assert "more than" in ask.answer()["error"]
    assert "chips" in ask("status")
    assert host.ask(b"F\r") == b"R\r"


def test_random_bytes_with_parity_faults(stand):
    """Whatever comes, the protocol still answers, and what was done is told."""
    running, host, ask = stand
    chance = random.Random(11)
    ask("fault", line="x", to="chip", kind="parity", count=10**6, chance=0.01, seed=5)
    total = 20_000
    for _ in range(total // 1000):
        host.send(chance.randbytes(1000))
        host.send(b"")
    running.until(lambda: running.server.lines["x"].taken == total and running.server.lines["x"].quiet())
    hits = ask("clear", line="x")["hits"]["chip"]["parity"]
    assert 100 < hits < 300
    found = ask("status")
    assert found["findings"] > 50
    assert len(running.bench["x"].findings) <= 2000
    host.send(b"\r")
    ask("advance", time="10 s")
    host.send(b"K\r")
    ask("advance", time="10 s")
    while host.socket.recv(1) != b"\r":
        pass
    host.send(b"F\r")
    assert host.read(b"R\r").endswith(b"R\r")


def test_quit_ends_the_server(stand):
    running, _, ask = stand
    assert set(ask("quit")) == {"time_ps"}
    running.thread.join(30)
    assert not running.thread.is_alive()
