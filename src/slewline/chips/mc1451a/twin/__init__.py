"""The slow twin of the MC1451A: the same motion, cycle by cycle."""
