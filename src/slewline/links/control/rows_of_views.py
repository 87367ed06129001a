"""Rows: the requests for views of chips and parts, and the events that a subscribed client receives."""

from __future__ import annotations

from .value_kinds import (
    A_CHIP,
    BOOLEAN,
    COUNT,
    EDGE,
    LEVEL,
    NAME,
    NUMBER,
    PIN,
    START,
    STOP,
    TEXT,
    TIME,
    WHOLE,
    Data,
    EventSpec,
    Key,
    RequestSpec,
    array,
    mapping,
    one_of,
    record,
)

OBJECT: Data = {"type": "object"}
WHOLE_OR_NULL: Data = {"type": ["integer", "null"]}
MAX_ENTRIES = 1000
MAX_COLUMNS = 4000
VIEW = record({"pace": OBJECT, "chips": mapping(OBJECT), "parts": mapping(OBJECT), "findings": WHOLE, "entries": WHOLE})
ENTRY = record({"number": WHOLE, "time_ps": WHOLE, "who": TEXT, "kind": TEXT, "text": TEXT}, {"code": TEXT})
SHEET = record(
    {
        "part": TEXT,
        "title": TEXT,
        "manual": TEXT,
        "axes": WHOLE,
        "buffer_bytes": WHOLE,
        "memory_unit": TEXT,
        "pins": array(OBJECT),
        "packages": array(OBJECT),
        "registers": array(OBJECT),
        "commands": array(OBJECT),
        "wires": array(array(TEXT)),
    }
)
PROGRAM_ROW = record({"address": WHOLE, "bytes": TEXT, "text": TEXT}, {"line": WHOLE})
PROBLEM = record({"line": WHOLE, "column": WHOLE, "length": WHOLE, "severity": TEXT, "says": TEXT, "remedy": TEXT})
FORMS = ("vcd", "csv")
AN_EVENT = one_of(
    record({"pin": PIN, "level": LEVEL}),
    record({"pin": PIN}, {"edge": EDGE.kind}),
    record({"quantity": NAME, "value": NUMBER}, {"slope": EDGE.kind}),
    record({"finding": NAME}),
)
SCALAR: Data = {"type": ["string", "number", "boolean"]}
MOST_SIGNALS, MOST_ARGUMENTS = 256, 8
THE_SIGNALS = Key("signals", array(NAME, MOST_SIGNALS), "pins and quantities, as `signals` lists them")

REQUESTS = (
    RequestSpec(
        "describe",
        "The data sheet of a chip: pins, registers, commands.",
        {"chip": "x"},
        (A_CHIP,),
        (Key("sheet", SHEET, "from the manual"),),
        reads=True,
    ),
    RequestSpec(
        "parts",
        "The parts around the chips, with the actions on them.",
        {},
        (),
        (Key("parts", mapping(OBJECT), "by name: kind, pins, verbs, quantities, neighbours"),),
        reads=True,
    ),
    RequestSpec(
        "listing",
        "The stored program of a chip.",
        {"chip": "x"},
        (A_CHIP,),
        (
            Key("rows", array(PROGRAM_ROW), "an instruction each"),
            Key("counter", WHOLE_OR_NULL, "the address of the instruction in progress; null: no program runs"),
        ),
        reads=True,
    ),
    RequestSpec(
        "view", "The complete view of a panel, now.", {}, (), (Key("view", VIEW, "of pace, chips, parts"),), reads=True
    ),
    RequestSpec(
        "subscribe",
        "Send events from now on: changes of the view, entries of the dialogue, and pauses.",
        {"every": "33 ms"},
        (Key("every", TIME, "minimum wall-clock time between two events; 0: send no more"),),
        (Key("view", VIEW, "the present view"),),
        reads=True,
    ),
    RequestSpec(
        "said",
        "The dialogue of hosts and chips, with findings and events; oldest first.",
        {"start": 0},
        (Key("start", COUNT, "the number of the first entry", "0"),),
        (Key("entries", array(ENTRY), f"the last {MAX_ENTRIES}"), Key("omitted", WHOLE, "number of omitted entries")),
        reads=True,
    ),
    RequestSpec(
        "signals",
        "The signals that a scope can show.",
        {},
        (),
        (Key("pins", mapping(array(TEXT)), "by owner"), Key("quantities", array(TEXT), "by full name")),
        reads=True,
    ),
    RequestSpec(
        "record",
        "Record pins from now on.",
        {"pins": ["x.clock", "x.mov"], "keep": "1 h"},
        (Key("pins", array(PIN), "owners and pins"), Key("keep", TIME, "length of the record", "1 h")),
    ),
    RequestSpec(
        "window",
        "The history of signals in a window, reduced to this number of columns.",
        {"signals": ["x.clock", "x.velocity"], "start": 0, "stop": "1 s", "columns": 800},
        (THE_SIGNALS, START, STOP, Key("columns", WHOLE | {"minimum": 1, "maximum": MAX_COLUMNS}, "of the picture")),
        (
            Key(
                "signals",
                mapping(OBJECT),
                "by name. A pin: `times_ps` and `levels`, the first one at the start; or, where it has too many edges, "
                "`columns`, a character each: 0, 1, x (both), - (floats or is not known). A quantity: `unit`, `held`, "
                "`times_ps` and `values`, null at a break",
            ),
        ),
        reads=True,
    ),
    RequestSpec(
        "find",
        "Find the first, or the last, instant of an event in a window.",
        {"on": {"pin": "x.mov", "edge": "falls"}, "start": 0, "stop": "1 s", "last": True},
        (
            Key(
                "on",
                AN_EVENT,
                "the event; for a finding, the name of its source, or empty for all",
            ),
            START,
            STOP,
            Key("last", BOOLEAN, "the last one", "false"),
        ),
        (Key("found_ps", WHOLE_OR_NULL, "null: there is none"),),
        reads=True,
    ),
    RequestSpec(
        "export",
        "Recorded pins as a file.",
        {"signals": ["x.clock"], "start": 0, "stop": "1 s", "form": "vcd"},
        (THE_SIGNALS, START, STOP, Key("form", {"enum": list(FORMS)}, "the format of the file")),
        (Key("text", TEXT, "the content of the file"),),
        reads=True,
    ),
    RequestSpec(
        "send",
        "Send commands to a chip, as its host would: lines of a script.",
        {"chip": "x", "text": "V1"},
        (A_CHIP, Key("text", TEXT, "one command per line")),
    ),
    RequestSpec(
        "act",
        "Operate a part, as an operator would.",
        {"part": "jog", "verb": "cw"},
        (
            Key("part", NAME, "its name"),
            Key("verb", NAME, "the action"),
            Key("args", array(SCALAR, MOST_ARGUMENTS), "the arguments of the verb", "none"),
        ),
    ),
    RequestSpec(
        "assemble",
        "Assemble a program for a chip, and check it for mistakes; it is not sent.",
        {"chip": "x", "text": "Po\nS50\n+400\nE"},
        (A_CHIP, Key("text", TEXT, "one command per line")),
        (
            Key("rows", array(PROGRAM_ROW), "instructions, with their lines"),
            Key("bytes", WHOLE, "the length of the program"),
            Key("problems", array(PROBLEM), "each with its place"),
        ),
        reads=True,
    ),
    RequestSpec(
        "examples", "The examples.", {}, (), (Key("examples", array(OBJECT), "name, part and title"),), reads=True
    ),
    RequestSpec(
        "example",
        "The text of an example.",
        {"name": "programs/weld.cy525"},
        (Key("name", NAME, "of the example"),),
        (Key("text", TEXT, "the content of the file"),),
        reads=True,
    ),
)

# ------------------------------------------------------------------------------------------------------------- events
EVENTS = (
    EventSpec(
        "view",
        "The view of a panel has changed; while time passes, also the time alone, ten times per second.",
        (Key("view", OBJECT, "the changes, in the shape of the reply to `view`; null: removed"),),
    ),
    EventSpec(
        "said",
        "Entries are new, or have grown: a grown entry keeps its number.",
        (Key("entries", array(ENTRY), "as in the reply to `said`"),),
    ),
    EventSpec("stopped", "Time has paused, because a breakpoint was met.", (Key("why", TEXT, "the breakpoint"),)),
    EventSpec(
        "branch",
        "The server shows another branch, or another instant; a complete view follows.",
        (Key("branch", WHOLE, "its number"),),
    ),
)
