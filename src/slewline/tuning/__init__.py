"""Tuning: the fastest of a chip's ramps that a motor can follow.

It is found by simulating the candidates, fastest first.

Each possible deviation from the data sheets of motor, driver and load has a function in `CHANGES` of
`perturbations.py` and, if it is tried by default, a row in `USUAL`.  The range of a search, and the
spacing of its values, are in each chip's `ramps.py`.
"""
