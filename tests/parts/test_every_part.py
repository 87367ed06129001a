"""What every kind of part has to do with its options, whatever it is: a suite over KINDS."""

from __future__ import annotations

from inspect import signature

import pytest

import slewline
from slewline.core.datasheet.option import Option, checked, flat
from slewline.parts import CATALOGUE, KINDS, ListedPart, options_of, part_class
from slewline.parts.base.part import Part
from tests.options import wrong_options
from tests.rows import rows

every_kind = rows("kind", KINDS)
NEEDS = {"prom": {"image": ""}, "switch": {"low": 0}}  # what a part must be told
RESERVED = {"kind", "name", "to", "on", "kernel"}  # keys of [[part]] and arguments of the constructor


def rows_of(kind):
    """The options that a user may give."""
    return options_of(part_class(kind), KINDS[kind].fixed)


def placed(kind, bench=None, **options):
    """A part of a kind, on a shaft if it needs one."""
    bench = bench or slewline.Bench()
    on = bench.part("translator") if part_class(kind).sits == "must" and not bench.parts else None
    on = on or next(iter(bench.parts.values()), None) if part_class(kind).sits == "must" else None
    return bench.part(kind, "p", on=on, **{**NEEDS.get(kind, {}), **options})


@every_kind
def test_a_constructor_takes_what_the_rows_say(kind):
    rows, fixed = rows_of(kind), KINDS[kind].fixed
    parameters = [name for name in signature(part_class(kind)).parameters if name not in {*RESERVED, *fixed}]
    assert parameters == [row.name for row in rows]
    for _, row in flat(rows):
        assert row.name not in RESERVED and row.description
        if not (row.required or row.table):
            assert row.checked("p", row.default) == row.default


@every_kind
def test_unknown_and_ill_typed_options_are_refused_without_a_trace(kind):
    bench = slewline.Bench()
    if part_class(kind).sits == "must":
        bench.part("translator")
    before = dict(bench.parts)
    for options, says in wrong_options(rows_of(kind)):
        with pytest.raises(slewline.UsageError, match=f"p: {says}"):
            placed(kind, bench, **options)
    assert bench.parts == before


class Loaded(Part):
    """A part with a table among its options."""

    options = (
        Option(
            "load",
            "table",
            {},
            "what the motor drives",
            table=(
                Option("inertia", "float", 0.0, "of all that turns", low=0, unit="kg m2"),
                Option("teeth", "int", 20, "of the wheel", low=3),
            ),
        ),
        Option("lag", "time", "1 us", "of the shaft", low=1),
    )

    def __init__(self, kernel, name, *, load, lag):
        super().__init__(kernel, name)
        self.load, self.lag = load, lag


@pytest.fixture
def loaded(monkeypatch):
    """A kind of part whose options have a table."""
    monkeypatch.setitem(KINDS, "loaded", ListedPart(at="loaded:Loaded", description="a part for tests"))
    monkeypatch.setitem(CATALOGUE.ours, "loaded", f"{__name__}:Loaded")


BENCH = """
[[part]]
kind = "loaded"
name = "p"
load = {{ {load} }}
"""


def test_a_table_among_the_options_comes_from_a_bench_file_and_from_a_journal(loaded, tmp_path):
    path, journal = tmp_path / "b.toml", tmp_path / "b.jsonl"
    path.write_text(BENCH.format(load="inertia = 2e-5"))
    bench = slewline.load(path, journal=journal)
    bench.run("1 us")
    assert bench["p"].load == {"inertia": 2e-5, "teeth": 20} and bench["p"].lag == "1 us"
    assert slewline.replay(journal)["p"].load == {"inertia": 2e-5, "teeth": 20}


@pytest.mark.parametrize(
    ("load", "says"),
    [
        ('inertia = "much"', r"line 2: \[\[part\]\] 1: p: load: inertia 'much'; allowed 0 or more kg m2"),
        ("teeth = 2", "p: load: teeth 2; allowed 3 or more"),
        ("tooth = 9", "p: load: no option 'tooth'; its options: inertia, teeth"),
    ],
)
def test_a_wrong_value_in_the_table_of_a_bench_file_is_reported_with_its_place(loaded, tmp_path, load, says):
    path = tmp_path / "b.toml"
    path.write_text(BENCH.format(load=load))
    with pytest.raises(slewline.errors.BenchFileError, match=says):
        slewline.load(path)


def test_a_table_is_checked_for_the_constructor(loaded):
    assert checked("p", Loaded.options, {})["load"] == {"inertia": 0.0, "teeth": 20}
