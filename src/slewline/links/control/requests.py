"""The requests of the control port: what each needs and what its reply has, as rows.

The check of a request, the JSON schema and the page of the documentation are made from them; what a request does is the
method of its name in `links.control.control`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...core.messages.near import hint
from ...errors import UsageError
from ...parts.lines.noise import LINKED

Data = dict[str, Any]
MAX_STEPS = 100_000  # in one reply
MAX_FINDINGS = 1000

# ----------------------------------------------------------------------------------------------------- kinds of values
TEXT: Data = {"type": "string"}
WHOLE: Data = {"type": "integer"}
BOOLEAN: Data = {"type": "boolean"}
NUMBER: Data = {"type": "number"}
TIME: Data = {"type": ["string", "integer"]}
LEVEL: Data = {"enum": [0, 1]}
PIN: Data = TEXT | {"pattern": r"^\w+\.\w+$"}


def array(of: Data) -> Data:
    """Return the schema of a list of values of a kind."""
    return {"type": "array", "items": of}


def mapping(of: Data) -> Data:
    """Return the schema of values of a kind by names that depend on the bench."""
    return {"type": "object", "additionalProperties": of}


def record(needed: Mapping[str, Data], optional: Mapping[str, Data] | None = None) -> Data:
    """Return the schema of an object with known keys."""
    return {"type": "object", "properties": {**needed, **(optional or {})}, "required": list(needed)}


FOUND = record({"time_ps": WHOLE, "code": TEXT, "text": TEXT})
AXIS = record({"position": WHOLE, "registers": mapping(WHOLE)})
CHIP = record(
    {
        "part": TEXT,
        "position": WHOLE,
        "registers": mapping(WHOLE),
        "axes": array(AXIS),
        "program": TEXT,
        "idle": BOOLEAN,
        "moving": BOOLEAN,
        "waiting": TEXT,
        "steps": WHOLE,
        "findings": array(FOUND),
    }
)
HITS = record({way: mapping(WHOLE) for way in ("chip", "host")})
LINE = record(
    {"chips": array(TEXT), "host": {"type": ["string", "null"]}, "taken": WHOLE, "given": WHOLE, "dropped": WHOLE},
    {"baud": WHOLE, "format": TEXT, "hits": HITS, "findings": array(FOUND)},
)
PACE = record(
    {"lockstep": BOOLEAN}, {"rate": NUMBER, "events": WHOLE, "late": WHOLE, "worst_us": WHOLE, "lost_us": WHOLE}
)


# ---------------------------------------------------------------------------------------------------------------- rows
@dataclass(frozen=True)
class Key:
    """A key of a request or of a reply."""

    name: str
    kind: Data
    says: str
    default: str = ""  # of a key that may be left out


@dataclass(frozen=True)
class RequestSpec:
    """A request; one that has two forms, such as `until`, has two rows."""

    do: str
    says: str
    example: Data
    keys: tuple[Key, ...] = ()
    reply: tuple[Key, ...] = ()
    form: str = ""

    @property
    def needs(self) -> list[str]:
        """The keys that may not be left out."""
        return [key.name for key in self.keys if not key.default]

    @property
    def name(self) -> str:
        """What it is called in the schema."""
        return f"{self.do}_{self.form}" if self.form else self.do


A_PIN = Key("pin", PIN, "owner and pin")
A_LEVEL = Key("level", LEVEL, "0 or 1, the electrical level")
A_CHIP = Key("chip", TEXT, "its name")
AN_AXIS = Key("axis", WHOLE, "counted from 1", "1")
A_LINE = Key("line", TEXT, "its name, or that of any chip on it")
TIMEOUT = Key("timeout", TIME, "how long to wait at most", "60 s")
MET = Key("met", BOOLEAN, "was the condition met?")

REQUESTS = (
    RequestSpec("drive", "Put a level on a pin.", {"pin": "x.enable", "level": 0}, (A_PIN, A_LEVEL)),
    RequestSpec("release", "Let go of a pin.", {"pin": "x.enable"}, (A_PIN,)),
    RequestSpec(
        "pulse",
        "Put a level on a pin for a time.",
        {"pin": "x.ui1", "level": 0, "width": "20 us"},
        (A_PIN, A_LEVEL, Key("width", TIME, "how long")),
    ),
    RequestSpec(
        "read",
        "Read levels.",
        {"pins": ["x.mov", "x.rdy"]},
        (Key("pins", array(PIN), "owners and pins"),),
        (Key("levels", mapping({"enum": [0, 1, None]}), "by pin; null: it floats"),),
    ),
    RequestSpec("advance", "Let time pass (lockstep only).", {"time": "250 ms"}, (Key("time", TIME, "how much"),)),
    RequestSpec(
        "until",
        "Wait until a pin has a level; in lockstep, time passes.",
        {"pin": "x.rdy", "level": 1, "timeout": "5 s"},
        (A_PIN, A_LEVEL, TIMEOUT),
        (MET,),
        "pin",
    ),
    RequestSpec(
        "until",
        "Wait until an axis is at a position.",
        {"chip": "x", "axis": 1, "position": 400},
        (A_CHIP, Key("position", WHOLE, "in steps"), AN_AXIS, TIMEOUT),
        (MET,),
        "position",
    ),
    RequestSpec(
        "fault",
        "Hit the next characters of a serial line.",
        {"line": "x", "to": "chip", "kind": "parity", "count": 3, "chance": 0.5, "seed": 1},
        (
            A_LINE,
            Key("to", {"enum": ["chip", "host"]}, "which direction"),
            Key("kind", {"enum": list(LINKED)}, ", ".join(LINKED)),
            Key("count", WHOLE | {"minimum": 1}, "how many characters", "1"),
            Key("chance", NUMBER | {"minimum": 0, "maximum": 1}, "the share of them that is hit", "1"),
            Key("seed", WHOLE, "which of them: the same seed hits the same ones", "0"),
        ),
        form="line",
    ),
    RequestSpec(
        "fault",
        "Let the programming of an EEPROM fail: M and X are answered E6.",
        {"chip": "x", "kind": "eeprom"},
        (A_CHIP, Key("kind", {"enum": ["eeprom"]}, "eeprom")),
        form="chip",
    ),
    RequestSpec(
        "clear",
        "End the faults on a line.",
        {"line": "x"},
        (A_LINE,),
        (Key("hits", HITS, "how many characters were hit, by direction and kind"),),
        "line",
    ),
    RequestSpec("clear", "Let the EEPROM work again.", {"chip": "x"}, (A_CHIP,), form="chip"),
    RequestSpec(
        "power",
        "Switch the supply of a chip.",
        {"chip": "x", "on": False},
        (A_CHIP, Key("on", BOOLEAN, "true or false")),
    ),
    RequestSpec(
        "status",
        "The state of chips, lines and time.",
        {},
        (),
        (
            Key("pace", PACE, "how time passes, and how well the wall clock is kept"),
            Key("chips", mapping(CHIP), "by name; of the findings the last 20"),
            Key("lines", mapping(LINE), "by name; bytes from the host (`taken`), to it, and those no host read"),
            Key("findings", WHOLE, "how many since the beginning"),
            Key("troubles", array(TEXT), "what the server could not do, such as a file that takes no more"),
        ),
    ),
    RequestSpec(
        "findings",
        "What hosts did that a manual forbids or leaves open; oldest first.",
        {"source": "x", "start": "1 s"},
        (
            Key("source", TEXT, "a chip or part", "all of them"),
            Key("start", TIME, "only those from this instant on", "0"),
        ),
        (
            Key("findings", array(record({"source": TEXT, **FOUND["properties"]})), f"the last {MAX_FINDINGS}"),
            Key("omitted", WHOLE, "how many older ones there are"),
        ),
    ),
    RequestSpec(
        "steps",
        f"The steps of an axis, {MAX_STEPS} at most.",
        {"chip": "x", "axis": 1, "start": 0, "stop": "1 s"},
        (A_CHIP, AN_AXIS, Key("start", TIME, "the window", "0"), Key("stop", TIME, "its end", "now")),
        (
            Key("times_ps", array(WHOLE), "of each step"),
            Key("directions", array({"enum": [1, -1]}), "1: clockwise, towards greater positions"),
            Key("positions", array(WHOLE), "after each step"),
        ),
    ),
    RequestSpec("schema", "The JSON schema of all this.", {}, (), (Key("schema", {"type": "object"}, "draft 7"),)),
    RequestSpec("quit", "End the server.", {}),
)

NAMES = tuple(dict.fromkeys(row.do for row in REQUESTS))
COMMON = (
    Key("id", {}, "anything; it comes back in the reply", "nothing"),
    Key("token", TEXT, "in the first request, if the server has one", "nothing"),
)


def read(line: bytes) -> Data:
    """Return a request.

    Raises:
        UsageError: no JSON object with a known "do", or keys that it does not have.
    """
    request = as_object(line)
    do = request.get("do")
    rows = [row for row in REQUESTS if row.do == do]
    if not rows:
        raise UsageError(f"do {do!r}; allowed {', '.join(NAMES)}{hint(do, NAMES)}")
    keys = {key.name: key for row in rows for key in row.keys}
    needed = [name for name in keys if all(name in row.needs for row in rows)]
    for name in needed:
        if name not in request:
            raise UsageError(f"{do}: needs {', '.join(needed)}; {name} is missing")
    for name, value in request.items():
        if name not in ("do", *keys, *(key.name for key in COMMON)):
            allowed = ", ".join(keys) or "nothing"
            raise UsageError(f"{do}: {name} is unknown; allowed {allowed}{hint(name, keys)}")
        if name in keys and must_be_text(keys[name].kind) and not isinstance(value, str):
            raise UsageError(f"{do}: {name} {value!r}; expected text")
    return request


def as_object(line: bytes) -> Data:
    """Return a line as a JSON object.

    Raises:
        UsageError: it is none.
    """
    try:
        found = json.loads(line)
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise UsageError(f'{line[:60]!r} is not a JSON object; expected a line such as {{"do": "status"}}')
    return found


def must_be_text(kind: Data) -> bool:
    """Return whether a value of this kind has to be text."""
    return kind.get("type") == "string" or isinstance(kind.get("enum", [0])[0], str)


# -------------------------------------------------------------------------------------------------------------- schema
def schema() -> Data:
    """Return all requests and replies as JSON schema: `definitions` has `drive`, `drive_reply` and so on."""
    made: Data = {row.name: request_schema(row) for row in REQUESTS}
    made |= {f"{row.name}_reply": reply_schema(row) for row in REQUESTS}
    made["error"] = record({"error": TEXT, "time_ps": WHOLE}, {"id": {}})
    made["request"] = {"oneOf": [{"$ref": f"#/definitions/{row.name}"} for row in REQUESTS]}
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "slewline control port",
        "description": "A line of text each: a request is an object, and so is its reply, or an error.",
        "definitions": made,
    }


def request_schema(row: RequestSpec) -> Data:
    """Return the schema of a request."""
    needed = {"do": {"const": row.do}} | {key.name: described(key) for key in row.keys if not key.default}
    optional = {key.name: described(key) for key in (*row.keys, *COMMON) if key.default}
    return record(needed, optional) | {"additionalProperties": False, "description": row.says}


def reply_schema(row: RequestSpec) -> Data:
    """Return the schema of the reply to it, unless it is an error; later versions may add keys."""
    return record({key.name: described(key) for key in row.reply} | {"time_ps": WHOLE}, {"id": {}})


def described(key: Key) -> Data:
    """Return the kind of a key, with what it means."""
    return key.kind | {"description": key.says}
