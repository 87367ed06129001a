"""Stepping: motions, jogging, HOME, and the outputs to the motor."""
