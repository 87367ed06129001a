"""What was found is replayed by the chip: every calculator says what a host sends, and the steps are the move's."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import slewline
from slewline.chips import PARTS, ramps_of
from slewline.errors import UsageError
from slewline.language.ramp_answers import Calculator
from slewline.tuning.task import Chosen, Tuned
from slewline.tuning.tuned_bench_file import bench_file, toml

from .stand_in import task

VALUES: dict[str, list[dict[str, Any]]] = {
    "cy500": [{"R": 200, "S": 10}],
    "cy512": [{"R": 200, "S": 10}],
    "cy525": [{"F": 3, "R": 40, "S": 200, "Z": 1}, {"F": 5, "R": 20, "S": 9, "Z": 3, "ramp_unit": 500}],
    "cy545": [{"F": 3, "R": 40, "S": 200}, {"F": 3, "R": 40, "S": 200, "ramp_jumps": "False"}],
    "cy545b": [{"F": 9, "R": 80, "S": 100}],
    "gs-c200": [{"S": 10, "T": 100, "R": 40}],
    "gs-c200s": [{"S": 10, "T": 300, "R": 40}],
} | {
    part: [
        {"SET_VEL": 42950, "SET_ACC": 141, "SET_START_VEL": 100},
        {"profile": "s-curve", "SET_VEL": 42950, "SET_MAX_ACC": 141, "SET_JERK": 100000},
        {"SET_VEL": 1500000, "SET_ACC": 60000, "SET_START_VEL": 0, "output": "high"},
    ]
    for part in PARTS
    if part.startswith("mc1")
}  # fmt: skip


def filled(calculator: Calculator, values: dict[str, Any]) -> dict[str, Any]:
    return dict(slewline.ramp(calculator.sheet.part, **values).values)


def found(part: str, values: dict[str, Any], **more: Any) -> Tuned:
    """A result with these values."""
    chosen = Chosen(filled(ramps_of(part), values), 10**12, 1.5)
    hz = ramps_of(part).sheet.crystal_hz
    made = replace(task("cy525"), **{"part": part, "crystal_hz": hz} | more)
    return Tuned(made, 1, 0, chosen, chosen, False, 1, 1, 1, {})


def test_every_part_is_here() -> None:
    assert set(VALUES) == set(PARTS)


@pytest.mark.parametrize(("part", "values"), [(part, each) for part, of in VALUES.items() for each in of])
def test_the_chip_outputs_the_judged_steps(part: str, values: dict[str, Any], tmp_path: Path) -> None:
    calculator = ramps_of(part)
    text = bench_file(found(part, values, steps=400), calculator)
    assert ("straps" in text) == bool(calculator.sheet.fastest)
    chip_alone = "".join(f"[[{table}" for table in text.split("[[") if table.startswith(("chip", "host")))
    path = tmp_path / "found.toml"
    path.write_text(chip_alone, "utf-8")
    bench = slewline.load(path)
    bench.run_until_idle()
    steps = bench["x"].steps().times_ps
    expected = slewline.ramp(part, **values).move(400).times()
    assert bench["x"].position == 400 and not bench.findings
    assert np.abs((steps - steps[0]) - (expected - expected[0])).max() <= 1  # ps: clocks that are no whole picoseconds


def test_a_bench_file_has_the_motor_as_it_was_given() -> None:
    said = {"motor": "QSH4218-51-10-049", "driver": 'L/4R "20 V"', "load": {"inertia": 6.8e-6, "hard stop": True}}
    one = found("cy525", VALUES["cy525"][1], crystal_hz=10_000_000, stepping="half", given=said)
    text = bench_file(one, ramps_of("cy525"))
    assert text.startswith("# the recommended ramp: 1000 steps in 1 s, worst lag 1.50 full steps\n")
    tables = tomllib.loads(text)
    assert tables["chip"] == [{"part": "cy525", "name": "x", "crystal": "10000000 Hz", "options": {"ramp_unit": 500}}]
    assert tables["part"] == [{"kind": "stepper", "name": "motor", "to": "x", "steps": "half"} | said]
    assert tables["host"] == [{"chips": ["x"], "script": ["A 0", "F 5", "R 20", "S 9", "Z 3", "N 1000", "G"]}]


def test_non_default_data_become_tables() -> None:
    made = task("cy525")
    said = {"motor": made.motor, "driver": made.driver, "load": made.load}
    tables = tomllib.loads(bench_file(found("cy525", VALUES["cy525"][0], given=said), ramps_of("cy525")))
    assert tables["part"][0]["driver"] == {"kind": "averaged", "supply": 24.0, "current": 1.0}
    assert tables["part"][0]["load"] == {"inertia": 6.8e-6, "friction": 0.005, "torque": 0.03}
    assert tables["part"][0]["motor"]["inertia"] == 6.8e-6 and "source" not in tables["part"][0]["motor"]


@pytest.mark.parametrize(
    "value", [1, -2.5, 1e-7, True, 'a\n"b" \\ é \x7f', [1, "x", []], {"a-b": 1, "c d": {"e": [2]}}]
)
def test_values_survive_toml(value: Any) -> None:
    assert tomllib.loads(f"x = {toml(value)}") == {"x": value}


def test_a_calculator_without_a_script_reports_it() -> None:
    class Silent(type(ramps_of("cy525"))):  # type: ignore[misc]
        script = Calculator.script

    with pytest.raises(UsageError, match="cy525: its calculator has no `script` method"):
        bench_file(replace(found("cy525", VALUES["cy525"][0])), Silent(ramps_of("cy525").sheet))
