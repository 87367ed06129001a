"""compare: the signals of a measured waveform file compared with those of the model."""

from __future__ import annotations

from collections.abc import Iterable

import click

from ...errors import UsageError
from ...record.measuring.compare_edges import Comparison
from ...record.measuring.explain import SignalPair, Terms, compare_signals
from ...record.waveforms.read_vcd import read_vcd
from ...record.waveforms.read_waveforms import read_waveforms
from ...record.waveforms.waveforms import Waveforms
from .. import FOUND
from ..programs import print_json


def compare(
    model: str,
    measured: str,
    pairs: Iterable[str],
    shift: str,
    tolerance: int | None,
    timescale: int | None,
    torn: bool,
    as_json: bool,
    invert: Iterable[str] = (),
    threshold: str | None = None,
) -> int:
    """Print the comparison of each pair of signals; return 0 if all pairs agree, else 1."""
    ours = read_vcd(model, torn=torn)
    theirs = read_waveforms(measured, timescale=timescale, torn=torn, threshold=threshold)
    within = ""
    if tolerance is None:
        tolerance = ours.sampling_ps + theirs.sampling_ps
        coarser = max(ours.sampling, theirs.sampling, key=lambda each: each.resolution_ps)
        within = "" if coarser.found == "unit" else str(coarser)
    signals = [
        SignalPair(
            name,
            other,
            ours.edges(name),
            theirs.edges(other),
            ours.width(name) == theirs.width(other) == 1,
            (ours.level_at(name, ours.start_ps), theirs.level_at(other, theirs.start_ps)),
        )
        for name, other in _pairs(ours, theirs, pairs)
    ]
    terms = Terms(shift, tolerance, within, _inverted(invert, signals))
    found = compare_signals(signals, terms)
    if as_json:
        print_json([_plain(one) for one in found])
    else:
        click.echo("\n".join(map(str, found)))
    return 0 if all(one.agrees for one in found) else FOUND


def _inverted(given: Iterable[str], signals: list[SignalPair]) -> set[str]:
    """Return the model names of the inverted signals; `given` has their model or measured names, or "all"."""
    names = {part.strip() for text in given for part in text.split(",")}
    by_name = {name: each.name for each in signals if each.wire for name in (each.name, each.other)}
    if "all" in names:
        return set(by_name.values())
    for name in names - by_name.keys():
        allowed = ", ".join([*dict.fromkeys(by_name.values()), "all"])
        raise UsageError(f"--invert {name}: not a wire that is compared; allowed {allowed}")
    return {by_name[name] for name in names}


def _pairs(ours: Waveforms, theirs: Waveforms, given: Iterable[str]) -> list[tuple[str, str]]:
    """Return pairs of signal names, in the model and in the measurement: those given, else matching names."""
    pairs = [tuple(part.strip() for part in pair.partition("=")) for text in given for pair in text.split(",")]
    for name, equals, other in pairs:
        if not (name and equals and other):
            raise UsageError(f"--map {name}{equals}{other}: name one signal from each file, such as x.pulse=D0")
        if ours.kind(name) != "bits" or theirs.kind(other) != "bits":
            raise UsageError(f"--map {name}={other}: expected signals with levels, not real or string variables")
    if pairs:
        return [(name, other) for name, _, other in pairs]
    alike = [
        (name, next((known for known in (name, name.rpartition(".")[2]) if known in theirs), ""))
        for name in ours.names
        if ours.kind(name) == "bits"
    ]
    alike = [(name, other) for name, other in alike if other and theirs.kind(other) == "bits"]
    if not alike:
        files = f"{ours.path} has {', '.join(ours.names)}; {theirs.path} has {', '.join(theirs.names)}"
        raise UsageError(f"the files have no signal name in common: {files}; give pairs, as in --map x.pulse=D0")
    return alike


def _plain(found: Comparison) -> dict[str, object]:
    return {
        "signal": found.name,
        "agrees": found.agrees,
        "model_edges": len(found.model[0]),
        "measured_edges": len(found.measured[0]),
        "pairs": len(found.pairs),
        "shift_ps": found.shift_ps,
        "tolerance_ps": found.tolerance_ps,
        "greatest_ps": found.greatest_ps,
        "mean_ps": found.mean_ps,
        "drift_ppm": found.drift_ppm,
        "within": found.within,
        "notes": list(found.notes),
        "differences": [row._asdict() for row in found.rows],
    }
