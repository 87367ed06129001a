"""Wires: nets, their drivers, the waveforms that drivers promise, pins, characters, and waits for all of these.

A promise that follows from other promises, as that of a gate, is a view (`views.py`).  The edges of a clock are
numbered by `clocking.py`.
"""
