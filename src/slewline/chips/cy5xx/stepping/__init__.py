"""Stepping: the plan player, ramps that grow with each step or with time, the outputs, and the slow twin."""
