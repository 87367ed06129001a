"""What chips and drivers reckon for a motor: the encoder's ratio, the resistor of the phase current."""

from __future__ import annotations

from collections.abc import Iterator

from slewline.chips.mc1451a import sheet
from slewline.errors import UsageError
from slewline.language.rates import step_ratio
from slewline.parts.drivers.gsd200 import set_point, to_ground

from .table import Reading, check, same, within


@check(21, "encoder, 12,800 pulses a turn")
def encoder_ratio() -> Iterator[Reading]:
    yield same("4000 counts, ratio", step_ratio(sheet.STEP_RATIO, 4000, 12_800), 4000 / 12_800 * 256)
    try:
        step_ratio(sheet.STEP_RATIO, 4096, 12_800)
    except UsageError as error:
        refused = "81.92" in str(error)
    else:
        refused = False
    yield same("4096 counts, refused", float(refused), 1)


@check(26, "GS-D200, resistor for a current")
def programmed_current() -> Iterator[Reading]:
    for amperes, ohms in ((0.5, 937.0), (0.25, 326.0)):
        yield within(f"{amperes} A, ohm", to_ground(amperes), ohms, 1.0)
        yield within(
            f"{amperes} A, by I / (1 - 0.933 I), ohm", to_ground(amperes), amperes / (1 - 0.933 * amperes) * 1e3, 1.0
        )
        yield within(f"{ohms:.0f} ohm, A", set_point(ohms), amperes, 1e-3)
