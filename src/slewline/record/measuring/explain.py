"""Comparison of all signals in a recording with those of the model, and possible causes of differences.

A correct recording may look wrong: an optocoupler inverts a signal, two clips have been exchanged, or a
filter delays one signal.  Each of these causes is tried, and reported if it explains the differences;
even then, the signals count as different.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

from ...core.time.timebase import Time, readable
from .compare_edges import Comparison, compare_edges
from .intervals import rounded

if TYPE_CHECKING:
    from .compare_edges import Edges

MOST = 12  # differing signals of which all pairs are tried: 66 pairs


class SignalPair(NamedTuple):
    """A model signal and a measured one to compare: names, edges, whether they are wires, initial levels."""

    name: str
    other: str
    model: Edges
    measured: Edges
    wire: bool = True
    levels: tuple[int, int] = (0, 0)


class Terms(NamedTuple):
    """The terms of a comparison.

    Attributes:
        shift: the time that is added to the measured times, as for `compare_edges`.
        tolerance: the greatest distance at which the two edges of a pair still agree, ps.
        within: text that states the origin of the tolerance.
        invert: the names of the signals whose measured levels are inverted first.
    """

    shift: Time = "first"
    tolerance: int = 0
    within: str = ""
    invert: Collection[str] = ()


def compare_signals(pairs: Sequence[SignalPair], terms: Terms) -> list[Comparison]:
    """Compare signals; the shift found for the first signal with paired edges is used for all later ones.

    If any signals differ, notes in the comparisons state the probable cause, if one is found.
    """
    found = _compared(pairs, terms)
    wrong = [index for index, one in enumerate(found) if not one.agrees]
    if not wrong:
        still = {pair.name: _constant(pair, terms) for pair in pairs if not len(pair.model[0]) + len(pair.measured[0])}
        return [replace(one, notes=still.get(one.name, ())) for one in found]
    notes = _polarity(pairs, terms) or _swapped(pairs, wrong[:MOST], terms) or _delays(pairs, found, terms)
    return [replace(one, notes=notes.get(one.name, ())) for one in found]


def _compared(pairs: Sequence[SignalPair], terms: Terms) -> list[Comparison]:
    by, found = terms.shift, []
    for pair in pairs:
        one = compare_edges(
            pair.model,
            pair.measured,
            shift=by,
            tolerance=terms.tolerance,
            name=pair.name,
            invert=pair.name in terms.invert,
        )
        found.append(replace(one, within=terms.within if one.greatest_ps else ""))
        if len(one.pairs):
            by = one.shift_ps
    return found


def _constant(pair: SignalPair, terms: Terms) -> tuple[str, ...]:
    """Return a note if a wire without edges has a level (0 or 1) other than the model's; otherwise, return ()."""
    ours, theirs = pair.levels
    if not pair.wire or min(ours, theirs) < 0:
        return ()
    theirs ^= pair.name in terms.invert
    return () if ours == theirs else (f"no edges; its level is {theirs}, that of the model {ours}; it may be inverted",)


def _agree(found: Sequence[Comparison]) -> bool:
    return all(one.agrees for one in found)


def _best_polarity(pairs: Sequence[SignalPair], terms: Terms) -> list[str] | None:
    """Return the signals to invert so that all signals agree with the model; None if no inversion achieves this."""
    wires = [pair for pair in pairs if pair.wire]
    for first in wires[:1]:  # it determines the shift
        for lead in ({*terms.invert} - {first.name}, {*terms.invert} | {first.name}):
            inverted = set(lead)
            for one in _compared(pairs, terms._replace(invert=inverted)):
                if not one.agrees and one.name != first.name and any(one.name == wire.name for wire in wires):
                    inverted ^= {one.name}
            if _agree(_compared(pairs, terms._replace(invert=inverted))):
                return sorted(inverted)
    return None


def _polarity(pairs: Sequence[SignalPair], terms: Terms) -> dict[str, tuple[str, ...]]:
    inverted = _best_polarity(pairs, terms)
    if inverted is None:
        return {}
    changed = {*inverted} ^ {*terms.invert}
    remedy = f"--invert {','.join(inverted)}" if inverted else "leave out --invert"
    return {name: (f"agrees when inverted: {remedy}",) for name in changed}


def _swapped(pairs: Sequence[SignalPair], wrong: Sequence[int], terms: Terms) -> dict[str, tuple[str, ...]]:
    """Return notes on two signals that have been exchanged; {} if no exchange makes all signals agree.

    Signals may be inverted in addition to the exchange.  The notes are keyed by the names of the two
    signals.
    """
    for a, b in combinations(wrong, 2):
        tried = list(pairs)
        for here, there in ((a, b), (b, a)):
            tried[here] = pairs[here]._replace(other=pairs[there].other, measured=pairs[there].measured)
        inverted = _best_polarity(tried, terms)
        if inverted is None:
            continue
        first, second = pairs[a], pairs[b]
        remedy = f"--map {first.name}={second.other},{second.name}={first.other}"
        if inverted:
            remedy += f" --invert {','.join(inverted)}"
        note = f"{first.other} and {second.other} are swapped: {remedy}"
        return {first.name: (note,), second.name: (note,)}
    return {}


def _delays(pairs: Sequence[SignalPair], found: Sequence[Comparison], terms: Terms) -> Mapping[str, tuple[str, ...]]:
    """Return notes on signals that agree except for a constant delay, or that would agree with more tolerance."""
    notes: dict[str, tuple[str, ...]] = {}
    for pair, one in zip(pairs, found, strict=True):
        if one.agrees:
            continue
        invert = pair.name in terms.invert
        for levels in (invert, not invert) if pair.wire else (invert,):
            own = compare_edges(pair.model, pair.measured, tolerance=terms.tolerance, name=pair.name, invert=levels)
            if not own.agrees or not len(own.pairs):
                continue
            whole = len(one.pairs) and not len(one.missing) + len(one.extra)
            by = round(float(one.late_ps.mean())) if whole else one.shift_ps - own.shift_ps
            much = readable(rounded(abs(by), 3))
            text = f"a constant delay of {much}" if by >= 0 else f"being {much} early"
            notes[pair.name] = (f"agrees except for {text}" + (", inverted" if levels != invert else ""),)
            break
        else:
            if not (len(one.missing) or len(one.extra)):
                needs = -(-one.greatest_ps // 1000)
                notes[pair.name] = (f"no edge is missing or extra; with --tolerance '{needs} ns' they agree",)
    return notes
