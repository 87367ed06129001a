"""Checks of a STEP and DIR recording, of one axis or several.

    STEP  ____|‾‾‾‾|______|‾‾‾‾|____       high, low: the least times of the driver
    DIR   _|‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾|__     set-up before a step, hold after it
           |<->|               |<->|

The limits are data sheet times, one row each, in the form that `bench.check_timing` uses for the model.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING

from ...chips import sheet_of
from ...core.datasheet.table import Limit
from ...core.messages.calls import answering
from ...core.time.timebase import Time, hertz, picoseconds, readable
from ...errors import UsageError
from ...record.measuring.intervals import Bound, Checked, SignalEdges, TimingTable, intervals
from ...record.measuring.measure import jitter, pulses, skew
from ...record.recording.recorder import real_edges
from ...record.waveforms.read_waveforms import read_waveforms
from ...record.waveforms.waveforms import EDGES, Waveforms
from ..step_drivers import OWN, StepDriver, own_driver, step_driver
from .capture_report import AxisCapture, CaptureReport

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

RUNT = 0.5  # of the median pulse or gap of STEP, whichever is shorter: shorter ones are glitches
COARSE = 4  # samples that a pulse should have


def limits_of(driver: StepDriver, edge: str) -> list[Limit]:
    """Return the requirements of a driver's inputs, as data sheet rows.

    Args:
        edge: the STEP edge with which a step begins, at the point where the signal was recorded: "rising",
            "falling" or "both".
    """
    high, low = ("rises", "falls") if edge != "falling" else ("falls", "rises")
    active, idle = ("active", "inactive") if edge != "both" else ("high", "low")
    step = "changes" if edge == "both" else high
    rows = (
        (f"step {high}", f"step {low}", f"STEP {active}", driver.high_ps),
        (f"step {low}", f"step {high}", f"STEP {idle}", driver.low_ps),
        ("direction changes", f"step {step}", "DIR before STEP", driver.setup_ps),
        (f"step {step}", "direction changes", "DIR after STEP", driver.hold_ps),
    )
    return [
        Limit(start, end, description, driver.source, least=least, keeper="host")
        for start, end, description, least in rows
        if least
    ]


@answering("check_capture()")
def check_capture(
    capture: Waveforms | str | Path,
    axes: Mapping[str, tuple[str, str | None]],
    *,
    driver: str | StepDriver | None = None,
    edge: str = "rising",
    forward: int = 1,
    idle: int | None = None,
    glitch: Time | None = None,
    part: str | None = None,
    pins: Mapping[str, str] | None = None,
    crystal: str | int | None = None,
) -> CaptureReport:
    """Check a recording against the data sheets of a driver and of a part; `print` shows the result.

    A time that misses its limit by no more than the sampling period is not reported as a violation.

    Args:
        capture: the result of `read_waveforms`, or the name of a file.
        axes: the STEP and DIR signals of each axis, keyed by a name of your choice: {"x": ("D0", "D1")}; DIR
            may be None.
        driver: the driver that receives the signals, such as "DM542", or the times of its data sheet, such
            as "high 30 us, low 30 us, setup 5 us, hold 5 us"; None: only steps, glitches, jitter and skew
            are checked.
        edge: the STEP edge with which a step begins, at the point where the signal was recorded: "rising",
            "falling" or "both".
        forward: the level of DIR at which positions count up, 0 or 1.
        idle: the level assumed for STEP where it floats or is unknown, as for `Waveforms.steps`.
        glitch: the length below which a pulse or gap of STEP or DIR is a glitch.  The default for DIR is the
            median pulse or the median gap of STEP, whichever is shorter; the default for STEP is half of
            that.  With edge "both", each pulse or gap lasts a whole step, so by default none is a glitch.
        part: the part whose pins were recorded, such as "cy525": the limits of its data sheet are checked,
            too.
        pins: the signals of the recorded pins, keyed by pin name: {"pulse": "D0", "direction": "D1"}.
        crystal: the clock of the part, such as "11 MHz"; by default the clock given in its data sheet.

    Raises:
        UsageError: no axis, a signal that is not a wire, STEP or DIR unknown at a step, `pins` without
            `part`.
        UnknownName: there is no such signal, driver or part.
        WaveformError: the file cannot be read.
    """
    waves = capture if isinstance(capture, Waveforms) else read_waveforms(capture)
    if not isinstance(axes, Mapping) or not axes:
        raise UsageError(f"axes={axes!r}: expected the signals STEP and DIR per axis, such as {{'x': ('D0', 'D1')}}")
    if edge not in EDGES:
        raise UsageError(f"edge={edge!r}: allowed {', '.join(EDGES)}")
    if (part is None) != (pins is None):
        raise UsageError("part and pins: give both, such as part='PART', pins={'PIN': 'D0'}")
    found = tuple(_axis(waves, name, signals, edge, forward, idle, glitch) for name, signals in axes.items())
    rows: list[Checked] = []
    notes = [
        f"{axis.name}: no step on {axes[axis.name][0]}; check whether STEP and DIR are exchanged"
        for axis in found
        if not len(axis.steps.times_ps)
    ]
    doubt = waves.sampling_ps
    if driver is not None:
        sheet = _driver(driver) if isinstance(driver, str) else driver
        rows += _of_driver(sheet, edge, found, doubt)
        notes += _too_coarse(sheet, doubt)
    if part is not None and pins is not None:
        rows += _of_part(waves, part, pins, crystal, doubt)
    skews = {(a.name, b.name): skew(a.steps.times_ps, b.steps.times_ps) for a, b in combinations(found, 2)}
    return CaptureReport(found, TimingTable(rows), skews, doubt, tuple(notes))


def _of_driver(sheet: StepDriver, edge: str, axes: Iterable[AxisCapture], doubt: int) -> Iterator[Checked]:
    """Yield the data sheet limits of a driver, each checked against the recording of each axis."""
    for axis in axes:
        for limit in limits_of(sheet, edge):
            if "direction" in axis.signals or "direction" not in limit.edges:
                yield _checked(axis.name, limit, axis.signals, 1, doubt)


def _too_coarse(sheet: StepDriver, doubt: int) -> Iterator[str]:
    """Yield advice if the sampling period `doubt` (ps) is too long for the pulses of a driver."""
    shortest = min(filter(None, (sheet.high_ps, sheet.low_ps)), default=0)
    if shortest and doubt * COARSE > shortest:
        yield (
            f"Sampled every {readable(doubt)}: too coarse for {sheet.name}, whose pulses may be "
            f"{readable(shortest)} short; record at {COARSE * 10**6 / shortest:g} MHz or more."
        )


def _driver(text: str) -> StepDriver:
    """Return the driver that a text describes, by its name or by its data sheet times."""
    return own_driver(text) if " " in text.strip() else step_driver(text, f"give its times, such as {OWN!r}")


def _axis(
    waves: Waveforms,
    name: str,
    signals: tuple[str, str | None],
    edge: str,
    forward: int,
    idle: int | None,
    glitch: Time | None,
) -> AxisCapture:
    if isinstance(signals, str) or len(signals) != 2:
        raise UsageError(f"axes: {name!r}: found {signals!r}; expected STEP and DIR, such as ('D0', 'D1')")
    step, direction = signals
    steps = waves.steps(step, direction, edge, forward=forward, idle=idle)
    own = {"step": _signal(waves, step, idle)}
    if direction is not None:
        own["direction"] = _signal(waves, direction, None)
    widths = [_median(lasts) for lasts in _widths(own["step"]) if edge != "both"]
    typical = min((width for width in widths if width), default=0)
    shortest = picoseconds(glitch) if glitch is not None else int(typical * RUNT)
    glitches = {*_short(own["step"], shortest)}
    if direction is not None:  # DIR has no reason to change twice within a pulse
        glitches |= {*_short(own["direction"], picoseconds(glitch) if glitch is not None else int(typical))}
    return AxisCapture(name, steps, own, tuple(sorted(glitches)), shortest, jitter(steps.times_ps, waves.sampling_ps))


def _widths(signal: SignalEdges) -> Iterator[NDArray[np.int64]]:
    for level in (0, 1):
        begins, ends = pulses(signal.times_ps, signal.levels, level)
        yield ends - begins


def _median(lasts: NDArray[np.int64]) -> float:
    import numpy as np

    return float(np.median(lasts)) if len(lasts) else 0.0


def _short(signal: SignalEdges, shorter: int) -> Iterator[int]:
    """Yield the starts (ps) of the pulses and gaps of a signal that are shorter than `shorter` (ps)."""
    for level in (0, 1):
        begins, ends = pulses(signal.times_ps, signal.levels, level)
        yield from begins[ends - begins < shorter].tolist()


def _signal(waves: Waveforms, name: str, idle: int | None) -> SignalEdges:
    """Return the edges of a wire; unknown levels become `idle` or, if that is None, the previous level."""
    import numpy as np

    times, levels = waves.edges(name)
    level = int(waves.level_at(name, waves.start_ps))
    if idle is not None:
        levels, level = np.where(levels < 0, idle, levels), idle if level < 0 else level
    known = levels >= 0
    times, levels = times[known], levels[known]
    if level < 0:
        level = int(levels[0]) if len(levels) else 0
    return SignalEdges(*real_edges(times, levels, level), level, False)


def _checked(name: str, limit: Limit, signals: Mapping[str, SignalEdges], crystal_hz: int, doubt: int) -> Checked:
    return Checked.of(name, Bound.of(limit, crystal_hz), *intervals(limit, lambda pin: signals[pin]), doubt)


def _of_part(
    waves: Waveforms, part: str, pins: Mapping[str, str], crystal: str | int | None, doubt: int
) -> Iterator[Checked]:
    """Yield the limits of a part that involve a recorded pin, each checked against the recording.

    A limit that also needs a pin that was not recorded is not checked, but yielded with that pin's name.
    """
    sheet = sheet_of(part)
    known = {pin.name for pin in sheet.pins}
    for pin in pins:
        if pin not in known:
            raise UsageError(f"pins: {part} has no pin {pin!r}; allowed {', '.join(sorted(known))}")
    signals = {pin: _signal(waves, name, None) for pin, name in pins.items()}
    clock = hertz(crystal) if crystal is not None else sheet.crystal_hz
    for limit in sheet.limits:
        needed = (limit.start.split()[0], limit.end.split()[0], *(pin for pin, _ in (*limit.given, *limit.before)))
        missing = next((pin for pin in needed if pin not in signals), None)
        if missing is None:
            yield _checked(sheet.part, limit, signals, clock, doubt)
        elif any(pin in signals for pin in needed[:2]):
            yield Checked(sheet.part, Bound.of(limit, clock), missing=missing)
