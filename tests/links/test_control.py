"""The control port, as a program in any language uses it."""

from __future__ import annotations

import json
import os
import random
import socket
from functools import cache

import fastjsonschema
import pytest

import slewline
from slewline.errors import UsageError
from slewline.links.control import control
from slewline.links.control.requests import REQUESTS, schema
from slewline.links.control.value_kinds import MAX_FINDINGS
from slewline.links.lines.pace import Lockstep
from slewline.links.server import Server
from tests.ensembles import in_long_runs

from .conftest import STRAPS, Asks, Threaded

PROGRAM = ("Po", "S50", "T200", "R20", "+400", "E")


@pytest.fixture
def stand(lockstep, client):
    """A module on a TCP port: the running server, a host, and a client of the control port."""
    server, line = lockstep()
    server.bench.part("jog_switch", name="jog")
    server.bench.record("x.clock", "x.mov")
    port, control = server.tcp(line, "127.0.0.1:0"), server.control("127.0.0.1:0")
    with Threaded(server) as running:
        yield running, client(port.where), Asks(client(control.where))


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


def test_time_advances_by_the_requested_amount(stand):
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


def test_an_unmet_condition_is_reported_at_the_time_limit(stand):
    _, _, ask = stand
    before = ask("status")["time_ps"]
    resting, at = "no command or program is in progress", before + 3 * 10**12
    assert ask("until", pin="x.mov", level=1, timeout="3 s") == {"met": False, "why": resting, "time_ps": at}
    nowhere = ask("until", chip="x", address=50, timeout="1 s")
    assert nowhere["met"] is False and nowhere["why"] == f"where no instruction begins: no program is stored; {resting}"
    assert (
        "x: instruction at 500; allowed 0..118, the addresses of a program"
        in ask("until", chip="x", address=500)["error"]
    )


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


def test_a_client_that_closes_its_sending_side_gets_every_reply(stand):
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


def test_a_module_without_power_is_silent(stand):
    running, host, ask = stand
    ask("power", chip="x", on=False)
    host.send(b"F\r")
    running.until(lambda: running.server.lines["x"].taken == 2)
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


def test_random_faults_continue_until_they_are_cleared(stand):
    _, host, ask = stand
    ask("fault", line="x", to="chip", kind="parity", count=1000, chance=0.5, seed=3)
    answers = [host.ask(b"F\r") for _ in range(40)]
    assert {b"E1\r", b"R\r"} == set(answers)
    ask("clear", line="x")
    assert {host.ask(b"F\r") for _ in range(20)} == {b"R\r"}


def test_garbling_never_hits_the_bit_to_which_a_checksum_is_blind(stand):
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


def test_the_status_reports_the_elapsed_time(stand):
    _, host, ask = stand
    host.ask(b"F\r")
    found = ask("status")
    line = found["lines"]["x"]
    assert (line["taken"], line["given"], line["dropped"]) == (2, 2, 0)
    assert (line["baud"], line["format"], line["chips"]) == (9600, "7O2", ["x"])
    assert line["host"] == "{}:{}".format(*host.socket.getsockname())
    assert found["pace"] == {"lockstep": True}
    assert found["chips"]["x"]["part"] == "gs-c200s"


WRONG = [
    ("nonsense", "is not a JSON object"),
    ("[" * 60_000, "is not a JSON object"),  # deeper than Python goes
    ("[1]", "is not a JSON object"),
    ('{"do": "dance"}', "do: 'dance'; allowed drive, release"),
    ('{"do": []}', "allowed drive, release"),
    ('{"do": "drive", "pin": "x.ui1"}', "level is missing"),
    ('{"do": "drive", "pin": "x.ui1", "level": 2}', "allowed 0, 1"),
    ('{"do": "drive", "pin": 7, "level": 1}', "expected text"),
    ('{"do": "drive", "pin": "ui1", "level": 1}', 'expected text such as "x.enable"'),
    ('{"do": "drive", "pin": "x.ui9", "level": 1}', "has no pin 'ui9'"),
    ('{"do": "drive", "pin": "x.ui1", "level": 1, "at": 3}', "drive: 'at' is unknown; allowed pin, level"),
    ('{"do": "read", "pins": "x.ui1"}', "expected a list"),
    ('{"do": "read", "pins": [7]}', "read: pins[0]: 7; expected text such as"),
    ('{"do": "advance", "time": 0.5}', "advance: time: 0.5; expected text with a unit such as"),
    ('{"do": "advance", "time": "-1 s"}', "does not run backwards"),
    (
        '{"do": "until", "pin": "x.ui1"}',
        "give pin, level, [timeout]; or chip, position, [axis], [timeout]; or chip, address",
    ),
    (
        '{"do": "until", "pin": "x.ui1", "level": 1, "chip": "x", "position": 1}',
        "found pin, level, chip, position; give pin, level",
    ),
    ('{"do": "until", "chip": "x", "position": "far"}', "expected a whole number"),
    ('{"do": "fault", "line": "y", "to": "chip", "kind": "lost"}', "no serial line 'y'; allowed: x"),
    ('{"do": "fault", "line": "x", "to": "me", "kind": "lost"}', "allowed chip, host"),
    ('{"do": "fault", "line": "x", "to": "chip", "kind": "loud"}', "allowed lost, garbled"),
    (
        '{"do": "fault", "line": "x", "to": "chip", "kind": "lost", "count": 0}',
        "fault: count: 0; expected a whole number; allowed 1 to 1000000000",
    ),
    (
        '{"do": "fault", "line": "x", "kind": "lost"}',
        "found line, kind; give line, to, kind, [count], [chance], [seed]; or chip, kind",
    ),
    ('{"do": "fault", "line": "x", "to": "chip", "kind": "eeprom"}', "allowed lost, garbled"),
    ('{"do": "fault", "chip": "x", "kind": "lost"}', "fault: kind: 'lost'; allowed eeprom"),
    ('{"do": "fault", "chip": "x", "kind": "eeprom", "count": 2}', "fault: found chip, kind, count; give line, to"),
    ('{"do": "fault", "chip": "y", "kind": "eeprom"}', "no chip 'y'; allowed: x"),
    ('{"do": "clear"}', "clear: found nothing; give line; or chip"),
    ('{"do": "fault", "line": "x", "to": "chip", "kind": "lost", "seed": {}}', "seed"),
    ('{"do": "power", "chip": "y", "on": true}', "no chip 'y'; allowed: x"),
    ('{"do": "power", "chip": "x", "on": 1}', "power: on: 1; expected true or false"),
    ('{"do": "steps", "chip": "x", "start": "soon"}', "steps: start: 'soon'; expected text with a unit"),
]


def test_mistakes_are_reported_and_the_server_continues(stand, subtests):
    for request_, says in WRONG:
        with subtests.test(request=request_[:60]):
            _, host, ask = stand
            ask("read", pins=[])
            ask.client.send(request_.encode() + b"\n")
            assert says in ask.answer()["error"]
            assert host.ask(b"F\r") == b"R\r"


def test_a_request_without_end_costs_no_memory(stand):
    running, host, ask = stand
    ask("read", pins=[])
    ask.client.send(b"x" * (3 * control.LONGEST))
    assert host.ask(b"F\r") == b"R\r"
    assert running.do(lambda: len(running.server.ports[1].clients[0].incoming)) <= control.LONGEST
    ask.client.send(b"\n")
    assert "more than" in ask.answer()["error"]
    assert "chips" in ask("status")
    assert host.ask(b"F\r") == b"R\r"


@pytest.mark.parametrize("total", [5_000, in_long_runs(20_000)])
def test_random_bytes_with_parity_faults(stand, total):
    """Whatever comes, the protocol still answers, and what was done is told."""
    running, host, ask = stand
    chance = random.Random(11)
    ask("fault", line="x", to="chip", kind="parity", count=10**6, chance=0.01, seed=5)
    for _ in range(total // 1000):
        host.send(chance.randbytes(1000))
        host.send(b"")
    running.until(lambda: running.server.lines["x"].taken == total and running.server.lines["x"].quiet())
    hits = ask("clear", line="x")["hits"]["chip"]["parity"]
    assert total * 0.005 < hits < total * 0.015
    found = ask("status")
    assert found["findings"] > total // 400
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


# ---------------------------------------------------------------------------------------------------------- who may ask
TOKEN = "correct horse"


@pytest.fixture
def guarded(lockstep, client):
    """A control port with a token: connect to it."""
    server, _ = lockstep()
    where = server.control("127.0.0.1:0", TOKEN).where
    with Threaded(server):
        yield lambda: Asks(client(where))


def test_the_first_request_carries_the_token_and_the_next_ones_need_not(guarded):
    ask = guarded()
    assert "levels" in ask("read", pins=["x.mov"], token=TOKEN)
    assert "levels" in ask("read", pins=["x.mov"])


@pytest.mark.parametrize(
    "token", [{}, {"token": "correct hors"}, {"token": ""}, {"token": 7}, {"token": "\ud800 horse"}]
)
def test_clients_without_the_token_are_disconnected_and_nothing_is_done(guarded, token):
    ask = guarded()
    lines = [{"do": "drive", "pin": "x.ui1", "level": 0} | token] * 2 + [{"do": "quit", "token": TOKEN}]
    ask.client.send("".join(json.dumps(line) + "\n" for line in lines).encode())
    replies = ask.client.read(end=b"").splitlines()
    assert len(replies) == 1 and "must include the token" in json.loads(replies[0])["error"]
    assert guarded()("read", pins=["x.ui1"], token=TOKEN)["levels"] == {"x.ui1": 1}


def test_a_token_that_can_be_guessed_is_refused(lockstep):
    server, _ = lockstep()
    with pytest.raises(UsageError, match="has 7 characters; give 8 or more"):
        server.control("127.0.0.1:0", "1234567")
    server.close()


def test_other_machines_reach_the_control_port_with_a_token_only(lockstep):
    server, line = lockstep()
    server.allow_remote = True
    server.tcp(line, "0.0.0.0:0")
    with pytest.raises(UsageError, match="add --token"):
        server.control("0.0.0.0:0")
    assert server.control("127.0.0.1:0").where.startswith("127.0.0.1:")
    assert server.control("0.0.0.0:0", TOKEN).where.startswith("0.0.0.0:")
    server.close()


# ------------------------------------------------------------------------------------------- lines, findings, schema
def test_a_line_goes_by_the_name_of_any_chip_on_it(client):
    bench = slewline.Bench()
    chips = [bench.add("gs-c200s", name=name, straps=STRAPS | {f"sel{sel}": 0}) for sel, name in enumerate("abc")]
    server = Server(bench, Lockstep(bench))
    server.line(*chips)
    control = server.control("127.0.0.1:0")
    with Threaded(server):
        ask = Asks(client(control.where))
        for name in ("a+b+c", "a", "c"):
            assert set(ask("fault", line=name, to="chip", kind="lost")) == {"time_ps"}
        assert ask.refused("clear", line="d") == "no serial line 'd'; allowed: a+b+c"
        assert len(server.lines["a+b+c"].to_chip.plans) == 3


def test_findings_are_read_all_of_them_or_those_of_a_chip_from_an_instant_on(stand):
    running, host, ask = stand
    assert ask("findings")["findings"] == []
    host.ask(b"HELLO\r")
    since = ask("advance", time="1 s")["time_ps"]
    host.ask(b"W\r")
    running.do(lambda: running.bench["x_line"].finding("test", "of a part"))
    found = ask("findings")
    assert [(one["source"], one["code"]) for one in found["findings"]][-1] == ("x_line", "test")
    assert found["omitted"] == 0
    both = ask("findings", source="x")["findings"]
    assert {one["source"] for one in both} == {"x"} and len(both) == len(found["findings"]) - 1 == 2
    assert ask("findings", source="x", start=since)["findings"] == both[1:]
    assert "has no 'y'" in ask.refused("findings", source="y")


def test_of_too_many_findings_only_the_last_are_reported(stand):
    running, _, ask = stand
    running.do(lambda: [running.bench["x"].finding("test", str(number)) for number in range(MAX_FINDINGS + 3)])
    found = ask("findings")
    assert (len(found["findings"]), found["findings"][0]["text"], found["omitted"]) == (MAX_FINDINGS, "3", 3)


def strict(found):
    """A schema that allows no keys but those it names."""
    if isinstance(found, dict):
        closed = {"additionalProperties": False} if "properties" in found else {}
        return closed | {key: strict(value) for key, value in found.items()}
    return [strict(value) for value in found] if isinstance(found, list) else found


@cache
def checker(name):
    """Compile the schema of one thing that is said, by its name; that takes longer than to ask for it."""
    definitions = strict(schema()["definitions"])
    return fastjsonschema.compile({"$ref": f"#/definitions/{name}", "definitions": definitions})


IN_A_PROCESS = {"go", "back", "branches", "branch"}  # what needs the wall clock, or a process that can be copied


def checked(row, ask):
    """Ask as the example of a row has it, and less; check requests and replies against the schema."""
    example = {"do": row.do, "id": [1]} | row.example
    for name in (row.name, "request"):
        checker(name)(example)
    with pytest.raises(fastjsonschema.JsonSchemaException):
        checker(row.name)(example | {"nonsense": 1})
    for key in row.keys:
        if not key.default:
            less = {name: value for name, value in example.items() if name != key.name}
            with pytest.raises(fastjsonschema.JsonSchemaException):
                checker(row.name)(less)
            checker("error")(ask(**less))
    reply = ask(**example)
    checker(f"{row.name}_reply")(reply)
    if row.reply:
        with pytest.raises(fastjsonschema.JsonSchemaException):
            checker(f"{row.name}_reply")({"time_ps": 0})


@pytest.mark.parametrize(
    "row", [row for row in REQUESTS if row.do != "quit" and row.do not in IN_A_PROCESS], ids=lambda row: row.name
)
def test_every_request_and_its_reply_match_the_schema(stand, row):
    _, host, ask = stand
    for line in (*PROGRAM, "HELLO"):
        host.ask(line.encode() + b"\r")
    checked(row, ask)


@pytest.mark.system
@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system cannot copy a process")
def test_requests_for_the_wall_clock_and_the_past_match_the_schema(serve, client, tmp_path):
    chip = ["gs-c200s", *(f"--strap={pin}={level}" for pin, level in STRAPS.items())]
    ports = serve(
        *chip, "--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0", "--journal", tmp_path / "journal", ports=2
    ).ports
    host = client(ports[chip[0].replace("-", "_")])
    for line in PROGRAM:
        host.ask(line.encode() + b"\r")
    ask = Asks(client(ports["control"]))
    for row in REQUESTS:
        if row.do in IN_A_PROCESS:
            checked(row, ask)


@pytest.mark.system
@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system cannot copy a process")
def test_every_event_matches_the_schema(serve, client, tmp_path):
    straps = [f"--strap={pin}={level}" for pin, level in STRAPS.items()]
    ports = ("--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0", "--journal", tmp_path / "journal")
    server = serve("gs-c200s", *straps, *ports, ports=2)
    watcher, host = client(server.ports["control"]), client(server.ports["gs_c200s"])
    ask = Asks(client(server.ports["control"]))
    watcher.send(b'{"do": "subscribe", "every": "10 ms"}\n')
    assert "view" in json.loads(watcher.read(b"\n"))
    ask("breakpoints", breakpoints=[{"finding": ""}])
    host.send(b"HELLO\r")
    found = {}
    while set(found) != {"view", "said", "stopped", "branch"}:
        event = json.loads(watcher.read(b"\n"))
        checker(f"{event['event']}_event")(event)
        if event["event"] == "stopped" and "stopped" not in found:
            assert ask("back", time="1 ms")["branch"] == 1
        found[event["event"]] = event
    assert found["stopped"]["why"] == "gs_c200s: E2"
    assert found["branch"]["branch"] == 1


def test_every_request_has_a_row_and_every_row_is_done():
    assert {f"do_{row.do}" for row in REQUESTS} == {name for name in dir(control.Requests) if name.startswith("do_")}


def test_the_schema_can_be_queried(stand):
    ask = stand[2]
    assert ask("schema")["schema"] == schema()


# ------------------------------------------------------------------------------------------------- what each verb does
def test_a_pin_that_is_recorded_is_seen_found_and_exported(stand):
    ask = stand[2]
    ask("record", pins=["x.ui1"])
    start = ask("pulse", pin="x.ui1", level=0, width="20 us")["time_ps"]
    rise = start + 20_000_000
    window = {"start": start, "stop": ask("advance", time="1 ms")["time_ps"]}
    assert ask("find", on={"pin": "x.ui1", "edge": "rises"}, **window)["found_ps"] == rise
    assert ask("find", on={"pin": "x.ui1", "edge": "rises"}, start=rise + 1)["found_ps"] is None
    seen = ask("window", signals=["x.ui1"], columns=10, **window)["signals"]["x.ui1"]
    assert (seen["times_ps"], seen["levels"]) == ([start, rise], [0, 1])
    text = ask("export", signals=["x.ui1"], form="csv", **window)["text"]
    assert text.splitlines() == ["time_ps,net,level", f"{rise},x.ui1,1"]


def test_a_data_sheet_is_described(stand):
    ask = stand[2]
    sheet = ask("describe", chip="x")["sheet"]
    assert (sheet["part"], sheet["axes"], len(sheet["commands"])) == ("gs-c200s", 1, 29)
    assert [(pin["name"], pin["way"]) for pin in sheet["pins"] if pin["number"] in (1, 28)] == [
        ("sel0", "in"),
        ("clock", "out"),
    ]
    assert "no chip 'jog'" in ask.refused("describe", chip="jog")


def test_parts_are_listed_with_their_wiring(stand):
    ask = stand[2]
    parts = ask("parts")["parts"]
    assert {name: (part["kind"], part["to"]) for name, part in parts.items()} == {
        "x_line": ("SerialPort", ["x"]),
        "jog": ("JogSwitch", []),
    }
    assert parts["jog"]["verbs"] == ["cw", "ccw", "off"]


def test_a_program_is_assembled_and_its_mistakes_have_their_places(stand):
    ask = stand[2]
    found = ask("assemble", chip="x", text="Po\nS50\nA1\nE")
    assert [(row["line"], row["address"], row["text"]) for row in found["rows"]] == [(2, 0, "S50"), (3, 4, "A1")]
    assert (found["bytes"], found["problems"]) == (6, [])
    wrong = ask("assemble", chip="x", text="Po\nS50000\nE")
    assert [(one["line"], one["column"]) for one in wrong["problems"] if one["severity"] == "error"] == [(2, 2)]
    assert (wrong["rows"], wrong["bytes"]) == ([], 0)
    assert ask("listing", chip="x")["rows"] == []


def test_examples_are_listed_and_read(stand):
    ask = stand[2]
    found = ask("examples")["examples"]
    (drill,) = (one for one in found if one["name"] == "drilling_machine.py")
    assert drill["part"] == "py" and drill["title"].startswith("The drilling machine of the GS-C data sheet: ")
    text = ask("example", name=drill["name"])["text"]
    assert text.startswith(f'"""{drill["title"]}"""\n')
    assert "no example 'drill'" in ask.refused("example", name="drill")
