"""Every verb with values of every other kind, over a socket: what is refused, and in which words."""

from __future__ import annotations

import json
import re
from functools import cache

import fastjsonschema
import pytest

from slewline.links.control.requests import NAMES, REQUESTS, read, request_schema

from .conftest import Asks, Threaded

VALUES = {
    "true": "true",
    "null": "null",
    "a list": "[]",
    "a list of true": "[true]",
    "a list of null": "[null]",
    "an object": "{}",
    "an object of others": '{"chip": 7, "pin": null, "finding": []}',
    "a word": '"word"',
    "no text": '""',
    "a name with a dot": '"x.y"',
    "an unpaired half": '"\\ud800"',
    "a long text": json.dumps("x" * 5000),
    "a path": '"../../etc/passwd"',
    "a number as text": '"1"',
    "a half": "0.5",
    "less than nothing": "-1",
    "nothing": "0",
    "much": str(10**12),
    "very much": str(10**30),
    "more digits than an array holds": str(2**63),
    "the least": str(-(2**63)),
    "a power": "1e300",
    "no number": "NaN",
    "without end": "Infinity",
    "over the edge": "1e999",
    "many digits": "9" * 5000,
    "deep": "[" * 40 + "]" * 40,
    "deeper": "[" * 900 + "]" * 900,
    "a time": '"1 ms"',
    "a long time": '"999999999999 h"',
    "less than no time": '"-1 s"',
}
# No word of Python, no name of a call, no path of this machine, no value as Python writes it.
FOREIGN = re.compile(
    r"Traceback|^b'|\"b'|NoneType|object at 0x|<class|<function|\b\w+\(\)|\bint\b|\bfloat\b|\bstr\b"
    r"|\bdict\b|\bbool\b|\bNone\b|\bTrue\b|\bFalse\b|\w+Error\b|\bbench\.|\bself\b|__|positional argument|unhashable"
    r"|/tmp|/home|\.py\b|mistake in slewline"
)


@pytest.fixture
def stand(lockstep, client):
    """A module on a TCP port: the running server, a host, and a client of the control port."""
    server, line = lockstep()
    server.bench.part("jog_switch", name="jog")
    server.bench.part("motor", name="m", to=server.bench["x"])
    server.bench.part("encoder", name="enc", on=server.bench["m"])
    server.bench.record("x.clock", "x.mov")
    port, control = server.tcp(line, "127.0.0.1:0"), server.control("127.0.0.1:0")
    with Threaded(server) as running:
        yield running, client(port.where), Asks(client(control.where))


def sent(ask, text):
    ask.client.send(text.encode() + b"\n")
    return ask.answer()


def places(row):
    """Yield the places of a row at which a value may be wrong: a key, or one of an object inside of it."""
    example = {"do": row.do} | row.example
    for key in row.keys:
        rest = {name: value for name, value in example.items() if name != key.name}
        yield f"{json.dumps(rest)[:-1]}, {json.dumps(key.name)}: ", "}"
        listed = key.kind.get("type") == "array"
        left, right = ("[", "]}") if listed else ("", "}")
        if listed:
            yield f"{json.dumps(rest)[:-1]}, {json.dumps(key.name)}: [", "]}"
        for form in (key.kind["items"] if listed else key.kind).get("oneOf", ()):
            whole = {name: SAMPLES[name] for name in form["properties"]}
            for inner in whole:
                others = {name: value for name, value in whole.items() if name != inner}
                begin = json.dumps(others)[:-1] + (", " if others else "")
                yield (
                    f"{json.dumps(rest)[:-1]}, {json.dumps(key.name)}: {left}{begin}{json.dumps(inner)}: ",
                    "}" + right,
                )


SAMPLES = {"chip": "x", "address": 7, "position": 4, "axis": 1, "register": "rate", "value": 3, "pin": "x.mov"}
SAMPLES |= {"edge": "any", "finding": "", "level": 1, "quantity": "x.position", "slope": "any"}


@cache
def allows(name):
    """What the schema says of a request, by a library of others, from what clients get."""
    return fastjsonschema.compile(next(request_schema(row) for row in REQUESTS if row.name == name))


def is_allowed(row, text):
    try:
        allows(row.name)(json.loads(text))
    except (fastjsonschema.JsonSchemaException, RecursionError):
        return False
    return True


NO_JSON = ("no number", "without end", "over the edge", "many digits", "deep", "deeper")


@pytest.mark.parametrize("row", [row for row in REQUESTS if row.keys], ids=lambda row: row.name)
def test_every_key_of_every_verb_with_every_other_kind_of_value(stand, row):
    running, _, ask = stand
    ask("read", pins=[])
    for begin, end in places(row):
        for what, value in VALUES.items():
            text = begin + value + end
            told = sent(ask, text).get("error", "")
            assert not FOREIGN.search(told) and len(told) < 1500, (text[:200], told)
            if what in NO_JSON:
                assert told, text[:200]
            elif not is_allowed(row, text):
                assert told.startswith(f"{row.do}: "), (text[:200], told)
                assert re.search(r"expected|allowed|needs|give", told), (text[:200], told)
    assert "chips" in ask("status")
    assert running.server.troubles == []


@pytest.mark.parametrize("part", ["enc", "jog", "m"])
def test_every_verb_of_a_part_with_arguments_of_every_kind(stand, part):
    running, _, ask = stand
    for verb in (*running.bench[part].verbs, "finding", "drop"):
        for value in VALUES.values():
            for args in (f"[{value}]", f"[1, {value}]", value):
                told = sent(ask, f'{{"do": "act", "part": "{part}", "verb": "{verb}", "args": {args}}}').get(
                    "error", ""
                )
                assert not FOREIGN.search(told), (verb, args[:100], told)
    assert "chips" in ask("status")


def test_an_argument_of_a_part_has_the_kind_of_its_parameter(stand):
    ask = stand[2]
    act = {"do": "act", "part": "enc", "verb": "slip"}
    for args, says in (
        ([True], "act: args[0]: true; expected a whole number; allowed"),
        (["3"], "act: args[0]: '3'; expected a whole number"),
        ([None], "act: args[0]: null; expected text or a number or true or false"),
        ([], "act: args: a list of length 0; allowed for slip: counts"),
        ([1, 2], "act: args: a list of length 2; allowed for slip: counts"),
        ([10**30], "allowed -9223372036854775808 to"),
    ):
        assert says in sent(ask, json.dumps(act | {"args": args}))["error"]
    assert "error" not in sent(ask, json.dumps(act | {"args": [3]}))


@pytest.mark.parametrize("value", [*VALUES.values()], ids=[*VALUES])
def test_an_id_of_any_kind_comes_back_or_is_refused(stand, value):
    ask = stand[2]
    text = f'{{"do": "read", "pins": [], "id": {value}}}'
    ask.client.send(b'{"do": "read", "pins": []}\n')
    ask.answer()
    ask.client.send(text.encode() + b"\n")
    line = ask.client.read(b"\n").decode()
    assert not FOREIGN.search(line)
    reply = json.loads(line, parse_constant=pytest.fail) if "error" not in line else {}
    assert reply.get("id") == (json.loads(value) if reply else None)


def test_requests_found_by_the_audit_of_a_schema_are_refused(stand):
    ask = stand[2]
    for request, says in (
        (
            {"do": "breakpoints", "breakpoints": [{"chip": "x", "register": "rate", "value": "x"}]},
            "[0].value: 'x'; exp",
        ),
        (
            {"do": "window", "signals": ["x.velocity"], "columns": True},
            "window: columns: true; expected a whole number",
        ),
        ({"do": "said", "start": True}, "said: start: true; expected a whole number"),
        ({"do": "export", "signals": [], "form": "vcd"}, "export: signals: no recorded pin is among them"),
        ({"do": "find", "on": {"pin": "x.mov", "level": True}}, "find: on.level: true; allowed 0, 1"),
        ({"do": "drive", "pin": "x.enable", "level": True}, "drive: level: true; allowed 0, 1"),
    ):
        assert says in sent(ask, json.dumps(request))["error"]


def test_a_whole_number_may_be_written_with_a_point(stand):
    ask = stand[2]
    assert "error" not in sent(ask, '{"do": "drive", "pin": "x.ui1", "level": 1.0}')
    assert "entries" in sent(ask, '{"do": "said", "start": 0.0}')


def test_an_internal_error_does_not_end_the_server(stand, monkeypatch):
    running, _, ask = stand

    def broken(_self, _request):
        raise OverflowError("int too large, in /home/me/file.py")

    monkeypatch.setattr("slewline.links.control.control.Requests.do_status", broken)
    told = ask.refused("status")
    assert told.startswith("status: an internal error of slewline")
    assert "levels" in ask("read", pins=[])
    reported = []
    running.server.report = reported.append
    ask("status")
    assert "OverflowError" in reported[0] and "broken" in reported[0]


def test_the_validator_and_the_schema_agree_on_every_example():
    for row in REQUESTS:
        request = {"do": row.do} | row.example
        assert read(json.dumps(request).encode()) == request == allows(row.name)(request)


def test_a_verb_of_several_forms_is_distinguished_by_its_keys():
    """No two forms of a verb take the same keys: which one is meant is then no matter of their order."""
    for do in NAMES:
        forms = [request_schema(row) for row in REQUESTS if row.do == do]
        for form in forms:
            keys = set(form["required"])
            fits = [one for one in forms if set(one["required"]) <= keys <= set(one["properties"])]
            assert fits == [form], do
