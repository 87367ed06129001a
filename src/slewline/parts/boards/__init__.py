"""Boards between a computer and the bus of a chip: ISA, a parallel card, the ports of an 8080, IEEE-488."""
