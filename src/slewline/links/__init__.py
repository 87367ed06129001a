"""Where virtual time meets the world: sockets, serial ports, the wall clock, files that keep memories.

No room below knows sockets, threads or the wall clock.  How each kind of channel is served is a row of `LINES` in
`serving.py`; `server.py` is the whole.
"""
