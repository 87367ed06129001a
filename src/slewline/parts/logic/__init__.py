"""Gates, delay lines and latches, for the wiring between a chip and its neighbours.

A gate with inputs in1, in2 ... and an output is a row of `FUNCTIONS` in `gates.py`, a row of `KINDS` in the package
above, and a law in `LAWS` of tests/laws/edge_driven.py.  A gate with other pins is a `Stateless` with `gated`.
"""
