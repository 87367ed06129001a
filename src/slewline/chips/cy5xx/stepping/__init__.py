"""Stepping: the player of plans, ramps by slope or by unit of time, outputs, twin."""
