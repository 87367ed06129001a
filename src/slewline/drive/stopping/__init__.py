"""Reactions to a board that stops its motor by itself: the chip is stopped at the position of the motor."""
