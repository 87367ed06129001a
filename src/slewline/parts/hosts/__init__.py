"""Host computers, one for each kind of connection to a chip.

`flow_host.py` is the example of a host for one chip, `bus_host.py` for several chips on a bus.  The end of a host on a
channel is in `ends`.
"""
