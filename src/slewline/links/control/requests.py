"""The requests of the control port: what each needs and what its reply has, as rows.

The check of a request, the JSON schema and the page of the documentation are made from them; what a request does is the
method of its name in `verbs.py`, `time_verbs.py` and `view_verbs.py`.
"""

from __future__ import annotations

import json

from ...core.messages.near import hint
from ...errors import UsageError
from . import rows, rows_of_time, rows_of_views
from .kinds import TEXT, WHOLE, Data, Key, RequestSpec, record
from .rows_of_events import EVENTS, EventSpec

REQUESTS = (*rows.REQUESTS, *rows_of_time.REQUESTS, *rows_of_views.REQUESTS)
NAMES = tuple(dict.fromkeys(row.do for row in REQUESTS))
READING = frozenset(row.do for row in REQUESTS if row.reads)
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
    made |= {row.name: event_schema(row) for row in EVENTS}
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


def event_schema(row: EventSpec) -> Data:
    """Return the schema of an event."""
    needed = {"event": {"const": row.event}, "time_ps": WHOLE} | {key.name: described(key) for key in row.keys}
    return record(needed) | {"description": row.says}


def described(key: Key) -> Data:
    """Return the kind of a key, with what it means."""
    return key.kind | {"description": key.says}
