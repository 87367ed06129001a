"""A chip with a motor, for tests of what both show of a motion."""

from __future__ import annotations

from typing import Any

import slewline
from slewline.build import Part


def with_motor(kind: str, program: str, **options: Any) -> tuple[slewline.Bench, slewline.Chip, Part]:
    """Return a bench with these options, its CY525 "x", and its motor of a kind, at rest after a program."""
    bench = slewline.Bench(**options)
    x = bench.add("cy525", name="x")
    motor = bench.part(kind, "motor", to=x)
    bench.host(x).send(program)
    bench.run_until_idle()
    return bench, x, motor
