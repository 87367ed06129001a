"""Tuning: the fastest ramp of a chip that a motor follows, found by simulating the candidates from the fastest on.

A possible deviation from the data sheets of motor, driver and load is a function of `CHANGES` in `perturbations.py`,
and a row of `USUAL` if it is tried by default.  The range of a search, and the spacing of its values, are in `ramps.py`
of each chip.
"""
