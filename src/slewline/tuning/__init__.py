"""Tuning: of the ramps that a chip can make, the fastest one that a motor follows, simulated from the fastest on.

What may differ from the data sheets of motor, driver and load is a function of `CHANGES` in `perturbations.py`, and a
row of `USUAL` if it is tried by default.  Where a search looks, and how it spaces values, is in `ramps.py` of each
chip.
"""
