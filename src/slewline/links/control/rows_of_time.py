"""The requests that control time, as rows."""

from __future__ import annotations

from .value_kinds import (
    A_CHIP,
    A_PIN,
    A_RATE,
    AN_AXIS,
    COUNT,
    EDGE,
    INSTANT,
    INTEGER,
    MET,
    NAME,
    NUMBER,
    PIN,
    TEXT,
    TIMEOUT,
    WHOLE,
    WHY,
    Data,
    Key,
    RequestSpec,
    array,
    one_of,
    record,
)

STEPS = ("instruction", "step", "command", "finding")
RATE: Data = {"type": ["string", "number"], "pattern": A_RATE, "examples": ["0.1"], "minimum": 0.001, "maximum": 1000}
MOST_BREAKPOINTS = 256
A_BREAKPOINT = one_of(
    record({"chip": NAME, "address": COUNT}),
    record({"chip": NAME, "position": INTEGER}, {"axis": AN_AXIS.kind}),
    record({"chip": NAME, "register": NAME}, {"axis": AN_AXIS.kind, "value": INTEGER}),
    record({"pin": PIN}, {"edge": EDGE.kind}),
    record({"finding": NAME}),
)
A_BRANCH = record(
    {"number": WHOLE, "parent": {"type": ["integer", "null"]}, "from_ps": WHOLE, "now_ps": WHOLE},
)

REQUESTS = (
    RequestSpec("pause", "Pause time: it then passes only for `step`, `until` and `advance`.", {}),
    RequestSpec(
        "go",
        "Let time pass with the wall clock again.",
        {"rate": "0.1"},
        (Key("rate", RATE, "virtual seconds per second", "as before"),),
        (Key("rate", NUMBER, "the present rate"),),
    ),
    RequestSpec(
        "step",
        "Pause, and let time pass to the next event of a chip.",
        {"chip": "x", "by": "instruction"},
        (A_CHIP, Key("by", {"enum": list(STEPS)}, "the event"), AN_AXIS, TIMEOUT),
        (MET, WHY),
        "chip",
    ),
    RequestSpec(
        "step",
        "Pause, and let time pass to the next edge of a pin.",
        {"pin": "x.mov", "edge": "rises"},
        (A_PIN, EDGE, TIMEOUT),
        (MET, WHY),
        "pin",
    ),
    RequestSpec(
        "until",
        "Wait until an instruction of the stored program begins.",
        {"chip": "x", "address": 7},
        (A_CHIP, Key("address", COUNT, "of the instruction"), TIMEOUT),
        (MET, WHY),
        "instruction",
    ),
    RequestSpec(
        "until",
        "Wait until an instant.",
        {"time": "1.5 s"},
        (Key("time", INSTANT, "since the beginning"),),
        (MET, WHY),
        "time",
    ),
    RequestSpec(
        "breakpoints",
        "Pause whenever one of these is met; they replace the previous ones. Without `breakpoints`, list the present "
        "ones.",
        {"breakpoints": [{"chip": "x", "address": 7}, {"pin": "x.mov", "edge": "falls"}]},
        (
            Key(
                "breakpoints",
                array(A_BREAKPOINT, MOST_BREAKPOINTS),
                "without a value, any change of the register; for a finding, the name of a chip or part, or empty for "
                "all",
                "the present ones",
            ),
        ),
        (Key("breakpoints", array(TEXT), "each in words"), Key("rows", array(A_BREAKPOINT), "each as requested")),
    ),
    RequestSpec(
        "back",
        "Go to an instant of the past, and pause there; the run from there on is a branch.",
        {"time": "50 ms"},
        (
            Key("time", INSTANT, "since the beginning"),
            Key("branch", COUNT, "the branch of the instant", "the one that is shown"),
        ),
        (Key("branch", WHOLE, "the number of the new branch"),),
    ),
    RequestSpec(
        "branches",
        "The branches that were begun, each with its start on its parent and its present time.",
        {},
        (),
        (Key("branches", array(A_BRANCH), "by number; 0 is the first run"), Key("current", WHOLE, "the one shown")),
        reads=True,
    ),
    RequestSpec(
        "branch",
        "Return to a branch in the state in which it was left, and pause there.",
        {"number": 0},
        (Key("number", COUNT, "of the branch"),),
        (Key("branch", WHOLE, "its number"),),
    ),
)
