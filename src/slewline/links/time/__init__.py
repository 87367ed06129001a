"""Time as a control: breakpoints, steps, and the way back to instants that were.

Going back in one process is in bench/rewinding.py; `exchange.py` puts the other bench in the place of the one that is
served, with the hosts and clients that are connected, and links/lines/outlet.py holds what goes out meanwhile.
"""
