"""The laws of motion in cycles, the ideal motions that these approximate, the record of an axis's cycles."""
