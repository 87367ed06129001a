"""Reactions when a board stops its motor by itself: the chip is stopped at the position of the motor."""
