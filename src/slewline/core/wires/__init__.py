"""Wires: nets, their drivers, the waveforms that drivers promise, pins, characters, and waits for all of these.

A promise that follows from other promises, as that of a gate, is a view (`views.py`).  `clocking.py` numbers the edges
of a clock.
"""
