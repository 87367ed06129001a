"""Tuning: the fastest of a chip's ramps that a motor can follow.

It is found by simulating the candidates, fastest first.

A possible deviation from the data sheets of motor, driver and load is a function in `CHANGES` of
`perturbations.py`, and a row of `USUAL` if it is tried by default.  The range of a search, and the
spacing of its values, are in each chip's `ramps.py`.
"""
