"""The laws of motion in cycles, their ideals, and what an axis did by them."""
