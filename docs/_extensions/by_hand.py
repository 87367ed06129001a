"""Ramps by hand: a page with sliders, which moves without a server.

What `slewline ramp` prints and draws for every place of the sliders is computed when the pages are built, and goes into
the one script of the page, next to the modules that draw it: from a file, browsers load scripts, but no modules and no
data.
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
import zlib
from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import slewline
from slewline.chips import ramps_of
from slewline.cli.ramp import move_line, summary
from slewline.language.ramp_answers import Calculator, Move, Ramp

PAGE = "tutorial/ramps_by_hand"
SCRIPT = "by_hand.js"
STEPS = 1000  # of every move on the page
LABEL = 14  # characters of a line of `slewline ramp` before what it says
TICK = 10**8  # ps; times of a curve are drawn in 0.1 ms
FINE = 0.004  # of the greatest rate: what a drawn curve may be off, about a pixel
MOMENT = 0.03  # of a move


class Sliders(NamedTuple):
    """The sliders of a part: where each of its parameters may stand, and where it stands at first."""

    part: str
    title: str
    places: Mapping[str, tuple[list[int | str], int]]
    fixed: Mapping[str, str]


PARTS = (
    Sliders(
        "cy525",
        "CY525",
        {
            "F": ([1, 3, 6, 10, 15, 20], 1),
            "R": ([10, 20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120, 127], 5),
            "S": ([1, 50, 100, 125, 150, 175, 190, 200, 210, 220, 230, 240, 250], 7),
        },
        {},
    ),
    Sliders(
        "gs-c200",
        "GS-C200",
        {
            "S": ([5, 10, 20, 30, 45, 60], 1),
            "T": ([40, 60, 80, 100, 150, 200, 250, 300, 350, 400, 500, 600], 5),
            "R": ([10, 20, 30, 50, 75, 100, 150, 200, 300, 400, 500, 700], 6),
        },
        {},
    ),
    Sliders(
        "mc1451a",
        "MC1451A",
        {
            "SET_VEL": ([f"{rate} steps/s" for rate in (500, 1000, 1500, 2000, 2500, 3000, 4000, 5000, 6000)], 4),
            "SET_MAX_ACC": ([f"{n}000 steps/s2" for n in (5, 7, 10, 15, 20, 30, 50, 70, 100)], 4),
            "SET_JERK": ([f"{n}0000 steps/s3" for n in (5, 10, 20, 30, 50, 100, 200, 500, 1000, 3000)], 3),
        },
        {"profile": "s-curve"},
    ),
)


# ----------------------------------------------------------------------------------------------------------------- runs
def runs(sliders: Sliders) -> dict[str, Any]:
    """Return the data of a part: its sliders, and a run for each combination of places, the last slider fastest."""
    calculator = ramps_of(sliders.part, None)
    made = [
        slewline.ramp(sliders.part, **sliders.fixed, **dict(zip(sliders.places, values, strict=True)))
        for values in product(*(places for places, _ in sliders.places.values()))
    ]
    moves = [ramp.move(STEPS) for ramp in made]
    outputs = [read([*summary(calculator, ramp), *move_line(move)]) for ramp, move in zip(made, moves, strict=True)]
    holes = {name: f"{{{name}}}" for name in sliders.places}
    named = [f"{name}={value}" for name, value in (sliders.fixed | holes).items()]
    return {
        "title": sliders.title,
        "command": f"slewline ramp {sliders.part} {' '.join(named)} --distance {STEPS}",
        "host": calculator.script(made[0].values | holes, STEPS),
        "sliders": [slider(calculator, name, *at, made) for name, at in sliders.places.items()],
        "output": {label: [lines.get(label, "") for lines in outputs] for label in outputs[0]},
        "curves": [curve(ramp, move) for ramp, move in zip(made, moves, strict=True)],
    }


def read(lines: list[str]) -> dict[str, str]:
    """Return the lines of `slewline ramp`, without its first line, by label; a label that is not printed is missing."""
    return {line[:LABEL].strip(): line[LABEL:] for line in lines[1:]}


def slider(calculator: Calculator, name: str, places: list[int | str], at: int, made: list[Ramp]) -> dict[str, Any]:
    """Return a slider: the name of its parameter, what that is, its values, and what those are in steps and seconds."""
    spoken = [place.replace("s2", "s²").replace("s3", "s³") for place in places if isinstance(place, str)]
    values = dict.fromkeys(ramp.values[name] for ramp in made)
    return {
        "name": name,
        "says": calculator.quantity(name).description,
        "values": [*values],
        "spoken": spoken,
        "at": at,
    }


def curve(ramp: Ramp, move: Move) -> list[int]:
    """Return the velocity over the time of a move: time, rate, time, rate ..., in 0.1 ms and steps/s.

    A rate that lasts for a moment is a point in the middle of its steps, so that the stairs of a ramp are a line.
    """
    begins = move.times()
    intervals = np.diff(begins)
    first = np.flatnonzero(np.abs(np.diff(intervals, prepend=0)) > 1)  # of the steps at one rate, to the ps
    last = np.append(first[1:], len(intervals))
    begin, end = begins[first], begins[last]
    lasts = (last - first > 1) & (end - begin > MOMENT * move.time_ps)
    middle = (begin + end) // 2
    times = np.concatenate(
        [[0], np.stack([np.where(lasts, at, middle) for at in (begin, end)], 1).ravel(), [move.time_ps]]
    )
    rates = np.concatenate([[ramp.start], np.repeat(1e12 / intervals[first], 2), [ramp.start]])
    kept = [*thinned(times, rates, FINE * rates.max())]
    return [round(number) for at in kept for number in (times[at] / TICK, rates[at])]


def thinned(x: np.ndarray, y: np.ndarray, tolerance: float) -> Iterator[int]:
    """Yield the indices of the points between which straight lines are no further off than a tolerance in y."""
    yield 0
    left = [(0, len(x) - 1)]
    while left:
        first, last = left.pop()
        inner = slice(first + 1, last)
        off = np.abs(np.interp(x[inner], x[[first, last]], y[[first, last]]) - y[inner])
        if off.size and off.max() > tolerance:
            middle = first + 1 + int(off.argmax())
            left += [(middle, last), (first, middle)]
        else:
            yield last


# --------------------------------------------------------------------------------------------------------------- script
def joined(path: Path, seen: set[Path]) -> Iterator[str]:
    """Yield a module as a part of a script, after those that it imports and that have not been seen."""
    text = path.read_text("utf-8")
    for name in re.findall(r'^import .* from "(.*)";$', text, re.MULTILINE):
        needed = (path.parent / name).resolve()
        if needed not in seen:
            seen.add(needed)
            yield from joined(needed, seen)
    yield re.sub(r"^import .*\n|^export (?=\w)", "", text, flags=re.MULTILINE)


def script(data: str) -> str:
    """Return the script of the page."""
    modules = "\n".join(joined(Path(__file__).with_suffix(".js"), set()))
    return f'(() => {{\n"use strict";\n{modules}\nbegin("{data}");\n}})();\n'


def packed() -> str:
    """Return the runs of all parts: JSON, deflated, in base64."""
    data = {"steps": STEPS, "perSecond": 10**12 // TICK, "parts": [runs(sliders) for sliders in PARTS]}
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"))
    return base64.b64encode(zlib.compress(text.encode("utf-8"), 9)).decode("ascii")


def write(app: Any) -> None:
    """Write the script; the runs are kept beside the doctrees as long as no source changes."""
    if app.builder.format != "html":
        return
    sources = sorted([Path(__file__), *Path(slewline.__file__).parent.rglob("*.py")])
    key = hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()
    kept = Path(app.doctreedir) / f"by_hand_{key}.txt"
    if not kept.exists():
        kept.write_text(packed(), "ascii")
    static = Path(app.outdir) / "_static"
    static.mkdir(parents=True, exist_ok=True)
    (static / SCRIPT).write_text(script(kept.read_text("ascii")), "utf-8")


def attach(app: Any, page: str, *_: object) -> None:
    """Give the page its script."""
    if page == PAGE:
        app.add_js_file(SCRIPT, loading_method="defer")
        app.add_css_file("by_hand.css")


def setup(app: Any) -> dict[str, bool]:
    """Let Sphinx write the script, and the page have it."""
    app.connect("builder-inited", write)
    app.connect("html-page-context", attach)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
