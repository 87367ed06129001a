"""What a waveform file of a bench has beside the pins: what the axes do, what is said of it, and how it is laid out."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING

from ...core.chip import Chip
from ...parts.base.part import Part
from .curves import axes_of

if TYPE_CHECKING:
    from ...record.recording.recorder import TextLog
    from ...record.waveforms.layouts import View
    from ...record.waveforms.vcd_sources import Source

_time = attrgetter("time_ps")
MOST_MARKS = 26  # that a viewer names
AROUND = 50  # before and after the motion, a layout shows a fiftieth of it
APART = 30  # marks are so far apart that their names can be read: a thirtieth of what is shown


def chips_of(chips: Mapping[str, Chip], names: Iterable[str]) -> list[Chip]:
    """Return the chips that some pins belong to."""
    owners = {name.split(".")[0] for name in names}
    return [chip for name, chip in chips.items() if name in owners]


def values_of(chips: Iterable[Chip], commands: Mapping[str, TextLog], parts: Iterable[Part] = ()) -> list[Source]:
    """Return what has a value beside the pins, for a waveform file.

    Of every chip its findings and the command in work; of every axis what moves it, and its quantities; of parts that
    have quantities, these and their findings.
    """
    from ...record.waveforms.vcd_sources import CurveSource, TextSource

    sources: list[Source] = []
    for chip in chips:
        sources.append(TextSource(f"{chip.name}.finding", partial(_findings, chip)))
        if chip.name in commands:
            sources.append(TextSource(f"{chip.name}.command", commands[chip.name].between, all=False))
        for scope, axis in axes_of(chip):
            sources.append(TextSource(f"{scope}.motion", axis.motor.log.texts, all=False))
            sources += [CurveSource(f"{scope}.{quantity.name}", quantity) for quantity in axis.quantities()]
    for part in parts:
        if quantities := part.quantities():
            sources.append(TextSource(f"{part.name}.finding", partial(_findings, part)))
            sources += [CurveSource(f"{part.name}.{quantity.name}", quantity) for quantity in quantities]
    return sources


def comments_of(chips: Iterable[Chip], values: bool, parts: Iterable[Part] = ()) -> Iterator[str]:
    """Yield the head of the file: the parts, and the units of the quantities."""
    for chip in chips:
        crystal = f", {chip.crystal_hz} Hz" if chip.sheet.crystal_high_hz else ""
        yield f"{chip.name}: {chip.sheet.part.upper()}{crystal}"
        for scope, axis in axes_of(chip) if values else ():
            yield from (f"{scope}.{quantity.name} in {quantity.unit}" for quantity in axis.quantities())
    for part in parts:
        yield from (f"{part.name}.{quantity.name} in {quantity.unit}" for quantity in part.quantities())


def view_of(chips: Sequence[Chip], start: int, stop: int, unit: int) -> View:
    """Return what a viewer shows first of a window (ps): the motion, or all of it if nothing moves, with marks."""
    from ...record.waveforms.layouts import View
    from .motions import moving_from_to

    axes = [axis for chip in chips for _, axis in axes_of(chip)]
    spans = [span for axis in axes if (span := moving_from_to(axis, start, stop)) is not None]
    begin, end = (min(a for a, _ in spans), max(b for _, b in spans)) if spans else (start, stop)
    around = (end - begin) // AROUND
    begin, end = max(begin - around, start), min(end + around, stop)
    found = [(ps, text.split(":")[0]) for chip in chips for ps, text in _findings(chip, start, stop)]
    begun = [(motion.time_ps, motion.text) for axis in axes for motion in axis.motor.motions(start, stop)]
    marks = _apart([*sorted(found), *sorted(begun)], (end - begin) // APART)
    scale = 10 ** ((len(str(unit)) - 1) % 3)
    return View(begin // unit, end // unit, [(ps // unit, text) for ps, text in marks], scale)


def _apart(marks: Iterable[tuple[int, str]], distance: int) -> list[tuple[int, str]]:
    """Marks by time, the first of them first of all; those that come too near to another one are left out."""
    kept: list[tuple[int, str]] = []
    for mark in marks:
        if len(kept) < MOST_MARKS and all(abs(mark[0] - other) > distance for other, _ in kept):
            kept.append(mark)
    return sorted(kept)


def _findings(owner: Chip | Part, start: int, stop: int) -> list[tuple[int, str]]:
    findings = owner.findings
    first, end = bisect_left(findings, start, key=_time), bisect_right(findings, stop, key=_time)
    return [(found.time_ps, f"{found.code}: {found.text}") for found in findings[first:end]]
