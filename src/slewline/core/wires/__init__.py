"""Wires: nets, their drivers, the waveforms that drivers promise, pins, characters, and waits for any of these.

A promise that follows from other promises, such as the promise of a gate, is a view (`views.py`).
`clocking.py` numbers the edges of a clock.
"""
