"""Stepping: the plan player, ramps whose rate grows with each step or with time, the outputs, and the slow twin."""
