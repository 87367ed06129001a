"""Time as a control: breakpoints, steps, and the way back to instants that were.

`server_past.py` is the past of a server, and chooses the way back: bench/past.py in this process, where
`bench_exchange.py` lets the hosts and clients go on that are connected, and links/lines/outlet.py holds what goes out
meanwhile; or `checkpoints.py` and `worlds.py` in a process of its own, which is shown as one of the `branches.py`.
"""
