"""Host computers, one class for each kind of connection to a chip.

`flow_host.py` is an example of a host for one chip, and `bus_host.py` is an example of a host for
several chips on a bus.  `ends` contains the hosts' ends of the connections.
"""
