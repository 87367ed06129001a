"""The requests for views of chips and parts, and the events that a client receives after `subscribe`, as rows."""

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
        "What the data sheet of a chip says: pins, registers, commands.",
        {"chip": "x"},
        (A_CHIP,),
        (Key("sheet", SHEET, "from the manual"),),
        reads=True,
    ),
    RequestSpec(
        "parts",
        "The parts around the chips, with what can be done to them.",
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
        "view", "Everything that a panel shows, now.", {}, (), (Key("view", VIEW, "of pace, chips, parts"),), reads=True
    ),
    RequestSpec(
        "subscribe",
        "Send events from now on: changes of the view, what is said, stops.",
        {"every": "33 ms"},
        (Key("every", TIME, "the least time between two, of the wall clock; 0: no more"),),
        (Key("view", VIEW, "as it is now"),),
        reads=True,
    ),
    RequestSpec(
        "said",
        "What hosts and chips have said, with findings and events; oldest first.",
        {"start": 0},
        (Key("start", COUNT, "the number of the first entry", "0"),),
        (Key("entries", array(ENTRY), f"the last {MAX_ENTRIES}"), Key("omitted", WHOLE, "how many are left out")),
        reads=True,
    ),
    RequestSpec(
        "signals",
        "What a scope can show.",
        {},
        (),
        (Key("pins", mapping(array(TEXT)), "by owner"), Key("quantities", array(TEXT), "by full name")),
        reads=True,
    ),
    RequestSpec(
        "record",
        "Keep what pins do, from now on.",
        {"pins": ["x.clock", "x.mov"], "keep": "1 h"},
        (Key("pins", array(PIN), "owners and pins"), Key("keep", TIME, "how much of the past", "1 h")),
    ),
    RequestSpec(
        "window",
        "What signals did in a window, thinned to what so many columns can show.",
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
        "Find the first, or the last, instant of a window at which something happens.",
        {"on": {"pin": "x.mov", "edge": "falls"}, "start": 0, "stop": "1 s", "last": True},
        (
            Key(
                "on",
                AN_EVENT,
                "what happens; of a finding, the name of its source, or empty for all",
            ),
            START,
            STOP,
            Key("last", BOOLEAN, "the last one", "false"),
        ),
        (Key("found_ps", WHOLE_OR_NULL, "null: it does not happen there"),),
        reads=True,
    ),
    RequestSpec(
        "export",
        "Recorded pins as a file.",
        {"signals": ["x.clock"], "start": 0, "stop": "1 s", "form": "vcd"},
        (THE_SIGNALS, START, STOP, Key("form", {"enum": list(FORMS)}, "the format of the file")),
        (Key("text", TEXT, "what is in the file"),),
        reads=True,
    ),
    RequestSpec(
        "send",
        "Send commands to a chip, as its host would: lines of a script.",
        {"chip": "x", "text": "V1"},
        (A_CHIP, Key("text", TEXT, "a command a line")),
    ),
    RequestSpec(
        "act",
        "Do something to a part, as a hand would.",
        {"part": "jog", "verb": "cw"},
        (
            Key("part", NAME, "its name"),
            Key("verb", NAME, "what to do"),
            Key("args", array(SCALAR, MOST_ARGUMENTS), "what its verb takes", "none"),
        ),
    ),
    RequestSpec(
        "assemble",
        "Assemble a program for a chip, and look for mistakes; nothing is sent.",
        {"chip": "x", "text": "Po\nS50\n+400\nE"},
        (A_CHIP, Key("text", TEXT, "a command a line")),
        (
            Key("rows", array(PROGRAM_ROW), "instructions, with their lines"),
            Key("bytes", WHOLE, "how long the program is"),
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
        (Key("text", TEXT, "what is in the file"),),
        reads=True,
    ),
)

# ------------------------------------------------------------------------------------------------------------- events
EVENTS = (
    EventSpec(
        "view",
        "Something that a panel shows has changed; while time passes, also that alone, ten times a second.",
        (Key("view", OBJECT, "what has changed, in the shape of the reply to `view`; null: it is gone"),),
    ),
    EventSpec(
        "said",
        "Entries are new, or have grown: one that has grown has the number that it had.",
        (Key("entries", array(ENTRY), "as in the reply to `said`"),),
    ),
    EventSpec("stopped", "Time stands, because a breakpoint is met.", (Key("why", TEXT, "which one"),)),
    EventSpec(
        "branch",
        "The server shows another branch, or another instant; a whole view follows.",
        (Key("branch", WHOLE, "its number"),),
    ),
)
