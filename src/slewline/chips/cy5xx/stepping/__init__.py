"""Stepping: the plan player, ramps with slopes or rate units, the outputs, and the twin."""
