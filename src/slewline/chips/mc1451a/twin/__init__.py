"""The slow twin of the MC1451A: a reference model with the same motion as the fast one, cycle by cycle."""
