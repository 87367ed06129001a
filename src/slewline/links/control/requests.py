"""The requests of the control port, as rows: the keys of each request and of its reply.

The JSON schema and the documentation page are generated from these rows, and `validator.py` checks each request
against the schema.  The handler of the request `drive` is the method `do_drive`, and so on, in `pin_verbs.py`,
`time_verbs.py` or `view_verbs.py`.
"""

from __future__ import annotations

from functools import cache

from ...core.messages.near import hint
from ...errors import UsageError
from . import rows_of_pins, rows_of_time, rows_of_views
from .rows_of_views import EVENTS
from .validator import as_object, check, shown
from .value_kinds import TEXT, WHOLE, Data, EventSpec, Key, RequestSpec, record

REQUESTS = (*rows_of_pins.REQUESTS, *rows_of_time.REQUESTS, *rows_of_views.REQUESTS)
NAMES = tuple(dict.fromkeys(row.do for row in REQUESTS))
READING = frozenset(row.do for row in REQUESTS if row.reads)
COMMON = (
    Key("id", {}, "any value; the reply repeats it", "nothing"),
    Key("token", TEXT, "required in the first request, if the server has one", "nothing"),
)


def read(line: bytes) -> Data:
    """Return the request in a line, after checking it.

    Raises:
        UsageError: the line is not a JSON object with a known "do", or a key or value is not allowed.
    """
    request = as_object(line)
    do = request.get("do")
    if not isinstance(do, str) or do not in NAMES:
        near = hint(do, NAMES) if isinstance(do, str) else ""
        raise UsageError(f"do: {shown(do)}; allowed {', '.join(NAMES)}{near}")
    found: Data = check(request, kind_of(do), do)
    return found


@cache
def kind_of(do: str) -> Data:
    """Return the schema of all forms of the request with a given `do`."""
    return {"oneOf": [request_schema(row) for row in REQUESTS if row.do == do]}


# -------------------------------------------------------------------------------------------------------------- schema
def schema() -> Data:
    """Return the JSON schema of requests, replies and events; `definitions` has `drive`, `drive_reply` etc."""
    made: Data = {row.name: request_schema(row) for row in REQUESTS}
    made |= {f"{row.name}_reply": reply_schema(row) for row in REQUESTS}
    made |= {row.name: event_schema(row) for row in EVENTS}
    made["error"] = record({"error": TEXT, "time_ps": WHOLE}, {"id": {}})
    made["request"] = {"oneOf": [{"$ref": f"#/definitions/{row.name}"} for row in REQUESTS]}
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "slewline control port",
        "description": "One line of text each: a request is an object, and so is its reply, or an error.",
        "definitions": made,
    }


def request_schema(row: RequestSpec) -> Data:
    """Return the schema of a request."""
    needed = {"do": {"const": row.do}} | {key.name: described(key) for key in row.keys if not key.default}
    optional = {key.name: described(key) for key in (*row.keys, *COMMON) if key.default}
    return record(needed, optional) | {"additionalProperties": False, "description": row.description}


def reply_schema(row: RequestSpec) -> Data:
    """Return the schema of a successful reply to a request; later versions may add keys."""
    always = {key.name: described(key) for key in row.reply if not key.default}
    sometimes = {key.name: described(key) for key in row.reply if key.default}
    return record(always | {"time_ps": WHOLE}, sometimes | {"id": {}})


def event_schema(row: EventSpec) -> Data:
    """Return the schema of an event."""
    needed = {"event": {"const": row.event}, "time_ps": WHOLE} | {key.name: described(key) for key in row.keys}
    return record(needed) | {"description": row.description}


def described(key: Key) -> Data:
    """Return the schema for the value of a key, with the description of the key."""
    return key.kind | {"description": key.description}
