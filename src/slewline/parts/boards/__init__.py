"""Boards between a computer and the bus of a chip: ISA, a parallel card, an 8080, IEEE-488."""
