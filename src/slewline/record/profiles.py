"""What an axis did in every cycle of its controller: velocity, position, acceleration and jerk, phases marked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

VELOCITY, POSITION, ACCELERATION, JERK = "#1f66ad", "#b8561b", "#2b5d4c", "#6a4c93"
BAND, BORDER, NUMBER = "#eef1f4", "#c6ced6", "#5f6b77"
HEIGHTS = (2.2, 1.5, 1.2, 1.2)  # of the panels, inches


@dataclass(frozen=True, slots=True)
class Profile:
    """Cycles of one axis: instants of their begins (ps), and in each of them velocity (steps/s), position (steps),
    acceleration (steps/s^2) and jerk (steps/s^3); all (n,).

    `spans` are stretches with a label, such as the phases of an S-curve: begin and end in ps, and the text.
    """

    name: str
    times_ps: NDArray[Any]
    velocities: NDArray[Any]
    positions: NDArray[Any]
    accelerations: NDArray[Any]
    jerks: NDArray[Any]
    spans: Sequence[tuple[int, int, str]] = ()
    rates: Mapping[str, float] = field(default_factory=dict)
    notes: Mapping[str, object] = field(default_factory=dict)

    @property
    def curves(self) -> tuple[tuple[NDArray[Any], str, str, bool], ...]:
        """What the panels show: values, label, colour, and whether they hold for a whole cycle."""
        return (
            (self.velocities, "Velocity in steps/s", VELOCITY, True),
            (self.positions, "Position in steps", POSITION, False),
            (self.accelerations, "Acc. in steps/s²", ACCELERATION, True),
            (self.jerks, "Jerk in steps/s³", JERK, True),
        )


def draw_profile(panels: Sequence[Axes], profile: Profile, scaled: Any, several: bool) -> None:
    """Draw a profile into its four panels; `scaled` turns instants into the units of the time axis."""
    from matplotlib.ticker import MaxNLocator

    times = scaled(profile.times_ps)
    for panel, (values, label, color, held) in zip(panels, profile.curves, strict=True):
        style = "steps-post" if held else "default"
        panel.plot(times, values, color=color, linewidth=1.4, drawstyle=style, solid_joinstyle="miter")
        if held:
            panel.axhline(0, color=BORDER, linewidth=0.8, zorder=1)
        panel.set_ylabel((f"{profile.name}: " if several and panel is panels[0] else "") + label)
        panel.margins(y=0.12)
        panel.yaxis.set_major_locator(MaxNLocator(4))
        panel.ticklabel_format(axis="y", style="sci", scilimits=(-4, 5), useMathText=True)
    for number, (begin, end, text) in enumerate(profile.spans):
        start, stop = scaled([begin, end])
        for panel in panels:
            if number % 2 == 0:
                panel.axvspan(start, stop, facecolor=BAND, linewidth=0, zorder=0)
            panel.axvline(start, color=BORDER, linewidth=0.7, zorder=1)
        at = ("data", "axes fraction")
        panels[0].annotate(
            text, ((start + stop) / 2, 1), (0, 3), at, "offset points", ha="center", fontsize=8, color=NUMBER
        )
