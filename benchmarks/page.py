"""The page about performance: the missed goals, the measurements by hand, and the tables of a run."""

from __future__ import annotations

import platform
import re
import tomllib
from collections.abc import Iterable
from datetime import date
from pathlib import Path

import numpy as np
from asked import ASKED
from rows import Row, spelled_out, table
from trees import SHORT

HAND = Path(__file__).with_name("klipper.toml")
EXAMPLE = "dialogue of 10,000 commands through the pins"
PAGE = """# Performance

One run of `make bench` on {day}: {processor}, CPython {python}, NumPy {numpy}.

Computing is timed in CPU seconds, with caches emptied between runs; serving is timed by the wall clock. A figure such
as *9.33 (9.25 to 9.41) x pyvcd* is a ratio, whose two sides are measured alternately: the median of all turns, and the
range that contains half of them. *x real time* means virtual seconds per CPU second. Numbers of calls, and modules with
their shares of the time, are from a profile of this run. A goal that is met with a margin of less than 5 % is *at the
limit*. The tables use these terms:

- *bare line*: a picture of one line of 900 points, drawn by matplotlib
- *p99*: the 99th percentile
- *growth exponent*: 1 means that the time is proportional to the number of items
- *keep*: [the option that limits the stored past](api.md#a-limited-past)
- *run of equal intervals*: consecutive steps with the same interval
- *expand*: compute the time of every step

Some goals were set in virtual seconds per CPU second on one machine, an AMD EPYC (Zen 5). On other machines they are
replaced by ratios to commit {short}: each goal is divided by the figure of that commit for the EPYC (Zen 5). Except
for the entry of a program into an EEPROM, this figure is calculated: it is the figure measured on an Intel Xeon,
divided by 0.62, the speed of the Xeon relative to the EPYC.
{example}.
`python benchmarks/beside.py reference` prints the ratios of the other goals.

## Goals missed

{missed}
## Comparison with Klipper, measured once by hand

{hand}
{tables}"""


def processor() -> str:
    """Return the name of the processor, with family and model if the name alone is not specific."""
    try:
        text = Path("/proc/cpuinfo").read_text("utf-8")
    except OSError:
        return platform.processor() or platform.machine()
    found = dict(re.findall(r"^(model name|cpu family|model)\s*: (.*)$", text, re.MULTILINE))
    if "model name" not in found:
        return platform.machine()
    numbers = ", ".join(
        f"{name} {found[key]}" for name, key in (("family", "cpu family"), ("model", "model")) if key in found
    )
    return f"{found['model name'].strip()} ({numbers})" if numbers else found["model name"].strip()


def by_hand(path: Path = HAND) -> tuple[str, list[Row]]:
    """Return the content of a file about a measurement by hand: its method, and its rows."""
    given = tomllib.loads(path.read_text("utf-8"))
    when = f"{given['date']}, {given['processor']}"
    rows = [
        Row(each["what"], each["figure"], f"x Klipper ({each['low']:g} to {each['high']:g})", each["goal"], True,
            each["bound"], when=when)
        for each in given["row"]
    ]  # fmt: skip
    return given["how"].strip(), rows


def missed(rows: Iterable[Row]) -> str:
    """Return the missed goals, each with its bottleneck; then the rows at the limit, and the rows without a verdict."""
    spelled = list(spelled_out(rows))
    lines = [
        f"- {name}: {row.shown}{dated(row)}; goal {row.wanted}. Bottleneck: {bound}.\n"
        for name, bound, row in spelled
        if not row.met
    ]
    for word, say in (("at the limit", "At the limit"), ("no verdict", "No verdict")):
        some = [f"{name} ({row.shown})" for name, _, row in spelled if row.verdict.startswith(word)]
        if some:
            lines.append(f"\n{say}: {'; '.join(some)}.\n")
    return "".join(lines) or "None.\n"


def dated(row: Row) -> str:
    """Return the date and the place of a figure, if it was not measured in this run."""
    return f", as measured on {row.when}" if row.when else ""


def written(found: dict[str, list[Row]], day: date) -> str:
    """Return the page: rows by family.

    Raises:
        ValueError: a row with a goal relative to the reference is missing, perhaps because of a new name.
    """
    how, hand = by_hand()
    asked = ASKED[EXAMPLE]
    everything = [*hand, *(row for rows in found.values() for row in rows)]
    if lost := ASKED.keys() - {row.name for row in everything}:
        raise ValueError(f"no row for the goals of {', '.join(sorted(lost))}")
    return PAGE.format(
        day=day.isoformat(),
        processor=processor(),
        python=platform.python_version(),
        numpy=np.__version__,
        short=SHORT,
        example=f"For the dialogue with a CY525 the goal is {asked.goal:g} / {asked.made:.3g} = {asked.ratio:g}",
        missed=missed(everything),
        hand=f"{how}\n\n{table(hand)}",
        tables="\n".join(f"## {family}\n\n{table(rows)}" for family, rows in found.items()),
    )
