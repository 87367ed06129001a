"""Interface between virtual time and the real world: sockets, serial ports, the wall clock, memory files.

No package on a lower level uses sockets, threads or the wall clock.  For each kind of channel, `LINES`
in `serving.py` has a row that serves it; the server is in `server.py`.
"""
