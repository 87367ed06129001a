"""Sockets and descriptors: the loop that waits for them, streams, strangers, and what systems lack.

What differs between systems is in `system.py`, and nowhere else.
"""
