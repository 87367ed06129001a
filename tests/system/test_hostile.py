"""Bench files, journals, URLs and the files beside them may come from anybody: they run no code of their own."""

from __future__ import annotations

import ast
import json
import os
import re
import sys
from pathlib import Path

import pytest
import serial

import slewline
import slewline.testing  # pySerial knows slewline:// from now on
from slewline.bench.files import entries
from slewline.build import Part, from_outside
from slewline.chips import PARTS, chip_class
from slewline.core.component import input_of
from slewline.errors import LONGEST_LINE, BenchFileError, SlewlineError, UsageError
from slewline.links.lines.memory_file import FileStore, packed
from slewline.parts import KINDS, part_class
from tests.cli.conftest import installed  # noqa: F401  (a fixture)
from tests.sources import text, tree

SOURCES = Path(__file__).parents[2] / "src/slewline"
HEAD = {"do": "journal", "t": 0, "version": 1, "seed": 0}
ADD = {"do": "add", "t": 0, "part": "cy525", "behaviour": slewline.Bench().add("cy525").sheet.behaviour, "name": "x"}
ADD |= {"crystal_hz": None, "straps": {}, "bare": False, "options": {}}
HOST = {"do": "host", "t": 0, "name": "pc", "chips": ["x"], "delay_ps": 0}
MOTOR = {"do": "part", "t": 0, "kind": "motor", "name": "m", "to": None, "options": {}}


def told(part, verb, *args):
    return {"do": "input", "t": 0, "part": part, "verb": verb, "args": args}


def called(host, do, *args):
    return {"do": do, "t": 0, "host": host, "args": args}


def replayed(*entries):
    Path("j.jsonl").write_text("\n".join(json.dumps(entry) for entry in (HEAD, *entries)) + "\n")
    return slewline.replay("j.jsonl")


@pytest.fixture(autouse=True)
def mark(tmp_path, monkeypatch):
    """A folder with a module `evil` that leaves a file when its code runs; the file."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    mark = tmp_path / "it-ran"
    code = f"open({str(mark)!r}, 'w').close()\n"
    (tmp_path / "evil.py").write_text(code)
    (tmp_path / "evils").mkdir()
    for name in ("__init__", "x", "cy525"):
        (tmp_path / f"evils/{name}.py").write_text(code)
    yield mark
    nothing_ran(mark)


def nothing_ran(mark):
    """Fail where a module of that folder has been imported."""
    assert not mark.exists()
    for name in [name for name in sys.modules if name.split(".")[0] in ("evil", "evils")]:
        del sys.modules[name]
        pytest.fail(f"{name} was imported")


# --------------------------------------------------------------------------------------------- a journal calls inputs
NO_INPUTS = [
    ("pc", "send", ["A 0\r"]),  # the face of a host; what reports is `write`
    ("pc", "do", [None]),
    ("pc", "work", ["text", None]),
    ("pc", "__init__", [None, "pc", []]),
    ("pc", "__setattr__", ["name", "x"]),
    ("pc", "__class__", []),
    ("pc", "errand", ["text", "evil"]),
    ("m", "take_pin", ["a", "b"]),
    ("m", "finding", ["code", "text"]),
    ("x", "reset", []),
    ("x", "power", [False]),
    ("x", "start", []),
    ("x", "fail_eeprom", [True]),  # of another chip
    ("x", "from_outside", []),
    ("x", "", []),
    ("x", None, []),
    ("x", ["reset"], []),
]


def test_a_journal_calls_no_method_but_inputs(subtests):
    for part, verb, args in NO_INPUTS:
        with subtests.test(part=part, verb=verb):
            with pytest.raises(BenchFileError, match=r"journal j.jsonl, line 5: ") as error:
                replayed(ADD, HOST, MOTOR, told(part, verb, *args))
            assert "is not an input; allowed " in str(error.value) or "input: verb: found " in str(error.value)


def test_an_attribute_of_a_bench_is_not_a_part():
    for name in ("kernel", "outside", "__class__", "random"):
        with pytest.raises(BenchFileError, match=f"has no .*{name}"):
            replayed(ADD, told(name, "write", "x"))


OF_BEFORE = [
    called("pc", "call", "do", "x", "evil"),
    called("pc", "call", "__init__", "x"),
    called("pc", "call", "to", "x"),
    called("pc", "call", "send", "x", "A"),
    called("m", "call", "verify", "x"),
    called("m", "clear"),
    called("x", "drop"),
    called("pc", "rest"),
    called("pc", "eval", "1"),
    {"do": "evil:X", "t": 0},
    {"do": "power", "t": 0, "chip": "m", "on": True},
    {"do": "connect", "t": 0, "part": "pc", "chips": ["x"]},
]


def test_calls_in_earlier_journals_are_a_list_too(subtests):
    for entry in OF_BEFORE:
        with subtests.test(entry=entry), pytest.raises(BenchFileError, match=r"journal j.jsonl, line 5: "):
            replayed(ADD, HOST, MOTOR, entry)


def test_inputs_allowed_by_a_list_are_replayed():
    bench = replayed(ADD, HOST, told("pc", "write", "x", [ord("A"), ord("\r")]), called("pc", "call", "verify", "x", 0))
    assert not bench["pc"].idle


def test_every_chip_and_part_declares_the_methods_that_report():
    declared = set()
    for path in SOURCES.rglob("*.py"):
        for cls in ast.walk(tree(path)) if "self.input(" in text(path) else ():
            for function in cls.body if isinstance(cls, ast.ClassDef) else ():
                verbs = {
                    ast.literal_eval(call.args[0])
                    for call in ast.walk(function)
                    if isinstance(call, ast.Call) and ast.unparse(call.func) == "self.input"
                }
                if verbs:
                    assert verbs == {function.name}, path
                    assert "from_outside" in [ast.unparse(one) for one in function.decorator_list], path
                    declared.add((cls.name, function.name))
    assert len(declared) > 30
    for cls in [*map(part_class, KINDS), *map(chip_class, PARTS)]:
        for verb in {verb for name, verb in declared if name in [base.__name__ for base in cls.__mro__]}:
            assert callable(input_of(object.__new__(cls), verb))


class Bell(Part):
    """A part of one's own."""

    rung = 0

    @from_outside
    def ring(self, times: int) -> None:
        """Ring."""
        self.input("ring", times)
        self.rung += times

    def knock(self) -> None:
        """Report what is not declared."""
        self.input("knock")


class LoudBell(Bell):
    """It need not declare again what it inherits."""

    def ring(self, times: int) -> None:
        """Ring louder."""
        self.input("ring", times)
        self.rung += 2 * times


def test_a_custom_part_declares_its_inputs():
    bench = slewline.Bench(journal="j.jsonl")
    bench.part(LoudBell, "bell").ring(2)
    again = slewline.replay("j.jsonl", allow_code=True)
    assert bench["bell"].rung == again["bell"].rung == 4
    with pytest.raises(
        UsageError,
        match=r"bell: 'knock' is not an input; allowed ring; declare a method of your own with @from_outside",
    ):
        bench["bell"].knock()


# ------------------------------------------------------------------------------------- names, options, files of a bench
NAMES = (
    "evil:X", "evils.x:X", "evils.cy525:Cy525", "evil:", ":evil", "evil", "evils.x", "evil:X:Y", " evil:X", "evil :X",
    "evil/x:X", "../evil:X", "./evil.py:X", "evil.py", "evil\n:X", "slewline.cli.main:main", "os:system",
    "builtins:exec", "slewline.chips.cy525:Cy525",
    "..evil:X", "CY525:evil", "cy525\x00evil:X", "cy525.evil", "entry_points", "",
)  # fmt: skip


def test_no_name_of_a_file_a_journal_or_a_url_imports(subtests, mark):
    for name in NAMES:
        with subtests.test(repr(name)):
            text = json.dumps(name)
            for table in (f"[[chip]]\npart = {text}\n", f"[[part]]\nkind = {text}\n"):
                Path("b.toml").write_text(table)
                with pytest.raises(SlewlineError):
                    slewline.load("b.toml")
            with pytest.raises(BenchFileError):
                replayed(ADD | {"part": name})
            with pytest.raises(BenchFileError):
                replayed(MOTOR | {"kind": name})
            with pytest.raises((SlewlineError, ValueError)):
                serial.serial_for_url(f"slewline://{name}")
            nothing_ran(mark)


TABLES = [
    '[[chip]]\npart = ["evil:X"]\n',
    '[[chip]]\npart = {module = "evil"}\n',
    '[[chip]]\npart = "cy525"\nclass = "evil:X"\n',
    '[[chip]]\npart = "cy525"\noptions = {store = "evil:X"}\n',
    '[[chip]]\npart = "gs-c200"\noptions = {store = "/etc/passwd"}\n',
    '[[chip]]\npart = "gs-c200"\noptions = {store = "evil.py"}\n',
    '[[chip]]\npart = "gs-c200"\noptions = {law = "evil:X"}\n',
    '[[chip]]\npart = "gs-c200"\noptions = {kernel = "evil:X"}\n',
    '[[chip]]\npart = "cy525"\nallow_code = true\n',
    '[bench]\nallow_code = true\n[[chip]]\npart = "evil:X"\n',
    '[[part]]\nkind = "inverter"\nto = "evil:X"\n',
    '[[part]]\nkind = "inverter"\nto = ["evil:X"]\n',
    '[[part]]\nkind = "switch"\non = "evil:X"\n',
    '[[part]]\nkind = "inverter"\nallow_code = true\n',
    '[[part]]\nkind = "prom"\ndata = {file = "evil.py"}\n',
    '[[chip]]\npart = "cy525"\n[[host]]\nover = "evil:X"\nscript = "A 0"\n',
    '[[chip]]\npart = "cy525"\n[[host]]\nname = "evil:X"\nscript = "A 0"\n',
    '[[chip]]\npart = "cy525"\n[[host]]\nscript = "@evil"\n',
    '[[chip]]\npart = "cy525"\n[[host]]\nscript = "@tell evil:X ring"\n',
    '[[chip]]\npart = "cy525"\n[[part]]\nkind = "encoder"\nname = "e"\n[[host]]\nscript = "@tell e __init__"\n',
    '[[chip]]\npart = "cy525"\n[[part]]\nkind = "encoder"\nname = "e"\n[[host]]\nscript = "@tell e power"\n',
    '[[chip]]\npart = "cy525"\n[[host]]\nscript = "@include evil.py"\n',
    '[[chip]]\npart = "cy525"\n[[host]]\nfile = "/etc/hostname"\n',
    '[[chip]]\npart = "cy525"\n[[wire]]\nfrom = "x.__class__"\nto = "x.abort"\n',
]


def test_no_key_of_a_bench_file_imports_opens_or_calls(subtests, mark):
    for table in TABLES:
        with subtests.test(table):
            Path("b.toml").write_text(table)
            with pytest.raises(SlewlineError):
                slewline.load("b.toml")
            nothing_ran(mark)


QUERIES = [
    *(
        "journal=it-ran",
        "stores=evil:X",
        "law=evil:X",
        "module=evil",
        "entry=evil:X",
        "allow_code=1",
        "kernel=evil:X",
    ),
    *("prepare=evil:X", "part=evil:X", "straps=evil:X", "self=evil:X", "bare=1", "store=none/x", "store=evils"),
]


def test_no_query_of_a_url_imports(subtests):
    for query in QUERIES:
        with subtests.test(query=query), pytest.raises(ValueError, match=query.partition("=")[0]):
            serial.serial_for_url(f"slewline://gs-c200?{query}", 9600, timeout=1)


def test_a_store_of_a_url_overwrites_nothing_but_memories():
    before = Path("evil.py").read_bytes()
    with serial.serial_for_url("slewline://gs-c200?store=evil.py", 9600, timeout=2) as port:
        for line in (b"P\r", b"E\r", b"M\r"):
            port.write(line)
            port.read_until(b"\r")
    assert Path("evil.py").read_bytes() == before


def test_no_option_of_a_journal_imports_or_opens(mark):
    for options in ({"store": str(mark)}, {"store": {"evil": 1}}, {"store": [300]}, {"law": "evil:X"}, {"name": "y"}):
        with pytest.raises(BenchFileError):
            replayed(ADD | {"part": "gs-c200", "behaviour": chip_class("gs-c200").sheet.behaviour, "options": options})


@pytest.mark.parametrize(
    "content",
    [b"cos\nsystem\n(S'touch it-ran'\ntR.", b"evil:X", b"#!/bin/sh\ntouch it-ran\n"],
    ids=["pickle", "name", "sh"],
)
def test_a_state_file_is_never_code_whatever_its_content(content):
    state = Path("x.eeprom")
    state.write_bytes(content)
    with pytest.raises(SlewlineError, match=r"x.eeprom is not a slewline memory"):
        FileStore(state).read()
    state.write_bytes(packed(content))  # and where it is one, it is what it is
    assert FileStore(state).read() == content


DRIVE, POWER = {"do": "drive", "t": 5, "pin": "x.abort", "level": 0}, {"do": "power", "t": 0, "chip": "x", "on": True}
WIRE = {"do": "wire", "t": 0, "a": "x.slew", "b": "x.abort", "invert": False}
RUN, SAID = {"do": "run", "t": 9, "to": 9}, called("pc", "send", "x", "41")
KINDS_OF_ENTRY = [HEAD, ADD, HOST, MOTOR, POWER, WIRE, SAID, DRIVE, DRIVE | {"round": 1}, RUN, told("x", "reset")]
KEPT = {"do", "to", "behaviour"}  # of a motor it may be left out, and so may the behaviour


def entry_of_no_sense(entry, name, value):
    """A field of an entry, missing or of another type: a message of ours, or a run."""
    changed = entry | {name: value} if value != "gone" else {key: entry[key] for key in entry if key != name}
    before = [each for each in (HEAD, ADD, HOST) if each["do"] != entry["do"]]
    lines = [changed, *before[1:]] if entry is HEAD else [*before, changed]
    lines.append(RUN | {"t": 10**9, "to": 10**9})
    Path("j.jsonl").write_text("\n".join(map(json.dumps, lines)) + "\n")
    try:
        slewline.replay("j.jsonl")
    except BenchFileError as error:
        assert str(error).startswith("journal j.jsonl")
        assert name == "args" or "Error(" not in str(error), "it is told in our words"
        assert len(str(error)) < LONGEST_LINE + 50
    else:
        assert name in ("slewline", "round", "name", "args", "verb") or value in (None, True, {}, []), changed


def test_a_malformed_entry_is_reported_with_its_line(subtests):
    for number, entry in enumerate(KINDS_OF_ENTRY):
        for value in (None, "gone", [], {}, 1.5, True, -1, 10**30, "x" * 100_000):
            with subtests.test(number=number, do=entry["do"], value=str(value)[:6]):
                for name in entry.keys() - KEPT:
                    entry_of_no_sense(entry, name, value)


NEEDS = [
    ({"do": "drive", "t": 0, "round": 1, "pin": "x.abort"}, "line 3: drive: needs level, 0, 1 or null"),
    (DRIVE | {"level": 2}, "line 3: drive: level: found 2; allowed 0, 1 or null"),
    (DRIVE | {"level": True}, "line 3: drive: level: found true; allowed 0, 1 or null"),
    (DRIVE | {"t": -1}, "line 3: drive: t: found -1; allowed picoseconds, 0 to 9223372036854775807"),
    (DRIVE | {"t": 1.5}, "line 3: drive: t: found 1.5; allowed picoseconds"),
    (DRIVE | {"t": 5, "round": 1, "pin": "x.bell"}, "line 3: x (cy525) has no pin 'bell'; its pins"),
    (POWER | {"chip": "y"}, "line 3: the bench has no 'y'; available: x"),
    (ADD | {"t": 0, "crystal_hz": "fast"}, 'line 3: add: crystal_hz: found "fast"; allowed a whole number or null'),
    ({"do": "dance", "t": 0}, "line 3: unknown entry 'dance'; allowed journal, add, part, host"),
]


def test_an_entry_is_reported_with_its_needs(subtests):
    for entry, says in NEEDS:
        place = re.escape(f"journal j.jsonl, {says}")
        with subtests.test(says), pytest.raises(BenchFileError, match=place):
            replayed(ADD, entry)


def test_a_journal_entry_of_the_past_is_reported():
    with pytest.raises(BenchFileError, match="line 4: run: t 3 is before 5, the t of the entry above"):
        replayed(ADD, DRIVE, RUN | {"t": 3})


@pytest.mark.parametrize("seed", ["gone", "a", None, [], 0.5])
def test_the_first_entry_has_a_seed(seed):
    head = {key: HEAD[key] for key in HEAD if key != "seed"} | ({} if seed == "gone" else {"seed": seed})
    Path("j.jsonl").write_text(json.dumps(head) + "\n")
    with pytest.raises(
        BenchFileError, match=r"journal j.jsonl, line 1: journal: (needs seed, a|seed: found .*; allowed a)"
    ):
        slewline.replay("j.jsonl")


@pytest.mark.parametrize("first", [b"", json.dumps(HEAD).encode() + b"\n"])
def test_an_endless_line_of_a_journal_is_not_read(monkeypatch, first):
    monkeypatch.setattr(entries, "LONGEST", 1 << 16)
    Path("j.jsonl").write_bytes(first)
    os.truncate("j.jsonl", 1 << 24)
    with pytest.raises(BenchFileError, match=rf"j.jsonl, line {1 + bool(first)}: not a journal entry: \\x00\\x00"):
        slewline.replay("j.jsonl")


@pytest.mark.parametrize("line", ["[" * 100_000, '{"do": "run", "t": ' + "9" * 5000 + "}", "9" * 5000])
def test_a_line_beyond_every_reader_is_not_a_journal_entry(line):
    Path("j.jsonl").write_text(json.dumps(HEAD) + "\n" + line + "\n")
    with pytest.raises(BenchFileError, match=r"j.jsonl, line 2: not a journal entry: "):
        slewline.replay("j.jsonl")
