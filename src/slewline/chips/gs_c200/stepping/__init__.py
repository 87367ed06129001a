"""Stepping: the player of plans, the position counter, the lines to the driver."""
