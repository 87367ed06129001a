"""What each verb does.  A verb without an entry in `DOES`, or with one that an empty verb passes too, is refused."""

from __future__ import annotations

import json
import os

import pytest

from slewline.links.control.control import Requests
from slewline.links.control.requests import REQUESTS, schema

from .conftest import STRAPS, Asks, Threaded

PROGRAM = ("Po", "S50", "T200", "R20", "+400", "E")
DOES = {}


def does(name):
    """Enter a test of what a verb does, by the name of its row: `until_pin`."""

    def enter(test):
        DOES[name] = test
        return test

    return enter


class Stand:
    """A module on a TCP port, in lockstep, with a host and a client of the control port."""

    def __init__(self, running, host, ask):
        self.running, self.host, self.ask = running, host, ask

    def level(self, pin):
        return self.running.do(lambda: self.running.bench.pin(pin).level)

    def program(self):
        for line in PROGRAM:
            assert self.host.ask(line.encode() + b"\r") == b"Y\r"

    def run(self):
        self.program()
        assert self.ask("advance", time="20 s")


@pytest.fixture
def stand(lockstep, client):
    server, line = lockstep()
    server.bench.part("jog_switch", name="jog")
    server.bench.record("x.mov")
    port, control = server.tcp(line, "127.0.0.1:0"), server.control("127.0.0.1:0")
    with Threaded(server) as running:
        yield Stand(running, client(port.where), Asks(client(control.where)))


@does("drive")
def _(at):
    at.ask("drive", pin="x.ui1", level=0)
    assert at.level("x.ui1") == 0


@does("release")
def _(at):
    at.running.do(lambda: at.running.bench.pin("x.ui1").drive(0))
    at.ask("release", pin="x.ui1")
    assert at.level("x.ui1") == 1


@does("pulse")
def _(at):
    at.ask("pulse", pin="x.ui1", level=0, width="20 us")
    assert at.level("x.ui1") == 0
    at.ask("advance", time="20 us")
    assert at.level("x.ui1") == 1


@does("read")
def _(at):
    at.running.do(lambda: at.running.bench.pin("x.ui1").drive(0))
    assert at.ask("read", pins=["x.ui1", "x.ui2"])["levels"] == {"x.ui1": 0, "x.ui2": 1}


@does("advance")
def _(at):
    before = at.running.do(lambda: at.running.bench.now_ps)
    at.ask("advance", time="250 ms")
    assert at.running.do(lambda: at.running.bench.now_ps) == before + 250 * 10**9


@does("until_pin")
def _(at):
    at.program()
    assert at.ask("until", pin="x.mov", level=1)["met"]
    assert at.level("x.mov") == 1


@does("until_position")
def _(at):
    at.program()
    assert at.ask("until", chip="x", position=123)["met"]
    assert at.running.do(lambda: at.running.bench["x"].position) == 123


@does("until_instruction")
def _(at):
    at.program()
    assert at.ask("until", chip="x", address=12, timeout="1 s")["met"]
    assert at.running.do(lambda: at.running.bench["x"].program_counter) == 12


@does("until_time")
def _(at):
    to = at.running.do(lambda: at.running.bench.now_ps) + 10**12
    assert at.ask("until", time=to) == {"met": True, "time_ps": to}


@does("fault_line")
def _(at):
    at.ask("fault", line="x", to="chip", kind="parity")
    assert (at.host.ask(b"F\r"), at.host.ask(b"F\r")) == (b"E1\r", b"R\r")


@does("fault_chip")
def _(at):
    at.ask("fault", chip="x", kind="eeprom")
    assert at.host.ask(b"M\r") == b"E6\r"


@does("clear_line")
def _(at):
    at.ask("fault", line="x", to="chip", kind="parity", count=100)
    assert at.host.ask(b"F\r") == b"E1\r"
    assert at.ask("clear", line="x")["hits"]["chip"]["parity"] == 2
    assert at.host.ask(b"F\r") == b"R\r"


@does("clear_chip")
def _(at):
    at.ask("fault", chip="x", kind="eeprom")
    at.ask("clear", chip="x")
    assert at.host.ask(b"M\r") == b"Y\r"


@does("unplug")
def _(at):
    assert at.host.ask(b"F\r") == b"R\r"
    at.ask("unplug", line="x")
    assert len(at.running.server.ports) == 1  # the control port
    assert at.host.read() == b""  # the connection is closed


@does("plug")
def _(at):
    where = at.running.server.ports[0].where
    at.ask("unplug", line="x")
    assert at.running.do(lambda: [port.where for port in at.running.server.ports if port.where == where]) == []
    at.ask("plug", line="x")
    assert at.running.do(lambda: [port.where for port in at.running.server.ports if port.where == where]) == [where]


@does("power")
def _(at):
    at.ask("power", chip="x", on=False)
    assert at.running.do(lambda: at.running.bench["x"].powered) is False
    at.ask("power", chip="x", on=True)
    assert at.running.do(lambda: at.running.bench["x"].powered) is True


@does("status")
def _(at):
    at.host.ask(b"F\r")
    found = at.ask("status")
    assert (found["pace"], found["lines"]["x"]["taken"], found["chips"]["x"]["part"]) == (
        {"lockstep": True},
        2,
        "gs-c200s",
    )


@does("findings")
def _(at):
    at.host.ask(b"HELLO\r")
    assert at.ask("findings")["findings"][-1]["source"] == "x"


@does("steps")
def _(at):
    at.run()
    assert at.ask("steps", chip="x")["positions"] == [*range(1, 401)]


@does("schema")
def _(at):
    assert at.ask("schema")["schema"] == schema()


@does("quit")
def _(at):
    at.ask("quit")
    at.running.thread.join(1)
    assert not at.running.thread.is_alive()


@does("pause")
def _(at):
    at.ask("pause")
    assert at.running.do(lambda: at.running.server.pace.paused)


@does("go")
def _(at):
    at.running.do(at.running.server.breakpoints.stand)
    assert at.ask("go")["rate"] == 1
    assert not at.running.do(lambda: at.running.server.pace.paused)


@does("step_chip")
def _(at):
    at.program()
    assert at.ask("step", chip="x", by="step")["met"]
    assert at.running.do(lambda: at.running.server.pace.paused)


@does("step_pin")
def _(at):
    at.program()
    assert at.ask("step", pin="x.mov", edge="rises")["met"]
    assert at.level("x.mov") == 1


@does("breakpoints")
def _(at):
    at.program()
    at.ask("pause")
    assert at.ask("breakpoints", breakpoints=[{"chip": "x", "position": 7}])["breakpoints"] == ["x at position 7"]
    at.ask("advance", time="20 s")
    assert at.running.do(lambda: at.running.bench["x"].position) == 7


@does("describe")
def _(at):
    assert at.ask("describe", chip="x")["sheet"]["part"] == "gs-c200s"


@does("parts")
def _(at):
    assert at.ask("parts")["parts"]["jog"]["verbs"] == ["cw", "ccw", "off"]


@does("listing")
def _(at):
    at.program()
    assert [row["text"] for row in at.ask("listing", chip="x")["rows"]] == ["S50", "T200", "R20", "+400"]


@does("view")
def _(at):
    at.run()
    assert at.ask("view")["view"]["chips"]["x"]["axes"][0]["position"] == 400


@does("subscribe")
def _(at):
    assert "x" in at.ask("subscribe", every="5 ms")["view"]["chips"]
    at.running.do(lambda: at.running.bench.pin("x.ui1").drive(0))
    assert at.ask.answer()["event"] == "view"


@does("said")
def _(at):
    at.host.ask(b"F\r")
    assert [one["text"] for one in at.ask("said")["entries"][-2:]] == ["F\\r", "R\\r"]


@does("signals")
def _(at):
    found = at.ask("signals")
    assert "mov" in found["pins"]["x"] and "x.velocity" in found["quantities"]


@does("record")
def _(at):
    at.ask("record", pins=["x.ui1"])
    assert "x.ui1" in at.running.do(lambda: [*at.running.bench.recorded])


@does("window")
def _(at):
    at.run()
    seen = at.ask("window", signals=["x.mov"], columns=100)["signals"]["x.mov"]
    assert seen["levels"] == [0, 1, 0]


@does("find")
def _(at):
    at.run()
    rise = at.ask("find", on={"pin": "x.mov", "edge": "rises"})["found_ps"]
    assert at.ask("find", on={"pin": "x.mov", "level": 1})["found_ps"] == rise > 0


@does("export")
def _(at):
    at.run()
    text = at.ask("export", signals=["x.mov"], form="csv")["text"]
    assert text.splitlines()[0].split(",")[1:] == ["net", "level"] and text.count("x.mov") >= 2


@does("send")
def _(at):
    at.ask("send", chip="x", text="Po\nS50\nT200\nR20\n+5\nE")
    at.ask("advance", time="20 s")
    assert at.running.do(lambda: at.running.bench["x"].position) == 5


@does("act")
def _(at):
    at.ask("act", part="jog", verb="cw")
    assert at.running.do(at.running.bench["jog"].shows)["position"] == "cw"


@does("assemble")
def _(at):
    assert [row["text"] for row in at.ask("assemble", chip="x", text="Po\nS50\nA1\nE")["rows"]] == ["S50", "A1"]


@does("examples")
def _(at):
    assert "drilling_machine.py" in [one["name"] for one in at.ask("examples")["examples"]]


@does("example")
def _(at):
    assert at.ask("example", name="drilling_machine.py")["text"].startswith('"""')


@pytest.fixture
def past(serve, client, tmp_path):
    """A server of which the past is kept, in a process that can be copied: a client of its control port."""
    straps = [f"--strap={pin}={level}" for pin, level in STRAPS.items()]
    ports = ("--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0", "--journal", tmp_path / "journal")
    ask = Asks(client(serve("gs-c200s", *straps, *ports, ports=2).ports["control"]))
    ask("pause")
    ask("advance", time="100 ms")
    return ask


@does("back")
def _(past):
    assert past("back", time="50 ms")["branch"] == 1
    assert past("status")["time_ps"] == 50 * 10**9


@does("branch")
def _(past):
    past("back", time="50 ms")
    past("drive", pin="gs_c200s.ui1", level=0)
    assert past("branch", number=0)["branch"] == 0
    assert past("read", pins=["gs_c200s.ui1"])["levels"] == {"gs_c200s.ui1": 1}
    assert past("branch", number=1)["branch"] == 1
    assert past("read", pins=["gs_c200s.ui1"])["levels"] == {"gs_c200s.ui1": 0}


@does("branches")
def _(past):
    assert [one["number"] for one in past("branches")["branches"]] == [0]
    past("back", time="50 ms")
    found = past("branches")
    assert ([one["number"] for one in found["branches"]], found["current"]) == ([0, 1], 1)


OF_THE_PAST = ("back", "branch", "branches")
HERE = [name for name in DOES if name not in OF_THE_PAST]


def test_there_is_a_test_of_what_each_verb_does_in_each_of_its_forms():
    assert sorted(DOES) == sorted(row.name for row in REQUESTS)


@pytest.mark.parametrize("name", HERE)
def test_a_verb_does_what_it_is_for(stand, name):
    DOES[name](stand)


@pytest.mark.parametrize("name", HERE)
def test_the_test_of_a_verb_fails_if_it_does_nothing(stand, monkeypatch, name):
    do = name.partition("_")[0]
    monkeypatch.setattr(Requests, f"do_{do}", lambda _self, _request: {})
    with pytest.raises((AssertionError, KeyError, IndexError, json.JSONDecodeError)):
        DOES[name](stand)


@pytest.mark.system
@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system cannot copy a process")
@pytest.mark.parametrize("name", OF_THE_PAST)
def test_a_verb_of_the_past_does_what_it_is_for(past, name):
    DOES[name](past)
