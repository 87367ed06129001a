"""Gates, delay lines and latches: what goes between a chip and its neighbours.

A gate with inputs in1, in2 ... and an output is a row of `FUNCTIONS` in `gates.py`, a row of `KINDS` in the room
above, and a law in `LAWS` of tests/laws/edge_driven.py.  One with other pins is a `Stateless` with `gated`.
"""
