"""All checks: a new module of them is named here, in EQUATIONS or in AT_WORK.

42 and 44 to 48 are not of the equations but of parts and of the tuner.
"""

from __future__ import annotations

from . import accuracy, bench, currents, damping, exact, friction, oscillations, others, pullout, tuner
from .table import CHECKS

EQUATIONS = (accuracy, currents, damping, friction, oscillations, others, pullout)
AT_WORK = (bench, exact, tuner)
ROWS = sorted(CHECKS, key=lambda one: (one.number, one.what))
