"""The foundation of parts: pins, queues of requests, and promises that follow from those of their inputs.

A part whose outputs follow from its inputs has a rule: a `Follower`, or a `Stateless` if it has no memory
(`follower.py`), or a `Clocked` if it counts the edges of a clock (`clocked.py`; levels by their number are in
`counted.py`).  Findings that a part makes only on demand are made by its `catch_up()`.
"""
