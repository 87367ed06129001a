"""The components of the rows that describe requests: kinds of values, as JSON schemas, and keys."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

Data = dict[str, Any]
MAX_STEPS = 100_000  # in one reply
MAX_FINDINGS = 1000

# ----------------------------------------------------------------------------------------------------- kinds of values
TEXT: Data = {"type": "string"}
NAME: Data = TEXT | {"maxLength": 200}
WHOLE: Data = {"type": "integer"}
BOOLEAN: Data = {"type": "boolean"}
NUMBER: Data = {"type": "number"}
A_TIME = r"^\s*[+-]?[0-9]{1,30}(\.[0-9]{0,30})?\s*[A-Za-zµ]+\s*$"  # a quantity with its unit
A_RATE = r"^[0-9]{1,9}(\.[0-9]{1,30})?$"
INT64 = 1 << 63
INTEGER: Data = WHOLE | {"minimum": -INT64, "maximum": INT64 - 1}  # of a request: such times are stored in arrays
COUNT: Data = WHOLE | {"minimum": 0, "maximum": INT64 - 1}
INSTANT: Data = {"type": ["string", "integer"], "pattern": A_TIME, "minimum": 0, "maximum": INT64 - 1}
TIME: Data = INSTANT | {"maximum": INT64 // 2}  # from now on
LEVEL: Data = {"enum": [0, 1]}
PIN: Data = NAME | {"pattern": r"^\w+\.\w+$", "examples": ["x.enable"]}


def array(of: Data, most: int | None = None) -> Data:
    """Return the schema of a list of values of one kind; `most` limits the number of values."""
    return {"type": "array", "items": of} | ({} if most is None else {"maxItems": most})


def one_of(*forms: Data) -> Data:
    """Return the schema of an object that takes one of several forms, each with its own keys and no others."""
    return {"oneOf": [form | {"additionalProperties": False} for form in forms]}


def mapping(of: Data) -> Data:
    """Return the schema of an object whose keys depend on the bench and whose values are of one kind."""
    return {"type": "object", "additionalProperties": of}


def record(needed: Mapping[str, Data], optional: Mapping[str, Data] | None = None) -> Data:
    """Return the schema of an object with the given required and optional keys."""
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
HITS = record({side: mapping(WHOLE) for side in ("chip", "host")})
LINE = record(
    {"chips": array(TEXT), "host": {"type": ["string", "null"]}, "taken": WHOLE, "given": WHOLE, "dropped": WHOLE},
    {"baud": WHOLE, "format": TEXT, "hits": HITS, "findings": array(FOUND)},
)
PACE = record(
    {"lockstep": BOOLEAN}, {"rate": NUMBER, "events": WHOLE, "late": WHOLE, "worst_us": WHOLE, "lost_us": WHOLE}
)


# ------------------------------------------------------------------------------------------------------- keys, requests
@dataclass(frozen=True)
class Key:
    """A key of a request or of a reply."""

    name: str
    kind: Data
    description: str
    default: str = ""  # for a key that may be left out


@dataclass(frozen=True)
class RequestSpec:
    """A request, as a row; a request with several forms, such as `until`, has one row for each form."""

    do: str
    description: str
    example: Data
    keys: tuple[Key, ...] = ()
    reply: tuple[Key, ...] = ()
    form: str = ""
    reads: bool = False  # the request changes nothing

    @property
    def needs(self) -> list[str]:
        """Names of the required keys."""
        return [key.name for key in self.keys if not key.default]

    @property
    def name(self) -> str:
        """Name of the request in the schema; if there are several forms, the name includes the form: `until_time`."""
        return f"{self.do}_{self.form}" if self.form else self.do


@dataclass(frozen=True)
class EventSpec:
    """An event, as a row: the client receives a line with `event`, `time_ps`, and the keys of the row."""

    event: str
    description: str
    keys: tuple[Key, ...]

    @property
    def name(self) -> str:
        """Name of the event in the schema."""
        return f"{self.event}_event"


A_PIN = Key("pin", PIN, "owner and pin")
A_LEVEL = Key("level", LEVEL, "the electrical level")
A_CHIP = Key("chip", NAME, "its name")
AN_AXIS = Key("axis", WHOLE | {"minimum": 1, "maximum": 16}, "counted from 1", "1")
A_LINE = Key("line", NAME, "its name, or that of any chip on it")
EDGES = ("rises", "falls", "any")
EDGE = Key("edge", {"enum": list(EDGES)}, "the edge", "any")
TIMEOUT = Key("timeout", TIME, "the longest wait", "60 s")
MET = Key("met", BOOLEAN, "whether the condition was met")
WHY = Key("why", TEXT, "for an unmet condition: its faults, and the waits of chips and parts", "where it was met")
START = Key("start", INSTANT, "the window", "0")
STOP = Key("stop", INSTANT, "its end", "now")
