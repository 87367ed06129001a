"""Memories on the bus of a chip, and a PROM that takes the place of a host."""
