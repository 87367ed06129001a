"""Stepping: motions, jog, HOME, and the outputs to the motor."""
