"""All checks: a new module of them is named here.

42 and 44 to 48 are not of the equations but of parts and of the tuner.
"""

from __future__ import annotations

from . import accuracy, bench, currents, damping, friction, oscillations, others, pullout, tuner
from .table import CHECKS

MODULES = (accuracy, bench, currents, damping, friction, oscillations, others, pullout, tuner)
ROWS = sorted(CHECKS, key=lambda one: (one.number, one.what))
