"""Interface between virtual time and the real world: sockets, serial ports, the wall clock, memory files.

No lower-level package uses sockets, threads or the wall clock.  Each kind of channel is served by a row
of `LINES` in `serving.py`; the server is in `server.py`.
"""
