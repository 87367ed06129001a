"""What a picture of a bench tells in words: parameters, differences from the ideal; and which curves are news."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ...core.chip import Chip
from ...core.time.timebase import Time, moment

if TYPE_CHECKING:
    from ...record.pictures.tracks import Track
    from ...record.style import TimeAxis

TOLD = 3  # values of a parameter that are told, of motions in which it differs


def words_of(chip: Chip) -> dict[str, str]:
    """Return what the commands of a chip are called, by their letters: {"R": "rate"}."""
    return {row.form: row.name.lower().replace("_", " ") for row in chip.sheet.commands}


def moments_of(times: Time | Iterable[Time]) -> list[int]:
    """Return the picoseconds of an instant, or of several."""
    return [moment(time) for time in ([times] if isinstance(times, Time) else times)]


def without_rest(tracks: Sequence[Track], axis: TimeAxis) -> Iterator[Track]:
    """Yield tracks without their positions, if none of these changes: of an axis at rest, or on its way home."""
    import numpy as np

    still = not any(
        np.ptp(np.nan_to_num(quantity.outline(*track.window(axis), 1).values))
        for track in tracks
        for quantity in track.quantities
        if quantity.name == "position"
    )
    for track in tracks:
        yield replace(track, quantities=[q for q in track.quantities if not still or q.name != "position"])


def differences(tracks: Sequence[Track]) -> Iterator[str]:
    """Yield how far the motions of a track leave their ideals at most, in words."""
    from ...record.style import few

    for track in tracks:
        if track.ideals:
            position = few(max(abs(deviation.position) for _, deviation in track.ideals))
            velocity = max(abs(deviation.velocity) for _, deviation in track.ideals)
            whose = f"{track.name}: d" if len(tracks) > 1 else "D"
            steps = f"{position} step{'s' * (position != '1')}"
            yield f"{whose}otted: the ideal; position within {steps}, velocity within {few(velocity)} steps/s"


def told(track: Track, words: Mapping[str, str]) -> str:
    """Return the parameters of the motions of a track: "slope S = 240, number N = 300, 500"."""
    from ...record.style import grouped

    values: dict[str, list[str]] = {}
    for notes in {id(motion.notes): motion.notes for motion in track.motions}.values():  # motions may share them
        for name, value in notes.items():
            text = grouped(value)
            if text not in values.setdefault(name, []):
                values[name].append(text)
    parts = []
    for name, texts in values.items():
        word = words.get(name, name.lower())
        called = f"{word} {name}" if word != name.lower() else name
        shown = ", ".join(texts[:TOLD]) + (" …" if len(texts) > TOLD else "")
        parts.append(f"{called} = {shown}")
    return "; ".join(parts) if any("," in part for part in parts) else ", ".join(parts)
