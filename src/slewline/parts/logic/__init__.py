"""Gates, delay lines and latches, for the wiring between a chip and its neighbours.

To add a gate with inputs in1, in2 ... and an output, add a row to `FUNCTIONS` in `gates.py`, a row to
`KINDS` in the parent package, and the truth function of the gate to `LAWS` in tests/laws/edge_driven.py.
A gate with other pins needs its own class.  Like `Gate`, this class has a `Stateless` rule that uses
`gated`.
"""
