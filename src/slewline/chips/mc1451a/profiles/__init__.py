"""The laws of motion in cycles; the ideal motions that these laws approximate; an axis's recorded cycles."""
