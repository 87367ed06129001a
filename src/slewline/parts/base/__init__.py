"""The foundation of parts: pins, request queues, and output promises that follow from the promises of the inputs.

A part whose outputs follow from its inputs has a rule: a `Follower`, or a `Stateless` if it has no memory
(`follower.py`), or a `Clocked` if it counts the edges of a clock (`clocked.py`; `counted.py` computes levels from the
number of edges).  Findings that a part makes only on demand are made by its `catch_up()`.
"""
