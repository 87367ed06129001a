"""The foundation of parts: pins, request queues, and output promises that follow from the promises of the inputs.

A part whose outputs follow from its inputs has a rule: a `Follower`, or a `Stateless` if the part has no memory
(`follower.py`), or a `Clocked` if the part counts the edges of a clock (`clocked.py`; `counted.py` computes levels
from the number of edges).  If a part makes findings only on demand, its `catch_up()` makes them.
"""
