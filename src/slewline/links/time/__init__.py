"""Control of time: breakpoints, steps, and the return to past instants.

`server_past.py` recreates the past of a server in one of two ways.  Within this process, it uses
bench/past.py; meanwhile `bench_exchange.py` keeps hosts and clients connected, and links/lines/outlet.py
holds back output.  In a separate process, it uses `checkpoints.py` and `worlds.py`; that process is
shown as one of the branches (`branches.py`).
"""
