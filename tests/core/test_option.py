"""Options as rows: what is allowed, what a text stands for, what is said of a wrong one."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

from slewline.core.datasheet.option import Option, checked, flat, read
from slewline.errors import UsageError
from tests.rows import rows

LOAD = Option(
    "load",
    "table",
    {},
    "what the motor drives",
    table=(
        Option("inertia", "float", 2.5, "of all that turns", low=0, unit="kg m2"),
        Option("rates", "ints", (), "of the table", low=1),
        Option("gear", "table", {}, "between", table=(Option("teeth", "int", 20, "of the wheel", low=3),)),
    ),
)
ROWS = (
    Option("slow", "bool", False, "slowly"),
    Option("count", "int", 3, "how many", low=1, high=9, unit="turns"),
    Option("odd", "int", 1, "an odd number", check=lambda number: "" if number % 2 else f"{number} is even"),
    Option("volts", "float", 5, "supply", unit="V"),
    Option("baud", "number", 9600, "rate", low=1),
    Option("lag", "time", "1 us", "lag", low=1),
    Option("wait", "time", 0, "wait", high=10**9),
    Option("clock", "frequency", "2 MHz", "clock", low=1000, unit="Hz"),
    Option("version", "text", "2.1", "version", like="'2.1'"),
    Option("stop", "choice", 1, "stop bits", choices=(1, "1.5", 2)),
    Option("pins", "ints", (1, 2), "numbers", low=1, high=8),
    Option("image", "bytes", b"", "bytes"),
    Option("law", "object", "steady", "law", choices=("steady",), check=lambda law: "" if callable(law) else "no law"),
    Option("address", "int", None, "address", low=0, none=True),
    LOAD,
)
DEFAULT_LOAD = {"inertia": 2.5, "rates": (), "gear": {"teeth": 20}}


def test_omitted_options_have_their_default_tables_too():
    found = checked("x", ROWS, {"load": {"gear": {"teeth": 7}}})
    assert found == {row.name: row.default for row in ROWS} | {"load": DEFAULT_LOAD | {"gear": {"teeth": 7}}}
    assert checked("x", ROWS, {})["load"] == DEFAULT_LOAD


@rows(
    ("name", "value", "kept"),
    [
        ("slow", True, True),
        ("count", 9, 9),
        ("odd", 7, 7),
        ("volts", -3, -3),
        ("baud", "37.5", "37.5"),
        ("lag", "1 ps", "1 ps"),
        ("wait", "1 ms", "1 ms"),
        ("clock", "1 kHz", "1 kHz"),
        ("stop", "2", 2),
        ("stop", "1.5", "1.5"),
        ("pins", [3, 1], (3, 1)),
        ("pins", {3, 1}, (1, 3)),
        ("image", "A 0\r", "A 0\r"),
        ("image", [0, 255], [0, 255]),
        ("law", "steady", "steady"),
        ("law", max, max),
        ("address", None, None),
        ("address", 0, 0),
    ],
)
def test_allowed_options_are_kept(name, value, kept):
    assert checked("x", ROWS, {name: value})[name] == kept


def test_integers_of_numpy_are_whole_numbers_and_become_plain_ones():
    found = checked("x", ROWS, {"count": np.int64(9), "pins": (np.uint8(3), 1), "wait": np.int64(5000)})
    assert {name: repr(found[name]) for name in ("count", "pins", "wait")} == {
        "count": "9",
        "pins": "(3, 1)",
        "wait": "5000",
    }
    with pytest.raises(UsageError, match=r"x: slow np.True_; allowed True, False"):
        checked("x", ROWS, {"slow": np.bool_(True)})


@rows(
    ("name", "value", "says"),
    [
        ("slow", "no", "x: slow 'no'; allowed True, False"),
        ("slow", 1, "x: slow 1; allowed True, False"),
        ("count", True, "x: count True; allowed 1..9 turns"),
        ("count", 0, "x: count 0; allowed 1..9 turns"),
        ("count", 10, "x: count 10; allowed 1..9 turns"),
        ("count", 2.0, "x: count 2.0; allowed 1..9 turns"),
        ("odd", 4, "x: odd 4; 4 is even"),
        ("odd", "3", "x: odd '3'; allowed a whole number"),
        ("volts", "5", "x: volts '5'; allowed a number (V)"),
        ("volts", True, "x: volts True; allowed a number (V)"),
        ("volts", float("nan"), "x: volts nan; allowed a number (V)"),
        ("volts", float("inf"), "x: volts inf; allowed a number (V)"),
        ("baud", 37.5, "x: baud 37.5; allowed 1 or more, such as 9600 or '37.5'"),
        ("baud", "fast", "x: baud 'fast'; allowed 1 or more, such as 9600 or '37.5'"),
        ("lag", 0, "x: lag 0; allowed more than 0, such as '20 ms'"),
        ("lag", 5, "x: lag 5; time 5: a bare number is picoseconds; write its unit, such as '5 ms' or '5 ps'"),
        ("lag", True, "x: lag True; allowed more than 0, such as '20 ms'"),
        ("wait", "2 ms", "x: wait '2 ms'; allowed up to 1 ms, such as '20 ms'"),
        ("clock", "1 Hz", "x: clock '1 Hz'; allowed 1000 or more Hz, such as '11 MHz'"),
        ("version", 2.1, "x: version 2.1; allowed text such as '2.1'"),
        ("stop", 3, "x: stop 3; allowed 1, 1.5, 2"),
        ("stop", True, "x: stop True; allowed 1, 1.5, 2"),
        ("stop", 1.5, "x: stop 1.5; allowed 1, 1.5, 2"),
        ("pins", [0], "x: pins [0]; allowed whole numbers, each 1..8"),
        ("pins", 3, "x: pins 3; allowed whole numbers, each 1..8"),
        ("pins", "12", "x: pins '12'; allowed whole numbers, each 1..8"),
        ("image", [256], "x: image [256]; allowed text, bytes, or whole numbers from 0 to 255"),
        ("image", [-1], "x: image [-1]; allowed text, bytes, or whole numbers from 0 to 255"),
        ("image", 5, "x: image 5; allowed text, bytes, or whole numbers from 0 to 255"),
        ("law", "quick", "x: law 'quick'; no law"),
        ("address", -1, "x: address -1; allowed 0 or more, None"),
        ("count", None, "x: count None; allowed 1..9 turns"),
        ("load", 5, "x: load 5; allowed a table of inertia, rates, gear"),
        ("load", {"inertia": -1}, "x: load: inertia -1; allowed 0 or more kg m2"),
        (
            "load",
            {"inertial": 1},
            "x: load: no option 'inertial'; its options: inertia, rates, gear; did you mean",
        ),
        ("load", {"gear": {"teeth": 2}}, "x: load: gear: teeth 2; allowed 3 or more"),
        ("cuont", 3, "x: no option 'cuont'; its options: slow, count, odd"),
        ("inertia", 1, "; did you mean load.inertia?"),
    ],
)
def test_disallowed_options_are_refused_with_the_allowed_ones(name, value, says):
    with pytest.raises(UsageError, match=re.escape(says)):
        checked("x", ROWS, {name: value})


def test_a_missing_required_option_is_requested():
    row = Option("image", "bytes", ..., "what it holds")
    assert row.required and row.shown == "" and row.data()["required"] and row.data()["default"] is None
    assert checked("x", [row], {"image": b"A"}) == {"image": b"A"}
    with pytest.raises(UsageError, match="x needs the option image: text, bytes"):
        checked("x", [row], {})


@rows(
    ("name", "text", "value"),
    [
        ("slow", "true", True),
        ("slow", "False", False),
        ("slow", "1", "1"),
        ("count", "7", 7),
        ("odd", "-3", -3),
        ("odd", "0x11", 17),
        ("count", "7.0", "7.0"),
        ("volts", "4.5", 4.5),
        ("baud", "37.5", "37.5"),
        ("lag", "20 ms", "20 ms"),
        ("lag", "2000", 2000),
        ("clock", "3000", 3000),
        ("version", "2.1", "2.1"),
        ("stop", "2", "2"),
        ("pins", "3, 1", (3, 1)),
        ("pins", "", ()),
        ("image", "A 0", "A 0"),
        ("address", "none", None),
        ("count", "none", "none"),
        ("load.inertia", "1e-5", {"inertia": 1e-5}),
        ("load.gear.teeth", "9", {"gear": {"teeth": 9}}),
        ("load", "9", "9"),
        ("count.x", "9", "9"),
        ("nothing", "9", "9"),
    ],
)
def test_a_text_is_what_its_row_makes_of_it(name, text, value):
    whole = name if name == "count.x" else name.partition(".")[0]
    assert read(ROWS, [(name, text)]) == {whole: value}


def test_keys_of_one_table_come_together_and_a_table_that_is_text_is_refused():
    pairs = [("load.inertia", "1"), ("count", "2"), ("load.rates", "5,6"), ("load.gear.teeth", "8")]
    assert checked("x", ROWS, read(ROWS, pairs))["load"] == {"inertia": 1.0, "rates": (5, 6), "gear": {"teeth": 8}}
    with pytest.raises(UsageError, match="x: load '3'; allowed a table"):
        checked("x", ROWS, read(ROWS, [("load.inertia", "1"), ("load", "3")]))


def test_defaults_are_allowed_and_rows_are_plain_data():
    for name, row in flat(ROWS):
        assert row.table or row.checked("x", row.default) == row.default, name
    data = json.loads(json.dumps([row.data() for row in ROWS]))
    assert [row["name"] for row in data] == [row.name for row in ROWS]
    assert [row["name"] for row in data[-1]["table"]] == ["inertia", "rates", "gear"]


def test_names_of_rows_in_tables_have_dots():
    assert [name for name, _ in flat([LOAD])] == ["load", "load.inertia", "load.rates", "load.gear", "load.gear.teeth"]


def test_defaults_are_shown_in_words():
    shown = {row.name: row.shown for row in ROWS}
    assert (shown["slow"], shown["lag"], shown["wait"], shown["load"]) == ("False", "'1 us'", "0", "")
    assert Option("t", "time", 1_200_000_000_000, "").shown == "1.2 s"
