"""The order of the parts in a bench file: none is needed, and none makes a difference."""

from __future__ import annotations

import json
import re
import shutil
from itertools import islice, permutations
from pathlib import Path

import pytest

import slewline
from slewline.cli.main import invoke
from slewline.errors import BenchFileError
from tests.rows import rows

ROOT = Path(__file__).parents[2]
FILES = sorted(
    path
    for folder in ("examples", "src/slewline", "tests/system/earlier_runs")
    for path in (ROOT / folder).rglob("*.toml")
    if len(re.findall(r"(?m)^\[\[part\]\]", path.read_text("utf-8"))) > 1
)
CHAIN = """
[[chip]]
part = "cy525"
name = "x"
options = { position = 0, rate = 20, firstrate = 20, slope = 255, divisor = 1, number = 100 }
[[host]]
chips = ["x"]
script = ["G"]
"""
PARTS = (
    '[[part]]\nkind = "translator"\nto = "x"\n',
    '[[part]]\nkind = "motor"\nname = "m"\nto = "x"\n',
    '[[part]]\nkind = "gear"\nname = "g"\non = "m"\npinion = 20\nwheel = 40\n',
    '[[part]]\nkind = "encoder"\nname = "e"\non = "g"\ncounts = 400\n',
)


def tables(text: str) -> tuple[list[str], list[int]]:
    """The tables of a file, and which of them are parts."""
    found = re.split(r"(?m)^(?=\[)", text)
    return found, [number for number, table in enumerate(found) if table.startswith("[[part]]")]


def orders(text: str, most: int):
    """The text with its parts in other orders, the one of the file first; the reverse is among them."""
    found, parts = tables(text)
    every = islice(permutations(parts), most)
    for order in [*every, tuple(reversed(parts))]:
        again = list(found)
        for place, number in zip(parts, order, strict=True):
            again[place] = found[number] if found[number].endswith("\n") else found[number] + "\n"
        yield "".join(again)


def run(path: Path, capfd) -> tuple[int, object]:
    status = invoke(["run", str(path), "--json", "--timeout", "3 s"])
    out, err = capfd.readouterr()
    assert out, err
    found = json.loads(out)
    found.pop("file", None)
    return status, found


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_the_benches_of_the_project_run_the_same_in_any_order(path, tmp_path, capfd):
    folder = tmp_path / "x"
    shutil.copytree(path.parent, folder)
    copy = folder / path.name
    seen = []
    for text in orders(path.read_text("utf-8"), 6):
        copy.write_text(text, "utf-8")
        seen.append(run(copy, capfd))
    assert len(seen) > 1 and all(each == seen[0] for each in seen)


def bench_of(tmp_path, *parts: str):
    path = tmp_path / "b.toml"
    path.write_text(CHAIN + "".join(parts))
    return slewline.load(str(path))


@rows("order", list(permutations(range(len(PARTS)))))
def test_a_chain_of_parts_is_made_from_any_order(tmp_path, order):
    bench = bench_of(tmp_path, *(PARTS[number] for number in order))
    bench.run_until_idle()
    assert bench["m"].position == 100 and bench["e"].shaft is not None
    assert set(bench.parts) >= {"translator", "m", "g", "e"}


@rows(
    ("parts", "says"),
    [
        (
            (
                '[[part]]\nkind = "inverter"\nname = "a"\nto = "b"\n',
                '[[part]]\nkind = "inverter"\nname = "b"\nto = "a"\n',
            ),
            r"b.toml, line 16: \[\[part\]\] 2, to: parts that name each other in a cycle: a -> b -> a; wire one",
        ),
        (
            ('[[part]]\nkind = "inverter"\nname = "a"\nto = "a"\n',),
            r"line 12: \[\[part\]\] 1, to: parts that name each other in a cycle: a -> a; wire one",
        ),
        (
            (
                '[[part]]\nkind = "gear"\nname = "a"\non = "c"\n',
                '[[part]]\nkind = "gear"\nname = "b"\non = "a"\n',
                '[[part]]\nkind = "gear"\nname = "c"\non = "b"\n',
            ),
            "in a cycle: a -> c -> b -> a",
        ),
        (
            ('[[part]]\nkind = "motor"\nto = "translatr"\n', PARTS[0]),
            "the bench has no 'translatr'; available: x, motor, translator; did you mean translator",
        ),
    ],
)
def test_a_circle_and_an_unknown_name_are_refused(tmp_path, parts, says):
    with pytest.raises(BenchFileError, match=says):
        bench_of(tmp_path, *parts)


def test_parts_without_names_are_numbered_as_in_the_file(tmp_path):
    """Also where one that names a later part is made after it."""
    bench = bench_of(
        tmp_path,
        '[[part]]\nkind = "gear"\non = "gear_2"\npinion = 20\nwheel = 40\n',
        '[[part]]\nkind = "motor"\nname = "late"\nto = "x"\n',
        '[[part]]\nkind = "gear"\non = "late"\npinion = 20\nwheel = 60\n',
    )
    assert [name for name in bench.parts if name in ("late", "gear", "gear_2")] == ["late", "gear_2", "gear"]
    assert [str(bench[name].shaft.ratio) for name in ("gear", "gear_2")] == ["1/2", "1/3"]


def test_a_long_chain_of_parts_from_the_last_to_the_first(tmp_path):
    """A file may come from anybody: its length is no depth of calls."""
    number = 1500
    chain = [f'[[part]]\nkind = "gear"\nname = "g{n}"\non = "g{n + 1}"\n' for n in range(number)]
    with pytest.raises(BenchFileError, match=rf"\[\[part\]\] {number}, on: the bench has no 'g{number}'"):
        bench_of(tmp_path, *chain)
