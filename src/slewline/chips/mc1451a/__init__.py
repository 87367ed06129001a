"""The MC1451A family: the chipset, its axes and their common parts."""
