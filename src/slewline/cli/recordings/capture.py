"""check-capture: compare a recording of STEP and DIR with the data sheets of a driver and a part."""

from __future__ import annotations

from collections.abc import Iterable

import click

from ...drive.captures.capture_report import CaptureReport
from ...drive.captures.checking import check_capture
from ...errors import UsageError
from ...record.waveforms.read_waveforms import read_waveforms
from .. import FOUND
from ..files import Outputs
from ..programs import print_json


def capture(
    file: str,
    axes: Iterable[str],
    driver: str | None,
    edge: str,
    forward: int,
    idle: int | None,
    glitch: int | None,
    chip: str | None,
    pins: Iterable[str],
    crystal: int | None,
    timescale: int | None,
    threshold: str | None,
    torn: bool,
    plot: str | None,
    as_json: bool,
) -> int:
    """Print a report on a recording; return 0 if there are no faults, else 1."""
    from ...record.pictures.picture_files import SUFFIXES

    outputs = Outputs([file])
    outputs.claim(plot, SUFFIXES)
    named = dict(_pair(text, "--axis", f"x={text}" if "," in text and "=" not in text else "x=D0,D1") for text in axes)
    signals = {name: _axis(name, value) for name, value in named.items()}
    of_part = dict(_pair(part, "--pin", "pulse=D0") for text in pins for part in text.split(","))
    waves = read_waveforms(file, timescale=timescale, torn=torn, threshold=threshold)
    found = check_capture(
        waves,
        signals,
        driver=driver,
        edge=edge,
        forward=forward,
        idle=idle,
        glitch=glitch,
        part=chip,
        pins=of_part or None,
        crystal=crystal,
    )
    if as_json:
        print_json(plain(found))
    else:
        click.echo(str(found))
    outputs.save(plot, found.plot)
    return 0 if found.good else FOUND


def _pair(text: str, option: str, example: str) -> tuple[str, str]:
    name, equals, value = (part.strip() for part in text.partition("="))
    if not (name and equals and value):
        raise UsageError(f"{option} {text}: expected a name and signals of the file, such as {example}")
    return name, value


def _axis(name: str, text: str) -> tuple[str, str | None]:
    step, comma, direction = (part.strip() for part in text.partition(","))
    if not step or (comma and not direction):
        raise UsageError(f"--axis {name}={text}: expected STEP and DIR, such as {name}=D0,D1")
    return step, direction or None


def plain(found: CaptureReport) -> dict[str, object]:
    """Return a report as data for JSON."""
    return {
        "good": found.good,
        "resolution_ps": found.resolution_ps,
        "axes": [
            {
                "axis": axis.name,
                "steps": len(axis.steps.times_ps),
                "forward": int((axis.steps.directions > 0).sum()),
                "position": int(axis.steps.positions[-1]) if len(axis.steps.positions) else 0,
                "glitches_ps": list(axis.glitches),
                "jitter_rms_ps": axis.jitter and axis.jitter.rms_ps,
                "jitter_greatest_ps": axis.jitter and axis.jitter.greatest_ps,
            }
            for axis in found.axes
        ],
        "limits": [
            {
                "of": row.chip,
                "says": row.bound.limit.description,
                "least_ps": row.bound.least,
                "most_ps": row.bound.most,
                "count": row.count,
                "shortest_ps": row.shortest_ps,
                "longest_ps": row.longest_ps,
                "verdict": row.verdict,
                "violations_ps": list(row.violations),
            }
            for row in found.limits
        ],
        "skews": [
            {"first": first, "second": second, "median_ps": each and each.median_ps, "pairs": each.pairs if each else 0}
            for (first, second), each in found.skews.items()
        ],
        "notes": list(found.notes),
    }
