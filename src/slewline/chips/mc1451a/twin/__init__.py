"""The slow twin of the MC1451A: a reference model that makes the same motion, cycle by cycle."""
