"""Host computers, one for each way to reach a chip.

`flow_host.py` is the model for a host of one chip, `bus_host.py` for one of several chips on a bus.  The end that a
host has on a channel is in `ends`.
"""
