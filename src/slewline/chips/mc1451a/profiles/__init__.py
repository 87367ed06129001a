"""The laws of motion in cycles, their ideals, and the record of an axis's cycles."""
