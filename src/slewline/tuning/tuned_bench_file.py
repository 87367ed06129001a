"""The bench file of a tuned ramp: chip, motor, driver, load and the commands of a host, for `slewline run`."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, fields, is_dataclass
from typing import Any

from ..core.time.timebase import readable
from ..language.ramp_answers import Calculator
from .task import Tuned

HEADS = {True: "the recommended ramp", False: "the fastest ramp that holds; none is recommended"}


def is_tuned(text: str) -> bool:
    """Return whether a bench file is a result of `bench_file`."""
    return text.startswith(tuple(f"# {head}: " for head in HEADS.values()))


def bench_file(tuned: Tuned, calculator: Calculator) -> str:
    """Return the text of a bench file that repeats the chosen move.

    Raises:
        NothingHolds: no move was found.
    """
    task, chosen, sheet = tuned.task, tuned.chosen, calculator.sheet
    chip: dict[str, Any] = {"part": task.part, "name": "x"}
    if task.crystal_hz != sheet.crystal_hz:
        chip["crystal"] = f"{task.crystal_hz} Hz"
    if straps := {**sheet.plain, **sheet.fastest}:
        chip["straps"] = straps
    if options := {**task.options, **calculator.fitted(chosen.values)}:
        chip["options"] = options
    motor = {"kind": "stepper", "name": "motor", "to": "x"} | {
        name: _given(value) for name, value in task.given.items() if value is not None
    }
    if task.stepping != "full":
        motor["steps"] = task.stepping
    if not any(pin.role == "direction" for pin in sheet.pins):  # phases show the direction of such a part
        motor["inputs"] = "phases"
    script = calculator.script(chosen.values, task.steps)
    which = HEADS[tuned.recommended is not None]
    head = f"# {which}: {task.steps} steps in {readable(chosen.time_ps)}, worst lag {chosen.worst:.2f} full steps"
    tables = [("chip", chip), ("part", motor), ("host", {"chips": ["x"], "script": script})]
    return "\n".join([head, *(line for name, table in tables for line in _table(name, table)), ""])


def _given(value: Any) -> Any:
    """Return the entry of a motor, driver or load: its text, its table, or the figures that differ from defaults."""
    if is_dataclass(value) and not isinstance(value, type):
        usual = {each.name: each.default for each in fields(value)}
        return {name: of for name, of in asdict(value).items() if of != usual[name] and name not in ("name", "source")}
    return value


def _table(name: str, table: Mapping[str, Any]) -> Iterator[str]:
    yield ""
    yield f"[[{name}]]"
    yield from (f"{key} = {toml(value)}" for key, value in table.items())


def toml(value: Any) -> str:
    """Return a value in TOML, on one line."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(key)} = {toml(of)}" for key, of in value.items()) + " }"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return json.dumps(value)  # numbers and booleans are written as in JSON


def _key(text: object) -> str:
    return (
        str(text) if str(text).replace("-", "").replace("_", "").isalnum() and str(text).isascii() else toml(str(text))
    )
