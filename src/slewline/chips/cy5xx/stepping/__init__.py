"""Stepping: the plan player, ramps whose rate grows by step or by time, the outputs, and the slow twin."""
