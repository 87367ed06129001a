"""Files that somebody has changed: hostile values in every key, and mutations; each is read, or refused in words."""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from collections import Counter
from contextlib import suppress
from copy import deepcopy
from inspect import signature
from itertools import chain, islice
from pathlib import Path

import pytest

import slewline
from slewline.bench.files import entries
from slewline.bench.files.tables import Tables, keys_of
from slewline.chips import PARTS, sheet_of
from slewline.errors import SlewlineError
from slewline.parts import KINDS, options_of, part_class
from tests.mutated import HOSTILE, READERS, Samples, Watch, read_mutated, read_watched, spelled

QUICK = 200  # mutated files of each kind
ALL = 50_000  # of all kinds
MOST_KB = 200_000


@pytest.fixture(scope="module")
def samples(tmp_path_factory):
    """A file of every kind, each in a folder of its own."""
    return Samples(tmp_path_factory.mktemp("samples"))


# ------------------------------------------------------------------------------------------------------ mutated files
@pytest.mark.parametrize("kind", READERS)
def test_a_mutated_file_is_read_or_refused_and_nothing_else(samples, kind):
    watch = Watch(samples.folder)
    found = read_mutated(samples, watch, kind, range(QUICK))
    assert found.total() == QUICK and found["read"] and found["refused"]


@pytest.mark.long
@pytest.mark.posix
@pytest.mark.timeout(900)
def test_fifty_thousand_mutated_files():
    ran = subprocess.run(
        [sys.executable, "-m", "tests.mutated", str(ALL)],
        stdout=subprocess.PIPE,
        text=True,
        check=False,
        cwd=Path(__file__).parents[2],
    )
    found = json.loads(ran.stdout)
    assert not found["failures"]
    assert sum(sum(counts.values()) for counts in found["files"].values()) == ALL
    assert found["kb"] < MOST_KB


# --------------------------------------------------------------------------------------------- every key, every reader
def places(value, at=()):
    """Yield the place of every value within JSON, the outermost first."""
    yield at
    inside = value.items() if isinstance(value, dict) else enumerate(value[:3]) if isinstance(value, list) else ()
    for key, each in inside:
        yield from places(each, (*at, key))


def put(value, at, new):
    """Return JSON with another value at a place."""
    if not at:
        return new
    value = deepcopy(value)
    inside = value
    for key in at[:-1]:
        inside = inside[key]
    inside[at[-1]] = new
    return value


def lines_with(data, more=()):
    """Yield lines of JSON, with each hostile value in the place of each value; `more` keys are put into every line."""
    lines = data.splitlines()
    for number, line in enumerate(lines):
        entry = json.loads(line)
        for at in chain(places(entry), ((key,) for key in more if key not in entry)):
            for value in HOSTILE:
                marked = json.dumps(put(entry, at, "\1")).encode()  # JSON has no 1e999, and no brackets without end
                yield b"\n".join(
                    [*lines[:number], marked.replace(b'"\\u0001"', spelled(value)), *lines[number + 1 :], b""]
                )


def toml(tables):
    """Return tables as TOML; a value that it has no spelling for as it is."""
    lines = []
    for name, table in tables.items():
        for each in table if isinstance(table, list) else [table]:
            lines.append(f"[[{name}]]" if isinstance(table, list) else f"[{name}]")
            lines += [f"{key} = {inline(value)}" for key, value in each.items()]
    return ("\n".join(lines) + "\n").encode("utf-8", "replace")


def inline(value):
    """Return a value as TOML has it."""
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {inline(each)}' for key, each in value.items())} }}"
    return (
        "null" if value is None else spelled(value).decode().replace("1e999", "inf").replace('"\\ud800"', '"\\uFFFD"')
    )


def benches(base):
    """Yield the sample with each hostile value in each key that a table may have."""
    for name in Tables.__struct_fields__:
        for key in keys_of([name]) if name != "part" else ("kind", "name", "to", "on", "file", "image", "store"):
            for number in range(len(base[name])) if isinstance(base[name], list) else ("",):
                at = (name, key) if number == "" else (name, number, key)
                for value in HOSTILE:
                    yield toml(put(base, at, value))
    for number in range(3):
        for key in ("straps", "options"):
            for value in HOSTILE:
                yield toml(put(base, ("chip", number, key), {"x": value}))


def options():
    """Yield bench files with each hostile value in each option of each chip and part."""
    for part in PARTS:
        for option in sheet_of(part).options:
            for given in within(option):
                yield toml({"chip": [{"part": part, "options": given}]})
    for kind in KINDS:
        on = {"kind": "motor", "name": "m", "to": "cy545"}
        shaft = {"on": "m"} if kind in ON_A_SHAFT else {}
        for option in options_of_kind(kind):
            for given in within(option):
                part = {"kind": kind} | shaft | needed_by(kind) | given
                yield toml({"chip": [{"part": "cy545"}], "part": [on, part] if shaft else [part]})


NEEDED = {
    "int": 1,
    "float": 1.0,
    "number": 1,
    "time": "1 ms",
    "text": "x",
    "bytes": [1],
    "ints": [1],
    "quantity": 1,
    "bool": True,
    "table": {},
    "object": "x",
}


def options_of_kind(kind):
    """Return the options that a kind of part may be given."""
    return options_of(part_class(kind), KINDS[kind].fixed)


def needed_by(kind):
    """Return a value for each option that a kind of part must have."""
    return {
        row.name: row.choices[0] if row.choices else NEEDED[row.kind] for row in options_of_kind(kind) if row.required
    }


def mounted(bench, kind):
    """Return a part of a kind on a bench, beside the chip x, or on a motor or within wires where it needs them.

    Raises:
        SlewlineError: it does not fit the chip.
    """
    try:
        return bench.part(kind, "p", to=bench["x"], **needed_by(kind))
    except SlewlineError as error:
        if "has no standard wiring" in str(error):
            return bench.part(kind, "p", **needed_by(kind))
        if "needs a shaft" not in str(error):
            raise
        return bench.part(kind, "p", to=bench["x"], on=bench.part("motor", "m", to=bench["x"]), **needed_by(kind))


def inputs(folder):
    """Yield journals in which each argument of each input of each chip, part and host is hostile in its turn."""
    for part in PARTS:
        bench = slewline.Bench(journal=folder / "made.jsonl")
        chip = bench.add(part, "x")
        owners = [chip, *(bench.host(chip, over=channel.name) for channel in chip.sheet.channels)]
        yield from inputs_of(folder, owners)
    for kind in KINDS:
        for part in PARTS:
            bench = slewline.Bench(journal=folder / "made.jsonl")
            bench.add(part, "x")
            with suppress(SlewlineError):
                yield from inputs_of(folder, [mounted(bench, kind)])
                break

    bench = slewline.Bench(journal=folder / "made.jsonl")
    bench.part("gpib_listener", "gpib", to=bench.add("cy525", "x"))
    gpib = [bench.part("gpib_talker", "pet", to="gpib"), bench.part("gpib_controller", "pc", to="gpib")]
    yield from inputs_of(folder, [bench.part("rs232_line", "line"), *gpib])


def inputs_of(folder, owners):
    """Yield journals, each with a call of an input of a chip or part that is on a bench."""
    made = (folder / "made.jsonl").read_bytes()
    for owner in owners:
        for verb in sorted(owner._input_names):
            names = [each for each in signature(getattr(owner, verb)).parameters.values() if each.name != "self"]
            usual = [usually(each) for each in names]
            for at in range(len(usual)):
                for value in HOSTILE:
                    args = (
                        json.dumps([*usual[:at], "\1", *usual[at + 1 :]]).encode().replace(b'"\\u0001"', spelled(value))
                    )
                    call = b'{"do":"input","t":0,"part":"%b","verb":"%b","args":%b}\n' % (
                        owner.name.encode(), verb.encode(), args,
                    )  # fmt: skip
                    yield made + call + b'{"do":"run","t":1000000000,"to":1000000000}\n'


def usually(parameter):
    """Return what a parameter may be."""
    if parameter.name in ("chip", "way"):
        return {"chip": "x", "way": "to_module"}[parameter.name]
    kind = str(parameter.annotation)
    return next((value for word, value in USUAL.items() if word in kind), 1)


USUAL = {
    "Sequence[int]": [1],
    "Sequence[str]": ["0"],
    "Data": "0",
    "Time": "1 ms",
    "str": "0",
    "bool": True,
    "float": 1.0,
}


ON_A_SHAFT = ("switch", "gear", "carriage")


def within(option):
    """Yield each hostile value of an option, and of the rows of a table."""
    for value in HOSTILE:
        yield {option.name: value}
    for row in option.table:
        for given in within(row):
            yield {option.name: given}


QUICKLY = 7  # each seventh, with a number of values that it does not divide: every key, and every value
STEPS = pytest.mark.parametrize("step", [QUICKLY, pytest.param(1, marks=pytest.mark.long)])


def walked(samples, kind, path, made, step=1):
    """Read each of some files, as the watch allows; return how many were read and refused."""
    watch, found = Watch(samples.folder), Counter()
    for data in islice(made, 0, None, step):
        found[read_watched(samples, watch, kind, path, data)] += 1
    return found


@STEPS
@pytest.mark.parametrize("kind", ["dialogue", "journal", "tune log", "black box"])
def test_every_value_of_a_line_may_be_hostile(samples, kind, step):
    for path in samples.paths[kind]:
        more = entries.OPTIONAL if kind == "journal" else ()
        found = walked(samples, kind, path, lines_with(samples.data[path], more), step)
        assert found["refused"]


@STEPS
def test_every_key_of_a_bench_file_may_be_hostile(samples, step):
    (path,) = samples.paths["bench file"]
    base = tomllib.loads(samples.data[path].decode())
    assert walked(samples, "bench file", path, [toml(base)]) == {"read": 1}
    assert len(HOSTILE) % QUICKLY
    assert walked(samples, "bench file", path, benches(base), step)["refused"]


@STEPS
def test_every_option_of_a_chip_and_a_part_may_be_hostile(samples, step):
    (path,) = samples.paths["bench file"]
    assert {*walked(samples, "bench file", path, options(), step)} == {"read", "refused"}


@STEPS
def test_every_argument_of_an_input_may_be_hostile(samples, step, tmp_path):
    (path,) = samples.paths["journal"]
    assert {*walked(samples, "journal", path, inputs(tmp_path), step)} == {"read", "refused"}
