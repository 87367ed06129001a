"""The family's times in crystal clocks, and a finding for a crystal frequency that the part does not allow."""

from __future__ import annotations

from collections.abc import Mapping

from ...core.context import ChipContext


def clocks(chip: ChipContext) -> dict[str, int]:
    """Return the sheet's times by name, in crystal clocks; the option `inferred` may replace some of them."""
    inferred: Mapping[str, int] = getattr(chip.options, "inferred", {})
    return {name: inferred.get(name, time.ticks) for name, time in chip.sheet.times.items()}


def check_crystal(chip: ChipContext, where: str) -> None:
    """Add a finding if the part does not allow the crystal frequency; `where` names the source of the limits."""
    low, high = chip.sheet.crystal_low_hz, chip.sheet.crystal_high_hz
    if not low <= chip.crystal_hz <= high:
        allowed = f"{low // 1_000_000} to {high // 1_000_000} MHz of {where}"
        text = f"{chip.crystal_hz / 1e6:g} MHz is outside the {allowed}; all times scale with the clock"
        chip.finding("crystal", text)
