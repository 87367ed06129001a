"""Wires: nets, their drivers, the waveforms that drivers promise, pins, characters, and waits for all of these."""
