"""Control of time: breakpoints, steps, and the return to past instants.

`server_past.py` is the past of a server, and chooses the method: bench/past.py in this process, where
`bench_exchange.py` keeps hosts and clients connected and links/lines/outlet.py holds back output meanwhile; or
`checkpoints.py` and `worlds.py` in a separate process, which is shown as one of the branches (`branches.py`).
"""
