"""The notes on a picture: the parameters of the motions, and their greatest deviations from the ideal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from ...core.chip import Chip

if TYPE_CHECKING:
    from ...record.pictures.tracks import Track

MAX_VALUES = 3  # of a parameter that differs between motions


def words_of(chip: Chip) -> dict[str, str]:
    """Return the command names of a chip, keyed by command letter: {"R": "rate"}."""
    return {row.form: row.name.lower().replace("_", " ") for row in chip.sheet.commands}


def differences(tracks: Sequence[Track]) -> Iterator[str]:
    """Yield a text for each track with ideal curves: the greatest deviation of its motions from these curves."""
    from ...record.style import few

    for track in tracks:
        if track.ideals:
            position = few(max(abs(deviation.position) for _, deviation in track.ideals))
            velocity = max(abs(deviation.velocity) for _, deviation in track.ideals)
            whose = f"{track.name}: d" if len(tracks) > 1 else "D"
            steps = f"{position} step{'s' * (position != '1')}"
            yield f"{whose}otted: the ideal; position within {steps}, velocity within {few(velocity)} steps/s"


def parameters_of(track: Track, words: Mapping[str, str]) -> str:
    """Return the motion parameters of a track as text: "slope S = 240, number N = 300, 500"."""
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
        shown = ", ".join(texts[:MAX_VALUES]) + (" …" if len(texts) > MAX_VALUES else "")
        parts.append(f"{called} = {shown}")
    return "; ".join(parts) if any("," in part for part in parts) else ", ".join(parts)
