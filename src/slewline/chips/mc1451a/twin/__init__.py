"""The slow twin of the MC1451A: the same, cycle by cycle."""
