"""Times and frequencies of the passive circuits around a chip (s.9)."""

from __future__ import annotations

from math import log, pi, sqrt

from slewline.core.time.timebase import PS_PER_S

PULL_UP_OHM = 50e3
RESET_FARAD = 1e-6


def reset_time(r: float = PULL_UP_OHM, c: float = RESET_FARAD, *, supply: float = 5.0, threshold: float = 3.8) -> int:
    """Return how long the capacitor at RESET keeps the pin low after power-up, in picoseconds (fig. 9.1).

    Args:
        r, c: ohms and farads; the built-in pull-up and 1 uF by default.
        supply, threshold: volts; the pin reads high from `threshold` on.
    """
    return round(r * c * log(supply / (supply - threshold)) * PS_PER_S)


def lc_frequency(l: float, c: float, cpp: float) -> float:  # noqa: E741  (the letter of the circuit)
    """Return the frequency of the LC clock in hertz (fig. 9.2).

    Args:
        l: coil, henry.
        c: each of the two capacitors, farads.
        cpp: capacitance from pin to pin, farads.
    """
    return 1 / (2 * pi * sqrt(l * (c + 3 * cpp) / 2))
