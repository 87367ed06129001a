"""Time as a control, on a server in this process: exact instants, what is refused, who is told."""

from __future__ import annotations

import json

import pytest

import slewline
from slewline.bench.runner import Wait
from slewline.links.lines.pace import Lockstep, Paced
from slewline.links.server import Server

from .conftest import STRAPS, Asks, Threaded

PROGRAM = ("Po", "S50", "T200", "R20", "L0", "+25", "-9", "L3", "E")


def plain(end="20 s"):
    """A bench on which the program runs without any server; edges, instructions, positions with their instants."""
    bench = slewline.Bench()
    x = bench.add("gs-c200s", name="x", straps=STRAPS)
    bench.record("x.clock", "x.mov", "x.dir")
    begun = []
    x.on_instruction.add(lambda address: begun.append((bench.now_ps, address)))
    host = bench.host(x)
    for line in PROGRAM:
        host.send(line.encode() + b"\r")
    bench.run(end)
    return bench, x, begun


@pytest.fixture(params=[Lockstep, lambda bench: Paced(bench, "0.01")], ids=["lockstep", "paced"])
def stand(request, client):
    """The same on a server, paused before the program runs; hosts are on the bench."""
    bench = slewline.Bench()
    x = bench.add("gs-c200s", name="x", straps=STRAPS)
    bench.record("x.clock", "x.mov", "x.dir")
    host = bench.host(x)
    for line in PROGRAM:
        host.send(line.encode() + b"\r")
    server = Server(bench, request.param(bench))
    server.pace.pause_time()
    control = server.control("127.0.0.1:0")
    with Threaded(server):
        yield Asks(client(control.where))


def test_each_step_of_a_motor_is_an_instant_of_a_plain_run(stand):
    _, x, _ = plain()
    for at in x.steps().times_ps.tolist()[:60]:
        assert stand("step", chip="x", by="step") == {"met": True, "time_ps": at}


@pytest.mark.parametrize("edge", ["rises", "falls", "any"])
@pytest.mark.parametrize("pin", ["x.clock", "x.mov"])
def test_each_edge_of_a_pin_is_one_of_a_plain_run(stand, pin, edge):
    bench, _, _ = plain()
    wanted = {"rises": (1,), "falls": (0,), "any": (0, 1)}[edge]
    edges = zip(*(array.tolist() for array in bench.edges(pin)), strict=True)
    times = [t for t, level in edges if level in wanted]
    now = stand("view")["time_ps"]
    for at in [t for t in times if t > now][:40]:
        assert stand("step", pin=pin, edge=edge) == {"met": True, "time_ps": at}


def test_each_instruction_is_one_of_a_plain_run(stand):
    _, _, begun = plain()
    stand("until", time=begun[0][0] - 1)
    for at, address in begun:
        assert stand("step", chip="x", by="instruction") == {"met": True, "time_ps": at}
        assert stand("listing", chip="x")["counter"] == address
    assert stand("step", chip="x", by="instruction", timeout="1 s")["met"] is False


def test_breakpoints_stop_at_the_instants_of_a_plain_run_and_each_is_reported(stand):
    bench, x, begun = plain()
    address = begun[-1][1]
    falls = [t for t, level in zip(*(a.tolist() for a in bench.edges("x.mov")), strict=True) if level == 0]
    steps = x.steps()
    position = steps.positions.tolist()
    sevens = [t for n, t in enumerate(steps.times_ps.tolist()) if position[n] == 7]
    now = stand("view")["time_ps"]
    wanted = sorted({t for t in [*falls, *sevens, *(t for t, a in begun if a == address)] if t > now})
    rows = [{"pin": "x.mov", "edge": "falls"}, {"chip": "x", "position": 7}, {"chip": "x", "address": address}]
    stand("breakpoints", breakpoints=[*rows, rows[0]])  # one of them twice
    for at in wanted:
        assert stand("until", time="20 s")["time_ps"] == at
    assert stand("until", time="20 s") == {"met": True, "time_ps": 20 * 10**12}
    assert stand("breakpoints")["rows"] == [*rows, rows[0]]


def test_a_breakpoint_ends_an_advance_while_time_is_stopped(stand):
    _, x, _ = plain()
    stand("breakpoints", breakpoints=[{"chip": "x", "position": 7}])
    steps = x.steps()
    at = steps.times_ps.tolist()[steps.positions.tolist().index(7)]
    assert stand("advance", time="15 s") == {"time_ps": at}


def test_a_passive_wait_stops_with_time():
    bench = slewline.Bench()
    bench.add("gs-c200s", name="x", straps=STRAPS)
    pace = Lockstep(bench)
    pace.start()
    now = bench.now_ps
    pace.wait(Wait(lambda: False, now + 10**12))
    pace.pause_time()
    assert pace.pass_time() and bench.now_ps == now
    pace.wait(Wait(lambda: False, now + 10**9, pushes=True))
    assert pace.pass_time() and bench.now_ps == now + 10**9
    pace.go()
    assert pace.pass_time() and bench.now_ps == now + 10**12


def test_a_rate_that_changes_loses_no_time_and_a_pause_is_not_a_lag():
    wall = [0]
    bench = slewline.Bench()
    bench.add("gs-c200s", name="x", straps=STRAPS)
    pace = Paced(bench, 1, lambda: wall[0])
    pace.start()
    began = bench.now_ps
    wall[0] += 10**9
    while not pace.pass_time():
        pass
    pace.pause_time()
    wall[0] += 100 * 10**9
    pace.pass_time()
    assert bench.now_ps == began + 10**12
    lag = (pace.lag.late, pace.lag.worst_ns, pace.lag.lost_ns)
    pace.go("0.5")
    wall[0] += 2 * 10**9
    while not pace.pass_time():
        pass
    assert bench.now_ps == began + 2 * 10**12
    assert pace.lag.lost_ns == lag[2]


BAD = [
    ({"do": "go", "rate": "0.0001"}, "0.001 to 1000"),
    ({"do": "go", "rate": "nan"}, "0.001 to 1000"),
    ({"do": "go", "rate": []}, "0.001 to 1000"),
    ({"do": "step", "chip": "x", "by": "day"}, "allowed instruction, step, command, finding"),
    ({"do": "step", "chip": "x", "pin": "x.mov"}, "found chip, pin; give chip, by, [axis], [timeout]; or pin"),
    ({"do": "step", "chip": "x"}, "found chip; give chip, by, [axis], [timeout]; or pin"),
    ({"do": "step", "pin": "x.mov", "edge": "up"}, "allowed rises, falls, any"),
    ({"do": "step", "chip": "x", "by": "step", "axis": 2}, "axis"),
    ({"do": "until", "time": "0 s"}, "is in the past"),
    ({"do": "until", "chip": "x", "address": -1}, "until: address: -1; expected a whole number; allowed 0 to"),
    ({"do": "until", "chip": "x", "address": "7"}, "until: address: '7'; expected a whole number"),
    ({"do": "breakpoints", "breakpoints": {}}, "expected a list"),
    ({"do": "breakpoints", "breakpoints": [7]}, "breakpoints[0]: 7; expected an object"),
    ({"do": "breakpoints", "breakpoints": [{"pin": 7}]}, "breakpoints[0].pin: 7; expected text such as"),
    ({"do": "breakpoints", "breakpoints": [{"finding": []}]}, "[0].finding: a list of length 0; expected text"),
    (
        {"do": "breakpoints", "breakpoints": [{"chip": ["x"], "address": 3}]},
        "[0].chip: a list of length 1; expected text",
    ),
    ({"do": "breakpoints", "breakpoints": [{"chip": "x", "register": "nonsense"}]}, "nonsense"),
    ({"do": "breakpoints", "breakpoints": [{"finding": ""}] * 257}, "allowed up to 256"),
    ({"do": "find", "on": {"finding": [1]}}, "find: on.finding: a list of length 1; expected text"),
    ({"do": "find", "on": {"pin": "x.mov", "level": 2}}, "allowed 0, 1"),
    ({"do": "find", "on": "x"}, "expected an object"),
    ({"do": "window", "signals": ["x.mov"], "columns": 10**30}, "allowed 1 to"),
    ({"do": "window", "signals": ["x.nonsense"], "columns": 3}, "nonsense"),
    ({"do": "window", "signals": "x.mov", "columns": 3}, "expected a list"),
    ({"do": "export", "signals": ["x.mov"], "form": "png"}, "allowed vcd, csv"),
    ({"do": "record", "pins": [["x.mov"]]}, "record: pins[0]: a list of length 1; expected text"),
    ({"do": "said", "start": "0"}, "said: start: '0'; expected a whole number"),
    ({"do": "act", "part": "x", "verb": "fly"}, "no verb 'fly'"),
    ({"do": "example", "name": "../../etc/passwd"}, "no example"),
    ({"do": "subscribe", "every": "soon"}, "subscribe: every: 'soon'; expected text with a unit"),
    ({"do": "back", "time": "0 s"}, "--journal FILE"),
]


def test_refusals_are_reported_and_nothing_is_done(client, subtests):
    for request_, says in BAD:
        with subtests.test(request=json.dumps(request_)[:60]):
            bench = slewline.Bench()
            bench.add("gs-c200s", name="x", straps=STRAPS)
            bench.record("x.mov")
            server = Server(bench, Paced(bench))
            control = server.control("127.0.0.1:0")
            with Threaded(server):
                ask = Asks(client(control.where))
                ask("breakpoints", breakpoints=[{"finding": "x"}])
                assert says in ask(**request_)["error"]
                assert not ask("view")["view"]["pace"]["paused"]
                assert ask("breakpoints")["rows"] == [{"finding": "x"}]
