"""What a notebook shows of a bench: its plot, if something has happened."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...errors import SlewlineError
from .options import PICTURE

if TYPE_CHECKING:
    from .drawing import Pictures

MOST_PINS = 12  # of more recorded pins a notebook shows none: whoever wants them calls bench.plot


def plot_of(pictures: Pictures) -> str | None:
    """Return the plot of a bench as SVG; None where nothing has moved, or matplotlib is missing."""
    from ...record.pictures.figures import description_of, figure
    from ...record.pictures.pictures import drawn

    recorded, motors = len(pictures.signals.recorded), [axis.motor for _, _, axis in pictures.circuit.axes()]
    if not recorded and not any(any(motor.played(motor.since, pictures.kernel.now)) for motor in motors):
        return None
    try:
        contents = pictures.contents(PICTURE | {"pins": None if recorded <= MOST_PINS else []})
        picture = figure(contents)
    except SlewlineError:
        return None
    return drawn(picture, "svg", contents.title, description_of(picture)).decode("utf-8")
