"""Tuning: of the ramps that a chip can make, the fastest one that a motor follows, simulated from the fastest on."""
